"""Between the matcher's words and the store of results, and from the stores to the bytes of a block."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.host.blocks import SENT_PLANES
from golden.host.loop_registers import LOOP_PLANES, PICTURE_PLANES, result_bytes

from ..host.blocks import LineByte, LineRequest
from ..matcher.settings import minimum_shape
from ..matcher.stream import DisparityWord
from .pair_read import PlaceCounter
from .store import row_start
from .words import PlacedResult, ReadPort, shown_label


__all__ = ["LineSource", "ResultWriter"]


class ResultWriter(wiring.Component):
    """Writes a picture of results. Golden: :func:`golden.host.loop_device.packed_result`.

    Timing: accepts a word a cycle, while the store does; it is offered in the next one. ``done`` is high in the cycle in which the store
    accepts the last word.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Of the store, lines.

    Members
    -------
    start : In(1)
        The next word is the first of its picture.
    minimum : In(minimum_shape(config))
        Least disparity; must hold from ``start`` to ``done``.
    width, lines : In
        As of :class:`hdl.loop.pair_read.PlaceCounter`.
    i : In(stream.Signature(DisparityWord(config)))
    o : Out(stream.Signature(PlacedResult(config, max_width * height)))
        To the store.
    done : Out(1)
    """
    def __init__(self, config: MatcherConfig, height: int):
        self.config = config
        self.places = PlaceCounter(config.max_width, height)
        members = self.places.signature.members
        super().__init__({
            "start": In(1), "minimum": In(minimum_shape(config)), "width": members["width"], "lines": members["lines"],
            "i": In(stream.Signature(DisparityWord(config))),
            "o": Out(stream.Signature(PlacedResult(config, config.max_width * height))), "done": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.places = places = self.places
        word, fraction_bits = self.i.p, self.config.method.disparity_scale.bit_length() - 1
        last  = Signal()
        moves = self.i.valid & self.i.ready
        m.d.comb += [
            places.start.eq(self.start), places.width.eq(self.width), places.lines.eq(self.lines), places.step.eq(moves),
            self.i.ready.eq(self.o.ready | ~self.o.valid), self.done.eq(self.o.valid & self.o.ready & last),
        ]
        stored = self.o.p
        with m.If(self.i.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid), last.eq(word.end), stored.address.eq(places.place.address)]
            for name in stored.result.shape().members:
                value = word[name] - self.minimum.shift_left(fraction_bits) if name == "disparity" else word[name]
                m.d.sync += stored.result[name].eq(value)
        return m


class LineSource(wiring.Component):
    """Bytes of a line out of the stores, for a block read. Golden: the blocks of :class:`golden.host.loop_device.LoopDevice`.

    Timing: a pixel's first byte is offered a cycle after its word was found; the next word is requested in the cycle after the last byte
    was accepted. From memory blocks there are 5 cycles from the request, and between pixels.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Of the stores, lines.

    Members
    -------
    width : In(range(max_width + 1))
        Pixels of a line, at least 1; must hold while a line is sent.
    i : In(stream.Signature(LineRequest()))
    read : Out(ReadPort(config, max_width * height))
    o : Out(stream.Signature(LineByte()))
    """
    def __init__(self, config: MatcherConfig, height: int):
        self.config, self.height = config, height
        super().__init__({
            "width": In(range(config.max_width + 1)),
            "i": In(stream.Signature(LineRequest())),
            "read": Out(ReadPort(config, config.max_width * height)),
            "o": Out(stream.Signature(LineByte())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        most  = result_bytes(self.config)
        plane = Signal.like(self.i.p.plane, reset_less=True)
        left  = Signal(range(self.config.max_width + 1), reset_less=True)   # pixels not sent
        word  = Signal(8 * most, reset_less=True)
        bytes_left = Signal(range(max(2, most)), reset_less=True)           # of the pixel, after the one offered
        request, found = self.read.request, self.read.found
        address = Signal.like(request.p.address, reset_less=True)
        m.d.comb += [
            self.o.p.value.eq(word[:8]), self.o.p.last.eq((left == 1) & (bytes_left == 0)),
            request.p.address.eq(address), request.p.results.eq(plane >= len(SENT_PLANES)),
        ]
        values = [found.left, found.right, shown_label(found.result, self.config), found.result.as_value()]
        assert len(values) == len(LOOP_PLANES) > len(PICTURE_PLANES) > len(SENT_PLANES)
        with m.FSM():
            with m.State("idle"):
                m.d.comb += self.i.ready.eq(1)
                line = self.i.p.line[:max(1, (self.height - 1).bit_length())]
                m.d.sync += [plane.eq(self.i.p.plane), left.eq(self.width), address.eq(row_start(line, self.config.max_width))]
                with m.If(self.i.valid):
                    m.next = "request"

            with m.State("request"):
                m.d.comb += request.valid.eq(1)
                with m.If(request.ready):
                    m.next = "read"

            with m.State("read"):
                m.d.sync += bytes_left.eq(0)
                with m.Switch(plane):
                    for number, value in enumerate(values):
                        with m.Case(number):
                            m.d.sync += word.eq(value)
                            if number >= len(PICTURE_PLANES):
                                m.d.sync += bytes_left.eq(most - 1)
                with m.If(self.read.valid):
                    m.next = "send"

            with m.State("send"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(self.o.ready):
                    m.d.sync += [word.eq(word >> 8), bytes_left.eq(bytes_left - 1)]
                    with m.If(bytes_left == 0):
                        m.d.sync += [left.eq(left - 1), address.eq(address + 1)]
                        m.next = "request"
                        with m.If(left == 1):
                            m.next = "idle"
        return m

"""Between the matcher's words and the store of results, and from the stores to the bytes of a block."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.host.loop_registers import LOOP_PLANES, PICTURE_PLANES, SENT_PLANES, result_bits, result_bytes

from ..host.blocks import LineByte, LineRequest
from ..matcher.settings import minimum_shape
from ..matcher.stream import DisparityWord
from .pair_read import PlaceCounter
from .store import FrameStore, row_start


__all__ = ["LineSource", "ResultWriter", "StoredResult", "shown_label"]


class StoredResult(data.StructLayout):
    """A result as it is stored: the fields of :func:`golden.host.loop_registers.result_bits`."""
    def __init__(self, config: MatcherConfig):
        super().__init__({**result_bits(config)})


def shown_label(word: data.View, config: MatcherConfig) -> Value:
    """The whole label of a stored result."""
    return word.disparity[config.method.disparity_scale.bit_length() - 1:]  # the scale is a power of two


class ResultWriter(wiring.Component):
    """Writes a picture of results. Golden: :func:`golden.host.loop_device.packed_result`.

    Timing: accepts a word a cycle; it is written in the next one. ``done`` is high in the cycle in which the last word is written.

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
    write : Out(1), address : Out(range(max_width * height)), data : Out(StoredResult(config))
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
            "write": Out(1), "address": Out(range(config.max_width * height)), "data": Out(StoredResult(config)), "done": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.places = places = self.places
        word, fraction_bits = self.i.p, self.config.method.disparity_scale.bit_length() - 1
        m.d.comb += [
            places.start.eq(self.start), places.width.eq(self.width), places.lines.eq(self.lines), places.step.eq(self.i.valid),
            self.i.ready.eq(1),
        ]
        m.d.sync += [self.write.eq(self.i.valid), self.done.eq(self.i.valid & word.end), self.address.eq(places.place.address)]
        for name in self.data.shape().members:
            value = word[name] - self.minimum.shift_left(fraction_bits) if name == "disparity" else word[name]
            m.d.sync += self.data[name].eq(value)
        return m


class LineSource(wiring.Component):
    """Bytes of a line out of the stores, for a block read. Golden: the blocks of :class:`golden.host.loop_device.LoopDevice`.

    Timing: the first byte is offered 5 cycles after the request was accepted, the next pixel's first one 5 cycles after the last of the
    one before.

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
    address : Out(range(max_width * height))
        To all stores.
    left, right : In(8), result : In(StoredResult(config))
        Words found, :attr:`hdl.loop.store.FrameStore.LATENCY` cycles later.
    o : Out(stream.Signature(LineByte()))
    """
    def __init__(self, config: MatcherConfig, height: int):
        self.config, self.height = config, height
        super().__init__({
            "width": In(range(config.max_width + 1)),
            "i": In(stream.Signature(LineRequest())),
            "address": Out(range(config.max_width * height)),
            "left": In(8), "right": In(8), "result": In(StoredResult(config)),
            "o": Out(stream.Signature(LineByte())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        most  = result_bytes(self.config)
        plane = Signal.like(self.i.p.plane, reset_less=True)
        left  = Signal(range(self.config.max_width + 1), reset_less=True)   # pixels not sent
        word  = Signal(8 * most, reset_less=True)
        bytes_left = Signal(range(max(2, most)), reset_less=True)           # of the pixel, after the one offered
        wait  = Signal(range(FrameStore.LATENCY + 1), reset_less=True)
        m.d.comb += [self.o.p.value.eq(word[:8]), self.o.p.last.eq((left == 1) & (bytes_left == 0))]
        found = [self.left, self.right, shown_label(self.result, self.config), self.result.as_value()]
        assert len(found) == len(LOOP_PLANES) > len(PICTURE_PLANES) > len(SENT_PLANES)
        with m.FSM():
            with m.State("idle"):
                m.d.comb += self.i.ready.eq(1)
                line = self.i.p.line[:max(1, (self.height - 1).bit_length())]
                m.d.sync += [plane.eq(self.i.p.plane), left.eq(self.width), wait.eq(FrameStore.LATENCY),
                             self.address.eq(row_start(line, self.config.max_width))]
                with m.If(self.i.valid):
                    m.next = "read"

            with m.State("read"):
                m.d.sync += [wait.eq(wait - 1), bytes_left.eq(0)]
                with m.Switch(plane):
                    for number, value in enumerate(found):
                        with m.Case(number):
                            m.d.sync += word.eq(value)
                            if number >= len(PICTURE_PLANES):
                                m.d.sync += bytes_left.eq(most - 1)
                with m.If(wait == 0):
                    m.next = "send"

            with m.State("send"):
                m.d.comb += self.o.valid.eq(1)
                m.d.sync += wait.eq(FrameStore.LATENCY)
                with m.If(self.o.ready):
                    m.d.sync += [word.eq(word >> 8), bytes_left.eq(bytes_left - 1)]
                    with m.If(bytes_left == 0):
                        m.d.sync += [left.eq(left - 1), self.address.eq(self.address + 1)]
                        m.next = "read"
                        with m.If(left == 1):
                            m.next = "idle"
        return m

"""Reader of a stored pair: a pixel of both pictures a clock, for the matcher."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ..matcher.stream import PixelPair
from ..parts.queue import Queue
from .words import ReadPort


__all__ = ["PairScan", "Place"]


class Place(data.StructLayout):
    """Where a pixel is: ``address`` in a store, and its flags as :data:`hdl.matcher.stream.FLAGS`."""
    def __init__(self, depth: int):
        super().__init__({"address": range(depth), "first": 1, "last": 1, "end": 1})


class PlaceCounter(wiring.Component):
    """Places of a picture in the upper left corner of a store, line by line from the top.

    Timing: ``place`` is that of pixel 0 in the cycle after ``start``, and of the next one in the cycle after ``step``; after the last one
    undefined.

    Parameters
    ----------
    max_width, height : int
        Of the store, pixels.

    Members
    -------
    start, step : In(1)
    width : In(range(max_width + 1)), lines : In(range(height + 1))
        Of the picture, at least 1; must hold while places are counted.
    place : Out(Place(max_width * height))
    """
    def __init__(self, max_width: int, height: int):
        self.max_width, self.height = max_width, height
        super().__init__({
            "start": In(1), "step": In(1), "width": In(range(max_width + 1)), "lines": In(range(height + 1)),
            "place": Out(Place(max_width * height)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        column  = Signal(range(self.max_width), reset_less=True)
        line    = Signal(range(self.height), reset_less=True)
        address = Signal(range(self.max_width * self.height), reset_less=True)
        row     = Signal.like(address, reset_less=True)     # of the line's first pixel
        last, lowest = Signal(), Signal()
        m.d.comb += [
            last.eq(column + 1 == self.width), lowest.eq(line + 1 == self.lines),
            self.place.address.eq(address), self.place.first.eq((column == 0) & (line == 0)),
            self.place.last.eq(last), self.place.end.eq(last & lowest),
        ]
        with m.If(self.start):
            m.d.sync += [column.eq(0), line.eq(0), address.eq(0), row.eq(0)]
        with m.Elif(self.step):
            m.d.sync += [column.eq(column + 1), address.eq(address + 1)]
            with m.If(last):
                m.d.sync += [column.eq(0), line.eq(line + 1), address.eq(row + self.max_width), row.eq(row + self.max_width)]
        return m


class PairScan(wiring.Component):
    """Reads both pictures once, in step. Golden: the pixels of both pictures, line by line from the top.

    Timing: a pixel a cycle while ``o`` accepts them and the stores answer; the first one 3 cycles after its word was found, 6 cycles after
    ``start`` from memory blocks. ``o.valid`` and the request do not depend on ``o.ready`` of the same cycle: as many pixels are read ahead
    as fit into a queue.

    Memory: ``ahead - 1`` pixels.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Of the stores, lines.
    ahead : int
        Pixels that are requested before ``o`` accepts them.

    Members
    -------
    start : In(1)
        Reads the pair from its first pixel on; must not be high again before the last one was accepted.
    width, lines : In
        As of :class:`PlaceCounter`.
    read : Out(ReadPort(config, max_width * height))
    o : Out(stream.Signature(PixelPair()))
    """
    def __init__(self, config: MatcherConfig, height: int, ahead: int):
        self.ahead = ahead
        self.places = PlaceCounter(config.max_width, height)
        members = self.places.signature.members
        super().__init__({
            "start": In(1), "width": members["width"], "lines": members["lines"],
            "read": Out(ReadPort(config, config.max_width * height)),
            "o": Out(stream.Signature(PixelPair())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.places = places = self.places
        m.submodules.queue = queue = Queue(PixelPair(), self.ahead)
        place, request = places.place, self.read.request
        active = Signal()
        ahead  = Signal(range(self.ahead + 1))
        issue  = Signal()
        m.d.comb += [
            places.start.eq(self.start), places.width.eq(self.width), places.lines.eq(self.lines), places.step.eq(issue),
            request.valid.eq(active & (ahead != self.ahead)), issue.eq(request.valid & request.ready),
            request.p.address.eq(place.address), request.p.flags.eq(Cat(place.first, place.last, place.end)),
        ]
        with m.If(self.start):
            m.d.sync += active.eq(1)
        with m.Elif(issue & place.end):
            m.d.sync += active.eq(0)
        leaves = self.o.valid & self.o.ready
        m.d.sync += ahead.eq(ahead + issue - leaves)

        into, found = queue.i, self.read.found
        m.d.comb += [
            into.valid.eq(self.read.valid), into.p.left.eq(found.left), into.p.right.eq(found.right),
            Cat(into.p.first, into.p.last, into.p.end).eq(self.read.flags),
        ]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m

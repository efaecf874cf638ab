"""Reader of a stored pair: a pixel of both pictures a clock, for the matcher."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ..matcher.stream import PixelPair
from ..parts.queue import Queue
from .store import FrameStore


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
    """Reads both stores once, in step. Golden: the pixels of both pictures, line by line from the top.

    Timing: a pixel a cycle while ``o`` accepts them; the first one 6 cycles after ``start``. ``o.valid`` and ``address`` do not depend on
    ``o.ready`` of the same cycle: as many pixels are read ahead as fit into a queue.

    Parameters
    ----------
    max_width, height : int
        Of the stores, pixels.

    Members
    -------
    start : In(1)
        Reads the pair from its first pixel on; must not be high again before the last one was accepted.
    width, lines : In
        As of :class:`PlaceCounter`.
    address : Out(range(max_width * height))
        To both stores.
    left, right : In(8)
        Words found, :attr:`hdl.loop.store.FrameStore.LATENCY` cycles later.
    o : Out(stream.Signature(PixelPair()))
    """
    #: Pixels on their way: those of the stores' latency, the queue's, and the cycle in which a place in it is known to be free.
    AHEAD = 8

    def __init__(self, max_width: int, height: int):
        self.places = PlaceCounter(max_width, height)
        members = self.places.signature.members
        super().__init__({
            "start": In(1), "width": members["width"], "lines": members["lines"],
            "address": Out(range(max_width * height)), "left": In(8), "right": In(8),
            "o": Out(stream.Signature(PixelPair())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.places = places = self.places
        m.submodules.queue = queue = Queue(PixelPair(), self.AHEAD)
        place = places.place
        active = Signal()
        ahead  = Signal(range(self.AHEAD + 1))
        issue  = Signal()
        m.d.comb += [
            places.start.eq(self.start), places.width.eq(self.width), places.lines.eq(self.lines), places.step.eq(issue),
            issue.eq(active & (ahead != self.AHEAD)), self.address.eq(place.address),
        ]
        with m.If(self.start):
            m.d.sync += active.eq(1)
        with m.Elif(issue & place.end):
            m.d.sync += active.eq(0)
        leaves = self.o.valid & self.o.ready
        m.d.sync += ahead.eq(ahead + issue - leaves)

        # Flags travel beside the words of the stores.
        flags = Cat(place.first, place.last, place.end)
        valid: Value = issue
        for number in range(FrameStore.LATENCY):
            next_valid = Signal(name=f"valid_{number}")
            next_flags = Signal(3, name=f"flags_{number}", reset_less=True)
            m.d.sync += [next_valid.eq(valid), next_flags.eq(flags)]
            valid, flags = next_valid, next_flags
        into = queue.i
        m.d.comb += [
            into.valid.eq(valid), into.p.left.eq(self.left), into.p.right.eq(self.right),
            Cat(into.p.first, into.p.last, into.p.end).eq(flags),
        ]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m

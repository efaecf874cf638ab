"""Order, and no loss: whatever is accepted leaves in order, once, and within a bounded time."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

from amaranth import *
from amaranth.lib import wiring

from hdl.matcher.lines import LineStore
from hdl.matcher.shift import RightShift
from hdl.parts.delay import CountedDelay, Delay, SkidRegister, StreamRegister
from hdl.parts.line_memory import LineMemory
from hdl.parts.queue import AsyncQueue, Queue

from .claim import Claim
from .proof import Proof
from .streams import LINEAR, short_store


__all__ = ["PROOFS", "Delayed", "InOrder", "LinesInOrder"]


class InOrder(Claim):
    """Words leave as they were accepted. One of them, any, is followed: it leaves behind those that were inside when it was accepted.

    Parameters
    ----------
    component : Component
    i, o : str
        Names of its streams.
    most : int
        Words that it holds.
    patience : int
        Cycles within which a word is offered, once none is before it.
    bits : int
        As of :meth:`Claim.surround`.
    compared : function
        What of a payload is the same in both streams.
    clocks : pair of str
        Domains of ``i`` and ``o``, if there are two: each of their clocks has an edge in any cycles.
    """
    def __init__(self, component: wiring.Component, *, i: str = "i", o: str = "o", most: int, patience: int | None, bits: int | None = None,
                 compared: Callable[[Any], Value] = Value.cast, clocks: tuple[str, str] | None = None, constant: tuple[str, ...] = ()):
        super().__init__()
        self.component = component
        self.i, self.o, self.most, self.patience, self.bits = i, o, most, patience, bits
        self.compared, self.clocks, self.constants = compared, clocks, constant

    def build(self, m: Module) -> None:
        given, left = getattr(self.component, self.i), getattr(self.component, self.o)
        i_edge, o_edge = Const(1), Const(1)
        if self.clocks:
            i_edge, o_edge = self.free(1, "i_edge"), self.free(1, "o_edge")
            enabled = EnableInserter(dict(zip(self.clocks, (i_edge, o_edge))))(self.component)
            m.submodules.component = DomainRenamer(dict.fromkeys(self.clocks, "sync"))(enabled)
        else:
            m.submodules.component = self.component
        self.surround(m, self.component, bits=self.bits, constant=self.constants)
        enters, leaves = Signal(), Signal()
        m.d.comb += [enters.eq(given.valid & given.ready & i_edge), leaves.eq(left.valid & left.ready & o_edge)]

        inside = Signal(range(self.most + 2))
        m.d.sync += inside.eq(inside + enters - leaves)
        self.promise(m, (inside != 0) | enters | ~leaves, "nothing leaves that was not accepted")
        self.promise(m, inside <= self.most, "holds no more")
        word = Signal(len(Value.cast(self.compared(given.payload))))
        before = Signal.like(inside)    # words in front of the one that is followed
        followed, gone = Signal(), Signal()
        begins = enters & ~followed & self.free(1, "follow")
        with m.If(begins):
            m.d.sync += [followed.eq(1), word.eq(self.compared(given.payload)), before.eq(inside - leaves)]
        with m.Elif(followed & leaves):
            m.d.sync += before.eq(before - 1)
            with m.If(before == 0):
                m.d.sync += gone.eq(1)
        with m.If(followed & ~gone & left.valid & (before == 0)):
            self.promise(m, self.compared(left.payload) == word, "the word that was accepted")
        if self.patience is not None:
            waiting = Signal(range(self.patience + 2))
            m.d.sync += waiting.eq(Mux((inside != 0) & ~left.valid, waiting + 1, 0))
            self.promise(m, waiting < self.patience, "offered in time")
        several = Signal()
        m.d.sync += several.eq(several | (begins & (inside == min(2, self.most - 1))))
        m.d.comb += self.witness.eq(gone & several)


class Delayed(Claim):
    """What enters in any cycle leaves ``clocks`` cycles later."""
    def __init__(self, component: Any, clocks: int, *, counts: bool = False):
        super().__init__()
        self.component, self.clocks, self.counts = component, clocks, counts

    def build(self, m: Module) -> None:
        m.submodules.component = component = self.component
        m.d.comb += component.i.eq(self.free(len(component.i), "i"))
        if self.counts:
            count = Signal.like(component.count)
            m.d.sync += count.eq(count + 1)
            m.d.comb += component.count.eq(count)
        word, left, followed = Signal.like(component.i), Signal(range(self.clocks + 1)), Signal()
        with m.If(~followed & self.free(1, "follow")):
            m.d.sync += [followed.eq(1), word.eq(component.i), left.eq(self.clocks - 1)]
        with m.Elif(left != 0):
            m.d.sync += left.eq(left - 1)
        m.d.comb += self.witness.eq(followed & (left == 0) & word.any())
        ended = Signal()
        m.d.sync += ended.eq(ended | (followed & (left == 0)))
        with m.If(followed & (left == 0) & ~ended):
            self.promise(m, component.o == word, "the word that entered")


class Stored(Claim):
    """A :class:`LineMemory` returns what was written to an address last; it is not read where it is written."""
    def __init__(self, component: LineMemory):
        super().__init__()
        self.component = component

    def build(self, m: Module) -> None:
        m.submodules.component = component = self.component
        self.surround(m, component)
        place = self.constant(m, component.column.shape(), "place")
        self.presume(m, ~(component.write & (component.column == component.address)), component.column < component.depth,
                     component.address < component.depth)
        word, written = Signal.like(component.i), Signal()
        with m.If(component.write & (component.column == place)):
            m.d.sync += [word.eq(component.i), written.eq(1)]
        # What it was in the cycle of the address, LATENCY cycles ago.
        asked, expected = Signal(component.LATENCY), [Signal.like(component.i, name=f"expected_{n}") for n in range(component.LATENCY)]
        m.d.sync += [asked.eq(Cat(written & (component.address == place), asked)), expected[0].eq(word)]
        m.d.sync += [later.eq(earlier) for earlier, later in pairwise(expected)]
        m.d.comb += [self.witness.eq(asked[-1] & expected[-1].any())]
        with m.If(asked[-1]):
            self.promise(m, component.o == expected[-1], "the word that was written last")


class LinesInOrder(Claim):
    """The columns of a line store: each pixel is in those of its line and of its neighbours, edges are replicated, frames are rectangular.

    Frames are well-formed and of any size up to ``width`` x ``height``, the same for all. One pixel, any, is followed.
    """
    def __init__(self, component: Any, width: int, height: int):
        super().__init__()
        self.component, self.width, self.height = component, width, height

    def build(self, m: Module) -> None:
        m.submodules.component = component = self.component
        i, o = component.i, component.o
        width, height = self.constant(m, range(self.width + 1), "width"), self.constant(m, range(self.height + 1), "height")
        self.presume(m, (width != 0) & (width <= self.width) & (height != 0) & (height <= self.height))

        # Frames that are accepted.
        x, y = Signal(range(self.width)), Signal(range(self.height))
        stalled, pixel = Signal(), Signal(2)
        last, lowest = Signal(), Signal()
        m.d.comb += [
            last.eq(x + 1 == width), lowest.eq(y + 1 == height), i.valid.eq(stalled | self.free(1, "i.valid")),
            i.p.first.eq((x == 0) & (y == 0)), i.p.last.eq(last), i.p.end.eq(last & lowest),
            Cat(i.p.left[0], i.p.right[0]).eq(Mux(stalled, pixel, self.free(2, "i.pixel"))), o.ready.eq(self.free(1, "o.ready")),
        ]
        m.d.sync += [stalled.eq(i.valid & ~i.ready), pixel.eq(Cat(i.p.left[0], i.p.right[0]))]
        enters = i.valid & i.ready
        with m.If(enters):
            m.d.sync += x.eq(Mux(last, 0, x + 1))
            with m.If(last):
                m.d.sync += y.eq(Mux(lowest, 0, y + 1))

        # Columns that leave.
        ox, oy = Signal(range(self.width)), Signal(range(self.height))
        o_last, o_lowest, leaves = Signal(), Signal(), Signal()
        m.d.comb += [o_last.eq(ox + 1 == width), o_lowest.eq(oy + 1 == height), leaves.eq(o.valid & o.ready)]
        with m.If(leaves):
            m.d.sync += ox.eq(Mux(o_last, 0, ox + 1))
            with m.If(o_last):
                m.d.sync += oy.eq(Mux(o_lowest, 0, oy + 1))
        self.promise(m, ~component.error, "no error")
        with m.If(o.valid):
            flags = Cat(o.p.first, o.p.last, o.p.end)
            self.promise(m, flags == Cat((ox == 0) & (oy == 0), o_last, o_last & o_lowest), "frames are rectangular")

        # The pixel that is followed, and how many frames leave before its own.
        begun, ended = enters & i.p.first, leaves & o.p.end
        frames = Signal(4)      # of which pixels are inside, or were accepted, and whose end has not left
        m.d.sync += frames.eq(frames + begun - ended)
        self.promise(m, ~frames.all(), "few frames are inside")
        followed, before, word = Signal(), Signal.like(frames), Signal(2)
        at_x, at_y = Signal.like(x), Signal.like(y)
        with m.If(~followed & enters & self.free(1, "follow")):
            m.d.sync += [followed.eq(1), word.eq(Cat(i.p.left[0], i.p.right[0])), at_x.eq(x), at_y.eq(y)]
            m.d.sync += before.eq(frames + begun - 1 - ended)
        gone = Signal()
        with m.Elif(followed & ended):
            m.d.sync += before.eq(before - 1)
            with m.If(before == 0):
                m.d.sync += gone.eq(1)
        here = Signal()
        m.d.comb += here.eq(followed & ~gone & (before == 0) & o.valid & (ox == at_x))
        seen = {name: Cat(o.p.left[name][0], o.p.right[name][0]) for name in ("minus", "line", "plus")}
        for name, shown in (("line", oy == at_y), ("minus", (oy == at_y + 1) | ((oy == 0) & (at_y == 0))),
                            ("plus", (oy + 1 == at_y) | (o_lowest & (at_y + 1 == height)))):
            with m.If(here & shown):
                self.promise(m, seen[name] == word, f"the pixel that was accepted, in {name}")
        m.d.comb += self.witness.eq(gone & (at_y == 1) & (word == 1))


def _proof(component: type, size: str, claim: str, build: Callable[[], Claim], *, suffix: str = "", depth: int | None = None,
           quick: bool = True, witness: int = 25) -> Proof:
    name = f"{component.__module__.removeprefix('hdl.')}.{component.__name__}{suffix}"
    return Proof("order", name, claim, size, build, depth=depth, quick=quick, witness=witness)


def _left_and_flags(payload: Any) -> Value:
    return Cat(payload.left, payload.first, payload.last, payload.end)


PROOFS = [
    *(_proof(Queue, f"{depth} words of 2 bits", "a word is offered within 2 cycles", suffix=f" of {depth}",
             build=lambda depth=depth: InOrder(Queue(2, depth), most=depth, patience=2)) for depth in (1, 2, 3, 5)),   # type: ignore[misc]
    _proof(AsyncQueue, "8 words of 1 bit, two clocks with edges in any cycles", "", quick=False, depth=14,
           build=lambda: InOrder(AsyncQueue(1, 8, i_domain="a", o_domain="b"), most=9, patience=None, clocks=("a", "b"))),
    _proof(StreamRegister, "2 bits", "", lambda: InOrder(StreamRegister(2), most=1, patience=1)),
    _proof(SkidRegister, "2 bits", "", lambda: InOrder(SkidRegister(2), most=2, patience=1)),
    _proof(RightShift, "any shift, pixels of 1 bit", "left pixels and flags", quick=False,
           build=lambda: InOrder(RightShift(LINEAR), most=4, patience=4, bits=1, compared=_left_and_flags)),
    *(_proof(Delay, f"{clocks} cycles, 2 bits", "", suffix=f" of {clocks}", quick=clocks < 9,
             build=lambda clocks=clocks: Delayed(Delay(2, clocks), clocks)) for clocks in (1, 4, 5, 7, 12)),   # type: ignore[misc]
    *(_proof(CountedDelay, f"{clocks} cycles, 2 bits", "", suffix=f" of {clocks}",
             build=lambda clocks=clocks: Delayed(CountedDelay(2, clocks, 3), clocks, counts=True)) for clocks in (5, 8)),   # type: ignore[misc]
    _proof(LineMemory, "5 words of 2 bits", "a word that was written last is found", lambda: Stored(LineMemory(2, 5))),
    _proof(LineStore, "frames of up to 2 x 2 pixels of 1 bit, 3 in the FIFO",
           "each pixel is in three columns, edges are replicated, frames are rectangular",
           lambda: LinesInOrder(short_store(), 2, 2), depth=22, quick=False),
]

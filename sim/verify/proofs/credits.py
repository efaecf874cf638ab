"""Credits and turns: what is requested fits where it goes, and every master is served within its bound."""

from collections.abc import Callable
from typing import Any

from amaranth import *

from golden.video.bandwidth import grant_clocks, served_clocks
from golden.video.memory_map import MemoryMap, Plane
from hdl.loop.pair_read import PairScan
from hdl.video.arbiter import Arbiter
from hdl.video.frame_read import _PlanePairReader

from .claim import Claim
from .proof import Proof
from .streams import LINEAR, STORES, scanned


__all__ = ["Fits", "PROOFS", "Served"]


class Fits(Claim):
    """A queue within a component is never offered a word that it does not take.

    Parameters
    ----------
    component : Component
    queues : function
        The component's module to streams into its queues.
    around : function
        Drives the ports ``driven``.
    """
    def __init__(self, component: Any, queues: Callable[[Any], list[Any]], *, around: Callable[[Module, Claim, Any], None],
                 driven: tuple[str, ...], constant: tuple[str, ...] = (), bits: int | None = None):
        super().__init__()
        self.component, self.queues, self.around, self.driven, self.constants, self.bits = component, queues, around, driven, constant, bits

    def build(self, m: Module) -> None:
        inner = self.component.elaborate(None)
        full = []
        for number, stream in enumerate(self.queues(inner)):
            # Assertions stand where the queue is.
            self.promise(inner, stream.ready | ~stream.valid, f"queue {number} has room")
            level = Signal(name=f"full_{number}")
            inner.d.comb += level.eq(~stream.ready)
            full.append(level)
        m.submodules.component = inner
        self.surround(m, self.component, bits=self.bits, constant=self.constants, skip=self.driven)
        self.around(m, self, self.component)
        seen = Signal(len(full))
        m.d.sync += seen.eq(seen | Cat(full))
        m.d.comb += self.witness.eq(seen.all())


def _returned(m: Module, claim: Claim, component: Any) -> None:
    """Words of a burst are returned in the order of the requests, at any time."""
    port = component.port
    request, first, second = port.request, Signal(3), Signal(3)     # words of the bursts in flight, two at most
    claim.take(m, request, "port.request", when=second == 0)
    granted = request.valid & request.ready
    m.d.comb += [
        port.rdata_valid.eq((first != 0) & claim.free(1, "port.rdata_valid")), port.rdata_last.eq(first == 1),
        port.rdata.eq(claim.free(1, "port.rdata")),
    ]
    left = Signal(3)
    m.d.comb += left.eq(first - port.rdata_valid)
    m.d.sync += first.eq(left)
    with m.If(left == 0):
        m.d.sync += [first.eq(Mux(second != 0, second, Mux(granted, request.p.length, 0))), second.eq(0)]
        with m.If((second != 0) & granted):
            m.d.sync += second.eq(request.p.length)
    with m.Elif(granted):
        m.d.sync += second.eq(request.p.length)


class Served(Claim):
    """A master of the arbiter, any, waits no longer than :func:`grant_clocks` for its grant, and a writer than :func:`served_clocks`.

    The memory accepts a word a cycle but for ``stall`` cycles, while the master waits; all words of a writer are there; the queue of bursts
    in flight is not full.

    Parameters
    ----------
    writers, readers, burst, stall : int
    slack : int
        Cycles less than the bound: 0, or a deliberate fault.
    """
    def __init__(self, writers: int, readers: int, burst: int, stall: int, *, slack: int = 0):
        super().__init__()
        self.component = Arbiter(writers, readers, burst=burst, outstanding=4)
        masters = writers + readers
        self.burst, self.stall = burst, stall
        self.grant, self.served = grant_clocks(masters, burst, 1, stall) - slack, served_clocks(masters, burst, 1, stall) - slack

    def build(self, m: Module) -> None:
        arbiter = self.component
        inner = arbiter.elaborate(None)
        m.submodules.component = inner
        bus, burst = arbiter.bus, self.burst
        room = inner.submodules.in_flight.i.ready
        self.presume(m, room)
        m.d.comb += [bus.ready.eq(self.free(1, "bus.ready")), bus.init_done.eq(1)]
        flying = Signal(range(4 * burst + 2))   # words to be returned
        issued = bus.read_req & bus.ready
        m.d.comb += bus.rdata_valid.eq((flying != 0) & self.free(1, "bus.rdata_valid"))
        m.d.sync += flying.eq(flying + issued - bus.rdata_valid)
        stalls = []
        for number, port in enumerate([*arbiter.write, *arbiter.read]):
            request, name = port.request, f"master_{number}"
            self.offer(m, request, name, 2)
            self.presume(m, (request.p.length != 0) & (request.p.length <= burst))
            stalled, waits, served = (Signal(range(limit + 2), name=f"{name}_{about}") for limit, about in (
                (self.stall, "stalled"), (self.grant, "waits"), (self.served, "is_served")))
            granted, busy = request.valid & request.ready, Signal(name=f"{name}_busy")
            accepted = granted
            if number < len(arbiter.write):
                accepted = port.accepted
                m.d.comb += port.word.valid.eq(1)
                with m.If(granted):
                    m.d.sync += busy.eq(1)
                with m.Elif(accepted):
                    m.d.sync += busy.eq(0)
                # A writer waits for its burst, and not for two.
                self.presume(m, ~(busy & request.valid))
            waiting = request.valid | busy
            m.d.sync += [
                stalled.eq(Mux(waiting & ~accepted, stalled + ~bus.ready, 0)), waits.eq(Mux(request.valid & ~granted, waits + 1, 0)),
                served.eq(Mux(waiting & ~accepted, served + 1, 0)),
            ]
            self.presume(m, (stalled < self.stall) | bus.ready | ~waiting)
            self.promise(m, waits <= self.grant, f"{name} is granted in time")
            self.promise(m, served <= self.served, f"{name} is served in time")
            stalls.append(stalled)
        m.d.comb += self.witness.eq(Cat(stalled == self.stall for stalled in stalls).any())


def _proof(component: type, size: str, claim: str, build: Callable[[], Claim], *, depth: int | None = None, quick: bool = True,
           witness: int = 40) -> Proof:
    return Proof("credits", f"{component.__module__.removeprefix('hdl.')}.{component.__name__}", claim, size, build, depth=depth,
                 quick=quick, witness=witness)


def scan_credits(component: PairScan) -> Fits:
    """Of the pixels that are read ahead."""
    return Fits(component, lambda module: [module.submodules.queue.i], around=scanned, driven=(*STORES, "start"),
                constant=("width", "lines"), bits=1)


def read_credits() -> Fits:
    """Of the words that are requested from the memory."""
    reader = _PlanePairReader(MemoryMap(40, 4), (Plane.LEFT, Plane.RIGHT), cuts=True, burst=2, depth=4)
    return Fits(reader, lambda module: [module.submodules.fifo_0.i, module.submodules.fifo_1.i], around=_returned,
                driven=("port.request", "port.rdata_valid", "port.rdata_last", "port.rdata"))


PROOFS = [
    _proof(PairScan, "3 x 2 pixels of 1 bit, 4 ahead, words after 2 cycles", "the queue of pixels that are read ahead",
           lambda: scan_credits(PairScan(LINEAR, 2, 4))),
    _proof(_PlanePairReader, "40 x 4 pixels, bursts of 2, FIFOs of 4 words", "both FIFOs of words from the memory", read_credits, depth=24,
           quick=False),
    _proof(Arbiter, "2 writers, 1 reader, bursts of 2, a stall of 2 cycles", "granted and served within `golden.video.bandwidth`'s bounds",
           lambda: Served(2, 1, 2, 2)),
]

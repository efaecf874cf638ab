"""The rules of streams, proved of each component of :mod:`hdl` that sends one."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from amaranth import *
from amaranth.lib import wiring

from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, MatcherConfig, OnePass, changed
from golden.video.frame_rule import Closes
from golden.video.memory_map import MemoryMap, Plane
from golden.video.side_by_side import Layout
from hdl.host.block_write import BlockWrite
from hdl.host.blocks import BlockRead
from hdl.host.registers import RequestReader
from hdl.interfaces.avalon_mm import AvalonMemoryMapped
from hdl.interfaces.axi_lite import AxiLite
from hdl.interfaces.frame_rule import FrameRule
from hdl.interfaces.words import WordAccess
from hdl.loop.line_ahead import LineAhead
from hdl.loop.pair_read import PairScan
from hdl.loop.receive import LinePlacer
from hdl.loop.results import LineSource, ResultWriter
from hdl.loop.sdram_store import WordArbiter
from hdl.matcher.census import BlindCensusStage, CensusStage
from hdl.matcher.frame_timing import FrameTiming
from hdl.matcher.lead import Lead
from hdl.matcher.lines import LineStore
from hdl.matcher.refine.border_fill import BorderFill
from hdl.matcher.refine.fill import Fill
from hdl.matcher.sequential.bec import Bec
from hdl.matcher.sequential.cost import CostEnergy, Edata, SubPixelBuffers, SubPixels
from hdl.matcher.sequential.engine import SequentialEngine
from hdl.matcher.shift import RightShift
from hdl.matcher.stream import PixelPair
from hdl.parts.delay import SkidRegister, StreamRegister
from hdl.parts.queue import AsyncQueue, Queue
from hdl.parts.uart import UartReceiver
from hdl.rig.balance import Balance
from hdl.rig.rows import RowWriter
from hdl.video.camera_fifo import CameraFifo
from hdl.video.dma import PixelPacker, PixelUnpacker, WordFifo
from hdl.video.frame_read import PairReader, PictureReader
from hdl.video.frame_write import FrameWriter, PictureWriter
from hdl.video.i2c import I2cMaster
from hdl.video.line_access import LineAccess
from hdl.video.system import PairFork

from .claim import Claim, Port, streams_of
from .proof import Proof


__all__ = ["AXI", "LINEAR", "PICTURES", "PROOFS", "STORES", "StreamRules", "axi", "scanned", "short_store"]


# Smallest sizes that have all parts: two labels, lines of up to three pixels, pictures of two lines.
THESIS, LINEAR = MatcherConfig(2, 3), MatcherConfig(2, 3, method=OnePass(Arithmetic.LINEAR))
FUSED = MatcherConfig(2, 3, method=changed(FUSED_1, census_rows=3, census_columns=3))
RECURSIVE = MatcherConfig(2, 3, method=RECURSIVE_1)
PICTURES = MemoryMap(8, 2)


class StreamRules(Claim):
    """What a component offers holds until it is accepted, in surroundings that obey the same rule and are otherwise free.

    The witness: each stream has offered a word before it was ever ready.

    Parameters
    ----------
    component : Component
    bits, constant : int, sequence of str
        As of :meth:`Claim.surround`.
    around : function
        Drives the ports ``driven``, or assumes something; given a module, the claim and the component.
    driven : sequence of str
    withdrawn : mapping
        Names of streams to functions of the claim: when an offer may be withdrawn.
    compared : mapping
        Names of streams to functions of a payload: what of it must hold.
    holds : bool
        As of :meth:`Claim.offer`.
    domains : sequence of str
        Further clock domains, which become ``sync``.
    """
    def __init__(self, component: wiring.Component, *, bits: int | None = None, constant: Sequence[str] = (),
                 around: Callable[[Module, Claim, Any], None] | None = None, driven: Sequence[str] = (),
                 withdrawn: Mapping[str, Callable[[Any], Value]] | None = None,
                 compared: Mapping[str, Callable[[Any], Value]] | None = None, domains: Sequence[str] = (), holds: bool = True):
        super().__init__()
        self.component = component
        self.bits, self.constants, self.around, self.driven = bits, constant, around, driven
        self.withdrawn, self.compared, self.domains, self.holds = withdrawn or {}, compared or {}, domains, holds
        self.sent: list[Port] = [stream for stream in streams_of(component) if stream.is_output]
        self.outputs = {stream.name: Cat(stream.value.valid, stream.value.payload) for stream in self.sent}

    def build(self, m: Module) -> None:
        m.submodules.component = DomainRenamer(dict.fromkeys(self.domains, "sync"))(self.component) if self.domains else self.component
        self.surround(m, self.component, bits=self.bits, constant=self.constants, skip=self.driven, holds=self.holds)
        if self.around:
            self.around(m, self, self.component)
        offered = []
        for name, _, stream, _ in self.sent:
            payload = Value.cast(self.compared.get(name, Value.cast)(stream.payload))
            withdrawn = self.withdrawn[name](self) if name in self.withdrawn else C(0)
            stalled, before = Signal(name=f"{name}_stalled"), Signal(len(payload), name=f"{name}_before")
            m.d.sync += [stalled.eq(stream.valid & ~stream.ready & ~withdrawn), before.eq(payload)]
            self.promise(m, ~stalled | (stream.valid & (payload == before)), f"{name} holds")
            asked, seen = Signal(name=f"{name}_asked"), Signal(name=f"{name}_seen")
            m.d.sync += [asked.eq(asked | stream.ready), seen.eq(seen | (stream.valid & ~stream.ready & ~asked))]
            offered.append(seen)
        m.d.comb += self.witness.eq(Cat(offered).all())


def _not_zero(*names: str) -> Callable[[Module, Claim, Any], None]:
    """Sizes are at least 1."""
    def around(m: Module, claim: Claim, component: Any) -> None:
        claim.presume(m, *(getattr(component, name) != 0 for name in names))
    return around


def _stores(m: Module, claim: Claim, component: Any) -> None:
    """Stores return words two cycles after their requests."""
    port, request = component.read, component.read.request
    claim.take(m, request, "read.request")
    due, flags, earlier = Signal(2), Signal.like(port.flags), Signal.like(port.flags)
    m.d.sync += [due.eq(Cat(request.valid & request.ready, due)), earlier.eq(request.p.flags), flags.eq(earlier)]
    found = Value.cast(port.found)
    m.d.comb += [port.valid.eq(due[1]), port.flags.eq(flags), found.eq(claim.free(2, "read.found"))]


STORES = ("read.request", "read.valid", "read.flags", "read.found")


def scanned(m: Module, claim: Claim, component: Any) -> None:
    """As :func:`_stores`, for pairs that begin when the last pixel of the one before has been accepted."""
    _stores(m, claim, component)
    _not_zero("width", "lines")(m, claim, component)
    busy = Signal()
    claim.presume(m, (component.width <= 3) & (component.lines <= 2))
    m.d.comb += component.start.eq(claim.free(1, "start") & ~busy)
    with m.If(component.start):
        m.d.sync += busy.eq(1)
    with m.Elif(component.o.valid & component.o.ready & component.o.p.end):
        m.d.sync += busy.eq(0)


def _line_bytes(m: Module, claim: Claim, component: Any) -> None:
    """A block read begins when the one before has ended; bytes of a line follow its request."""
    request, byte, sent = component.request, component.i, component.port.byte
    busy, due = Signal(), Signal()
    m.d.comb += component.port.start.eq(claim.free(1, "port.start") & ~busy)
    claim.take(m, request, "request")
    claim.offer(m, byte, "i", when=due)
    with m.If(component.port.start):
        m.d.sync += busy.eq(1)
    with m.If(request.valid & request.ready):
        m.d.sync += due.eq(1)
    with m.If(byte.valid & byte.ready & byte.p.last):
        m.d.sync += due.eq(0)
    with m.If(sent.valid & sent.ready & sent.p.last & ~due):
        m.d.sync += busy.eq(0)


class _Bursts(StreamRules):
    """The rules of a writer at the arbiter, whose words must hold within a granted burst."""
    def __init__(self, component: wiring.Component, port: str = "port", **options: Any):
        self.left = Signal(range(17))   # words of the burst
        self.port = port
        super().__init__(component, around=self.arbiter, driven=[f"{port}.{name}" for name in ("request", "word", "accepted")],
                         withdrawn={f"{port}.word": lambda claim: claim.left == 0}, **options)

    def arbiter(self, m: Module, claim: Claim, component: Any) -> None:
        """Takes the words of each burst, and some time later tells that the last one was accepted."""
        port, due = getattr(component, self.port), Signal()
        request, word = port.request, port.word
        claim.take(m, request, f"{self.port}.request", when=(self.left == 0) & ~due)
        claim.take(m, word, f"{self.port}.word", when=self.left != 0)
        with m.If(request.valid & request.ready):
            m.d.sync += self.left.eq(request.p.length)
        with m.If(word.valid & word.ready):
            m.d.sync += [self.left.eq(self.left - 1), due.eq(self.left == 1)]
        m.d.comb += port.accepted.eq(due & claim.free(1, f"{self.port}.accepted"))
        with m.If(port.accepted):
            m.d.sync += due.eq(0)


def _answers(m: Module, claim: Claim, component: Any) -> None:
    """A response for each command, once it has been accepted."""
    command, result, due = component.command, component.result, Signal()
    claim.take(m, command, "command")
    with m.If(command.valid & command.ready):
        m.d.sync += due.eq(1)
    with m.If(result.valid):
        m.d.sync += due.eq(0)
    payload = Value.cast(result.payload)
    m.d.comb += [result.valid.eq(due & claim.free(1, "result.valid")), payload.eq(claim.free(len(payload), "result.payload"))]


def axi(m: Module, claim: Claim, component: Any) -> None:
    """A master whose channels hold what they offer."""
    _answers(m, claim, component)
    for channel, names in (("aw", ["awaddr"]), ("ar", ["araddr"]), ("w", ["wdata", "wstrb"])):
        valid, ready = getattr(component, f"{channel}valid"), getattr(component, f"{channel}ready")
        data = Cat(getattr(component, name) for name in names)
        stalled, held = Signal(name=f"{channel}_stalled"), Signal(len(data), name=f"{channel}_held")
        m.d.sync += [stalled.eq(valid & ~ready), held.eq(data)]
        m.d.comb += [valid.eq(stalled | claim.free(1, f"{channel}valid")), data.eq(Mux(stalled, held, claim.free(len(data), channel)))]


AXI = ("command", "result", "awvalid", "awaddr", "arvalid", "araddr", "wvalid", "wdata", "wstrb")


def short_store() -> LineStore:
    """A line store with few words in its FIFO."""
    store = LineStore(LINEAR)
    store.PLUS_DEPTH = 3    # type: ignore[misc]
    return store


def _proof(component: type, size: str, make: Callable[[], wiring.Component], *, note: str = "", kind: type[StreamRules] = StreamRules,
           witness: int = 25, quick: bool = True, **options: Any) -> Proof:
    return Proof("streams", f"{component.__module__.removeprefix('hdl.')}.{component.__name__}", note, size,
                 lambda: kind(make(), **options), witness=witness, quick=quick)


def _cleared(claim: Any) -> Value:
    return Value.cast(claim.component.clear)


_BIT: dict[str, Any] = {"bits": 1}
_TWO: dict[str, Any] = {"bits": 2}
# Whatever is offered to it: a component that sends through one of these needs no proof of its own.
_UNRULY: dict[str, Any] = {"holds": False, "note": "even if what it is offered does not hold"}
_SMALL = "2 labels, lines of up to 3 pixels of 1 bit"

PROOFS = [
    _proof(Queue, "4 words of 4 bits", lambda: Queue(4, 4), **_UNRULY),
    _proof(AsyncQueue, "8 words of 2 bits, one clock", lambda: AsyncQueue(2, 8), **_UNRULY),
    _proof(StreamRegister, "4 bits", lambda: StreamRegister(4), **_UNRULY),
    _proof(SkidRegister, "4 bits", lambda: SkidRegister(4), **_UNRULY),
    _proof(UartReceiver, "16 clocks a bit", lambda: UartReceiver(32, 2), witness=200, quick=False,
           note="a byte that is not accepted in time stays"),
    _proof(BlockRead, "2 lines", lambda: BlockRead(2), around=_line_bytes, driven=("request", "i", "port.start")),
    _proof(RequestReader, "time-out of 3 cycles, with block writes", lambda: RequestReader(3, writes=True),
           note="a byte that is offered as a block ends is none of it, and is withdrawn",
           withdrawn={"put.byte": lambda claim: claim.component.put.done}),
    _proof(AvalonMemoryMapped, "whole", AvalonMemoryMapped, around=_answers, driven=("command", "result")),
    _proof(AxiLite, "whole", AxiLite, around=axi, driven=AXI, note="data and strobes of a read are undefined",
           compared={"command": lambda payload: Mux(payload.write, payload.as_value(), Cat(payload.address, payload.write))}),
    _proof(FrameRule, "frames of up to 3 x 3 pixels of 1 bit", lambda: FrameRule(3, 3, Closes.LINE), **_BIT,
           constant=("width", "height"), around=_not_zero("width", "height")),
    _proof(WordAccess, "whole", WordAccess),
    _proof(PairScan, "3 x 2 pixels of 1 bit, 4 ahead, words after 2 cycles", lambda: PairScan(LINEAR, 2, 4), around=scanned,
           driven=(*STORES, "start"), constant=("width", "lines")),
    _proof(BlockWrite, "2 lines of up to 3 bytes", lambda: BlockWrite(3, 2)),
    _proof(LinePlacer, "3 x 2 pixels", lambda: LinePlacer(3, 2), constant=("plane", "line")),
    _proof(LineSource, "3 x 2 pixels", lambda: LineSource(LINEAR, 2), constant=("width",)),
    _proof(ResultWriter, "3 x 2 pixels", lambda: ResultWriter(LINEAR, 2), constant=("width", "lines", "minimum")),
    _proof(LineAhead, "3 x 2 pixels, one clock", lambda: LineAhead(LINEAR, 2, Layout(1, range(6), range(2))), around=_stores,
           driven=STORES, domains=("pixel",)),
    _proof(WordArbiter, "3 clients", lambda: WordArbiter(3, 2)),
    _proof(FrameTiming, "4 pixels", lambda: FrameTiming(4)),
    _proof(LineStore, "lines of up to 3 pixels of 1 bit, 3 in the FIFO", short_store, **_BIT),
    _proof(RightShift, "pixels of 1 bit", lambda: RightShift(LINEAR), **_BIT, quick=False),
    _proof(Lead, "lead of 1, pixels of 1 bit", lambda: Lead(MatcherConfig(2, 3, minimum=-1)), **_BIT),
    _proof(CensusStage, "3 x 3, pixels of 1 bit", lambda: CensusStage(FUSED), **_BIT),
    _proof(BlindCensusStage, "pixels of 1 bit", lambda: BlindCensusStage(RECURSIVE), **_BIT, quick=False),
    _proof(Fill, _SMALL, lambda: Fill(FUSED), **_BIT),
    _proof(BorderFill, _SMALL, lambda: BorderFill(RECURSIVE), **_BIT, quick=False),
    _proof(SubPixels, _SMALL, lambda: SubPixels(LINEAR), **_BIT),
    _proof(SubPixelBuffers, _SMALL, lambda: SubPixelBuffers(LINEAR), **_BIT),
    _proof(CostEnergy, _SMALL, lambda: CostEnergy(LINEAR), **_BIT),
    _proof(Edata, _SMALL, lambda: Edata(LINEAR), **_BIT),
    _proof(Bec, _SMALL, lambda: Bec(LINEAR), **_BIT, quick=False),
    _proof(SequentialEngine, _SMALL, lambda: SequentialEngine(THESIS), **_BIT, quick=False, witness=60),
    _proof(Balance, "4 x 4 pixels of 1 bit", lambda: Balance(4, 4, 2), **_BIT, quick=False),
    _proof(RowWriter, "lines of up to 3 pixels of 1 bit", lambda: RowWriter(PixelPair(), ("left", "right"), 3, 3, 4), **_BIT),
    _proof(WordFifo, "4 words of 4 bits", lambda: WordFifo(4), bits=4, note="`clear` withdraws", withdrawn={"o": _cleared}),
    _proof(PixelPacker, "pixels of 1 bit", PixelPacker, **_BIT, note="`clear` withdraws", withdrawn={"o": _cleared}),
    _proof(PixelUnpacker, "8 x 2 pixels of 1 bit", lambda: PixelUnpacker(PICTURES), **_BIT),
    _proof(FrameWriter, "8 x 2 pixels of 1 bit, bursts of 2", lambda: FrameWriter(PICTURES, Plane.LEFT, burst=2, depth=4), **_BIT,
           kind=_Bursts, note="words hold within a burst that was granted", quick=False),
    _proof(PictureWriter, "8 x 2 pixels of 1 bit, bursts of 2", lambda: PictureWriter(PICTURES, Plane.SHOWN_LEFT, burst=2, depth=4),
           **_BIT, kind=_Bursts, note="words hold within a burst that was granted", quick=False),
    _proof(PairReader, "8 x 2 pixels of 2 bits, bursts of 2", lambda: PairReader(PICTURES, burst=2, depth=4), **_TWO, quick=False),
    _proof(PictureReader, "8 x 2 pixels of 2 bits, bursts of 2", lambda: PictureReader(PICTURES, LINEAR, burst=2, depth=4), **_TWO),
    _proof(LineAccess, "8 x 2 pixels of 2 bits", lambda: LineAccess(MemoryMap(8, 2, host=True), burst=2), **_TWO, kind=_Bursts,
           port="write", witness=60, note="words hold within a burst that was granted"),
    _proof(CameraFifo, "8 words, one clock", lambda: CameraFifo("sync", 8)),
    _proof(I2cMaster, "4 clocks a bit", lambda: I2cMaster(400_000)),
    _proof(PairFork, "whole", PairFork),
]

"""Pictures in an SDRAM, which host, matcher and monitor share."""

import math
from typing import Any

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.formats import DisplayFormat
from golden.video.sdram import COLUMN_BITS, SDRAM, WORD_BITS, SdramClocks
from golden.video.side_by_side import layout

from ..parts.delay import SkidRegister
from ..parts.queue import Queue
from .line_ahead import LineAhead
from .sdram import HALF_BITS, Access, SdramController, SdramPins
from .words import FLAG_BITS, PlacedResult, StoredResult, Stores, pass_on


__all__ = ["BURST", "SdramStores", "WordArbiter"]


#: Most words of a client that follow each other while others wait.
BURST = 64

# Of a word that is read: its reader, and the flags of the request.
_READER_BITS = 2
_TAG_BITS = _READER_BITS + FLAG_BITS


class WordArbiter(wiring.Component):
    """Accesses of several clients, one after another: a client goes on for up to :data:`BURST` words, then the first one that has an access
    is next.

    Timing: latency 1 cycle, a word a cycle. ``ready`` of a client depends combinationally on ``valid`` of all.

    Members
    -------
    clients : In(stream.Signature(Access(tag_bits))).array(clients)
        In the order of their priority.
    o : Out(stream.Signature(Access(tag_bits)))
    """
    def __init__(self, clients: int, tag_bits: int):
        self.shape = Access(tag_bits)
        super().__init__({"clients": In(stream.Signature(self.shape)).array(clients), "o": Out(stream.Signature(self.shape))})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.register = register = SkidRegister(self.shape)
        valid = Cat(client.valid for client in self.clients)
        owner, left = Signal(range(len(valid))), Signal(range(BURST))
        first, chosen = Signal.like(owner), Signal.like(owner)
        held = Signal()
        for number in reversed(range(len(valid))):
            with m.If(valid[number]):
                m.d.comb += first.eq(number)
        m.d.comb += [
            held.eq(valid.bit_select(owner, 1) & (left != 0)), chosen.eq(Mux(held, owner, first)), register.i.valid.eq(valid.any()),
        ]
        with m.Switch(chosen):
            for number, client in enumerate(self.clients):
                with m.Case(number):
                    m.d.comb += [register.i.payload.eq(client.payload), client.ready.eq(register.i.ready)]
        with m.If(register.i.valid & register.i.ready):
            m.d.sync += [owner.eq(chosen), left.eq(Mux(held, left - 1, BURST - 1))]
        wiring.connect(m, register.o, wiring.flipped(self.o))
        return m


class SdramStores(Stores):
    """Both pictures in the lower half of an SDRAM, a word for the two pixels of a place, and the results in the upper half.

    The display is served first, then the results, the matcher's reading, and the host. Results wait in a queue, pixels are read ahead, and
    both take turns of up to :data:`BURST` words.

    Timing: as of :class:`hdl.loop.sdram.SdramController`; two accesses a pixel of a pair.

    Parameters
    ----------
    config, height
        As of :class:`hdl.loop.words.Stores`.
    clock_hz : int
        Of ``sync``.
    display : DisplayFormat or None
        The monitor's, if there is one.
    clocks : SdramClocks or None
        Of the memory; by default those of ``SDRAM`` at ``clock_hz``.

    Raises
    ------
    ValueError
        If the pictures are too large, or the clock is too fast for the memory or too slow for the monitor.

    Members
    -------
    busy, write, scan, read, results
        As of :class:`hdl.loop.words.Stores`.
    memory : Out(SdramPins())
    members of :meth:`hdl.loop.line_ahead.LineAhead.display_members`
        With ``display`` only.
    """
    ahead = 2 * BURST
    about = "SDRAM, with two accesses a pixel, for which the matcher waits"

    def __init__(self, config: MatcherConfig, height: int, clock_hz: int, *, display: DisplayFormat | None = None,
                 clocks: SdramClocks | None = None):
        layout_of = layout(display, config.max_width, height) if display else None
        super().__init__(config, height, {
            "memory": Out(SdramPins()), **(LineAhead.display_members(config, layout_of) if layout_of else {}),
        })
        assert StoredResult(config).size <= WORD_BITS
        if self.depth > 1 << HALF_BITS:
            raise ValueError(f"pictures of {config.max_width}x{height} pixels do not fit into half of an SDRAM of {2 << HALF_BITS:,} "
                             "words; choose smaller ones")
        self.controller = SdramController(clocks or SDRAM.clocks(clock_hz), _TAG_BITS)
        self.lines = LineAhead(config, height, layout_of) if layout_of else None
        if display and self.lines:
            available = display.h_total * clock_hz // display.pixel_clock_hz
            if self.line_clocks > available:
                least = math.ceil(self.line_clocks * display.pixel_clock_hz / display.h_total / 1e5) / 10
                raise ValueError(f"a line of the monitor lasts {available} clocks of {clock_hz / 1e6:g} MHz, and reading the next one "
                                 f"takes up to {self.line_clocks}; choose a clock of at least {least:g} MHz")

    @property
    def line_clocks(self) -> int:
        """Most cycles from the monitor's event to the last word of the next line: a burst of another client, the words, changes of rows,
        and the refreshes among them.
        """
        assert self.lines
        controller, clocks = self.controller, self.controller.clocks
        row = controller.row_clocks + clocks.read_to_write
        # Pictures and results each lie in so many rows; two more changes for the burst before.
        of_lines = 2 * (2 + self.config.max_width // (1 << COLUMN_BITS)) + 2
        busy = BURST + self.lines.words + of_lines * row + controller.LATENCY + 8
        refreshes = 1 + busy // (clocks.refresh_interval // 2)
        return busy + refreshes * (controller.refresh_clocks + row)

    def pair_clocks(self, width: int, height: int) -> int:
        # As if each access changed the row, and the memory were the monitor's and the refreshes' for half of the time.
        row = self.controller.row_clocks + self.controller.clocks.read_to_write
        return 2 * 2 * width * height * (1 + row) + self.ahead

    def elaborate(self, platform: object) -> Module:
        m = Module()
        depth = self.depth
        m.submodules.controller = controller = self.controller
        m.submodules.waiting = waiting = Queue(PlacedResult(self.config, depth), 2 * BURST)
        if self.lines:
            m.submodules.lines = self.lines
        display = [self.lines.read] if self.lines else []
        m.submodules.arbiter = arbiter = WordArbiter(len(display) + 4, _TAG_BITS)
        wiring.connect(m, arbiter.o, controller.i)
        wiring.connect(m, controller.memory, wiring.flipped(self.memory))
        wiring.connect(m, wiring.flipped(self.results), waiting.i)

        clients = iter(arbiter.clients)
        for number, reader in enumerate(display):
            self._reads(m, next(clients), reader, number)
        self._writes(m, next(clients), waiting.o, waiting.o.p.address, 1, waiting.o.p.result.as_value(), -1)
        self._reads(m, next(clients), self.scan, len(display))
        sent = self.write.p
        self._writes(m, next(clients), self.write, sent.address, 0, sent.level.replicate(2), Mux(sent.plane, 0b10, 0b01))
        self._reads(m, next(clients), self.read, len(display) + 1)
        if self.lines:
            pass_on(m, LineAhead.display_members(self.config, self.lines.layout), self.lines, self)
        return m

    @staticmethod
    def _writes(m: Module, client: Any, source: Any, address: Value, upper: int, word: Value, written: Value | int) -> None:
        """A stream whose words are written into a half of the memory."""
        access = client.p
        m.d.comb += [
            client.valid.eq(source.valid), source.ready.eq(client.ready), access.write.eq(1), access.data.eq(word),
            access.bytes.eq(written), access.address[:HALF_BITS].eq(address), access.address[HALF_BITS].eq(upper),
        ]

    def _reads(self, m: Module, client: Any, reader: Any, number: int) -> None:
        """Requests of a reader, and its words."""
        access, request, controller = client.p, reader.request, self.controller
        word, found = controller.found, reader.found
        m.d.comb += [
            client.valid.eq(request.valid), request.ready.eq(client.ready), access.address[:HALF_BITS].eq(request.p.address),
            access.address[HALF_BITS].eq(request.p.results), access.tag.eq(Cat(request.p.flags, Const(number, _READER_BITS))),
            reader.valid.eq(controller.valid & (controller.tag[FLAG_BITS:] == number)), reader.flags.eq(controller.tag[:FLAG_BITS]),
            found.left.eq(word[:PIXEL_BITS]), found.right.eq(word[PIXEL_BITS:]), found.result.as_value().eq(word),
        ]

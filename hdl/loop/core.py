"""A pair in, its disparities out: stores, matcher, registers and blocks, behind two streams of bytes."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.host.loop_registers import LOOP_PLANES, loop_register_map

from ..host.block_write import BlockWrite
from ..host.blocks import BlockRead
from ..host.registers import ByteRegisters
from ..matcher.matcher import Matcher
from ..matcher.settings import minimum_shape
from ..parts.counters import count_events
from .pair_read import PairScan
from .receive import LinePlacer
from .results import LineSource, ResultWriter
from .words import Stores, pass_on


__all__ = ["LoopCore"]


class LoopCore(wiring.Component):
    """A matcher with stores for a pair and its results, between bytes from and to a host.

    Golden: :class:`golden.host.loop_device.LoopDevice`, byte by byte.

    The host writes the lines of both pictures as blocks and then 1 to ``start``: settings are put into force, the matcher reads the pair
    from its stores, at a pixel a clock if these are memory blocks, and its results are stored. They are kept until another pair is written
    or started.

    Timing: from ``start`` to the last result there are at most :meth:`pair_clocks` cycles, which ``clocks_high`` and ``clocks_low`` count.
    Requests as of :class:`hdl.host.registers.RequestReader`, blocks as of :class:`hdl.host.block_write.BlockWrite` and
    :class:`hdl.host.blocks.BlockRead`.

    Parameters
    ----------
    stores : Stores
        Of which the system has the size and the matcher's configuration.
    timeout : int
        Cycles of silence after which a request is expected; as of :class:`hdl.host.registers.RequestReader`.

    Members
    -------
    i, o : stream.Signature(8)
        Bytes from and to the line.
    line_error : In(1)
        One cycle: a byte of the line was lost.
    leds : Out(8)
        For a board: 0 busy, 1 a pair is kept, 2 matcher error, 3 the line had an error, 4 to 7 number of pairs.
    members of ``stores.outside``
        Passed on.
    """
    def __init__(self, stores: Stores, timeout: int):
        config, height = stores.config, stores.height
        width = config.max_width
        self.config, self.width, self.height, self.stores = config, width, height, stores
        self.registers = loop_register_map(config, height)
        self.register_file = ByteRegisters(self.registers, timeout, writes=True)
        self.block_read = BlockRead(height, planes=len(LOOP_PLANES))
        self.block_write = BlockWrite(width, height)
        self.placer = LinePlacer(width, height)
        self.matcher = Matcher(config)
        self.scan = PairScan(config, height, stores.ahead)
        self.writer = ResultWriter(config, height)
        self.source = LineSource(config, height)
        super().__init__({
            "i": In(stream.Signature(8)), "o": Out(stream.Signature(8)), "line_error": In(1), "leds": Out(8), **stores.outside,
        })

    def pair_clocks(self, width: int, height: int) -> int:
        """Bound of the clocks from ``start`` to the last result of a pair of that size."""
        matcher = self.matcher
        line = max(width, matcher.full_rate_width) * matcher.clocks_per_pixel + matcher.line_clocks
        of_matcher = matcher.frame_clocks(width, height) + matcher.latency_lines * line + matcher.latency_clocks
        return of_matcher + self.scan.ahead + self.stores.pair_clocks(width, height)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.register_file = register_file = self.register_file
        m.submodules.block_read = block_read = self.block_read
        m.submodules.block_write = block_write = self.block_write
        m.submodules.placer = placer = self.placer
        m.submodules.source = source = self.source
        m.submodules.scan = scan = self.scan
        m.submodules.matcher = matcher = self.matcher
        m.submodules.writer = writer = self.writer
        m.submodules.stores = stores = self.stores

        wiring.connect(m, wiring.flipped(self.i), register_file.i)
        wiring.connect(m, register_file.o, wiring.flipped(self.o))
        wiring.connect(m, register_file.block, block_read.port)
        wiring.connect(m, register_file.put, block_write.port)
        wiring.connect(m, block_read.request, source.i)
        wiring.connect(m, source.o, block_read.i)
        wiring.connect(m, scan.o, matcher.i)
        wiring.connect(m, matcher.o, writer.i)
        wiring.connect(m, block_write.o, placer.i)
        wiring.connect(m, placer.o, stores.write)
        wiring.connect(m, scan.read, stores.scan)
        wiring.connect(m, source.read, stores.read)
        wiring.connect(m, writer.o, stores.results)
        pass_on(m, stores.outside, stores, self)
        m.d.comb += register_file.line_error.eq(self.line_error)

        settings, actions, status = register_file.settings, register_file.actions, register_file.status
        go     = Signal()
        busy   = Signal()
        kept   = Signal()
        pairs  = Signal(16)
        clocks = Signal(32, reset_less=True)
        width  = Signal.like(scan.width, reset_less=True)
        lines  = Signal.like(scan.lines, reset_less=True)
        minimum = Signal(minimum_shape(self.config), init=self.config.minimum)
        scanning = Signal()     # `go`, a cycle later
        m.d.comb += [go.eq(actions.start & ~busy & ~settings.keep), status.busy.eq(busy), status.kept.eq(kept), status.pairs.eq(pairs)]
        m.d.sync += scanning.eq(go)
        with m.If(go):
            m.d.sync += [busy.eq(1), kept.eq(0), clocks.eq(1), width.eq(settings.picture_width), lines.eq(settings.picture_height)]
            if "minimum" in self.config.settings:
                m.d.sync += minimum.eq(settings.minimum)
        with m.Elif(busy):
            m.d.sync += clocks.eq(clocks + 1)
            with m.If(writer.done):
                m.d.sync += [busy.eq(0), kept.eq(1)]
        with m.Elif(block_write.o.valid):
            m.d.sync += kept.eq(0)

        m.d.comb += [
            *(getattr(matcher, name).eq(settings[name]) for name in self.config.settings),
            matcher.apply_settings.eq(go), matcher.clear.eq(actions.clear_counters),
            *(each.start.eq(scanning) for each in (scan, writer)),
            *(each.width.eq(width) for each in (scan, writer)), *(each.lines.eq(lines) for each in (scan, writer)),
            writer.minimum.eq(minimum), block_read.kept.eq(kept),
            block_write.refuse.eq(busy | settings.keep), block_write.length.eq(settings.picture_width),
            placer.plane.eq(register_file.put.plane), placer.line.eq(register_file.put.line),
            source.width.eq(settings.picture_width), stores.busy.eq(busy),
            status.matcher_error.eq(matcher.error), Cat(status.clocks_low, status.clocks_high).eq(clocks),
        ]
        count_events(m, pairs, writer.done, actions.clear_counters)
        m.d.sync += self.leds.eq(Cat(busy, kept, matcher.error, register_file.errors.any(), pairs[:4]))
        return m

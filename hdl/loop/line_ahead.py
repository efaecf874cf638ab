"""Lines of a stored left picture and its labels, a line ahead of a monitor in another clock domain."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Member, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.side_by_side import Layout

from ..parts.crossing import EventCrossing
from ..parts.delay import NO_COLLISION
from .words import ReadPort, shown_known, shown_label


__all__ = ["LineAhead"]


class LineAhead(wiring.Component):
    """Reads each line that a monitor shows while it shows the one before. Golden: :func:`golden.video.side_by_side.side_by_side`.

    At ``display_frame`` the first line is read, and at each ``display_line`` the next one, into the half of the line buffers that is not
    shown. A line that has not been read when it is shown is wrong in this frame, and the next frame is whole again.

    Timing: :attr:`words` words are requested for a line, all at once, and all are found before the next ``display_line``; the events take
    3 cycles of ``sync``. What is shown follows ``display_column`` by a cycle of ``pixel``.

    Memory: two lines of grey levels and two of labels.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Lines of the stores.
    layout : Layout
        What is shown of them.

    Members
    -------
    display_column : In, display_frame : In(1), display_line : In(1), display_left : Out(8), display_label : Out(range(labels)),
    display_known : Out(1)
        In ``pixel``; as :class:`hdl.video.side_by_side.SideBySide` has them.
    read : Out(ReadPort(config, max_width * height))
    """
    def __init__(self, config: MatcherConfig, height: int, layout: Layout):
        self.config, self.height, self.layout = config, height, layout
        super().__init__({**self.display_members(config, layout), "read": Out(ReadPort(config, config.max_width * height))})

    @staticmethod
    def display_members(config: MatcherConfig, layout: Layout) -> dict[str, Member]:
        """Those in ``pixel``."""
        return {
            "display_column": In(range(layout.width * layout.step)), "display_frame": In(1), "display_line": In(1),
            "display_left": Out(PIXEL_BITS), "display_label": Out(range(config.labels)), "display_known": Out(1),
        }

    @property
    def words(self) -> int:
        """Of a line, both pictures together."""
        return 2 * self.layout.width

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config, step = self.config, self.layout.step
        request, found = self.read.request, self.read.found
        columns = self.layout.width * step
        last_column = columns - step

        m.submodules.events = events = EventCrossing("pixel", 2)
        m.d.comb += events.i.eq(Cat(self.display_frame, self.display_line))
        frame, line = events.o

        # The line being read, or the next one; the half that it is for.
        lines_left = Signal(range(len(self.layout.lines) + 1))
        start_of   = Signal.like(request.p.address, reset_less=True)    # address of its first pixel
        half       = Signal()
        new_frame, new_line, busy = Signal(), Signal(), Signal()
        requesting = Signal()
        column     = Signal(range(columns), reset_less=True)    # to be requested
        results    = Signal()
        place      = Signal(range(columns), reset_less=True)    # of the word that is found next
        labels     = Signal()
        m.d.comb += [
            request.valid.eq(requesting), request.p.address.eq(start_of + column), request.p.results.eq(results),
        ]
        with m.If(busy):
            with m.If(requesting & request.ready):
                m.d.sync += column.eq(column + step)
                with m.If(column == last_column):
                    m.d.sync += [column.eq(0), results.eq(1), requesting.eq(~results)]
            with m.If(self.read.valid):
                m.d.sync += place.eq(place + step)
                with m.If(place == last_column):
                    m.d.sync += [place.eq(0), labels.eq(1)]
                    with m.If(labels):
                        m.d.sync += [busy.eq(0), half.eq(~half), lines_left.eq(lines_left - 1),
                                     start_of.eq(start_of + step * config.max_width)]
        with m.Else():
            m.d.sync += [column.eq(0), results.eq(0), place.eq(0), labels.eq(0)]
            with m.If(new_frame):
                m.d.sync += [new_frame.eq(0), new_line.eq(1), lines_left.eq(len(self.layout.lines)), start_of.eq(0), half.eq(0)]
            with m.Elif(new_line):
                m.d.sync += [new_line.eq(0), busy.eq(lines_left != 0), requesting.eq(lines_left != 0)]
        with m.If(frame):
            m.d.sync += new_frame.eq(1)
        with m.If(line):
            m.d.sync += new_line.eq(1)

        # The half that is shown: line 0 is in the lower one.
        shown = Signal()
        with m.If(self.display_frame):
            m.d.pixel += shown.eq(1)
        with m.Elif(self.display_line):
            m.d.pixel += shown.eq(~shown)

        known = Cat(shown_label(found.result, config), shown_known(found.result, config))
        for name, word, enable, outputs in (
                ("left", found.left, ~labels, [self.display_left]), ("label", known, labels, [self.display_label, self.display_known])):
            m.submodules[name] = memory = Memory(shape=len(word), depth=2 << len(column), init=[], attrs=NO_COLLISION)
            writer, reader = memory.write_port(), memory.read_port(domain="pixel")
            m.d.comb += [
                writer.addr.eq(Cat(place, half)), writer.data.eq(word), writer.en.eq(self.read.valid & enable),
                reader.addr.eq(Cat(self.display_column, shown)), reader.en.eq(1), Cat(outputs).eq(reader.data),
            ]
        return m

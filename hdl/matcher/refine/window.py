"""Columns of labels for the windows of the refinement: line memories, and the control of edge replication."""

from amaranth import *
from amaranth.hdl import Mux, ShapeLike, ValueLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.matcher.confidence import WINDOW

from ...parts.delay import data_register
from ..settings import minimum_shape
from ..stream import FLAGS, LabelWord


__all__ = ["LabelColumn", "LabelColumns", "SlotWord", "VoteColumn", "column_registers", "take_column", "window_columns"]


class VoteColumn(data.StructLayout):
    """Labels of ``rows`` lines at one ``x``, from top to bottom, whether they passed, the middle one's size."""
    def __init__(self, config: MatcherConfig, rows: int = WINDOW, **further: ShapeLike):
        word = LabelWord(config)
        super().__init__({"label": data.ArrayLayout(word["label"].shape, rows), "passed": rows, "size": word["size"].shape, **further})


class LabelColumn(VoteColumn):
    """A column of labels, with the grey level of each where the refinement uses it."""
    def __init__(self, config: MatcherConfig, rows: int):
        word = LabelWord(config)
        super().__init__(config, rows, **({"grey": data.ArrayLayout(word["grey"].shape, rows)} if "grey" in word.members else {}))


class SlotWord(data.StructLayout):
    """A column of labels, with the frame flags of the pixel half a window before it, whose window it completes if ``shown``.

    ``opens``: first column of its line. ``enable`` and ``minimum`` are those of the frame.
    """
    def __init__(self, config: MatcherConfig, column: VoteColumn):
        super().__init__({"column": column, "opens": 1, "shown": 1, "enable": 1, "minimum": minimum_shape(config), **FLAGS})


def column_registers(newest: Value | data.View, size: int, name: str = "column") -> list[Signal]:
    """Registers for the last ``size`` columns, each like ``newest``; the newest first."""
    return [Signal(newest.shape(), name=f"{name}_{n}", reset_less=True) for n in range(size)]


def take_column(m: Module, window: list[Signal], newest: ValueLike, advance: ValueLike, opens: ValueLike) -> None:
    """While ``advance``, shifts a column into the registers; the one that ``opens`` a line is replicated to the left.

    After column ``x`` of a line they are the window around column ``x - len(window) // 2``.
    """
    with m.If(advance):
        for n, (column, newer) in enumerate(zip(window, [newest, *window])):
            m.d.sync += column.eq(Mux(opens, newest, newer) if 0 < n <= len(window) // 2 else newer)


def window_columns(m: Module, newest: Value | data.View, advance: ValueLike, opens: ValueLike, size: int, name: str) -> list[Signal]:
    """Registers for a window, as :func:`column_registers`, that take columns, as :func:`take_column`."""
    window = column_registers(newest, size, name)
    take_column(m, window, newest, advance, opens)
    return window


class LabelColumns(wiring.Component):
    """Turns lines of labels into columns for windows around the line half a window above the newest, with edge replication.

    The last column of a line is repeated :attr:`reach` times, and so is the last line of a frame, without waiting for the next word.
    Golden: the padding of :func:`golden.matcher.refine.median`.

    Timing: ``W + reach`` columns a line, ``H + reach`` lines a frame, one a cycle while ``go`` and ``i.valid``; a column :attr:`LATENCY`
    cycles after its label was accepted.

    Memory: ``max_width`` words of the labels of ``rows - 1`` lines, their bits ``passed`` and grey levels, and ``reach`` sizes.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    rows : int
        Lines of a column: odd, at least 5.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    enable : In(1), minimum : In(minimum_shape(config))
        Sampled as the word marked ``first`` is accepted.
    go : In(1)
        A column may be issued.
    issued : Out(1)
        A column that is ``shown`` is issued; :attr:`LATENCY` cycles later it is output.
    o : Out(SlotWord(config, LabelColumn(config, rows))), valid : Out(1)
    """
    LATENCY = 3

    def __init__(self, config: MatcherConfig, rows: int):
        self.config = config
        self.rows = rows
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "enable": In(1),
            "minimum": In(minimum_shape(config)),
            "go": In(1),
            "issued": Out(1),
            "o": Out(SlotWord(config, LabelColumn(config, rows))),
            "valid": Out(1),
        })

    @property
    def reach(self) -> int:
        """Lines above and below the middle one."""
        return self.rows // 2

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        size = self.i.p.size
        rows, reach = self.rows, self.reach

        # The column issued in this cycle.
        x       = Signal(range(config.max_width))
        width   = Signal.like(x)              # of this frame, less one
        columns = Signal(range(reach + 1), name="columns_before")   # of this line before this one; saturates
        lines   = Signal(range(reach + 1))    # of this frame before this one; saturates
        past    = Signal(range(reach + 2))    # at the end of a line: 0 within the picture, 1 at its last line, then 2, 3
        first   = Signal()                    # no column of this frame has been shown
        again   = Signal(range(reach))        # number of the column that replicates the line's last; a power of two wraps
        issue   = Signal()
        below   = Signal()
        repeats = Signal()
        closes  = Signal()                    # the line ends
        shown   = Signal()
        enable  = Signal(reset_less=True)
        minimum = Signal(minimum_shape(config), reset_less=True)
        ends    = past == reach + 1           # the frame ends with this line
        with m.FSM():
            with m.State("line"):
                m.d.comb += [self.i.ready.eq(self.go), issue.eq(self.go & self.i.valid)]
                with m.If(issue):
                    m.d.sync += x.eq(x + 1)
                    with m.If(self.i.p.first):
                        m.d.sync += [enable.eq(self.enable), minimum.eq(self.minimum), first.eq(1)]
                    with m.If(self.i.p.last):
                        m.d.sync += [width.eq(x), x.eq(0), past.eq(self.i.p.end)]
                        m.next = "repeats"
            with m.State("line below"):
                m.d.comb += [issue.eq(self.go), below.eq(1)]
                with m.If(issue):
                    m.d.sync += x.eq(x + 1)
                    with m.If(x == width):
                        m.d.sync += x.eq(0)
                        m.next = "repeats"
            with m.State("repeats"):
                m.d.comb += [issue.eq(self.go), repeats.eq(1), closes.eq(again == reach - 1)]
                with m.If(issue):
                    m.d.sync += again.eq(again + 1)
                    with m.If(closes):
                        if reach & (reach - 1):
                            m.d.sync += again.eq(0)
                        with m.If((past == 0) | ends):
                            m.next = "line"
                        with m.Else():
                            m.d.sync += past.eq(past + 1)
                            m.next = "line below"
        m.d.comb += [shown.eq((columns == reach) & (lines == reach)), self.issued.eq(issue & shown)]
        with m.If(issue):
            with m.If(shown):
                m.d.sync += first.eq(0)
            with m.If(closes):
                m.d.sync += [columns.eq(0), lines.eq(Mux(ends, 0, Mux(lines == reach, reach, lines + 1)))]
            with m.Elif(columns != reach):
                m.d.sync += columns.eq(columns + 1)

        # The memory holds the lines above the newest; below the picture its last line is replicated.
        column  = LabelColumn(config, rows)
        by_line = {name: field.shape.elem_shape for name, field in column if isinstance(field.shape, data.ArrayLayout)}
        stored  = data.StructLayout({
            **{name: data.ArrayLayout(shape, rows - 1) for name, shape in by_line.items()}, "passed": rows - 1,
            "size": data.ArrayLayout(size.shape(), reach)})
        m.submodules.memory = memory = Memory(shape=stored, depth=config.max_width, init=[])
        read = memory.read_port()
        write = memory.write_port()
        m.d.comb += read.addr.eq(x)

        s1_valid  = Signal()
        new       = Signal()
        new_x     = Signal.like(x, reset_less=True)
        new_pixel = Signal(LabelWord(config), reset_less=True)
        new_top   = Signal(reset_less=True)
        new_below = Signal(reset_less=True)
        new_slot  = Signal(SlotWord(config, column), reset_less=True)
        m.d.sync += [
            s1_valid.eq(issue), new.eq(issue & ~repeats), new_x.eq(x), new_pixel.eq(self.i.p), new_top.eq(lines == 0), new_below.eq(below),
            new_slot.opens.eq(columns == 0), new_slot.shown.eq(shown), new_slot.first.eq(first), new_slot.last.eq(closes),
            new_slot.end.eq(closes & ends),
        ]

        # A register behind the memory. The column is written back, a line higher, two cycles after it was read: another cycle later, a
        # line of one pixel reads it again.
        above    = Signal(stored, reset_less=True)
        s2_valid = Signal()
        keep     = Signal()
        x_now    = Signal.like(x, reset_less=True)
        pixel    = Signal(LabelWord(config), reset_less=True)
        top      = Signal(reset_less=True)
        is_below = Signal(reset_less=True)
        slot     = Signal(SlotWord(config, column), reset_less=True)
        m.d.sync += [
            above.eq(read.data), s2_valid.eq(s1_valid), keep.eq(new), x_now.eq(new_x), pixel.eq(new_pixel), top.eq(new_top),
            is_below.eq(new_below), slot.eq(new_slot), slot.enable.eq(enable), slot.minimum.eq(minimum),
        ]
        newest_passed = Mux(is_below, above.passed[-1], pixel.passed)
        now = Signal(column)
        for name in by_line:
            newest = Mux(is_below, above[name][-1], pixel[name])
            m.d.comb += [*(line.eq(Mux(top, newest, old)) for line, old in zip(now[name], above[name])), now[name][-1].eq(newest)]
        m.d.comb += [
            now.passed.eq(Cat(Mux(top, newest_passed.replicate(rows - 1), above.passed), newest_passed)), now.size.eq(above.size[0]),
            write.addr.eq(x_now), write.en.eq(keep), write.data.passed.eq(now.passed[1:]),
            write.data.size.eq(Cat(*above.size[1:], pixel.size)),
            *(line.eq(lower) for name in by_line for line, lower in zip(write.data[name], now[name][1:])),
        ]

        # A column that replicates the one before changes its flags only.
        word = data_register(m, self.o)
        m.d.sync += [self.valid.eq(s2_valid), word.eq(slot), word.column.eq(Mux(keep, now, word.column))]
        return m

"""Control of the rectifier's rings: rows that are stored, and lines that are output. The same for both cameras."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from golden.config import PIXEL_BITS
from golden.rig.maps import CELL, CELL_BITS, DISPLACEMENT_BITS

from .displacement import Displacement, PointStep


__all__ = ["LineReader", "RowWriter"]


class RowWriter(wiring.Component):
    """Stores the rows of frames in the rings, and makes of whatever is received rectangular frames; or copies it.

    Timing: a pixel a cycle, written a cycle after it was accepted. Between frames a cycle is lost. ``i.ready`` depends combinationally on
    ``o.ready`` where words are copied.

    Parameters
    ----------
    payload : StructLayout
        A pixel of each side and the flags.
    sides : sequence of str
    max_width, max_height, lines : int
        As of :class:`hdl.rig.rectifier.Rectifier`.

    Members
    -------
    i : In(stream.Signature(payload)), enable : In(1)
    o : Out(stream.Signature(payload))
        Words that are copied.
    full : In(1)
        All slots are in use.
    idle : In(1)
        The frame before has left.
    begin : Out(1)
        A frame begins; all slots are free.
    width : Out(range(max_width))
        Of the frame, less one.
    row_done : Out(1)
        A row has been received.
    first_row : Out(1)
        It is the first one.
    ended : Out(1)
        No more rows will be received.
    waiting : Out(1)
        A pixel waits for a slot.
    write, slot_odd, x_odd : Out(1), write_address, pixels : Out
        As of :class:`hdl.rig.ring.LineRing`; ``pixels`` of all sides.
    error : Out(1)
    """
    def __init__(self, payload: data.StructLayout, sides: tuple[str, ...], max_width: int, max_height: int, lines: int):
        self.sides = sides
        self.max_width = max_width
        self.max_height = max_height
        self.lines = lines
        self.stride = (max_width + 1) // 2
        super().__init__({
            "i": In(stream.Signature(payload)),
            "o": Out(stream.Signature(payload)),
            "enable": In(1), "full": In(1), "idle": In(1),
            "begin": Out(1), "width": Out(range(max_width)), "row_done": Out(1), "first_row": Out(1), "ended": Out(1), "waiting": Out(1),
            "write": Out(1), "slot_odd": Out(1), "x_odd": Out(1), "write_address": Out(ceil_log2(lines // 2 * self.stride)),
            "pixels": Out(data.StructLayout(dict.fromkeys(sides, PIXEL_BITS))),
            "error": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        word = self.i.p
        x       = Signal(range(self.max_width))
        row     = Signal(range(self.max_height))
        odd     = Signal()                                  # of the slot
        pair    = Signal(range(self.lines // 2))            # of slots
        start   = Signal.like(self.write_address)           # of the pair
        address = Signal.like(self.write_address)
        accepted = Signal()
        padding  = Signal()     # the line's last pixel again
        m.d.comb += self.first_row.eq(row == 0)
        m.d.sync += [self.write.eq(accepted | padding), self.slot_odd.eq(odd), self.x_odd.eq(x[0]), self.write_address.eq(address)]
        with m.If(accepted):
            m.d.sync += [self.pixels[side].eq(word[side]) for side in self.sides]
        with m.If(accepted | padding):
            m.d.sync += [x.eq(x + 1), address.eq(address + x[0])]
        with m.If(self.row_done):
            m.d.sync += [x.eq(0), row.eq(row + 1), odd.eq(~odd), address.eq(start)]
            with m.If(odd):
                wraps = pair == self.lines // 2 - 1
                following = Mux(wraps, 0, start + self.stride)
                m.d.sync += [pair.eq(Mux(wraps, 0, pair + 1)), start.eq(following), address.eq(following)]
        m.d.comb += self.o.payload.eq(word)

        # `expected`: a word without `first` is an error, as it is not the rest of a ragged frame.
        expected = Signal(init=1)
        opened   = Signal()     # a word of the frame that is copied has been accepted
        closes   = word.last | word.end
        with m.FSM():
            with m.State("between frames"):
                with m.If(self.i.valid & ~word.first):
                    m.d.comb += [self.i.ready.eq(1), self.error.eq(expected)]
                    m.d.sync += expected.eq(0)
                with m.Elif(self.i.valid & self.idle):
                    m.d.comb += self.begin.eq(1)
                    m.d.sync += [
                        x.eq(0), row.eq(0), odd.eq(0), pair.eq(0), start.eq(0), address.eq(0), self.ended.eq(0), opened.eq(0),
                    ]
                    with m.If(self.enable):
                        m.next = "row"
                    with m.Else():
                        m.next = "copy"

            with m.State("copy"):
                with m.If(self.i.valid & word.first & opened):
                    m.d.sync += expected.eq(1)
                    m.next = "between frames"
                with m.Else():
                    m.d.comb += [self.o.valid.eq(self.i.valid), self.i.ready.eq(self.o.ready)]
                    with m.If(self.i.valid):
                        m.d.sync += opened.eq(self.o.ready | opened)

            with m.State("row"):
                with m.If(self.i.valid & word.first & ~((x == 0) & (row == 0))):
                    m.d.comb += self.error.eq(1)
                    with m.If((x != 0) & (row != 0)):
                        m.next = "pad"
                    with m.Else():
                        m.d.sync += self.ended.eq(1)
                        m.next = "between frames"
                with m.Elif(self.i.valid & self.full):
                    m.d.comb += self.waiting.eq(1)
                with m.Elif(self.i.valid):
                    m.d.comb += [accepted.eq(1), self.i.ready.eq(1)]
                    m.d.sync += expected.eq(0)
                    with m.If(row == 0):
                        m.d.sync += self.width.eq(x)
                    at_end = Mux(row == 0, closes | (x == self.max_width - 1), x == self.width)
                    fault = Signal()        # of the line; too high counts too
                    high = (row == self.max_height - 1) & ~word.end
                    m.d.comb += [
                        fault.eq((closes ^ at_end) | (at_end & (~closes | high))), self.error.eq(fault | (word.end & ~word.last)),
                        self.row_done.eq(at_end & (closes | (row != 0))),
                    ]
                    with m.If(fault | word.end):
                        m.d.sync += expected.eq(word.end)
                        with m.If(at_end):
                            m.d.sync += self.ended.eq(1)
                            m.next = "between frames"
                        with m.Else():
                            m.next = "pad"

            with m.State("pad"):
                m.d.comb += [padding.eq(1), self.row_done.eq(x == self.width)]
                with m.If(x == self.width):
                    m.d.sync += self.ended.eq(1)
                    m.next = "between frames"
        return m


class LineReader(wiring.Component):
    """Walks over the lines of a picture: reads the map for :class:`hdl.rig.displacement.Displacement`, frees rows, gives pixels.

    For each line it reads the row bounds, the values at the first column of control points and the slopes to the second one; for each
    further cell the slopes, while the pixels of the cell before are output.

    Parameters
    ----------
    max_width, max_height, lines : int
        As of :class:`hdl.rig.rectifier.Rectifier`.
    words : int
        Of a map.
    sides : int

    Members
    -------
    begin : In(1)
        A frame begins: nothing is held.
    first_row : In(1)
        Its first row has been received, and the width is known.
    width : In(range(max_width))
        Less one.
    complete : In(range(lines + 1)), ended : In(1)
        Rows that are held, and whether all have been received.
    bounds : In(ArrayLayout(signed(15), sides))
    read : In(1)
        Pixels that read rows are in flight.
    abandoned : In(1)
        Rows are freed as if the map were the identity.
    address : Out(range(words)), step : Out(PointStep()), load_value, load_slope, advance : Out(1)
        To the maps.
    free : Out(1)
        The first row held is free.
    behind : Out(signed)
        The line's number less that of the first row held.
    valid : Out(1), ready : In(1), x : Out(range(max_width)), first_line, last_line, last : Out(1)
        A pixel.
    starved : Out(1)
        A line waits for rows.
    busy : Out(1)
        Lines of the frame are to be output.
    """
    STEPS = CELL_BITS + 1

    def __init__(self, max_width: int, max_height: int, lines: int, words: int, sides: int):
        self.words = words
        self.row_bits = ceil_log2(max_height) + 2
        super().__init__({
            "begin": In(1), "first_row": In(1), "width": In(range(max_width)), "complete": In(range(lines + 1)), "ended": In(1),
            "bounds": In(data.ArrayLayout(signed(DISPLACEMENT_BITS + 1), sides)), "read": In(1), "abandoned": In(1),
            "address": Out(range(words)), "step": Out(PointStep()), "load_value": Out(1), "load_slope": Out(1), "advance": Out(1),
            "free": Out(1), "behind": Out(signed(self.row_bits)),
            "valid": Out(1), "ready": In(1), "x": Out(range(max_width)), "first_line": Out(1), "last_line": Out(1), "last": Out(1),
            "starved": Out(1), "busy": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()

        # Where the map's words are.
        cells   = Signal(range((1 << len(self.width) >> CELL_BITS) + 4))    # columns of control points: the row bound is behind them
        y       = Signal(CELL_BITS)                                         # of the line in its row of cells
        upper   = Signal(range(self.words))                                 # first word of the control points above and below
        lower   = Signal(range(self.words))
        m.d.comb += cells.eq((self.width >> CELL_BITS) + 2)

        # A sum of six words, or of twelve for a slope. What is read travels with it to the maps.
        kinds = {"bound": 1, "value": 1, "slope": 1}    # in this order, for each line
        BOUND, SLOPE = 1, 4
        reading = Signal()
        kind    = Signal(data.StructLayout(kinds))
        column  = Signal(range(self.words))
        number  = Signal(range(self.STEPS))
        minus   = Signal()                      # of a slope the left column, which is subtracted
        layout  = data.StructLayout({"step": PointStep(), "last": 1, **kinds})
        issued  = Signal(layout)
        below   = Signal()
        m.d.comb += [
            below.eq(Cat(Const(0, 1), y).bit_select(number, 1)),  # bit n - 1 of y for word n, and the upper one for the first
            issued.step.valid.eq(reading), issued.step.load.eq((number == 0) & ~minus), issued.step.subtract.eq(minus),
            issued.step.shift.eq((number != 0) & (minus | ~kind.slope)),
            issued.last.eq(reading & (number == self.STEPS - 1) & (minus | ~kind.slope)),
            issued.bound.eq(kind.bound), issued.value.eq(kind.value), issued.slope.eq(kind.slope),
        ]
        m.d.sync += self.address.eq(Mux(below, lower, upper) + column + (kind.slope & ~minus))
        with m.If(reading):
            with m.If(kind.slope):
                m.d.sync += minus.eq(~minus)
            with m.If(minus | ~kind.slope):
                m.d.sync += number.eq(number + 1)
            with m.If(issued.last):
                m.d.sync += [number.eq(0), column.eq(0), kind.eq(Cat(kind.slope, kind.bound, kind.value))]
                m.d.sync += reading.eq(~kind.slope)
        travelling = [Signal(layout, name=f"travelling_{n}") for n in range(Displacement.LATENCY + 1)]
        m.d.sync += [later.eq(word) for later, word in zip(travelling, [issued, *travelling])]
        m.d.comb += self.step.eq(travelling[-1].step)
        summed = Signal(layout)
        m.d.sync += summed.eq(travelling[-1])
        have_bound, have_slope = summed.last & summed.bound, summed.last & summed.slope

        # Rows are freed up to the first one that this line or a later one reads in any picture. Then the line waits for the row below it:
        # where all rows have been received, and there is none, it is the last one.
        bounds  = Signal.like(self.bounds, reset_less=True)
        freeing = Signal()
        may_go  = Signal()
        needed  = Signal()      # the first row held is still needed
        more    = Signal()
        with m.If(have_bound):
            m.d.sync += [bounds.eq(self.bounds), freeing.eq(1)]
        above = [bound + self.behind > 0 for bound in bounds]
        all_above = above[0]
        for each in above[1:]:
            all_above = all_above & each
        m.d.comb += [
            needed.eq(Mux(self.abandoned, self.behind <= 0, ~all_above)),
            more.eq(self.behind + 1 < self.complete),
        ]
        with m.If(freeing & ~self.read):
            with m.If(~needed & (self.complete != 0)):
                m.d.comb += self.free.eq(1)
            with m.Elif((needed | self.ended) & (more | self.ended)):
                m.d.sync += [freeing.eq(0), may_go.eq(1), self.last_line.eq(~more)]
            with m.Else():
                m.d.comb += self.starved.eq(1)
        with m.If(self.free):
            m.d.sync += self.behind.eq(self.behind - 1)

        # The lines.
        ready_slope = Signal()      # the slopes of the next cell have been summed
        loaded = Signal()
        m.d.comb += [self.last.eq(self.x == self.width), self.load_value.eq(summed.last & summed.value)]
        m.d.sync += loaded.eq(self.load_value)
        with m.If(have_slope):
            m.d.sync += ready_slope.eq(1)

        def read_line():
            # What has been read of a further cell is given up.
            return [reading.eq(1), kind.eq(BOUND), column.eq(cells), number.eq(0), minus.eq(0), ready_slope.eq(0), self.x.eq(0),
                    *(word.last.eq(0) for word in (*travelling, summed))]

        def read_slope(start):
            return [reading.eq(1), kind.eq(SLOPE), column.eq(start), ready_slope.eq(0)]

        with m.FSM():
            with m.State("idle"):
                m.d.sync += [y.eq(0), self.first_line.eq(1), upper.eq(0), lower.eq(cells + 1)]
                with m.If(self.begin):
                    m.d.sync += self.behind.eq(0)
                with m.If(self.busy):
                    m.d.sync += read_line()
                    m.next = "line"
            with m.State("line"):
                m.d.comb += self.advance.eq(loaded)
                with m.If(may_go & (ready_slope | have_slope)):
                    m.d.comb += self.load_slope.eq(1)
                    m.d.sync += [may_go.eq(0), *read_slope(1)]
                    m.next = "pixels"
            with m.State("pixels"):
                m.d.comb += self.valid.eq(1)
                with m.If(self.ready):
                    m.d.comb += self.advance.eq(1)
                    m.d.sync += self.x.eq(self.x + 1)
                    with m.If(self.last):
                        m.d.sync += [self.behind.eq(self.behind + 1), y.eq(y + 1), self.first_line.eq(0), *read_line()]
                        with m.If(y == CELL - 1):
                            m.d.sync += [upper.eq(lower), lower.eq(lower + cells + 1)]
                        m.next = "line"
                        with m.If(self.last_line):
                            m.d.sync += [self.busy.eq(0), reading.eq(0)]
                            m.next = "idle"
                    with m.Elif(self.x[:CELL_BITS] == CELL - 1):
                        m.d.comb += self.load_slope.eq(1)
                        m.d.sync += read_slope((self.x >> CELL_BITS) + 2)
        with m.If(self.first_row):
            m.d.sync += self.busy.eq(1)
        return m

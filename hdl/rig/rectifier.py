"""The rectifier: pictures of one camera or both, resampled by a map, a pixel a clock."""

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import and_
from types import MappingProxyType

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from golden.config import PIXEL_BITS
from golden.rig.lines import DEFAULT_LINES, LINES
from golden.rig.maps import DISPLACEMENT_BITS, GAIN_BITS, SIZES, WORD_BITS, identity, pack, word_count

from ..matcher.stream import FLAGS
from ..parts.counters import count_events
from ..parts.delay import Delay
from ..parts.queue import Queue
from .displacement import Displacement
from .ring import LineRing, Weights
from .rows import LineReader, RowWriter


__all__ = ["BOTH", "Rectifier"]


#: The cameras of a pair, as :class:`hdl.matcher.stream.PixelPair` names them.
BOTH = ("left", "right")

_NO_MAPS: Mapping[str, Sequence[int]] = MappingProxyType({})


class Rectifier(wiring.Component):
    """Resamples the pictures of both cameras, each by its map. With ``enable`` low, an exact copy.

    Golden: :func:`golden.rig.rectify.rectify` for each side; the maps must pass :func:`golden.rig.lines.check_lines`, together.

    The lines of both pictures are received together, so their rings advance together: a row is free when no line that follows reads it in
    either camera. A line is output once its last row, and the row below itself, have been received; the last lines of a picture follow
    without waiting for the next one. Then the next picture is accepted.

    Frames: the first line sets the width. Frames at ``o`` are rectangular and closed by ``end``. A ragged frame raises ``error`` for one
    cycle, is cut after the faulty line, padded with its last pixel if it was short, and dropped from there to the next ``first``. Ragged is
    what it is to :class:`hdl.matcher.lines.LineStore`, and a frame of more than ``max_height`` lines. With ``enable`` low all words from
    the first ``first`` on are copied, whatever their flags.

    If a map needs more lines than there are, neither the next row can be stored nor the next pixel read: ``fault`` is raised until
    ``clear``, ``abandoned`` counts, and the rest of the picture is black. The next one is exact, if its map is good. A map for another size
    gives an undefined picture of the right size.

    Maps: each side has two. ``map_write`` writes a word of the one that is not in use; ``swap`` makes it the one in use from the next
    ``first`` on, until when ``swapping`` is high, and no word must be written.

    Timing: a pixel a cycle; a line takes :attr:`line_clocks` cycles more. A picture's first pixel is valid :attr:`latency` cycles after the
    last one that its line needs was accepted, on lines of :attr:`line_clocks` pixels or more. ``i.ready`` does not depend on ``o.ready``.

    Memory: each side the ring and two maps, see :class:`LineRing` and :class:`Displacement`; a queue of words.

    Parameters
    ----------
    max_width, max_height : int
        Of a picture, pixels.
    lines : int
        Of each ring; one of :data:`golden.rig.lines.LINES`.
    sides : tuple of str
        Cameras whose pixels the payloads have: with :data:`BOTH` payloads are :class:`hdl.matcher.stream.PixelPair`.
    maps : mapping of str to sequence of int
        Words of :func:`golden.rig.maps.pack` that a side has after configuration; by default those of the identity at full size.

    Members
    -------
    i, o : streams of a pixel of each side and the flags
    enable : In(1)
        Sampled with ``first``.
    map_write : In(len(sides)), map_address : In(range(words)), map_data : In(36)
        A bit for each side.
    swap : In(1), swapping : Out(1)
    error : Out(1)
    fault : Out(1), abandoned : Out(8), clear : In(1)
    """
    QUEUE = 32

    def __init__(self, max_width: int, max_height: int, lines: int = DEFAULT_LINES, *, sides: Sequence[str] = BOTH,
                 maps: Mapping[str, Sequence[int]] = _NO_MAPS):
        for name, value in (("max_width", max_width), ("max_height", max_height)):
            if value not in SIZES:
                raise ValueError(f"{name} of a rectifier must be from {SIZES[0]} to {SIZES[-1]}, not {value!r}")
        if lines not in LINES:
            raise ValueError(f"a rectifier can hold {', '.join(map(str, LINES))} lines, not {lines!r}")
        self.max_width = max_width
        self.max_height = max_height
        self.lines = lines
        self.sides = tuple(sides)
        self.words = 1 << ceil_log2(word_count(max_width, max_height))
        self.maps = maps
        self.payload = data.StructLayout({**dict.fromkeys(self.sides, PIXEL_BITS), **FLAGS})
        shapes: dict[str, ShapeLike] = {"map_write": len(self.sides), "map_address": range(self.words), "map_data": WORD_BITS}
        super().__init__({
            "i": In(stream.Signature(self.payload)),
            "o": Out(stream.Signature(self.payload)),
            "enable": In(1),
            **{name: In(shape) for name, shape in shapes.items()},
            "swap": In(1),
            "swapping": Out(1),
            "error": Out(1),
            "fault": Out(1),
            "abandoned": Out(8),
            "clear": In(1),
        })

    #: Cycles of a line beyond its pixels: six words for the row bound, six for the first column, twelve for the first slope, and the
    #: cycles in between.
    line_clocks = 28
    #: Cycles from the last pixel that the first one of a line waits for, where the line before has left.
    latency = 24

    def elaborate(self, platform: object) -> Module:
        m = Module()
        lines = self.lines
        maps: dict[str, Displacement] = {}
        rings: dict[str, LineRing] = {}
        for side in self.sides:
            words = self.maps.get(side) or pack(identity(self.max_width, self.max_height))
            m.submodules[f"{side}_map"] = maps[side] = Displacement(self.words, words)
            m.submodules[f"{side}_ring"] = rings[side] = LineRing(self.max_width, lines)
        m.submodules.queue = queue = Queue(self.payload, self.QUEUE)
        wiring.connect(m, queue.o, wiring.flipped(self.o))

        # Rows in, lines out.
        m.submodules.writer = writer = RowWriter(self.payload, self.sides, self.max_width, self.max_height, lines)
        m.submodules.reader = reader = LineReader(self.max_width, self.max_height, lines, self.words, len(self.sides))
        wiring.connect(m, wiring.flipped(self.i), writer.i)

        # The maps. Which of two is in use changes between frames.
        bank = Signal(reset_less=True)      # a reset does not restore what the memories held after configuration
        m.d.comb += writer.enable.eq(self.enable)
        with m.If(self.swap):
            m.d.sync += self.swapping.eq(1)
        with m.Elif(writer.begin):
            m.d.sync += self.swapping.eq(0)
        with m.If(writer.begin & self.swapping):
            m.d.sync += bank.eq(~bank)
        for number, side in enumerate(self.sides):
            each = maps[side]
            m.d.comb += [
                each.write.eq(self.map_write[number]), each.write_address.eq(Cat(self.map_address, ~bank)),
                each.write_data.eq(self.map_data), each.address.eq(Cat(reader.address, bank)), reader.bounds[number].eq(each.bound),
                *(getattr(each, name).eq(getattr(reader, name)) for name in ("step", "load_value", "load_slope", "advance")),
            ]

        # Rows that are held, in all rings alike.
        complete = Signal(range(lines + 1))
        first    = Signal(range(lines))     # slot of the first one
        wrap     = Signal(range(-lines, 0))                 # the same less the number of slots, a cycle late
        m.d.sync += wrap.eq(first - lines)
        gone     = Signal()                 # the rest of the picture is black
        with m.If(writer.begin):
            m.d.sync += [complete.eq(0), first.eq(0), gone.eq(0)]
        with m.Else():
            m.d.sync += complete.eq(complete + writer.row_done - reader.free)
            with m.If(reader.free):
                m.d.sync += first.eq(Mux(first == lines - 1, 0, first + 1))
        m.d.comb += [
            writer.full.eq(complete == lines), self.error.eq(writer.error), reader.begin.eq(writer.begin),
            reader.first_row.eq(writer.row_done & writer.first_row), reader.width.eq(writer.width), reader.complete.eq(complete),
            reader.ended.eq(writer.ended), reader.abandoned.eq(gone),
        ]
        for side in self.sides:
            m.d.comb += [
                *(getattr(rings[side], name).eq(getattr(writer, name)) for name in ("write", "slot_odd", "x_odd", "write_address")),
                rings[side].pixel.eq(writer.pixels[side]), rings[side].first.eq(first), rings[side].wrap.eq(wrap),
            ]

        # Places in the picture, then limited to it. Rows count from the first one held: it is row 0 where a place is above the picture.
        # Weights, gains and flags follow through memories.
        flags, parts_of = data.StructLayout(FLAGS), {"wx": 6, "wy": 6, "gain": GAIN_BITS + 2}
        m.submodules.weight_delay = weight_delay = Delay(data.ArrayLayout(Weights(), len(self.sides)), LineRing.WEIGHTED + 1)
        gains = data.ArrayLayout(GAIN_BITS + 2, len(self.sides))
        m.submodules.gain_delay = gain_delay = Delay(data.StructLayout({"gains": gains, "flags": flags}), LineRing.GAINED + 1)
        placed_valid, limited_valid = Signal(), Signal()
        placed_flags, limited_flags = Signal(flags, reset_less=True), Signal(flags, reset_less=True)
        go, issue, space, received = Signal(), Signal(), Signal(), Signal()
        m.d.comb += reader.ready.eq(~placed_valid | go)
        with m.If(reader.ready):
            m.d.sync += [
                placed_valid.eq(reader.valid), placed_flags.last.eq(reader.last),
                placed_flags.first.eq(reader.first_line & (reader.x == 0)), placed_flags.end.eq(reader.last & reader.last_line),
            ]
        m.d.comb += go.eq(~limited_valid | issue)
        with m.If(go):
            m.d.sync += [limited_valid.eq(placed_valid), limited_flags.eq(placed_flags)]
        here = []
        row_bits = lines.bit_length()       # of rows that count from the first one held: the greatest is not held
        top = Signal(range(-1, lines))      # the last one held
        # At the right and lower edges the last column and row have all the weight: those beyond are not read.
        left_of_last  = Signal.like(writer.width)
        above_last    = Signal(range(lines))
        m.d.comb += [
            top.eq(complete - 1), above_last.eq(Mux(top > 0, top - 1, 0)),
        ]
        m.d.sync += left_of_last.eq(writer.width - (writer.width != 0))
        for number, side in enumerate(self.sides):
            dx, dy = maps[side].dx, maps[side].dy
            x     = Signal(signed(max(len(reader.x), DISPLACEMENT_BITS - 5) + 2), name=f"{side}_x", reset_less=True)
            row   = Signal(signed(len(reader.behind) + 1), name=f"{side}_row", reset_less=True)
            parts = Signal(data.StructLayout(parts_of), name=f"{side}_parts", reset_less=True)
            with m.If(reader.ready):
                m.d.sync += [
                    x.eq((dx >> 5) + reader.x), row.eq((dy >> 5) + reader.behind), parts.wx.eq(dx[:5]), parts.wy.eq(dy[:5]),
                    parts.gain.eq(maps[side].gain),
                ]
            limited = Signal(data.StructLayout({"x": range(self.max_width), "row": row_bits, **parts_of}), name=f"{side}_limited",
                             reset_less=True)
            with m.If(go):
                m.d.sync += [limited[field].eq(parts[field]) for field in parts_of]
                m.d.sync += [limited.x.eq(x), limited.row.eq(row)]
                with m.If(x < 0):
                    m.d.sync += [limited.x.eq(0), limited.wx.eq(0)]
                with m.Elif(x >= writer.width):
                    m.d.sync += [limited.x.eq(left_of_last), limited.wx.eq(Mux(writer.width == 0, 0, 32))]
                with m.If(row < 0):
                    m.d.sync += [limited.row.eq(0), limited.wy.eq(0)]
                with m.Elif(row[row_bits:].any()):
                    m.d.sync += limited.row.eq(~0)
            # The picture's last row is the last one held, once all have been received.
            final = Signal(name=f"{side}_final")
            m.d.comb += final.eq(limited.row >= top)
            here.append(~final)
            source = Signal(data.StructLayout({"x": range(self.max_width), "row": range(lines)}), name=f"{side}_source", reset_less=True)
            weights, gain = weight_delay.i[number], gain_delay.i.gains[number]
            m.d.sync += [source.x.eq(limited.x), source.row.eq(Mux(final, above_last, limited.row))]
            m.d.comb += [
                rings[side].x.eq(source.x), rings[side].row.eq(source.row),
                weights.wx.eq(limited.wx), weights.x_odd.eq(limited.x[0]), weights.wy.eq(Mux(final, Mux(top > 0, 32, 0), limited.wy)),
                rings[side].weights.eq(weight_delay.o[number]), gain.eq(Mux(gone, 0, limited.gain)),
                rings[side].gain.eq(gain_delay.o.gains[number]),
            ]
        m.d.comb += [received.eq(writer.ended | gone | reduce(and_, here)), issue.eq(limited_valid & received & space)]

        # What follows never stalls: a pixel is issued if the queue has room for all in flight.
        stages = LineRing.LATENCY + 1
        valid  = Signal(stages)
        used   = Signal(range(self.QUEUE + 1))
        m.d.sync += valid.eq(Cat(issue, valid))
        m.d.sync += used.eq(used + (issue | (writer.o.valid & writer.o.ready)) - (self.o.valid & self.o.ready))
        m.d.comb += [
            space.eq(used != self.QUEUE), writer.idle.eq(~reader.busy & ~placed_valid & ~limited_valid & ~valid.any()),
            reader.read.eq(placed_valid | limited_valid | valid[:LineRing.READ].any()),
        ]
        m.submodules.flag_delay = flag_delay = Delay(flags, LineRing.LATENCY - LineRing.GAINED)
        m.d.comb += [gain_delay.i.flags.eq(limited_flags), flag_delay.i.eq(gain_delay.o.flags)]
        m.d.comb += [queue.i.valid.eq(valid[-1] | writer.o.valid), writer.o.ready.eq(queue.i.ready)]
        with m.If(valid[-1]):
            m.d.comb += [queue.i.p[name].eq(flag_delay.o[name]) for name in FLAGS]
            m.d.comb += [queue.i.p[side].eq(rings[side].o) for side in self.sides]
        with m.Else():
            m.d.comb += queue.i.payload.eq(writer.o.payload)

        # Neither a row can be stored nor a line read.
        stopped = Signal()
        m.d.comb += stopped.eq(writer.waiting & ((limited_valid & ~received) | reader.starved) & ~gone)
        with m.If(self.clear):
            m.d.sync += self.fault.eq(0)
        with m.If(stopped):
            m.d.sync += [gone.eq(1), self.fault.eq(1)]
        count_events(m, self.abandoned, stopped, self.clear)
        return m

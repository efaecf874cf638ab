"""Photometric balance: the right picture is given the left one's mean and contrast."""

import enum

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, PIXEL_MAX
from golden.rig.balance import GAIN_ONE, GAINS, LEAST_DEVIATION, OFFSETS

from ..matcher.stream import PixelPair, copy_flags
from ..parts.delay import NO_COLLISION, data_register
from .contrast import MEAN_BITS, Contrast


__all__ = ["Balance", "BalanceMode"]


class BalanceMode(enum.IntEnum):
    """What the right picture's gain and offset are."""
    OFF, AUTO, FIXED = range(3)


class Balance(wiring.Component):
    """Gives the right picture a gain and an offset, by a table; with the mode *auto* those of :class:`golden.rig.balance.Auto`.

    Each pair is measured as it passes. Where a frame's size is not the one told, or it has no ``end``, what was measured of it is
    discarded. The mode *auto* starts anew after a frame with another one. Frames of any flags pass; *off* is an exact copy.

    Timing: latency :attr:`latency` cycles, a pixel a cycle, but a frame's first pixel waits for :attr:`frame_clocks` cycles, for the table,
    and, from the end of the frame before, for what was measured of it. ``i.ready`` depends combinationally on ``o.ready``.

    Memory: the table, 256 words of 8 bits.

    Parameters
    ----------
    max_width, max_height : int
        Pixels.
    labels : int
        Disparities.

    Members
    -------
    i, o : streams of PixelPair
    mode : In(BalanceMode), fixed_gain : In(10), fixed_offset : In(signed(16))
        Sampled as the word marked ``first`` is offered, as all other settings. A gain of 256 is 1, the offset is in 1/256 grey level.
    width : In(range(max_width + 1)), height : In(range(max_height + 1)), minimum : In(signed(9))
        Of the pictures, and the least disparity.
    left_mean, right_mean, left_deviation, right_deviation : Out(12)
        Of the last pair that was measured, 1/16 grey level; deviations from the means of the pair before it.
    gain : Out(10), offset : Out(signed(16))
        That are applied; from the end of a pair on those of the next one, if it is *auto*.
    """
    latency = 2
    #: Cycles of the table.
    frame_clocks = PIXEL_MAX + 3
    #: Bound of the cycles from the end of a pair to the table for the next one.
    evaluation_clocks = 200
    SMOOTH, SMOOTH_BITS = 3, 4

    def __init__(self, max_width: int, max_height: int, labels: int):
        self.contrast = Contrast(max_width, max_height, labels)
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(PixelPair())),
            "mode": In(BalanceMode), "fixed_gain": In(10), "fixed_offset": In(signed(16)),
            "width": In(range(max_width + 1)), "height": In(range(max_height + 1)), "minimum": In(signed(9)),
            **{name: Out(MEAN_BITS) for name in ("left_mean", "right_mean", "left_deviation", "right_deviation")},
            "gain": Out(10), "offset": Out(signed(16)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.contrast = contrast = self.contrast
        m.submodules.table = table = Memory(shape=PIXEL_BITS, depth=PIXEL_MAX + 1, init=[], attrs=NO_COLLISION)
        read, write = table.read_port(), table.write_port()
        advance, accepted, opened = Signal(), Signal(), Signal()
        m.d.comb += [
            advance.eq(~self.o.valid | self.o.ready), accepted.eq(self.i.valid & self.i.ready),
            *(getattr(contrast, name).eq(getattr(self, name)) for name in ("width", "height", "minimum")),
            *(getattr(self, name).eq(getattr(contrast, name)) for name in ("left_mean", "right_mean", "left_deviation", "right_deviation")),
            contrast.valid.eq(accepted), contrast.pixel.eq(self.i.p),
        ]

        # The pixels. A frame's first one waits for the table.
        s1_valid = Signal()
        s1       = Signal(PixelPair(), reset_less=True)
        payload  = data_register(m, self.o.payload)
        m.d.comb += contrast.previous.eq(s1)
        m.d.comb += [read.addr.eq(self.i.p.right), read.en.eq(advance), self.i.ready.eq(advance & (opened | ~self.i.p.first))]
        with m.If(advance):
            m.d.sync += [
                s1_valid.eq(accepted), s1.eq(self.i.p), self.o.valid.eq(s1_valid),
                payload.left.eq(s1.left), payload.right.eq(read.data), *copy_flags(payload, s1),
            ]
        with m.If(accepted):
            m.d.sync += opened.eq(0)

        # Gain and offset with more bits, rounded where they are applied; whether they were measured, and means are known.
        half = 1 << self.SMOOTH_BITS >> 1
        gain   = Signal(10 + self.SMOOTH_BITS, init=GAIN_ONE << self.SMOOTH_BITS)
        offset = Signal(signed(16 + self.SMOOTH_BITS))
        known  = Signal()
        means  = Signal()
        auto   = Signal()
        m.d.comb += [self.gain.eq((gain + half) >> self.SMOOTH_BITS), self.offset.eq((offset + half) >> self.SMOOTH_BITS)]

        # The gain is a quotient, from its highest bit on; then it is multiplied by the mean, bit by bit.
        dividend = Signal(MEAN_BITS + 8)
        rest     = Signal(MEAN_BITS)
        product  = Signal(MEAN_BITS + 10)
        count    = Signal(PIXEL_BITS)       # of steps, and of the table's words
        tried    = Signal(MEAN_BITS + 1)
        fits     = Signal()
        m.d.comb += [tried.eq(Cat(dividend[-1], rest)), fits.eq(tried >= self.right_deviation)]
        wanted = Signal(10)         # of the gain
        wanted_offset = Signal(signed(MEAN_BITS + 8))
        limited_offset = Signal(signed(16))
        m.d.comb += wanted_offset.eq((self.left_mean << 4) - (product >> 4))
        # The limits are powers of two.
        places = OFFSETS[-1].bit_length() - 1
        with m.If(~wanted_offset[-1] & wanted_offset[places:].any()):
            m.d.comb += limited_offset.eq(OFFSETS[-1])
        with m.Elif(wanted_offset[-1] & ~wanted_offset[places:].all()):
            m.d.comb += limited_offset.eq(OFFSETS[0])
        with m.Else():
            m.d.comb += limited_offset.eq(wanted_offset)

        value  = Signal(signed(20))
        result = Signal(signed(12))
        m.d.comb += [result.eq(value >> 8), write.addr.eq(count)]
        above, below = result[PIXEL_BITS:].any(), result[-1]
        m.d.comb += write.data.eq(Mux(below, 0, Mux(above, PIXEL_MAX, result)))
        with m.FSM():
            with m.State("pixels"):
                with m.If(contrast.measured):
                    m.d.sync += means.eq(auto)
                    m.d.sync += [dividend.eq((self.left_deviation << 8) + (self.right_deviation >> 1)), rest.eq(0), count.eq(0)]
                    with m.If(auto & means & (self.right_deviation >= LEAST_DEVIATION)):
                        m.next = "divide"
                with m.Elif(self.i.valid & self.i.p.first & ~opened & ~contrast.busy):
                    m.d.comb += contrast.begin.eq(1)
                    m.d.sync += auto.eq(self.mode == BalanceMode.AUTO)
                    with m.If(self.mode != BalanceMode.AUTO):
                        fixed = self.mode == BalanceMode.FIXED
                        m.d.sync += [
                            gain.eq(Mux(fixed, self.fixed_gain, GAIN_ONE) << self.SMOOTH_BITS),
                            offset.eq(Mux(fixed, self.fixed_offset, 0) << self.SMOOTH_BITS), known.eq(0), means.eq(0),
                        ]
                    with m.Elif(~auto):
                        m.d.sync += [gain.eq(GAIN_ONE << self.SMOOTH_BITS), offset.eq(0)]
                    m.next = "table"

            with m.State("divide"):
                m.d.sync += [
                    dividend.eq(Cat(fits, dividend)), rest.eq(Mux(fits, tried - self.right_deviation, tried)), count.eq(count + 1),
                ]
                with m.If(count == len(dividend) - 1):
                    m.next = "limit"
            with m.State("limit"):
                least, most = (limit.bit_length() - 1 for limit in (GAINS[0], GAINS[-1]))   # powers of two
                m.d.sync += [count.eq(0), product.eq(0)]
                m.d.sync += wanted.eq(Mux(dividend[least:].any(), Mux(dividend[most:].any(), GAINS[-1], dividend), GAINS[0]))
                m.next = "multiply"
            with m.State("multiply"):
                m.d.sync += [product.eq((product << 1) + Mux(wanted[-1], self.right_mean, 0)), wanted.eq(wanted.rotate_left(1)),
                             count.eq(count + 1)]
                with m.If(count == len(wanted) - 1):
                    m.next = "smooth"
            with m.State("smooth"):
                goal, offset_goal = wanted << self.SMOOTH_BITS, limited_offset << self.SMOOTH_BITS
                m.d.sync += known.eq(1)
                with m.If(known):
                    m.d.sync += gain.eq(gain + ((goal - gain) >> self.SMOOTH))
                    m.d.sync += offset.eq(offset + ((offset_goal - offset) >> self.SMOOTH))
                with m.Else():
                    m.d.sync += [gain.eq(goal), offset.eq(offset_goal)]
                m.next = "pixels"

            with m.State("table"):
                m.d.sync += [value.eq(self.offset + 128), count.eq(0)]
                m.next = "fill"
            with m.State("fill"):
                m.d.comb += write.en.eq(1)
                m.d.sync += [value.eq(value + self.gain), count.eq(count + 1)]
                with m.If(count == PIXEL_MAX):
                    m.d.sync += opened.eq(1)
                    m.next = "pixels"
        return m

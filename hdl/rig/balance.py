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
        That are applied.
    """
    latency = 2
    #: Cycles of the table.
    frame_clocks = PIXEL_MAX + 3
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
        m.d.comb += [read.addr.eq(self.i.p.right), read.en.eq(advance), self.i.ready.eq(advance & (opened | ~self.i.p.first))]
        with m.If(advance):
            m.d.sync += [
                s1_valid.eq(accepted), s1.eq(self.i.p), self.o.valid.eq(s1_valid),
                payload.left.eq(s1.left), payload.right.eq(read.data), *copy_flags(payload, s1),
            ]
        with m.If(accepted):
            m.d.sync += opened.eq(0)

        # Gain and offset that were measured, with more bits, and whether they are known; whether means are.
        gain   = Signal(range((GAINS[-1] << self.SMOOTH_BITS) + 1))
        offset = Signal(range(OFFSETS[0] << self.SMOOTH_BITS, (OFFSETS[-1] << self.SMOOTH_BITS) + 1))
        known  = Signal()
        means  = Signal()
        auto   = Signal()

        # The gain is a quotient, from its highest bit on; then it is multiplied by the mean, bit by bit.
        dividend = Signal(MEAN_BITS + 8)
        rest     = Signal(MEAN_BITS)
        product  = Signal(MEAN_BITS + 10)
        steps    = Signal(range(MEAN_BITS + 9))
        tried    = Signal(MEAN_BITS + 1)
        fits     = Signal()
        m.d.comb += [tried.eq(Cat(dividend[-1], rest)), fits.eq(tried >= self.right_deviation)]
        wanted = Signal(10)         # of the gain
        wanted_offset = Signal(signed(MEAN_BITS + 8))
        limited_offset = Signal(signed(16))
        m.d.comb += wanted_offset.eq((self.left_mean << 4) - (product >> 4))
        with m.If(wanted_offset > OFFSETS[-1]):
            m.d.comb += limited_offset.eq(OFFSETS[-1])
        with m.Elif(wanted_offset < OFFSETS[0]):
            m.d.comb += limited_offset.eq(OFFSETS[0])
        with m.Else():
            m.d.comb += limited_offset.eq(wanted_offset)

        level  = Signal(PIXEL_BITS)
        value  = Signal(signed(20))
        result = Signal(signed(12))
        m.d.comb += [result.eq(value >> 8), write.addr.eq(level)]
        m.d.comb += write.data.eq(Mux(result < 0, 0, Mux(result > PIXEL_MAX, PIXEL_MAX, result)))
        with m.FSM():
            with m.State("pixels"):
                with m.If(contrast.measured):
                    m.d.sync += means.eq(auto)
                    m.d.sync += [dividend.eq((self.left_deviation << 8) + (self.right_deviation >> 1)), rest.eq(0), steps.eq(0)]
                    with m.If(auto & means & (self.right_deviation >= LEAST_DEVIATION)):
                        m.next = "divide"
                with m.Elif(self.i.valid & self.i.p.first & ~opened & ~contrast.busy):
                    m.d.comb += contrast.begin.eq(1)
                    m.d.sync += auto.eq(self.mode == BalanceMode.AUTO)
                    with m.If(self.mode == BalanceMode.AUTO):
                        half = 1 << self.SMOOTH_BITS >> 1
                        m.d.sync += [
                            self.gain.eq(Mux(known, (gain + half) >> self.SMOOTH_BITS, GAIN_ONE)),
                            self.offset.eq(Mux(known, (offset + half) >> self.SMOOTH_BITS, 0)),
                        ]
                    with m.Else():
                        fixed = self.mode == BalanceMode.FIXED
                        m.d.sync += [
                            self.gain.eq(Mux(fixed, self.fixed_gain, GAIN_ONE)), self.offset.eq(Mux(fixed, self.fixed_offset, 0)),
                            known.eq(0), means.eq(0),
                        ]
                    m.next = "table"

            with m.State("divide"):
                m.d.sync += [
                    dividend.eq(Cat(fits, dividend)), rest.eq(Mux(fits, tried - self.right_deviation, tried)), steps.eq(steps + 1),
                ]
                with m.If(steps == len(dividend) - 1):
                    m.next = "limit"
            with m.State("limit"):
                m.d.sync += [steps.eq(0), product.eq(0)]
                m.d.sync += wanted.eq(Mux(dividend > GAINS[-1], GAINS[-1], Mux(dividend < GAINS[0], GAINS[0], dividend)))
                m.next = "multiply"
            with m.State("multiply"):
                m.d.sync += [product.eq((product << 1) + Mux(wanted[-1], self.right_mean, 0)), wanted.eq(wanted.rotate_left(1)),
                             steps.eq(steps + 1)]
                with m.If(steps == len(wanted) - 1):
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
                m.d.sync += [value.eq(self.offset + 128), level.eq(0)]
                m.next = "fill"
            with m.State("fill"):
                m.d.comb += write.en.eq(1)
                m.d.sync += [value.eq(value + self.gain), level.eq(level + 1)]
                with m.If(level == PIXEL_MAX):
                    m.d.sync += opened.eq(1)
                    m.next = "pixels"
        return m

"""Mean and mean deviation of both pictures, in windows that see the same scene."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS

from ..matcher.stream import PixelPair
from ..parts.arithmetic import add_with_carry, bit_length, choose


__all__ = ["MEAN_BITS", "Contrast"]


#: Of a mean or a deviation, 1/16 grey level.
MEAN_BITS = PIXEL_BITS + 4


def _without_highest(value: Value) -> Value:
    """A number less the largest power of two in it."""
    bits = len(value)
    return Cat(value[n] & value[n + 1:].any() for n in range(bits - 1)) if bits > 1 else Const(0, 1)


def _below_highest(value: Value) -> Value:
    """Ones in all places below the highest one of a number, as wide as it."""
    return Cat(*(value[n + 1:].any() for n in range(len(value) - 1)), 0)


class Contrast(wiring.Component):
    """Measures a pair as it passes.

    Golden: :func:`golden.rig.balance.windows`, and :func:`golden.rig.balance.measure` with the pair before.

    Timing: the windows are there 3 cycles after ``begin``. ``busy`` from the pixel marked ``end`` until ``measured``, if the picture had
    the size told; that takes ``4 n + 15`` cycles at most, with windows of ``2**n`` pixels in the largest picture.

    Parameters
    ----------
    max_width, max_height : int
    labels : int

    Members
    -------
    width : In(range(max_width + 1)), height : In(range(max_height + 1)), minimum : In(signed(9))
        Sampled with ``begin``.
    begin : In(1)
    valid : In(1), pixel : In(PixelPair()), previous : In(PixelPair())
        ``previous`` is the pixel that was valid in the cycle before.
    busy : Out(1)
    measured : Out(1)
        For one cycle; results hold from then on.
    left_mean, right_mean, left_deviation, right_deviation : Out(12)
    """
    def __init__(self, max_width: int, max_height: int, labels: int):
        self.max_width = max_width
        self.max_height = max_height
        self.labels = labels
        super().__init__({
            "width": In(range(max_width + 1)), "height": In(range(max_height + 1)), "minimum": In(signed(9)),
            "begin": In(1), "valid": In(1), "pixel": In(PixelPair()), "previous": In(PixelPair()),
            "busy": Out(1), "measured": Out(1),
            **{name: Out(MEAN_BITS) for name in ("left_mean", "right_mean", "left_deviation", "right_deviation")},
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        most = self.max_width.bit_length() + self.max_height.bit_length()
        most_n = most - 2

        # The windows: the largest powers of two, in the middle, and apart by the middle disparity.
        width, height = Signal.like(self.width), Signal.like(self.height)
        beside = Signal.like(self.width)        # columns beside a window, on both sides
        above  = Signal.like(self.height)
        apart  = Signal(signed(12))
        start  = Signal.like(beside)
        left   = Signal.like(width)
        right  = Signal.like(width)
        shifts = Signal(range(most + 1))        # by which sums are less than those of the largest windows
        begun  = Signal(2)

        def within(value):
            return Mux(value < 0, 0, Mux(value > beside, beside, value))

        m.d.sync += begun.eq(Cat(self.begin, begun))
        with m.If(self.begin):
            m.d.sync += [width.eq(self.width), height.eq(self.height), apart.eq(self.minimum + self.labels // 2)]
        m.d.comb += [beside.eq(_without_highest(width)), above.eq(_without_highest(height)), start.eq(beside >> 1)]
        m.d.sync += shifts.eq(most - bit_length(width) - bit_length(height))
        with m.If(begun[0]):
            m.d.sync += left.eq(within(start + ((apart + 1) >> 1)))
        with m.If(begun[1]):
            m.d.sync += right.eq(within(left - apart))

        # Places of the pixels, counted from 1.
        x, y = Signal.like(width), Signal.like(height)
        with m.If(self.begin):
            m.d.sync += [x.eq(1), y.eq(1)]
        with m.Elif(self.valid):
            m.d.sync += x.eq(x + 1)
            with m.If(self.pixel.last | self.pixel.end):
                m.d.sync += [x.eq(1), y.eq(y + 1)]
        ends = Signal()
        whole = Signal()    # so far each line had the right width
        m.d.comb += ends.eq(x == width)
        with m.If(self.begin):
            m.d.sync += whole.eq(1)
        with m.Elif(self.valid & (self.pixel.last != ends)):
            m.d.sync += whole.eq(0)

        # Sums: levels a cycle after the pixel, distances from the last means another one later.
        means = {"left": Signal(MEAN_BITS, name="left_mean_of_sum"), "right": Signal(MEAN_BITS, name="right_mean_of_sum")}
        sums = []
        top = Signal.like(height)
        m.d.comb += top.eq(above >> 1)
        inside_rows = ~((y + ~top)[:len(y)] & ~_below_highest(height)).any()
        for side, window in (("left", left), ("right", right)):
            inside   = Signal(name=f"{side}_inside")
            level    = self.previous[side]
            measured = Signal(name=f"{side}_measured")
            distance = Signal(signed(MEAN_BITS + 1), name=f"{side}_distance", reset_less=True)
            total    = Signal(most_n + PIXEL_BITS, name=f"{side}_sum")
            far      = Signal(most_n + MEAN_BITS, name=f"{side}_far")
            m.d.sync += [
                inside.eq(self.valid & inside_rows & ~((x + ~window)[:len(x)] & ~_below_highest(width)).any()),
                measured.eq(inside), distance.eq((level << 4) - means[side]),
            ]
            with m.If(self.begin):
                m.d.sync += [total.eq(0), far.eq(0)]
            with m.Else():
                with m.If(inside):
                    m.d.sync += total.eq(total + level)
                with m.If(measured):
                    below = distance[-1]
                    m.d.sync += far.eq(add_with_carry(far, distance[:MEAN_BITS] ^ below.replicate(MEAN_BITS), below))
            sums.append((total << 4, far))
            m.d.comb += getattr(self, f"{side}_mean").eq(means[side])

        # One after the other is shifted as if its window were the largest: its highest bits are the mean.
        work   = Signal(most_n + MEAN_BITS)
        number = Signal(2)
        count  = Signal.like(shifts)
        settle = Signal(2)
        results = [means["left"], self.left_deviation, means["right"], self.right_deviation]
        with m.FSM() as control:
            with m.State("pixels"):
                m.d.sync += [number.eq(0), settle.eq(0)]
                with m.If(self.valid & self.pixel.end & whole & ends & (y == height)):
                    m.next = "settle"
            with m.State("settle"):
                m.d.sync += settle.eq(settle + 1)
                with m.If(settle == 2):
                    m.next = "load"
            with m.State("load"):
                m.d.sync += [work.eq(choose([sums[0][0], sums[0][1], sums[1][0], sums[1][1]], number)), count.eq(shifts)]
                m.next = "shift"
            with m.State("shift"):
                with m.If(count == 0):
                    with m.Switch(number):
                        for n, result in enumerate(results):
                            with m.Case(n):
                                m.d.sync += result.eq(work[most_n:])
                    m.d.sync += number.eq(number + 1)
                    m.next = "load"
                    with m.If(number == len(results) - 1):
                        m.next = "measured"
                with m.Else():
                    m.d.sync += [work.eq(work << 1), count.eq(count - 1)]
            with m.State("measured"):
                m.d.comb += self.measured.eq(1)
                m.next = "pixels"
        m.d.comb += self.busy.eq(~control.ongoing("pixels"))
        return m

"""Displacement and gain of each pixel, from control points, without a multiplier."""

from collections.abc import Sequence

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.rig.maps import CELL_BITS, DISPLACEMENT_BITS, GAIN_BITS, WORD_BITS

from ..parts.delay import NO_COLLISION


__all__ = ["Displacement", "PointStep"]


class PointStep(data.StructLayout):
    """What is done with a word read from the map: added or subtracted, to nothing if ``load``; then the sum is halved if ``shift``."""
    def __init__(self):
        super().__init__({"valid": 1, "load": 1, "subtract": 1, "shift": 1})


class Displacement(wiring.Component):
    """The map of a camera, and what it says of the pixel at hand. All control is outside and serves both cameras.

    Golden: :func:`golden.rig.maps.displacement`.

    Down a column of control points the value is ``D0 + sum of 2**k (D1 if bit k of fy else D0)``, so it is added up from six words, from
    the lowest bit on, and halved in between: bits that fall off are kept. The slope from one column to the next takes twelve words,
    alternately added and subtracted. Along the line, slopes are accumulated.

    Timing: a word is read :attr:`LATENCY` cycles after ``address``, and ``step`` must come with it. The results of a step can be used in
    the cycle after it.

    Memory: two maps of ``words`` words.

    Parameters
    ----------
    words : int
        Of a map, a power of two.
    init : sequence of int
        The words of the first map after configuration.

    Members
    -------
    write : In(1), write_address : In(range(2 * words)), write_data : In(36)
    address : In(range(2 * words))
    step : In(PointStep())
    load_value, load_slope : In(1)
        The sum is the value at a line's first pixel, which is there an ``advance`` later; is the slope from the next pixel on.
    advance : In(1)
        To the next pixel.
    bound : Out(signed(15))
        The sum without fraction: the row bound, if it was summed.
    dx, dy : Out(signed(14))
        1/32 pixel.
    gain : Out(10)
        512 is 1.
    """
    LATENCY = 2

    def __init__(self, words: int, init: Sequence[int] = ()):
        self.words = words
        self.init = init
        super().__init__({
            "write": In(1), "write_address": In(range(2 * words)), "write_data": In(WORD_BITS),
            "address": In(range(2 * words)), "step": In(PointStep()),
            "load_value": In(1), "load_slope": In(1), "advance": In(1),
            "bound": Out(signed(DISPLACEMENT_BITS + 1)),
            "dx": Out(signed(DISPLACEMENT_BITS)), "dy": Out(signed(DISPLACEMENT_BITS)), "gain": Out(GAIN_BITS + 2),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory(shape=WORD_BITS, depth=2 * self.words, init=self.init, attrs=NO_COLLISION)
        read, write = memory.read_port(), memory.write_port()
        word = Signal(WORD_BITS, reset_less=True)
        m.d.comb += [
            read.addr.eq(self.address), read.en.eq(1),
            write.addr.eq(self.write_address), write.data.eq(self.write_data), write.en.eq(self.write),
        ]
        m.d.sync += word.eq(read.data)

        displacement, gain = signed(DISPLACEMENT_BITS), unsigned(GAIN_BITS)
        places = (("dx", displacement, 0, 10, 512), ("dy", displacement, DISPLACEMENT_BITS, 10, 512),
                  ("gain", gain, 2 * DISPLACEMENT_BITS, 8, 128))
        for name, shape, place, dropped, half in places:
            point = Signal(shape, name=f"{name}_point")
            m.d.comb += point.eq(word[place:place + shape.width])
            # Two more bits: a slope's sum, before the lower one is subtracted.
            bits = shape.width + 2
            total = Signal(signed(bits), name=f"{name}_sum", reset_less=True)
            low   = Signal(CELL_BITS, name=f"{name}_low", reset_less=True)
            added = Signal(signed(bits), name=f"{name}_added")
            # Subtraction is the addition of the complement, and of one more below.
            flipped = Cat(self.step.subtract, point ^ self.step.subtract.replicate(bits)).as_signed()
            m.d.comb += added.eq((Cat(self.step.subtract, Mux(self.step.load, 0, total)).as_signed() + flipped) >> 1)
            with m.If(self.step.valid):
                m.d.sync += total.eq(Mux(self.step.shift, added >> 1, added))
                with m.If(self.step.shift):
                    m.d.sync += low.eq(Cat(low[1:], added[0]))
            if name == "dx":
                m.d.comb += self.bound.eq(total)

            whole = Cat(low, total[:shape.width + 1]).as_signed()
            # A line's first value is a slope from nothing: what is accumulated needs no multiplexer.
            bits = shape.width + 2 * CELL_BITS
            slope = Signal(signed(bits), name=f"{name}_slope", reset_less=True)
            value = Signal(bits, name=f"{name}_value", reset_less=True)
            with m.If(self.load_value):
                m.d.sync += [slope.eq(whole << CELL_BITS), value.eq(half)]
            with m.Elif(self.load_slope):
                m.d.sync += slope.eq(whole)
            with m.If(self.advance & ~self.load_value):
                m.d.sync += value.eq(value + slope)
            m.d.comb += getattr(self, name).eq(value[dropped:])
        return m

"""The ring of lines of a camera, and the grey level between four of its pixels."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from golden.config import PIXEL_BITS, PIXEL_MAX
from golden.rig.maps import GAIN_BITS

from ..parts.delay import data_register
from ..parts.line_memory import LineMemory


__all__ = ["LineRing", "Weights"]


class Weights(data.StructLayout):
    """Weights of the right column and of the lower row, 1/32, and whether the left column is odd."""
    def __init__(self):
        super().__init__({"wx": range(33), "x_odd": 1, "wy": range(33)})


class LineRing(wiring.Component):
    """Holds the last lines of a camera's picture and interpolates between four of its pixels, times a gain.

    Golden: :func:`golden.rig.rectify.rectify`, from the source of a pixel on. Row ``r`` of the picture is in slot ``r % lines``. Banks are
    by parity of slot and of column, so that the four neighbours of any place are read at once. Parities select weights, not pixels.

    Timing: a pixel a cycle, always; latency :attr:`LATENCY` cycles from ``x`` and ``row``. Its rows must not be overwritten for
    :attr:`READ` cycles. Its weights follow :attr:`WEIGHTED` cycles later, its gain :attr:`GAINED`, so that one delay in a memory serves
    both cameras.

    Memory: ``lines * (max_width + max_width % 2)`` words in four banks.

    Parameters
    ----------
    max_width : int
        Pixels of a line.
    lines : int
        Even.

    Members
    -------
    write : In(1), slot_odd, x_odd : In(1), write_address : In(range(...)), pixel : In(8)
        A pixel is written; its address is ``(slot >> 1) * stride + (x >> 1)``.
    first : In(range(lines)), wrap : In(range(-lines, 0))
        Slot of the first row held, and the same less ``lines``.
    x : In(range(max_width)), row : In(range(lines))
        The left upper one of four pixels; rows count from the first one held.
    weights : In(Weights()), gain : In(10)
        512 is 1.
    o : Out(8)
    """
    READ, WEIGHTED, GAINED, LATENCY = 5, 7, 14, 16

    def __init__(self, max_width: int, lines: int):
        self.max_width = max_width
        self.lines = lines
        self.stride = (max_width + 1) // 2
        self.depth = lines // 2 * self.stride
        super().__init__({
            "write": In(1), "slot_odd": In(1), "x_odd": In(1), "write_address": In(ceil_log2(self.depth)), "pixel": In(PIXEL_BITS),
            "first": In(range(lines)), "wrap": In(range(-lines, 0)), "x": In(range(max_width)), "row": In(range(lines)),
            "weights": In(Weights()), "gain": In(GAIN_BITS + 2), "o": Out(PIXEL_BITS),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        pairs = self.lines // 2

        def register(shape, name, value):
            result = Signal(shape, name=name, reset_less=True)
            m.d.sync += result.eq(value)
            return result

        def later(value, clocks, name):
            for n in range(clocks):
                value = register(value.shape(), f"{name}_{n}", value)
            return value

        # 1: slot of the upper row. 2, 3: rows of slots in both banks, and their first words.
        wrapped = Signal(signed(len(self.row) + 1))
        m.d.comb += wrapped.eq(self.row + self.wrap)
        slot = register(range(self.lines), "slot", Mux(wrapped[-1], self.row + self.first, wrapped))
        odd_pair = register(range(pairs), "odd_pair", slot >> 1)
        even_pair = register(range(pairs), "even_pair", Mux(slot[0], Mux(slot >> 1 == pairs - 1, 0, (slot >> 1) + 1), slot >> 1))
        upper_odd = register(1, "upper_odd", slot[0])
        starts = []
        for name, pair in (("even_start", even_pair), ("odd_start", odd_pair)):
            start = Signal(range(self.depth), name=name, reset_less=True)
            with m.Switch(pair):
                for number in range(pairs):
                    with m.Case(number):
                        m.d.sync += start.eq(number * self.stride)
            starts.append(start)
        x = later(self.x, 3, "x")
        even_x = (x >> 1) + x[0]

        # 4: addresses; 5, 6, 7: the banks; 8: differences between columns, the right one times its weight.
        pixels = []
        for slot_odd, start in enumerate(starts):
            for x_odd, column in enumerate((even_x, x >> 1)):
                m.submodules[f"bank_{slot_odd}{x_odd}"] = bank = LineMemory(PIXEL_BITS, self.depth)
                m.d.comb += [
                    bank.address.eq(register(range(self.depth), f"address_{slot_odd}{x_odd}", start + column)),
                    bank.write.eq(self.write & (self.slot_odd == slot_odd) & (self.x_odd == x_odd)),
                    bank.column.eq(self.write_address), bank.i.eq(self.pixel),
                ]
                pixels.append(bank.o)

        # A weight counts for the odd column and the odd slot.
        upper_odd = later(upper_odd, self.WEIGHTED - 2, "upper_odd")

        def weight(value, swapped, name):
            return register(6, name, Mux(swapped, 32 - value, value))

        # 8: weights and differences along the line. 9: products. 10: levels of both rows, 1/32.
        wx = weight(self.weights.wx, self.weights.x_odd, "weight_x")
        wy = weight(self.weights.wy, upper_odd, "weight_y")
        levels = []
        for name, even, odd in (("even", *pixels[:2]), ("odd", *pixels[2:])):
            difference = register(signed(PIXEL_BITS + 1), f"{name}_difference", odd - even)
            product = register(signed(PIXEL_BITS + 6), f"{name}_product", difference * wx)
            base = later(even, 2, f"{name}_base")
            levels.append(register(PIXEL_BITS + 5, f"{name}_level", ((base << 5) + product)[:PIXEL_BITS + 5]))

        # 11: difference down the column. 12, 13: its upper part times the weight in a multiplier, its lower one in logic. 14: the level.
        wy = later(wy, 3, "weight_y")
        fall = register(signed(PIXEL_BITS + 6), "fall", levels[1] - levels[0])
        upper = register(signed(PIXEL_BITS + 7), "upper_product", (fall >> 5) * wy)
        low = fall[:5]
        low_sums = [register(12, f"low_{n}", Mux(wy[n], low << n, 0) + Mux(wy[n + 1], low << n + 1, 0)) for n in (0, 2, 4)]
        whole = register(PIXEL_BITS + 6, "whole_product", (later(levels[0], 2, "level_base") + upper)[:PIXEL_BITS + 6])
        part = register(10, "low_product", low_sums[0] + low_sums[1] + low_sums[2])
        level = register(PIXEL_BITS, "level", (((whole << 5) + part + 512) >> 10)[:PIXEL_BITS])

        # 15: times the gain, whose lowest bit is added in logic. 16: rounded and limited.
        product = register(PIXEL_BITS + 9, "gain_product", level * self.gain[1:])
        rest = register(PIXEL_BITS, "gain_rest", Mux(self.gain[0], level, 0))
        result = (((product << 1) + rest + 256) >> 9)
        m.d.sync += data_register(m, self.o).eq(Mux(result[PIXEL_BITS:].any(), PIXEL_MAX, result))
        return m

"""Altera's PLL, altpll: the block itself, and a PLL for one clock."""

from fractions import Fraction
from functools import partial

from amaranth import *
from amaranth.hdl import ValueLike

from ..clock import chosen_clock


__all__ = ["OUTPUTS", "Pll", "altpll", "make_clock"]


#: Outputs of the block.
OUTPUTS = 5

# Limits of the device handbooks of Cyclone III and IV: frequency of the oscillator, in Hz, and dividers of an output.
_OSCILLATOR_HZ = (600_000_000, 1_300_000_000)
_DIVIDERS = range(1, 513)


def altpll(family: str, input_hz: int, ratio: Fraction, clock: Value, reset: ValueLike, clocks: Signal, locked: Signal) -> Instance:
    """The block, with its first output at ``input_hz * ratio``.

    Parameters
    ----------
    family : str
        Of the FPGA, as Quartus calls it.
    input_hz : int
    ratio : Fraction
    clock, reset : Value
        Inputs.
    clocks : Signal(OUTPUTS)
        Outputs.
    locked : Signal()
        Output: the clocks are stable.
    """
    return Instance("altpll",
        p_intended_device_family=family, p_lpm_type="altpll", p_operation_mode="NORMAL", p_pll_type="AUTO", p_bandwidth_type="AUTO",
        p_compensate_clock="CLK0", p_inclk0_input_frequency=10**12 // input_hz, p_width_clock=len(clocks),
        p_clk0_multiply_by=ratio.numerator, p_clk0_divide_by=ratio.denominator, p_clk0_duty_cycle=50, p_clk0_phase_shift="0",
        p_port_inclk0="PORT_USED", p_port_areset="PORT_USED", p_port_clk0="PORT_USED", p_port_locked="PORT_USED",
        i_inclk=Cat(clock, C(0, 1)), i_areset=reset, o_clk=clocks, o_locked=locked)


def _oscillators(input_hz: int) -> range:
    """Multiples of the input within the limits, in Hz."""
    least, most = _OSCILLATOR_HZ
    return range(-(-least // input_hz) * input_hz, most + 1, input_hz)


def _makes(input_hz: int, output_hz: int) -> bool:
    """Whether the oscillator can run at a multiple of both."""
    return output_hz > 0 and any(
        oscillator % output_hz == 0 and oscillator // output_hz in _DIVIDERS for oscillator in _oscillators(input_hz))


def make_clock(board: str, input_hz: int, clock_mhz: float) -> int:
    """As :func:`boards.clock.chosen_clock`, which names the nearest clock that is a whole number of kHz.

    Examples
    --------
    >>> make_clock("b", 50_000_000, 62.5), make_clock("b", 50_000_000, 75)
    (62500000, 75000000)
    """
    offered = (oscillator // divider for oscillator in _oscillators(input_hz) for divider in _DIVIDERS if not oscillator % (1000 * divider))
    return chosen_clock(board, input_hz, clock_mhz, partial(_makes, input_hz), offered)


class Pll(Elaboratable):
    """A PLL that makes one clock.

    Parameters
    ----------
    family : str
    input_hz, output_hz : int
        :class:`ValueError` if it cannot make that clock.

    Attributes
    ----------
    clock : Signal()
        Input.
    clocks : Signal(1)
        Output.
    locked : Signal()
        Output: the clock is stable.
    """
    def __init__(self, family: str, input_hz: int, output_hz: int):
        if not _makes(input_hz, output_hz):
            raise ValueError(f"an altpll does not make {output_hz} Hz of {input_hz} Hz; choose another clock")
        self.family = family
        self.input_hz = input_hz
        self.ratio = Fraction(output_hz, input_hz)
        self.clock = Signal()
        self.clocks = Signal(1)
        self.locked = Signal()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        outputs = Signal(OUTPUTS)
        m.submodules.block = altpll(self.family, self.input_hz, self.ratio, self.clock, 0, outputs, self.locked)
        m.d.comb += self.clocks.eq(outputs)
        return m

"""The ECP5's PLL, EHXPLLL: dividers for a clock, and the block itself."""

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from amaranth import *

from ..clock import chosen_clock


__all__ = ["ATTRIBUTES", "Dividers", "Pll", "dividers", "make_clock"]


# Limits of the data sheet, in Hz: inside the phase detector, and of the oscillator.
_DETECTOR_HZ = 3_125_000
_OSCILLATOR_HZ = (400_000_000, 800_000_000)
_MIDDLE_HZ = sum(_OSCILLATOR_HZ) // 2
_DIVIDERS = range(1, 129)

#: Attributes of the block, which must stay in the Verilog: the loop filter, as Lattice's and Trellis's tools set it.
ATTRIBUTES = {"ICP_CURRENT": "12", "LPF_RESISTOR": "8", "MFG_ENABLE_FILTEROPAMP": "1", "MFG_GMCREF_SEL": "2"}

_OUTPUTS = ("CLKOP", "CLKOS")


class Dividers(NamedTuple):
    """Of the input, of the feedback, which is taken from the first output, and of each output."""
    reference: int
    feedback: int
    outputs: tuple[int, ...]


def dividers(input_hz: int, outputs_hz: Sequence[int]) -> Dividers | None:
    """Dividers that make the clocks without error, with the oscillator as near to the middle of its range as possible; ``None`` if there
    are none.

    Parameters
    ----------
    input_hz : int
    outputs_hz : sequence of int
        One or two clocks.

    Examples
    --------
    >>> dividers(25_000_000, [125_000_000, 25_000_000])
    Dividers(reference=1, feedback=5, outputs=(5, 25))
    >>> dividers(25_000_000, [75_000_000]), dividers(25_000_000, [77_000_000])
    (Dividers(reference=1, feedback=3, outputs=(8,)), None)
    """
    ratio = Fraction(outputs_hz[0], input_hz)
    if ratio.numerator not in _DIVIDERS or ratio.denominator not in _DIVIDERS or input_hz < ratio.denominator * _DETECTOR_HZ:
        return None
    found = []
    for first in _DIVIDERS:
        oscillator = first * outputs_hz[0]
        others = [Fraction(oscillator, hz) for hz in outputs_hz]
        if _OSCILLATOR_HZ[0] <= oscillator <= _OSCILLATOR_HZ[1] and all(other.denominator == 1 and other in _DIVIDERS for other in others):
            found.append((abs(oscillator - _MIDDLE_HZ), tuple(int(other) for other in others)))
    return Dividers(ratio.denominator, ratio.numerator, min(found)[1]) if found else None


def make_clock(board: str, input_hz: int, clock_mhz: float) -> int:
    """As :func:`boards.clock.chosen_clock`, which names the nearest clock that is a multiple of 3.125 MHz."""
    offered = (clock for step in _DIVIDERS if dividers(input_hz, [clock := step * _DETECTOR_HZ]))
    return chosen_clock(board, input_hz, clock_mhz, lambda hz: dividers(input_hz, [hz]), offered)


class Pll(Elaboratable):
    """A PLL that makes one clock or two.

    Parameters
    ----------
    input_hz : int
    outputs_hz : sequence of int
        :class:`ValueError` if it cannot make them.

    Attributes
    ----------
    clock : Signal()
        Input.
    clocks : Signal(len(outputs_hz))
        Outputs, with their rising edges aligned.
    locked : Signal()
        Output: the clocks are stable.
    """
    def __init__(self, input_hz: int, outputs_hz: Sequence[int]):
        settings = dividers(input_hz, outputs_hz)
        if settings is None:
            raise ValueError(f"an EHXPLLL does not make {', '.join(map(str, outputs_hz))} Hz of {input_hz} Hz; choose others")
        self.input_hz = input_hz
        self.outputs_hz = tuple(outputs_hz)
        self.dividers = settings
        self.clock = Signal()
        self.clocks = Signal(len(outputs_hz))
        self.locked = Signal()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        parameters: dict[str, int | str] = {}
        # The phases are alike, so the outputs are aligned; half a period of the first one is where the vendor's tool has them.
        phase = self.dividers.outputs[0] // 2
        for name, divider in zip(_OUTPUTS, self.dividers.outputs):
            parameters |= {f"p_{name}_ENABLE": "ENABLED", f"p_{name}_DIV": divider, f"p_{name}_CPHASE": phase, f"p_{name}_FPHASE": 0}
        m.submodules.block = Instance("EHXPLLL",
            **{f"a_{name}": value for name, value in ATTRIBUTES.items()},
            a_FREQUENCY_PIN_CLKI=f"{self.input_hz / 1e6:g}",
            p_CLKI_DIV=self.dividers.reference, p_CLKFB_DIV=self.dividers.feedback, p_FEEDBK_PATH="CLKOP",
            p_PLLRST_ENA="DISABLED", p_INTFB_WAKE="DISABLED", p_STDBY_ENABLE="DISABLED", p_DPHASE_SOURCE="DISABLED",
            p_OUTDIVIDER_MUXA="DIVA", p_OUTDIVIDER_MUXB="DIVB", p_OUTDIVIDER_MUXC="DIVC", p_OUTDIVIDER_MUXD="DIVD",
            **parameters,
            i_CLKI=self.clock, i_CLKFB=self.clocks[0], i_RST=0, i_STDBY=0, i_PHASESEL0=0, i_PHASESEL1=0, i_PHASEDIR=1, i_PHASESTEP=1,
            i_PHASELOADREG=1, i_PLLWAKESYNC=0, i_ENCLKOP=0,
            **{f"o_{name}": self.clocks[number] if number < len(self.clocks) else Signal(name=name)
               for number, name in enumerate(_OUTPUTS)},
            o_LOCK=self.locked)
        return m

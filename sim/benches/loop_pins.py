"""Pins that all boards with a serial line have, for the cocotb halves of the benches of their top levels.

The system behind the pins is :class:`sim.models.loop_double.LoopDouble`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cocotb.triggers import Timer


__all__ = ["LoopPins", "lit"]


def lit(dut: Any) -> int:
    """The number that the LEDs show."""
    return sum(int(getattr(dut, f"led_{number}__io").value) << number for number in range(8))


@dataclass(frozen=True)
class LoopPins:
    """A board's top level.

    Parameters
    ----------
    dut : Any
        As cocotb has it.
    oscillator, button : str
        Ports.
    pressed : int
        Level of the button.
    half_ns : int
        Of the oscillator's period; the stand-ins of the PLLs repeat its clock.
    """
    dut: Any
    oscillator: str
    button: str
    pressed: int
    half_ns: int

    async def clocks(self, count: int, sample: Callable[[], None] = lambda: None) -> None:
        """Clock periods of the oscillator; ``sample`` is called at the end of each of their halves."""
        for _ in range(count):
            for level in (1, 0):
                getattr(self.dut, self.oscillator).value = level
                await Timer(self.half_ns, unit="ns")
                sample()

    def press(self, pressed: bool) -> None:
        """Press or release the button."""
        getattr(self.dut, self.button).value = self.pressed if pressed else 1 - self.pressed

    async def check_line_leds_and_reset(self) -> None:
        """The line reaches the system and is driven by it; LEDs in their order, lit by 1; the button clears."""
        line = self.dut.uart_0__rx__io
        self.press(False)
        line.value = 1
        await self.clocks(10)
        assert (int(self.dut.uart_0__tx__io.value), lit(self.dut)) == (1, 0)
        for changes in range(1, 40):
            line.value = 1 - changes % 2
            await self.clocks(2)
            assert (int(self.dut.uart_0__tx__io.value), lit(self.dut)) == (1 - changes % 2, changes)
        self.press(True)
        await self.clocks(3)
        assert lit(self.dut) == 0
        self.press(False)
        await self.clocks(5)

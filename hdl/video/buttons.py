"""Push buttons of the board."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


__all__ = ["Button"]


class Button(wiring.Component):
    """Debounces a button: one pulse each time that it is pressed.

    It counts as pressed, or as released, when its level has been stable for :attr:`SECONDS`. There is no golden model.

    Timing: ``pressed`` is high for a cycle, ``SECONDS`` and a cycle after the last bounce.

    Parameters
    ----------
    clock_hz : int

    Members
    -------
    i : In(1)
        1 while the button is down; synchronous.
    pressed : Out(1)
    """
    SECONDS = 0.01

    def __init__(self, clock_hz: int):
        self.clocks = max(1, round(self.SECONDS * clock_hz))
        super().__init__({"i": In(1), "pressed": Out(1)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        down  = Signal()
        count = Signal(range(self.clocks + 1))  # cycles for which `i` has differed from `down`
        m.d.sync += self.pressed.eq(0)
        with m.If(self.i == down):
            m.d.sync += count.eq(0)
        with m.Elif(count != self.clocks - 1):
            m.d.sync += count.eq(count + 1)
        with m.Else():
            m.d.sync += [down.eq(self.i), count.eq(0), self.pressed.eq(self.i)]
        return m

"""Push buttons of the board."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


__all__ = ["Button"]


class Button(wiring.Component):
    """A bouncing button: told once for each time that it is pressed.

    It counts as pressed, or as let go, when it has been so for :attr:`SECONDS`. Independent of the rest of the system: no golden model.

    Timing: ``pressed`` for a cycle, ``SECONDS`` and a cycle after the last bounce.

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

    def __init__(self, clock_hz):
        self.clocks = max(1, round(self.SECONDS * clock_hz))
        super().__init__({"i": In(1), "pressed": Out(1)})

    def elaborate(self, platform):
        m = Module()
        down  = Signal()
        count = Signal(range(self.clocks + 1))  # cycles for which the button has differed from `down`
        m.d.sync += self.pressed.eq(0)
        with m.If(self.i == down):
            m.d.sync += count.eq(0)
        with m.Elif(count != self.clocks - 1):
            m.d.sync += count.eq(count + 1)
        with m.Else():
            m.d.sync += [down.eq(self.i), count.eq(0), self.pressed.eq(self.i)]
        return m

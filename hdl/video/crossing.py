"""From one clock to another: events, and whether the other clock runs."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out


__all__ = ["ClockWatch", "EventCrossing"]


class EventCrossing(wiring.Component):
    """One cycle in the domain ``domain`` becomes one cycle in ``sync``; several events side by side, each for itself.

    Each event inverts a register, whose changes are seen in ``sync``. None is lost or made by a reset of either domain: no register here
    is reset.

    Timing: an event is seen 2 to 3 cycles of ``sync`` later. Events of the same bit must be more than a period of ``sync`` apart.

    Parameters
    ----------
    domain : str
    events : int

    Members
    -------
    i : In(events)
        In ``domain``.
    o : Out(events)
        In ``sync``.
    """
    def __init__(self, domain: str, events: int):
        self.domain = domain
        self.events = events
        super().__init__({"i": In(events), "o": Out(events)})

    def elaborate(self, platform):
        m = Module()
        toggle = Signal(self.events, reset_less=True)
        seen   = Signal(self.events)
        before = Signal(self.events, reset_less=True)
        m.d[self.domain] += toggle.eq(toggle ^ self.i)
        m.submodules.synchronizer = FFSynchronizer(toggle, seen)
        m.d.sync += before.eq(seen)
        m.d.comb += self.o.eq(seen ^ before)
        return m


class ClockWatch(wiring.Component):
    """Tells in ``sync`` when the clock of another domain stands still, or its domain is held in reset.

    That clock divided by :attr:`DIVISOR` is watched: no change for :attr:`TIMEOUT` cycles of ``sync`` means that it has stopped. The
    clocks may differ by a factor of ``TIMEOUT / DIVISOR`` one way, and ``DIVISOR`` the other.

    Timing: ``stopped`` rises ``TIMEOUT`` cycles after the last change was seen, 3.4 us at 75 MHz, and falls when the next one is. It is
    high after reset.

    Parameters
    ----------
    domain : str

    Members
    -------
    stopped : Out(1)
    """
    DIVISOR = 16
    TIMEOUT = 256

    def __init__(self, domain: str):
        self.domain = domain
        super().__init__({"stopped": Out(1, init=1)})

    def elaborate(self, platform):
        m = Module()
        divider = Signal(range(2 * self.DIVISOR))
        m.d[self.domain] += divider.eq(divider + 1)
        seen, before = Signal(), Signal()
        m.submodules.synchronizer = FFSynchronizer(divider[-1], seen)
        quiet = Signal(range(self.TIMEOUT))
        m.d.sync += before.eq(seen)
        with m.If(seen != before):
            m.d.sync += [quiet.eq(0), self.stopped.eq(0)]
        with m.Elif(quiet == self.TIMEOUT - 1):
            m.d.sync += self.stopped.eq(1)
        with m.Else():
            m.d.sync += quiet.eq(quiet + 1)
        return m

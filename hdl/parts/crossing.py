"""Clock domain crossing of events, and a watchdog for a clock."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out


__all__ = ["ClockWatch", "EventCrossing"]


class EventCrossing(wiring.Component):
    """Takes one-cycle events from the domain ``domain`` to ``sync``; each bit is an event of its own.

    Each event inverts a register, whose edges are detected in ``sync``. A reset of either domain neither loses an event nor makes one: no
    register here is reset.

    Timing: latency 2 to 3 cycles of ``sync``. Events of the same bit must be more than a period of ``sync`` apart.

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

    def elaborate(self, platform: object) -> Module:
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
    """Tells in ``sync`` when the clock of another domain has stopped, or its domain is held in reset.

    That clock divided by :attr:`DIVISOR` is sampled: no edge for :attr:`TIMEOUT` cycles of ``sync`` means that it has stopped. The clock
    may be slower than ``sync`` by a factor of ``TIMEOUT / DIVISOR``, and faster by a factor of ``DIVISOR``.

    Timing: ``stopped`` rises ``TIMEOUT`` cycles after the last edge, 3.4 us at 75 MHz, and falls with the next one. It is high after
    reset.

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

    def elaborate(self, platform: object) -> Module:
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

"""Counters of events that hold their greatest value."""

from amaranth import *


__all__ = ["count_events"]


def count_events(m: Module, counter: Value, event: Value | int = 1, clear: Value | None = None) -> None:
    """Count in ``sync`` the cycles in which ``event`` is high; ``counter`` stays at its greatest value.

    An event in the cycle of ``clear`` is counted after it. Within ``m.If`` and the like, ``event`` may be left out.
    """
    counting = m.If(event & ~counter.all())
    if clear is not None:
        with m.If(clear):
            m.d.sync += counter.eq(event)
        counting = m.Elif(event & ~counter.all())
    with counting:
        m.d.sync += counter.eq(counter + 1)

"""Amaranth's simulator in less time, with the same results: an engine that does not repeat what has no effect.

It changes the code that Amaranth's own engine generates for a design, and how processes are woken; each clock is computed as before.
"""

import re
from typing import Any
from unittest import mock

from amaranth import sim
from amaranth.sim import _pyrtl, pysim


__all__ = ["Simulator"]


_MASKED = re.compile(r"\((0x[0-9a-f]+) & slots\[(\d+)\]\.curr\)")
_UPDATE = re.compile(r"slots\[(\d+)\]\.update\(next_\1, (-?\d+)\)")
_SLOT = re.compile(r"slots\[(\d+)\]")


def _faster(code: str, slots: list[Any]) -> str:
    """The code of a process, with signals as local variables, without masks that change nothing and calls for signals that keep their
    value."""
    def masked(match: re.Match[str]) -> str:
        signal = slots[int(match[2])].signal
        every = (1 << len(signal)) - 1
        return match[0] if signal.shape().signed or int(match[1], 16) & every != every else f"slots[{match[2]}].curr"

    def update(match: re.Match[str]) -> str:
        signal, mask = slots[int(match[1])].signal, int(match[2])
        every = (1 << len(signal)) - 1
        state, value = f"slots[{match[1]}]", f"next_{match[1]}"
        return (match[0] if mask & every != every else
                f"if {state}.next != {value}: {state}.next = {value}; {state}.pending.add({state})")

    before = ""
    while before != code:   # a masked value may be masked again
        before, code = code, _MASKED.sub(masked, code)
    code = _UPDATE.sub(update, code)
    names = ", ".join(f"slot{number}=slots[{number}]" for number in dict.fromkeys(_SLOT.findall(code)))
    return _SLOT.sub(r"slot\1", code).replace("def run():", f"def run({names}):", 1)


class _Emitter(_pyrtl._PythonEmitter):
    def __init__(self, slots):
        super().__init__()
        self._slots = slots

    def flush(self, indent=""):
        return _faster(super().flush(indent), self._slots)


class _Signal(pysim._PySignalState):
    """A signal that wakes the processes of the design without a call for each."""
    __slots__ = ("due", "of_any", "of_edge")

    def __init__(self, signal, pending, due):
        super().__init__(signal, pending)
        self.due = due
        self.of_any, self.of_edge = (), {}

    def sort(self):
        """Take the processes out of the functions that would wake them."""
        kept, of_any = [], []
        for waker in self.wakers:
            inner = dict(zip(waker.__code__.co_freevars, (cell.cell_contents for cell in waker.__closure__ or ())))
            if waker.__qualname__.startswith("comb_waker."):
                of_any.append(inner["process"])
            elif waker.__qualname__.startswith("edge_waker."):
                self.of_edge.setdefault(inner["polarity"], []).append(inner["process"])
            else:
                kept.append(waker)
        self.wakers[:], self.of_any = kept, tuple(of_any)

    def commit(self):
        if self.curr == self.next:
            return False
        self.due.update(self.of_any)
        if self.of_edge:
            self.due.update(self.of_edge.get(self.next, ()))
        if self.wakers:
            pysim._run_wakers(self.wakers, self.curr, self.next)
        self.curr = self.next
        return True


class _State(pysim._PyEngineState):
    def __init__(self):
        super().__init__()
        self.due = set()

    def get_signal(self, signal):
        if signal not in self.signals:
            self.signals[signal] = len(self.slots)
            self.slots.append(_Signal(signal, self.pending, self.due))
        return self.signals[signal]


class _Engine(pysim.PySimEngine):
    def __init__(self, design):
        state = _State()
        with mock.patch.object(pysim, "_PyEngineState", lambda: state), \
                mock.patch.object(_pyrtl, "_PythonEmitter", lambda: _Emitter(state.slots)):
            super().__init__(design)
        for slot in state.slots:
            if isinstance(slot, _Signal):
                slot.sort()
        self._due = state.due
        self._of_design = frozenset(self._processes)
        # Those that read a memory without a clock are woken by its changes, too.
        self._of_memories = {cell.cell_contents for slot in state.slots if not isinstance(slot, _Signal)
                             for waker in slot.wakers for cell in waker.__closure__}
        self._start()

    def _start(self):
        self._due.clear()
        self._due.update(process for process in self._of_design if process.runnable)
        self._others = (self._processes - self._of_design) | self._of_memories

    def reset(self):
        super().reset()
        self._start()

    def add_clock_process(self, clock, **options):
        super().add_clock_process(clock, **options)
        self._start()

    def add_async_process(self, simulator, process):
        super().add_async_process(simulator, process)
        self._start()

    def write_vcd(self, **_):
        raise NotImplementedError("waveforms are written by Amaranth's own simulator: import Simulator from amaranth.sim")

    def step_design(self):
        while True:
            for trigger in self._active_triggers:
                trigger.run()
            self._active_triggers.clear()
            due = tuple(self._due)
            self._due.clear()
            for process in due:
                process.run()
            for process in self._others:
                if process.runnable:
                    process.runnable = False
                    process.run()
            self._delta_cycles += 1
            if self._state.commit():
                return


class Simulator(sim.Simulator):
    """:class:`amaranth.sim.Simulator` with the faster engine; it writes no waveforms."""
    def __init__(self, toplevel: Any):
        super().__init__(toplevel, engine=_Engine)

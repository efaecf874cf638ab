"""Set-up of the video chips: a sequencer for a chip's table of steps."""

import enum
import math
from typing import Any

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.video.setup_steps import Chip, Drive, Failure, Lock, Poll, Step, Write

from ..parts.counters import count_events
from .i2c import I2cMaster


__all__ = ["ChipSetup"]


class _Kind(enum.Enum):
    """Kind of a step."""
    DRIVE = 0
    WRITE = 1
    POLL = 2
    LOCK = 3


_KINDS = {Drive: _Kind.DRIVE, Write: _Kind.WRITE, Poll: _Kind.POLL, Lock: _Kind.LOCK}


class _StepWord(data.StructLayout):
    """A step in memory; ``ticks`` is its time."""
    def __init__(self, ticks_max: int, channels: int):
        super().__init__({
            "kind": _Kind, "register": 8, "value": 8, "mask": 8, "ticks": range(ticks_max + 1), "channel": range(max(channels, 1)),
        })


class ChipSetup(wiring.Component):
    """Sets up a chip over an I2C bus, and monitors it from then on.

    The steps of ``chip.setup`` are executed once, then those of ``chip.watch`` every ``watch_seconds``. A step that still fails after its
    time ends the attempt: ``step`` and ``reason`` tell which one and why (:meth:`golden.video.setup_steps.Chip.explain` puts it in words),
    ``failures`` counts, and after ``pause_seconds`` the whole set-up is repeated, from the pins on. After ``tries`` attempts in a row have
    failed, ``failed`` is set and the bus is idle until ``restart``. A failure of a step of ``chip.watch`` is counted too, and starts the
    set-up with all its attempts again.

    Status: ``busy`` from reset or ``restart`` until ``done`` or ``failed``, exactly one of the three is high. ``step`` and ``reason`` are
    those of the latest failure since reset or ``restart``. ``locked`` is low unless ``done``.

    Timing: a register is written in 29 bits of the bus, read in 40; times are rounded up to :attr:`TICK_SECONDS`.

    Memory: a word of about 40 bits for each step.

    Parameters
    ----------
    chip : :class:`golden.video.setup_steps.Chip`
    clock_hz, bus_hz, stretch_seconds
        As of :class:`I2cMaster`.
    tries : int
        Attempts in a row, at least 1.
    pause_seconds : float
        Between two attempts.
    watch_seconds : float
        Between two executions of ``chip.watch``.

    Members
    -------
    restart : In(1)
        Repeat the set-up from the beginning, as after reset, once the transfer on the bus has ended; high for a cycle or more.
    scl_low, sda_low : Out(1)
    scl_i, sda_i : In(1)
        The bus, as of :class:`I2cMaster`.
    *pin* : Out(1)
        Each of ``chip.pins``, by its name.
    busy, done, failed : Out(1)
    step : Out(range(len(chip.steps)))
    reason : Out(Failure)
    failures : Out(16)
        Failed attempts, and failures of ``chip.watch``; holds its greatest value.
    locked : Out(chip.channels)
        One bit a channel; only if the chip has channels.
    """
    TICK_SECONDS = 100e-6

    def __init__(self, chip: Chip, clock_hz: int, bus_hz: int = 100_000, *, stretch_seconds: float = 1e-3, tries: int = 4,
                 pause_seconds: float = 0.1, watch_seconds: float = 0.02):
        if tries < 1:
            raise ValueError(f"a chip must be set up in at least 1 try, not {tries!r}")
        for name, seconds in (("pause_seconds", pause_seconds), ("watch_seconds", watch_seconds)):
            if not (math.isfinite(seconds) and seconds >= 0):
                raise ValueError(f"{name} must be 0 or more, not {seconds!r}")
        self.chip = chip
        self.clock_hz = clock_hz
        self.tries = tries
        self.pause = self._ticks(pause_seconds)
        self.interval = self._ticks(watch_seconds)
        self.master = I2cMaster(clock_hz, bus_hz, stretch_seconds=stretch_seconds)
        levels = chip.setup[0].levels if isinstance(chip.setup[0], Drive) else ()
        members = {
            "restart": In(1),
            "scl_low": Out(1),
            "sda_low": Out(1),
            "scl_i": In(1, init=1),
            "sda_i": In(1, init=1),
            **{pin: Out(1, init=level) for pin, level in zip(chip.pins, levels)},
            "busy": Out(1, init=1),
            "done": Out(1),
            "failed": Out(1),
            "step": Out(range(len(chip.steps))),
            "reason": Out(Failure),
            "failures": Out(16),
        }
        if chip.channels:
            members["locked"] = Out(chip.channels)
        super().__init__(members)

    def _ticks(self, seconds: float) -> int:
        """``seconds`` in ticks, rounded up, but not for a rounding error of the float."""
        return math.ceil(round(seconds / self.TICK_SECONDS, 6))

    def _word(self, step: Step) -> dict[str, Any]:
        """A step as a word of the memory."""
        value = sum(level << place for place, level in enumerate(step.levels)) if isinstance(step, Drive) else getattr(step, "value", 0)
        return {
            "kind": _KINDS[type(step)], "register": getattr(step, "register", 0), "value": value, "mask": getattr(step, "mask", 0),
            "ticks": self._ticks(step.seconds), "channel": getattr(step, "channel", 0),
        }

    def elaborate(self, platform: object) -> Module:
        m = Module()
        chip = self.chip
        m.submodules.master = master = self.master
        m.d.comb += [
            self.scl_low.eq(master.scl_low), self.sda_low.eq(master.sda_low), master.scl_i.eq(self.scl_i), master.sda_i.eq(self.sda_i),
        ]

        words = [self._word(step) for step in chip.steps]
        ticks_max = max(self.pause, self.interval, *(word["ticks"] for word in words))
        layout = _StepWord(ticks_max, chip.channels)
        m.submodules.table = table = Memory(shape=layout, depth=len(words), init=words)
        read = table.read_port()
        word = read.data
        at = Signal(range(len(words)))
        m.d.comb += read.addr.eq(at)

        # A timer of whole ticks.
        tick_cycles = math.ceil(round(self.clock_hz * self.TICK_SECONDS, 6))
        cycles = Signal(range(tick_cycles))
        ticks  = Signal(range(ticks_max + 1))
        with m.If(cycles != 0):
            m.d.sync += cycles.eq(cycles - 1)
        with m.Elif(ticks != 0):
            m.d.sync += [ticks.eq(ticks - 1), cycles.eq(tick_cycles - 1)]
        expired = Signal()
        m.d.comb += expired.eq((cycles == 0) & (ticks == 0))

        def wait(ticks_to_wait: Value | int) -> None:
            m.d.sync += [ticks.eq(ticks_to_wait), cycles.eq(0)]

        # A transfer: three bytes to write a register, four to read one.
        part   = Signal(range(4), reset_less=True)
        byte   = Signal(8, reset_less=True)
        result = Signal(Failure, reset_less=True)
        writes = Signal()
        m.d.comb += writes.eq(word.kind == _Kind.WRITE)
        send = master.i.p
        with m.Switch(part):
            with m.Case(0):
                m.d.comb += [send.data.eq(chip.address << 1), send.start.eq(1)]
            with m.Case(1):
                m.d.comb += [send.data.eq(word.register), send.stop.eq(~writes & (not chip.restart))]
            with m.Case(2):
                m.d.comb += [send.data.eq(Mux(writes, word.value, chip.address << 1 | 1)), send.start.eq(~writes), send.stop.eq(writes)]
            with m.Case(3):
                m.d.comb += [send.read.eq(1), send.nack.eq(1), send.stop.eq(1)]
        matches = Signal()
        m.d.comb += matches.eq((byte & word.mask) == word.value)

        again  = Signal()                       # `restart` was high
        tries  = Signal(range(self.tries), init=self.tries - 1)     # remaining after this one
        locked = self.locked if chip.channels else Signal(1)
        with m.If(self.restart):
            m.d.sync += again.eq(1)

        def begin() -> None:
            m.d.sync += at.eq(0)
            m.next = "fetch"

        def begin_again() -> None:
            m.d.sync += [again.eq(self.restart), tries.eq(self.tries - 1), self.busy.eq(1), self.done.eq(0), self.failed.eq(0)]
            m.d.sync += [self.step.eq(0), self.reason.eq(Failure.NONE), locked.eq(0)]
            begin()

        with m.FSM():
            with m.State("fetch"):
                m.next = "step"

            with m.State("step"):
                m.d.sync += part.eq(0)
                wait(word.ticks)
                with m.If(word.kind == _Kind.DRIVE):
                    m.d.sync += Cat(getattr(self, pin) for pin in chip.pins).eq(word.value)
                    m.next = "wait"
                with m.Else():
                    m.next = "send"
            with m.State("wait"):
                with m.If(again):
                    begin_again()
                with m.Elif(expired):
                    m.next = "next"

            with m.State("send"):
                m.d.comb += master.i.valid.eq(1)
                with m.If(master.i.ready):
                    m.next = "receive"
            with m.State("receive"):
                m.d.comb += master.o.ready.eq(1)
                with m.If(master.o.valid):
                    m.d.sync += [part.eq(part + 1), byte.eq(master.o.p.data), result.eq(master.o.p.result)]
                    with m.If((master.o.p.result != Failure.NONE) | (part == Mux(writes, 2, 3))):
                        m.next = "judge"
                    with m.Else():
                        m.next = "send"
            with m.State("judge"):
                m.d.sync += part.eq(0)
                with m.If(again):
                    begin_again()
                with m.Elif((result == Failure.NONE) & (matches | (word.kind != _Kind.POLL))):
                    with m.If(word.kind == _Kind.LOCK):
                        m.d.sync += locked.bit_select(word.channel, 1).eq(matches)
                    m.next = "next"
                with m.Elif(expired):
                    m.next = "fail"
                with m.Else():
                    m.next = "send"

            with m.State("next"):
                m.d.sync += at.eq(at + 1)
                m.next = "fetch"
                with m.If(at == len(chip.setup) - 1):
                    m.d.sync += [self.busy.eq(0), self.done.eq(1), tries.eq(self.tries - 1)]
                with m.If(at == len(words) - 1):
                    wait(self.interval)
                    m.next = "watch" if chip.watch else "stop"
            with m.State("watch"):
                m.d.sync += at.eq(len(chip.setup))
                with m.If(again):
                    begin_again()
                with m.Elif(expired):
                    m.next = "fetch"

            with m.State("fail"):
                m.d.sync += [self.step.eq(at), self.reason.eq(Mux(result == Failure.NONE, Failure.NOT_READY, result))]
                m.d.sync += [locked.eq(0), self.done.eq(0)]
                count_events(m, self.failures)
                with m.If(~self.done & (tries == 0)):
                    m.d.sync += [self.busy.eq(0), self.failed.eq(1)]
                    m.next = "stop"
                with m.Else():
                    with m.If(~self.done):
                        m.d.sync += tries.eq(tries - 1)
                    m.d.sync += self.busy.eq(1)
                    wait(self.pause)
                    m.next = "pause"
            with m.State("pause"):
                with m.If(again):
                    begin_again()
                with m.Elif(expired):
                    begin()
            with m.State("stop"):
                with m.If(again):
                    begin_again()
        return m

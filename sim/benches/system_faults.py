"""Faults of the whole system, by name: how each is caused, and which register counts it."""

import dataclasses
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from random import Random

from cocotb.triggers import ClockCycles

from sim.benches.system_rig import NO_CLOCK, NO_SIGNAL, Rig
from sim.models.i2c_chips import Fault as ChipFault


__all__ = ["FAULTS", "Fault", "camera_reset", "film"]


@dataclass(frozen=True)
class Fault:
    """A fault.

    Parameters
    ----------
    counter : str
        Register that counts it.
    strike : coroutine function
        Causes the fault; returns when it is over.
    kept : bool
        No picture is lost.
    """
    counter: str
    strike: Callable[[Rig], Awaitable[None]]
    kept: bool = False


def film(side: str, *faults: str) -> Callable[[Rig], Awaitable[None]]:
    """Faults in a camera's next frames."""
    async def strike(rig):
        camera = rig.films[side]
        camera.faults.extend(faults)
        end = camera.frames + len(faults) + 1   # those, after the one in transmission
        await rig.until(lambda: camera.frames >= end)
    return strike


def _stall(clocks):
    async def strike(rig):
        rig.memory.stall(clocks)
        await ClockCycles(rig.dut.clk, clocks)
    return strike


async def _refresh_storm(rig):
    calm = rig.memory.timing
    rig.memory.timing = dataclasses.replace(calm, refresh=(100, 98))
    await ClockCycles(rig.dut.clk, 7500)
    rig.memory.timing = calm


async def _line_noise(rig):
    """Levels that are not bytes, then an idle line, after which it works again: time-out, and a reply to noise."""
    rig.host.rng = Random(1)
    rig.host.send_noise(60)
    rig.host.send_level(1, rig.QUIET_BITS)
    while not rig.host.idle:
        await rig.exchange()


def camera_reset(side: str) -> Callable[[Rig], Awaitable[None]]:
    """A reset of a camera's domain."""
    async def strike(rig):
        reset = getattr(rig.dut, f"{side}_camera_rst")
        reset.value = 1
        await ClockCycles(rig.dut.clk, 500)
        reset.value = 0
    return strike


def _silent(chip, register):
    """A chip acknowledges no byte until that is counted; then it does, and is set up."""
    async def strike(rig):
        counter = f"{chip}_failures"
        before = await rig.read(counter)
        faults = getattr(rig, chip).faults
        faults.append(ChipFault("no acknowledge", register))
        for _ in range(100):
            if await rig.read(counter) != before:
                break
        else:
            raise TimeoutError(f"{counter} has not counted")
        faults.clear()
    return strike


#: By name.
FAULTS = {
    "left camera lost and back": Fault("left_dropped", film("left", "signal lost", NO_SIGNAL, NO_SIGNAL)),
    "right camera lost in noise and back": Fault("right_dropped", film("right", "signal lost in noise", NO_SIGNAL)),
    "left camera's clock stops and comes back": Fault("left_dropped", film("left", "clock stopped", NO_CLOCK)),
    "right camera's clock stops for a moment": Fault("right_dropped", film("right", "clock stopped")),
    "fields swapped": Fault("left_dropped", film("left", "fields swapped")),
    "top field missing": Fault("right_dropped", film("right", "top field missing")),
    "bottom field missing": Fault("left_dropped", film("left", "bottom field missing")),
    "one-bit errors of timing codes": Fault("right_corrected", film("right", "one-bit errors of all codes"), kept=True),
    "two-bit error of a timing code": Fault("left_rejected", film("left", "two-bit error of a code")),
    "short line": Fault("right_dropped", film("right", "short line")),
    "long line": Fault("left_dropped", film("left", "long line")),
    "lines missing": Fault("right_dropped", film("right", "lines dropped")),
    "decoder reset": Fault("left_dropped", film("left", "decoder reset")),
    "left camera's domain reset": Fault("left_dropped", camera_reset("left")),
    "memory stalls for 100 us": Fault("display_underflows", _stall(7500)),
    "memory stalls for 400 us": Fault("left_overflow", _stall(30000)),
    "refreshes without end": Fault("display_underflows", _refresh_storm),
    "noise on the host's line": Fault("uart_errors", _line_noise, kept=True),
    "video decoder does not acknowledge": Fault("decoder_failures", _silent("decoder", 0xFF), kept=True),
    "DVI transmitter does not acknowledge": Fault("transmitter_failures", _silent("transmitter", 0x08), kept=True),
}

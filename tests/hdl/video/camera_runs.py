"""A receiver between two clocks, in Amaranth's simulator."""

from dataclasses import dataclass, field

import numpy as np
from amaranth import *
from amaranth.sim import Simulator

from golden.video.formats import CameraFormat
from sim.kit.cases import comparable
from sim.kit.streams import check_rules
from sim.models.camera import frames_of, play


SMALL = CameraFormat(width=6, field_lines=3, blanking=6, before_top=2, after_top=1, before_bottom=1, after_bottom=1)
TINY = CameraFormat(width=4, field_lines=2, blanking=4, before_top=1, after_top=1, before_bottom=1, after_bottom=1)
WIDE = CameraFormat(width=16, field_lines=3, blanking=8, before_top=2, after_top=1, before_bottom=2, after_bottom=1)

COUNTERS = ("corrected", "rejected", "dropped", "overflow")
STATUS = (*COUNTERS, "present")

BYTE = 1 / 27e6
#: Periods of ``sync`` in bytes: 75 MHz and 148.5 MHz to the camera's 27 MHz; a little more and a little less than 1; nearly the slowest.
RATIOS = {"75 MHz": 27 / 75, "148.5 MHz": 27 / 148.5, "faster": 1 / 1.01, "slower": 1.01, "slowest": 1.9}


def pictures(count, format=SMALL, seed=0):
    return list(np.random.default_rng(seed).integers(0, 256, (count, format.height, format.width)))


@dataclass
class Run:
    """Words that left, the cycles of ``sync`` in which they did, and the plain outputs in every cycle."""
    words: list = field(default_factory=list)
    cycles: list = field(default_factory=list)
    status: list = field(default_factory=list)

    def frames(self, format):
        return frames_of(map(comparable, self.words), format)

    def member(self, name):
        """In every cycle."""
        place = STATUS.index(name)
        return [values[place] for values in self.status]

    @property
    def counters(self):
        """Those that are not 0 at the end."""
        return {name: value for name, value in zip(STATUS, self.status[-1]) if value and name in COUNTERS}


def run_camera(dut, data, *, ratio=27 / 75, stall=0.0, phase=0.1 * BYTE, seed=1, drain=60, inputs=None, resets=(), camera_resets=()):
    """Play bytes into a :class:`CameraInput` of the domain ``camera``.

    Parameters
    ----------
    stall : float or callable
        Probability, or function of the cycle, of a low ``o.ready``.
    drain : int
        Cycles of ``sync`` after the last byte; ``o.ready`` as before.
    inputs : callable
        Values of members by name, as a function of the cycle.
    resets : container of int
        Cycles of ``sync`` in which it is in reset.
    camera_resets : sequence of int
        Bytes at which the reset of ``camera`` begins, ends, begins ...
    """
    run = Run()
    rng = np.random.default_rng(seed)
    chance = stall if callable(stall) else lambda cycle: stall
    m = Module()
    m.domains.sync = sync = ClockDomain()
    m.domains.camera = camera = ClockDomain()
    m.submodules.dut = dut

    async def bytes_in(ctx):
        for number, part in enumerate(np.split(np.asarray(data), camera_resets)):
            ctx.set(camera.rst, number % 2)
            await play(ctx, camera.clk, dut.data, part.tolist(), period=BYTE, phase=0 if number else phase)
        await ctx.delay(drain * BYTE * ratio)

    async def watch(ctx):
        cycle = 0
        status = [getattr(dut, name) for name in STATUS]
        while True:
            for name, value in (inputs(cycle) if inputs else {}).items():
                ctx.set(getattr(dut, name), value)
            ctx.set(dut.o.ready, int(rng.random() >= chance(cycle)))
            if resets:
                ctx.set(sync.rst, cycle in resets)
            _, _, *values = await ctx.tick().sample(*status)
            run.status.append(values)
            cycle += 1

    sim = Simulator(m)
    sim.add_clock(BYTE * ratio)
    sim.add_testbench(bytes_in)
    sim.add_testbench(watch, background=True)
    sim.add_testbench(check_rules(dut.o, run.words, run.cycles), background=True)
    sim.run()
    return run

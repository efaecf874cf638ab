# amaranth: UnusedElaboratable=no
import itertools
import random

import pytest
from amaranth import *
from amaranth.sim import Simulator

from golden.pairing import CAMERAS, PLANES, Pairing
from hdl.video.pairing import BufferControl


WRITERS = (*CAMERAS, *PLANES)
INPUTS = ("done", "fetch", "hold", "clear", *(f"{writer}.{event}" for writer in WRITERS for event in ("begin", "complete", "abandoned")))
BITS = {name: 1 << place for place, name in enumerate(INPUTS)}
EVENTS = [name for name in INPUTS if name not in ("hold", "clear")]


def member(dut, name):
    """``"left_camera.begin"`` of a component."""
    name = {"done": "reader.done", "fetch": "display.fetch"}.get(name, name)
    for part in name.split("."):
        dut = getattr(dut, part)
    return dut


class Reference:
    """What the gateware must show in each cycle, by the golden model; its counters are set back by ``clear`` and stop at 16 bits."""

    def __init__(self, buffers, window, life):
        self.rule = Pairing(buffers, window, life)
        self.now = 0
        self.started = None
        self.cleared = [0] * len(BufferControl.COUNTERS)

    def counts(self):
        left, right = self.rule.cameras
        pictures = self.rule.pictures
        return [self.rule.pairs, left.skipped, right.skipped, left.unpaired, right.unpaired, pictures.dropped, pictures.abandoned]

    def clock(self, names):
        """A cycle with these inputs high."""
        counts = self.counts()
        if "clear" in names:
            self.cleared = counts
        self.started = self.rule.clock(self.now, {*names, "hold" if "hold" in names else "release"})
        self.now += 1

    def expected(self):
        """Of each output its value, ``None`` if it may have any."""
        rule = self.rule
        pictures = rule.pictures
        values = [self.started is not None, *(camera.reading for camera in rule.cameras), pictures.shown is not None, pictures.shown]
        for camera in rule.cameras:
            values += [camera.filling is not None, camera.filling]
        for plane in pictures.planes:
            accept = pictures.writing is not None and plane.value == "filling"
            values += [accept, pictures.writing if accept else None]
        values += [min(count - cleared, 2**16 - 1) for count, cleared in zip(self.counts(), self.cleared)]
        return values


def outputs(dut):
    reader, display = dut.reader, dut.display
    values = [reader.start, reader.left_buffer, reader.right_buffer, display.shown_valid, display.shown_buffer]
    for writer in WRITERS:
        values += [member(dut, writer).accept, member(dut, writer).buffer]
    return values + [getattr(dut, name) for name in BufferControl.COUNTERS]


def compare(dut, cycles):
    """Run ``cycles``, sets of inputs that are high, or functions of the golden model that give one; compare all outputs in every cycle.

    Returns the golden model.
    """
    reference = Reference(dut.buffers, dut.window_clocks, dut.life_clocks)
    shown = outputs(dut)
    places = list(itertools.accumulate((len(value) for value in shown), initial=0))
    m = Module()
    m.submodules.dut = dut
    driven = Signal(len(INPUTS))
    seen = Signal(places[-1])
    m.d.comb += [Cat(member(dut, name) for name in INPUTS).eq(driven), seen.eq(Cat(shown))]

    async def testbench(ctx):
        for number, names in enumerate(cycles):
            if callable(names):
                names = names(reference)
            got = ctx.get(seen)
            for index, value in enumerate(reference.expected()):
                if value is not None:
                    found = got >> places[index] & (1 << len(shown[index])) - 1
                    assert found == value, f"cycle {number}: {shown[index].name} is {found}, not {value}"
            ctx.set(driven, sum(BITS[name] for name in names))
            reference.clock(names)
            await ctx.tick()

    simulator = Simulator(m)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return reference


@pytest.mark.parametrize("buffers, window, life, chance", [
    (2, 2, 5, 0.3), (2, 6, None, 0.12), (2, 12, 13, 0.06), (3, 5, None, 0.15), (3, 1, 2, 0.4), (5, 7, 40, 0.1),
])
def test_random(buffers, window, life, chance):
    """Every event at any time, whether it makes sense or not."""
    rng = random.Random(1)
    names = [*EVENTS, "hold", "clear"]
    weights = {"hold": 0.2, "clear": 0.02, **{name: 0.3 for name in EVENTS if name.endswith("abandoned")}}
    cycles = [{name for name in names if rng.random() < chance * weights.get(name, 1.0)} for _ in range(4000)]
    reference = compare(BufferControl(buffers, window, life), cycles)
    assert min(reference.counts()[:1] + reference.counts()[3:5]) > 20
    print(reference.counts())

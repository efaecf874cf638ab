# amaranth: UnusedElaboratable=no
"""hdl.video.system: the fork of a pair, the sizes that follow from the parameters; ``sim/test_system.py`` runs the whole."""

import dataclasses

import numpy as np
import pytest
from amaranth.hdl import Fragment
from amaranth.sim import Simulator

from golden.config import Arithmetic, Engine, MatcherConfig, OnePass
from golden.errors import UserError
from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.rig.maps import identity
from golden.video.bandwidth import MemoryTiming
from golden.video.formats import DISPLAYS, PAL
from hdl.video.ports import DOMAINS
from hdl.video.system import PairFork, StereoSystem
from sim.kit.streams import check_rules, receive, send
from tests.kit import refused_components


DISPLAY = DISPLAYS["720x576"]
SEQUENTIAL = MatcherConfig(labels=6, engine=Engine.SEQUENTIAL, method=OnePass(Arithmetic.THESIS))
STREAMING = MatcherConfig(labels=4, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR))


@pytest.mark.parametrize("stalls", [(0.0, 0.0, 0.0), (0.0, 0.7, 0.0), (0.0, 0.0, 0.7), (0.5, 0.5, 0.5), (0.8, 0.1, 0.1)])
def test_fork(stalls):
    """Each branch gets every pixel once, in order, whoever stalls; no pixel is taken before both have it."""
    rng = np.random.default_rng(1)
    flags = ("first", "last", "end")
    words = [{"left": int(left), "right": int(right), **{flag: int(bit) for flag, bit in zip(flags, rng.integers(0, 2, 3))}}
             for left, right in rng.integers(0, 256, (200, 2))]
    dut = PairFork()
    got = {}

    async def source(ctx):
        await send(ctx, dut.i, words, rng=np.random.default_rng(2), stall=stalls[0])

    def sink(name, stall, seed):
        async def testbench(ctx):
            got[name] = await receive(ctx, getattr(dut, name), len(words), rng=np.random.default_rng(seed), stall=stall)
        return testbench

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    for number, name in enumerate(("matcher", "left")):
        simulator.add_testbench(sink(name, stalls[1 + number], 3 + number))
        simulator.add_testbench(check_rules(getattr(dut, name), [], name=name), background=True)
    simulator.run()
    for name, fields in (("matcher", {"left": "left", "right": "right"}), ("left", {"value": "left"})):
        assert [{field: int(word[field]) for field in (*fields, *flags)} for word in got[name]] == [
            {**{field: word[of] for field, of in fields.items()}, **{flag: word[flag] for flag in flags}} for word in words]


def system(*args, **options):
    component = StereoSystem(*args, **options)
    Fragment.get(component, None)   # Amaranth complains of components that are not used
    return component


def test_sizes_follow_from_the_parameters():
    fast, slow = system(STREAMING, DISPLAY), system(SEQUENTIAL, DISPLAY)
    # One more than needed, for a kept pair.
    assert (fast.memory_map.buffers, slow.memory_map.buffers) == (3, 4)
    assert (fast.control.buffers, fast.budget.buffers, slow.budget.buffers) == (3, 2, 3)
    assert fast.depths == {"left_camera": fast.budget.camera_depth, "right_camera": fast.budget.camera_depth,
                           "pair": fast.budget.matcher_depth, "picture": fast.budget.matcher_depth, "display": fast.budget.display_depth}
    assert fast.control.window_clocks == 5 / 8 * 75_000_000 / 25
    assert fast.serial.register_file.timeout == 750_000
    quick = system(STREAMING, DISPLAY, baud=75_000_000 // 16, setup_hz=500_000)
    assert quick.serial.register_file.timeout == 16 * 1152
    assert (quick.setup_hz, quick.setups["decoder"].clock_hz) == (500_000, 500_000)


def test_window_reaches_all_that_depends_on_it():
    """The control, the number of buffers, and the time that the budget gives the matcher."""
    frame = PAL.frame_seconds
    wide = system(STREAMING, DISPLAY, window=0.75)
    assert wide.control.window_clocks == 0.75 * 75_000_000 / 25
    assert (wide.memory_map.buffers, wide.budget.window, wide.budget.reading_seconds) == (3, 0.75, 0.25 * frame)
    # The matcher takes 0.14 of a frame: with a wider window three buffers are needed, and it then has a whole one.
    wider = system(STREAMING, DISPLAY, window=0.9)
    assert 0.1 * frame < wider.budget.matcher_seconds < 0.25 * frame
    assert (wider.memory_map.buffers, wider.control.buffers, wider.budget.reading_seconds) == (4, 4, frame)
    for window in (0, 1):
        with refused_components(), pytest.raises(ValueError, match=f"window of a pair must be above 0 and below 1 frame, not {window}"):
            StereoSystem(STREAMING, DISPLAY, window=window)


def test_rectification_takes_its_time():
    """A pair takes as long as the slower of matcher and rectifier; the host's registers are there with it only."""
    plain, with_rig = system(STREAMING, DISPLAY), system(STREAMING, DISPLAY, rig=RigConfig(22))
    pixels = PAL.width * PAL.height
    clocks = round(with_rig.budget.matcher_clocks * pixels)
    assert clocks == with_rig.pair_rig.frame_clocks(with_rig.matcher) > round(plain.budget.matcher_clocks * pixels)
    assert clocks < 1.11 * pixels
    # The lines of a slow matcher come after those that the rectifiers wait for.
    slow, alone = (system(SEQUENTIAL, DISPLAY, rig=rig).budget.matcher_clocks for rig in (RigConfig(), None))
    assert alone < slow < 1.02 * alone
    assert "row_offset" in with_rig.registers and "row_offset" not in plain.registers
    assert with_rig.registers["rectify_lines"].reset == 22 and plain.registers["rectify_lines"].reset == 0
    with refused_components(), pytest.raises(ValueError, match="the rig is for pictures of 64x40 pixels, and the cameras send 720x576"):
        StereoSystem(STREAMING, DISPLAY, rig=RigConfig(22, Rig(identity(64, 40), identity(64, 40))))


def test_what_cannot_be():
    with pytest.raises(ValueError, match="lines of 640 pixels, and the cameras send 720: choose the same width"):
        StereoSystem(dataclasses.replace(STREAMING, max_width=640), DISPLAY)
    # Too slow for double buffers, but not for triple ones; too slow for any number of them.
    budget = system(SEQUENTIAL, DISPLAY, timing=MemoryTiming(clock_hz=60_000_000)).budget
    assert 3 / 8 * PAL.frame_seconds < budget.matcher_seconds < PAL.frame_seconds
    with refused_components(), pytest.raises(UserError, match=r"with 3 buffers it has 40\.0 ms: choose"):
        StereoSystem(SEQUENTIAL, DISPLAY, timing=MemoryTiming(clock_hz=50_000_000))


def test_leds():
    """Each shows what the docstring says: its level, the lowest bit of the pairs, whether a chip has failed or a counter is not zero."""
    dut = StereoSystem(MatcherConfig(labels=2, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR)), DISPLAY)
    left, right = dut.cameras.values()
    decoder, transmitter = dut.setups.values()
    # What is set, its values, and the LEDs then.
    cases = [(left.present, {1: 1}), (right.present, {1: 2}), (decoder.locked, {1: 4, 2: 8, 3: 12}), (dut.memory.init_done, {1: 16}),
             (dut.control.pairs, {1: 32, 2: 0, 3: 32}), (decoder.failed, {1: 64}), (transmitter.failed, {1: 64}), *(
                 (counter, {1: 128, 2: 128}) for counter in (
                     left.dropped, right.dropped, dut.control.left_skipped, dut.control.right_skipped, dut.control.pictures_abandoned,
                     dut.display.underflows))]

    async def testbench(ctx):
        for signal, values in cases:
            for value, leds in {**values, 0: 0}.items():
                ctx.set(signal, value)
                await ctx.tick()
                assert ctx.get(dut.leds) == leds, (signal.name, value)

    simulator = Simulator(dut)
    for domain in DOMAINS:
        simulator.add_clock(1e-6, domain=domain)
    simulator.add_testbench(testbench)
    simulator.run()

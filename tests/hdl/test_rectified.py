"""hdl.rectified: the matcher behind rectification and balance, as a stream and behind frame timing signals; settings, maps, errors.

On whole pictures the Verilog is compared: sim/benches/test_rectified.py.
"""

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import FUSED_1, Arithmetic, Engine, MatcherConfig, OnePass, changed
from golden.matcher.matcher import match
from golden.pictures.scenes import scene
from golden.rig.balance import Auto, Fixed
from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.rig.maps import map_sum, pack
from hdl.matcher.framed import FramedMatcher
from hdl.rectified import RectifiedMatcher
from hdl.rig.balance import BalanceMode
from sim.kit.cases import camera, comparable, field_words, pixel_words
from sim.kit.rig_cases import noise_map
from sim.kit.streams import receive, send
from tests.kit import refused_components


WIDTH, HEIGHT, LABELS = 20, 6, 3
CONFIG = MatcherConfig(LABELS, WIDTH, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR))
# With a least disparity as setting.
FUSED = MatcherConfig(LABELS, WIDTH, 1, method=changed(FUSED_1, reach=2, census_rows=3, census_columns=3))
RIGS = [Rig(noise_map(WIDTH, HEIGHT, 60, seed), noise_map(WIDTH, HEIGHT, 60, seed + 1)) for seed in (1, 3)]
RAGGED = ({"first": 1, "last": 0, "end": 0}, {"first": 0, "last": 1, "end": 0}, {"first": 0, "last": 1, "end": 1})


def pairs(count):
    each = [scene(WIDTH, HEIGHT, LABELS, seed)[:2] for seed in range(count)]
    return [(left, (right * 0.7).astype(np.uint8)) for left, right in each]


# Slow: a method whose least disparity is a setting, which moves the windows of the balance.
@pytest.mark.parametrize("config", [CONFIG, pytest.param(FUSED, marks=pytest.mark.slow)], ids=lambda config: config.method.name)
def test_settings_maps_and_errors(config):
    """Built-in maps and settings; others of both after a pulse; maps that are loaded; a ragged frame, after which the next is exact."""
    core = RectifiedMatcher(config, HEIGHT, RigConfig(22, RIGS[0]))
    second = {"minimum": 2} if config.minimum else {}
    frames = pairs(7)
    auto, expected = Auto(config.minimum, LABELS), []
    for number, frame in enumerate(frames[:6]):
        settings = second if number > 2 else {}
        auto.minimum = settings.get("minimum", config.minimum)
        left, right = RIGS[number > 3].rectified(*frame)
        expected.append(match(left, auto.pair(left, right), config.with_settings(settings)))
    assert (auto.gain, auto.offset) != (256, 0)
    expected.append(match(*frames[6], config.with_settings({**second, "u1": 40, "in_use": 2})))
    received = []

    async def apply(ctx, **settings):
        for name, value in {**{name: setting.default for name, setting in core.settings.items()}, **settings}.items():
            ctx.set(getattr(core, name), value)
        await pulse(ctx, "apply_settings")
        for name in core.settings:
            ctx.set(getattr(core, name), 0)

    async def pulse(ctx, name):
        ctx.set(getattr(core, name), 1)
        await ctx.tick()
        ctx.set(getattr(core, name), 0)

    async def load(ctx):
        for side, which in enumerate((RIGS[1].left, RIGS[1].right)):
            ctx.set(core.map_side, side)
            await pulse(ctx, "map_start")
            for word in pack(which):
                for name, part in (("low", word & 65535), ("middle", word >> 16 & 65535), ("high", word >> 32)):
                    ctx.set(getattr(core, f"map_{name}"), part)
                await pulse(ctx, "map_next")
                await ctx.tick().repeat(4)
            assert ctx.get(core.map_sum) == map_sum(pack(which))
        await pulse(ctx, "swap")
        assert ctx.get(core.swapping) == 1

    async def frame(ctx, number):
        """Send one, and wait until its disparities have been received."""
        await send(ctx, core.i, pixel_words(*frames[number]), rng=np.random.default_rng(1))
        received.append([comparable(word) for word in await receive(ctx, core.o, WIDTH * HEIGHT, rng=np.random.default_rng(1))])

    async def testbench(ctx):
        ctx.set(core.o.ready, 0)
        for number in range(3):
            await frame(ctx, number)
        await apply(ctx, **second)
        await frame(ctx, 3)
        await load(ctx)
        await frame(ctx, 4)
        assert ctx.get(core.swapping) == 0
        await frame(ctx, 5)
        assert (ctx.get(core.gain), ctx.get(core.offset)) == (auto.gain, auto.offset)
        assert (ctx.get(core.left_mean), ctx.get(core.right_mean)) == (auto.statistics.left_mean, auto.statistics.right_mean)
        assert (ctx.get(core.error), ctx.get(core.fault), ctx.get(core.abandoned)) == (0, 0, 0)
        await apply(ctx, **second, rectify=0, balance=BalanceMode.OFF, u1=40, in_use=2)
        await frame(ctx, 6)
        assert ctx.get(core.error) == 0
        await apply(ctx)
        ctx.set(core.o.ready, 1)
        # The last line is shorter than the first one: of a picture of two lines and two pixels nothing but its last one is missing.
        await send(ctx, core.i, [{"left": 9, "right": 9, **flags} for flags in RAGGED], rng=np.random.default_rng(1))
        await ctx.tick().repeat(500)
        assert ctx.get(core.error) == 1
        await pulse(ctx, "clear")
        await ctx.tick()
        assert ctx.get(core.error) == 0
        ctx.set(core.o.ready, 0)
        await apply(ctx, **second, rectify=0, balance=BalanceMode.OFF, u1=40, in_use=2)
        await frame(ctx, 6)

    sim = Simulator(core)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    for number, (given, wanted) in enumerate(zip(received, [*expected, expected[-1]], strict=True)):
        assert given == field_words(wanted), f"frame {number}"


def test_behind_frame_timing():
    """A camera with a pause after its frame, which the lines take that the maps need; then another setting of the stages."""
    core = RectifiedMatcher(CONFIG, HEIGHT, RigConfig(22, RIGS[0]))
    dut = FramedMatcher(CONFIG, core)
    assert {"rectify", "map_low", "fault", "error", "u1", "clear", "dropped"} <= {*dut.signature.members}
    (left, right), signals = pairs(1)[0], ("frame_valid", "line_valid", "pixel_valid", "left", "right")
    cycles = camera(pixel_words(left, right), rng=np.random.default_rng(1), gaps=0.5, line_gap=30)
    frame = [dict(zip(signals, cycle)) for cycle in cycles] + [{"frame_valid": 0}] * 900
    reset = [{"reset_n": 0, "disparity_ready": 1}, {}, {}, {"reset_n": 1}, {}, {}, {}, {}]
    fixed = {"rectify": 1, "balance": BalanceMode.FIXED, "fixed_gain": 400, "fixed_offset": -3000, "width": WIDTH, "height": HEIGHT,
             "in_use": LABELS, **CONFIG.rule.weights._asdict()}
    words = []

    async def testbench(ctx):
        for step in [*reset, *frame, {**fixed, "apply_settings": 1}, {"rectify": 0, "apply_settings": 0}, *frame]:
            for name, value in step.items():
                ctx.set(getattr(dut, name), value)
            await ctx.delay(1e-6)
            if ctx.get(dut.disparity_valid):
                words.append(ctx.get(dut.disparity))
            ctx.set(dut.clk, 1)
            await ctx.delay(1e-6)
            ctx.set(dut.clk, 0)
        assert (ctx.get(dut.error), ctx.get(dut.dropped), ctx.get(dut.fault)) == (0, 0, 0)

    sim = Simulator(dut)
    sim.add_testbench(testbench)
    sim.run()
    left, right = RIGS[0].rectified(left, right)
    expected = [match(left, each, CONFIG)["disparity"].ravel().tolist() for each in (right, Fixed(400, -3000).pair(left, right))]
    assert words == expected[0] + expected[1] and expected[0] != expected[1]


def test_a_rig_of_another_size_is_refused():
    with refused_components(), pytest.raises(ValueError, match=r"^the rig is for pictures of 20x6 pixels.*send 20x7; calibrate"):
        RectifiedMatcher(CONFIG, HEIGHT + 1, RigConfig(22, RIGS[0]))

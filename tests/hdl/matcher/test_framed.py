import numpy as np
from amaranth.sim import Simulator

from golden.config import Arithmetic, MatcherConfig, OnePass, changed
from golden.matcher.labelling import match
from golden.pictures.scenes import scene
from hdl.matcher.framed import FramedMatcher
from sim.kit.cases import between_frames, camera, disparity_words, noise, pixel_words


CONFIG = MatcherConfig(labels=6, max_width=16, method=OnePass(Arithmetic.LINEAR))
CAMERA = ("frame_valid", "line_valid", "pixel_valid", "left", "right")


def run_system(dut, steps, drain=1000):
    """Play a dict of inputs in each clock; return the words given, and ``error`` and ``dropped`` before each clock."""
    words, status = [], []

    async def testbench(ctx):
        for step in [*steps, *({"frame_valid": 0} for _ in range(drain))]:
            for name, value in step.items():
                ctx.set(getattr(dut, name), value)
            await ctx.delay(1e-6)
            status.append((ctx.get(dut.error), ctx.get(dut.dropped)))
            if ctx.get(dut.disparity_valid) and ctx.get(dut.disparity_ready):
                words.append({name: ctx.get(getattr(dut, f"disparity{suffix}")) for name, suffix in
                              (("disparity", ""), ("first", "_first"), ("last", "_last"), ("end", "_end"))})
            ctx.set(dut.clk, 1)
            await ctx.delay(1e-6)
            ctx.set(dut.clk, 0)

    sim = Simulator(dut)
    sim.add_testbench(testbench)
    sim.run()
    return words, status


def show(left, right, seed=1):
    """A frame as the camera sends it, at the matcher's pace, and a pause after it."""
    cycles = camera(pixel_words(left, right), rng=np.random.default_rng(seed), gaps=0.8, line_gap=20) + between_frames(300)
    return [dict(zip(CAMERA, cycle)) for cycle in cycles]


RESET = [{"reset_n": 0, "disparity_ready": 1}, {}, {}, {"reset_n": 1}, *({} for _ in range(5))]


def test_frames():
    """Camera in, disparities out; weights; a reset, even in mid-frame, brings the built-in ones back."""
    left, right, _ = scene(14, 4, 6, seed=1)
    weighted = MatcherConfig(labels=6, max_width=16, in_use=5, method=changed(OnePass(Arithmetic.LINEAR), u1=63, u2=2, u3=30))
    expected = [disparity_words(match(left, right, config)) for config in (CONFIG, weighted)]
    assert expected[0] != expected[1]
    frame = show(left, right)
    weights = {"u1": 63, "u2": 2, "u3": 30, "in_use": 5}
    words, status = run_system(FramedMatcher(CONFIG), [
        *RESET, *frame, {**weights, "apply_settings": 1}, {"u1": 1, "apply_settings": 0}, *frame,
        *frame[:40], *RESET, {"frame_valid": 0}, {}, *frame])
    assert words == [*expected[0], *expected[1], *expected[0]]
    assert set(status) == {(0, 0)}


def test_error_and_clear():
    """A short line raises ``error``, which stays until ``clear``."""
    frame = show(*noise(5, 3, 1))
    # One pixel of the second line is not seen.
    lost = [n for n, step in enumerate(frame) if step["line_valid"] and step["pixel_valid"] and step["frame_valid"]][7]
    ragged = [{**step, "pixel_valid": 0} if n == lost else step for n, step in enumerate(frame)]
    steps = [*RESET, *ragged, *frame, {"clear": 1}, {"clear": 0}, *frame]
    words, status = run_system(FramedMatcher(CONFIG), steps)
    assert words[-15:] == words[-30:-15]
    errors = [error for error, _ in status]
    first, last = errors.index(1), len(errors) - 1 - errors[::-1].index(1)
    assert all(errors[first:last + 1])
    assert last == len(RESET) + 2 * len(frame)


def test_dropped():
    """Nobody takes a word: the second frame finds the first one's pixels still waiting."""
    dut = FramedMatcher(CONFIG)
    assert dut.dropped.shape() == dut.timing.dropped.shape()
    frame = show(*noise(16, 8, 1))
    words, status = run_system(dut, [*RESET, {"disparity_ready": 0}, *frame, *frame, {"disparity_ready": 1}])
    assert status[-1] == (0, 1)
    assert len(words) == 16 * 8


def test_reset_holds():
    """Nothing is output while the button is pressed."""
    dut = FramedMatcher(CONFIG)
    frame = show(*noise(5, 3, 1))
    words, _ = run_system(dut, [*RESET, {"reset_n": 0}, *frame])
    assert words == []

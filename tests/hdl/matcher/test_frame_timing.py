# amaranth: UnusedElaboratable=no
from itertools import accumulate

import numpy as np
import pytest
from amaranth import *
from amaranth.sim import Simulator

from hdl.matcher.frame_timing import FrameTiming
from sim.kit.cases import between_frames, camera, comparable, noise, pixel_words
from sim.kit.streams import check_rules


IDLE = (0, 0, 0)   # frame valid, line valid, pixel valid


def run_timing(dut, cycles, *, rng, stall=0.0, drain=80, resets=(), elaboratable=None, reset=None):
    """Play the cycles; ``stall`` may be a function of the cycle. Return words given, ``dropped`` after each cycle, cycles of the words."""
    given, at, dropped = [], [], []
    chance = stall if callable(stall) else lambda cycle: stall

    async def play(ctx):
        for number, (frame_valid, line_valid, pixel_valid, *greys) in enumerate([*cycles, *(IDLE for _ in range(drain))]):
            ctx.set(dut.frame_valid, frame_valid)
            ctx.set(dut.line_valid, line_valid)
            ctx.set(dut.pixel_valid, pixel_valid)
            if greys:
                ctx.set(dut.left, greys[0])
                ctx.set(dut.right, greys[1])
            ctx.set(dut.o.ready, int(rng.random() >= chance(number)))
            if reset is not None:
                ctx.set(reset, number in resets)
            await ctx.tick()
            dropped.append(ctx.get(dut.dropped))

    sim = Simulator(elaboratable or dut)
    sim.add_clock(1e-6)
    sim.add_testbench(play)
    sim.add_testbench(check_rules(dut.o, given, at), background=True)
    sim.run()
    return [comparable(word) for word in given], dropped, at


PATTERNS = {
    "shortest gaps": {"line_gap": 1},
    "frame valid around the lines": {"line_gap": 3, "before": 2, "after": 2},
    "frame valid falls a cycle after line valid": {"after": 1},
    "gaps in lines": {"gaps": 0.5, "line_gap": 2, "before": 1},
}


@pytest.mark.parametrize("stall", [0.0, 0.3])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_flags(pattern, stall):
    """Frames of all sizes, one-pixel lines and one-pixel frames among them."""
    rng = np.random.default_rng(1)
    frames = [pixel_words(*noise(*size, seed)) for seed, size in enumerate([(5, 3), (1, 4), (1, 1), (7, 1), (2, 2), (1, 1)])]
    cycles = between_frames(3)
    for words in frames:
        cycles += camera(words, rng=rng, **PATTERNS[pattern]) + between_frames(40)
    given, dropped, _ = run_timing(FrameTiming(depth=64), cycles, rng=rng, stall=stall)
    assert given == [word for words in frames for word in words]
    assert not any(dropped)


def test_latency():
    """Two cycles after the pixel that follows; the last one, after frame valid falls."""
    rng = np.random.default_rng(1)
    words = pixel_words(*noise(4, 1, 1))
    cycles = between_frames(4) + camera(words, rng=rng) + between_frames(4)
    given, _, at = run_timing(FrameTiming(depth=8), cycles, rng=rng)
    assert given == words
    assert at == [4 + n + 1 + 2 for n in range(4)]


def test_first_frame_after_reset_is_waited_for():
    """What is left of a frame at power-on is not sent, and not counted: nothing was dropped that had begun."""
    rng = np.random.default_rng(1)
    words = pixel_words(*noise(5, 3, 1))
    cycles = camera(words[7:], rng=rng) + between_frames(20) + camera(words, rng=rng) + between_frames(1)
    given, dropped, _ = run_timing(FrameTiming(depth=64), cycles, rng=rng)
    assert given == words
    assert not any(dropped)


@pytest.mark.parametrize("at", range(6, 22, 3))
def test_reset_in_mid_frame(at):
    rng = np.random.default_rng(1)
    words = pixel_words(*noise(5, 3, 1))
    dut = FrameTiming(depth=64)
    reset = Signal()
    cycles = between_frames(5) + camera(words, rng=rng) + between_frames(20)
    given, dropped, _ = run_timing(dut, [*cycles, *cycles], rng=rng, resets=[at], elaboratable=ResetInserter(reset)(dut), reset=reset)
    rest = given[-len(words):]
    assert rest == words
    begun = given[:-len(words)]
    assert begun == words[:len(begun)]
    assert not any(dropped)


def test_overflow_gives_up_from_that_pixel_on():
    """Nobody takes a word: the FIFO fills, the frame ends there, the next one is dropped whole, and the one after recovery is whole."""
    rng = np.random.default_rng(1)
    frames = [pixel_words(*noise(5, 3, seed)) for seed in range(4)]
    cycles = []
    ends = []
    for words in frames:
        cycles += between_frames(20) + camera(words, rng=rng) + between_frames(10)
        ends.append(len(cycles))
    # From the end of the second frame on all is taken at once.
    given, dropped, _ = run_timing(FrameTiming(depth=4), cycles, rng=rng, stall=lambda cycle: float(cycle < ends[1]))
    begun = len(given) - 2 * 15
    assert 4 <= begun <= 6
    assert given == frames[0][:begun] + frames[2] + frames[3]
    assert [dropped[end - 1] for end in ends] == [1, 2, 2, 2]


def test_overflow_by_the_last_pixel():
    """The pixel that does not fit is the last of its frame."""
    rng = np.random.default_rng(1)
    counts = set()
    for pixels in range(3, 9):
        words = pixel_words(*noise(pixels, 1, 1))
        given, dropped, _ = run_timing(FrameTiming(depth=4), between_frames(2) + camera(words, rng=rng) + between_frames(10), rng=rng,
                                       stall=lambda cycle, pixels=pixels: float(cycle < pixels + 12))
        lost = len(words) - len(given)
        assert given == words[:len(given)]
        assert dropped[-1] == (lost > 0)
        counts.add(lost)
    assert {0, 1, 2} <= counts


@pytest.mark.parametrize("seed", range(4))
def test_frames_are_whole_or_cut_and_counted(seed):
    """Whatever the consumer does: each frame is output whole, cut, or not at all; the last two are counted."""
    rng = np.random.default_rng(seed)
    frames = []
    for number in range(40):
        left, right = noise(int(rng.integers(1, 7)), int(rng.integers(1, 4)), number)
        frames.append(pixel_words(left, np.full_like(right, number)))   # the right picture tells the frame
    cycles = between_frames(2)
    for words in frames:
        cycles += camera(words, rng=rng, gaps=0.3, line_gap=int(rng.integers(1, 4))) + between_frames(int(rng.integers(1, 20)))
    mood = rng.choice([0.0, 0.5, 0.95], len(cycles) // 50 + 1)
    given, dropped, _ = run_timing(FrameTiming(depth=4), cycles, rng=rng, stall=lambda cycle: mood[min(cycle // 50, len(mood) - 1)])
    expected, lost = [], 0
    for number, words in enumerate(frames):
        count = sum(word["right"] == number for word in given)
        expected += words[:count]
        lost += count < len(words)
    assert given == expected
    assert dropped[-1] == lost
    assert 0 < lost < len(frames)
    assert list(accumulate(dropped, max)) == dropped


def test_count_of_dropped_frames_stays_at_its_greatest():
    dut = FrameTiming(depth=4)

    async def testbench(ctx):
        ctx.set(dut.dropped, 2**16 - 3)
        for expected in (2**16 - 3, 2**16 - 2, 2**16 - 1, 2**16 - 1):   # the first frame fills the FIFO
            for valid in (0, 1, 1, 0, 0, 0):
                for member in (dut.frame_valid, dut.line_valid, dut.pixel_valid):
                    ctx.set(member, valid)
                await ctx.tick()
            assert ctx.get(dut.dropped) == expected

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()


def test_bad_depth():
    with pytest.raises(ValueError, match=r"at least 4 pixels, not 3$"):
        FrameTiming(depth=3)

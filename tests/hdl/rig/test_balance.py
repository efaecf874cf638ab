# amaranth: UnusedElaboratable=no
"""hdl.rig.balance: bit-exact with golden.rig.balance, pair by pair."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.rig.balance import BALANCE_OFF, LEAST_DEVIATION, Auto, Fixed, measure, target
from hdl.rig.balance import Balance, BalanceMode
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.frames import run_frames
from sim.kit.streams import check_rules, send


OFF, AUTO, FIXED = BalanceMode
STATUS = ("left_mean", "right_mean", "left_deviation", "right_deviation", "gain", "offset")


def darker(width, height, seed, gain=0.7, offset=0):
    """A pair whose right picture is the left one, darker, and another one where that is too simple."""
    left, other = noise(width, height, seed)
    return left, np.clip(np.where(other < 250, left, other) * gain + offset, 0, 255).astype(int)


def settings(left, mode=AUTO, minimum=0, gain=0, offset=0):
    height, width = left.shape
    return {"mode": int(mode), "width": width, "height": height, "minimum": minimum & 511, "fixed_gain": gain,
            "fixed_offset": offset & 65535}


def balance(width=40, height=24, labels=8):
    return Balance(width, height, labels)


def expected(frames, labels=8):
    """Output of (pair, settings) in golden; *auto* begins anew after another mode."""
    auto, result = None, []
    for (left, right), inputs in frames:
        minimum = inputs["minimum"] - (inputs["minimum"] >> 8 << 9)
        if inputs["mode"] == AUTO:
            auto = auto or Auto(minimum, labels)
            auto.minimum = minimum
            right = auto.pair(left, right)
        else:
            auto = None
            signed = inputs["fixed_offset"] - (inputs["fixed_offset"] >> 15 << 16)
            right = (Fixed(inputs["fixed_gain"], signed) if inputs["mode"] == FIXED else BALANCE_OFF).pair(left, right)
        result += pixel_words(left, right)
    return result


def check(frames, *, labels=8, stall=0.0, **size):
    words = [(pixel_words(*pair), inputs) for pair, inputs in frames]
    out = run_frames(balance(labels=labels, **size), words, rng=np.random.default_rng(1), stall_i=stall, stall_o=stall)
    wanted = expected(frames, labels)
    assert [comparable(word) for word in out] == wanted
    return wanted


def test_auto_follows():
    """Gain and offset settle, then change with the right camera; the last pairs differ from the first."""
    pairs = [darker(19, 9, seed, *change) for seed, change in enumerate([(0.7,)] * 3 + [(0.5, 40)] * 3 + [(1, -30)] * 2)]
    frames = [(pair, settings(pair[0])) for pair in pairs]
    check(frames)
    auto = Auto(0, 8)
    gains = [auto.gain for left, right in pairs if auto.pair(left, right) is not None]
    assert len(set(gains)) == len(pairs)


# Slow: windows at the edges on both sides.
@pytest.mark.parametrize("minimum, labels", [(1, 8), (-7, 8), pytest.param(-64, 16, marks=pytest.mark.slow),
                                             pytest.param(255, 2, marks=pytest.mark.slow)])
def test_windows(minimum, labels):
    """Pictures of several sizes, with windows at their edges: means and deviations tell which pixels were measured."""
    sizes = [(40, 24), (40, 24), (33, 17), (31, 8), (2, 2)]
    pairs = [noise(*size, seed) for seed, size in enumerate(sizes)]
    check([(pair, settings(pair[0], minimum=minimum)) for pair in [*pairs, pairs[0]]], labels=labels)


def test_modes_change():
    """*Auto* begins anew after another mode, also where a frame with that mode was not measured."""
    modes = [AUTO, AUTO, AUTO, OFF, AUTO, AUTO, AUTO, FIXED, AUTO, FIXED, OFF]
    pairs = [darker(12, 6, seed, 0.4 + 0.05 * seed) for seed in range(len(modes))]
    fixed = {7: (512, -16384), 9: (128, 16384), 10: (300, 5)}
    frames = [(pair, settings(pair[0], mode, 0, *fixed.get(number, (0, 0)))) for number, (pair, mode) in enumerate(zip(pairs, modes))]
    frames[3][1]["width"] += 1
    check(frames, stall=0.3)


def test_no_contrast_is_held():
    """A black or flat right picture changes nothing: what was measured before still holds; limits of gain and offset."""
    flat = np.full((8, 16), 77)
    left, right = darker(16, 8, 1)
    dim = left // 8 + 100
    least = flat + np.where(np.arange(16) % 2, 2, -2)
    assert measure(left, least, 0, 8).right_deviation == LEAST_DEVIATION
    pairs = [(left, flat), (left, flat), (left, right), (left, right), (left, 0 * flat), (left, right), (left, dim), (dim, left),
             (left, least), (left, least), (left, right)]
    assert target(measure(left, dim, 0, 8))[0] == 512 and target(measure(dim, left, 0, 8))[0] == 128
    check([(pair, settings(pair[0])) for pair in pairs])


def drive(frames, **size):
    """Send frames of words; return the output, status after each frame, and the cycles of transfers."""
    dut = balance(**size)
    rng = np.random.default_rng(4)
    taken, given, cycles, status = [], [], {"i": [], "o": []}, []

    async def source(ctx):
        ctx.set(dut.o.ready, 1)
        for words, inputs in frames:
            for name, value in inputs.items():
                ctx.set(getattr(dut, name), value)
            await send(ctx, dut.i, words, rng=rng)
            await ctx.tick().repeat(200)
            status.append({name: ctx.get(getattr(dut, name)) for name in STATUS})

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(check_rules(dut.i, taken, cycles["i"]), background=True)
    simulator.add_testbench(check_rules(dut.o, given, cycles["o"]), background=True)
    simulator.run()
    return [comparable(word) for word in given], status, cycles


def test_status_latency_and_frames_of_another_size():
    """A frame that is not as large as told, or that is cut, is balanced and not measured."""
    pairs = [darker(13, 6, seed) for seed in range(5)]
    small = darker(12, 6, 9)
    words = [pixel_words(*pair) for pair in pairs]
    cut = words[3][:30]
    told = settings(pairs[0][0])
    sent = [words[0], pixel_words(*small), words[1], words[2], cut, words[4]]
    given, status, cycles = drive([(each, told) for each in sent])
    auto = Auto(0, 8)
    wanted = []
    for name, (left, right) in {0: pairs[0], 1: small, 2: pairs[1], 3: pairs[2], 4: pairs[3], 5: pairs[4]}.items():
        gain, offset = auto.gain, auto.offset
        if name in (1, 4):
            right = Fixed(gain, offset).pair(left, right)
        else:
            right = auto.pair(left, right)
        wanted += pixel_words(left, right)[:30 if name == 4 else None]
        assert (status[name]["gain"], status[name]["offset"]) == (auto.gain, auto.offset)
        found = auto.statistics
        assert (status[name]["left_mean"], status[name]["right_mean"]) == (found.left_mean, found.right_mean)
        if name > 1:    # of the first pair no deviation is known
            assert (status[name]["left_deviation"], status[name]["right_deviation"]) == (found.left_deviation, found.right_deviation)
    assert given == wanted
    assert cycles["i"][0] == Balance.frame_clocks
    assert [b - a for a, b in zip(cycles["i"], cycles["o"])] == [Balance.latency] * len(given)

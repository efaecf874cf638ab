import numpy as np
import pytest

from golden.config import RECURSIVE_1, MatcherConfig, changed
from golden.matcher.recursive.border_fill import border_fill, border_slope
from golden.matcher.refine import fill
from hdl.matcher.refine.border_fill import BorderFill
from sim.kit.cases import comparable, label_words
from sim.kit.frames import run_frames
from sim.kit.streams import run_stream


def config_of(labels=80, max_width=60, *, sub_pixel=False):
    return MatcherConfig(labels=labels, max_width=max_width, method=changed(RECURSIVE_1, sub_pixel=sub_pixel))


def picture(rng, config, width, height):
    """Labels, which passed, sizes of supports and grey levels.

    Lines start with up to 20 pixels that fail. Most are a surface from there on, flat or as steep as its steps allow; some have a step that
    is too high, some are noise, some fail altogether.
    """
    scale = config.method.disparity_scale
    greatest = (config.labels - 1) * scale
    labels = rng.integers(0, greatest + 1, (height, width))
    passed = rng.random((height, width)) < rng.choice([0.5, 0.8, 1.0], (height, 1))
    for y in range(height):
        least, most = rng.choice([[-scale, scale], [0, scale], [-scale, 0], [scale, scale], [-scale, -scale], [-1, 1]])
        steps = np.where(passed[y], rng.integers(least, most + 1, width), 0)
        if rng.random() < 0.3:
            steps[rng.integers(width)] += rng.choice([-1, 1])
        surface = np.clip(rng.integers(0, greatest + 1) + np.cumsum(steps), 0, greatest)
        labels[y] = np.where(passed[y] & (rng.random() < 0.8), surface, labels[y])
        passed[y, :rng.integers(21) * (rng.random() < 0.9)] = False
    passed[rng.random(height) < 0.1] = False
    return labels, passed, rng.integers(1, config.refined.arms.support_max + 1, labels.shape), rng.integers(0, 256, labels.shape)


def filled(config, labels, passed):
    return border_fill(labels, passed, config.labels, config.method.disparity_scale)


def check(config, sizes, *, seed=1, stall_i=0.0, stall_o=0.0):
    """Frames in a row, the stage on for two of three; each is exact. Returns how many labels are not those of the plain fill."""
    rng = np.random.default_rng(seed)
    frames, expected, sloped = [], [], 0
    for number, size in enumerate(sizes):
        labels, *rest = picture(rng, config, *size)
        enable = number % 3 != 1
        result = filled(config, labels, rest[0]) if enable else labels
        sloped += np.count_nonzero(result != fill(labels, rest[0])) if enable else 0
        frames.append((label_words(labels, *rest), {"enable": enable}))
        expected += label_words(result, *rest)
    given = run_frames(BorderFill(config), frames, rng=rng, stall_i=stall_i, stall_o=stall_o, timeout=2000)
    assert [comparable(word) for word in given] == expected
    return sloped


# Slow: one stall at a time, of which the other is made; without a stall is test_every_span.
@pytest.mark.parametrize("stall_i, stall_o", [
    (0.3, 0.3), *(pytest.param(*stalls, marks=pytest.mark.slow) for stalls in ((0.0, 0.0), (0.4, 0.0), (0.0, 0.4), (0.0, 0.9)))])
def test_matches_golden(stall_i, stall_o):
    """Frames of all sizes in a row, the narrowest behind the widest."""
    rng = np.random.default_rng(2)
    sizes = [(1, 1), (60, 8), (1, 40), (60, 1), (17, 3), (18, 9), (2, 30), *((int(rng.integers(17, 61)), 8) for _ in range(5))]
    assert check(config_of(), sizes, stall_i=stall_i, stall_o=stall_o) > 20


@pytest.mark.parametrize("max_width", [1, 2, 17, 18])
def test_narrow_memories(max_width):
    """The narrowest line with a slope at its border has 18 pixels."""
    sloped = check(config_of(max_width=max_width), [(max_width, 40), (1, 5), (max_width, 1)] * 2, stall_o=0.2)
    assert (sloped > 0) == (max_width == 18)


@pytest.mark.parametrize("labels, sub_pixel", [(2, False), (3, True), (17, False), (40, True), (256, False), (256, True)])
def test_labels(labels, sub_pixel):
    """Up to surfaces that leave the range of labels on either side, as all do that have two labels."""
    config = config_of(labels, sub_pixel=sub_pixel)
    sloped = check(config, [(50, 12), (60, 12), (37, 12)], stall_i=0.2, stall_o=0.2)
    assert (sloped > 5) == (labels > 2)


# Slow: each other span, but for the shortest and the longest ones, whose surfaces go on or not.
@pytest.mark.parametrize("span, sub_pixel", [
    pytest.param(span, sub_pixel, marks=[] if span in (15, 16, 32, 33) or span % 2 == sub_pixel else pytest.mark.slow)
    for span in range(14, 35) for sub_pixel in (False, True)])
def test_every_span(span, sub_pixel):
    """Rising and falling surfaces from one label in all to one a column, that end with a passing pixel and then a step or the line."""
    config = config_of(labels=120, sub_pixel=sub_pixel)
    scale, lines = config.method.disparity_scale, []
    for fall in (1, span // 3, span - 1, span):
        for sign in (-1, 1):
            surface = 60 * scale + sign * (np.arange(span + 1) * fall * scale // span)
            for behind in ([], [surface[-1] + sign * (scale + 1)] * 3):
                line = np.concatenate([np.zeros(9), surface, behind, np.full(60 - 10 - span - len(behind), 7)])
                lines.append((line, (np.arange(60) >= 9) & (np.arange(60) < 10 + span + len(behind))))
    labels, passed = (np.array(part).astype(kind) for part, kind in zip(zip(*lines), (int, bool)))
    found = [border_slope(line, which, scale)[1] != 0 for line, which in lines]
    assert any(found) == (span >= 16)
    rest = passed, np.ones_like(labels), np.zeros_like(labels)
    given = run_stream(BorderFill(config), label_words(labels, *rest), rng=np.random.default_rng(1), inputs={"enable": 1}, timeout=300)
    assert [comparable(word) for word in given] == label_words(filled(config, labels, passed), *rest)


def test_pixels_far_away():
    """The surface does not reach pixels that are far away, however far, though none between passes."""
    config = config_of(max_width=200)
    labels = np.tile(np.maximum(60 - np.arange(200), 40), (20, 1))
    passed = np.tile((np.arange(200) >= 5) & (np.arange(200) < 26), (20, 1))
    for line, which in enumerate(passed):
        which[35 + 8 * line:] = True
    labels[:, 30:] = 41 - np.arange(20)[:, None] % 3
    rest = passed, np.ones_like(labels), np.zeros_like(labels)
    given = run_stream(BorderFill(config), label_words(labels, *rest), rng=np.random.default_rng(1), inputs={"enable": 1}, timeout=300)
    assert [comparable(word) for word in given] == label_words(filled(config, labels, passed), *rest)


@pytest.mark.parametrize("labels, sub_pixel", [(18, False), (40, True)])
@pytest.mark.parametrize("width", [18, 40, 130])
def test_greatest_rise(width, labels, sub_pixel):
    """The steepest surfaces as far to the right as they may be."""
    config = config_of(labels, width, sub_pixel=sub_pixel)
    scale, lines = config.method.disparity_scale, []
    for span in range(16, min(32, width - 2, labels - 1) + 1):
        surface = np.full(width, span * scale)
        surface[-span - 1:] = np.arange(span, -1, -1) * scale
        lines += [surface, span * scale - surface]
    labels = np.array(lines)
    passed = np.arange(width) >= width - 1 - np.repeat(np.arange(16, 16 + len(lines) // 2), 2)[:, None]
    rest = passed, np.ones_like(labels), np.zeros_like(labels)
    result = filled(config, labels, passed)
    assert {result[0, 0], result[1, 0]} == {min(width, config.labels) * scale - scale, 0}
    given = run_stream(BorderFill(config), label_words(labels, *rest), rng=np.random.default_rng(1), inputs={"enable": 1}, timeout=1000)
    assert [comparable(word) for word in given] == label_words(result, *rest)


@pytest.mark.parametrize("width", [1, 2, 3, 12, 60])
def test_rate_and_latency(width):
    """A pixel a cycle over lines and frames, up to the greatest width; a line and ``latency`` cycles, whatever passed."""
    config = config_of()
    rng = np.random.default_rng(1)
    dut = BorderFill(config)
    cycles = {}
    frames = [(label_words(*picture(rng, config, width, height)), {"enable": 1}) for height in (5, 1, 30)]
    run_frames(dut, frames, rng=rng, cycles=cycles)
    assert np.unique(np.diff(cycles["i"])).tolist() == [1 + dut.line_clocks]
    assert np.unique(np.subtract(cycles["o"], cycles["i"])).tolist() == [dut.lines * width + dut.latency]


def test_lines_wait():
    """While nothing is output, as many lines of one pixel are accepted as have room; then all are exact."""
    config = config_of()
    rng = np.random.default_rng(1)
    labels, *rest = picture(rng, config, 1, 50)
    cycles = {}
    given = run_stream(BorderFill(config), label_words(labels, *rest), rng=rng, stall_o=0.97, inputs={"enable": 1}, cycles=cycles)
    assert [comparable(word) for word in given] == label_words(filled(config, labels, rest[0]), *rest)
    waiting = [number - np.searchsorted(cycles["o"], cycle) for number, cycle in enumerate(cycles["i"])]
    behind = BorderFill.OUTPUT_CLOCKS + 1   # the last register holds two words
    assert BorderFill.LINES <= max(waiting) + 1 <= BorderFill.LINES + behind


def test_line_leaves_when_complete():
    """The first line is output although the second is incomplete, which is held."""
    config = config_of()
    rng = np.random.default_rng(1)
    labels, *rest = picture(rng, config, 12, 2)
    words = label_words(filled(config, labels, rest[0]), *rest)
    given = run_stream(BorderFill(config), label_words(labels, *rest)[:17], rng=rng, count=12, drain=50, timeout=50, inputs={"enable": 1})
    assert [comparable(word) for word in given] == words[:12]

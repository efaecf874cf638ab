import numpy as np
import pytest

from golden.config import FUSED_1, Fused, MatcherConfig, changed
from golden.matcher.refine import fill
from hdl.matcher.refine.fill import Fill
from sim.kit.cases import comparable, label_words
from sim.kit.frames import run_frames
from sim.kit.streams import run_stream


def config_of(disparities=80, max_width=40, *, sub_pixel=False):
    return MatcherConfig(labels=disparities, max_width=max_width, method=changed(FUSED_1, sub_pixel=sub_pixel))


def picture(rng, config, width, height, share):
    """Labels, which passed (about ``share`` of them), and sizes of supports."""
    greatest = config.labels * config.method.disparity_scale - 1
    labels = np.where(rng.random((height, width)) < 0.3, rng.choice([0, greatest], (height, width)),
                      rng.integers(0, greatest + 1, (height, width)))
    return labels, rng.random((height, width)) < share, rng.integers(1, config.method_as(Fused).arms.support_max + 1, (height, width))


def check(config, sizes, *, seed=1, stall_i=0.0, stall_o=0.0, shares=(0.0, 0.1, 0.5, 0.9, 1.0)):
    """Frames in a row, the stage on for two of three; each is exact."""
    rng = np.random.default_rng(seed)
    frames, expected = [], []
    for number, size in enumerate(sizes):
        labels, passed, n = picture(rng, config, *size, shares[number % len(shares)])
        enable = number % 3 != 1
        frames.append((label_words(labels, passed, n), {"enable": enable}))
        expected += label_words(fill(labels, passed) if enable else labels, passed, n)
    given = run_frames(Fill(config), frames, rng=rng, stall_i=stall_i, stall_o=stall_o, timeout=300)
    assert [comparable(word) for word in given] == expected


STALLS = [(0.0, 0.0), (0.4, 0.0), (0.0, 0.4), (0.3, 0.3), (0.0, 0.9)]


# Slow: with one width and stall what is seen with the others, by turns.
@pytest.mark.parametrize("max_width, stall_i, stall_o", [
    pytest.param(width, *stalls, marks=pytest.mark.slow if (n + number) % 2 else [])
    for n, width in enumerate((1, 2, 40)) for number, stalls in enumerate(STALLS)])
def test_matches_golden(max_width, stall_i, stall_o):
    """Frames of all sizes in a row, among them the widest."""
    rng = np.random.default_rng(2)
    sizes = [(1, 1), (max_width, 3), (1, 8), (max_width, 1), (max_width, 2),
             *((int(rng.integers(1, max_width + 1)), int(rng.integers(1, 9))) for _ in range(11))]
    check(config_of(max_width=max_width), sizes, stall_i=stall_i, stall_o=stall_o)


@pytest.mark.parametrize("disparities, sub_pixel", [(2, False), (128, False), (80, True), (256, True)])
def test_labels(disparities, sub_pixel):
    check(config_of(disparities, 9, sub_pixel=sub_pixel), [(9, 4), (7, 3), (9, 5), (1, 3), (8, 8)] * 2, stall_i=0.2, stall_o=0.2)


def test_every_pattern():
    """All ways in which the pixels of a line may pass: nearest, only one side, none; the labels fall, rise, and are equal."""
    config = config_of(max_width=7)
    rng = np.random.default_rng(1)
    passed = (np.arange(128)[:, None] >> np.arange(7) & 1).astype(bool)
    for labels in (np.arange(7), np.arange(7)[::-1], np.full(7, 3)):
        labels = np.tile(labels, (128, 1))
        n = rng.integers(1, 34, labels.shape)
        given = run_frames(Fill(config), [(label_words(labels, passed, n), {"enable": 1})], rng=rng, timeout=50)
        assert [comparable(word) for word in given] == label_words(fill(labels, passed), passed, n)


@pytest.mark.parametrize("width", [1, 2, 3, 12])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_rate_and_latency(width, share):
    """A pixel a cycle over lines and frames, up to the greatest width; a line and ``latency`` cycles, whatever passed."""
    config = config_of(max_width=12)
    rng = np.random.default_rng(1)
    dut = Fill(config)
    cycles = {}
    frames = [(label_words(*picture(rng, config, width, height, share)), {"enable": 1}) for height in (5, 1, 3)]
    run_frames(dut, frames, rng=rng, cycles=cycles)
    assert np.unique(np.diff(cycles["i"])).tolist() == [1 + dut.line_clocks]
    assert np.unique(np.subtract(cycles["o"], cycles["i"])).tolist() == [dut.lines * width + dut.latency]


def test_line_leaves_when_complete():
    """The first line is output although the second is incomplete, which is held."""
    rng = np.random.default_rng(1)
    labels, passed, n = picture(rng, config_of(), 12, 2, 0.5)
    words = label_words(fill(labels, passed), passed, n)
    given = run_stream(Fill(config_of()), label_words(labels, passed, n)[:17], rng=rng, count=12, drain=50, timeout=50,
                       inputs={"enable": 1})
    assert [comparable(word) for word in given] == words[:12]

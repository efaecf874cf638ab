import numpy as np
import pytest

from golden.config import Arithmetic, Cost, FusedParameters, MatcherConfig, Refinement
from hdl.median import Median
from sim.cases import comparable, label_words, refined_words
from sim.frames import run_frames


def config_of(disparities=80, max_width=40, *, window=5, sub_pixel=False):
    return MatcherConfig(disparities=disparities, max_width=max_width, arithmetic=Arithmetic.LINEAR, cost=Cost.FUSED,
                         fused=FusedParameters(median=window), refinement=Refinement(sub_pixel=sub_pixel))


def picture(rng, config, width, height, share=0.6):
    """Labels of which some are near one another, which passed (about ``share`` of them), and sizes of supports."""
    greatest = config.disparities * config.disparity_scale - 1
    labels = rng.integers(0, greatest + 1, (height, width))
    near = np.clip(rng.integers(0, greatest + 1) + rng.integers(-2 * config.disparity_scale, 2 * config.disparity_scale + 1, labels.shape),
                   0, greatest)
    labels = np.where(rng.random(labels.shape) < 0.6, near, labels)
    labels = np.where(rng.random(labels.shape) < 0.2, rng.choice([0, greatest], labels.shape), labels)
    return labels, rng.random((height, width)) < share, rng.integers(1, config.fused.support_max + 1, (height, width))


def check(config, sizes, *, seed=1, stall_i=0.0, stall_o=0.0):
    """Frames in a row, the median on for two of three, all with minima of their own; each is exact."""
    rng = np.random.default_rng(seed)
    frames, expected = [], []
    for number, size in enumerate(sizes):
        labels, passed, n = picture(rng, config, *size, rng.choice([0.0, 0.6, 1.0]))
        inputs = {"enable": int(number % 3 != 1), "minimum": int(rng.choice([0, 1, 255, rng.integers(256)]))}
        frames.append((label_words(labels, passed, n), inputs))
        expected += refined_words(labels, passed, n, config, **inputs)
    given = run_frames(Median(config), frames, rng=rng, stall_i=stall_i, stall_o=stall_o, timeout=500)
    assert [comparable(word) for word in given] == expected


STALLS = [(0.0, 0.0), (0.4, 0.0), (0.0, 0.4), (0.3, 0.3)]


@pytest.mark.parametrize("stall_i, stall_o", STALLS)
@pytest.mark.parametrize("window", [3, 5])
def test_matches_golden(window, stall_i, stall_o):
    rng = np.random.default_rng(2)
    sizes = [(1, 1), (40, 3), (1, 8), (40, 1), *((int(rng.integers(1, 41)), int(rng.integers(1, 9))) for _ in range(5))]
    check(config_of(window=window), sizes, stall_i=stall_i, stall_o=stall_o)


@pytest.mark.parametrize("window", [3, 5])
def test_small_frames(window):
    """All sizes of one to five lines and columns, narrow frames hard behind wide ones."""
    sizes = [(width, height) for height in range(1, 6) for width in (5, 1, 4, 2, 3)]
    check(config_of(max_width=5, window=window), sizes)


def test_narrowest_memory():
    check(config_of(max_width=1), [(1, 1), (1, 5), (1, 2), (1, 3)], stall_o=0.2)


@pytest.mark.parametrize("disparities, sub_pixel, window", [(2, False, 5), (128, False, 3), (80, True, 5), (3, True, 3), (128, True, 5)])
def test_labels(disparities, sub_pixel, window):
    check(config_of(disparities, 9, window=window, sub_pixel=sub_pixel), [(9, 4), (3, 6), (9, 1)], stall_i=0.2, stall_o=0.2)

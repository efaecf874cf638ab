"""golden.lab.thesis.disturb: lenses and cameras, against what they are said to do."""

import numpy as np
import pytest

from golden.lab.thesis.disturb import Lens, distort, disturb, straighten
from golden.pictures.dataset import StereoPair


def flat(disparity=6, width=81, height=61):
    """A pair at one disparity, whose grey levels are linear: between pixels they are exact."""
    y, x = np.indices((height, width))
    levels = (x + y).astype(np.uint8)
    truth = np.full(levels.shape, float(disparity))
    truth[20, 30] = np.inf
    whole = np.ones(levels.shape, bool)
    return StereoPair("flat", levels, levels + np.uint8(disparity), truth, {"all": whole, "half": whole & (x > 40)}, 16)


@pytest.mark.parametrize("k", [-0.14, -0.05, 0.0, 0.1])
def test_lens(k):
    lens = Lens(k, 81, 61)
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0, 80, 200), rng.uniform(0, 60, 200)
    u, v = lens.source(x, y)
    np.testing.assert_allclose(lens.seen(u, v), (x, y), atol=1e-3)
    # The corner moves outward by the part k of its distance, the centre stays.
    np.testing.assert_allclose(lens.seen(np.array([40.0, 80]), np.array([30.0, 60])), [[40, 80 + 40 * k], [30, 60 + 30 * k]])


def test_too_strong_a_lens():
    with pytest.raises(ValueError, match=r"k must be above -4/27, not -0\.15"):
        Lens(-0.15, 81, 61)


def test_no_lens_changes_nothing():
    pair = flat()
    seen, off_line = distort(pair, 0.0)
    assert off_line == 0
    again = straighten(pair, 0.0)
    for name in ("left", "right", "truth"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(pair, name))
        np.testing.assert_array_equal(getattr(again, name), getattr(pair, name))
    np.testing.assert_array_equal(seen.masks["half"], pair.masks["half"])


@pytest.mark.parametrize("k", [-0.1, 0.08])
def test_distort(k):
    """Both pictures show at a match, found through the truth, the same grey level; off their line by what is told."""
    pair = flat()
    seen, off_line = distort(pair, k)
    lens = Lens(k, 81, 61)
    y, x = np.nonzero(np.isfinite(seen.truth))
    u, v = lens.source(x.astype(float), y.astype(float))
    _, y_right = lens.seen(u - 6, v)
    assert off_line == pytest.approx(np.abs(y - y_right).max(), abs=0.02) and 0.1 < off_line < 3
    within = (u >= 0) & (u <= 80) & (v >= 0) & (v <= 60)
    np.testing.assert_allclose(seen.left[y, x][within], (u + v)[within], atol=0.51)
    x_right = x - seen.truth[y, x]
    inside = (x_right >= 0) & (x_right < 81)
    u_right, v_right = lens.source(x_right, y.astype(float))
    both = inside & (u_right >= 0) & (u_right <= 80) & (v_right >= 0) & (v_right <= 60)
    np.testing.assert_allclose(u_right[both] + 6, u[both], atol=0.8)  # rounded to whole pixels, and a little off the line
    assert len(np.unique(seen.truth[np.isfinite(seen.truth)])) > 1
    assert np.isinf(seen.truth).sum() >= 1


def test_what_is_beyond_the_picture_does_not_count():
    seen, _ = distort(flat(), -0.1)  # a barrel shows more than there is
    assert not seen.masks["all"][0, 0] and np.isinf(seen.truth[0, 0]) and seen.masks["all"][30, 40]
    pincushion, _ = distort(flat(), 0.1)
    assert pincushion.masks["all"].all()


def test_straighten_brings_back():
    pair = flat()
    again = straighten(pair, 0.05)
    inner = np.s_[8:-8, 8:-8]
    assert np.abs(again.left[inner].astype(int) - pair.left[inner]).max() <= 1
    assert again.truth is pair.truth


def test_disturb():
    pair = flat(0)
    still = disturb(pair, 1.0, 0.0, 1)
    np.testing.assert_array_equal(still.left, pair.left)
    np.testing.assert_array_equal(still.right, pair.right)
    np.testing.assert_array_equal(disturb(pair, 0.5, 0.0, 1).right, np.rint(pair.right * 0.5))
    np.testing.assert_array_equal(disturb(pair, 0.5, 0.0, 1).left, pair.left)
    first, again, other = (disturb(pair, 1.0, 3.0, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.right, again.right)
    inner = (pair.left > 15)  # not clipped
    for side in ("left", "right"):
        assert 2.8 < (getattr(first, side).astype(int) - getattr(pair, side))[inner].std() < 3.2
        assert (getattr(first, side) != getattr(other, side)).mean() > 0.5
    assert np.corrcoef((first.left.astype(int) - pair.left)[inner], (first.right.astype(int) - pair.right)[inner])[0, 1] < 0.1

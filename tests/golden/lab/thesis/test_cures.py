"""golden.lab.thesis.cures: a balanced pair is nearly the undisturbed one, and a lens's map brings the geometry back."""

import numpy as np
import pytest

from golden.lab.thesis import sweeps
from golden.lab.thesis.cures import balanced, lens_rig, rectified
from golden.lab.thesis.disturb import Lens, distort, disturb
from golden.lab.thesis.disturbances import LENSES
from golden.pictures.dataset import StereoPair
from golden.pictures.scenes import layers
from golden.rig.lines import DEFAULT_LINES
from golden.rig.maps import displacement


@pytest.fixture(scope="module")
def pair():
    left, right, truth, visible = layers(96, 64, 8, seed=1)
    return StereoPair("layers", left, right, truth.astype(float), {"nonocc": visible, "all": np.ones_like(visible)}, 8)


def smooth(width=160, height=120):
    """A pair without fine detail, so that interpolation is nearly exact."""
    y, x = np.mgrid[:height, :width]
    levels = np.rint(120 + 60 * np.sin(x / 9) * np.cos(y / 11) + 40 * np.sin((x + 2 * y) / 14)).astype(np.uint8)
    return StereoPair("smooth", levels, np.roll(levels, -3, axis=1), np.full(levels.shape, 3.0), {"all": np.ones(levels.shape, bool)}, 8)


def apart(one, other):
    return np.abs(one.astype(int) - other).mean()


def test_balanced(pair):
    dark = disturb(pair, 0.7, 0.0, 1)
    cured = balanced(dark)
    assert apart(cured.right, pair.right) < 2 < 30 < apart(dark.right, pair.right)
    assert cured.left is dark.left and cured.truth is pair.truth


@pytest.mark.parametrize("method", ["float", "fused"])
def test_gain_is_cured_and_noise_is_not(pair, method):
    still, dark, bright, noisy, quiet = (sweeps.disturbed(pair, method, *setting)["bad"][1] for setting in (
        (1.0, 0.0), (0.7, 0.0), (0.7, 0.0, True), (1.0, 8.0), (1.0, 8.0, True)))
    assert abs(bright - still) < 0.2 < 0.5 < dark - still
    assert abs(quiet - noisy) < 0.6 and min(noisy, quiet) > still + 1


@pytest.mark.parametrize("k", LENSES)
def test_the_map_is_the_lens_s(k):
    """At Tsukuba's size; the default rectifier holds its lines."""
    rig = lens_rig(k, 384, 288)
    y, x = np.indices((288, 384)).astype(float)
    for found, exact in zip(displacement(rig.left), np.subtract(Lens(k, 384, 288).seen(x, y), (x, y))):
        # What a bilinear function leaves of the lens over 32 pixels, halved by the fit, and the rounding.
        assert np.abs(found / 32 - exact).max() < 2.5 * abs(k) + 1 / 32
    assert rig.left is rig.right and rig.row_offset == 0 and rig.lines <= DEFAULT_LINES


@pytest.mark.parametrize("k", [-0.1, 0.1])
def test_rectified(k):
    pair = smooth()
    seen, _ = distort(pair, k)
    again = rectified(seen, pair, k)
    inner = np.s_[12:-12, 12:-12]
    for side in ("left", "right"):
        assert apart(getattr(again, side)[inner], getattr(pair, side)[inner]) < 0.7 < 4 < apart(
            getattr(seen, side)[inner], getattr(pair, side)[inner])
    assert again.truth is pair.truth and again.masks is pair.masks


def test_without_a_lens_nothing_changes():
    pair = smooth()
    again = rectified(distort(pair, 0.0)[0], pair, 0.0)
    assert (again.left == pair.left).all() and (again.right == pair.right).all()

"""golden.calibrate.flat: a known vignetting is made good, in the map too; flats that cannot be measured are refused."""

import numpy as np
import pytest

from golden.calibrate.flat import Flat, read_flat
from golden.errors import UserError
from golden.pictures.images import write_picture
from golden.rig.fit import fit_map
from golden.rig.rectify import rectify


WIDTH, HEIGHT = 120, 90
Y, X = np.mgrid[:HEIGHT, :WIDTH].astype(float)


def fall(strength=0.6):
    """Brightness of a lens, 1 in the middle of the picture."""
    return 1 - strength * (((X - 59.5) / 120)**2 + ((Y - 44.5) / 120)**2)


def noisy(levels):
    return np.clip(np.rint(levels + np.random.default_rng(1).normal(0, 2, levels.shape)), 0, 255).astype(np.uint8)


def test_gain_is_the_inverse():
    gain = Flat(noisy(200 * fall()), "flat.png").gain(X, Y)
    assert np.abs(gain * fall() - 1).max() < 0.02 and gain.min() == pytest.approx(1, abs=0.005)


def test_beyond_the_edge_as_at_the_edge():
    flat = Flat(noisy(200 * fall()), "flat.png")
    assert flat.gain(np.array([-5.0, 0.0]), np.array([-9.0, 0.0])).std() == 0


def test_map_makes_it_good():
    """A grey picture through the same lens is even after the rectifier, which takes its pixels from elsewhere."""
    sx, sy = 5 + 0.9 * X, 3 + 0.9 * Y
    which = fit_map(sx, sy, Flat(noisy(200 * fall()), "flat.png").gain(sx, sy))
    grey = np.rint(120 * fall()).astype(np.uint8)
    assert np.ptp(grey) > 20 and np.ptp(rectify(grey, which).astype(int)) <= 4


@pytest.mark.parametrize("levels, message", [
    (12 * fall(), "flat.png has a grey level of 12 where it is brightest, and 16 to 250 are usable"),
    (20 * fall(), "has a grey level of 1. where it is darkest"),
    (255 + 0 * X, "has a grey level of 255 where it is brightest"),
    (200 * fall(1.4), r"flat.png has .. % of its greatest brightness where it is darkest, and 50 % can be made good"),
])
def test_refused(levels, message):
    with pytest.raises(UserError, match=message):
        Flat(np.rint(levels).astype(np.uint8), "flat.png")


def test_sizes(tmp_path):
    write_picture(tmp_path / "a.png", noisy(200 * fall()))
    assert read_flat(tmp_path / "a.png", (120, 90)).brightest == pytest.approx(200, abs=2)
    with pytest.raises(UserError, match="has 120x90 pixels and the cameras have 120x91"):
        read_flat(tmp_path / "a.png", (120, 91))
    with pytest.raises(UserError, match="is too small, 30x90 pixels; 40 are needed"):
        Flat(noisy(200 * fall())[:, :30], "flat.png")

"""golden.rig.fit: bilinear maps are met exactly, others as near as least squares can, better than sampled points."""

import numpy as np
import pytest

from golden.rig.fit import control_points, fit_map
from golden.rig.maps import displacement, grid


@pytest.mark.parametrize("size", [(2, 2), (32, 32), (33, 65), (100, 70)])
def test_planes_are_exact(size):
    y, x = np.mgrid[:size[1], :size[0]].astype(float)
    dx, dy, gain = displacement(fit_map(x + 3.5 + 0.25 * x, y - 2 - 0.125 * x + 0.0625 * y, 1 + 0 * x))
    assert np.abs(dx / 32 - (3.5 + 0.25 * x)).max() < 0.05 and np.abs(dy / 32 - (-2 - 0.125 * x + 0.0625 * y)).max() < 0.05
    assert (gain == 512).all()


def test_least_squares_over_both_axes():
    """The normal equations of the whole problem, solved at once, have the same solution."""
    rng = np.random.default_rng(1)
    values = rng.normal(size=(40, 70))
    rows, columns = grid(70, 40)
    basis = np.zeros((40, 70, rows, columns))
    for y in range(40):
        for x in range(70):
            for j, a in ((y // 32, 1 - y % 32 / 32), (y // 32 + 1, y % 32 / 32)):
                for i, b in ((x // 32, 1 - x % 32 / 32), (x // 32 + 1, x % 32 / 32)):
                    basis[y, x, j, i] = a * b
    whole = np.linalg.lstsq(basis.reshape(2800, -1), values.ravel(), rcond=None)[0].reshape(rows, columns)
    assert np.allclose(control_points(values), whole)


def test_a_lens():
    """A lens of k1 = -0.3 at 720x576: at most 0.2 pixels off, 0.04 on average; control points that are samples are twice as bad."""
    y, x = np.mgrid[:576, :720]
    u, v = (x - 359.5) / 720, (y - 287.5) / 720
    bent = 1 - 0.3 * (u * u + v * v)
    sx, sy = 720 * u * bent + 359.5, 720 * v * bent + 287.5
    dx, dy, _ = displacement(fit_map(sx, sy))
    error = np.hypot(dx / 32 - (sx - x), dy / 32 - (sy - y))
    assert error.max() < 0.2 and error.mean() < 0.04


def test_beyond_the_limits():
    y, x = np.mgrid[:40, :40].astype(float)
    with pytest.raises(ValueError, match=r"dx of the control point .* must be from -8192 to 8191"):
        fit_map(x + 300, y)
    with pytest.raises(ValueError, match=r"gain of the control point .* is 256"):
        fit_map(x, y, 2 + 0 * x)

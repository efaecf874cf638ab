"""golden.calibrate: known cameras are found again, outliers dropped, bad calibrations refused."""

import numpy as np
import pytest

from golden.calibrate.rectified import check_places, corners_after, make_rig, rectification, rig_dy
from golden.calibrate.solve import solve
from golden.calibrate.views import View, view
from golden.errors import UserError
from golden.rig.maps import identity
from golden.rig.rectify import sources

from .boards import BASELINE, BOARD, FOCAL, SIZE, Cameras


def spoiled(each, lines, name=None):
    return View(name or each.name, each.left, each.right + np.float32([0, lines]))


def test_cameras_are_found_again():
    cameras = Cameras()
    found = solve(list(cameras.views(noise=0)), BOARD, SIZE)
    assert found.rms < 0.01 and not found.dropped and len(found.kept) == 10
    for matrix, distortion in zip(found.rectified.matrices, found.rectified.distortions):
        assert np.allclose(matrix, cameras.matrix, atol=0.1) and distortion[0] == pytest.approx(-0.1, abs=2e-3)
    assert np.allclose(found.rectified.translation, cameras.translation, atol=0.05)
    assert found.rectified.baseline == pytest.approx(np.hypot(BASELINE, 2), abs=0.05)


def test_outlier_is_dropped_and_the_others_are_as_without_it():
    views = list(Cameras().views())
    alone = solve(views[1:], BOARD, SIZE)
    found = solve([spoiled(views[0], 6, "bad"), *views[1:]], BOARD, SIZE)
    assert [each.name for each in found.dropped] == ["bad"] and found.rms == pytest.approx(alone.rms, rel=1e-3)


def test_given_lenses_are_kept():
    cameras = Cameras()
    lenses = [cameras.matrix, cameras.distortion] * 2
    found = solve(list(cameras.views()), BOARD, SIZE, lenses)
    assert (found.rectified.matrices[1] == cameras.matrix).all() and found.rms < 0.1
    with pytest.raises(UserError, match=r"the corners are off by \d+\.\d\d pixels \(rms\), and 0.5 is allowed"):
        solve(list(cameras.views()), BOARD, SIZE, [cameras.matrix, cameras.distortion + 0.4] * 2)


def test_too_few_views():
    views = list(Cameras().views())
    with pytest.raises(UserError, match="7 views can be used, and 8 are needed at least"):
        solve(views[:7], BOARD, SIZE)
    with pytest.raises(UserError, match="7 views can be used, after bad were dropped as outliers"):
        solve([spoiled(views[0], 6, "bad"), *views[1:8]], BOARD, SIZE)


def test_noise():
    with pytest.raises(UserError, match="rms"):
        solve(list(Cameras().views(noise=1)), BOARD, SIZE)
    with pytest.raises(UserError, match=r"corners of the rectified pictures are 0\.\d\d lines apart on average, and 0.3 is allowed"):
        solve(list(Cameras().views(noise=0.3)), BOARD, SIZE)


def test_exchanged_and_one_above_the_other():
    with pytest.raises(UserError, match=r"the cameras are exchanged: the second one is \d+\.\d mm to the left of the first"):
        solve([View(each.name, each.right, each.left) for each in Cameras().views()], BOARD, SIZE)
    cameras = Cameras(baseline=2, lower=40)
    with pytest.raises(UserError, match=r"one above the other, 40\.0 mm apart"):
        check_places(rectification(SIZE, *[cameras.matrix, cameras.distortion] * 2, cameras.rotation, cameras.translation))


def test_order_of_the_corners():
    each = next(Cameras().views())
    assert (view("a", each.left, each.right).right == each.right).all()
    turned = view("a", each.left, each.right[::-1])
    assert (turned.right == each.right).all() and (turned.left == each.left).all()


@pytest.fixture(scope="module")
def rectified():
    cameras = Cameras()
    return rectification(SIZE, *[cameras.matrix, cameras.distortion] * 2, cameras.rotation, cameras.translation)


def test_rig_is_as_good_as_floating_point(rectified):
    rig = make_rig(rectified.maps(0), rectified.maps(1), 34)
    views = list(Cameras().views(noise=0))
    exact = np.concatenate([rectified.corner_dy(each.left, each.right) for each in views])
    whole = np.concatenate([rig_dy(rig, each.left, each.right) for each in views])
    before = np.concatenate([each.left[:, 1] - each.right[:, 1] for each in views])
    assert np.abs(before).mean() > 1 and np.abs(exact).max() < 0.01 and np.abs(whole).mean() < 0.05
    assert rectified.focal > 0.8 * FOCAL


def test_corners_after_is_the_inverse_of_the_map(rectified):
    """A corner at the source of a whole pixel is found at that pixel, with rows moved as without."""
    rig = make_rig(rectified.maps(0), rectified.maps(1), 34)
    sx, sy = sources(rig.right)
    y, x = np.mgrid[40:200:37, 40:280:41]
    corners = np.stack([sx[y, x], sy[y, x]], -1).reshape(-1, 2) / 32
    assert np.abs(corners_after(rig.right, corners) - np.stack([x, y], -1).reshape(-1, 2)).max() < 1e-6
    assert np.allclose(corners_after(identity(*SIZE), corners, row_offset=3), corners - [0, 3])


def test_rows_are_moved_only_where_lines_are_too_few():
    y, x = np.mgrid[:240, :320].astype(float)
    enough = make_rig((x, y), (x, y + 30), 34)
    moved = make_rig((x, y), (x, y + 30), 22)
    assert enough.row_offset == 0 and enough.lines == 32
    assert moved.row_offset == 10 and moved.lines == 22
    assert make_rig((x, y + 15), (x, y - 15), 22).row_offset == -10


def test_too_many_lines():
    y, x = np.mgrid[:240, :320].astype(float)
    with pytest.raises(UserError, match=r"this map needs \d+ lines and the gateware holds 22: level .*, or build with --rectify-lines"):
        make_rig((x, y + 0.15 * x), (x, y), 22)
    with pytest.raises(UserError, match="dy of the control point"):
        make_rig((x, y), (x, y + 400), 34)

"""golden.rig.lines: row bounds free no row too early, and are nearly as good as any; maps that gateware cannot run are refused."""

import dataclasses

import numpy as np
import pytest

from golden.rig.fit import fit_map
from golden.rig.lines import check_lines, check_rows, first_rows, lines_needed
from golden.rig.maps import grid, identity
from golden.rig.rectify import sources


def camera_map(width, height, roll=0.0, offset=0.0, lens=0.0):
    """A map for a camera that is rolled, in degrees, moved down, in lines, and has a lens of that k1 and a focal length of the width."""
    y, x = np.mgrid[:height, :width]
    u, v = (x - (width - 1) / 2) / width, (y - (height - 1) / 2) / width
    angle = np.radians(roll)
    u, v = u * np.cos(angle) - v * np.sin(angle), u * np.sin(angle) + v * np.cos(angle)
    bent = 1 + lens * (u * u + v * v)
    return fit_map(u * bent * width + (width - 1) / 2, v * bent * width + (height - 1) / 2 + offset)


CAMERAS = [{"roll": 1}, {"roll": -2, "offset": 3}, {"lens": -0.3}, {"lens": 0.2, "roll": 1}, {"offset": -9}]


def ring(maps, lines):
    """Whether all maps can be run line by line with rings of so many lines, by playing it: no formula of the model but F."""
    height = maps[0].height
    rows = [sources(which)[1] >> 5 for which in maps]
    first = [first_rows(which.bounds, height) for which in maps]
    written = 0
    for y in range(height):
        wanted = max(min(max(int(each[y].max()), y) + 1, height - 1) for each in rows)
        while written <= wanted:
            if any(written - lines >= each[y] for each in first):
                return False
            written += 1
        # What is in the ring now are the last rows written: all that this line reads must be among them.
        assert all(each[y].min() >= written - lines for each in rows)
    return True


@pytest.mark.parametrize("camera", CAMERAS, ids=str)
def test_bounds_are_safe_and_lines_exact(camera):
    which = camera_map(160, 144, **camera)
    check_rows(which)
    needed = lines_needed([which])
    assert ring([which], needed) and not ring([which], needed - 1)


@pytest.mark.parametrize("camera", CAMERAS, ids=str)
def test_bounds_cost_no_lines(camera):
    """As many as with a bound for every line."""
    which = camera_map(160, 144, **camera)
    upper = sources(which)[1] >> 5
    best = max(min(max(int(upper[y].max()), y) + 1, 143) - int(upper[y:].min()) + 1 for y in range(144))
    assert lines_needed([which]) == best


@pytest.mark.parametrize("camera", CAMERAS, ids=str)
def test_no_bound_can_be_greater(camera):
    which = camera_map(160, 144, **camera)
    for j in range(len(which.bounds) - 1):
        bounds = which.bounds.copy()
        bounds[j] += 1
        with pytest.raises(ValueError, match="row bounds of this map"):
            check_rows(dataclasses.replace(which, bounds=bounds))


def test_both_cameras_together():
    """A row is read for both: where one camera is 9 lines lower, it waits so much longer than the other."""
    level, low = identity(96, 96), camera_map(96, 96, offset=9)
    assert lines_needed([level]) == 2 and lines_needed([low]) < 9
    together = lines_needed([level, low])
    assert together == 11 and ring([level, low], together) and not ring([level, low], together - 1)


def test_refusal_names_the_build_option():
    maps = [camera_map(160, 144, roll=14)]
    needed = lines_needed(maps)
    assert 34 < needed <= 44
    check_lines(maps, 44)
    with pytest.raises(ValueError) as refused:
        check_lines(maps, 34)
    assert str(refused.value) == (f"this map needs {needed} lines and the gateware holds 34: level the cameras, "
                                  "or build with --rectify-lines 44")
    with pytest.raises(ValueError, match="level the cameras; gateware can be built with 68 at most"):
        check_lines([camera_map(160, 144, roll=35)], 34)


def test_bounds_that_fall_or_free_too_early():
    plain = identity(64, 96)
    with pytest.raises(ValueError, match=r"fall from .* and must never fall"):
        check_rows(dataclasses.replace(plain, bounds=np.array([0, -80, -160, -160])))
    with pytest.raises(ValueError, match="free the rows before 1 at line 0, but row 0 is still to be read"):
        check_rows(dataclasses.replace(plain, bounds=np.ones(4, int)))
    with pytest.raises(ValueError, match="never fall"):
        check_lines([plain, dataclasses.replace(plain, bounds=np.array([0, -80, -160, -160]))], 34)


def test_first_rows_by_hand():
    assert first_rows(np.array([0, -32, -32]), 64).tolist() == [0] * 32 + [*range(32)]
    assert first_rows(np.array([-1, 0]), 4).tolist() == [-1, 0, 1, 2]     # the quotient is floored
    assert grid(64, 64) == (3, 3)

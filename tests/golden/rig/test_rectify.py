"""golden.rig.rectify: the fast function equals the plain one, the identity copies, edges repeat, gains limit."""

import dataclasses

import numpy as np
import pytest

from golden.rig.maps import grid, identity
from golden.rig.rectify import move_rows, rectify, rectify_plain


def picture(width, height, seed=1):
    return np.random.default_rng(seed).integers(0, 256, (height, width), dtype=np.uint8)


def random_map(width, height, reach, seed=2):
    rng = np.random.default_rng(seed)
    shape = grid(width, height)
    return dataclasses.replace(identity(width, height), dx=rng.integers(-reach, reach + 1, shape),
                               dy=rng.integers(-reach, reach + 1, shape), gain=rng.integers(0, 256, shape))


@pytest.mark.parametrize("size", [(2, 2), (31, 33), (64, 32), (65, 40)])
@pytest.mark.parametrize("reach", [40, 400, 8191])     # within the picture, at its edges, far beyond them
def test_fast_equals_plain(size, reach):
    source, which = picture(*size), random_map(*size, reach)
    assert (rectify(source, which) == rectify_plain(source, which)).all()


@pytest.mark.parametrize("size", [(2, 2), (33, 32), (70, 45)])
@pytest.mark.parametrize("function", [rectify, rectify_plain])
def test_identity_is_an_exact_copy(size, function):
    source = picture(*size)
    result = function(source, identity(*size))
    assert result.dtype == np.uint8 and (result == source).all()


def test_whole_and_half_pixels_by_hand():
    source = np.array([[10, 20, 40], [50, 61, 80]])
    flat = np.ones(grid(3, 2), int)
    moved = dataclasses.replace(identity(3, 2), dx=32 * flat)
    assert rectify(source, moved).tolist() == [[20, 40, 40], [61, 80, 80]]           # edge replication
    assert rectify(source, dataclasses.replace(moved, dx=-32 * flat)).tolist() == [[10, 10, 20], [50, 50, 61]]
    assert rectify(source, dataclasses.replace(moved, dx=16 * flat)).tolist() == [[15, 30, 40], [56, 71, 80]]    # 55.5 and 70.5 round up
    assert rectify(source, dataclasses.replace(moved, dx=0 * flat, dy=8 * flat)).tolist() == [[20, 30, 50], [50, 61, 80]]


def test_gain():
    source = np.array([[0, 100, 200], [3, 1, 255]])
    flat = np.ones(grid(3, 2), int)
    assert rectify(source, dataclasses.replace(identity(3, 2), gain=192 * flat)).tolist() == [[0, 150, 255], [5, 2, 255]]
    assert rectify(source, dataclasses.replace(identity(3, 2), gain=0 * flat)).tolist() == [[0, 0, 0], [0, 0, 0]]


def test_picture_of_another_size():
    with pytest.raises(ValueError, match="the map is for pictures of 9x8 pixels, not 8x9"):
        rectify(picture(8, 9), identity(9, 8))


def test_rows_move():
    source = picture(5, 6)
    assert (move_rows(source, 0) == source).all()
    assert (move_rows(source, 2)[:4] == source[2:]).all() and (move_rows(source, 2)[4:] == source[5]).all()
    assert (move_rows(source, -100) == source[0]).all()
    with pytest.raises(ValueError, match="row_offset must be a whole number from -128 to 127, not 128"):
        move_rows(source, 128)


def test_moved_rows_and_a_moved_map_are_the_same_away_from_the_edges():
    source = picture(40, 64)
    flat = np.ones(grid(40, 64), int)
    whole = rectify(source, dataclasses.replace(identity(40, 64), dy=32 * 7 * flat + 5))
    half = rectify(move_rows(source, 7), dataclasses.replace(identity(40, 64), dy=0 * flat + 5))
    assert (whole[:56] == half[:56]).all()

"""Rectification: the identity changes nothing, fast is plain, a map survives its words, a moved picture is moved."""

import dataclasses

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from golden.rig.maps import GAIN_ONE, grid, identity, pack, unpack
from golden.rig.rectify import move_rows, rectify, rectify_plain
from tests.golden.strategies import pictures


SIZES = st.tuples(st.integers(2, 40), st.integers(2, 36))  # width and height: with one cell and with two


GAINS = st.integers(0, 255)


@st.composite
def maps(draw, reach=8191, gains=GAINS):
    size = draw(SIZES)
    shape = grid(*size)
    moved = {name: draw(arrays(np.int64, shape, elements=st.integers(-reach, reach))) for name in ("dx", "dy")}
    bounds = draw(arrays(np.int64, shape[:1], elements=st.integers(-8192, 8191)))
    return dataclasses.replace(identity(*size), **moved, gain=draw(arrays(np.int64, shape, elements=gains)), bounds=bounds)


@st.composite
def mapped(draw, which):
    """A map and a picture of its size."""
    found = draw(which)
    return found, np.random.default_rng(draw(st.integers(0, 99))).integers(0, 256, (found.height, found.width), dtype=np.uint8)


@given(SIZES.flatmap(lambda size: pictures(size[::-1])))
def test_identity_is_the_identity(picture):
    which = identity(*picture.shape[::-1])
    for function in (rectify, rectify_plain):
        assert (function(picture, which) == picture).all()


@given(mapped(maps(300)))
def test_fast_is_plain(drawn):
    which, picture = drawn
    assert (rectify(picture, which) == rectify_plain(picture, which)).all()


@given(mapped(maps(gains=st.just(GAIN_ONE))))
def test_levels_are_those_of_the_picture(drawn):
    """Without a gain no level is below the least of the picture or above its greatest; a picture of one level stays one."""
    which, picture = drawn
    result = rectify(picture, which)
    assert picture.min() <= result.min() and result.max() <= picture.max()
    assert (rectify(np.full_like(picture, 77), which) == 77).all()


@given(SIZES, st.integers(-50, 50), st.integers(-50, 50), st.integers(0, 99))
def test_whole_pixels_move_the_picture(size, dx, dy, seed):
    width, height = size
    picture = np.random.default_rng(seed).integers(0, 256, (height, width), dtype=np.uint8)
    zero = np.zeros(grid(width, height), dtype=np.int64)
    result = rectify(picture, dataclasses.replace(identity(width, height), dx=zero + 32 * dx, dy=zero + 32 * dy))
    columns = np.clip(np.arange(width) + dx, 0, width - 1)
    assert (result == move_rows(picture, dy)[:, columns]).all()


@given(maps())
def test_words_of_a_map(which):
    after = unpack(pack(which), which.width, which.height)
    for name in ("dx", "dy", "gain", "bounds"):
        assert (getattr(after, name) == getattr(which, name)).all()

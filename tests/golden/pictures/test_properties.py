"""Pictures are read as they were written, whatever is in them."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from golden.pictures.disparities import read_disparity, write_disparity
from golden.pictures.images import read_picture, write_picture
from golden.pictures.text import read_text, write_text
from tests.golden.strategies import numbers, pictures, sizes


@given(st.lists(sizes.flatmap(pictures), min_size=1, max_size=3))
def test_text_pictures(before):
    with tempfile.TemporaryDirectory() as folder:
        write_text(Path(folder, "a.txt"), before)
        after = read_text(Path(folder, "a.txt"))
        lines = Path(folder, "a.txt").read_text(encoding="ascii").splitlines()
    assert len(after) == len(before) and len(lines) == sum(len(each) + 1 for each in before)
    for one, other in zip(before, after, strict=True):
        assert other.shape == one.shape and (other == one).all()


@pytest.mark.parametrize("suffix", [".txt", ".png", ".pgm", ".pfm", ".npy"])
@given(before=sizes.flatmap(pictures))
def test_grey_pictures(suffix, before):
    with tempfile.TemporaryDirectory() as folder:
        write_picture(Path(folder, f"a{suffix}"), before)
        after = read_picture(Path(folder, f"a{suffix}"))
    assert after.dtype == np.uint8 and after.shape == before.shape and (after == before).all()


@pytest.mark.parametrize("suffix, scale", [(".pfm", 1), (".npy", 1), (".png", 1), (".png", 256)])
@given(labels=sizes.flatmap(lambda shape: numbers(shape, 99)), eighths=st.data())
def test_disparities(suffix, scale, labels, eighths):
    """Pixels, with eighths where the format holds them; 0 is unknown in a picture of bytes."""
    fractions = suffix != ".npy" and (suffix == ".pfm" or scale > 1)
    pixels = labels + 1 + eighths.draw(arrays(np.int64, labels.shape, elements=st.integers(0, 7))) / 8 * fractions
    pixels = pixels if fractions else pixels.astype(int)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"a{suffix}")
        write_disparity(path, pixels, 0, 101, scale if scale > 1 else None)
        after = read_disparity(path, scale)
    assert (after == pixels).all()

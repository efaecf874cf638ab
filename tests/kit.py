"""Photographs with ground truth, for tests."""

import functools

import pytest

from golden.errors import UserError
from golden.pictures.dataset import data_folder, load_pair, motorcycle


@functools.cache
def middlebury(name):
    """A pair of the Middlebury benchmark; skips the test if the data are not on this machine."""
    try:
        folder = data_folder()
    except UserError as error:
        pytest.skip(str(error))
    return load_pair(folder, name)  # a folder that is there must be whole


@functools.cache
def reduced_motorcycle():
    """The Motorcycle pair as the demonstration takes it; skips the test if scikit-image is not installed."""
    pytest.importorskip("skimage", reason="scikit-image, which carries the Motorcycle pair, is not installed")
    return motorcycle()

"""What tests of several rooms share: photographs with ground truth, components that are refused."""

import contextlib
import functools
import gc
import warnings

import pytest
from amaranth.hdl import UnusedElaboratable

from golden.errors import UserError
from golden.pictures.dataset import PAIRS, data_folder, load_pair, motorcycle


@contextlib.contextmanager
def refused_components():
    """Around what a constructor refuses: the components that it had built by then are collected here, without Amaranth's warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnusedElaboratable)
        yield
        gc.collect()


@functools.cache
def middlebury(name):
    """A pair of the Middlebury benchmark; skips the test if the data are not on this machine."""
    try:
        folder = data_folder()
    except UserError as error:
        pytest.skip(str(error))
    return load_pair(folder, name)  # a folder that is there must be whole


@contextlib.contextmanager
def only(name):
    """Within the block the benchmark has one pair; afterwards all, in the same order. Skips the test if the data are missing."""
    middlebury(name)
    every = dict(PAIRS)
    for other in every.keys() - {name}:
        del PAIRS[other]
    try:
        yield
    finally:
        PAIRS.clear()
        PAIRS.update(every)


@functools.cache
def reduced_motorcycle():
    """The Motorcycle pair as the demonstration takes it; skips the test if scikit-image is not installed."""
    pytest.importorskip("skimage", reason="scikit-image, which carries the Motorcycle pair, is not installed")
    return motorcycle()

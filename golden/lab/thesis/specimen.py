"""The page made of small synthetic pairs, in seconds and without data; the digest of the full page is taken over it."""

import inspect
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ...pages import digest
from ...pictures.dataset import MASKS, PAIRS, StereoPair
from ...pictures.scenes import layers
from ..cache import source_digest
from ..workers import Done, Job
from . import plots, sheets
from .laboratory import Laboratory
from .page import Section, markdown


__all__ = ["inputs", "specimens"]


SIZE = (30, 20, 8)  # width and height, pixels; number of disparities


def specimens() -> dict[str, StereoPair]:
    """Small synthetic pairs under the benchmark's names, with masks as the benchmark's; the same at every call."""
    result = {}
    for seed, name in enumerate(PAIRS):
        left, right, truth, visible = layers(*SIZE, seed)
        edges = np.zeros_like(visible)
        edges[:, SIZE[0] // 3:SIZE[0] * 2 // 3] = True
        masks = dict(zip(MASKS, (visible, np.ones_like(visible), visible & edges), strict=True))
        result[name] = StereoPair(name, left, right, truth.astype(np.float64), masks, SIZE[2])
    return result


def _timeless(jobs: Sequence[Job], done: Done) -> None:
    """Compute jobs here, one after another, and set their seconds to 0: the digest must not depend on the machine."""
    for number, (function, *arguments) in enumerate(jobs):
        result: dict[str, Any] = function(*arguments)
        done(number, result | {name: np.array(0.0) for name in result if name == "seconds"})


def inputs(chapters: Callable[[Laboratory], Iterator[Section]], pictures: dict[str, str], quick: bool = False) -> str:
    """Digest of all inputs of the pages.

    The page of :func:`specimens` represents the methods, the parameters that are tried, the tables of resources and the words: its text
    changes when one of them changes, and not when code is rewritten without effect. Plots are represented by their code.

    Parameters
    ----------
    chapters : callable
        Gives the sections of the pages.
    pictures : dict of str to str
        Digests of the benchmark's pictures by their names.
    quick : bool
    """
    pairs = specimens()
    # Every conversion to grey gives other levels.
    colours = [np.stack([side, side // 2, 255 - side], axis=-1) for side in (pairs["tsukuba"].left, pairs["tsukuba"].right)]
    lab = Laboratory(pairs, (colours[0], colours[1]), _timeless, None, quick=quick)
    text = markdown("", "", list(chapters(lab)), "")
    return digest(text, pictures, source_digest(map(inspect.getfile, (plots, sheets))))

"""Folders of stereo pairs with ground truth, any number of them, laid out as ours or as Middlebury publishes those of 2005 and 2006."""

import argparse
import dataclasses
import json
import os
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX, MatcherConfig
from ..errors import UserError
from ..files import parsed
from ..notes import note
from .dataset import MASKS, PAIRS, StereoPair, data_folder, load_pair, read_mask, same_size
from .disparities import read_disparity
from .images import read_pair
from .masks import computed_masks


__all__ = ["LABEL_STEP", "SCALES", "add_noise_option", "check_noise", "load_data", "sets_in", "with_noise"]


@dataclasses.dataclass(frozen=True)
class Layout:
    """Names of the files of a set: both pictures and their truths, of which that of the right picture may be missing."""
    left: str
    right: str
    truth: str
    right_truth: str


OURS = Layout("left.png", "right.png", "disp_left.png", "disp_right.png")
MIDDLEBURY = Layout("view1.png", "view5.png", "disp1.png", "disp5.png")

#: Units a pixel of Middlebury's truths of 2005 and 2006 by the height of the pictures: third, half and full size.
SCALES = {370: 3, 555: 2, 1110: 1}

#: Where a set does not tell its disparities, the least multiple of this that covers the truth is searched.
LABEL_STEP = 8


def load_data(data: str | os.PathLike[str] | None = None, names: Collection[str] | None = None) -> list[StereoPair]:
    """The benchmark's pairs, if the folder holds all of them; else every set in it.

    Parameters
    ----------
    data : path or None
        A folder for :func:`golden.pictures.dataset.data_folder`.
    names : collection of str or None
        The pairs or sets that are taken, in this order; ``None``: all.
    """
    folder = data_folder(data)
    found = [path.name for path, _ in _folders(folder)]
    if set(PAIRS) <= set(found):
        if others := sorted(set(found) - set(PAIRS)):
            note(f"{folder} holds the benchmark, and {', '.join(others)}, which do not belong to it and are left out; give a folder of "
                 "sets for them")
        return [load_pair(folder, name) for name in _chosen(names, list(PAIRS), folder)]
    if not found:
        raise UserError(f"the folder {folder} holds no set; give the benchmark, one with {', '.join(PAIRS)}, or a folder of sets with "
                        f"{_words(OURS)} and meta.json, or {_words(MIDDLEBURY)}, as docs/data.md tells")
    return sets_in(folder, names)


def sets_in(path: str | os.PathLike[str], names: Collection[str] | None = None) -> list[StereoPair]:
    """Sets of a folder, by default all in the order of their names: those in its folders, or the folder itself if it is one.

    Either layout is found by its left picture: ``left.png``, ``right.png``, ``disp_left.png``, optionally ``disp_right.png``; or
    ``view1.png``, ``view5.png``, ``disp1.png``, ``disp5.png`` as Middlebury has them. ``meta.json`` gives ``scale``, the units of the truth
    a pixel, which Middlebury's heights tell too (:data:`SCALES`); ``unknown_value``, by default 0; and ``disp_range``, least and greatest
    disparity, by default from 0 to the least multiple of :data:`LABEL_STEP` that covers the truth. Masks of
    :data:`golden.pictures.dataset.MASKS` that are not there are those of :func:`golden.pictures.masks.computed_masks`.
    """
    path = Path(path)
    if not path.is_dir():
        raise UserError(f"the folder {path} does not exist; name one that holds sets")
    found = {folder.resolve().name: (folder, layout) for folder, layout in _folders(path)}
    if not found:
        raise UserError(f"the folder {path} holds no pair; name one whose folders hold {_words(OURS)} and meta.json, "
                        f"or {_words(MIDDLEBURY)}")
    return [_load(*found[name]) for name in _chosen(names, list(found), path)]


def add_noise_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--noise``, for :func:`check_noise` and :func:`with_noise`."""
    parser.add_argument("--noise", type=float, default=0.0, metavar="G", help=(
        "add Gaussian noise of this standard deviation to both pictures first, grey levels; the same in every run (default: none)"))


def check_noise(options: argparse.Namespace) -> None:
    """:class:`UserError` unless ``--noise`` is possible."""
    if not 0 <= options.noise <= PIXEL_MAX:
        raise UserError(f"--noise must be a number of grey levels from 0 to {PIXEL_MAX}, not {options.noise:g}; choose one in that range")


def with_noise(pair: StereoPair, deviation: float, seed: int = 1) -> StereoPair:
    """The pair with Gaussian noise added to both pictures, rounded to grey levels and clipped; always the same for the same seed.

    Parameters
    ----------
    deviation : float
        Standard deviation, grey levels.
    """
    rng = np.random.default_rng(seed)
    left, right = (np.clip(np.rint(side + rng.normal(0, deviation, side.shape)), 0, PIXEL_MAX).astype(np.uint8)
                   for side in (pair.left, pair.right))
    return dataclasses.replace(pair, left=left, right=right)


def _words(layout: Layout) -> str:
    return f"{layout.left}, {layout.right}, {layout.truth}"


def _folders(path: Path) -> list[tuple[Path, Layout]]:
    """Folders of sets and their layouts: the folder itself, else those in it; ours, where files of both layouts are in one."""
    def found(places: Iterable[Path]) -> list[tuple[Path, Layout]]:
        layouts = ((place, layout) for place in places for layout in (MIDDLEBURY, OURS) if (place / layout.left).exists())
        return list(dict(layouts).items())

    return found([path]) or found(sorted(each for each in path.iterdir() if each.is_dir()))


def _chosen(names: Collection[str] | None, found: Sequence[str], folder: Path) -> Sequence[str]:
    """``names``, all of which must be among those found, which are taken by default."""
    for name in names or ():
        if name not in found:
            raise UserError(f"{folder} holds no set {name}; those there are {', '.join(found)}")
    return found if names is None else list(names)


def _load(folder: Path, layout: Layout) -> StereoPair:
    left, right = read_pair(folder / layout.left, folder / layout.right)
    if not (folder / layout.truth).exists():
        raise UserError(f"{folder} holds {layout.left}, but no truth {layout.truth}; add it, or move the set elsewhere")
    meta = _meta(folder / "meta.json", layout, left.shape[0])

    def truth_of(name: str) -> NDArray[np.float64]:
        truth = read_disparity(folder / name, meta.scale, meta.unknown)
        same_size(folder / name, truth, left)
        return truth

    truth = truth_of(layout.truth)
    known = np.isfinite(truth)
    if not known.any():
        raise UserError(f"{folder / layout.truth} holds no known disparity; restore the data folder")
    masks = computed_masks(truth, truth_of(layout.right_truth) if (folder / layout.right_truth).exists() else None)
    for mask in MASKS:
        if (folder / f"{mask}.png").exists():
            masks[mask] = read_mask(folder / f"{mask}.png", left)
    greatest = float(truth[known].max())
    labels = LABEL_STEP * -(-(int(np.ceil(greatest)) + 1) // LABEL_STEP) if meta.labels is None else meta.labels
    if labels not in MatcherConfig.LABELS:
        limits = MatcherConfig.LABELS
        raise UserError(f"{folder} has disparities up to {greatest:g} pixels, and so needs {labels} labels, not {limits[0]} to "
                        f"{limits[-1]}; take it at a smaller size, or correct scale and disp_range in its meta.json")
    return StereoPair(folder.resolve().name, left, right, truth, masks, labels)


@dataclasses.dataclass(frozen=True)
class Meta:
    """What ``meta.json`` tells: units of the truth a pixel, the number that marks unknown disparities, and the number of labels."""
    scale: float
    unknown: float | None
    labels: int | None


def _meta(path: Path, layout: Layout, height: int) -> Meta:
    """What ``meta.json`` tells of a set whose pictures have that height."""
    document: Any = {}
    try:
        if path.exists() or layout is OURS:
            document = parsed(json.loads, path.read_text(encoding="utf-8"))
        if layout is MIDDLEBURY and height in SCALES:
            document = {"scale": SCALES[height], **document}
        greatest = document.get("disp_range", (0, None))[1]
        # Unknown disparities are 0 anyway; named, a truth that has none would be worth a note.
        meta = Meta(float(document["scale"]), float(document.get("unknown_value", 0)) or None,
                    None if greatest is None else int(greatest) + 1)
    except (OSError, ValueError, KeyError, TypeError, IndexError, AttributeError, OverflowError) as error:
        heights = ", ".join(map(str, SCALES))
        why = f"; {height} lines are none of Middlebury's {heights}, which would" if layout is MIDDLEBURY and not path.exists() else ""
        raise UserError(f"{path} does not tell the scale of the disparities ({error!r}){why}; "
                        'write {"scale": units a pixel} into it') from error
    if not meta.scale > 0:
        raise UserError(f"{path} has the scale {meta.scale:g}, which is not above 0; correct it")
    return meta

"""Ground truth given on the command line for any pair."""

import argparse
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..config import MatcherConfig
from ..errors import UserError
from ..notes import note
from .disparities import read_disparity
from .images import read_picture


__all__ = ["add_threshold_option", "add_truth_options", "check_threshold", "check_truth_options", "read_truth"]


# Scales that data sets have; parts of a truth that make a note worth while; how far above the others a
# mark is; how much more often 0 is there than any other number if it is a mark, and not a plane at infinity.
_SCALES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
_GOOD_PART = 0.05
_MANY = 0.25
_FAR = 1.5
_OFTEN = 2

Truth = tuple[NDArray[np.float64], NDArray[np.bool_]]


def add_threshold_option(parser: argparse._ActionsContainer) -> None:
    """Add ``--threshold``, for :func:`check_threshold`."""
    parser.add_argument("--threshold", type=float, default=1.0, metavar="PIXELS", help="a greater error is bad (default: %(default)g)")


def check_threshold(options: argparse.Namespace) -> None:
    """:class:`UserError` unless ``--threshold`` is a number of pixels."""
    if not (math.isfinite(options.threshold) and options.threshold >= 0):
        raise UserError(f"--threshold must be a number of pixels from 0, not {options.threshold:g}; choose such a number")


def add_truth_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--truth --truth-scale --truth-unknown --mask --threshold``, for :func:`read_truth`."""
    group = parser.add_argument_group("ground truth")
    group.add_argument("--truth", type=Path, metavar="FILE", help=(
        "true disparities of LEFT, to compare with: .png, .pgm or .tif (0 is unknown), .pfm or .npy (what is not finite is unknown)"))
    group.add_argument("--truth-scale", type=float, default=1.0, metavar="S", help=(
        "units of --truth a pixel; KITTI's is 256 (default: %(default)g)"))
    group.add_argument("--truth-unknown", type=float, metavar="VALUE", help=(
        "number in --truth that marks unknown disparities, in place of 0: -1, -16; nan if there is none"))
    group.add_argument("--mask", type=Path, metavar="FILE", help="picture whose pixels of level 255 count (default: all of known truth)")
    add_threshold_option(group)


def check_truth_options(options: argparse.Namespace) -> None:
    """:class:`UserError` unless the options make sense, as far as can be checked before files are read."""
    if not (math.isfinite(options.truth_scale) and options.truth_scale > 0):
        raise UserError(f"--truth-scale must be a number above 0, not {options.truth_scale:g}; give the units of --truth a pixel")
    check_threshold(options)
    if options.truth_scale != 1 and not options.truth:
        raise UserError(f"--truth-scale {options.truth_scale:g} is for --truth, which is missing; give --truth FILE or leave it out")
    if options.truth_unknown is not None and not options.truth:
        raise UserError(f"--truth-unknown {options.truth_unknown:g} is for --truth, which is missing; give --truth FILE or leave it out")
    if options.mask and not options.truth:
        raise UserError(f"{options.mask} masks a ground truth, but there is none; give --truth too or leave --mask out")


def read_truth(options: argparse.Namespace, shape: tuple[int, ...], config: MatcherConfig) -> Truth | None:
    """Ground truth and mask that the options name; ``None`` if they name none.

    Parameters
    ----------
    options : argparse.Namespace
        Of :func:`add_truth_options`.
    shape : (int, int)
        Height and width of the pictures.
    config : MatcherConfig
        Gives the disparities that are searched: a truth that is mostly outside them has another scale.

    Returns
    -------
    truth : (H, W) float64 ndarray
        Pixels; ``inf`` where unknown.
    mask : (H, W) bool ndarray
        Pixels that count; at least one, all of known truth.
    """
    if options.truth is None:
        return None
    path = options.truth
    truth = read_disparity(path, options.truth_scale, options.truth_unknown)
    _check_size(path, truth.shape, shape)
    mask = known = np.isfinite(truth)
    if not known.any():
        raise UserError(f"{path} holds no known disparity; give a ground truth with at least one, or another --truth-unknown")
    _check_disparities(options, truth[known], config)
    if options.mask is not None:
        levels = read_picture(options.mask)
        _check_size(options.mask, levels.shape, shape)
        if not (levels == 255).any():
            raise UserError(f"{options.mask} has no pixel of level 255, so nothing counts; mark those that count with 255")
        mask = known & (levels == 255)
        if not mask.any():
            raise UserError(f"{options.mask} marks only pixels whose disparity {path} does not know; give another --mask or --truth")
    return truth, mask


def _check_size(path: Path, found: tuple[int, ...], shape: tuple[int, ...]) -> None:
    if found != shape:
        sizes = [f"{width}x{height}" for height, width in (found, shape)]
        raise UserError(f"{path} has {sizes[0]} pixels, but the pictures have {sizes[1]}; give one of the same size")


def _check_disparities(options: argparse.Namespace, truth: NDArray[np.float64], config: MatcherConfig) -> None:
    """:class:`UserError`, or a note, where known disparities show that a number marks unknown ones, or that the scale is wrong.

    Parameters
    ----------
    truth : (N,) float64 ndarray
        Known disparities, pixels.
    """
    path, scale, greatest = options.truth, options.truth_scale, config.minimum + config.labels - 1
    units = truth * scale
    suspect = _suspect(units, scale, greatest)
    mark = None if suspect is None else (
        f"{path} holds {np.count_nonzero(units == suspect)} pixels of exactly {suspect:.9g}, {np.mean(units == suspect):.0%} of it")
    # With "=", because argparse takes -1e+30 for an option.
    remedy = None if suspect is None else f"if {suspect:.9g} marks unknown disparities, give --truth-unknown={suspect:.9g}"
    below = units[units < 0]
    if below.size and config.minimum >= 0:
        if suspect is not None and suspect < 0:
            raise UserError(f"{mark}, which is below 0; {remedy}")
        raise UserError(f"{path} holds the disparity {truth.min():g}, which is below 0; "
                        "left(x) must match right(x - d); swap the pictures or the sign")
    others = truth if suspect is None else truth[units != suspect]
    searched = others if others.size else truth
    fits = [each for each in _SCALES if (searched * scale).max() <= (greatest + options.threshold) * each]
    # KITTI's scale, where there are more than bytes; else the finest.
    fit = (256 if 256 in fits and (searched * scale).max() > 255 else fits[0]) if fits else None
    hint = f"; --truth-scale {fit} would fit" if fit else ""
    middle = float(np.median(truth))
    if middle > greatest + options.threshold:
        unknown = f"; {remedy}" if suspect is not None and suspect > greatest * scale else ""
        raise UserError(f"{path} holds a median disparity of {middle:g} pixels, more than the {greatest} that are searched; "
                        f"correct --truth-scale {scale:g} or raise --disparities{hint}{unknown}")
    if scale > 1 and truth.max() < 1:
        raise UserError(f"{path} holds disparities below 1 pixel only with --truth-scale {scale:g}; correct it{hint}")
    if suspect is not None:
        note(f"{mark}, which counts as a disparity; {remedy}")
    if 0 < truth.max() < 1:
        note(f"{path} holds disparities below 1 pixel only; unless they are in pixels, give --truth-scale, the units a pixel")
    if (beyond := np.mean(searched > greatest + options.threshold)) > _MANY:
        note(f"{beyond:.0%} of the disparities of {path} are above the {greatest} pixels that are searched; raise --disparities or correct "
             f"--truth-scale {scale:g}{hint}")


def _suspect(units: NDArray[np.float64], scale: float, greatest: int) -> float | None:
    """The number that seems to mark unknown disparities, in units of the file: most of those below 0, 0, or a good part of all.

    Above 0 only the greatest, beyond what is searched, if nothing else is there or it is far above all else: else the scale is wrong.
    """
    below, counts = np.unique(units[units < 0], return_counts=True)
    if below.size == 1 or (below.size and 2 * counts.max() > counts.sum() and counts.max() >= _GOOD_PART * units.size):
        return float(below[counts.argmax()])
    most, searched = float(units.max()), greatest * scale
    second = float(units[units < most].max(initial=-np.inf))
    alone = most > searched and second >= 0 and (second <= searched or most > _FAR * second)
    values, counts = np.unique(units, return_counts=True)
    often = {float(value): count for value, count in zip(values, counts) if count >= _GOOD_PART * units.size}
    if often.get(0.0, 0) > _OFTEN * max(counts[values != 0], default=0):
        return 0.0
    return most if alone and most in often else None

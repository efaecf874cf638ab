"""Ground truth given on the command line for any pair."""

import argparse
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..config import MatcherConfig
from ..errors import UserError
from .disparities import read_disparity
from .images import read_picture


__all__ = ["add_threshold_option", "add_truth_options", "check_threshold", "check_truth_options", "read_truth"]


SUFFIXES = (".png", ".pfm", ".npy")

Truth = tuple[NDArray[np.float64], NDArray[np.bool_]]


def add_threshold_option(parser: argparse._ActionsContainer) -> None:
    """Add ``--threshold``, for :func:`check_threshold`."""
    parser.add_argument("--threshold", type=float, default=1.0, metavar="PIXELS", help="a greater error is bad (default: %(default)g)")


def check_threshold(options: argparse.Namespace) -> None:
    """:class:`UserError` unless ``--threshold`` is a number of pixels."""
    if not (math.isfinite(options.threshold) and options.threshold >= 0):
        raise UserError(f"--threshold must be a number of pixels from 0, not {options.threshold:g}; choose such a number")


def add_truth_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--truth --truth-scale --mask --threshold``, for :func:`read_truth`."""
    group = parser.add_argument_group("ground truth")
    group.add_argument("--truth", type=Path, metavar="FILE", help=(
        "true disparities of LEFT, to compare with: .png (0 is unknown), .pfm or .npy (values that are not finite are unknown)"))
    group.add_argument("--truth-scale", type=float, default=1.0, metavar="S", help="units of --truth a pixel (default: %(default)g)")
    group.add_argument("--mask", type=Path, metavar="FILE", help="picture whose pixels of level 255 count (default: all of known truth)")
    add_threshold_option(group)


def check_truth_options(options: argparse.Namespace) -> None:
    """:class:`UserError` unless the options make sense, as far as can be checked before files are read."""
    if not (math.isfinite(options.truth_scale) and options.truth_scale > 0):
        raise UserError(f"--truth-scale must be a number above 0, not {options.truth_scale:g}; give the units of --truth a pixel")
    check_threshold(options)
    if options.truth_scale != 1 and not options.truth:
        raise UserError(f"--truth-scale {options.truth_scale:g} is for --truth, which is missing; give --truth FILE or leave it out")
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
    truth = read_disparity(path, options.truth_scale)
    _check_size(path, truth.shape, shape)
    mask = known = np.isfinite(truth)
    if not known.any():
        raise UserError(f"{path} holds no known disparity; give a ground truth with at least one")
    if truth[known].min() < 0:
        raise UserError(f"{path} holds the disparity {truth[known].min():g}, which is below 0; "
                        "left(x) must match right(x - d); swap the pictures or the sign")
    greatest, middle = config.minimum + config.labels - 1, float(np.median(truth[known]))
    if middle > greatest + options.threshold:
        raise UserError(f"{path} holds a median disparity of {middle:g} pixels, more than the {greatest} that are searched; "
                        f"correct --truth-scale {options.truth_scale:g} or raise --disparities")
    if options.truth_scale > 1 and truth[known].max() < 1:
        raise UserError(f"{path} holds disparities below 1 pixel only with --truth-scale {options.truth_scale:g}; correct it")
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

"""Further outputs of `golden match`: colours, a sheet, depth."""

import argparse
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..config import MatcherConfig
from ..errors import UserError
from .calibration import Calibration, read_calibration
from .depth import DEPTH_SUFFIXES, depth, write_depth
from .images import colour_map, write_picture
from .sheet import SHEET_SUFFIXES, write_sheet
from .truth import Truth


__all__ = ["SUFFIXES", "add_product_options", "read_camera", "write_products"]


# The suffixes that each option accepts.
SUFFIXES = {"colour": (".png", ".ppm", ".jpg", ".jpeg"), "sheet": SHEET_SUFFIXES, "depth": DEPTH_SUFFIXES}


def add_product_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--colour --sheet --depth`` and the calibration that depth needs."""
    group = parser.add_argument_group("pictures to look at, and depth")
    group.add_argument("--colour", type=Path, metavar="FILE", help=f"disparities as colours, nearer is brighter: {_words('colour')}")
    group.add_argument("--sheet", type=Path, metavar="FILE", help=(
        f"left picture and disparities side by side, and the ground truth and the errors if there is one: {_words('sheet')}"))
    group.add_argument("--depth", type=Path, metavar="FILE", help=(
        f"depth = focal length * baseline / disparity, in the unit of the baseline: {_words('depth')}, a point cloud"))
    group.add_argument("--calib", type=Path, metavar="FILE", help="calib.txt of Middlebury 2014, for --depth")
    group.add_argument("--focal", type=float, metavar="PIXELS", help="focal length, in place of --calib")
    group.add_argument("--baseline", type=float, metavar="LENGTH", help="distance of the cameras, any unit, in place of --calib")


def _words(option: str) -> str:
    return ", ".join(SUFFIXES[option])


def read_camera(options: argparse.Namespace, shape: tuple[int, ...] | None = None) -> Calibration | None:
    """The calibration that the options give, ``None`` without ``--depth``; :class:`UserError` if it is not complete.

    Parameters
    ----------
    options : argparse.Namespace
        Of :func:`add_product_options`.
    shape : (int, int) or None
        Height and width of the pictures, which must match the calibration; ``None``: not known yet.
    """
    numbers = {name: value for name in ("focal", "baseline") if (value := getattr(options, name)) is not None}
    if options.depth is None:
        for name in ("calib", *numbers):
            if getattr(options, name) is not None:
                raise UserError(f"--{name} {getattr(options, name)} is for --depth, which is missing; give --depth FILE or leave it out")
        return None
    if options.calib is not None:
        if numbers:
            raise UserError(f"--{min(numbers)} is given with --calib {options.calib}, which contains it; give one of the two")
        calibration = read_calibration(options.calib)
        if shape is not None and calibration.size not in (None, shape[::-1]):
            raise UserError(f"{options.calib} is for {calibration.size[0]}x{calibration.size[1]} pixels, "  # type: ignore[index]
                            f"but the pictures have {shape[1]}x{shape[0]}; scale cam0, doffs and the size in it")
        return calibration
    for name in ("focal", "baseline"):
        if name not in numbers:
            raise UserError(f"--{name} is missing, without which there is no depth; give it, or --calib FILE")
    try:
        return Calibration(**numbers)
    except ValueError as error:
        raise UserError(f"--{error}; correct it") from None


def write_products(options: argparse.Namespace, left: NDArray[Any], disparity: NDArray[Any], config: MatcherConfig,
                   truth: Truth | None, calibration: Calibration | None) -> None:
    """Write the files that the options name.

    Parameters
    ----------
    options : argparse.Namespace
        Of :func:`add_product_options` and :func:`golden.pictures.truth.add_truth_options`.
    left : (H, W) uint8 ndarray
        Grey levels.
    disparity : (H, W) ndarray
        Pixels.
    config : MatcherConfig
    truth : Truth or None
        Of :func:`golden.pictures.truth.read_truth`.
    calibration : Calibration or None
        Of :func:`read_camera`.
    """
    if options.colour:
        write_picture(options.colour, colour_map(disparity - config.minimum, config.labels))
    if options.sheet:
        limits = config.minimum, config.minimum + config.labels - 1
        write_sheet(options.sheet, left, disparity, limits, truth, options.threshold)
    if calibration is not None:
        write_depth(options.depth, depth(disparity, calibration), left, calibration)

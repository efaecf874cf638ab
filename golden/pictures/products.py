"""Further outputs of `golden match`: colours, a sheet, depth."""

import argparse
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import MatcherConfig
from ..errors import UserError
from ..notes import note
from .calibration import Calibration
from .calibration_files import read_calibration
from .depth import DEPTH_SUFFIXES, depth, write_depth
from .images import colour_map, write_picture
from .sheet import SHEET_SUFFIXES, write_sheet
from .truth import Truth


__all__ = ["SUFFIXES", "add_product_options", "check_camera_options", "read_camera", "write_products"]


# The suffixes that each option accepts.
SUFFIXES = {"colour": (".png", ".ppm", ".jpg", ".jpeg"), "sheet": SHEET_SUFFIXES, "depth": DEPTH_SUFFIXES}


_UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}


def add_product_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--colour --sheet --depth`` and the calibration that depth needs."""
    group = parser.add_argument_group("pictures to look at, and depth")
    group.add_argument("--colour", type=Path, metavar="FILE", help=f"disparities as colours, nearer is brighter: {_words('colour')}")
    group.add_argument("--sheet", type=Path, metavar="FILE", help=(
        f"left picture and disparities side by side, and the ground truth and the errors if there is one: {_words('sheet')}"))
    group.add_argument("--depth", type=Path, metavar="FILE", help=(
        "depth = focal length * baseline / disparity, in the unit of the baseline: .npy, .pfm, or .ply, a point cloud; .png: in "
        "millimetres, 16 bits, 0 where there is none"))
    group.add_argument("--calib", type=Path, action="append", metavar="FILE", help=(
        "for --depth: calib.txt of Middlebury 2014 or KITTI; YAML of OpenCV (P1 and P2, or Q) or of ROS (camera_info of the right camera, "
        "or of both: --calib LEFT --calib RIGHT)"))
    group.add_argument("--kitti-cameras", choices=("0,1", "2,3"), metavar="0,1|2,3", help=(
        "which cameras of KITTI's --calib: grey or colour (default: 0,1)"))
    group.add_argument("--focal", type=float, metavar="PIXELS", help="focal length, in place of --calib")
    group.add_argument("--baseline", type=float, metavar="LENGTH", help="distance of the cameras, any unit, in place of --calib")
    group.add_argument("--baseline-unit", choices=_UNITS, metavar="|".join(_UNITS), help=(
        "unit of the baseline, for --depth FILE.png (default: as --calib lays down: Middlebury mm, KITTI and ROS m)"))


def _words(option: str) -> str:
    return ", ".join(SUFFIXES[option])


def read_camera(options: argparse.Namespace, shape: tuple[int, ...], config: MatcherConfig) -> Calibration | None:
    """The calibration that the options give, ``None`` without ``--depth``; :class:`UserError` if it is none for these pictures.

    Parameters
    ----------
    options : argparse.Namespace
        Of :func:`add_product_options`, after :func:`check_camera_options`.
    shape : (int, int)
        Height and width of the pictures, which must match the calibration.
    config : MatcherConfig
        Gives the disparities that are searched; one of them at least must have a depth.
    """
    if options.depth is None:
        return None
    if options.calib is not None:
        told = " and ".join(map(str, options.calib))
        calibration = read_calibration(options.calib, options.kitti_cameras)
        if calibration.size not in (None, shape[::-1]):
            raise UserError(f"{told} is for {calibration.size[0]}x{calibration.size[1]} pixels, "  # type: ignore[index]
                            f"but the pictures have {shape[1]}x{shape[0]}; scale focal lengths, principal points and the size in it")
    else:
        told = "--focal and --baseline"
        calibration = _from_numbers(options)
    if options.baseline_unit is not None:
        calibration = dataclasses.replace(calibration, millimetres=_UNITS[options.baseline_unit])
    if options.depth.suffix.lower() == ".png" and calibration.millimetres is None:
        raise UserError(f"{options.depth} holds millimetres, but the unit of the baseline, {calibration.baseline:g}, is not known from "
                        f"{told}; give --baseline-unit {'|'.join(_UNITS)}")
    greatest = config.minimum + config.labels - 1
    if greatest + calibration.offset <= 0:
        raise UserError(f"no pixel can have a depth: disparities up to {greatest} are searched, and with doffs, which is "
                        f"{calibration.offset:g} in {told}, they are not above 0; correct doffs or raise --disparities")
    return calibration


def check_camera_options(options: argparse.Namespace) -> None:
    """:class:`UserError` unless the options make sense, as far as can be checked before files are read."""
    names = ("calib", "kitti_cameras", "focal", "baseline", "baseline_unit")
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    if options.depth is None:
        for name, value in given.items():
            value = " ".join(map(str, value)) if name == "calib" else value
            raise UserError(f"--{name.replace('_', '-')} {value} is for --depth, which is missing; give --depth FILE or leave it out")
        return
    if options.baseline_unit is not None and options.depth.suffix.lower() != ".png":
        raise UserError(f"--baseline-unit {options.baseline_unit} is for --depth FILE.png: {options.depth} is in the unit of the baseline, "
                        "whatever it is; leave it out")
    numbers = [name for name in ("focal", "baseline") if name in given]
    if options.calib is not None:
        if numbers:
            raise UserError(f"--{min(numbers)} is given with --calib {options.calib[0]}, which contains it; give one of the two")
        return
    if options.kitti_cameras is not None:
        raise UserError(f"--kitti-cameras {options.kitti_cameras} is for --calib, which is missing; give --calib FILE or leave it out")
    for name in ("focal", "baseline"):
        if name not in numbers:
            raise UserError(f"--{name} is missing, without which there is no depth; give it, or --calib FILE")
    _from_numbers(options)


def _from_numbers(options: argparse.Namespace) -> Calibration:
    try:
        return Calibration(options.focal, options.baseline)
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
        z = depth(disparity, calibration)
        if not np.isfinite(z).any():
            note(f"no pixel has a depth in {options.depth}: no disparity plus the cameras' offset, {calibration.offset:g}, is above 0")
        write_depth(options.depth, z, left, calibration)

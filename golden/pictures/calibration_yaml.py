"""Calibration in YAML: camera_info of ROS, and what OpenCV's FileStorage writes after stereoRectify."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from ..errors import UserError
from ..files import parsed
from ..notes import note
from .calibration import Calibration, Matrix, from_projections


__all__ = ["is_yaml", "read_mapping", "read_yaml"]


_METRE = 1000.0

# OpenCV's header is that of no version of YAML: the colon must be a blank.
_OPENCV_HEADER = re.compile(r"\A\s*%YAML:[\d.]+\s*$", re.MULTILINE)
_OPENCV_TAG = re.compile(r"!!opencv-[\w-]+")  # of a matrix, which is a mapping without it
_KEYS = re.compile(r"(?:^|[{,])\s*[\"']?(?:projection_matrix|[PpQ]|P1|P2|image_width|camera_matrix|K|k)[\"']?\s*:", re.MULTILINE)

_ROS_HELP = "give camera_info of both cameras, --calib LEFT.yaml --calib RIGHT.yaml, or of the right one"


def is_yaml(text: str) -> bool:
    """Whether a text is one that :func:`read_yaml` is for, or OpenCV's XML, which it refuses."""
    return bool(_OPENCV_HEADER.search(text) or _KEYS.search(text) or text.lstrip().startswith("<?xml"))


def read_yaml(paths: Sequence[Path], texts: Sequence[str]) -> Calibration:
    """The calibration in files of YAML.

    - OpenCV: one file with ``P1`` and ``P2``, or ``Q``, of ``stereoRectify``, in the unit of its chessboard, which the file does not tell.
    - ROS: ``camera_info`` of the left and of the right camera, in metres, as ``camera_calibration`` saves it (``projection_matrix``) or as
      a topic prints it (``P`` or ``p``). The right one alone has focal length and baseline (``-fx * baseline`` is in its ``P``); the
      principal points are then taken as equal, as ROS's own calibration makes them, and a note says so.

    Parameters
    ----------
    paths : sequence of path
        One file, or those of the left and of the right camera.
    texts : sequence of str
        Their contents.

    Returns
    -------
    Calibration
        :class:`UserError` if they are not that.
    """
    entries = [read_mapping(path, text) for path, text in zip(paths, texts)]
    if len(entries) == 1 and not _is_ros(entries[0]):
        return _opencv(paths[0], entries[0])
    for path, each in zip(paths, entries):
        if not _is_ros(each):
            raise UserError(f"{path} is no camera_info of ROS, which alone has a file for each camera; {_ROS_HELP}")
    if len(paths) > 2:
        raise UserError(f"--calib is given {len(paths)} times; {_ROS_HELP}")
    matrices = [_ros_matrix(path, each) for path, each in zip(paths, entries)]
    sizes = [_ros_size(path, each) for path, each in zip(paths, entries)]
    right = matrices[-1]
    if len(matrices) == 1:
        if not right[3]:
            raise UserError(f"{paths[0]} has no baseline (P[3] is 0), as camera_info of the left camera; {_ROS_HELP}")
        note(f"{paths[0]} is of the right camera: the principal point of the left one is taken as the same (doffs=0); give both to be sure")
        matrices = [[*right[:3], 0.0, *right[4:7], 0.0, *right[8:]], right]
    if sizes[0] != sizes[-1]:
        raise UserError(f"{paths[0]} and {paths[-1]} are for pictures of different sizes, {sizes[0]} and {sizes[-1]}; "
                        "give those of one pair")
    names = [f"P of {path}" for path in (paths[0], paths[-1])]
    return from_projections(matrices[0], matrices[1], (names[0], names[1]), sizes[0], _METRE)


def read_mapping(path: Path, text: str) -> dict[Any, Any]:
    """The first document of a file."""
    if text.lstrip().startswith("<?xml"):
        raise UserError(f"{path} is XML; let OpenCV's FileStorage write it to a file with the suffix .yml")
    try:
        document = parsed(lambda text: next(yaml.safe_load_all(text), None), _OPENCV_TAG.sub("", _OPENCV_HEADER.sub("", text)))
    except (yaml.YAMLError, ValueError) as error:       # a date that is none, for example
        raise UserError(f"{path} cannot be read as YAML: {error}; check the file") from None
    if not isinstance(document, dict):
        raise UserError(f"{path} holds no names and values; {_ROS_HELP}")
    return document


def _is_ros(entries: dict[Any, Any]) -> bool:
    return any(name in entries for name in ("projection_matrix", "P", "p", "camera_matrix", "K", "k"))


def _numbers(path: Path, name: str, value: Any, shape: tuple[int, int]) -> Matrix:
    """A matrix row by row, from a list or from a mapping with ``rows``, ``cols`` and ``data``."""
    count = shape[0] * shape[1]
    if isinstance(value, dict):
        told = (value.get("rows"), value.get("cols"))
        if told != shape:
            raise UserError(f"{path} has the matrix {name} of {told[0]}x{told[1]} numbers; it must be {shape[0]}x{shape[1]}")
        value = value.get("data")
    try:
        numbers = [float(each) for each in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise UserError(f"{path} has a matrix {name} that is not {count} numbers; correct it")
    return numbers


def _ros_matrix(path: Path, entries: dict[Any, Any]) -> Matrix:
    name = next((name for name in ("projection_matrix", "P", "p") if name in entries), None)
    if name is None:
        raise UserError(f"{path} has no projection_matrix (P), which alone describes the rectified pictures; {_ROS_HELP}")
    numbers = _numbers(path, name, entries[name], (3, 4))
    if not numbers[0]:
        raise UserError(f"{path} has a projection_matrix of zeros: the camera is not calibrated; calibrate it")
    return numbers


def _ros_size(path: Path, entries: dict[Any, Any]) -> tuple[int, int] | None:
    width, height = (entries.get(f"image_{name}", entries.get(name)) for name in ("width", "height"))
    if width is None and height is None:
        return None
    if not (isinstance(width, int) and isinstance(height, int) and width > 0 and height > 0):
        raise UserError(f"{path} has the size {width}x{height}, which is not two whole numbers above 0; correct it")
    return width, height


def _opencv(path: Path, entries: dict[Any, Any]) -> Calibration:
    if "P1" in entries and "P2" in entries:
        left, right = (_numbers(path, name, entries[name], (3, 4)) for name in ("P1", "P2"))
        return from_projections(left, right, (f"P1 of {path}", f"P2 of {path}"))
    if "Q" not in entries:
        raise UserError(f"{path} has neither P1 and P2 nor Q; write what stereoRectify gives into it")
    q = _numbers(path, "Q", entries["Q"], (4, 4))
    # [1 0 0 -cx; 0 1 0 -cy; 0 0 0 f; 0 0 1/b (cx' - cx)/b]
    if any(q[at] for at in (1, 2, 4, 6, 8, 9, 10, 12, 13)) or q[0] != 1 or q[5] != 1 or q[11] <= 0 or q[14] <= 0:
        raise UserError(f"{path} has a Q that is not stereoRectify's of two cameras side by side, the left one first: "
                        "[1 0 0 -cx; 0 1 0 -cy; 0 0 0 f; 0 0 1/b d/b] with b above 0; correct it, or give P1 and P2")
    return Calibration(q[11], 1 / q[14], q[15] / q[14], (-q[3], -q[7]))

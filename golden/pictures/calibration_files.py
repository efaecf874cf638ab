"""Calibration files: Middlebury's and KITTI's text; YAML is in ``calibration_yaml``."""

import os
import re
from collections.abc import Sequence
from pathlib import Path

from ..errors import UserError
from ..notes import note
from .calibration import CENTRE_PIXELS, Calibration, Matrix, check_rectified, from_projections
from .calibration_yaml import is_yaml, read_yaml


__all__ = ["read_calibration"]


KINDS = "calib.txt of Middlebury 2014 or KITTI, camera_info of ROS or stereoRectify's P1 and P2 or Q of OpenCV in YAML"

# Metres of KITTI and millimetres of Middlebury are laid down by these data sets.
_METRE = 1000.0
_MILLIMETRE = 1.0

_LINE = re.compile(r"\s*(\w+)\s*=\s*(.*?)\s*")
_KITTI = re.compile(r"\s*P(?:_rect_0)?([0-3])\s*:\s*([-+\d.].*?)\s*")
_KITTI_SIZE = re.compile(r"\s*S_rect_0([0-3])\s*:\s*(\S+)\s+(\S+)\s*")


def read_calibration(paths: Sequence[str | os.PathLike[str]], kitti: str | None = None) -> Calibration:
    """The calibration of a rectified pair, from a file in one of these formats, recognised by its content.

    - Middlebury 2014: lines ``name=value`` with ``cam0`` and ``baseline``, in millimetres, and, if present, ``cam1``, ``doffs``,
      ``width`` and ``height``. Without ``doffs`` it is the distance of the principal points of ``cam1`` and ``cam0``.
    - KITTI: lines ``P0: 12 numbers`` to ``P3:``, or ``P_rect_00:`` to ``P_rect_03:``, in metres.
    - ROS and OpenCV: see :func:`golden.pictures.calibration_yaml.read_yaml`.

    Parameters
    ----------
    paths : sequence of path
        One file; or two, those of the left and of the right camera, of ROS.
    kitti : str or None
        The cameras of KITTI, ``"0,1"`` (grey) or ``"2,3"`` (colour); ``None``: the grey ones if they are there.

    Returns
    -------
    Calibration
        :class:`UserError` if it has another format, or contradicts itself.
    """
    files = [Path(path) for path in paths]
    texts = [_text(path) for path in files]
    kittis = [any(map(_KITTI.fullmatch, text.splitlines())) for text in texts]
    if kitti is not None and not all(kittis):
        raise UserError(f"{files[kittis.index(False)]} is no calib.txt of KITTI; leave --kitti-cameras {kitti} out")
    if not any(map(_middlebury, texts)) and not any(kittis) and all(map(is_yaml, texts)):
        return read_yaml(files, texts)
    if len(files) > 1:
        raise UserError(f"{files[1]} is given with {files[0]}, but only camera_info of ROS has a file for each camera; give one --calib")
    try:
        return _read_kitti(files[0], texts[0], kitti) if kittis[0] else _read_middlebury(files[0], texts[0])
    except UserError:
        raise
    except (ValueError, OverflowError) as error:
        raise UserError(f"{files[0]} cannot be a calibration: {error}; correct it") from None


def _text(path: Path) -> str:
    """The file's text: UTF-8, or UTF-16 if its mark says so, as Windows writes it."""
    try:
        data = path.read_bytes()
        return data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except OSError as error:
        raise UserError(f"cannot read {path}: {error.strerror}; give a {KINDS}") from error
    except UnicodeDecodeError:
        raise UserError(f"{path} is not text; give a {KINDS}") from None


def _number(path: Path, name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UserError(f"{path} has the {name} {text[:40]!r}, which is not a number; correct it") from None


def _size(path: Path, texts: Sequence[str]) -> tuple[int, int]:
    width, height = (int(_number(path, name, text)) for name, text in zip(("width", "height"), texts))
    return width, height


def _middlebury(text: str) -> bool:
    return any(match and match[1].startswith("cam") for match in map(_LINE.fullmatch, text.splitlines()))


def _read_middlebury(path: Path, text: str) -> Calibration:
    entries = {match[1]: match[2] for match in map(_LINE.fullmatch, text.splitlines()) if match}
    for name in ("cam0", "baseline"):
        if name not in entries:
            if not entries:
                raise UserError(f"{path} is not a calibration that can be read; give a {KINDS}, or --focal and --baseline")
            raise UserError(f"{path} has no {name}; add the line {name}=..., or give --focal and --baseline instead of --calib")
    left = _matrix(path, "cam0", entries["cam0"])
    right = _matrix(path, "cam1", entries["cam1"]) if "cam1" in entries else left
    check_rectified(left, right, (f"cam0 of {path}", f"cam1 of {path}"))
    apart = right[2] - left[2] if "cam1" in entries else None
    offset = _number(path, "doffs", entries["doffs"]) if "doffs" in entries else apart
    if offset is None:
        note(f"{path} has neither doffs nor cam1: the principal points of both cameras are taken as equal (doffs=0)")
        offset = 0.0
    if apart is not None and abs(offset - apart) > CENTRE_PIXELS:
        raise UserError(f"{path} has the doffs {offset:g}, but the principal points of cam1 and cam0 are {apart:g} pixels apart "
                        f"({right[2]:g} - {left[2]:g}), which doffs must be; correct one of them")
    size = _size(path, [entries["width"], entries["height"]]) if "width" in entries and "height" in entries else None
    if size is None and (one := [name for name in ("width", "height") if name in entries]):
        _number(path, one[0], entries[one[0]])
    baseline = _number(path, "baseline", entries["baseline"])
    return Calibration(left[0], baseline, offset, (left[2], left[6]), size, _MILLIMETRE, left[5])


def _matrix(path: Path, name: str, text: str) -> Matrix:
    """The projection matrix, 3x4, of a camera's matrix, 3x3."""
    rows = [row.replace(",", " ").split() for row in text.strip("[] ").split(";")]
    if [len(row) for row in rows] != [3, 3, 3]:
        raise UserError(f"{path} has the {name} {text[:60]!r}; write it as [fx 0 cx; 0 fy cy; 0 0 1]")
    return [number for row in rows for number in [*(_number(path, f"number in {name}", each) for each in row), 0.0]]


def _read_kitti(path: Path, text: str, cameras: str | None) -> Calibration:
    lines = text.splitlines()
    matrices = {match[1]: [_number(path, f"number in P{match[1]}", each) for each in match[2].split()]
                for match in map(_KITTI.fullmatch, lines) if match}
    complete = [pair for pair in ("0,1", "2,3") if matrices.keys() >= {*pair.split(",")}]
    if not complete:
        raise UserError(f"{path} has {', '.join(f'P{each}' for each in matrices)}, but a pair is P0 and P1, or P2 and P3; "
                        "add the other one")
    if cameras is None:
        cameras = complete[0]
        if len(complete) > 1:
            note(f"of {path} the grey cameras, P0 and P1, are taken; --kitti-cameras 2,3 takes those of image_2 and image_3")
    if cameras not in complete:
        raise UserError(f"{path} has not both cameras of --kitti-cameras {cameras}; give {complete[0]}")
    left, right = cameras.split(",")
    sizes = {match[1]: _size(path, (match[2], match[3])) for match in map(_KITTI_SIZE.fullmatch, lines) if match}
    return from_projections(matrices[left], matrices[right], (f"P{left} of {path}", f"P{right} of {path}"), sizes.get(left), _METRE)

"""Calibrations of others in place of pictures: OpenCV's intrinsics and extrinsics, and the camera chain of Kalibr."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from ..pictures.calibration_yaml import read_mapping
from .rectified import Rectified, rectification
from .views import opencv


__all__ = ["SUFFIXES", "UNITS", "read_cameras", "read_intrinsics"]


#: Suffixes of files that are calibrations, not pictures.
SUFFIXES = (".yml", ".yaml")

#: Millimetres in the units of length.
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
_HELP = "give OpenCV's intrinsics.yml and extrinsics.yml, or Kalibr's camchain"
_DISTORTIONS = (4, 5, 8, 12, 14)    # numbers of coefficients that OpenCV has

Floats = NDArray[np.float64]


def _read(path: Path) -> dict[Any, Any]:
    try:
        return read_mapping(path, path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise UserError(f"cannot read {path}: {error.strerror}; {_HELP}") from None
    except UnicodeDecodeError:
        raise UserError(f"{path} is not text; {_HELP}") from None


def _array(path: Path, name: str, value: Any, shapes: Sequence[tuple[int, ...]]) -> Floats:
    """Numbers of one of these shapes, from lists or from OpenCV's mapping with ``rows``, ``cols`` and ``data``."""
    data = value.get("data") if isinstance(value, dict) else value
    try:
        numbers = np.array(data, dtype=np.float64).ravel()
    except (TypeError, ValueError):
        numbers = np.empty(0)
    shape = next((each for each in shapes if numbers.size == np.prod(each)), None)
    if shape is None or not np.isfinite(numbers).all():
        counts = " or ".join(str(int(np.prod(each))) for each in shapes)
        raise UserError(f"{path} has a {name} that is not {counts} numbers; correct it")
    return numbers.reshape(shape)


def _lens(path: Path, entries: dict[Any, Any], camera: int) -> tuple[Floats, Floats]:
    names = f"M{camera}", f"D{camera}"
    matrix = _array(path, names[0], entries[names[0]], [(3, 3)])
    if matrix[0, 0] <= 0 or matrix[1, 1] <= 0:
        raise UserError(f"{path} has an {names[0]} with a focal length that is not above 0; correct it")
    return matrix, _array(path, names[1], entries[names[1]], [(count,) for count in _DISTORTIONS])


def read_intrinsics(path: Path) -> list[Floats]:
    """Matrix and distortion of the left and of the right camera, ``M1 D1 M2 D2`` of OpenCV's ``intrinsics.yml``."""
    entries = _read(path)
    _need(path, entries, ("M1", "D1", "M2", "D2"))
    return [*_lens(path, entries, 1), *_lens(path, entries, 2)]


def _need(path: Path, entries: dict[Any, Any], names: Sequence[str]) -> None:
    lacking = [name for name in names if name not in entries]
    if lacking:
        raise UserError(f"{path} has no {' and no '.join(lacking)}; give the file that has, intrinsics.yml (M1, D1, M2, D2) and "
                        "extrinsics.yml (R, T) of OpenCV's stereo_calib")


def read_cameras(paths: Sequence[Path], size: tuple[int, int] | None, unit: float | None) -> Rectified:
    """The cameras in files, rectified.

    Parameters
    ----------
    paths : sequence of path
        Kalibr's camchain; or OpenCV's YAML with ``M1 D1 M2 D2 R T``, in one file or two.
    size : (int, int) or None
        Width and height of the pictures; Kalibr's file has it.
    unit : float or None
        Millimetres in the unit of OpenCV's ``T``, which its file does not tell; Kalibr's is the metre.

    Returns
    -------
    Rectified
        :class:`UserError` if the files are something else, or these cameras cannot be rectified.
    """
    entries = _read(paths[0])
    if "cam0" in entries:
        if len(paths) > 1:
            raise UserError(f"{paths[0]} of Kalibr has both cameras; leave {paths[1]} out")
        if unit is not None:
            raise UserError(f"{paths[0]} of Kalibr is in metres; leave --baseline-unit out")
        return _kalibr(paths[0], entries, size)
    told = " and ".join(map(str, paths))
    for path in paths[1:]:
        entries = {**entries, **_read(path)}
    _need(Path(told), entries, ("M1", "D1", "M2", "D2", "R", "T"))
    if size is None:
        raise UserError(f"{told} of OpenCV does not tell the size of the pictures; give --size WIDTHxHEIGHT")
    if unit is None:
        raise UserError(f"{told} of OpenCV does not tell the unit of T; give --baseline-unit mm, cm or m, which was that of the chessboard")
    first, second = (_lens(Path(told), entries, camera) for camera in (1, 2))
    rotation = _rotation(Path(told), "R", _array(Path(told), "R", entries["R"], [(3, 3), (3,)]))
    return rectification(size, *first, *second, rotation, unit * _array(Path(told), "T", entries["T"], [(3, 1)]))


def _rotation(path: Path, name: str, value: Floats) -> Floats:
    """A rotation, which may be given as a vector."""
    if value.shape == (3,):
        value = opencv().Rodrigues(value)[0]
    if np.abs(value @ value.T - np.eye(3)).max() > 1e-3 or np.linalg.det(value) < 0:
        raise UserError(f"{path} has a {name} that is no rotation; correct it")
    return value


def _kalibr(path: Path, entries: dict[Any, Any], size: tuple[int, int] | None) -> Rectified:
    lenses, sizes = [], []
    for name in ("cam0", "cam1"):
        camera = entries.get(name)
        if not isinstance(camera, dict):
            raise UserError(f"{path} has no {name}; give a camera chain of two cameras")
        model, lens = camera.get("camera_model"), camera.get("distortion_model")
        if model != "pinhole" or lens not in ("radtan", "none"):
            raise UserError(f"{path} has the {name} of camera_model {model}, distortion_model {lens}; only pinhole with radtan or none can "
                            "be rectified: calibrate with pinhole-radtan")
        fx, fy, cx, cy = _array(path, f"{name}.intrinsics", camera.get("intrinsics"), [(4,)])
        bent = np.zeros(4) if lens == "none" else _array(path, f"{name}.distortion_coeffs", camera.get("distortion_coeffs"), [(4,)])
        lenses.append((np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), bent))
        width, height = map(int, _array(path, f"{name}.resolution", camera.get("resolution"), [(2,)]))
        sizes.append((width, height))
    if sizes[0] != sizes[1] or size not in (None, sizes[0]):
        told = [f"{width}x{height}" for width, height in [*sizes, *([size] if size else [])]]
        raise UserError(f"{path} and --size differ in the size of the pictures, or its cameras do: {', '.join(told)}; use one size")
    # Of cam1 from cam0: the right camera is cam1 if that is to the right.
    place = _array(path, "cam1.T_cn_cnm1", entries["cam1"].get("T_cn_cnm1"), [(4, 4)])
    return rectification(sizes[0], *lenses[0], *lenses[1], _rotation(path, "cam1.T_cn_cnm1", place[:3, :3]), UNITS["m"] * place[:3, 3:])

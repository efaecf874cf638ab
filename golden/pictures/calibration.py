"""Calibration of a rectified pair: Middlebury's calib.txt."""

import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import UserError


__all__ = ["Calibration", "read_calibration"]


_LINE = re.compile(r"\s*(\w+)\s*=\s*(.*?)\s*")


@dataclass(frozen=True)
class Calibration:
    """Parameters of a rectified pair of cameras from which depth is computed.

    Parameters
    ----------
    focal : float
        Focal length of both, pixels.
    baseline : float
        Distance between them, in any unit of length, which is the unit of depth.
    offset : float
        Pixels that are added to a disparity before depth is computed: distance of the principal points (Middlebury's ``doffs``).
    centre : (float, float) or None
        Principal point of the left picture, x and y in pixels; ``None``: the middle of the picture.
    size : (int, int) or None
        Width and height of the pictures it applies to, pixels; ``None``: any.
    """
    focal: float
    baseline: float
    offset: float = 0.0
    centre: tuple[float, float] | None = None
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name in ("focal", "baseline"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be a number above 0, not {value:g}")
        if not math.isfinite(self.offset):
            raise ValueError(f"offset must be a number, not {self.offset:g}")


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """The calibration in a file in the format of Middlebury 2014's ``calib.txt``, lines ``name=value``.

    Read are ``cam0`` (the left camera's matrix, rows separated by ``;``), ``baseline``, and, if present, ``doffs``, ``width`` and
    ``height``. :class:`UserError` if the file has another format.
    """
    path = Path(path)
    try:
        matches = map(_LINE.fullmatch, path.read_text(encoding="utf-8").splitlines())
    except OSError as error:
        raise UserError(f"cannot read {path}: {error.strerror}; give a calib.txt as Middlebury 2014 has it") from error
    except UnicodeDecodeError:
        raise UserError(f"{path} is not text; give a calib.txt as Middlebury 2014 has it") from None
    entries = {match[1]: match[2] for match in matches if match}
    for name in ("cam0", "baseline"):
        if name not in entries:
            raise UserError(f"{path} has no {name}; add the line {name}=..., or give --focal and --baseline instead of --calib")

    def number(name: str, text: str) -> float:
        try:
            return float(text)
        except ValueError:
            raise UserError(f"{path} has the {name} {text[:40]!r}, which is not a number; correct it") from None

    matrix = [row.split() for row in entries["cam0"].strip("[] ").split(";")]
    if [len(row) for row in matrix] != [3, 3, 3]:
        raise UserError(f"{path} has the cam0 {entries['cam0'][:60]!r}; write it as [f 0 cx; 0 f cy; 0 0 1]")
    try:
        size = tuple(int(number(name, entries[name])) for name in ("width", "height") if name in entries)
        return Calibration(
            focal=number("focal length", matrix[0][0]), baseline=number("baseline", entries["baseline"]),
            offset=number("doffs", entries.get("doffs", "0")), centre=(number("cx", matrix[0][2]), number("cy", matrix[1][2])),
            size=(size[0], size[1]) if len(size) == 2 else None)
    except UserError:
        raise
    except (ValueError, OverflowError) as error:
        raise UserError(f"{path} cannot be a calibration: {error}; correct it") from None

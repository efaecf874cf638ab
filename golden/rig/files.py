"""Files of a rig: the maps of both cameras as the words of the gateware, in JSON."""

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..errors import UserError
from ..files import parsed, write_json
from .lines import check_rows, lines_needed
from .maps import RectifyMap, pack, unpack
from .rectify import ROW_OFFSETS, move_rows, rectify


__all__ = ["RIG_NAME", "Rig", "read_rig", "write_rig"]


#: The file's name in a folder that ``golden calibrate`` has written.
RIG_NAME = "rig.json"

_FORMAT = "stereo rig"
_VERSION = 1


@dataclass(frozen=True)
class Rig:
    """How the pictures of two mounted cameras become a rectified pair.

    Parameters
    ----------
    left, right : RectifyMap
        For pictures of one size.
    row_offset : int
        Lines by which the reader moves the right camera's picture before it is rectified: line ``y`` is the camera's ``y + row_offset``.

    :class:`ValueError` if the sizes differ, the offset is not one of :data:`golden.rig.rectify.ROW_OFFSETS`, or row bounds are wrong.
    """
    left: RectifyMap
    right: RectifyMap
    row_offset: int = 0

    def __post_init__(self) -> None:
        sizes = [(each.width, each.height) for each in (self.left, self.right)]
        if sizes[0] != sizes[1]:
            raise ValueError(f"the maps are for pictures of {sizes[0][0]}x{sizes[0][1]} and {sizes[1][0]}x{sizes[1][1]} pixels; "
                             "calibrate both cameras at one size")
        if not isinstance(self.row_offset, int) or self.row_offset not in ROW_OFFSETS:
            raise ValueError(f"row_offset must be a whole number from {ROW_OFFSETS[0]} to {ROW_OFFSETS[-1]}, not {self.row_offset!r}; "
                             "level the cameras")
        for each in (self.left, self.right):
            check_rows(each)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures, pixels."""
        return self.left.width, self.left.height

    @property
    def lines(self) -> int:
        """Lines that the rectifiers must hold."""
        return lines_needed([self.left, self.right])

    def rectified(self, left, right) -> tuple[NDArray[Any], NDArray[Any]]:  # type: ignore[no-untyped-def]
        """The rectified pair of the cameras' pictures, (H, W) uint8 each; :class:`ValueError` if they have another size."""
        return rectify(left, self.left), rectify(move_rows(right, self.row_offset), self.right)


def write_rig(path: str | os.PathLike[str], rig: Rig) -> None:
    """Write a rig, whole or not at all: ``width``, ``height``, ``row_offset``, and as ``left`` and ``right`` the words of
    :func:`golden.rig.maps.pack`, nine hexadecimal digits each.
    """
    width, height = rig.size
    words = {side: [f"{word:09x}" for word in pack(which)] for side, which in (("left", rig.left), ("right", rig.right))}
    write_json(path, {"format": _FORMAT, "version": _VERSION, "width": width, "height": height, "row_offset": rig.row_offset, **words})


def read_rig(path: str | os.PathLike[str]) -> Rig:
    """The rig in a file, or in the file :data:`RIG_NAME` of a folder; :class:`UserError` if there is none, or it holds something else."""
    path = Path(path)
    path = path / RIG_NAME if path.is_dir() else path
    try:
        document = parsed(json.loads, path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"cannot read {path}: {error.strerror}; give the {RIG_NAME} of golden calibrate, or its folder") from error
    except ValueError:
        document = None
    if not isinstance(document, dict) or document.get("format") != _FORMAT:
        raise UserError(f"{path} is not a rig; give the {RIG_NAME} of golden calibrate, or its folder")
    if document.get("version") != _VERSION:
        raise UserError(f"{path} is a rig of version {document.get('version')!r}, and version {_VERSION} can be read; calibrate again")
    try:
        width, height, row_offset = (document[name] for name in ("width", "height", "row_offset"))
        left, right = (unpack([int(word, 16) for word in document[side]], width, height) for side in ("left", "right"))
        return Rig(left, right, row_offset)
    except KeyError as error:
        raise UserError(f"{path} has no {error.args[0]}; calibrate again") from None
    except (TypeError, ValueError, OverflowError) as error:
        remedy = "" if "; " in str(error) else "; calibrate again"
        raise UserError(f"{path} cannot be a rig: {error}{remedy}") from None

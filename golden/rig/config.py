"""What rectification and balance in gateware are built with."""

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .files import Rig
from .lines import DEFAULT_LINES, LINES, check_lines
from .maps import pack


__all__ = ["MapsInUse", "RigConfig"]


class MapsInUse(enum.IntEnum):
    """Which maps the rectifiers have in use: the identity, those that were built in, or those that the host has loaded."""
    IDENTITY, BUILT_IN, LOADED = range(3)


@dataclass(frozen=True)
class RigConfig:
    """Parameters of the stages between two cameras and the matcher.

    Parameters
    ----------
    lines : int
        That each rectifier holds; one of :data:`golden.rig.lines.LINES`.
    rig : Rig or None
        Whose maps the gateware has after configuration; the identity if ``None``.

    :class:`ValueError` for another number of lines, and for a rig that needs more of them.
    """
    lines: int = DEFAULT_LINES
    rig: Rig | None = None

    def __post_init__(self) -> None:
        if self.lines not in LINES:
            raise ValueError(f"rectifiers can hold {', '.join(map(str, LINES))} lines, not {self.lines!r}; choose one of these")
        if self.rig:
            check_lines([self.rig.left, self.rig.right], self.lines)

    def check_size(self, width: int, height: int) -> None:
        """:class:`ValueError` unless the rig, if there is one, is for pictures of this size."""
        if self.rig and self.rig.size != (width, height):
            raise ValueError(f"the rig is for pictures of {'x'.join(map(str, self.rig.size))} pixels, and the cameras send "
                             f"{width}x{height}; calibrate at this size")

    @property
    def row_offset(self) -> int:
        """Lines by which the reader moves the right camera's picture after configuration."""
        return self.rig.row_offset if self.rig else 0

    @property
    def maps(self) -> Mapping[str, Sequence[int]]:
        """Words of the map of each side, by its name; empty without a rig."""
        return {"left": pack(self.rig.left), "right": pack(self.rig.right)} if self.rig else {}

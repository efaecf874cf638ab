"""The systems that a serial line may lead to, by the identity that each of them tells."""

from collections.abc import Callable
from dataclasses import dataclass

from ..config import MatcherConfig
from ..rig.config import RigConfig
from .blocks import line_bytes
from .loop_registers import LOOP_IDENTITY, LOOP_VERSION, loop_register_map
from .registers import IDENTITY, VERSION, RegisterMap, register_map


__all__ = ["SYSTEMS", "System"]


@dataclass(frozen=True)
class System:
    """What a host must know of a system.

    Parameters
    ----------
    about : str
        What it is, with an article.
    version : int
        Of its register map.
    registers : callable
        Register map of a configuration, lines of a picture, and lines that rectifiers hold.
    size : tuple of str
        Registers with the width and the height of the pictures in its memory.
    line_bytes : callable
        Bytes of a block, without its CRC, that is a line of so many pixels, a byte each.
    cameras : bool
        Whether pictures have the cameras' size, and pairs are theirs unless the host sends its own.
    """
    about: str
    version: int
    registers: Callable[[MatcherConfig, int, int], RegisterMap]
    size: tuple[str, str]
    line_bytes: Callable[[int], int]
    cameras: bool


#: Identity to system.
SYSTEMS = {
    IDENTITY: System("a system with cameras", VERSION,
                     lambda config, height, lines: register_map(config, height, RigConfig(lines) if lines else None),
                     ("width", "height"), line_bytes, True),
    LOOP_IDENTITY: System("a matcher behind a serial line", LOOP_VERSION, lambda config, height, lines: loop_register_map(config, height),
                          ("picture_width", "picture_height"), lambda width: width, False),
}

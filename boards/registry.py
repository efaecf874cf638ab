"""Finds boards by name. A board is a folder ``boards/NAME/`` whose module ``board`` exports one :class:`Board` as ``BOARD``."""

import importlib
import math
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol

import boards
from golden.config import MatcherConfig
from golden.errors import UserError
from golden.host.registers import RegisterMap, register_map
from golden.rig.config import RigConfig
from golden.video.bandwidth import Budget, MemoryTiming
from golden.video.formats import DISPLAYS, PAL, CameraFormat, DisplayFormat
from hdl.bitstream import Bitstream
from hdl.fit import Fit
from hdl.matcher.matcher import Matcher
from hdl.netlist import Netlist
from hdl.video.system import StereoSystem

from .loader import Loader


__all__ = ["Board", "Design", "Project", "Serial", "System", "board_names", "find_board", "stereo_system"]


@dataclass(frozen=True)
class Design:
    """What is built for a board.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Lines of a picture; its lines have ``config.max_width`` pixels.
    clock_hz : int
        Of the matcher.
    display : DisplayFormat or None
        ``None`` for a board without a monitor.
    rig : RigConfig or None
        Rectification and balance; ``None`` without them.
    baud : int or None
        Bits a second on the serial line, of a board on which they are chosen.
    """
    config: MatcherConfig
    height: int
    clock_hz: int
    display: DisplayFormat | None = None
    rig: RigConfig | None = None
    baud: int | None = None


class System(Protocol):
    """A component for a board: its ports are those that the board's project connects.

    ``budget`` is that of its frame store; ``None`` without one.
    """
    matcher: Matcher
    budget: Budget | None


def stereo_system(design: Design) -> System:
    """The system with two cameras, memory and monitor; its ports are :class:`hdl.video.ports.SystemPorts`."""
    assert design.display
    return StereoSystem(design.config, design.display, timing=MemoryTiming.at(design.clock_hz), rig=design.rig)


def stereo_registers(design: Design) -> RegisterMap:
    """Registers of :func:`stereo_system`."""
    return register_map(design.config, design.height, design.rig)


@dataclass(frozen=True)
class Project:
    """A project to be written.

    Parameters
    ----------
    name : str
        Of the top-level module, which is in the file ``NAME.v``.
    files : dict
        File name to text.
    netlist : dict
        The modules of the same design.
    clocks_mhz : mapping
        Frequencies of the clocks that blocks of the vendor generate, by their sources as :func:`hdl.netlist.clock_sources` has them.
    stored : str
        What pictures of a host are stored in, in words.
    """
    name: str
    files: dict[str, str]
    netlist: dict[str, Netlist]
    clocks_mhz: Mapping[str, float] = field(default_factory=dict)
    stored: str = ""

    @property
    def ports(self) -> dict[str, tuple[str, int]]:
        """Ports of the top level in alphabetical order: name to direction and width in bits."""
        return {name: (port.direction, len(port.bits)) for name, port in sorted(self.netlist[self.name].ports.items())}


@dataclass(frozen=True)
class Serial:
    """Pairs of pictures that a host sends to a board without cameras: what is built unless something else is chosen.

    Parameters
    ----------
    width, height, disparities : int
    baud : int
        Bits a second.
    """
    width: int
    height: int
    disparities: int
    baud: int


@dataclass(frozen=True)
class Board:
    """A board, as ``python -m hdl.build --board NAME`` uses it.

    Parameters
    ----------
    name : str
        Of its folder.
    device : str
        The FPGA, by its ordering code.
    clock_mhz : float
        Clock of the matcher, unless another one is chosen. On a board with a frame store it is that of the memory controller's local
        interface.
    toolchain : str
        The software that takes the project, a vendor's or openly developed.
    project : callable
        Makes the :class:`Project` from a system and the design.
    check : callable
        Lists the problems of a project, a sentence each; empty if it is sound.
    system : callable
        Makes the component that is on the board, from the design.
    registers : callable
        The host's registers of the same design.
    about : mapping
        Entries of the manifest that only this board has.
    pictures : CameraFormat or Serial
        Where pictures come from. Cameras determine their size.
    displays : mapping
        Formats of its monitor by name, the default first. Empty without a monitor.
    memory_clocks_mhz : mapping
        What ``--memory-clock`` may choose: clock of the memory itself, in MHz, to that of the local interface. Empty without a choice.
    make_clock : callable or None
        What ``--clock`` may choose: takes MHz, returns Hz, and raises :class:`golden.errors.UserError` if the board does not make that
        clock. ``None`` without a choice.
    fit : callable or None
        What a project takes of the device; without it nothing is said about that.
    bitstream : callable or None
        Makes the bitstream of a project, with the folder where logs are kept, and a function that is called with the name of each step.
        ``None`` where a vendor's software has to.
    needs : mapping
        Modules that making the bitstream needs, and their packages.
    loader : Loader or None
        Loads the bitstream into the board; ``None`` if that is not known.
    """
    name: str
    device: str
    clock_mhz: float
    toolchain: str
    project: Callable[[Any, Design], Project]
    check: Callable[[Project], list[str]]
    system: Callable[[Design], System] = stereo_system
    registers: Callable[[Design], RegisterMap] = stereo_registers
    about: Mapping[str, Any] = field(default_factory=dict)
    pictures: CameraFormat | Serial = PAL
    displays: Mapping[str, DisplayFormat] = field(default_factory=lambda: DISPLAYS)
    memory_clocks_mhz: Mapping[int, float] = field(default_factory=dict)
    make_clock: Callable[[float], int] | None = None
    fit: Callable[[Project], Fit] | None = None
    bitstream: Callable[[Project, Path, Callable[[str], None]], Bitstream] | None = None
    needs: Mapping[str, str] = field(default_factory=dict)
    loader: Loader | None = None

    def clock_hz(self, clock_mhz: float | None = None, memory_clock_mhz: int | None = None) -> int:
        """Clock of the matcher: with the memory at the one clock, or at the other clock, or as the board has it by default.

        :class:`golden.errors.UserError` if the board does not offer it.
        """
        if memory_clock_mhz is not None and memory_clock_mhz not in self.memory_clocks_mhz:
            offered = " or ".join(map(str, sorted(self.memory_clocks_mhz)))
            raise UserError(f"the board {self.name} does not run its memory at {memory_clock_mhz} MHz; " +
                            (f"choose --memory-clock {offered}" if offered else "leave --memory-clock out"))
        if clock_mhz is not None:
            if self.make_clock is None:
                raise UserError(f"the board {self.name} does not choose the matcher's clock by --clock {clock_mhz:g}; " +
                                ("choose --memory-clock" if self.memory_clocks_mhz else "leave --clock out"))
            if not math.isfinite(clock_mhz):
                raise UserError(f"--clock must be a number of MHz, not {clock_mhz:g}; leave it out for {self.clock_mhz:g} MHz")
            return self.make_clock(clock_mhz)
        return round(1e6 * (self.clock_mhz if memory_clock_mhz is None else self.memory_clocks_mhz[memory_clock_mhz]))


def board_names() -> list[str]:
    """Names of all boards, alphabetically: the folders of this package that have a module ``board``."""
    names = (folder.name for folder in pkgutil.iter_modules(boards.__path__) if folder.ispkg)
    return sorted(name for name in names if find_spec(f"boards.{name}.board"))


def find_board(name: str) -> Board:
    """The board of that name; :class:`golden.errors.UserError` if there is none, or if it needs a Python package that is not installed."""
    names = board_names()
    if name not in names:
        raise UserError(f"there is no board {name!r}; choose one of: {', '.join(names)}")
    try:
        module = importlib.import_module(f"boards.{name}.board")
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] in ("boards", "golden", "hdl"):
            raise
        package = error.name.partition(".")[0].replace("_", "-")
        raise UserError(f"the board {name} needs the Python package {package}; install it with `pip install {package}`") from None
    board = getattr(module, "BOARD", None)
    if not isinstance(board, Board) or board.name != name:
        raise UserError(f"the module boards.{name}.board has {board!r} as BOARD; export a Board named {name!r} there")
    return board

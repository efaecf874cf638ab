"""Finds boards by name. A board is a folder ``boards/NAME/`` whose module ``board`` exports one :class:`Board` as ``BOARD``."""

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any, Protocol

import boards
from golden.config import MatcherConfig
from golden.errors import UserError
from golden.rig.config import RigConfig
from golden.video.bandwidth import Budget, MemoryTiming
from golden.video.formats import DisplayFormat
from hdl.fit import Fit
from hdl.matcher.matcher import Matcher
from hdl.netlist import Netlist
from hdl.resources.count import Count, Resources
from hdl.resources.devices import Device
from hdl.video.system import StereoSystem


__all__ = ["Board", "Project", "System", "board_names", "find_board", "stereo_system"]


class System(Protocol):
    """A component for a board: its ports are those that the board's project connects."""
    matcher: Matcher
    budget: Budget


def stereo_system(config: MatcherConfig, display: DisplayFormat, timing: MemoryTiming, rig: RigConfig | None) -> System:
    """The system with two cameras, memory and monitor; its ports are :class:`hdl.video.ports.SystemPorts`.

    Rectification and balance are those of ``rig``; without them if ``None``.
    """
    return StereoSystem(config, display, timing=timing, rig=rig)


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
    """
    name: str
    files: dict[str, str]
    netlist: dict[str, Netlist]
    clocks_mhz: Mapping[str, float] = field(default_factory=dict)

    @property
    def ports(self) -> dict[str, tuple[str, int]]:
        """Ports of the top level in alphabetical order: name to direction and width in bits."""
        return {name: (port.direction, len(port.bits)) for name, port in sorted(self.netlist[self.name].ports.items())}


@dataclass(frozen=True)
class Board:
    """A board, as ``python -m hdl.build --board NAME`` uses it.

    Parameters
    ----------
    name : str
        Of its folder.
    device : Device
        The FPGA.
    memory_clock_mhz : float
        Clock of the memory controller's local interface, which is the clock of the matcher, unless another one is chosen.
    toolchain : str
        The vendor's software that takes the project.
    project : callable
        Makes the :class:`Project` from a system, the display and the configuration.
    check : callable
        Lists the problems of a project, a sentence each; empty if it is sound.
    system : callable
        Makes the component that is on the board, of what :func:`stereo_system` takes.
    about : mapping
        Entries of the manifest that only this board has.
    estimate : callable or None
        Estimates what a project's netlist takes of a device of this family; without it nothing is said about the fit.
    allowance : Resources
        What black boxes of the netlist take, which no estimate sees.
    allowed_for : str
        What these are, in words.
    memory_clocks_mhz : mapping
        What ``--memory-clock`` may choose: clock of the memory itself, in MHz, to that of the local interface. Empty without a choice.
    """
    name: str
    device: Device
    memory_clock_mhz: float
    toolchain: str
    project: Callable[[System, DisplayFormat, MatcherConfig], Project]
    check: Callable[[Project], list[str]]
    system: Callable[[MatcherConfig, DisplayFormat, MemoryTiming, RigConfig | None], System] = stereo_system
    about: Mapping[str, Any] = field(default_factory=dict)
    memory_clocks_mhz: Mapping[int, float] = field(default_factory=dict)
    estimate: Callable[[Mapping[str, Netlist], str], Count] | None = None
    allowance: Resources = field(default_factory=Resources)
    allowed_for: str = ""

    def fit(self, project: Project) -> Fit | None:
        """The project beside the device; ``None`` if this board estimates nothing."""
        if self.estimate is None:
            return None
        return Fit(self.estimate(project.netlist, project.name).total, self.allowance, self.allowed_for, self.device)

    def local_clock_mhz(self, memory_clock_mhz: int | None) -> float:
        """Clock of the local interface with the memory at that clock, or as the board has it by default.

        :class:`golden.errors.UserError` if the board does not offer it.
        """
        if memory_clock_mhz is None:
            return self.memory_clock_mhz
        if memory_clock_mhz not in self.memory_clocks_mhz:
            offered = " or ".join(map(str, sorted(self.memory_clocks_mhz)))
            raise UserError(f"the board {self.name} does not run its memory at {memory_clock_mhz} MHz; " +
                            (f"choose --memory-clock {offered}" if offered else "leave --memory-clock out"))
        return self.memory_clocks_mhz[memory_clock_mhz]


def board_names() -> list[str]:
    """Names of all boards, alphabetically: the folders of this package that have a module ``board``."""
    names = (folder.name for folder in pkgutil.iter_modules(boards.__path__) if folder.ispkg)
    return sorted(name for name in names if find_spec(f"boards.{name}.board"))


def find_board(name: str) -> Board:
    """The board of that name; :class:`golden.errors.UserError` if there is none."""
    names = board_names()
    if name not in names:
        raise UserError(f"there is no board {name!r}; choose one of: {', '.join(names)}")
    board = getattr(importlib.import_module(f"boards.{name}.board"), "BOARD", None)
    if not isinstance(board, Board) or board.name != name:
        raise UserError(f"the module boards.{name}.board has {board!r} as BOARD; export a Board named {name!r} there")
    return board

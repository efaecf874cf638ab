"""The board in the simulator's place: ``python -m sim.run LEFT RIGHT --hardware PORT``."""

import argparse
import contextlib
import functools
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from golden.cli import progress
from golden.config import MatcherConfig
from golden.errors import UserError
from golden.host.loop_registers import LOOP_BAUD
from hdl.host.chip import Chip, SerialPort, Transport
from hdl.host.loop import Board, BoardRun, LoopBoard
from hdl.host.put import CameraBoard

from .figures import common_report, print_figures
from .kit.harness import Result


__all__ = ["Connect", "add_hardware_options", "as_result", "board_report", "match_shown", "opened", "print_board", "serial_port"]


#: Opens a port at a baud rate.
Connect = Callable[[str, int], AbstractContextManager[Transport]]

#: With the option that names the port.
serial_port: Connect = functools.partial(SerialPort, option="--hardware")

_LIMITS = {"baud": (1, 4_000_000), "timeout": (0.001, 60)}


def add_hardware_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--hardware``, ``--baud`` and ``--timeout``."""
    parser.add_argument("--hardware", metavar="PORT", help="match on the board at this serial port, such as /dev/ttyUSB0, in place of a "
                        "simulator; docs/loop.md")
    parser.add_argument("--baud", type=int, metavar="BAUD", help=f"bits a second of the board's line (default: {LOOP_BAUD})")
    parser.add_argument("--timeout", type=float, metavar="S", help="longest wait for a reply of the board, seconds (default: 0.2)")


@contextlib.contextmanager
def opened(options: argparse.Namespace, connect: Connect) -> Iterator[Board | None]:
    """The board that ``--hardware`` names, for the block; ``None`` without the option. :class:`UserError` if there is no such board."""
    if options.hardware is None:
        for name in _LIMITS:
            if getattr(options, name) is not None:
                raise UserError(f"--{name} is of a board's line; name its port with --hardware, or leave --{name} out")
        yield None
        return
    if options.waves:
        raise UserError("--waves is of a simulation; leave it out with --hardware")
    if options.simulator is not None:
        raise UserError(f"--simulator {options.simulator} and --hardware exclude each other; leave one of them out")
    for name, (least, greatest) in _LIMITS.items():
        value = getattr(options, name)
        if value is not None and not least <= value <= greatest:
            raise UserError(f"--{name} must be from {least} to {greatest}, not {value}; choose a value in that range")
    baud = options.baud or LOOP_BAUD
    with connect(options.hardware, baud) as transport:
        chip = Chip(transport, options.timeout or 0.2, "--hardware")
        yield (CameraBoard if chip.system.cameras else LoopBoard)(chip, baud)


def match_shown(board: Board, config: MatcherConfig, left: NDArray[np.uint8], right: NDArray[np.uint8]) -> BoardRun:
    """:meth:`hdl.host.loop.Board.match` with a progress bar."""
    with progress() as bar:
        task = bar.add_task("", total=None)
        return board.match(left, right, config, lambda what, done, total: bar.update(task, description=what, completed=done, total=total))


def as_result(run: BoardRun) -> Result:
    """A run of the board as one of the simulator, for what reads its fields."""
    return Result([run.fields], [], {"clocks": run.clocks}, run.seconds, 0.0)


def board_report(board: Board, run: BoardRun, config: MatcherConfig, options: argparse.Namespace, wrong: int) -> dict:
    """The figures of a run, for ``report.json``."""
    height, width = run.fields["disparity"].shape
    return {
        **common_report(config, height, width, run.clocks, wrong), "hardware": options.hardware, "baud": board.baud,
        "clocks_per_pixel": round(run.clocks / (width * height), 4),
        "put_seconds": round(run.put_seconds, 4), "match_seconds": round(run.match_seconds, 4), "get_seconds": round(run.get_seconds, 4),
        "frames_per_second": round(1 / run.seconds, 3), "repeated": run.repeated,
        "line_frames_per_second": round(1 / board.line_seconds(width, height, config), 3),
    }


def print_board(report: dict, config: MatcherConfig, folder: Path) -> None:
    """The figures, as a table on stdout."""
    print_figures(report, config, f"board at {report['hardware']}", (
        ("frames/s, sent, matched and read", f"{report['frames_per_second']:.2f}"),
        (f"frames/s that the line allows at {report['baud']:,} baud", f"{report['line_frames_per_second']:.2f}"),
        ("clocks of the board for the pair", f"{report['clocks']}"),
        ("clocks per pixel", f"{report['clocks_per_pixel']:.3f}"),
        ("seconds to send the pair", f"{report['put_seconds']:.3f}"),
        ("seconds until it was matched", f"{report['match_seconds']:.3f}"),
        ("seconds to read the result", f"{report['get_seconds']:.3f}"),
        ("requests and blocks repeated", f"{report['repeated']}"),
    ), folder)

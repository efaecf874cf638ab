"""`python -m hdl.host.console`: settings, status, counters, maps and pictures of a running system, over its serial line."""

import functools
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.live import Live
from rich.table import Table

from golden.cli import Parser
from golden.errors import UserError, run_cli
from golden.files import check_output
from golden.host.blocks import PLANES
from golden.host.protocol import BAUD
from golden.host.registers import Kind, Register, RegisterMap, register_map
from golden.pictures.images import read_pair, write_picture
from golden.rig.config import RigConfig
from golden.rig.files import RIG_NAME, read_rig
from golden.tables import print_table, whole

from .calibrate import DEFAULT_PAIRS, PAIRS, calibrate, check_calibration
from .chip import Chip, SerialPort, Transport
from .grab import grab, grab_pair, showing
from .load_map import load_rig
from .put import put


__all__ = ["main"]


def _register(registers: RegisterMap, name: str) -> Register:
    if name not in registers:
        raise UserError(f"there is no register {name!r}; python -m hdl.host.console list shows all of them")
    return registers[name]


def _assignment(registers: RegisterMap, text: str) -> tuple[Register, int]:
    """The register and the value of ``NAME=VALUE``."""
    name, equals, what = text.partition("=")
    if not equals:
        raise UserError(f"{text!r} is no assignment; write it as NAME=VALUE")
    register = _register(registers, name)
    if not register.writable:
        raise UserError(f"{name} cannot be set, it is read-only; python -m hdl.host.console list shows those that can")
    named = {word: value for value, word in register.words.items()}
    try:
        value = named[what] if what in named else int(what, 0)
    except ValueError:
        value = register.maximum + 1
    if not register.minimum <= value <= register.maximum:
        unit = f" {register.unit}" if register.unit else ""
        raise UserError(f"{name} cannot be set to {what!r}; choose one of: {register.limits}{unit}")
    return register, value


def _get(chip: Chip, names: Iterable[str]) -> None:
    registers = [_register(chip.registers, name) for name in names]
    for register in registers:
        print(f"{register.name} = {register.text(chip.read(register.name))}")


def _set(chip: Chip, assignments: Iterable[str]) -> None:
    # All are checked before the first one is written.
    for register, value in [_assignment(chip.registers, text) for text in assignments]:
        chip.write(register.name, value)
        print(f"{register.name} = {register.text(value)}")


def _watch(chip: Chip, interval: float, count: int | None) -> None:
    registers = chip.registers.of(Kind.STATUS, Kind.COUNTER)
    before: dict[str, int] = {}

    def table() -> Table:
        result = Table()
        for column in ("register", "value", "change"):
            result.add_column(column, justify="left" if column == "register" else "right")
        result.add_column("meaning")
        for register in registers:
            value = chip.read(register.name)
            change = value - before.get(register.name, value) if register.kind is Kind.COUNTER else 0
            result.add_row(register.name, register.text(value), f"{change:+}" if change else "", register.description)
            before[register.name] = value
        return whole(result)

    try:
        with Live(table(), console=Console(), auto_refresh=False) as live:
            while count is None or (count := count - 1) > 0:
                time.sleep(interval)
                live.update(table(), refresh=True)
    except KeyboardInterrupt:
        return  # the usual end of a watch


def _list(registers: RegisterMap, caption: str | None = None) -> None:
    table = Table(caption=caption, caption_justify="left")
    for column in ("register", "access", "values", "unit", "meaning"):
        table.add_column(column)
    for register in registers:
        table.add_row(register.name, register.access, register.limits, register.unit, register.description)
    print_table(table)


def _pair(chip: Chip) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    with showing("pair") as report:
        return grab_pair(chip, report)


# Of grey pictures, all of whose pixels are kept.
_SUFFIXES = (".png", ".pgm", ".npy")

# Limits of the numbers on the command line.
_LIMITS = {"baud": (1, 4_000_000), "timeout": (0.001, 60), "interval": (0, 3600), "count": (1, 10**9), "pairs": (PAIRS[0], PAIRS[-1])}


def _parser() -> Parser:
    parser = Parser(prog="python -m hdl.host.console", description=__doc__)
    parser.add_argument("--port", metavar="PORT", help="serial port, such as /dev/ttyUSB0 or COM3; for all commands but list")
    parser.add_argument("--baud", type=int, default=BAUD, metavar="BAUD", help="bits a second (default: %(default)s)")
    parser.add_argument("--timeout", type=float, default=0.2, metavar="S", help="longest wait for a reply, seconds (default: %(default)s)")
    commands = parser.add_subparsers(dest="command", required=True, metavar="get|set|watch|rectify|grab|put|calibrate|list")
    get = commands.add_parser("get", help="print registers")
    get.add_argument("names", nargs="+", metavar="NAME")
    assign = commands.add_parser("set", help="write settings and actions; a setting takes effect at a frame's start")
    assign.add_argument("assignments", nargs="+", metavar="NAME=VALUE")
    watch = commands.add_parser("watch", help="show status and counters until interrupted")
    watch.add_argument("--interval", type=float, default=1.0, metavar="S", help="seconds between two readings (default: %(default)s)")
    watch.add_argument("--count", type=int, metavar="N", help="end after N readings")
    rectify = commands.add_parser("rectify", help="load the maps of both cameras and put them in use")
    rectify.add_argument("rig", type=Path, metavar="DIR", help=f"folder that golden calibrate wrote, or its {RIG_NAME}")
    picture = commands.add_parser("grab", help="read a picture of the next pair out of the chip's memory, while the system runs")
    picture.add_argument("plane", choices=PLANES, metavar="|".join(PLANES), help="a camera's picture, or the disparities as the monitor's "
                         "labels")
    picture.add_argument("file", type=Path, metavar="FILE", help=f"picture to write: {', '.join(_SUFFIXES)}")
    pair = commands.add_parser("put", help="match and show a pair of pictures in place of the cameras', until source=cameras is set")
    for name in ("left", "right"):
        pair.add_argument(name, type=Path, metavar=name.upper(), help="picture of the cameras' size")
    calibration = commands.add_parser("calibrate", help="take pairs of a chessboard with the cameras, calibrate, and load the maps")
    calibration.add_argument("--board", required=True, metavar="9x6", help="inner corners of the chessboard")
    calibration.add_argument("--square", type=float, required=True, metavar="MM", help="side of a square, millimetres")
    calibration.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder of the pictures and of the results")
    calibration.add_argument("--pairs", type=int, default=DEFAULT_PAIRS, metavar="N", help=(
        f"good pairs to be taken, {PAIRS[0]} to {PAIRS[-1]} (default: %(default)s)"))
    commands.add_parser("list", help="show all registers: those behind the port, or without one those of a system with cameras")
    return parser


def _run(connect: Callable[[str, int], AbstractContextManager[Transport]], argv: Sequence[str] | None) -> None:
    options = _parser().parse_args(argv)
    if options.command == "list" and options.port is None:
        return _list(register_map(rig=RigConfig()), "the reset value and the maximum of in_use depend on the build")
    if options.port is None:
        raise UserError("--port is missing; name the serial port that the line is plugged into, such as --port /dev/ttyUSB0")
    for name, (least, greatest) in _LIMITS.items():
        value = getattr(options, name, None)
        if value is not None and not least <= value <= greatest:
            raise UserError(f"--{name} must be from {least} to {greatest}, not {value}; choose a value in that range")
    rig = read_rig(options.rig) if options.command == "rectify" else None
    if options.command == "grab":
        check_output(options.file, _SUFFIXES, "FILE")
    pair = read_pair(options.left, options.right) if options.command == "put" else None
    board = check_calibration(options.board, options.square, options.output) if options.command == "calibrate" else None
    with connect(options.port, options.baud) as transport:
        chip = Chip(transport, options.timeout)
        if options.command == "list":
            _list(chip.registers)
        elif options.command == "get":
            _get(chip, options.names)
        elif options.command == "set":
            _set(chip, options.assignments)
        elif options.command == "grab":
            with showing(options.plane) as report:
                picture = grab(chip, options.plane, report)
            write_picture(options.file, picture)
            print(f"{options.file}: {options.plane}, {picture.shape[1]}x{picture.shape[0]} pixels")
        elif pair:
            with showing("left and right") as report:
                put(chip, *pair, options.baud, report)
            print(f"{options.left} and {options.right} are matched and shown; grab disparity reads the result, set source=cameras ends it")
        elif board:
            print(f"{options.output}: {calibrate(chip, functools.partial(_pair, chip), board, options.output, options.pairs)}")
        elif rig:
            print(f"{options.rig}: {load_rig(chip, rig)}")
        else:
            _watch(chip, options.interval, options.count)


def main(argv: Sequence[str] | None = None, connect: Callable[[str, int], AbstractContextManager[Transport]] = SerialPort) -> int:
    """Run the command line; the exit status is the result. ``connect`` opens the port, at a baud rate."""
    return run_cli(functools.partial(_run, connect), argv, "hdl.host.console")


if __name__ == "__main__":
    sys.exit(main())

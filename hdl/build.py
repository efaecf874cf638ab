"""Write Verilog, of the matcher alone or of the project for a board: ``python -m hdl.build``."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from amaranth.hdl import Value
from amaranth.lib import data
from amaranth.lib.wiring import Component, Flow
from rich.console import Console

from boards.registry import Board, Design, Project, Serial, board_names, find_board
from golden.cli import Parser
from golden.config import MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import atomic, check_folder, output_folder, remove_stale, write_json
from golden.host.core_registers import WORD_BYTES
from golden.rig.config import RigConfig
from golden.tables import print_table
from golden.video.bandwidth import Budget
from golden.video.formats import CameraFormat

from .bitstream import Placed, digest, placed_before
from .emit import port_name, verilog_text
from .fit import Fit, remedies
from .header import command_line, header
from .interfaces.choice import add_interface_option, check_interface
from .interfaces.cores import INTERFACES
from .keywords import reserved
from .matcher.framed import FramedMatcher
from .matcher.matcher import Matcher
from .options import add_design_options, add_rig_options, design_config, need, rig_config, set_defaults
from .packages.core import Core, RegisterSpace
from .packages.registry import add_package_option, chosen_packages, package_files, project_version
from .rectified import PIXEL_ORDER, RectifiedMatcher
from .waivers import verilator_waivers


__all__ = ["main"]


DEFAULT_NAME = "matcher"
MANIFEST = "manifest.json"
FRAMES_PER_SECOND = 25  # PAL


def ports_of(component: Component) -> dict[str, tuple[str, int]]:
    """Ports of the emitted module: name to direction and width in bits."""
    ports = {} if {"clk", "aclk"} & set(component.signature.members) else {"clk": ("input", 1), "rst": ("input", 1)}
    for path, member, value in component.signature.flatten(component):
        ports[port_name(path)] = ("input" if member.flow is Flow.In else "output", len(Value.cast(value)))
    return ports


def fields_of(component: Component) -> dict[str, dict[str, tuple[int, int]]]:
    """Places of the fields of the payloads: port to field to lowest and highest bit."""
    return {
        port_name(path): {name: (field.offset, field.offset + field.width - 1) for name, field in value.shape()}
        for path, _, value in component.signature.flatten(component) if isinstance(value, data.View)
    }


def about_rig(rig: RigConfig | None) -> dict[str, Any]:
    """Entries of the manifest on rectification: lines that a rectifier holds, 0 without; whether a rig is built in, and its row offset."""
    if rig is None:
        return {"rectify_lines": 0}
    return {"rectify_lines": rig.lines, "rig": rig.rig is not None, "row_offset": rig.row_offset}


def manifest_of(name: str, matcher: Matcher | RectifiedMatcher, ports: Mapping[str, tuple[str, int]], height: int,
                arguments: Mapping[str, Any]) -> dict[str, Any]:
    """The manifest: parameters of the matcher, its timing and the ports of the module ``name``; then ``arguments``."""
    config = matcher.config
    clocks = matcher.clocks_per_pixel
    return {
        "top": name,
        "engine": str(config.engine),
        "parameters": {
            "disparities": config.labels, "method": config.method.name, "arithmetic": str(config.method.arithmetic),
            "minimum": config.minimum, "max_width": config.max_width, "height": height, "disparity_scale": config.method.disparity_scale,
            "method_parameters": config.method.about(),
        },
        "clocks_per_pixel": clocks,
        "full_rate_width": matcher.full_rate_width,
        "latency_clocks": matcher.latency_lines * max(config.max_width, matcher.full_rate_width) * clocks + matcher.latency_clocks,
        "ports": {port: {"direction": direction, "width": width} for port, (direction, width) in ports.items()},
        **arguments,
    }


class _Build(NamedTuple):
    """A design to be written: ``about`` has the entries of the manifest beyond the matcher's parameters, ``space`` the host's registers."""
    top: str
    matcher: Matcher | RectifiedMatcher
    files: dict[str, str]
    ports: dict[str, tuple[str, int]]
    about: dict[str, Any]
    budget: Budget | None = None
    space: RegisterSpace | None = None
    fit: Fit | None = None
    project: Project | None = None

    @property
    def packed(self) -> Core:
        """The core as packages describe it."""
        config = self.matcher.config
        description = f"Stereo matcher, method {config.method.name}, {config.labels} disparities, lines of up to {config.max_width} pixels"
        return Core(self.top, project_version(), description, sorted(self.files), self.ports, self.about.get("payloads", {}), self.space)

    def frame_clocks(self, width: int, height: int) -> int:
        """Cycles that a frame takes, with all that is in front of the matcher."""
        of_budget = round(width * height * self.budget.matcher_clocks) if self.budget else 0
        return max(of_budget, self.matcher.frame_clocks(width, height))


def _build_core(name: str, config: MatcherConfig, height: int, rig: RigConfig | None, frame_timing: bool, interface: str) -> _Build:
    about: dict[str, Any] = {"interface": "frame timing" if frame_timing else interface}
    space = None
    if interface in INTERFACES:
        component: Component = (with_bus := INTERFACES[interface](config, height))
        matcher: Matcher | RectifiedMatcher = with_bus.matcher
        about |= with_bus.about
        space = RegisterSpace(with_bus.core.registers, WORD_BYTES, f"Registers of the core {name} with the interface {interface}")
    else:
        matcher = RectifiedMatcher(config, height, rig) if rig else Matcher(config)
        component = FramedMatcher(config, matcher) if frame_timing else matcher
    files = {f"{name}.v": verilog_text(component, name=name), f"{name}.vlt": verilator_waivers(name)}
    about |= {"payloads": fields_of(component), **about_rig(rig), **({"pixel_order": PIXEL_ORDER} if rig else {})}
    return _Build(name, matcher, files, ports_of(component), about, space=space)


def _build_board(design: Design, board: Board, display_name: str | None) -> _Build:
    core = board.system(design)
    project = board.project(core, design)
    config, size = design.config, (design.config.max_width, design.height)
    fit = board.fit(project) if board.fit else None
    if fit:
        fit.check(remedies(config, design.rig, size if isinstance(board.pictures, Serial) else None))
    problems = board.check(project)
    if problems:
        raise RuntimeError(f"the project is not sound: {'; '.join(problems)}")
    about: dict[str, Any] = {"device": board.device}
    if display_name:
        about["display"] = display_name
    about["clock_mhz"] = design.clock_hz / 1e6
    if design.display:
        about["pixel_clock_mhz"] = design.display.pixel_clock_hz / 1e6
    if isinstance(board.pictures, CameraFormat):
        about["camera_clock_mhz"] = board.pictures.byte_clock_hz / 1e6
    else:
        about |= {"width": size[0], "height": size[1], "baud": design.baud, "stored_in": project.stored}
    about |= board.about
    if core.budget:
        about |= {"buffers": core.budget.memory_map.buffers,
                  "memory_words_per_second": {"used": round(core.budget.used), "available": round(core.budget.available)}}
    about |= {"board": board.name, **about_rig(design.rig)}
    if fit:
        about["resources"] = fit.manifest
    space = RegisterSpace(board.registers(design), 2,
                          f"Registers of the system on the board {board.name}: an offset is twice the address on the serial line")
    return _Build(project.name, core.matcher, project.files, project.ports, about, core.budget, space, fit, project)


def _add_board_options(parser: Parser) -> None:
    parser.add_argument("--display", metavar="FORMAT", help="with --board: the monitor's format (default: the board's first one)")
    parser.add_argument("--memory-clock", type=int, metavar="MHZ",
                        help="with --board: clock of the memory, if the board offers several; the matcher has the clock of its controller")
    parser.add_argument("--clock", type=float, metavar="MHZ", help="with --board: clock of the matcher, if the board offers a choice")
    parser.add_argument("--baud", type=int, metavar="BITS", help=(
        "with --board: bits a second on the serial line, if the board offers a choice"))
    parser.add_argument("--no-bitstream", action="store_true", help=(
        "with --board: write the project only, where open tools make the bitstream, in minutes"))
    parser.add_argument("--program", action="store_true", help="with --board: load the bitstream into the board, too")


def _check_core(options: argparse.Namespace) -> None:
    """Raise :class:`UserError` if an option of boards is given with --core."""
    without = {"display": "is the format of the board's monitor, and --core has no monitor",
               "memory_clock": "is that of the board's memory, and --core has none",
               "clock": "is that of the board's matcher, and --core has its clock from the design around it",
               "baud": "is that of the board's serial line, and --core has none",
               "no_bitstream": "is for a board, and --core makes none", "program": "loads a board's bitstream, and --core makes none"}
    for name, reason in without.items():
        if getattr(options, name) not in (None, False):
            option = f"--{name.replace('_', '-')}"
            raise UserError(f"{option} {reason}; choose --board, or leave {option} out")


def _check_board(options: argparse.Namespace, board: Board) -> None:
    """Raise :class:`UserError` if an option does not go with the board."""
    if options.name is not None:
        raise UserError("--name is for the bare matcher, and a board's project has a name; choose --core, or leave --name out")
    if options.frame_timing:
        raise UserError("--frame-timing is for the bare matcher, and --board makes a whole system; choose --core, or leave "
                        "--frame-timing out")
    pictures = board.pictures
    if isinstance(pictures, CameraFormat):
        if (options.width, options.height) != (pictures.width, pictures.height):
            raise UserError(f"the cameras of --board send pictures of {pictures.width}x{pictures.height} pixels, not "
                            f"{options.width}x{options.height}; leave --width and --height out, or choose --core")
        if options.baud is not None:
            raise UserError(f"--baud {options.baud} is for a board that a host sends pictures to, and {board.name} has cameras; "
                            "leave it out")
    else:
        if options.baud is not None and options.baud < 1:
            raise UserError(f"--baud must be a whole number from 1, not {options.baud}; choose {pictures.baud}, or another rate of your "
                            "port")
        for option, value in (("--rectify", options.rectify), ("--rig", options.rig), ("--rectify-lines", options.rectify_lines)):
            if value not in (None, False):
                raise UserError(f"{option} is for a board with cameras, and a host sends rectified pictures to {board.name}; leave it out")
    for option, given in (("--no-bitstream", options.no_bitstream), ("--program", options.program)):
        if given and board.bitstream is None:
            raise UserError(f"{option} is for a board whose bitstream open tools make, and {board.toolchain} makes that of {board.name}; "
                            "leave it out")
    if options.program and options.no_bitstream:
        raise UserError("--program loads the bitstream that --no-bitstream does not make; leave one of the two out")
    if board.bitstream and not options.no_bitstream:
        for module, package in board.needs.items():
            need(module, package)
    if options.program:
        if board.loader is None:
            raise UserError(f"no program that loads {board.name} is known; leave --program out")
        board.loader.find()


def _design(options: argparse.Namespace, board: Board, config: MatcherConfig) -> tuple[Design, str | None]:
    """What is built for a board, and the name of its display."""
    name = options.display
    if name is None:
        name = next(iter(board.displays), None)
    elif not board.displays:
        raise UserError(f"the board {board.name} has no monitor; leave --display out")
    if name is not None and name not in board.displays:
        raise UserError(f"there is no display format {name!r}; choose one of: {', '.join(board.displays)}")
    serial = isinstance(board.pictures, Serial)
    rig = None if serial else rig_config(options, True)
    baud = options.baud or board.pictures.baud if isinstance(board.pictures, Serial) else None
    clock_hz = board.clock_hz(options.clock, options.memory_clock)
    return Design(config, options.height, clock_hz, board.displays[name] if name else None, rig, baud), name


def _write(folder: Path, files: Mapping[str, str], manifest: Mapping[str, Any], placed: Placed | None, sources: str) -> None:
    """Write a project, remove what an earlier one left, and last the manifest, with what is known of a bitstream that is there."""
    document = dict(manifest)
    if placed:
        document |= {"files": sorted([*files, *placed.files, *placed.logs]), "bitstream": placed.about(sources)}
    for file_name, text in files.items():
        with atomic(folder / file_name) as file:
            file.write(text.encode())
    remove_stale(folder, MANIFEST, ("top", "ports"), document["files"])
    write_json(folder / MANIFEST, document)


def _tell_board(board: Board, design: Design, build: _Build, folder: Path) -> None:
    """Print what a board's clocks and memory are, what the design takes of its device, and what is to be done."""
    clock_mhz = design.clock_hz / 1e6
    if build.budget:
        print(f"The memory controller gives the matcher {clock_mhz:g} MHz; "
              f"frames wait in {build.budget.buffers} buffers for each camera{', a kept pair in one more' if build.budget.kept else ''}.")
        print_table(build.budget.table())
    else:
        assert build.project
        print(f"The matcher has {clock_mhz:g} MHz, the serial line {design.baud:,} bits a second; pictures are in {build.project.stored}.")
    if build.fit:
        print_table(build.fit.table())
        print("\n".join(build.fit.told()))
        if warning := build.fit.warning():
            print(f"hdl.build: {warning}", file=sys.stderr)
    if "README.md" in build.files:
        what = "What to plug in" if board.bitstream else f"What to do in {board.toolchain}"
        print(f"{what}: {folder / 'README.md'}")


def _make_bitstream(board: Board, build: _Build, folder: Path) -> Placed:
    """Make and write the bitstream of a project; what place and route says of it."""
    assert board.bitstream and build.project
    with Console(stderr=True).status("bitstream, minutes") as status:
        made = board.bitstream(build.project, folder, lambda step: status.update(f"bitstream, minutes: {step}"))
    for file_name, content in made.contents.items():
        with atomic(folder / file_name) as file:
            file.write(content)
    return made.placed


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.build", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--board", metavar="|".join(board_names()), help="the whole system, as a project for this board")
    what.add_argument("--core", action="store_true", help="the bare matcher with its streams, for another design")
    _add_board_options(parser)
    parser.add_argument("--frame-timing", action="store_true", help="with --core: frame timing signals instead of the stream of pixels")
    add_interface_option(parser)
    parser.add_argument("--name", metavar="NAME", help="with --core: of the top module and its file; sub-modules are NAME_and_more, so "
                        f"that several cores live in one design (default: {DEFAULT_NAME})")
    parser.add_argument("--output", type=Path, metavar="DIR", help="default: build/core, or build/ and the board's name")
    add_package_option(parser)
    add_design_options(parser, boards=True)
    add_rig_options(parser)
    options = parser.parse_args(argv)

    board = None if options.board is None else find_board(options.board)
    serial = board.pictures if board and isinstance(board.pictures, Serial) else None
    set_defaults(options, *((serial.width, serial.height, serial.disparities) if serial else ()))
    config = design_config(options)
    if board:
        _check_board(options, board)
    else:
        _check_core(options)
    if options.name is not None and (reason := reserved(options.name)):
        raise UserError(f"--name {options.name!r} cannot name a module: {reason}; choose another one, such as left_eye")
    check_interface(options)
    design, display = _design(options, board, config) if board else (None, None)
    rig = design.rig if design else rig_config(options, False)
    packages = chosen_packages(options, board=bool(board), registers=bool(board) or options.interface in INTERFACES)
    folder = options.output or Path("build") / (board.name if board else "core")
    # Before minutes of work; made only when there is something to be written.
    check_folder(folder)

    with Console(stderr=True).status("writing Verilog"):
        build = (_build_board(design, board, display) if board and design else
                 _build_core(options.name or DEFAULT_NAME, config, options.height, rig, options.frame_timing,
                             options.interface))
    files, matcher = build.files | package_files(packages, build.packed), build.matcher
    needed = round(FRAMES_PER_SECOND * build.frame_clocks(options.width, options.height) / 1e6, 2)
    about = {**build.about, "clock_mhz_for_25_frames": needed, "files": sorted(files)}
    manifest = manifest_of(build.top, matcher, build.ports, options.height, about)
    command = command_line(sys.argv[1:] if argv is None else argv)
    latency = matcher.latency_lines, matcher.latency_clocks
    verilog = {file: text for file, text in files.items() if file.endswith(".v")}
    files |= {file: header(file, project_version(), command, manifest, latency) + text for file, text in verilog.items()}

    making = board if board and board.bitstream and not options.no_bitstream else None
    # Two builds write one after the other, and the second one's files are all that is left; a bitstream takes too long to wait for.
    with output_folder(folder, wait=not making):
        sources = digest(build.files, making.needs.values()) if making else ""
        placed = placed_before(folder, MANIFEST, sources) if making else None
        _write(folder, files, manifest, placed, sources)
        print(f"{folder}: {', '.join(sorted(files))}")
        print(f"Clocks a pixel: {matcher.clocks_per_pixel}; {options.width}x{options.height} at {FRAMES_PER_SECOND} frames/s "
              f"needs {needed} MHz.")
        if rig:
            maps = "the maps of the rig" if rig.rig else "maps that change nothing"
            moved = options.core and rig.row_offset
            order = f"; line y + {rig.row_offset} of the right picture is to be sent as its line y" if moved else ""
            print(f"Both pictures are rectified, {rig.lines} lines are held, with {maps}{order}.")
        if board and design:
            _tell_board(board, design, build, folder)
        if not making:
            return 0
        if placed:
            print(f"{folder / placed.files[0]} is of these sources already.")
        else:
            placed = _make_bitstream(making, build, folder)
            _write(folder, files, manifest, placed, sources)
        print_table(placed.table())
        print("\n".join(placed.told()))
        if missed := placed.missed():
            print(f"hdl.build: {missed}" + ("; nothing was loaded into the board" if options.program else ""), file=sys.stderr)
            return 1
        if options.program and making.loader:
            making.loader.load(folder / placed.files[0])
            print(f"{folder / placed.files[0]} is in the board until power is off.")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.build")


if __name__ == "__main__":
    sys.exit(main())

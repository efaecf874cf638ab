"""Write Verilog, of the matcher alone or of the project for a board: ``python -m hdl.build``."""

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from amaranth.hdl import Value
from amaranth.lib import data
from amaranth.lib.wiring import Component, Flow
from rich.console import Console

from boards.registry import Board, board_names, find_board
from golden.cli import Parser
from golden.config import MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import atomic, check_folder, output_folder, remove_stale
from golden.host.core_registers import WORD_BYTES
from golden.host.registers import register_map
from golden.rig.config import RigConfig
from golden.tables import print_table
from golden.video.bandwidth import Budget, MemoryTiming
from golden.video.formats import DISPLAYS, PAL

from .emit import port_name, verilog_text
from .fit import Fit, remedies
from .header import command_line, header
from .interfaces.choice import add_interface_option, check_interface
from .interfaces.cores import INTERFACES
from .keywords import reserved
from .matcher.framed import FramedMatcher
from .matcher.matcher import Matcher
from .options import add_design_options, add_rig_options, design_config, rig_config
from .packages.core import Core, RegisterSpace
from .packages.registry import add_package_option, chosen_packages, package_files, project_version
from .rectified import PIXEL_ORDER, RectifiedMatcher
from .waivers import verilator_waivers


__all__ = ["main"]


DEFAULT_DISPLAY = "720x576"
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


def _build_board(config: MatcherConfig, board: Board, display_name: str, clock_mhz: float, rig: RigConfig | None) -> _Build:
    display = DISPLAYS[display_name]
    core = board.system(config, display, MemoryTiming.at(round(clock_mhz * 1e6)), rig)
    project = board.project(core, display, config)
    fit = board.fit(project)
    if fit:
        fit.check(remedies(config, rig))
    problems = board.check(project)
    if problems:
        raise RuntimeError(f"the project is not sound: {'; '.join(problems)}")
    about = {
        "device": board.device.name, "display": display_name, "clock_mhz": clock_mhz,
        "pixel_clock_mhz": display.pixel_clock_hz / 1e6, "camera_clock_mhz": PAL.byte_clock_hz / 1e6,
        **board.about, "buffers": core.budget.memory_map.buffers,
        "memory_words_per_second": {"used": round(core.budget.used), "available": round(core.budget.available)},
        "board": board.name, **about_rig(rig),
    }
    if fit:
        about["resources"] = {"estimated": fit.estimated._asdict(), "allowance": fit.allowance._asdict(),
                              "device": fit.device.capacity._asdict()}
    space = RegisterSpace(register_map(config, PAL.height, rig), 2,
                          f"Registers of the system on the board {board.name}: an offset is twice the address on the serial line")
    return _Build(project.name, core.matcher, project.files, project.ports, about, core.budget, space, fit)


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.build", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--board", metavar="|".join(board_names()), help="the whole system, as a project for this board")
    what.add_argument("--core", action="store_true", help="the bare matcher with its streams, for another design")
    parser.add_argument("--display", metavar="|".join(DISPLAYS), help=f"with --board: the monitor's format (default: {DEFAULT_DISPLAY})")
    parser.add_argument("--memory-clock", type=int, metavar="MHZ",
                        help="with --board: clock of the memory, if the board offers several; the matcher has the clock of its controller")
    parser.add_argument("--frame-timing", action="store_true", help="with --core: frame timing signals instead of the stream of pixels")
    add_interface_option(parser)
    parser.add_argument("--name", metavar="NAME", help="with --core: of the top module and its file; sub-modules are NAME_and_more, so "
                        f"that several cores live in one design (default: {DEFAULT_NAME})")
    parser.add_argument("--output", type=Path, metavar="DIR", help="default: build/core, or build/ and the board's name")
    add_package_option(parser)
    add_design_options(parser)
    add_rig_options(parser)
    options = parser.parse_args(argv)

    board = None if options.board is None else find_board(options.board)
    config = design_config(options)
    if options.core and options.display is not None:
        raise UserError("--display is the format of the board's monitor, and --core has no monitor; choose --board, or leave --display out")
    if options.core and options.memory_clock is not None:
        raise UserError("--memory-clock is that of the board's memory, and --core has none; choose --board, or leave --memory-clock out")
    clock_mhz = board.local_clock_mhz(options.memory_clock) if board else 0
    if board and options.name is not None:
        raise UserError("--name is for the bare matcher, and a board's project has a name; choose --core, or leave --name out")
    if options.name is not None and (reason := reserved(options.name)):
        raise UserError(f"--name {options.name!r} cannot name a module: {reason}; choose another one, such as left_eye")
    if board and options.frame_timing:
        raise UserError("--frame-timing is for the bare matcher, and --board has cameras; choose --core, or leave --frame-timing out")
    if board and (options.width, options.height) != (PAL.width, PAL.height):
        raise UserError(f"the cameras of --board send pictures of {PAL.width}x{PAL.height} pixels, not {options.width}x{options.height}; "
                        "leave --width and --height out, or choose --core")
    check_interface(options)
    display = options.display or DEFAULT_DISPLAY
    if display not in DISPLAYS:
        raise UserError(f"there is no display format {display!r}; choose one of: {', '.join(DISPLAYS)}")
    rig = rig_config(options, bool(board))
    packages = chosen_packages(options, board=bool(board), registers=bool(board) or options.interface in INTERFACES)
    folder = options.output or Path("build") / (board.name if board else "core")
    # Before minutes of work; made only when there is something to be written.
    check_folder(folder)

    with Console(stderr=True).status("writing Verilog"):
        build = (_build_board(config, board, display, clock_mhz, rig) if board else
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
    files[MANIFEST] = json.dumps(manifest, indent=2) + "\n"

    # Two builds write one after the other, and the second one's files are all that is left.
    with output_folder(folder, wait=True):
        for file_name, text in files.items():
            if file_name == MANIFEST:
                remove_stale(folder, MANIFEST, ("top", "ports"), files)
            with atomic(folder / file_name) as file:
                file.write(text.encode())
    print(f"{folder}: {', '.join(sorted(files))}")
    print(f"Clocks a pixel: {matcher.clocks_per_pixel}; {options.width}x{options.height} at {FRAMES_PER_SECOND} frames/s "
          f"needs {needed} MHz.")
    if rig:
        maps = "the maps of the rig" if rig.rig else "maps that change nothing"
        moved = f"; line y + {rig.row_offset} of the right picture is to be sent as its line y" if options.core and rig.row_offset else ""
        print(f"Both pictures are rectified, {rig.lines} lines are held, with {maps}{moved}.")
    if board and build.budget:
        print(f"The memory controller gives the matcher {clock_mhz:g} MHz; "
              f"frames wait in {build.budget.buffers} buffers for each camera{', a kept pair in one more' if build.budget.kept else ''}.")
        print_table(build.budget.table())
    if build.fit:
        print_table(build.fit.table())
        print("\n".join(build.fit.told()))
        if warning := build.fit.warning():
            print(f"hdl.build: {warning}", file=sys.stderr)
    if board and "README.md" in files:
        print(f"What to do in {board.toolchain}: {folder / 'README.md'}")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.build")


if __name__ == "__main__":
    sys.exit(main())

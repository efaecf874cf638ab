"""Write Verilog and a Quartus project: ``python -m hdl.build``."""

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from amaranth.hdl import Value
from amaranth.lib import data
from amaranth.lib.wiring import Flow
from rich.console import Console

from boards.cyclone3.check import check_project
from boards.cyclone3.project import MEMORY_CONTROLLER, quartus_project
from golden.cli import Parser
from golden.config import Cost, MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output
from golden.video.bandwidth import MemoryTiming
from golden.video.formats import DISPLAYS, PAL, DisplayFormat

from .emit import verilog_text
from .matcher.framed import FramedMatcher
from .matcher.matcher import Matcher
from .options import BOARDS, add_design_options, design_config
from .verilog import modules
from .video.system import StereoSystem


__all__ = ["main", "stereo_system"]


DEFAULT_DISPLAY = "720x576"
FRAMES_PER_SECOND = 25  # PAL


def ports_of(component):
    """Ports of the emitted module: name to (direction, width in bits)."""
    ports = {} if "clk" in component.signature.members else {"clk": ("input", 1), "rst": ("input", 1)}
    for path, member, value in component.signature.flatten(component):
        ports["__".join(map(str, path))] = ("input" if member.flow is Flow.In else "output", len(Value.cast(value)))
    return ports


def fields_of(component):
    """Where the fields of a payload are: port to field to (lowest bit, highest bit)."""
    return {
        "__".join(map(str, path)): {name: (field.offset, field.offset + field.width - 1) for name, field in value.shape()}
        for path, _, value in component.signature.flatten(component) if isinstance(value, data.View)
    }


def manifest_of(name, matcher, ports, height, arguments):
    """What a machine wants to know of the build."""
    config = matcher.config
    clocks = matcher.clocks_per_pixel
    if config.cost is Cost.FUSED:
        about_cost = {"minimum": config.minimum, "fused": asdict(config.fused), "refinement": asdict(config.refinement),
                      "disparity_scale": config.disparity_scale}
    else:
        about_cost = {"fraction_bits": config.fraction_bits}
    return {
        "top": name,
        "engine": str(config.engine),
        "parameters": {
            "disparities": config.disparities, "cost": str(config.cost), "arithmetic": str(config.arithmetic), **about_cost,
            **dict(zip(("u1", "u2", "u3"), config.weights)), "max_width": config.max_width, "height": height,
        },
        "clocks_per_pixel": clocks,
        "full_rate_width": matcher.full_rate_width,
        "latency_clocks": matcher.latency_lines * max(config.max_width, matcher.full_rate_width) * clocks + matcher.latency_clocks,
        "ports": {port: {"direction": direction, "width": width} for port, (direction, width) in ports.items()},
        **arguments,
    }


def stereo_system(config: MatcherConfig, display: DisplayFormat, timing: MemoryTiming):
    """What goes on the board: :class:`hdl.video.system.StereoSystem`, or what has its ports, a ``matcher`` and a ``budget``."""
    return StereoSystem(config, display, timing=timing)


def _core_files(config, frame_timing):
    """Name, matcher, no budget, files, ports, and what the manifest has of its own."""
    component = FramedMatcher(config) if frame_timing else Matcher(config)
    matcher = component.matcher if frame_timing else component
    files = {"matcher.v": verilog_text(component, name="matcher")}
    return "matcher", matcher, None, files, ports_of(component), {"payloads": fields_of(component)}


def _board_files(config, board, display):
    """The same of a board: a checked Quartus project."""
    name = "stereo"
    core = stereo_system(config, DISPLAYS[display], MemoryTiming(clock_hz=round(board.MEMORY_CLOCK_MHZ * 1e6)))
    files = quartus_project(name, core, DISPLAYS[display], config)
    problems = check_project(name, files, balls=board.BALLS, bank_volts=board.BANK_VOLTS, clock_balls=board.CLOCK_BALLS)
    if problems:
        raise RuntimeError(f"the project is not sound: {'; '.join(problems)}")
    about = {
        "device": board.DEVICE, "display": display, "clock_mhz": board.MEMORY_CLOCK_MHZ,
        "pixel_clock_mhz": DISPLAYS[display].pixel_clock_hz / 1e6, "camera_clock_mhz": PAL.byte_clock_hz / 1e6,
        "memory_controller": MEMORY_CONTROLLER, "buffers": core.budget.memory_map.buffers,
        "memory_words_per_second": {"used": round(core.budget.used), "available": round(core.budget.available)},
    }
    return name, core.matcher, core.budget, files, modules(files[f"{name}.v"])[name].ports, about


def _check_folder(folder: Path) -> None:
    """Raise :class:`UserError` unless files can be written into ``folder``, which may not exist yet."""
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise UserError(f"{existing} is not a folder; choose another --output")
    if not os.access(existing, os.W_OK):
        raise UserError(f"the folder {existing} cannot be written; choose another --output")
    check_output(existing / "manifest.json", [".json"])


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.build", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--board", metavar="|".join(BOARDS), help="the whole system, as a Quartus project for this board")
    what.add_argument("--core", action="store_true", help="the bare matcher with its streams, for a design of your own")
    parser.add_argument("--display", metavar="|".join(DISPLAYS), help=f"with --board: the monitor's format (default: {DEFAULT_DISPLAY})")
    parser.add_argument("--frame-timing", action="store_true", help="with --core: frame timing signals instead of the stream of pixels")
    parser.add_argument("--output", type=Path, metavar="DIR", help="default: build/cyclone3 or build/core")
    add_design_options(parser)
    options = parser.parse_args(argv)

    config = design_config(options)
    if options.core and options.display is not None:
        raise UserError("--display is the format of the board's monitor, and --core has none; choose --board, or leave --display out")
    if options.board and options.frame_timing:
        raise UserError("--frame-timing is for the bare matcher, and --board has cameras; choose --core, or leave --frame-timing out")
    if options.board and (options.width, options.height) != (PAL.width, PAL.height):
        raise UserError(f"the cameras of --board send pictures of {PAL.width}x{PAL.height} pixels, not {options.width}x{options.height}; "
                        "leave --width and --height out, or choose --core")
    display = options.display or DEFAULT_DISPLAY
    if display not in DISPLAYS:
        raise UserError(f"there is no display format {display!r}; choose one of: {', '.join(DISPLAYS)}")
    folder = options.output or Path("build") / (options.board or "core")
    _check_folder(folder)

    with Console(stderr=True).status("writing Verilog"):
        if options.board:
            name, matcher, budget, files, ports, about = _board_files(config, BOARDS[options.board], display)
            about["board"] = options.board
        else:
            name, matcher, budget, files, ports, about = _core_files(config, options.frame_timing)
    needed = round(FRAMES_PER_SECOND * matcher.frame_clocks(options.width, options.height) / 1e6, 2)
    about |= {"clock_mhz_for_25_frames": needed, "files": sorted(files)}
    manifest = manifest_of(name, matcher, ports, options.height, about)
    files["manifest.json"] = json.dumps(manifest, indent=2) + "\n"

    folder.mkdir(parents=True, exist_ok=True)
    for file_name, text in files.items():
        with atomic(folder / file_name) as file:
            file.write(text.encode())
    print(f"{folder}: {', '.join(sorted(files))}")
    print(f"Clocks a pixel: {matcher.clocks_per_pixel}; {options.width}x{options.height} at {FRAMES_PER_SECOND} frames/s "
          f"needs {needed} MHz.")
    if budget:
        print(f"The memory controller gives the matcher {BOARDS[options.board].MEMORY_CLOCK_MHZ} MHz; "
              f"frames wait in {budget.memory_map.buffers} buffers for each camera.")
        Console().print(budget.table())
        print(f"What to do in Quartus: {folder / 'README.md'}")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.build")


if __name__ == "__main__":
    sys.exit(main())

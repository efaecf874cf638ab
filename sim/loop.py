"""A board without a board: ``python -m sim.loop`` simulates the matcher behind a serial line at a port of this machine."""

import contextlib
import functools
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from golden.cli import Parser, add_gateware_options, described, gateware_config
from golden.config import MatcherConfig
from golden.errors import UserError, run_cli

from .kit.loop_port import simulated_port, small_board
from .kit.simulators import SimulationError, require


__all__ = ["main"]


# Pixels of the stores. A pair of 128x96 takes minutes.
_SIZES = {"width": MatcherConfig.WIDTHS, "height": range(1, 1025)}


def _wait(port: str) -> None:
    """Until interrupted."""
    threading.Event().wait()


def _run(wait: Callable[[str], None], argv: Sequence[str] | None) -> int:
    parser = Parser(prog="sim.loop", description="Simulate a board with the matcher behind a serial line. Its port is a pseudo-terminal, "
                    "which sim.run --hardware and hdl.host.console open as they open a board's; Ctrl-C ends it.")
    parser.add_argument("--width", type=int, default=32, metavar="PIXELS", help="of the board's stores (default: %(default)s)")
    parser.add_argument("--height", type=int, default=16, metavar="LINES", help="of the board's stores (default: %(default)s)")
    parser.add_argument("--disparities", type=int, default=8, metavar="N", help="of the board (default: %(default)s)")
    add_gateware_options(parser)
    options = parser.parse_args(argv)
    for name, values in _SIZES.items():
        if getattr(options, name) not in values:
            raise UserError(f"--{name} must be a whole number from {values[0]} to {values[-1]}, not {getattr(options, name)}; "
                            "choose a value in that range")
    config = gateware_config(options, options.disparities, max_width=options.width)
    require("verilator")
    try:
        with tempfile.TemporaryDirectory(prefix="loop-") as folder:
            print("Writing and building the Verilog ...", file=sys.stderr, flush=True)
            with simulated_port(small_board(config, options.height), Path(folder)) as port:
                size = f"{options.width}x{options.height} pixels and {config.labels} disparities"
                print(f"A board of {size}, {described(config)}, is at {port}:")
                print(f"python -m sim.run LEFT RIGHT --hardware {port} --baud 9600 --timeout 5", flush=True)
                with contextlib.suppress(KeyboardInterrupt):    # the usual end
                    wait(port)
    except SimulationError as error:
        print(f"sim.loop: {error}", file=sys.stderr)
        return 1
    return 0


def main(argv: Sequence[str] | None = None, wait: Callable[[str], None] = _wait) -> int:
    """Run the command line; the exit status is the result. ``wait`` is given the port, and the board ends with it."""
    return run_cli(functools.partial(_run, wait), argv, "sim.loop")


if __name__ == "__main__":
    sys.exit(main())

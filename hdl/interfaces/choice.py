"""The option of the command line that chooses the core's interface."""

import argparse

from golden.errors import UserError

from .cores import INTERFACES


__all__ = ["STREAM", "add_interface_option", "check_interface"]


#: The interface without a bus.
STREAM = "stream"


def add_interface_option(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--interface``."""
    parser.add_argument("--interface", default=STREAM, metavar=f"{STREAM}|{'|'.join(INTERFACES)}", help=(
        "with --core: bare streams with the settings as ports; AXI4-Stream with registers behind AXI4-Lite; or Avalon-ST with "
        "Avalon-MM (default: %(default)s)"))


def check_interface(options: argparse.Namespace) -> None:
    """Raise :class:`UserError` if there is no such interface, or not with the other options."""
    name = options.interface
    if name != STREAM and name not in INTERFACES:
        raise UserError(f"there is no interface {name!r}; choose one of: {', '.join([STREAM, *INTERFACES])}")
    if name == STREAM:
        return
    if options.board is not None:
        raise UserError(f"--interface {name} is for the bare matcher, and --board has cameras and a monitor; "
                        "choose --core, or leave --interface out")
    if options.frame_timing:
        raise UserError(f"--interface {name} and --frame-timing are two kinds of input; leave one of the two out")
    if options.rectify:
        raise UserError(f"--rectify has registers that --interface {name} does not; leave --rectify out and rectify in front of the core, "
                        "or choose --interface stream")

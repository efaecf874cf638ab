"""Options that the command lines of the gateware share: the size of the picture and the matcher."""

import argparse
import importlib.util

from golden.cli import add_gateware_options, gateware_config
from golden.config import MatcherConfig
from golden.errors import UserError


__all__ = ["add_design_options", "design_config", "need"]


HEIGHTS = range(1, 4097)


def add_design_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that :func:`design_config` reads."""
    parser.add_argument("--width", type=int, default=720, metavar="PIXELS", help="longest line, 1 to 4096 (default: %(default)s)")
    parser.add_argument("--height", type=int, default=576, metavar="LINES",
                        help="lines of a frame, 1 to 4096, for frame rates only: the matcher takes any (default: %(default)s)")
    parser.add_argument("--disparities", type=int, default=80, metavar="D",
                        help="labels, 2 to 256, sequential engine to 128 (default: %(default)s)")
    add_gateware_options(parser)


def design_config(options: argparse.Namespace) -> MatcherConfig:
    """The matcher that the options describe; :class:`UserError` if there is none."""
    for option, value, limits in (("--width", options.width, MatcherConfig.WIDTHS), ("--height", options.height, HEIGHTS)):
        if value not in limits:
            raise UserError(f"{option} must be a whole number from {limits[0]} to {limits[-1]}, not {value}; choose a value in that range")
    return gateware_config(options, options.disparities, max_width=options.width)


def need(module: str, package: str) -> None:
    """Raise :class:`UserError` unless an optional dependency is installed: ``module`` of the package ``package``."""
    if importlib.util.find_spec(module) is None:
        raise UserError(f"the Python package {package} is not installed; install it with `pip install {package}`")

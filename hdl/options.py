"""Options that the command lines of the gateware share: the size of the picture, the matcher, and what rectifies in front of it."""

import argparse
import importlib.util
from pathlib import Path
from typing import Any

from golden.cli import add_gateware_options, gateware_config
from golden.config import MatcherConfig
from golden.errors import UserError
from golden.rig.config import RigConfig
from golden.rig.files import RIG_NAME, read_rig
from golden.rig.lines import DEFAULT_LINES, LINES
from golden.rig.maps import SIZES


__all__ = ["add_design_options", "add_rig_options", "design_config", "need", "rig_config", "set_defaults"]


HEIGHTS = range(1, 4097)

# PAL's pictures, and the labels of the thesis.
WIDTH, HEIGHT, DISPARITIES = 720, 576, 80


def add_design_options(parser: argparse.ArgumentParser, *, boards: bool = False) -> None:
    """Add the options that :func:`design_config` reads; with ``boards`` :func:`set_defaults` must be called, for boards have their own."""
    def told(default: int) -> dict[str, Any]:
        return {"type": int, "default": None if boards else default}

    own = ", or a board's own" if boards else ""
    parser.add_argument("--width", **told(WIDTH), metavar="PIXELS", help=f"longest line, 1 to 4096 (default: {WIDTH}{own})")
    parser.add_argument("--height", **told(HEIGHT), metavar="LINES", help=(
        f"lines of a frame, 1 to 4096, for frame rates and --rectify: the matcher takes any (default: {HEIGHT}{own})"))
    parser.add_argument("--disparities", **told(DISPARITIES), metavar="D",
                        help=f"labels, 2 to 256, sequential engine to 128 (default: {DISPARITIES}{own})")
    add_gateware_options(parser)


def set_defaults(options: argparse.Namespace, width: int = WIDTH, height: int = HEIGHT, disparities: int = DISPARITIES) -> None:
    """Set what was not chosen."""
    for name, default in (("width", width), ("height", height), ("disparities", disparities)):
        if getattr(options, name) is None:
            setattr(options, name, default)


def design_config(options: argparse.Namespace) -> MatcherConfig:
    """The matcher that the options describe; :class:`UserError` if there is none."""
    for option, value, limits in (("--width", options.width, MatcherConfig.WIDTHS), ("--height", options.height, HEIGHTS)):
        if value not in limits:
            raise UserError(f"{option} must be a whole number from {limits[0]} to {limits[-1]}, not {value}; choose a value in that range")
    return gateware_config(options, options.disparities, max_width=options.width)


def add_rig_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that :func:`rig_config` reads."""
    parser.add_argument("--rectify", action=argparse.BooleanOptionalAction, default=None, help=(
        "rectification of both pictures and balance of brightness in front of the matcher (default: with --board)"))
    parser.add_argument("--rectify-lines", type=int, metavar="N", help=(
        f"that each rectifier holds, {', '.join(map(str, LINES))} (default: {DEFAULT_LINES})"))
    parser.add_argument("--rig", type=Path, metavar="DIR", help=(
        f"folder of golden calibrate, or its {RIG_NAME}: the maps after configuration (default: those that change nothing)"))


def rig_config(options: argparse.Namespace, board: bool) -> RigConfig | None:
    """Rectification and balance that the options describe, ``None`` if there are none; :class:`UserError` if the options contradict.

    Parameters
    ----------
    options : Namespace
        With ``rectify``, ``rectify_lines``, ``rig``, and the pictures' ``width`` and ``height``.
    board : bool
        Whether a board is built, which rectifies by default, or the bare matcher, which does not.
    """
    if board and options.rectify:
        raise UserError("--rectify is what --board does by default; leave it out, or choose --core")
    if not board and options.rectify is False:
        raise UserError("--no-rectify is what --core does by default; leave it out, or choose --board")
    if not (board if options.rectify is None else options.rectify):
        for option, value in (("--rig", options.rig), ("--rectify-lines", options.rectify_lines)):
            if value is not None:
                remedy = "leave one of the two out" if board else f"add --rectify, or leave {option} out"
                raise UserError(f"{option} {value} is for rectification, and {'--no-rectify' if board else '--core'} builds none; {remedy}")
        return None
    lines = DEFAULT_LINES if options.rectify_lines is None else options.rectify_lines
    if lines not in LINES:
        raise UserError(f"--rectify-lines must be one of {', '.join(map(str, LINES))}, not {lines}; choose one of these")
    for option, value in (("--width", options.width), ("--height", options.height)):
        if value not in SIZES:
            raise UserError(f"{option} must be from {SIZES[0]} to {SIZES[-1]} with --rectify, not {value}; choose a value in that range")
    if options.rig is None:
        return RigConfig(lines)
    rig = read_rig(options.rig)
    if rig.size != (options.width, options.height):
        size, remedy = "x".join(map(str, rig.size)), "" if board else f", or choose --width {rig.size[0]} --height {rig.size[1]}"
        raise UserError(f"{options.rig} is a rig for pictures of {size} pixels, and the cameras send {options.width}x{options.height}; "
                        f"calibrate at this size{remedy}")
    try:
        return RigConfig(lines, rig)
    except ValueError as error:
        raise UserError(f"{options.rig}: {error}") from None


def need(module: str, package: str) -> None:
    """Raise :class:`UserError` unless an optional dependency is installed: ``module`` of the package ``package``."""
    if importlib.util.find_spec(module) is None:
        raise UserError(f"the Python package {package} is not installed; install it with `pip install {package}`")

"""What the command lines share: parser, matcher options, console and progress on stderr."""

import argparse
import dataclasses
from typing import Any, NoReturn

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from .config import Arithmetic, Engine, MatcherConfig
from .errors import UserError


__all__ = ["Parser", "add_gateware_options", "add_matcher_options", "gateware_config", "matcher_config", "progress"]


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are :class:`UserError`, so that bad arguments end like any other bad input.

    Options are not abbreviated: a script that says ``--disp`` must not change its meaning when an option is added.
    """
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs.setdefault("allow_abbrev", False)
        super().__init__(*args, **kwargs)

    def error(self, message: str) -> NoReturn:
        raise UserError(f"{message}; see {self.prog} --help")


def add_matcher_options(parser: argparse.ArgumentParser, default: Arithmetic | None = Arithmetic.THESIS,
                        otherwise: str = "all three") -> None:
    """Add ``--arithmetic --fraction-bits --u1 --u2 --u3``; with ``default`` ``None`` no arithmetic means ``otherwise``."""
    weights = MatcherConfig.u1, MatcherConfig.u2, MatcherConfig.u3
    parser.add_argument("--arithmetic", type=Arithmetic, choices=list(Arithmetic), default=default, metavar="float|thesis|linear",
                        help=f"number formats (default: {default or otherwise})")
    parser.add_argument("--fraction-bits", type=int, default=MatcherConfig.fraction_bits, metavar="Q",
                        help="fraction bits of the slopes, 0 to 4; linear arithmetic only (default: %(default)s)")
    for name, weight, neighbour in zip(("--u1", "--u2", "--u3"), weights, ("left", "upper", "lower"), strict=True):
        parser.add_argument(name, type=int, default=weight, metavar="U",
                            help=f"weight of the {neighbour} neighbour, grey levels a pixel of disparity, 0 to 63 (default: %(default)s)")


def matcher_config(options: argparse.Namespace, disparities: int, arithmetic: Arithmetic | None = None,
                   max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_matcher_options` ask for; :class:`UserError` if it cannot be.

    Examples
    --------
    >>> parser = Parser()
    >>> add_matcher_options(parser)
    >>> matcher_config(parser.parse_args(["--u3", "7"]), 16).weights
    (15, 10, 7)
    """
    try:
        return MatcherConfig(
            disparities=disparities, arithmetic=arithmetic or options.arithmetic, fraction_bits=options.fraction_bits,
            u1=options.u1, u2=options.u2, u3=options.u3, max_width=max_width)
    except ValueError as error:  # it names the parameter, its limits and the value: the option carries the same name
        raise UserError(f"--{str(error).replace('_', '-', 1)}; choose a value in that range") from None


def add_gateware_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--engine`` and the options of :func:`add_matcher_options`, for :func:`gateware_config`."""
    parser.add_argument("--engine", type=Engine, choices=list(Engine), metavar="streaming|sequential",
                        help="one pixel a cycle, linear arithmetic; or as the thesis does (default: streaming, unless --arithmetic thesis)")
    add_matcher_options(parser, default=None, otherwise="linear, with --engine sequential thesis")


def gateware_config(options: argparse.Namespace, disparities: int, max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_gateware_options` ask for; :class:`UserError` if there is no such gateware.

    Examples
    --------
    >>> parser = Parser()
    >>> add_gateware_options(parser)
    >>> [str(gateware_config(parser.parse_args(words), 16).engine) for words in ([], ["--arithmetic", "thesis"])]
    ['streaming', 'sequential']
    """
    if options.arithmetic is Arithmetic.FLOAT:
        raise UserError("--arithmetic float has no gateware; choose thesis or linear, or use python -m golden match")
    arithmetic = options.arithmetic or (Arithmetic.THESIS if options.engine is Engine.SEQUENTIAL else Arithmetic.LINEAR)
    engine = options.engine or (Engine.SEQUENTIAL if arithmetic is Arithmetic.THESIS else Engine.STREAMING)
    if engine is Engine.STREAMING and arithmetic is Arithmetic.THESIS:
        raise UserError("--arithmetic thesis cannot be computed by the streaming engine; choose --engine sequential or --arithmetic linear")
    config = matcher_config(options, disparities, arithmetic, max_width=max_width)
    if engine is Engine.SEQUENTIAL and disparities not in MatcherConfig.SEQUENTIAL_DISPARITIES:
        limits = MatcherConfig.SEQUENTIAL_DISPARITIES
        raise UserError(f"--disparities must be a whole number from {limits[0]} to {limits[-1]} with the sequential engine, "
                        f"not {disparities}; choose a value in that range")
    return dataclasses.replace(config, engine=engine)


def progress() -> Progress:
    """A progress bar on stderr; it leaves nothing behind, and is silent where stderr is not a terminal."""
    console = Console(stderr=True)
    return Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                    console=console, transient=True, disable=not console.is_terminal)

"""What the command lines share: parser, matcher options, console and progress on stderr."""

import argparse
import contextlib
import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from .config import FUSED_1, METHODS, Arithmetic, Engine, Fused, MatcherConfig, OnePass, Refinement, changed
from .errors import UserError
from .matcher.parameters import read_parameters


__all__ = ["STAGES", "Parser", "add_gateware_options", "add_matcher_options", "add_method_options", "add_minimum_option",
           "check_disparities", "gateware_config", "matcher_config", "method_config", "progress"]


# Options of the refinement that can be switched each by itself, and what they switch.
STAGES = Refinement.SWITCHES

WEIGHTS = {"u1": "left", "u2": "upper", "u3": "lower"}  # and the neighbour of each


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
                        otherwise: str = "all three", fused: bool = False) -> None:
    """Add ``--arithmetic --fraction-bits --u1 --u2 --u3``; with ``default`` ``None`` no arithmetic means ``otherwise``.

    Numbers that are not given are ``None``: their default depends on the cost. ``fused`` says that ``--cost fused`` is an option too.
    """
    parser.add_argument("--arithmetic", type=Arithmetic, choices=list(Arithmetic), default=default, metavar="float|thesis|linear",
                        help=f"number formats (default: {default or otherwise})")
    parser.add_argument("--fraction-bits", type=int, metavar="Q",
                        help=f"fraction bits of the slopes, 0 to 4; linear arithmetic only (default: {OnePass.fraction_bits})")
    for name, neighbour in WEIGHTS.items():
        default_of_fused = f"; with --cost fused {getattr(FUSED_1.weights, name)}, in eighths of its cost" if fused else ""
        parser.add_argument(f"--{name}", type=int, metavar="U", help=(
            f"weight of the {neighbour} neighbour, grey levels a pixel of disparity, 0 to 63 "
            f"(default: {getattr(OnePass.weights, name)}{default_of_fused})"))


def matcher_config(options: argparse.Namespace, disparities: int, arithmetic: Arithmetic | None = None,
                   max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_matcher_options` ask for; :class:`UserError` if it cannot be.

    Examples
    --------
    >>> parser = Parser()
    >>> add_matcher_options(parser)
    >>> matcher_config(parser.parse_args(["--u3", "7"]), 16).method.weights
    Weights(u1=15, u2=10, u3=7)
    """
    with _parameters_are_options():
        method = changed(OnePass(arithmetic or options.arithmetic), **_given(options, "fraction_bits", *WEIGHTS))
        return _sized(options, disparities, max_width, method)


def check_disparities(disparities: int) -> None:
    """:class:`UserError` unless that many labels are possible; the option is named ``--disparities`` everywhere."""
    limits = MatcherConfig.LABELS
    if disparities not in limits:
        raise UserError(f"--disparities must be a whole number from {limits[0]} to {limits[-1]}, not {disparities}; "
                        "choose a value in that range")


def _sized(options: argparse.Namespace, disparities: int, max_width: int, method: OnePass | Fused) -> MatcherConfig:
    """A configuration of that size; the number of labels is the option ``--disparities``."""
    check_disparities(disparities)
    return MatcherConfig(disparities, max_width, getattr(options, "minimum", 0), method=method)


@contextlib.contextmanager
def _parameters_are_options() -> Iterator[None]:
    """Turn the complaint of a configuration into :class:`UserError`: it names a parameter, and the option carries the same name."""
    try:
        yield
    except ValueError as error:
        raise UserError(f"--{str(error).replace('_', '-', 1)}; choose a value in that range") from None


def _given(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Those of the options that are given."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def add_method_options(parser: argparse.ArgumentParser, cost: str = OnePass.name, thesis: str = str(Arithmetic.THESIS)) -> None:
    """Add ``--cost``, the switches of the refinement and the options of :func:`add_matcher_options`, for :func:`method_config`.

    Parameters
    ----------
    cost : str
        Default of ``--cost``.
    thesis : str
        What help says of the arithmetic of the cost ``THESIS`` where none is given.
    """
    parser.add_argument("--cost", choices=list(METHODS), default=cost, metavar="thesis|fused", help=(
        "matching cost of the thesis; or fused with a census, summed over a support and refined after the rule (default: %(default)s)"))
    parser.add_argument("--parameters", type=Path, metavar="fused-1|fused-2|fused-3|FILE", help=(
        "parameters of the fused cost; fused-2 counts the lines above and below too, fused-3 makes the least gateware; or a file of "
        "golden tune (default: fused-1)"))
    parser.add_argument("--refine", action=argparse.BooleanOptionalAction, help="all stages of the refinement or none (default: all)")
    for name, what in STAGES.items():
        parser.add_argument(f"--{name}", action=argparse.BooleanOptionalAction, help=f"{what}, whatever --refine says of the others")
    parser.add_argument("--sub-pixel", action="store_true", help="three fraction bits of disparity")
    add_matcher_options(parser, default=None, otherwise=f"{thesis}; with --cost fused linear", fused=True)


def add_minimum_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--minimum``, the least disparity."""
    limits = MatcherConfig.MINIMUMS
    parser.add_argument("--minimum", type=int, default=MatcherConfig.minimum, metavar="M", help=(
        f"least disparity, pixels, {limits[0]} to {limits[-1]}: N disparities are M .. M + N - 1 (default: %(default)s)"))


def method_config(options: argparse.Namespace, disparities: int, arithmetic: Arithmetic = Arithmetic.THESIS,
                  max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_method_options` ask for; :class:`UserError` if it cannot be.

    Parameters
    ----------
    arithmetic : Arithmetic
        Of the cost ``THESIS`` where none is given.

    Examples
    --------
    >>> parser = Parser()
    >>> add_method_options(parser)
    >>> config = method_config(parser.parse_args(["--cost", "fused", "--no-fill", "--u3", "7"]), 16)
    >>> config.method.weights, config.method.refinement.fill
    (Weights(u1=17, u2=30, u3=7), False)
    """
    if options.cost == OnePass.name:
        switches = {name: value for name in ("refine", *STAGES) if (value := getattr(options, name)) is not None}
        given = [name if value else f"no-{name}" for name, value in switches.items()] + ["sub-pixel"] * options.sub_pixel
        given += ["parameters"] * (options.parameters is not None)
        if given:
            raise UserError(f"--{given[0]} belongs to the cost fused; choose --cost fused or leave it out")
        return matcher_config(options, disparities, options.arithmetic or arithmetic, max_width=max_width)

    if options.arithmetic not in (None, Arithmetic.LINEAR):
        raise UserError(f"--arithmetic {options.arithmetic} cannot make the fused cost; choose --arithmetic linear or --cost thesis")
    if options.fraction_bits is not None:
        raise UserError(f"--fraction-bits {options.fraction_bits} belongs to the cost thesis; leave it out or choose --cost thesis")
    stages = {name: options.refine is not False if getattr(options, name) is None else getattr(options, name) for name in STAGES}
    if options.fill and not stages["check"]:
        raise UserError("--fill has nothing to do without the left-right check; add --check or leave --fill out")
    params = read_parameters(options.parameters) if options.parameters else FUSED_1
    with _parameters_are_options():
        method = changed(params, **_given(options, *WEIGHTS), **stages, sub_pixel=options.sub_pixel)
        return _sized(options, disparities, max_width, method)


def add_gateware_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--engine``, ``--minimum`` and the options of :func:`add_method_options`, for :func:`gateware_config`."""
    parser.add_argument("--engine", type=Engine, choices=list(Engine), metavar="streaming|sequential", help=(
        "one pixel a cycle, linear arithmetic; or as the thesis does, its cost only (default: streaming, unless --arithmetic thesis)"))
    add_minimum_option(parser)
    add_method_options(parser, thesis="linear, with --engine sequential thesis")


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
        others = "linear" if options.cost == Fused.name else "thesis or linear"
        raise UserError(f"--arithmetic float has no gateware; choose {others}, or use python -m golden match")
    if options.cost == Fused.name and options.engine is Engine.SEQUENTIAL:
        raise UserError("--engine sequential has no cost fused; choose --engine streaming or --cost thesis")
    if options.cost == OnePass.name and options.minimum:
        raise UserError(f"--minimum {options.minimum} belongs to the cost fused; choose --cost fused or leave it out")
    arithmetic = options.arithmetic or (Arithmetic.THESIS if options.engine is Engine.SEQUENTIAL else Arithmetic.LINEAR)
    engine = options.engine or (Engine.SEQUENTIAL if arithmetic is Arithmetic.THESIS else Engine.STREAMING)
    if engine is Engine.STREAMING and arithmetic is Arithmetic.THESIS and options.cost == OnePass.name:
        raise UserError("--arithmetic thesis cannot be computed by the streaming engine; choose --engine sequential or --arithmetic linear")
    config = method_config(options, disparities, arithmetic, max_width)
    if engine is Engine.SEQUENTIAL and disparities not in MatcherConfig.SEQUENTIAL_LABELS:
        limits = MatcherConfig.SEQUENTIAL_LABELS
        raise UserError(f"--disparities must be a whole number from {limits[0]} to {limits[-1]} with the sequential engine, "
                        f"not {disparities}; choose a value in that range")
    return dataclasses.replace(config, engine=engine)


def progress() -> Progress:
    """A progress bar on stderr; it leaves nothing behind, and is silent where stderr is not a terminal."""
    console = Console(stderr=True)
    return Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                    console=console, transient=True, disable=not console.is_terminal)

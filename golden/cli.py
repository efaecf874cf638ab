"""Shared by the command lines: parser, options of a matcher and of its method, progress on stderr."""

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


# Stages of the refinement, each of which has an option, and their descriptions.
STAGES = Refinement.SWITCHES

WEIGHTS = {"u1": "left", "u2": "upper", "u3": "lower"}  # and the neighbour of each


class Parser(argparse.ArgumentParser):
    """A parser that raises :class:`UserError`, so that bad arguments end as all bad input does.

    Options cannot be abbreviated: a script with ``--disp`` would change its meaning when an option is added.
    """
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs.setdefault("allow_abbrev", False)
        super().__init__(*args, **kwargs)

    def error(self, message: str) -> NoReturn:
        raise UserError(f"{message}; see {self.prog} --help")


def add_matcher_options(parser: argparse.ArgumentParser, default: Arithmetic | None = Arithmetic.THESIS,
                        otherwise: str = "all three", fused: bool = False) -> None:
    """Add ``--arithmetic --fraction-bits --u1 --u2 --u3``.

    An option that is not given is ``None``: its default depends on the method.

    Parameters
    ----------
    default : Arithmetic or None
        Default of ``--arithmetic``.
    otherwise : str
        Its description in the help, if ``default`` is ``None``.
    fused : bool
        Whether ``--cost fused`` is an option too; the help then names the weights of both methods.
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
    """The configuration that the options of :func:`add_matcher_options` describe; :class:`UserError` if it is impossible.

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
    """Turn the :class:`ValueError` of a method, which begins with a parameter, into the :class:`UserError` of the option of that name."""
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
        The default arithmetic of the thesis's method, as the help describes it.
    """
    parser.add_argument("--cost", choices=list(METHODS), default=cost, metavar="thesis|fused", help=(
        "the thesis's matching cost; or that fused with a census, summed over a support, with refined disparities (default: %(default)s)"))
    parser.add_argument("--parameters", type=Path, metavar="fused-1|fused-2|fused-3|FILE", help=(
        "parameters of the fused cost; fused-2 adds the costs of the lines above and below, fused-3 needs the fewest resources; or a file "
        "that golden tune wrote (default: fused-1)"))
    parser.add_argument("--refine", action=argparse.BooleanOptionalAction, help="all stages of the refinement or none (default: all)")
    for name, what in STAGES.items():
        parser.add_argument(f"--{name}", action=argparse.BooleanOptionalAction, help=f"{what}; overrides --refine")
    parser.add_argument("--sub-pixel", action="store_true", help="disparities with three fraction bits")
    add_matcher_options(parser, default=None, otherwise=f"{thesis}; with --cost fused linear", fused=True)


def add_minimum_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--minimum``, the least disparity."""
    limits = MatcherConfig.MINIMUMS
    parser.add_argument("--minimum", type=int, default=MatcherConfig.minimum, metavar="M", help=(
        f"least disparity, pixels, {limits[0]} to {limits[-1]}: N disparities are M .. M + N - 1 (default: %(default)s)"))


def method_config(options: argparse.Namespace, disparities: int, arithmetic: Arithmetic = Arithmetic.THESIS,
                  max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_method_options` describe; :class:`UserError` if it is impossible.

    Parameters
    ----------
    arithmetic : Arithmetic
        Default of the thesis's method.

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
        raise UserError(f"--arithmetic {options.arithmetic} cannot compute the fused cost; choose --arithmetic linear or --cost thesis")
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
        "a pixel a cycle, in linear arithmetic; or the thesis's, for its cost only (default: streaming, unless --arithmetic thesis)"))
    add_minimum_option(parser)
    add_method_options(parser, thesis="linear, with --engine sequential thesis")


def gateware_config(options: argparse.Namespace, disparities: int, max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_gateware_options` describe; :class:`UserError` if it has no gateware.

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
    """A progress bar on stderr that is removed at its end; disabled unless stderr is a terminal."""
    console = Console(stderr=True)
    return Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                    console=console, transient=True, disable=not console.is_terminal)

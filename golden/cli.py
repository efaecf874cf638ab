"""Shared by the command lines: parser, options of a matcher and of its method, progress on stderr."""

import argparse
import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from .config import METHODS, Arithmetic, Engine, MatcherConfig, Method, OnePass, RecursiveCost, Weights, changed, parameters_of
from .errors import UserError
from .matcher.parameters import NAMED, default_parameters, read_parameters


__all__ = ["Parser", "add_gateware_options", "add_method_options", "add_minimum_option", "belongs", "check_disparities", "described",
           "either", "gateware_config", "method_config", "methods_with", "progress", "refines_by_default"]


# Parameters that have options of their own; a method without one refuses it.
NUMBERS = ("sub_pixel", "fraction_bits", "census_threshold", "soft_multipliers", *Weights._fields)


class Parser(argparse.ArgumentParser):
    """A parser that raises :class:`UserError`, so that bad arguments end as all bad input does.

    Options cannot be abbreviated: a script with ``--disp`` would change its meaning when an option is added.
    """
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs.setdefault("allow_abbrev", False)
        super().__init__(*args, **kwargs)

    def error(self, message: str) -> NoReturn:
        raise UserError(f"{message}; see {self.prog} --help")


class _Renamed(argparse.Action):
    """An option that has another name now: refused with that name, whatever its value."""
    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: str | Sequence[Any] | None,
                 option_string: str | None = None) -> NoReturn:
        value = values if values in METHODS else "|".join(METHODS)
        raise UserError(f"{option_string} is now --method; write --method {value}")


def methods_with(has: Callable[[Method], bool]) -> list[str]:
    """Names of the methods of which, with their default parameters, ``has`` is true."""
    return [name for name, kind in METHODS.items() if has(kind())]


def either(names: Sequence[str]) -> str:
    """Names to choose from, in words.

    Examples
    --------
    >>> either(["one"]), either(["one", "two", "three"])
    ('one', 'one, two or three')
    """
    return " or ".join([*([", ".join(names[:-1])] if names[1:] else []), names[-1]])


def belongs(option: str, methods: Sequence[str]) -> UserError:
    """What to say of an option, with its value if it has one, that belongs to these methods, and is given with another one.

    Examples
    --------
    >>> print(belongs("--sub-pixel", ["fused"]))
    --sub-pixel belongs to the method fused; choose --method fused or leave it out
    """
    choice = either(methods)
    return UserError(f"{option} belongs to the method {choice}; choose --method {choice} or leave it out")


def described(config: MatcherConfig) -> str:
    """Method and arithmetic in words, for reports.

    Examples
    --------
    >>> described(MatcherConfig())
    'method thesis, thesis arithmetic'
    """
    return f"method {config.method.name}, {config.method.arithmetic} arithmetic"


def check_disparities(disparities: int) -> None:
    """:class:`UserError` unless that many labels are possible; the option is named ``--disparities`` everywhere."""
    limits = MatcherConfig.LABELS
    if disparities not in limits:
        raise UserError(f"--disparities must be a whole number from {limits[0]} to {limits[-1]}, not {disparities}; "
                        "choose a value in that range")


@contextlib.contextmanager
def _parameters_are_options() -> Iterator[None]:
    """Turn the :class:`ValueError` of a method, which begins with a parameter, into the :class:`UserError` of the option of that name."""
    try:
        yield
    except ValueError as error:
        raise UserError(f"--{str(error).replace('_', '-', 1)}; choose a value in that range") from None


def _switches() -> dict[str, str]:
    """The switches of all methods, and what each of them switches."""
    return {name: what for kind in METHODS.values() for name, what in kind.SWITCHES.items()}


def _add_weights(parser: argparse.ArgumentParser) -> None:
    """Add an option for each weight that a method has."""
    settings = {name: kind().settings(MatcherConfig.minimum) for name, kind in METHODS.items()}
    for weight in Weights._fields:
        having = {name: each[weight] for name, each in settings.items() if weight in each}
        one = next(iter(having.values()))
        defaults = ", ".join(f"{name} {each.default} {each.unit}" for name, each in having.items())
        parser.add_argument(f"--{weight}", type=int, metavar="U", help=(
            f"{one.description}, {one.minimum} to {one.maximum} (default: {defaults})"))


def add_method_options(parser: argparse.ArgumentParser, method: str = OnePass.name, thesis: str = str(Arithmetic.THESIS)) -> None:
    """Add ``--method`` and the options of all methods, for :func:`method_config`.

    An option that is not given is ``None``: its default depends on the method.

    Parameters
    ----------
    method : str
        Default of ``--method``.
    thesis : str
        The default arithmetic of the thesis's method, as the help describes it.
    """
    names, sets = "|".join(METHODS), [name for sets in NAMED.values() for name in sets]
    about = "; ".join(f"{name}: {kind.ABOUT}" for name, kind in METHODS.items())
    parser.add_argument("--method", choices=list(METHODS), default=method, metavar=names, help=f"{about} (default: %(default)s)")
    parser.add_argument("--cost", nargs="?", action=_Renamed, default=argparse.SUPPRESS, help=argparse.SUPPRESS)
    parser.add_argument("--parameters", type=Path, metavar="|".join([*sets, "FILE"]), help=(
        "a set of parameters of the method, see docs/tuning.md, or a file that golden tune wrote "
        f"(default: {', '.join(next(iter(each)) for each in NAMED.values())})"))
    parser.add_argument("--refine", action=argparse.BooleanOptionalAction, help="all stages of the refinement or none (default: all)")
    for name, what in _switches().items():
        parser.add_argument(f"--{name}", action=argparse.BooleanOptionalAction, help=f"{what}; overrides --refine")
    parser.add_argument("--sub-pixel", action="store_const", const=True, help="disparities with three fraction bits")
    fixed = ", ".join(f"{name} {kind().arithmetic}" for name, kind in METHODS.items() if "arithmetic" not in parameters_of(kind()))
    parser.add_argument("--arithmetic", type=Arithmetic, choices=list(Arithmetic), metavar="float|thesis|linear",
                        help=f"number formats of the thesis's method (default: {thesis}); the others have one each: {fixed}")
    parser.add_argument("--fraction-bits", type=int, metavar="Q",
                        help=f"fraction bits of the slopes, 0 to 4; linear arithmetic only (default: {OnePass.fraction_bits})")
    limits = RecursiveCost.LIMITS["census_threshold"]
    parser.add_argument("--census-threshold", type=int, metavar="T", help=(
        f"difference of grey levels that the census of the method recursive does not see, {limits[0]} to {limits[-1]}; "
        f"1 for cameras, whose noise it is, see docs/tuning.md (default: {RecursiveCost.census_threshold})"))
    _add_weights(parser)


def add_minimum_option(parser: argparse.ArgumentParser) -> None:
    """Add ``--minimum``, the least disparity."""
    limits = MatcherConfig.MINIMUMS
    parser.add_argument("--minimum", type=int, default=MatcherConfig.minimum, metavar="M", help=(
        f"least disparity, pixels, {limits[0]} to {limits[-1]}: N disparities are M .. M + N - 1 (default: %(default)s)"))


def refines_by_default(options: argparse.Namespace) -> bool:
    """Whether neither ``--refine`` nor a switch is given."""
    return all(getattr(options, name) is None for name in ("refine", *_switches()))


def _check_owners(options: argparse.Namespace) -> None:
    """:class:`UserError` if an option is given that belongs to other methods than the one that is chosen."""
    switches = _switches()
    owners = {
        "refine": methods_with(lambda method: bool(method.SWITCHES)), "parameters": list(NAMED),
        **{name: methods_with(lambda method, name=name: name in method.SWITCHES) for name in switches},  # type: ignore[misc]
        **{name: methods_with(lambda method, name=name: name in parameters_of(method))  # type: ignore[misc]
           for name in NUMBERS},
    }
    for name, methods in owners.items():
        value = getattr(options, name, None)    # some options are the gateware's only
        if value is not None and options.method not in methods:
            option = name.replace("_", "-")
            raise belongs(f"--no-{option}" if value is False else f"--{option}" if value is True else f"--{option} {value}", methods)


def method_config(options: argparse.Namespace, disparities: int, arithmetic: Arithmetic = Arithmetic.THESIS,
                  max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_method_options` describe; :class:`UserError` if it is impossible.

    Parameters
    ----------
    arithmetic : Arithmetic
        Default of a method that has a choice.

    Examples
    --------
    >>> parser = Parser()
    >>> add_method_options(parser)
    >>> config = method_config(parser.parse_args(["--method", "fused", "--no-fill", "--u3", "7"]), 16)
    >>> config.method.weights, config.method.refinement.fill
    (Weights(u1=17, u2=30, u3=7), False)
    """
    _check_owners(options)
    method = read_parameters(options.parameters, options.method) if options.parameters else default_parameters(options.method)
    values = {name: value for name in NUMBERS if (value := getattr(options, name, None)) is not None}
    if "arithmetic" in parameters_of(method):
        values["arithmetic"] = options.arithmetic or arithmetic
    elif options.arithmetic not in (None, method.arithmetic):
        others = either(methods_with(lambda other: "arithmetic" in parameters_of(other)))
        raise UserError(f"--arithmetic {options.arithmetic} cannot compute the method {method.name}; "
                        f"choose --arithmetic {method.arithmetic} or --method {others}")
    for name in method.SWITCHES:
        values[name] = options.refine is not False if getattr(options, name) is None else getattr(options, name)
    if options.fill and not values.get("check", True):
        raise UserError("--fill has nothing to do without the left-right check; add --check or leave --fill out")
    check_disparities(disparities)
    with _parameters_are_options():
        return MatcherConfig(disparities, max_width, getattr(options, "minimum", 0), method=changed(method, **values))


def add_gateware_options(parser: argparse.ArgumentParser) -> None:
    """Add ``--engine``, ``--minimum`` and the options of :func:`add_method_options`, for :func:`gateware_config`."""
    parser.add_argument("--engine", type=Engine, choices=list(Engine), metavar="streaming|sequential", help=(
        "a pixel a cycle, in linear arithmetic; or the thesis's, for its method only (default: streaming, unless --arithmetic thesis)"))
    add_minimum_option(parser)
    add_method_options(parser, thesis="linear, with --engine sequential thesis")
    parser.add_argument("--soft-multipliers", action="store_const", const=True, help=(
        "the means of the method recursive are multiplied in logic (default: in the multipliers of the device)"))


def gateware_config(options: argparse.Namespace, disparities: int, max_width: int = MatcherConfig.max_width) -> MatcherConfig:
    """The configuration that the options of :func:`add_gateware_options` describe; :class:`UserError` if it has no gateware.

    Examples
    --------
    >>> parser = Parser()
    >>> add_gateware_options(parser)
    >>> [str(gateware_config(parser.parse_args(words), 16).engine) for words in ([], ["--arithmetic", "thesis"])]
    ['streaming', 'sequential']
    """
    named = METHODS[options.method]()
    chooses = "arithmetic" in parameters_of(named)
    if options.arithmetic is Arithmetic.FLOAT:
        others = "thesis or linear" if chooses else named.arithmetic
        raise UserError(f"--arithmetic float has no gateware; choose {others}, or use python -m golden match")
    config = method_config(options, disparities, Arithmetic.THESIS if options.engine is Engine.SEQUENTIAL else Arithmetic.LINEAR, max_width)
    engines = config.method.engines
    engine = options.engine or (Engine.STREAMING if Engine.STREAMING in engines else engines[0])
    if engine not in engines:
        if chooses:
            raise UserError(f"--arithmetic {config.method.arithmetic} cannot be computed by the {engine} engine; "
                            f"choose --engine {' or '.join(engines)} or --arithmetic linear")
        others = either(methods_with(lambda method: engine in method.engines))
        raise UserError(f"--engine {engine} has no method {named.name}; choose --engine {' or '.join(engines)} or --method {others}")
    if options.minimum and "minimum" not in config.settings:
        raise belongs(f"--minimum {options.minimum}", methods_with(lambda method: "minimum" in method.settings(0)))
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

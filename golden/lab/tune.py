"""`python -m golden tune`: search for better parameters of a method."""

import argparse
import itertools
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from ..cli import Parser, progress
from ..config import FUSED_1, Fused, MatcherConfig, Recursive, changed, value_of
from ..errors import UserError, run_cli
from ..files import check_output
from ..matcher.parameters import NAMED, PARAMETER_SUFFIX, NamedMethod, read_parameters, write_parameters
from ..pictures.dataset import StereoPair, motorcycle
from ..pictures.scenes import layers
from ..pictures.sets import sets_in
from ..tables import print_table
from .evaluate import average, evaluate
from .workers import Run, add_worker_options, check_installed, workers


__all__ = ["SPACES", "main", "objective", "search"]


#: Parameters of a method that are searched, and their ranges; a further method adds a row. Factor, shift and tolerance are fixed, so the
#: cost keeps its bits and the gateware its size.
SPACES: dict[str, dict[str, range]] = {
    Fused.name: {
        "truncation": range(40, 401), "census_weight": range(0, 101), "cost_outside": range(1, 81),
        "census_rows": range(3, 8, 2), "census_columns": range(3, 10, 2), "arm_threshold": range(3, 31), "reach": range(4, 32),
        "u1": range(1, 64), "u2": range(1, 64), "u3": range(1, 64), "median_size": range(3, 6, 2),
        "vertical_lines": range(2), "vertical_threshold": range(3, 61),
    },
    Recursive.name: {
        "truncation": range(40, 401), "census_weight": range(0, 101), "cost_outside": range(1, 16), "lower_threshold": range(3, 61),
        "near_threshold": range(2, 31), "far_threshold": range(1, 21), "step_threshold": range(2, 31), "far_step": range(2, 17),
        "reach": range(4, 32), "spread_step": range(2, 33), "spread_jump": range(20, 128), "gate_numerator": range(50, 1001),
        "gate_offset": range(1, 33), "gate_floor": range(41), "fan": range(3, 17), "above_share": range(16),
    },
}

# Trials whose parameters are suggested together and whose results are reported together: the search does not depend on the number of
# processors.
BATCH = 8
# Most suggestions for one batch; those whose cost has too many bits are rejected.
ATTEMPTS = 400

BUILT_IN = {"motorcycle": "the Motorcycle pair of scikit-image", "scenes": "synthetic scenes with occlusions"}


def objective(pair: StereoPair, params: NamedMethod) -> dict[str, float]:
    """Percentage of bad pixels of a pair for each of its masks, all stages of the refinement on."""
    return evaluate([pair], lambda disparities: MatcherConfig(disparities, method=params))[pair.name]


def _figures(run: Run, pairs: Sequence[StereoPair], candidates: Sequence[NamedMethod]) -> list[dict[str, dict[str, float]]]:
    """Figures of every candidate on every pair."""
    jobs = [(objective, pair, params) for params in candidates for pair in pairs]
    found: dict[int, dict[str, float]] = {}
    run(jobs, found.__setitem__)
    return [{pair.name: found[len(pairs) * number + at] for at, pair in enumerate(pairs)} for number in range(len(candidates))]


def _suggest(trial: Any, names: Sequence[str], start: NamedMethod, cost_bits: int) -> NamedMethod | None:
    """Parameters to try; ``None`` if their cost has too many bits."""
    values, space = {}, SPACES[start.name]
    for name in names:
        greatest = min(space[name][-1], (1 << cost_bits) - 1) if name == "cost_outside" else space[name][-1]
        values[name] = trial.suggest_int(name, space[name][0], greatest, step=space[name].step)
    try:
        params = changed(start, **values)
    except ValueError:  # more than eight bits
        return None
    return params if params.cost_max.bit_length() <= cost_bits else None


def search(run: Run, pairs: Sequence[StereoPair], names: Sequence[str], trials: int, seed: int, start: NamedMethod = FUSED_1,
           advance: Any = None, cost_bits: int = 8) -> tuple[NamedMethod, float]:
    """Parameters of the least average of bad pixels on ``pairs``; the search is Optuna's TPE, and the same for the same seed.

    Parameters
    ----------
    run : Run
        Of :func:`golden.lab.workers.workers`.
    pairs : sequence of StereoPair
        Names must differ.
    names : sequence of str
        Of :data:`SPACES` of the method: the parameters that are searched, from a ``start`` within it. The others keep the values of
        ``start``.
    trials : int
        The first is ``start`` itself, so the result is never worse.
    advance : callable or None
        Called with the number of finished trials, the least average and its parameters.
    cost_bits : int
        Parameters whose cost ``C`` has more bits are not tried.

    Returns
    -------
    params : NamedMethod
        Of the class of ``start``.
    value : float
        Average of all masks of all pairs, percent.
    """
    import optuna  # here, because only this command needs it

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with warnings.catch_warnings():
        # Joint distributions, because weights and costs depend on each other. Optuna calls that experimental; its version is bounded.
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        sampler = optuna.samplers.TPESampler(seed=seed, n_startup_trials=2 * BATCH, multivariate=True, constant_liar=True)
    study = optuna.create_study(sampler=sampler)
    study.enqueue_trial({name: value_of(start, name) for name in names})
    best, least = start, float("inf")
    for done in range(0, trials, BATCH):
        candidates = []  # (trial, parameters)
        for _ in range(ATTEMPTS):
            trial = study.ask()
            params = _suggest(trial, names, start, cost_bits)
            if params is None:
                study.tell(trial, state=optuna.trial.TrialState.FAIL)
            else:
                candidates.append((trial, params))
            if len(candidates) == min(BATCH, trials - done):
                break
        if not candidates:
            raise UserError(f"none of {ATTEMPTS} parameter sets has a cost of {cost_bits} bits at most; "
                            "allow more --cost-bits or start from a greater cost_shift")
        averages = [average(figures) for figures in _figures(run, pairs, [params for _, params in candidates])]
        for (trial, params), value in zip(candidates, averages, strict=True):
            study.tell(trial, value)
            if value < least:
                best, least = params, value
        if advance:
            advance(min(done + BATCH, trials), least, best)
    return best, least


def _scenes() -> list[StereoPair]:
    """Synthetic scenes, of three sizes."""
    result = []
    for seed, (width, height, disparities) in enumerate([(160, 120, 16), (240, 180, 32), (320, 240, 64)], start=1):
        left, right, truth, visible = layers(width, height, disparities, seed)
        masks = {"nonocc": visible, "all": np.ones_like(visible)}
        result.append(StereoPair(f"scene {seed}", left, right, truth.astype(np.float64), masks, disparities))
    return result


def _pairs(places: Sequence[str], option: str) -> list[StereoPair]:
    """The pairs of all folders and built-in names."""
    result: list[StereoPair] = []
    for place in places:
        result += [motorcycle()] if place == "motorcycle" else _scenes() if place == "scenes" else sets_in(place)
    names = [pair.name for pair in result]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"the pair {name} is given more than once for {option}; give each once")
    return result


def parser() -> Parser:
    """The arguments of the command."""
    words = "; ".join(f"the word {word}: {what}" for word, what in BUILT_IN.items())
    result = Parser(prog="golden tune", formatter_class=argparse.ArgumentDefaultsHelpFormatter, description=(
        "Searches parameters of a method with the fewest bad pixels on some pairs, and shows the result on others. A place of pairs "
        f"is a pair's folder or a folder of such (see docs/data.md); {words}. The same seed gives the same result."))
    result.add_argument("--train", nargs="+", required=True, metavar="PLACE", help="pairs that the search sees")
    result.add_argument("--test", nargs="+", default=list(BUILT_IN), metavar="PLACE", help="pairs that the search does not see")
    result.add_argument("--trials", type=int, default=200, metavar="N", help="parameter sets to try, including the start")
    result.add_argument("--seed", type=int, default=1, metavar="S", help="of the search")
    result.add_argument("--method", choices=list(SPACES), default=next(iter(SPACES)), metavar="|".join(SPACES), help="whose parameters")
    searched = "; ".join(f"{name}: {' '.join(space)}" for name, space in SPACES.items())
    result.add_argument("--search", nargs="+", metavar="NAME", default=argparse.SUPPRESS,
                        help=f"parameters that are searched (default: {searched})")
    sets = {method: list(NAMED[method]) for method in SPACES}
    result.add_argument("--start", type=Path, metavar="|".join([*itertools.chain(*sets.values()), "FILE"]), default=argparse.SUPPRESS,
                        help=f"parameters to start from (default: {', '.join(names[0] for names in sets.values())})")
    result.add_argument("--cost-bits", type=int, default=8, metavar="B", help="most bits of a cost, hence of memory for lines of costs")
    add_worker_options(result)
    result.add_argument("--output", type=Path, required=True, metavar="FILE",
                        help=f"write the best so far there, for --parameters; suffix {PARAMETER_SUFFIX}")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    for name, lowest in (("trials", 1), ("seed", 0)):
        if getattr(options, name) < lowest:
            raise UserError(f"--{name} must be at least {lowest}, not {getattr(options, name)}; choose a greater one")
    if not 1 <= options.cost_bits <= 8:
        raise UserError(f"--cost-bits must be 1 to 8, not {options.cost_bits}; a cost has 8 bits at most")
    output = check_output(options.output, (PARAMETER_SUFFIX,))
    space, place = SPACES[options.method], getattr(options, "start", None) or next(iter(NAMED[options.method]))
    start: NamedMethod = read_parameters(place, options.method)
    searched = getattr(options, "search", list(space))
    for name in searched:
        if name not in space:
            raise UserError(f"--search {name} is no parameter that is searched of the method {start.name}; choose from {', '.join(space)}")
        if value_of(start, name) not in space[name]:
            raise UserError(f"{place} has {name} = {value_of(start, name)}, which is not within the "
                            f"{space[name][0]} to {space[name][-1]} of the search; leave it out of --search")
    if start.cost_max.bit_length() > options.cost_bits:
        raise UserError(f"the cost of the start reaches {start.cost_max}, more than --cost-bits {options.cost_bits} hold; "
                        "start from parameters with a greater cost_shift")
    train, test = _pairs(options.train, "--train"), _pairs(options.test, "--test")
    common = {pair.name for pair in train} & {pair.name for pair in test}
    if common:
        raise UserError(f"the pair {min(common)} is given for --train and for --test; a test needs pairs that the search has not seen")
    check_installed("dask", "optuna")

    with workers(options.workers, options.scheduler) as compute, progress() as bar:
        task = bar.add_task("", total=options.trials)

        places = ", ".join(pair.name for pair in train)
        written: NamedMethod | None = None

        def advance(done: int, least: float, best: NamedMethod) -> None:
            nonlocal written
            bar.update(task, completed=done, description=f"least average {least:.2f} %")
            if best != written or done == options.trials:  # an interrupted search keeps its best
                note = f"golden tune: {least:.2f} % bad pixels on {places}\nseed {options.seed}, {done} of {options.trials} trials"
                write_parameters(output, best, note)
                written = best

        best, _ = search(compute, train, searched, options.trials, options.seed, start, advance, options.cost_bits)
        rows = {part: _figures(compute, pairs, [start, best]) for part, pairs in (("train", train), ("test", test))}

    table = Table(title="Bad pixels: off by more than 1 pixel, percent, average of the masks")
    for column in ("", "pair", "start", "best"):
        table.add_column(column, justify="right" if column in ("start", "best") else "left")
    for part, (before, after) in rows.items():
        for number, name in enumerate(before):
            table.add_row("" if number else part, name, *(f"{np.mean(list(figures[name].values())):.2f}" for figures in (before, after)))
        table.add_row("", "average", f"{average(before):.2f}", f"{average(after):.2f}", end_section=True)
    print_table(table)
    others = [f"{name} {value_of(start, name)} -> {value_of(best, name)}" for name in start.LIMITS
              if value_of(start, name) != value_of(best, name)]
    print(f"{output}: {', '.join(others) or 'nothing better than the start'}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden tune")

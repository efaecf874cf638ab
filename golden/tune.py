"""`python -m golden tune`: search for better parameters of the fused cost."""

import argparse
import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from .cli import Parser, progress
from .config import FUSED_1, Arithmetic, Cost, FusedParameters, MatcherConfig
from .dataset import StereoPair, motorcycle, pairs_in
from .errors import UserError, run_cli
from .evaluate import average, evaluate
from .files import check_output
from .parameters import PARAMETER_SUFFIX, read_parameters, write_parameters
from .scenes import layers
from .workers import Run, add_worker_options, check_installed, workers


__all__ = ["SPACE", "main", "objective", "search"]


# What is searched, and how far. The cost keeps its 8 bits and the gateware its size: factor, shift and tolerance stay.
SPACE = {
    "truncation": range(40, 401), "census_weight": range(0, 101), "cost_outside": range(5, 81),
    "census_rows": range(3, 8, 2), "census_columns": range(3, 10, 2), "arm_threshold": range(3, 31), "reach": range(4, 32),
    "u1": range(1, 64), "u2": range(1, 64), "u3": range(1, 64), "median": range(3, 6, 2),
}

# Trials that are asked for together and told together: the search is the same on any number of processors.
BATCH = 8

BUILT_IN = {"motorcycle": "the Motorcycle pair of scikit-image", "scenes": "synthetic scenes with occlusions"}


def objective(pair: StereoPair, params: FusedParameters) -> dict[str, float]:
    """Percentage of bad pixels of a pair for each of its masks, all stages of the refinement on."""
    return evaluate([pair], lambda disparities: MatcherConfig(
        disparities=disparities, arithmetic=Arithmetic.LINEAR, cost=Cost.FUSED, fused=params))[pair.name]


def _figures(run: Run, pairs: Sequence[StereoPair], candidates: Sequence[FusedParameters]) -> list[dict[str, dict[str, float]]]:
    """Figures of every candidate on every pair."""
    jobs = [(objective, pair, params) for params in candidates for pair in pairs]
    found: dict[int, dict[str, float]] = {}
    run(jobs, found.__setitem__)
    return [{pair.name: found[len(pairs) * number + at] for at, pair in enumerate(pairs)} for number in range(len(candidates))]


def search(run: Run, pairs: Sequence[StereoPair], names: Sequence[str], trials: int, seed: int, start: FusedParameters = FUSED_1,
           advance: Any = None) -> tuple[FusedParameters, float]:
    """Parameters of the least average of bad pixels on ``pairs``; the search is Optuna's TPE, and the same for the same seed.

    Parameters
    ----------
    run : Run
        Of :func:`golden.workers.workers`.
    pairs : sequence of StereoPair
        Names must differ.
    names : sequence of str
        Of :data:`SPACE`: what is searched, from a ``start`` within it. The others stay as they are there.
    trials : int
        The first is ``start`` itself, so the result is never worse.
    advance : callable or None
        Called with the number of trials that are done and the least average.

    Returns
    -------
    params : FusedParameters
    value : float
        Average of all masks of all pairs, percent.
    """
    import optuna  # here, because only this command needs it

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed, n_startup_trials=3 * BATCH))
    study.enqueue_trial({name: getattr(start, name) for name in names})
    best, least = start, float("inf")
    for done in range(0, trials, BATCH):
        candidates = []  # (trial, parameters)
        for _ in range(done, min(done + BATCH, trials)):
            trial = study.ask()
            values = {name: trial.suggest_int(name, SPACE[name][0], SPACE[name][-1], step=SPACE[name].step) for name in names}
            try:
                candidates.append((trial, dataclasses.replace(start, **values)))
            except ValueError:  # the cost does not fit its bits
                study.tell(trial, state=optuna.trial.TrialState.FAIL)
        averages = [average(figures) for figures in _figures(run, pairs, [params for _, params in candidates])]
        for (trial, params), value in zip(candidates, averages, strict=True):
            study.tell(trial, value)
            if value < least:
                best, least = params, value
        if advance:
            advance(min(done + BATCH, trials), least)
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
        result += [motorcycle()] if place == "motorcycle" else _scenes() if place == "scenes" else pairs_in(place)
    names = [pair.name for pair in result]
    for name in names:
        if names.count(name) > 1:
            raise UserError(f"the pair {name} is given more than once for {option}; give each once")
    return result


def parser() -> Parser:
    """The arguments of the command."""
    words = "; ".join(f"the word {word}: {what}" for word, what in BUILT_IN.items())
    result = Parser(prog="golden tune", formatter_class=argparse.ArgumentDefaultsHelpFormatter, description=(
        "Searches parameters of the fused cost that give the fewest bad pixels on some pairs, and shows what they give on others. "
        f"A place of pairs is a pair's folder or a folder of such (see docs/data.md); {words}. The same seed gives the same result."))
    result.add_argument("--train", nargs="+", required=True, metavar="PLACE", help="pairs that the search sees")
    result.add_argument("--test", nargs="+", default=list(BUILT_IN), metavar="PLACE", help="pairs that it does not see")
    result.add_argument("--trials", type=int, default=200, metavar="N", help="parameter sets that are tried, the start among them")
    result.add_argument("--seed", type=int, default=1, metavar="S", help="of the search")
    result.add_argument("--search", nargs="+", choices=SPACE, default=list(SPACE), metavar="NAME", help="parameters that are searched")
    result.add_argument("--start", type=Path, metavar="FILE", help="parameters to start from, fused-1 if none are given")
    add_worker_options(result)
    result.add_argument("--output", type=Path, required=True, metavar="FILE",
                        help=f"write the best there, for --parameters; suffix {PARAMETER_SUFFIX}")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    for name, lowest in (("trials", 1), ("seed", 0)):
        if getattr(options, name) < lowest:
            raise UserError(f"--{name} must be at least {lowest}, not {getattr(options, name)}; choose a greater one")
    output = check_output(options.output, (PARAMETER_SUFFIX,))
    start = read_parameters(options.start) if options.start else FUSED_1
    for name in options.search:
        if getattr(start, name) not in SPACE[name]:
            raise UserError(f"{options.start} has {name} = {getattr(start, name)}, which is not within the {SPACE[name][0]} to "
                            f"{SPACE[name][-1]} of the search; leave it out of --search")
    train, test = _pairs(options.train, "--train"), _pairs(options.test, "--test")
    common = {pair.name for pair in train} & {pair.name for pair in test}
    if common:
        raise UserError(f"the pair {min(common)} is given for --train and for --test; a test needs pairs that the search has not seen")
    check_installed("dask", "optuna")

    with workers(options.workers, options.scheduler) as compute, progress() as bar:
        task = bar.add_task("", total=options.trials)

        def advance(done: int, least: float) -> None:
            bar.update(task, completed=done, description=f"least average {least:.2f} %")

        best, least = search(compute, train, options.search, options.trials, options.seed, start, advance)
        rows = {part: _figures(compute, pairs, [start, best]) for part, pairs in (("train", train), ("test", test))}

    places = ", ".join(pair.name for pair in train)
    write_parameters(output, best, f"golden tune: {least:.2f} % bad pixels on {places}\nseed {options.seed}, {options.trials} trials")
    table = Table(title="Bad pixels: off by more than 1 pixel, percent, average of the masks")
    for column in ("", "pair", "start", "best"):
        table.add_column(column, justify="right" if column in ("start", "best") else "left")
    for part, (before, after) in rows.items():
        for number, name in enumerate(before):
            table.add_row("" if number else part, name, *(f"{np.mean(list(figures[name].values())):.2f}" for figures in (before, after)))
        table.add_row("", "average", f"{average(before):.2f}", f"{average(after):.2f}", end_section=True)
    Console().print(table)
    changed = [f"{field.name} {getattr(start, field.name)} -> {getattr(best, field.name)}" for field in dataclasses.fields(best)
               if getattr(start, field.name) != getattr(best, field.name)]
    print(f"{output}: {', '.join(changed) or 'nothing better than the start'}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden tune")

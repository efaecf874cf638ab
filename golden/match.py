"""`python -m golden match`: disparities of a pair of pictures, in software."""

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .cli import Parser, add_matcher_options, matcher_config, progress
from .config import MatcherConfig
from .cost import local_disparity, matching_cost
from .dataset import motorcycle
from .errors import UserError, run_cli
from .files import check_output
from .images import LABEL_SUFFIXES, read_pair, write_labels
from .labelling import labelling
from .metrics import bad_pixels


__all__ = ["main"]


LIMITS = f"{MatcherConfig.DISPARITIES[0]} to {MatcherConfig.DISPARITIES[-1]}"


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(
        prog="golden match", description="Disparities of a rectified pair of pictures, as the gateware computes them.",
        epilog="Without LEFT and RIGHT the Motorcycle pair of scikit-image, reduced to 180x120 pixels, is matched "
               "and compared with its truth.")
    result.add_argument("left", nargs="?", type=Path, metavar="LEFT", help="left picture: PNG, PGM, PPM, JPEG, PFM, NPY or text picture")
    result.add_argument("right", nargs="?", type=Path, metavar="RIGHT", help="right picture, of the same size")
    result.add_argument("--disparities", type=int, metavar="N",
                        help=f"number of disparities, {LIMITS}: 0 .. N-1 pixels (default without pictures: what covers the truth)")
    add_matcher_options(result)
    result.add_argument("--output", type=Path, required=True, metavar="FILE",
                        help="disparities, pixels; the suffix decides: .npy labels, .png or .pgm 8-bit labels, .pfm, .txt text picture")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    # What costs nothing to check comes before what takes time.
    if options.left and not options.right:
        raise UserError(f"{options.left} has no right picture; give LEFT and RIGHT, or neither for the Motorcycle pair")
    if options.left and options.disparities is None:
        raise UserError(f"--disparities is missing; give the number of disparities of the pictures, {LIMITS}")
    if options.disparities is not None:
        matcher_config(options, options.disparities)
    output = check_output(options.output, LABEL_SUFFIXES)
    if any(side is not None and side.exists() and output.exists() and side.samefile(output) for side in (options.left, options.right)):
        raise UserError(f"{output} is one of the pictures; choose another --output")

    pair = None if options.left else motorcycle()
    left, right = (pair.left, pair.right) if pair else read_pair(options.left, options.right)
    config = matcher_config(options, options.disparities if options.disparities is not None or not pair else pair.disparities)

    start = time.perf_counter()
    with progress() as bar:
        task = bar.add_task("Matching cost", total=2)
        cost = matching_cost(left, right, config)
        bar.update(task, advance=1, description="Disparities")
        labels = labelling(cost, local_disparity(cost), left, config)
        bar.update(task, advance=1)
    seconds = time.perf_counter() - start

    write_labels(output, labels.astype(np.uint8))
    height, width = labels.shape
    print(f"{output}: {width}x{height} pixels, {config.disparities} disparities, {config.arithmetic}, {seconds:.2f} s")
    if pair:
        bad = bad_pixels(labels, pair.truth, pair.masks["known"])
        print(f"bad pixels: {bad:.2f} % of those with known truth are off by more than 1 pixel")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden match")

"""`python -m golden match`: disparities of a pair of pictures, in software."""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .cli import Parser, add_method_options, add_minimum_option, belongs, described, either, method_config, methods_with
from .config import MatcherConfig
from .errors import UserError, run_cli
from .files import check_output
from .matcher.confidence import CONFIDENCE_MAX
from .matcher.matcher import in_pixels, match
from .order import note_order
from .pictures.dataset import motorcycle
from .pictures.disparities import LABEL_SUFFIXES, check_disparity_output, write_disparity, write_labels
from .pictures.images import read_pair
from .pictures.metrics import bad_pixels
from .pictures.products import SUFFIXES, add_product_options, check_camera_options, read_camera, write_products
from .pictures.truth import add_truth_options, check_truth_options, read_truth
from .pictures.white import add_white_option, check_white
from .rig.balance import balance
from .rig.files import read_rig


__all__ = ["main"]


LIMITS = f"{MatcherConfig.LABELS[0]} to {MatcherConfig.LABELS[-1]}"


# What some methods give in addition to the disparity.
MAPS = {
    "passed": "where the left-right check passed, 0 or 1",
    "confidence": f"confidence of every disparity, 0 .. {CONFIDENCE_MAX}",
}


def _methods_with_field(name: str) -> list[str]:
    """The methods that give it."""
    return methods_with(lambda method: name in method.result_fields(MatcherConfig.LABELS[0], MatcherConfig.minimum))


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(
        prog="golden match", description="Disparities of a pair of pictures, rectified or with --rig, as the gateware computes them.",
        epilog="Without LEFT and RIGHT the Motorcycle pair of scikit-image, reduced to 180x120 pixels, is matched "
               "and compared with its truth.")
    result.add_argument("left", nargs="?", type=Path, metavar="LEFT", help="left picture: PNG, PGM, PPM, TIFF, JPEG, PFM, NPY or text")
    result.add_argument("right", nargs="?", type=Path, metavar="RIGHT", help="right picture, of the same size")
    result.add_argument("--disparities", type=int, metavar="N",
                        help=f"number of disparities, {LIMITS}: 0 .. N-1 pixels (default without pictures: what covers the truth)")
    add_white_option(result)
    result.add_argument("--rig", type=Path, metavar="FILE", help=(
        "rectify the pair first: the rig.json of golden calibrate, or its folder; LEFT and RIGHT are as the cameras give them"))
    result.add_argument("--balance", action="store_true", help=(
        "then make the right picture's brightness and contrast those of the left one, as the gateware does"))
    add_minimum_option(result)
    add_method_options(result)
    add_truth_options(result)
    add_product_options(result)
    result.add_argument("--output", type=Path, required=True, metavar="FILE",
                        help="disparities, pixels; the suffix decides: .npy labels, .png or .pgm 8-bit labels, .pfm, .txt text picture")
    result.add_argument("--png-scale", type=int, metavar="S", help=(
        "--output is a .png of 16 bits with disparity * S, rounded; 0 would be unknown, so disparity 0 is 1; S = 256 is KITTI's format"))
    for option, what in MAPS.items():
        result.add_argument(f"--{option}", type=Path, metavar="FILE", help=(
            f"{what}; --method {either(_methods_with_field(option))} only, formats as of --output"))
    return result


def greatest(config: MatcherConfig) -> int:
    """Greatest disparity that can be, pixels."""
    return config.minimum + config.labels - 1


def _check_outputs(options: argparse.Namespace, config: MatcherConfig) -> None:
    """:class:`UserError` unless every file that is asked for can be written, and can hold what is written there."""
    inputs = (options.left, options.right, options.rig, options.truth, options.mask, *(options.calib or []))
    sides = [side for side in inputs if side is not None and side.exists()]
    taken: list[tuple[str, Path]] = []
    for name in ("output", *MAPS, *SUFFIXES):
        path = getattr(options, name)
        if path is None:
            continue
        option = f"--{name}"
        if name in MAPS and name not in config.result_fields:
            raise belongs(option, _methods_with_field(name))
        check_output(path, SUFFIXES.get(name, LABEL_SUFFIXES), option)
        if any(path.exists() and side.samefile(path) for side in sides):
            raise UserError(f"{path} is one of the files that are read; choose another {option}")
        for other, before in taken:
            if path.resolve() == before.resolve():
                raise UserError(f"{path} is given for {other} and for {option}; choose another {option}")
        taken.append((option, path))
    check_disparity_output(options.output, config.minimum, greatest(config), config.method.disparity_scale > 1, options.png_scale)


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    # Cheap checks first.
    if options.left and not options.right:
        raise UserError(f"{options.left} has no right picture; give LEFT and RIGHT, or neither for the Motorcycle pair")
    if options.left and options.disparities is None:
        raise UserError(f"--disparities is missing; give the number of disparities of the pictures, {LIMITS}")
    if options.rig and not options.left:
        raise UserError(f"--rig {options.rig} is for the cameras' own pictures; give LEFT and RIGHT, or leave it out")
    check_white(options, bool(options.left))
    check_truth_options(options)
    check_camera_options(options)
    _check_outputs(options, method_config(options, MatcherConfig.LABELS[0] if options.disparities is None else options.disparities))

    rig = read_rig(options.rig) if options.rig else None
    pair = None if options.left else motorcycle()
    left, right = (pair.left, pair.right) if pair else read_pair(options.left, options.right, options.white)
    config = method_config(options, options.disparities if options.disparities is not None or not pair else pair.disparities)
    if rig is not None:
        if left.shape[::-1] != rig.size:
            raise UserError(f"{options.left} has {left.shape[1]}x{left.shape[0]} pixels and {options.rig} is for "
                            f"{rig.size[0]}x{rig.size[1]}; calibrate at the size of the pictures")
        left, right = rig.rectified(left, right)
    if options.balance:
        right = balance(left, right, config.minimum, config.labels)
    camera = read_camera(options, left.shape, config)
    truth = read_truth(options, left.shape, config)
    if pair and truth is None:
        truth = pair.truth, pair.masks["known"]

    start = time.perf_counter()
    fields = match(left, right, config)
    disparity = in_pixels(fields["disparity"], config)
    seconds = time.perf_counter() - start

    write_disparity(options.output, disparity, config.minimum, greatest(config), options.png_scale)
    for name in MAPS:
        if getattr(options, name):
            write_labels(getattr(options, name), fields[name].astype(np.uint8))
    write_products(options, left, disparity, config, truth, camera)

    height, width = disparity.shape
    print(f"{options.output}: {width}x{height} pixels, {config.labels} disparities, {described(config)}, {seconds:.2f} s")
    if "passed" in fields:
        print(f"passed: {100 * np.mean(fields['passed']):.0f} % of the pixels pass the left-right check")
    note_order(left, right, config)
    if truth is not None:
        bad = bad_pixels(disparity, *truth, options.threshold)
        print(f"bad pixels: {bad:.2f} % of the {np.count_nonzero(truth[1])} that count are off by more than {options.threshold:g} pixel")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden match")

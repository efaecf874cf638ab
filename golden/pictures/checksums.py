"""`python -m golden data`: checks that a folder holds the pictures on which the figures of this repository are measured."""

import argparse
import hashlib
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from ..cli import Parser
from ..errors import UserError, run_cli
from ..tables import print_table
from .dataset import MASKS, PAIRS, add_data_option, data_folder
from .images import read_colours


__all__ = ["FILES", "main", "pixel_digest", "state", "sums"]


#: What is checked of every pair.
FILES = ("left.png", "right.png", "disp_left.png", *(f"{mask}.png" for mask in MASKS))

SUMS = Path(__file__).with_name("middlebury.sha256")
PIXEL_SUMS = Path(__file__).with_name("middlebury_pixels.sha256")

SAME, ENCODED, OTHER, MISSING = "good", "same pixels", "differs", "missing"


def sums(path: Path) -> dict[str, str]:
    """SHA-256 of files by their names, from a list in the format of `sha256sum`."""
    lines = path.read_text(encoding="ascii").splitlines()
    return {name: digest for digest, name in (line.split("  ", 1) for line in lines)}


def pixel_digest(path: Path) -> str:
    """SHA-256 of a picture's pixels, independent of its encoding: shape as text, then all bytes; equal colour channels are one."""
    levels = read_colours(path)
    if levels.ndim == 3 and (levels == levels[..., :1]).all():
        levels = levels[..., 0]
    return hashlib.sha256(f"{levels.shape}".encode("ascii") + levels.tobytes()).hexdigest()


def state(folder: Path, name: str, digest: str, of_pixels: str) -> str:
    """Whether a file is the expected one: one of the four words."""
    path = folder / name
    if not path.is_file():
        return MISSING
    if hashlib.sha256(path.read_bytes()).hexdigest() == digest:
        return SAME
    try:
        return ENCODED if pixel_digest(path) == of_pixels else OTHER
    except UserError:  # no picture
        return OTHER


def parser() -> argparse.ArgumentParser:
    """The arguments of the command."""
    result = Parser(prog="golden data", description=(
        "Compares the pictures of the four Middlebury pairs with the checksums of those on which the figures here are measured. "
        "docs/data.md says where to get them, and their layout."))
    add_data_option(result, "--check")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    folder = data_folder(parser().parse_args(argv).check)
    files, pixels = sums(SUMS), sums(PIXEL_SUMS)
    states = {name: state(folder, name, digest, pixels[name]) for name, digest in files.items()}

    table = Table(title=Text(str(folder)))
    table.add_column("pair")
    for name in FILES:
        table.add_column(name)
    for pair in PAIRS:
        table.add_row(pair, *(states[f"{pair}/{name}"] for name in FILES))
    print_table(table)
    bad = [name for name, word in states.items() if word not in (SAME, ENCODED)]
    if bad:
        raise UserError(f"{folder} lacks {len(bad)} of {len(states)} pictures or holds others, first {bad[0]}: {states[bad[0]]}; "
                        "get them as docs/data.md says")
    print(f"{len(states)} pictures are those of the figures.")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden data")

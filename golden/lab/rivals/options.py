"""What the commands of the rivals share: which pairs, and names that are given once."""

import argparse
from pathlib import Path

from ...cli import Parser
from ...errors import UserError
from ...pictures.dataset import PAIRS, StereoPair, data_folder, load_pair


__all__ = ["add_pair_options", "check_names", "load_pairs"]


def add_pair_options(parser: Parser) -> None:
    """Add ``--data`` and ``--pairs``, for :func:`load_pairs`."""
    parser.add_argument("--data", type=Path, metavar="DIR",
                        help=f"folder that holds {', '.join(PAIRS)} (default: $STEREO_DATA, else ../shared/data/middlebury)")
    parser.add_argument("--pairs", nargs="+", choices=PAIRS, default=list(PAIRS), metavar="NAME", help="which (default: all four)")


def load_pairs(options: argparse.Namespace) -> list[StereoPair]:
    """The pairs that the options of :func:`add_pair_options` ask for; :class:`UserError` if they are not there."""
    folder = data_folder(options.data)
    return [load_pair(folder, name) for name in options.pairs]


def check_names(options: argparse.Namespace, *lists: str) -> None:
    """:class:`UserError` if an option that takes names is given one twice."""
    for option in lists:
        names = getattr(options, option)
        for name in names:
            if names.count(name) > 1:
                raise UserError(f"--{option} names {name} more than once; name each once")

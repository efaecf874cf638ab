"""Options that the commands of the rivals share: the choice of pairs, and lists of names."""

import argparse

from ...cli import Parser
from ...errors import UserError
from ...pictures.dataset import PAIRS, add_data_option


__all__ = ["add_pair_options", "check_names"]


def add_pair_options(parser: Parser) -> None:
    """Add ``--data`` and ``--pairs``, the arguments of :func:`golden.pictures.dataset.load_pairs`."""
    add_data_option(parser)
    parser.add_argument("--pairs", nargs="+", choices=PAIRS, default=list(PAIRS), metavar="NAME", help="which (default: all four)")


def check_names(options: argparse.Namespace, *lists: str) -> None:
    """:class:`UserError` if an option that takes names is given one twice."""
    for option in lists:
        names = getattr(options, option)
        for name in names:
            if names.count(name) > 1:
                raise UserError(f"--{option} names {name} more than once; name each once")

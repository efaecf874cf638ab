"""Options that the commands of the rivals share: the choice of sets, and lists of names."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from ...cli import Parser
from ...errors import UserError
from ...pictures.dataset import PAIRS, StereoPair, add_data_option, data_folder
from ...pictures.sets import load_data


__all__ = ["add_pair_options", "check_names", "load_folders"]


def add_pair_options(parser: Parser, several: bool = False) -> None:
    """Add ``--data``, of one folder or of several, and ``--pairs``, the arguments of :func:`load_folders`."""
    add_data_option(parser, sets=True, several=several)
    parser.add_argument("--pairs", nargs="+", metavar="NAME",
                        help=f"which pairs or sets; of the benchmark {', '.join(PAIRS)} (default: all)")


def check_names(options: argparse.Namespace, *lists: str) -> None:
    """:class:`UserError` if an option that takes names is given one twice."""
    for option in lists:
        names = getattr(options, option) or []
        for name in names:
            if names.count(name) > 1:
                raise UserError(f"--{option} names {name} more than once; name each once")


def load_folders(folders: Sequence[Path] | None, names: Sequence[str] | None = None) -> dict[str, list[StereoPair]]:
    """Pairs of several folders for :func:`golden.pictures.sets.load_data`, by the folders' names; ``None``: the default folder.

    Folders must differ in their names, and sets of all folders too.
    """
    folders = [data_folder()] if folders is None else folders
    if names and len(folders) > 1:
        raise UserError(f"--pairs {names[0]} chooses in one folder, but --data names {len(folders)}; name one or leave --pairs out")
    result: dict[str, list[StereoPair]] = {}
    for folder in folders:
        name = folder.resolve().name
        if name in result:
            raise UserError(f"--data names two folders {name}; name each once, and folders of different names")
        result[name] = load_data(folder, names)
        for pair in result[name]:
            if any(pair.name == other.name for before, pairs in result.items() if before != name for other in pairs):
                raise UserError(f"the set {pair.name} is in {folder} and in another folder of --data; name one of them")
    return result

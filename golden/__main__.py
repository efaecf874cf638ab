"""`python -m golden COMMAND`: the commands of the golden model."""

import argparse
import sys
from collections.abc import Sequence

from . import match
from .calibrate import command as calibrate
from .cli import Parser
from .errors import run_cli
from .lab import boards, cameras, evaluate, sparsification, tune
from .lab.rivals import command as rivals
from .lab.rivals import compare, gaps
from .lab.thesis import command as thesis
from .pictures import checksums


__all__ = ["main"]


COMMANDS = {
    "match": (match.main, "disparities of a pair of pictures"),
    "calibrate": (calibrate.main, "two cameras from pictures of a chessboard: how to rectify theirs"),
    "boards": (boards.main, "disparities of real cameras, with the plane of a chessboard as truth"),
    "cameras": (cameras.main, "what badly mounted cameras cost, and what rectification and balance are worth"),
    "evaluate": (evaluate.main, "bad pixels on the Middlebury benchmark or other sets"),
    "data": (checksums.main, "whether a folder holds the Middlebury pairs"),
    "sparsification": (sparsification.main, "whether confidence ranks errors"),
    "rivals": (rivals.main, "bad pixels and time of other methods and of ours"),
    "gaps": (gaps.main, "how far the rule is from the minimum cut of each line"),
    "compare": (compare.main, "our methods and OpenCV's side by side on hard scenes, with pictures"),
    "thesis": (thesis.main, "every table and figure of the thesis, with ours for comparison"),
    "tune": (tune.main, "a search for better parameters of a method"),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command that the first argument names; the exit status is the result."""
    argv = sys.argv[1:] if argv is None else argv
    parser = Parser(
        prog="golden", description="The reference model of the stereo matcher.", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="\n".join(f"  {name:16}{what}; see golden {name} --help" for name, (_, what) in COMMANDS.items()))
    parser.add_argument("command", choices=COMMANDS, metavar="|".join(COMMANDS), help="what to do")

    def run(head: Sequence[str] | None) -> int:
        command, _ = COMMANDS[parser.parse_args(head).command]
        return command(argv[1:])

    return run_cli(run, argv[:1], "golden")


if __name__ == "__main__":
    sys.exit(main())

"""Bad input: how a command line says so, and ends."""

import sys
from collections.abc import Callable, Sequence


__all__ = ["UserError", "run_cli"]


class UserError(ValueError):
    """Bad input from the user, described in one sentence that names the value, the limit and the remedy.

    A command line prints the sentence and exits with status 2: no traceback. To callers of the library it is a :class:`ValueError`.
    """


def run_cli(function: Callable[[Sequence[str] | None], int | None], argv: Sequence[str] | None, prog: str) -> int:
    """Run the body of a command line; the exit status is the result.

    Parameters
    ----------
    function : callable
        Takes ``argv``; returns an exit status, ``None`` for 0.
    argv : sequence of str or None
        Arguments without the program's name; ``None`` for those of the process.
    prog : str
        What the sentence on stderr begins with.

    Returns
    -------
    int
        What ``function`` returned; 2 after a :class:`UserError`, or when memory ran out; 130 when interrupted.
    """
    try:
        return function(argv) or 0
    except UserError as error:
        sentence, status = str(error), 2
    except MemoryError as error:
        sentence, status = f"not enough memory: {error or 'allocation refused'}; use a smaller picture or fewer disparities", 2
    except KeyboardInterrupt:
        sentence, status = "interrupted", 130
    # One line, even if a file name contains line breaks.
    print(f"{prog}: {' '.join(sentence.split())}", file=sys.stderr)
    return status

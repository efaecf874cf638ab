"""Programs that end when what started them does."""

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from typing import Any


__all__ = ["run_program", "started"]


# Seconds for a program to end by itself before it is killed.
_GRACE = 5.0


@contextlib.contextmanager
def started(command: Sequence[str | os.PathLike[str]], **options: Any) -> Iterator["subprocess.Popen[Any]"]:
    """A program in a process group of its own; the end of the block waits for it.

    If the block or the wait raises, :class:`KeyboardInterrupt` for example, the program is ended first, with all that it has started:
    ``make`` and compilers would run on otherwise, and so would a simulator when this process alone was sent a signal.

    Parameters
    ----------
    command, options
        As of :class:`subprocess.Popen`. Standard input is empty by default: a terminal stops a program of another group that reads it.
    """
    options = {"stdin": subprocess.DEVNULL, **options}
    process = subprocess.Popen(command, process_group=0, **options)
    try:
        yield process
        process.wait()
    except BaseException:
        _end(process)
        raise
    finally:
        for stream in filter(None, (process.stdout, process.stderr)):
            stream.close()


def _end(process: "subprocess.Popen[Any]") -> None:
    """By SIGTERM, so that a command of ours ends what it has started; then, whatever is left, by SIGKILL."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        deadline = time.monotonic() + _GRACE
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_GRACE)
        # `make` ends before its compilers, which have temporary files to remove.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            while time.monotonic() < deadline:
                os.killpg(process.pid, 0)
                time.sleep(0.02)


def run_program(command: Sequence[str | os.PathLike[str]], **options: Any) -> int:
    """Run a program as :func:`started` does, to its end; the exit status."""
    with started(command, **options) as process:
        pass
    return int(process.returncode)

"""Bad input, signals, and a standard output that cannot be written: how a command line says so, and ends."""

import contextlib
import errno
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any, TextIO


__all__ = ["UserError", "guard_start", "run_cli"]


# What ends a command from outside, and how the line on stderr names it. The exit status is that of a shell: 128 and the signal's number.
# Windows has not all of them.
_SIGNALS = {number: told for name, told in (("SIGINT", "interrupted"), ("SIGTERM", "ended by SIGTERM"), ("SIGHUP", "ended by SIGHUP"))
            if (number := getattr(signal, name, None)) is not None}
_BROKEN_PIPE = 128 + 13     # SIGPIPE, which Python ignores

# Seconds after a signal in which others are ignored: `timeout`, `make` and service managers send two, and the first one is being obeyed.
_DEAF_SECONDS = 1.0

# Seconds after which a signal is sent once more, if what it raised was swallowed on the way.
_AGAIN_SECONDS = 1.5

# What a full disk, a quota or a read-only file system says of a temporary file; outputs have their own checks.
_NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)


class UserError(ValueError):
    """Bad input from the user, described in one sentence that names the value, the limit and the remedy.

    A command line prints the sentence and exits with status 2: no traceback. To callers of the library it is a :class:`ValueError`.
    """


class _Signalled(BaseException):
    """A signal other than SIGINT: not an error, so that nothing on the way takes it for one."""
    def __init__(self, number: int):
        super().__init__(number)
        self.number = number


def _say(prog: str, sentence: str) -> None:
    """One line on stderr, even if a file name contains line breaks; nothing if it cannot be written."""
    with contextlib.suppress(OSError):
        print(f"{prog}: {' '.join(sentence.split())}", file=sys.stderr, flush=True)


def guard_start() -> None:
    """Let a signal end a command with one line while its modules are imported, before :func:`run_cli` runs it.

    For the ``__init__`` of a package with commands. Does nothing unless Python is about to run one of them, by ``-m``: whoever imports the
    package decides on signals.
    """
    if sys.argv[:1] != ["-m"]:     # Python's placeholder until it has found the module
        return
    words = sys.orig_argv
    prog = words[words.index("-m") + 1] if "-m" in words else "python"

    def end(number: int, frame: FrameType | None) -> None:
        _say(prog, _SIGNALS[signal.Signals(number)])
        os._exit(128 + number)     # nothing was begun that needs an orderly end

    for number in _SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, end)


@contextlib.contextmanager
def _signals() -> Iterator[Callable[[], contextlib.AbstractContextManager[None]]]:
    """Within a block of the function that is yielded, signals are exceptions, so that temporary folders go and child processes end.

    A signal that comes before such a block is met in it; one that comes after it is passed on to who handled signals before. A signal that
    is ignored stays so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield contextlib.nullcontext
        return
    last = -_DEAF_SECONDS
    unraisable = sys.unraisablehook
    raising = resent = False
    timer: threading.Timer | None = None
    held: list[int] = []

    def send_again(number: int) -> None:
        nonlocal resent
        resent = True
        os.kill(os.getpid(), number)

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal last, resent, timer
        was_resent, resent = resent, False
        if time.monotonic() - last < _DEAF_SECONDS:
            return
        if not raising:
            held.extend([] if was_resent else [number])
            return
        timer = threading.Timer(_AGAIN_SECONDS, send_again, [number])
        timer.daemon = True
        timer.start()
        if was_resent and isinstance(sys.exception(), KeyboardInterrupt | _Signalled):
            return  # it is being obeyed: something cleans up, and takes its time
        last = time.monotonic()
        # A half-built design is no mistake now: Amaranth would warn of every component.
        warnings.simplefilter("ignore")
        raise KeyboardInterrupt if number == signal.SIGINT else _Signalled(number)

    def again(args: "sys.UnraisableHookArgs") -> None:
        # The exception met a `__del__`, which drops it: once more, a little later.
        nonlocal last
        if not isinstance(args.exc_value, KeyboardInterrupt | _Signalled):
            unraisable(args)
            return
        last = -_DEAF_SECONDS
        number = getattr(args.exc_value, "number", signal.SIGINT)
        threading.Timer(0.01, os.kill, (os.getpid(), number)).start()

    @contextlib.contextmanager
    def raised() -> Iterator[None]:
        nonlocal raising
        try:
            raising = True
            for number in held[:1]:
                held.clear()
                end(number, None)
            yield
        finally:
            raising = False
            if timer:
                timer.cancel()

    before = {number: signal.getsignal(number) for number in _SIGNALS}
    for number, handler in before.items():
        if handler not in (signal.SIG_IGN, None):
            signal.signal(number, end)
    sys.unraisablehook = again
    try:
        yield raised
    finally:
        sys.unraisablehook = unraisable
        for number, handler in before.items():
            if handler not in (signal.SIG_IGN, None):
                signal.signal(number, handler)
        for number in held[:1]:
            signal.raise_signal(number)


class _Unwritable(BaseException):
    """stdout or stderr failed; not an error of the body, which may have handlers for those."""
    def __init__(self, stream: "_Stream", reason: OSError):
        super().__init__(stream, reason)
        self.stream, self.reason = stream, reason


class _Stream:
    """A text stream whose failure is told from that of another file."""
    def __init__(self, stream: TextIO):
        self.stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        with self._watched():
            return self.stream.write(text)

    def flush(self) -> None:
        with self._watched():
            self.stream.flush()

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            # What is buffered goes nowhere, so that Python's own attempt at its end succeeds.
            with contextlib.suppress(OSError, ValueError):
                null = os.open(os.devnull, os.O_WRONLY)
                os.dup2(null, self.stream.fileno())
                os.close(null)
            raise _Unwritable(self, error) from None


@contextlib.contextmanager
def _output() -> Iterator[None]:
    """Within the block stdout and stderr are watched; at its end all is written. Characters that stdout's encoding lacks are escaped."""
    before = sys.stdout, sys.stderr
    errors = getattr(sys.stdout, "errors", None)
    reconfigure = getattr(sys.stdout, "reconfigure", None) if errors == "strict" else None
    if reconfigure:
        reconfigure(errors="backslashreplace")
    # Either may be None: closed by who started the process.
    sys.stdout, sys.stderr = (stream and _Stream(stream) for stream in before)  # type: ignore[assignment]
    try:
        yield
    finally:
        try:
            if sys.stdout:
                sys.stdout.flush()
        finally:
            sys.stdout, sys.stderr = before
            if reconfigure:
                reconfigure(errors=errors)


def _result(function: Callable[[Sequence[str] | None], int | None], argv: Sequence[str] | None,
            raised: Callable[[], contextlib.AbstractContextManager[None]]) -> tuple[int, str]:
    """Exit status of a command's body, in which signals are ``raised``, and the sentence to print, empty if there is none."""
    try:
        with raised(), _output():
            return function(argv) or 0, ""
    except UserError as error:
        return 2, str(error)
    except MemoryError as error:
        return 2, f"not enough memory: {error or 'allocation refused'}; use a smaller picture or fewer disparities"
    except KeyboardInterrupt:
        return 128 + signal.SIGINT, _SIGNALS[signal.SIGINT]
    except _Signalled as ended:
        return 128 + ended.number, _SIGNALS[signal.Signals(ended.number)]
    except _Unwritable as failed:
        if isinstance(failed.reason, BrokenPipeError):      # `| head`: nobody wants the rest
            return _BROKEN_PIPE, ""
        return 2, f"cannot write to {failed.stream.name.strip('<>')}: {failed.reason.strerror}; redirect it elsewhere"
    except OSError as error:
        if error.errno in _NO_SPACE:
            name = f" for {error.filename}" if error.filename else ""
            return 2, f"{error.strerror}{name}; make room, or name another folder with --output, or with TMPDIR for temporary files"
        if "temporary directory" in str(error):     # of `tempfile`, when no folder that it knows can be written
            return 2, f"{error.strerror}; name a folder that can be written with TMPDIR"
        raise


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
        What ``function`` returned; 2 after a :class:`UserError`, when memory or disk ran out, or when stdout cannot be written; 130 when
        interrupted, 143 after SIGTERM, 129 after SIGHUP; 141, without a sentence, when nobody reads stdout any more.
    """
    with _signals() as raised:
        status, sentence = _result(function, argv, raised)
        if sentence:
            _say(prog, sentence)
        return status

"""Runs commands in processes that begin with everything imported: ``python -m sim.verify.fuzz.server``, and the side that asks it.

A request is a line of JSON on stdin, and so is its answer on stdout. A case costs milliseconds in place of the half second that Python
takes to import what it needs; of a share of the cases, the process is started anew, as a user does it.
"""

import atexit
import contextlib
import ctypes
import importlib
import io
import json
import os
import resource
import select
import signal
import subprocess
import sys
import time
import traceback
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

from golden.errors import guard_start
from golden.processes import started

from ..campaign import ROOT


__all__ = ["serve", "server"]


# Bytes of memory, of a file, seconds of processor: a fault must not take the machine with it.
_MEMORY, _FILE, _PROCESSOR = 3 << 30, 256 << 20, 30

# Seconds between two looks at the processor time of a command; how many seconds may pass for one of its processor, which has other work.
_POLL, _PATIENCE = 0.2, 5.0

_ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

# Of prctl(2) and capset(2): what a command leaves behind becomes a child of the server; a capability is dropped; the version.
_SUBREAPER, _DROP, _CAPABILITIES = 36, 24, 0x20080522


def _without_rights() -> None:
    """Let the rights of files hold for root, too."""
    if os.geteuid():
        return
    library = ctypes.CDLL(None, use_errno=True)
    for number in range(64):    # what no capability has is an error
        library.prctl(_DROP, number, 0, 0, 0)
    header = (ctypes.c_uint32 * 2)(_CAPABILITIES, 0)
    if library.capset(header, (ctypes.c_uint32 * 6)()):
        raise OSError(ctypes.get_errno(), "root's rights cannot be dropped")


def _limits() -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (_FILE, _FILE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (_PROCESSOR, _PROCESSOR))


def _redirect(request: Mapping[str, Any]) -> None:
    """Standard streams as the request has them: stdout a file, a full device, closed, or a pipe that nobody reads."""
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
    os.dup2(os.open(request["stderr"], flags), 2)
    kind = request["stdout_kind"]
    if kind == "pipe":
        read, write = os.pipe()
        os.close(read)
        os.dup2(write, 1)
    elif kind == "closed":
        os.close(1)
    else:
        os.dup2(os.open("/dev/full" if kind == "full" else request["stdout"], flags), 1)


def _streams(closed: bool) -> None:
    """Python's text streams, as it opens them at its start."""
    def text(number: int, name: str, **options: Any) -> io.TextIOWrapper:
        raw = io.FileIO(number, "rb" if number == 0 else "wb", closefd=False)
        raw.name = f"<{name}>"  # type: ignore[misc]
        return io.TextIOWrapper(io.BufferedReader(raw) if number == 0 else io.BufferedWriter(raw), encoding="utf-8", **options)

    sys.stdin = text(0, "stdin")
    sys.stdout = None if closed else text(1, "stdout")  # type: ignore[assignment]
    sys.stderr = text(2, "stderr", errors="backslashreplace", line_buffering=True)


def _child(request: Mapping[str, Any]) -> NoReturn:
    """Run the command of the request in this process, and end it."""
    status = 99
    try:
        os.setsid()
        for number in _ENDING:
            signal.signal(number, signal.SIG_DFL)
        _redirect(request)
        os.closerange(3, 256)
        os.environ.clear()
        os.environ.update(request["environment"])
        os.umask(0o022)
        _without_rights()
        os.chdir(request["folder"])
        _limits()
        words = [request["module"], *request["argv"]]
        if request["anew"]:
            signal.pthread_sigmask(signal.SIG_SETMASK, ())
            os.execv(sys.executable, [os.fsencode(word) for word in (sys.executable, "-W", "always", "-m", *words)])
        status = _body(request, words)
    except BaseException:
        traceback.print_exc()
        status = 1
    finally:
        with contextlib.suppress(BaseException):
            sys.stderr.flush()
        os._exit(status)


def _body(request: Mapping[str, Any], words: list[str]) -> int:
    """What ``python -m MODULE ARGV`` does once it has imported everything."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.argv, sys.orig_argv = ["-m"], [sys.executable, "-m", *words]
    guard_start()
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    sys.argv = words
    _streams(request["stdout_kind"] == "closed")
    warnings.resetwarnings()
    warnings.simplefilter("always")
    module, _, function = request["main"].partition(":")
    try:
        status = getattr(importlib.import_module(module), function)(words[1:])
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
    except BaseException:
        traceback.print_exc()
        status = 1
    atexit._run_exitfuncs()
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except BaseException:
        traceback.print_exc()
        status = 120    # as Python's own
    return int(status or 0)


def _left(session: int) -> list[tuple[int, str]]:
    """Processes of a session that are alive: numbers and names."""
    found = []
    for path in Path("/proc").iterdir():
        if path.name.isdigit():
            with contextlib.suppress(OSError, ValueError, IndexError):
                name, _, rest = (path / "stat").read_text().rpartition(")")
                state, _, _, its_session = rest.split()[:4]
                if int(its_session) == session and state not in "ZX":
                    found.append((int(path.name), name.partition("(")[2]))
    return found


def _processor(session: int) -> float:
    """Seconds of a processor that a session has had so far."""
    total = 0
    for number, _ in _left(session):
        with contextlib.suppress(OSError, ValueError):
            total += sum(map(int, Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[11:15]))
    return total / os.sysconf("SC_CLK_TCK")


def _ended(handle: int, pid: int, end: float, processor: float) -> bool:
    """Wait for a process; whether it has ended before the time ``end``, and before it had so many seconds of a processor."""
    while (rest := end - time.monotonic()) > 0:
        if select.select([handle], [], [], min(rest, _POLL))[0]:
            return True
        if _processor(pid) > processor:
            break
    return bool(select.select([handle], [], [], 0)[0])


def _clear(session: int, patience: float = 2.0) -> list[str]:
    """Names of the processes that a command has left, after some patience; they are killed."""
    end = time.monotonic() + patience
    while (left := _left(session)) and time.monotonic() < end:
        time.sleep(0.02)
    for number, _ in left:
        with contextlib.suppress(OSError):
            os.kill(number, signal.SIGKILL)
    return [name for _, name in left]


def _attend(pid: int, request: Mapping[str, Any]) -> dict[str, Any]:
    """Wait for a process, send it its signals, and tell how it ended."""
    start = time.monotonic()
    ended, sent = "itself", None
    number, seconds = request["signal"] or (signal.SIGTERM, request["limit"] * (1 if request["waits"] else _PATIENCE))
    handle = os.pidfd_open(pid)
    try:
        for how, each, wait, processor in (("signal" if request["signal"] else "limit", number, seconds, request["limit"]),
                                           ("killed", signal.SIGKILL, request["grace"] * _PATIENCE, request["limit"] + request["grace"])):
            if _ended(handle, pid, time.monotonic() + wait, processor):
                break
            ended, sent = how, int(number)
            signal.pidfd_send_signal(handle, each)
        else:
            select.select([handle], [], [])
    finally:
        os.close(handle)
    _, status, used = os.wait4(pid, 0)
    seconds = time.monotonic() - start
    left = _clear(pid)
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    return {"status": os.waitstatus_to_exitcode(status), "ended": ended, "sent": sent, "seconds": round(seconds, 3),
            "processor": round(used.ru_utime + used.ru_stime, 3), "left": left}


def serve() -> None:
    """Answer requests until stdin ends."""
    ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)
    for name in json.loads(sys.stdin.readline()):
        with contextlib.suppress(ImportError):      # of an extra that is not installed
            importlib.import_module(name)
    print("ready", flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        # Blocked in the child until its handlers are there.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, _ENDING)
        pid = os.fork()
        if not pid:
            _child(request)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        print(json.dumps(_attend(pid, request)), flush=True)


@contextlib.contextmanager
def server(modules: list[str]) -> Iterator[Any]:
    """Within the block a function that sends a request and returns its answer.

    Parameters
    ----------
    modules : list of str
        Imported once, before the first request.
    """
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "agg"}
    with started([sys.executable, "-m", "sim.verify.fuzz.server"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT,
                 env=environment) as process:
        assert process.stdin and process.stdout
        write, read = process.stdin, process.stdout

        def ask(document: Any) -> str:
            write.write(json.dumps(document) + "\n")
            write.flush()
            answer: str = read.readline()
            if not answer:
                raise RuntimeError("the process that runs the cases has ended")
            return answer

        ask(modules)
        yield lambda request: json.loads(ask(request))
        write.close()


if __name__ == "__main__":
    serve()

"""One case: a command, its arguments and files, how it is started and ended, and the faults that were found."""

import atexit
import contextlib
import functools
import os
import random
import shlex
import shutil
import signal
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..campaign import ROOT
from .arguments import Arguments
from .commands import BASES, Command, commands, documents_status_1, parser_of
from .judge import faults, look
from .server import server


__all__ = ["WAYS", "run_case"]


# Imported by functions of the commands when they are first needed.
_LATE = ("cv2", "dask", "distributed", "matplotlib.backends.backend_agg", "matplotlib.figure", "optuna", "ortools.graph.python.max_flow",
         "maxflow", "scipy.ndimage", "skimage.data", "serial")

# Seconds that a command has to end after its first signal.
_GRACE = 8.0

# Seconds that a command has where it may wait for what never comes: a named pipe without a writer.
_WAITS = 2.0

#: How a case is started and ended, of a hundred: as it is; sent a signal; Python started anew and sent one; stdout that is a full device, a
#: pipe that nobody reads, or closed.
WAYS = {"plain": 76, "signal": 12, "anew": 4, "full": 3, "pipe": 3, "closed": 2}

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_parser = functools.cache(parser_of)


@functools.cache
def _ask(modules: tuple[str, ...]) -> Callable[[Any], dict[str, Any]]:
    """The server of this process, started at the first case."""
    stack = contextlib.ExitStack()
    ask: Callable[[Any], dict[str, Any]] = stack.enter_context(server(list(modules)))
    atexit.register(stack.close)
    return ask


def _module(command: Command) -> str:
    return f"{command.module}.__main__" if Path(ROOT, *command.module.split("."), "__main__.py").exists() else command.module


@functools.cache
def _cache() -> str:
    """Folder where tools keep what they have compiled from WebAssembly, of this process."""
    folder = tempfile.mkdtemp(prefix="fuzz-cache-")
    atexit.register(shutil.rmtree, folder)
    return folder


def _environment(rng: random.Random, place: Path, arguments: Arguments) -> dict[str, str]:
    """A small environment; the user's is not the business of a seeded case."""
    kept = {name: os.environ[name] for name in ("PATH", "LD_LIBRARY_PATH") if name in os.environ}
    data = rng.choice(("", "benchmark", "sets", "nowhere", "left.png"))
    if data in ("benchmark", "sets"):
        arguments.sample(data)
    return {**kept, "HOME": str(place / "home"), "TMPDIR": str(place / "tmp"), "LC_ALL": "C.UTF-8", "PYTHONPATH": str(ROOT),
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "agg", "COLUMNS": rng.choice(("80", "20", "0", "x")),
            "STEREO_DATA": data or str(place / "absent"), "XDG_CACHE_HOME": _cache()}


def _delay(rng: random.Random) -> float:
    """Seconds, as many of a hundredth as of one."""
    return round(10 ** rng.uniform(-3, 0.3), 4)


def run_case(seed: int, number: int, only: str | None = None, keep: str | None = None,
             among: Sequence[Command] | None = None, way: str | None = None, grace: float = _GRACE) -> dict[str, Any]:
    """Run a case and judge it.

    Parameters
    ----------
    seed, number : int
        Of the campaign and of the case.
    only : str or None
        Name of the command; ``None``: any.
    keep : str or None
        Folder where the case's files are left.
    among : sequence of Command or None
        In place of all commands of the project.
    way : str or None
        One of :data:`WAYS`; ``None``: any.
    grace : float
        Seconds that the command has to end after its first signal.

    Returns
    -------
    dict
        ``command``, ``way``, ``status``, ``ended``, ``processor`` in seconds, ``given`` options and ``faults``, and if there are any the
        command ``line``.
    """
    rng = random.Random(f"{seed}/{number}")
    every = tuple(among or commands())
    chosen = rng.choices(every, [each.share for each in every])[0]
    if only is not None:
        chosen = next(each for each in every if each.name == only)
    parser = _parser(chosen)
    drawn = rng.choices([*WAYS], [*WAYS.values()])[0]
    way = way or drawn
    place = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        place.chmod(0o755)
        for name in ("work", "tmp", "home"):
            (place / name).mkdir()
        arguments = Arguments(rng, place / "work", rng.choice((0.7, 0.9, 0.97, 1.0)))
        argv = [*chosen.words, *arguments.line(parser, BASES.get(chosen.name, ()))]
        arguments.outputs.update({str(each.default) for each in parser._actions if isinstance(each.default, Path)}, {"build"})
        environment = _environment(rng, place, arguments)
        arguments.close()
        before = look(place / "work")
        anew, sent = way == "anew", None
        if way in ("signal", "anew"):
            sent = rng.choice(_SIGNALS), _delay(rng)
        answer = _ask((*sorted({_module(each) for each in every}), *(_LATE if among is None else ())))({
            "module": chosen.module, "main": f"{_module(chosen)}:main", "argv": argv, "folder": str(place / "work"),
            "environment": environment, "limit": _WAITS if arguments.waits else chosen.seconds, "waits": arguments.waits,
            "grace": grace, "signal": sent, "anew": anew,
            "stdout": str(place / "stdout"), "stderr": str(place / "stderr"),
            "stdout_kind": way if way in ("full", "pipe", "closed") else "file"})
        told = (place / "stderr").read_text(encoding="utf-8", errors="replace")
        found = faults(chosen.name, chosen.module, answer, told, place / "work", before, outputs=arguments.outputs, anew=anew,
                       long=chosen.long or arguments.waits, documented=documents_status_1(parser), stdout_kind=way)
        found += [f"left in TMPDIR: {path.name}" for path in (place / "tmp").iterdir()]
        if keep is not None:
            shutil.copytree(place, Path(keep) / f"{seed}-{number}", symlinks=True, ignore=_special, dirs_exist_ok=True)
        result = {"command": chosen.name, "way": way, "status": answer["status"], "ended": answer["ended"],
                  "processor": answer["processor"], "given": sorted(set(arguments.given)), "faults": found}
        if found or keep is not None:
            result["line"] = shlex.join(["python", "-m", chosen.module, *(each if len(each) < 300 else f"{each[:60]}..." for each in argv)])
        return result
    finally:
        for path in place.rglob("*"):
            if path.is_dir() and not path.is_symlink():
                path.chmod(0o755)
        shutil.rmtree(place)


def _special(folder: str, names: list[str]) -> list[str]:
    """What cannot be copied."""
    return [name for name in names if (path := Path(folder, name)).exists() and not (path.is_file() or path.is_dir())]

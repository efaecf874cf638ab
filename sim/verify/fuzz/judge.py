"""What a command must not do, from how it ended, what it said, and what it left in its folder."""

import hashlib
import io
import json
import os
import re
import signal
import stat
import warnings
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ..campaign import ROOT


__all__ = ["Seen", "faults", "look"]


#: What is at each path of a folder: its kind, and for a file a digest of its content.
Seen = dict[str, tuple[str, str]]

_TEMPORARY = re.compile(r"^\..*\.tmp$|^tmp|\.part$|~$")
_CRASH = re.compile(r"Traceback \(most recent|^\w*(?:Error|Exception|Warning): |\.py:\d+: \w*Warning|Exception ignored|Fatal Python error|"
                    r"Segmentation fault|core dumped|resource_tracker", re.MULTILINE)
# What a command may tell on stderr beside its sentence: notes, and stages of a simulation.
_TOLD = re.compile(r"note: |.* \.\.\.$")
_SENTENCES = {signal.SIGINT: "interrupted", signal.SIGTERM: "ended by SIGTERM", signal.SIGHUP: "ended by SIGHUP"}
_BROKEN_PIPE = 141
# How a file of a format ends.
_ENDS = {".svg": b"</svg>", ".html": b"</html>", ".pdf": b"%%EOF"}
# A traceback through a file of the project, other than those with which it begins, that set the handlers of signals.
_OURS = re.compile(rf'File "{re.escape(str(ROOT))}/(?!\.|\w+/__init__\.py|golden/errors\.py)')


def look(folder: Path) -> Seen:
    """What is in a folder and in all below it."""
    found: Seen = {}
    for path in sorted(folder.rglob("*")):
        name, mode = str(path.relative_to(folder)), path.lstat().st_mode
        if stat.S_ISLNK(mode):
            found[name] = "link", os.readlink(path)
        elif stat.S_ISREG(mode):
            try:
                found[name] = "file", hashlib.sha256(path.read_bytes()).hexdigest()
            except PermissionError:
                found[name] = "file", f"closed, of {path.lstat().st_size} bytes"
        else:
            found[name] = "folder" if stat.S_ISDIR(mode) else "other", ""
    return found


def _whole(path: Path) -> str:
    """Why a file is not whole; empty if it is, as far as its format tells."""
    data, suffix = path.read_bytes(), path.suffix.lower()
    try:
        if suffix in (".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".tif"):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with Image.open(io.BytesIO(data)) as picture:
                    picture.load()
            if suffix == ".png" and not data.endswith(b"IEND\xaeB`\x82"):
                return "no end"
        elif suffix == ".npy":
            np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
        elif suffix == ".pfm":
            _, size, _, samples = data.split(b"\n", 3)
            width, height = map(int, size.split())
            if len(samples) != 4 * width * height * (3 if data.startswith(b"PF") else 1):
                return f"{len(samples)} bytes of samples"
        elif suffix == ".json":
            json.loads(data)
        elif suffix in _ENDS and not data.rstrip().endswith(_ENDS[suffix]):
            return "no end"
        elif suffix == ".v" and len(re.findall(rb"^module\b", data, re.MULTILINE)) != len(re.findall(rb"^endmodule\b", data, re.MULTILINE)):
            return "a module without an end"
        elif suffix in (".md", ".txt", ".toml", ".yaml", ".v", ".tcl", ".csv", ".qsf") and not data.endswith(b"\n"):
            return "no end of the last line" if data else "it is empty"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def _of_output(name: str, outputs: Collection[str]) -> bool:
    return any(name == each or name.startswith(f"{each.rstrip('/')}/") or each in (".", "..") for each in outputs)


def _files(folder: Path, before: Seen, after: Seen, status: int, outputs: Collection[str]) -> list[str]:
    """Faults of the files that were left."""
    found = []
    for name, seen in after.items():
        if seen == before.get(name):
            continue
        path = folder / name
        if _TEMPORARY.search(path.name):
            found.append(f"temporary left: {name}")
        elif seen[0] == "file":
            if status in (1, 2):
                found.append(f"{'changed' if name in before else 'written'} though it failed: {name}")
            elif name in before and not _of_output(name, outputs):
                found.append(f"changed, and no output: {name}")
            elif why := _whole(path):
                found.append(f"not whole: {name}, {why}")
        elif name in before:
            found.append(f"{before[name][0]} became {seen[0]}: {name}")
    found += [f"removed: {name}" for name in before if name not in after and (status or not _of_output(name, outputs))]
    return found


def _said(told: str, name: str, module: str, status: int, sentence: str, stdout_kind: str) -> list[str]:
    """Faults of what is on stderr; ``sentence``: how it must be worded, if only one is possible."""
    lines = told.splitlines()
    own = [line for line in lines if not _TOLD.match(line)]
    if sentence and len(own) == 2 and own[0].startswith(f"{name}: "):
        own = own[1:]       # the signal met a command that had just ended with its own sentence
    # At its start a command has the name of its module; `python -m golden` hands on to another command.
    handed_on = "" if " " in name else "( [a-z]+)?"
    named = rf"({re.escape(name)}{handed_on}|{re.escape(module)}): " if sentence else rf"{re.escape(name)}{handed_on}: "
    found = []
    if _CRASH.search(told):
        found.append(f"stderr: {' | '.join([*lines[:1], *lines[-2:]])[:400]}")
    elif status == 0 and not sentence:
        # Without a stdout Python's help goes to stderr.
        helped = stdout_kind == "closed" and own[:1] and own[0].startswith("usage: ")
        found += [f"said at success: {line[:200]}" for line in own if not line.startswith(f"{name}: warning") and not helped]
    elif len(own) != 1 or not lines or lines[-1] != own[0]:
        found.append(f"{len(own)} sentences on stderr, not 1: {' | '.join(own)[:300]}")
    elif not re.match(named, own[0]):
        found.append(f"the sentence does not begin with {name}: {own[0][:200]}")
    elif sentence and own[0].partition(": ")[2] != sentence:
        found.append(f"the sentence is not {sentence!r}: {own[0][:200]}")
    elif status == 2 and not re.search(r"; \S", own[0]):
        found.append(f"the sentence names no remedy: {own[0][:300]}")
    return found


def _ending(answer: Mapping[str, Any], told: str, anew: bool, allowed: Collection[int], long: bool) -> tuple[list[str], str | None]:
    """Faults of the exit status, and the sentence that goes with it: ``None`` if there is none, empty if it may have any words."""
    status, sent = answer["status"], answer["sent"]
    if answer["ended"] == "killed":
        return [f"did not end within its time after signal {int(sent)} was needed"], None
    late = [] if answer["ended"] != "limit" or long else [f"took {answer['seconds']:.1f} s"]
    if sent is not None and status == 128 + sent:
        return late, _SENTENCES[signal.Signals(sent)]
    if sent is not None and anew and not _OURS.search(told) and (status == -sent or (sent == signal.SIGINT and status == 1)):
        return late, None       # Python had not come to the project's code
    if status in (0, 2) or status in allowed:
        return late, ""
    return [*late, f"status {status}"], None


def faults(name: str, module: str, answer: Mapping[str, Any], told: str, folder: Path, before: Seen, *, outputs: Collection[str],
           anew: bool, long: bool, documented: bool, stdout_kind: str) -> list[str]:
    """Faults of a case, a sentence each.

    Parameters
    ----------
    name : str
        Of the command, as its sentence begins.
    module : str
        What ``python -m`` runs.
    answer : mapping
        Of :func:`sim.verify.fuzz.server.server`.
    told : str
        What is on stderr.
    folder : Path
        Of the case; ``before`` is what was in it, ``outputs`` names what the command may write.
    anew : bool
        Whether Python was started anew, so that a signal may have met it before it ran the command.
    long : bool
        Whether the command may compute for longer than it had time.
    documented : bool
        Whether its help tells what status 1 is.
    stdout_kind : str
        ``full``, ``pipe`` or ``closed`` where stdout is a full device, a pipe that nobody reads, or closed; else any other word.
    """
    allowed = [1] * documented + [_BROKEN_PIPE] * (stdout_kind == "pipe")
    found, sentence = _ending(answer, told, anew, allowed, long)
    status = answer["status"]
    if status == _BROKEN_PIPE and stdout_kind == "pipe":
        sentence = None
    if sentence is not None:
        found += _said(told, name, module, status, sentence, stdout_kind)
    elif _CRASH.search(told) and (not anew or _OURS.search(told)):
        found.append(f"stderr: {told.strip()[-400:]}")
    # What is printed last may fail after all is written.
    files = 0 if stdout_kind in ("full", "pipe", "closed") else status
    found += _files(folder, before, look(folder), files, outputs)
    found += [f"process left: {each}" for each in answer["left"]]
    return found

"""The comment at the top of every delivered Verilog file: what it is, and how it is made again."""

import importlib.metadata
import shlex
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any


__all__ = ["command_line", "header"]


_WIDTH = 110


def command_line(argv: Sequence[str]) -> str:
    """The command that makes the same files, from its arguments, into the default folder: where files lie is not part of them.

    Examples
    --------
    >>> command_line(["--core", "--output", "/tmp/x", "--rig", "my rig", "--output=y"])
    "python -m hdl.build --core --rig 'my rig'"
    """
    kept = [word for word, before in zip(argv, ["", *argv]) if before != "--output" and word.partition("=")[0] != "--output"]
    return f"python -m hdl.build {shlex.join(kept)}"


def _facts(values: Mapping[str, Any]) -> list[str]:
    """Parameters as ``name = value``; those of a group with its name in front."""
    told = []
    for name, value in values.items():
        if isinstance(value, Mapping):
            told += [f"{name}.{fact}" for fact in _facts(value)]
        else:
            told.append(f"{name} = {' '.join(map(str, value)) if isinstance(value, list | tuple) else value}")
    return told


def header(file: str, version: str, command: str, manifest: Mapping[str, Any], latency: tuple[int, int]) -> str:
    """Lines of comment, the same for the same arguments.

    Parameters
    ----------
    file : str
        Name of the file.
    version : str
        Of this project.
    command : str
        From :func:`command_line`.
    manifest : mapping
        Of the build: its ``parameters``, ``engine``, ``clocks_per_pixel`` and ``full_rate_width`` are told.
    latency : tuple of int
        Lines, and clocks beyond them.
    """
    parameters = manifest["parameters"]
    board = f", on the board {manifest['board']}" if "board" in manifest else ""
    what = f"method {parameters['method']}, {manifest['engine']} engine, {parameters['disparities']} disparities{board}"
    lines = [
        f"{file}: stereo matcher, {what}.",
        f"stereo-graph-cut {version}; made by:",
        f"    {command}",
        f"SPDX-License-Identifier: {importlib.metadata.metadata('stereo-graph-cut')['License-Expression']}",
        "",
        *textwrap.wrap(f"Parameters: {', '.join(_facts(parameters))}.", _WIDTH, subsequent_indent="    ", break_long_words=False),
        f"Clocks a pixel: {manifest['clocks_per_pixel']}. A line of fewer than {manifest['full_rate_width']} pixels takes as long as that.",
        f"Latency: at most {latency[0]} lines and {latency[1]} clocks.",
    ]
    return "".join(f"// {line}".rstrip() + "\n" for line in lines) + "\n"

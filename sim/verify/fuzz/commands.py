"""The commands of the project, found by what they are, and their parsers, as they make them."""

import argparse
import functools
import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple
from unittest import mock

from ..campaign import ROOT


__all__ = ["BASES", "LEFT_OUT", "Command", "commands", "documents_status_1", "main_of", "parser_of"]


_PACKAGES = ("golden", "hdl", "boards", "sim")
_RUNS = re.compile(r"^if __name__ == .__main__.:", re.MULTILINE)

#: Commands that are not fuzzed, and why.
LEFT_OUT = {
    "sim.verify": "it would start this campaign and others, which take hours",
}

_PAIR = "left.png right.png --disparities 4"
_SMALL = "--width 8 --height 4 --disparities 4"

#: Arguments with which a command does its work on the samples, from which a part of its cases begin: what options mean together, a parser
#: does not tell. Names of samples are replaced by hostile files, numbers by hostile ones; any options are added.
BASES = {
    "golden": (
        "data --check benchmark",
        "--help",
    ),
    "golden match": (
        f"{_PAIR} --output new.npy",
        f"{_PAIR} --method fused --output new.png --passed old.png --confidence new.pgm",
        f"{_PAIR} --method recursive --sub-pixel --output new.pfm --colour new.ppm",
        f"{_PAIR} --output new.txt --truth truth.pfm --mask mask.png",
        f"{_PAIR} --output new.png --png-scale 256 --minimum 1",
        f"{_PAIR} --output new.pgm --rig calibrated --balance",
        f"{_PAIR} --output new.npy --depth new.ply --calib calib.txt",
        f"{_PAIR} --output new.npy --depth new.png --calib kitti.txt --kitti-cameras 2,3",
        f"{_PAIR} --output new.npy --depth new.pfm --calib ros_left.yaml --calib ros_right.yaml",
        f"{_PAIR} --output new.npy --depth new.npy --calib projections.yml --baseline-unit cm",
        f"{_PAIR} --output new.npy --depth new.npy --focal 30 --baseline 2",
        f"{_PAIR} --output new.npy --sheet new.png",
        "left_16.png right_16.png --white 1023 --disparities 4 --output old.npy --method fused --parameters fused.toml",
    ),
    "golden calibrate": (
        "intrinsics.yml extrinsics.yml --size 24x16 --baseline-unit mm --output new",
        "camchain.yaml --output old",
        "stereo.yml --size 24x16 --baseline-unit cm --output new --rectify-lines 22 --flat left.png right.png",
    ),
    "golden boards": (
        "left.png right.png --rig calibrated --board 9x6 --methods fused",
    ),
    "golden cameras": (
        "--data sets --methods fused-1 --json new.json",
        "--data sets/one --methods one-pass-linear",
    ),
    "golden evaluate": (
        "--data sets --json old.json",
        "--data benchmark --method fused --sub-pixel --json new.json",
        "--data sets/one --arithmetic linear --noise 2 --threshold 0.5",
    ),
    "golden data": (
        "--check benchmark",
    ),
    "golden sparsification": (
        "--data benchmark --output new.svg",
    ),
    "golden rivals": (
        "--data sets --methods one-pass-linear --workers 1 --output new.json",
        "--data sets --methods opencv-bm --workers 1",
    ),
    "golden gaps": (
        "--data sets --every 4 --json new.json --output new.png",
    ),
    "golden compare": (
        f"{_PAIR} --scenes --methods fused-1 --output new.png",
        f"{_PAIR} --scenes --methods one-pass-linear --truth truth.png",
        "--data sets --scenes --methods one-pass-linear --output old.pdf",
    ),
    "golden thesis": (
        "--data benchmark --quick --output new --workers 1",
    ),
    "golden tune": (
        "--train sets --test benchmark/tsukuba --trials 2 --workers 1 --output new.toml",
        "--train sets --test scenes --trials 1 --workers 1 --output new.toml --method recursive --start recursive.toml",
    ),
    "golden.host.register_page": (
        "--output new.md",
        "--output old.md --loop",
    ),
    "golden.lab.bench": (
        f"{_SMALL} --plain-rows 2 --arithmetic linear",
    ),
    "golden.lab.pairing_bench": (
        "--hours 0.01 --ppm 10",
    ),
    "hdl.build": (
        f"--core {_SMALL} --output new",
        f"--core {_SMALL} --method fused --interface axi --package registers,vivado --output old",
        f"--core {_SMALL} --interface avalon --package quartus --name eye --output new",
        f"--core {_SMALL} --rectify --output new",
        f"--board ulx3s --no-bitstream {_SMALL} --output new",
        "--board cyclone3 --output new --rig calibrated",
    ),
    "hdl.host.console": (
        "list",
        "--port port list",
        "--port left.png get labels",
        "--port null set u1=3",
        "--port port rectify calibrated",
        "--port port grab left new.png",
        "--port port calibrate --board 9x6 --square 25 --output new --pairs 9",
    ),
    "hdl.resources": (
        f"--estimate {_SMALL} --json new.json",
        f"--estimate {_SMALL} --method fused --parameters fused.toml --json old.json",
    ),
    "hdl.resources.tables": (
        "--output new.md --clock clock.json",
    ),
    "sim.bench": (
        f"{_SMALL} --simulator icarus",
    ),
    "sim.demo": (
        "--reduce 8 --simulator icarus --output new",
    ),
    "sim.evaluate": (
        "--data benchmark --pairs tsukuba --simulator icarus --json new.json",
    ),
    "sim.loop": (
        _SMALL,
    ),
    "sim.run": (
        f"{_PAIR} --simulator icarus --output new",
        f"{_PAIR} --simulator icarus --output old --method fused --waves",
        f"{_PAIR} --hardware port --output new",
    ),
    "sim.system": (
        "--frames 1 --output new",
        "left.png right.png --output new",
    ),
}

# Seconds of a processor that a command has, if it may take longer by nature; then it is ended by SIGTERM, which it must obey. Those that
# write Verilog or simulate need some to come to their end at all.
_SECONDS = {
    **dict.fromkeys(("golden", "golden match", "golden boards", "golden calibrate", "golden cameras", "golden evaluate",
                     "golden sparsification", "golden rivals", "golden gaps", "golden compare", "golden thesis", "golden tune",
                     "golden.lab.bench", "golden.lab.pairing_bench", "hdl.resources.tables", "sim.bench", "sim.demo",
                     "sim.loop", "sim.system"), 2.0),
    **dict.fromkeys(("hdl.build", "hdl.resources", "sim.evaluate"), 5.0), "sim.run": 8.0,
}

# Of the others: more than they ever need.
_ENOUGH = 20.0

# Of a hundred cases or so; others have one share each. Those whose inputs are files of others have most.
_SHARES = {"golden match": 8, "golden calibrate": 5, "hdl.build": 4, "golden evaluate": 3, "golden compare": 2, "hdl.host.console": 2,
           "sim.run": 2, "golden cameras": 2, "golden tune": 2, "golden boards": 2}


class Command(NamedTuple):
    """A command line.

    Members
    -------
    name : str
        What its sentence on stderr begins with.
    module : str
        What ``python -m`` runs.
    words : tuple of str
        Arguments that name the command within the module.
    share : int
        Of the cases.
    seconds : float
        Of a processor, after which a case is ended by SIGTERM.
    long : bool
        Whether it may compute for longer than that.
    """
    name: str
    module: str
    words: tuple[str, ...] = ()
    share: int = 1
    seconds: float = _ENOUGH
    long: bool = False


class _Taken(BaseException):
    """Carries a parser out of the command that was about to use it."""
    def __init__(self, parser: argparse.ArgumentParser):
        super().__init__()
        self.parser = parser


def main_of(command: Command) -> Callable[[Sequence[str]], int]:
    """The function behind the command; it takes the arguments after ``words``."""
    package = Path(ROOT, *command.module.split("."), "__main__.py").exists()
    main = importlib.import_module(f"{command.module}.__main__" if package else command.module).main
    return lambda argv: main([*command.words, *argv])


def parser_of(command: Command) -> argparse.ArgumentParser:
    """The parser that the command makes: taken from it as it begins to parse."""
    before = list(command.words)    # each of these is parsed by a parser of its own
    parse = argparse.ArgumentParser.parse_args

    def take(parser: argparse.ArgumentParser, args: Sequence[str] | None = None, namespace: None = None) -> argparse.Namespace:
        if before:
            before.pop()
            return parse(parser, args, namespace)
        raise _Taken(parser)

    try:
        with mock.patch.object(argparse.ArgumentParser, "parse_args", take):
            main_of(command)([])
    except _Taken as taken:
        return taken.parser
    raise ValueError(f"{command.name} has not parsed its arguments")


def documents_status_1(parser: argparse.ArgumentParser) -> bool:
    """Whether a command's help tells what exit status 1 means."""
    return re.search(r"\bstatus\s+1\b", f"{parser.description} {parser.epilog}") is not None


@functools.cache
def commands() -> tuple[Command, ...]:
    """All commands: modules that run as programs, and the commands within ``python -m golden``."""
    files = sorted(path for package in _PACKAGES for path in (ROOT / package).rglob("*.py"))
    modules = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__main__") for path in files
               if _RUNS.search(text := path.read_text(encoding="utf-8")) and "run_cli(" in text]
    found = [Command(module, module) for module in modules if module not in LEFT_OUT]
    within = importlib.import_module("golden.__main__").COMMANDS
    found += [Command(f"golden {word}", "golden", (word,)) for word in within]
    return tuple(each._replace(share=_SHARES.get(each.name, 1), seconds=_SECONDS.get(each.name, _ENOUGH), long=each.name in _SECONDS)
                 for each in found)

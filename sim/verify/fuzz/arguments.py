"""Arguments for a command, sound and hostile, as its parser describes them: a new option is given without a change here."""

import argparse
import random
import re
from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from .hostile import NUMBERS, ODD_INPUTS, ODD_OUTPUTS, damaged, make_odd, odd_name
from .samples import samples


__all__ = ["Arguments", "options_of"]


# An option whose help says so is a file to be written.
_WRITES = re.compile(r"\b(write|writes|draw|results|Markdown)\b|^disparities as colours|^depth =|side by side|left-right check passed|"
                     r"^confidence of", re.IGNORECASE)

# Words of a help, and the samples that are meant; the first that is found decides.
_KINDS = (
    (r"rig\.json|golden calibrate", r"rig\.json|calibrated"), (r"number in --truth|true disparities", r"truth.*"),
    (r"pixels of level 255", r"mask.*"), (r"camera_info", r"calib\.txt|kitti\.txt|projections\.yml|ros_.*"),
    (r"golden tune wrote|to start from", r".*\.toml"), (r"camchain", r"(left|right).*|(intr|extr).*|camchain.*|stereo\.yml"),
    (r"intrinsics", r"intrinsics\.yml"), (r"--json JSON", r"clock\.json"), (r"^page of", r"page\.md"),
    (r"golden calibrate", r"calibrated|rig\.json"), (r"left picture|LEFT", r"left.*"), (r"right picture", r"right.*"),
    (r"picture", r"(left|right).*"), (r"folder|pairs|see docs/data", r"sets|sets/one|benchmark"),
)

_SUFFIX = re.compile(r"\.(?:npy|png|pgm|pfm|txt|ppm|jpe?g|svg|pdf|json|md|toml|ply)\b")
_RANGE = re.compile(r"(-?[\d.]*\d)(?: to | \.\. )(-?[\d.]*\d)")
_JUNK = ("", "x", "ü", "\udcff", "-", "--", "=", "a\nb", "%s", "{}", "../..", "9" * 400, "a" * 70_000, "None", "🂡", "\x1b[31m", "é" * 300)
_ODDS = 0.22


def options_of(parser: argparse.ArgumentParser) -> list[str]:
    """Names of all options and positional arguments, with those of subcommands."""
    found = []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            found += [f"{word} {name}" for word, each in action.choices.items() for name in options_of(each)]
        elif action.help is not argparse.SUPPRESS and not isinstance(action, argparse._HelpAction):
            found.append(_name(action))
    return found


def _name(action: argparse.Action) -> str:
    return action.option_strings[0] if action.option_strings else str(action.metavar or action.dest)


class Arguments:
    """Makes the arguments of one case, and the files that they name.

    Parameters
    ----------
    rng : random.Random
    folder : Path
        The working folder of the case, empty.
    sound : float
        Probability that an argument is what the command expects.

    Members
    -------
    given : list of str
        The options that were given, as of :func:`options_of`.
    outputs : set of str
        Names of the files and folders that the command may write.
    waits : bool
        Whether a command that reads what it was given waits for ever.
    """
    def __init__(self, rng: random.Random, folder: Path, sound: float):
        self.rng, self.folder, self.sound = rng, folder, sound
        self.given: list[str] = []
        self.outputs: set[str] = set()
        self.waits = False
        self._closed: list[tuple[Path, int]] = []

    def _ok(self) -> bool:
        return self.rng.random() < self.sound

    # ---- files

    def _put(self, name: str, data: bytes) -> None:
        path = self.folder / name
        if path.is_symlink() or path.exists():      # what an argument before needs
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)

    def sample(self, name: str) -> str:
        """Write a sample, or all of a folder of them; now and then one file of it is damaged."""
        files = {each: data for each, data in samples().items() if each == name or each.startswith(f"{name}/")}
        broken = None if self._ok() else self.rng.choice(sorted(files))
        for each, data in files.items():
            self._put(each, damaged(each, data, self.rng) if each == broken else data)
        return name

    def input(self, told: str) -> str:
        """Name of a file or folder that is read, by what a help says of it."""
        every = [*samples(), *{name.partition("/")[0] for name in samples() if "/" in name}, "sets/one"]
        pattern = next((kind for words, kind in _KINDS if re.search(words, told)), ".*") if self._ok() else ".*"
        name = self.rng.choice(sorted(each for each in every if re.fullmatch(pattern, each) and each != "left.bmp"))
        if self._ok():
            return self.sample(name)
        kind = self.rng.choice(ODD_INPUTS)
        data = samples().get(name, b"x")
        if kind == "absent" or self.rng.random() < 0.5:     # a damaged file
            suffix = PurePosixPath(name).suffix
            self._put(f"damaged{suffix}", damaged(name, data, self.rng))
            return f"damaged{suffix}"
        return self._odd(kind, PurePosixPath(name).suffix, data)

    def output(self, told: str, folder: bool) -> str:
        """Name of a file or folder that is written; what is there before, is kept if the command fails."""
        found = _SUFFIX.findall(told)
        suffix = "" if folder else self.rng.choice(found or [".png", ".json", ".npy", ".txt"])
        if self._ok() or self._ok():
            name = self.rng.choice(("new", "out/new", "old"))
            if name == "old" and not folder:
                self._put(f"old{suffix}", b"what was here before\n")
            elif name == "out/new":
                (self.folder / "out").mkdir(exist_ok=True)
            elif name == "old":
                self._put("old/manifest.json", b'{"files": ["mine.txt"]}\n')
                self._put("old/mine.txt", b"what was here before\n")
            name += suffix
        else:
            name = self._odd(self.rng.choice(ODD_OUTPUTS), suffix, b"what was here before\n")
        self.outputs.add(name)
        return name

    def _odd(self, kind: str, suffix: str, data: bytes) -> str:
        name = odd_name(kind, suffix)
        path = self.folder / name
        try:
            make_odd(kind, path, data)
        except OSError:     # an argument before made something else of that name
            return "absent"
        self.waits |= kind == "fifo"
        if kind in ("closed_folder", "read_only_folder"):
            self._closed.append((path.parent, 0 if kind == "closed_folder" else 0o555))
        return name

    def close(self) -> None:
        """Take the rights to folders: the last step before the command runs."""
        for path, mode in self._closed:
            path.chmod(mode)

    # ---- words

    def _number(self, action: argparse.Action, told: str) -> str:
        if not self._ok():
            return self.rng.choice(NUMBERS)
        found = _RANGE.search(told)
        default = action.default if isinstance(action.default, int | float) else 1
        low, high = (float(found[1]), float(found[2])) if found else (min(default, 1), default + 3)
        if self.rng.random() < 0.15:
            value = self.rng.choice((low, high, low - 1, high + 1, default))
        else:   # small, so that it is computed soon
            value = self.rng.uniform(max(low, 0), min(high, max(low, 0) + self.rng.choice((3, 16))) + 0.99)
        return f"{value:.3f}".rstrip("0").rstrip(".") if action.type is float and self.rng.random() < 0.5 else str(int(value))

    def _word(self, action: argparse.Action, told: str) -> str:
        if not self._ok():
            return self.rng.choice((*_JUNK, *NUMBERS, self.input(told), told[:20]))
        metavar = str(action.metavar or "")
        words = [word for word in metavar.split("|") if not word.isupper()] if "|" in metavar else []
        if action.choices:
            words = [str(each) for each in action.choices]
        elif re.fullmatch(r"\d+x\d+|[\w.]+=[\w.]+", metavar):
            words = [metavar]
        elif not words:
            words = re.findall(r"\b(?:[a-z]+[-\w]*|\d+x\d+|\d+)\b", told) or ["x"]
            default = action.default
            words += [str(default)] * (default is not None) * len(words)
        return self.rng.choice(words)

    def value(self, action: argparse.Action) -> str:
        """A value of an option."""
        told = f"{action.help or ''}"
        if action.type in (int, float):
            return self._word(action, told) if action.choices and self._ok() else self._number(action, told)
        places = action.type is Path or (action.metavar in ("PLACE", "LEFT RIGHT") or ("picture" in told and action.choices is None))
        if not places:
            return self._word(action, told)
        metavar = str(action.metavar or "")
        named = [word for word in metavar.split("|") if not word.isupper()] if "|" in metavar else []
        if named and self.rng.random() < 0.6:
            return self.rng.choice(named)
        writes = action.dest in ("output", "cache")
        writes |= _WRITES.search(told) is not None and not re.search(r"golden tune wrote|hdl.resources --", told)
        if not self._ok() and self._ok():
            writes = not writes
        left_right = isinstance(action.metavar, tuple)
        return self.output(f"{told} {'' if _SUFFIX.search(told) else '.npy .png .txt'}", "DIR" in metavar) if writes else \
            self.input("picture" if left_right else f"{told} {metavar}")

    def _values(self, action: argparse.Action) -> list[str]:
        counts: dict[object, Sequence[int]] = {None: (1,), "?": (0, 1, 1, 1), "*": (0, 2, 2, 1), "+": (1, 1, 2, 2, 16)}
        counts = {**counts, 0: (0,)}
        count = self.rng.choice(counts.get(action.nargs, (action.nargs if isinstance(action.nargs, int) else 1,)))
        if not self._ok() and action.nargs != 0:
            count += self.rng.choice((-1, 1))
        return [self.value(action) for _ in range(max(0, count))]

    def _from(self, base: str, parser: argparse.ArgumentParser) -> list[str]:
        """A base with some of its words replaced, and some options added."""
        places = [*samples(), *(name.rpartition("/")[0] for name in samples() if "/" in name), "benchmark", "sets"]
        words = []
        for word in base.split():
            stem, _, suffix = word.partition(".")
            if word in places:
                words.append(self.sample(word) if self._ok() else self.input(word))
            elif stem in ("new", "old"):
                words.append(self.output(f".{suffix}", not suffix))
            elif word.isdigit() and not self._ok():
                words.append(self.rng.choice(NUMBERS))
            elif not word.startswith("-") and not self._ok() and not self._ok():
                words.append(self.rng.choice(_JUNK))
            else:
                words.append(word)
        self.given += [_name(each) for each in parser._actions if {*each.option_strings} & {*words} or not each.option_strings]
        optional = [each for each in parser._actions if each.option_strings and not {*each.option_strings} & {*words}
                    and not isinstance(each, argparse._HelpAction) and each.help is not argparse.SUPPRESS]
        for action in self.rng.sample(optional, min(len(optional), self.rng.choice((0, 0, 1, 1, 2, 3)))):
            self.given.append(_name(action))
            words += [self.rng.choice(action.option_strings), *self._values(action)]
        return words

    def line(self, parser: argparse.ArgumentParser, bases: Sequence[str] = (), prefix: str = "") -> list[str]:
        """The arguments, from one of the bases now and then."""
        if bases and self.rng.random() < 0.6:
            return self._from(self.rng.choice(bases), parser)
        parts: list[list[str]] = []
        tail: list[str] = []
        required = self._required(parser)
        hidden = self.rng.random() < 0.1
        optional = [each for each in parser._actions if each not in required and not isinstance(each, argparse._HelpAction)
                    and (each.help is not argparse.SUPPRESS or hidden)]
        chosen = self.rng.sample(optional, min(len(optional), self.rng.choice((0, 1, 1, 2, 2, 3, 4, 6))))
        for action in [*required, *chosen]:
            if action in required and not self._ok() and not self._ok():
                continue
            if isinstance(action, argparse._SubParsersAction):
                word = self.rng.choice([*action.choices])
                tail = [word, *self.line(action.choices[word], prefix=f"{word} ")] if self._ok() or self._ok() else [self.rng.choice(_JUNK)]
                continue
            values = self._values(action)
            self.given.append(prefix + _name(action))
            if action.option_strings:
                option = self.rng.choice(action.option_strings)
                glued = len(values) == 1 and self.rng.random() < 0.15
                parts.append([f"{option}={values[0]}"] if glued else [option, *values])
            else:
                tail += values
        if not self._ok() and self.rng.random() < 0.3:
            parts.append([self.rng.choice(("--unknown", "--help", "--", "-h", "--out", *_JUNK))])
        self.rng.shuffle(parts)
        ahead = self.rng.random() < 0.5
        # Behind an option that takes any number of values a positional argument would be one of these.
        flat = [word for part in parts for word in part]
        return [*tail, *flat] if ahead and not isinstance(parser._subparsers, argparse._ArgumentGroup) else [*flat, *tail]

    def _required(self, parser: argparse.ArgumentParser) -> list[argparse.Action]:
        """Actions without which nothing begins: those that the parser requires, one of each group, positional arguments mostly."""
        required = [each for each in parser._actions if each.required]
        required += [self.rng.choice(group._group_actions) for group in parser._mutually_exclusive_groups if group.required]
        positional = [each for each in parser._actions if not each.option_strings and each not in required]
        return required + (positional if self.rng.random() < 0.8 else [])

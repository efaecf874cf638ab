"""Cases drawn by number: the same number gives the same case."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from golden.config import METHODS, WEIGHT_MAX, Arithmetic, MatcherConfig, Setting, Weights, parameters_of, value_of

from .case import Case, CaseFrame
from .trees import unreachable, winners


__all__ = ["ICARUS", "draw", "discriminates"]


#: The cases with numbers below this are small, for Icarus.
ICARUS = 40

# Methods and engines of twenty cases, and of twenty for Icarus: a build of the first ones takes a quarter of one of the last ones.
_KINDS: Sequence[tuple[tuple[str, str], int, int]] = (
    (("thesis", "sequential"), 7, 10), (("thesis", "streaming"), 5, 6), (("fused", "streaming"), 5, 3), (("recursive", "streaming"), 3, 1))

# Parameters that the gateware grows with: most cases draw them from the first ones, and those for Icarus from the others.
_MODEST: Mapping[str, range] = {"reach": range(7), "census_rows": range(1, 6, 2), "census_columns": range(1, 8, 2), "fan": range(3, 9)}
_LEAST: Mapping[str, range] = {"reach": range(4), "census_rows": range(1, 4, 2), "census_columns": range(1, 6, 2), "fan": range(3, 5)}

# Probabilities of a stall, and most further clocks of one. A burst is longer than queues between stages hold.
_STALLS = ((0.0, 0), (0.1, 0), (0.5, 0), (0.9, 0), (0.03, 60))

_TRIES = 200


class _Draw:
    """Draws from ``random``; of its methods each takes what it draws from."""
    def __init__(self, random: np.random.Generator, small: bool):
        self.random = random
        self.small = small

    def one(self, values: Sequence[Any], weights: Sequence[float] | None = None) -> Any:
        total = None if weights is None else np.divide(weights, sum(weights))
        return values[int(self.random.choice(len(values), p=total))]

    def chance(self, probability: float) -> bool:
        return bool(self.random.random() < probability)

    def number(self, allowed: range) -> int:
        """One of them: the least and the greatest more often than the others."""
        if self.chance(0.25):
            return int(self.one((allowed[0], allowed[-1])))
        return int(allowed[int(self.random.integers(len(allowed)))])

    def parameters(self, kind: Any, engine: str) -> dict[str, Any]:
        """Values of the method's parameters, some of which keep their defaults."""
        limits = {**dict.fromkeys(Weights._fields, range(WEIGHT_MAX + 1)), "fraction_bits": getattr(kind, "FRACTION_BITS", range(0)),
                  **getattr(kind, "LIMITS", {})}
        values: dict[str, Any] = {}
        for name in parameters_of(kind()):
            default = value_of(kind(), name)
            if name in _MODEST and (self.small or self.chance(0.85)):
                values[name] = self.number((_LEAST if self.small else _MODEST)[name])
            elif isinstance(default, Arithmetic):
                formats = [each for each in Arithmetic if self._has_engine(kind, name, each, engine)]
                values[name] = str(self.one(formats))
            elif isinstance(default, bool):
                values[name] = self.chance(0.5)
            elif name in limits and self.chance(0.35):
                values[name] = self.number(limits[name])
        return {name: value for name, value in values.items() if value != value_of(kind(), name)}

    @staticmethod
    def _has_engine(kind: Any, name: str, value: Arithmetic, engine: str) -> bool:
        return value is not Arithmetic.FLOAT and engine in kind(**{name: value}).engines

    def setting(self, setting: Setting, name: str, labels: int) -> int:
        return self.number(range(setting.minimum, (labels if name == "in_use" else setting.maximum) + 1))

    def settings(self, config: MatcherConfig) -> dict[str, int]:
        """Values of some of the settings."""
        share = self.random.random()
        return {name: self.setting(setting, name, config.labels) for name, setting in config.settings.items() if self.chance(share)}

    def stalls(self) -> dict[str, Any]:
        (stall_i, burst_i), (stall_o, burst_o) = self.one(_STALLS), self.one(_STALLS)
        return {"stall_i": stall_i, "stall_o": stall_o, "burst_i": burst_i, "burst_o": burst_o}

    def sizes(self) -> tuple[int, int, int]:
        """Labels, greatest width, greatest height; one case in eight has lines shorter than its disparities."""
        if self.small:
            labels = int(self.random.integers(2, 7))
        elif self.chance(0.04):
            labels = int(self.random.integers(25, 61))
        else:
            labels = int(self.one((2, 3, self.random.integers(4, 9), self.random.integers(9, 25)), (1, 1, 4, 3)))
        if self.chance(0.125):
            return labels, int(self.random.integers(1, labels + 1)), int(self.random.integers(1, 9))
        width = int(self.random.integers(labels + 3, max(2 * labels + 8, 16 if self.small else 48)))
        return labels, width, int(self.random.integers(3, 6 if self.small else 25))

    def frames(self, config: MatcherConfig, width: int, height: int) -> tuple[CaseFrame, ...]:
        """Two to five frames: the first ones show all labels with the settings that were built in, the others have other settings."""
        labels = config.labels
        lines = max(height, 2)
        shown = self.one(("steps", "bands"))
        start = int(self.random.integers(1000)) * labels
        whole = 1 if shown == "steps" else min(-(-labels // lines), 3)
        frames = [CaseFrame(width, lines, shown, start + number * lines, **self.stalls()) for number in range(whole)]
        for _ in range(int(self.random.integers(1, 4))):
            frames.append(CaseFrame(
                self.number(range(1, width + 1)), self.number(range(1, height + 1)),
                self.one(("steps", "bands", "noise", "even"), (3, 3, 2, 1)), int(self.random.integers(1000)),
                self.settings(config) if self.chance(0.75) else None, **self.stalls()))
        return tuple(frames)

    def case(self, name: str, engine: str) -> Case:
        """Of this method and engine; :class:`ValueError` if there is no such matcher."""
        labels, width, height = self.sizes()
        kind = METHODS[name]
        plain = Case(name, labels, width, (), engine=engine, parameters=self.parameters(kind, engine))
        if self.chance(0.1):
            plain = Case(**{**vars(plain), "in_use": int(self.random.integers(1, labels + 1))})
        if "minimum" in plain.config.settings and self.chance(0.4):
            plain = Case(**{**vars(plain), "minimum": int(self.random.integers(-min(labels + 4, 64), 7))})
        longer = self.one((0, 0, 1, int(self.random.integers(1, 30))))
        return Case(**{**vars(plain), "max_width": width + longer, "frames": self.frames(plain.config, width, height),
                       "seed": int(self.random.integers(1, 1000))})


def discriminates(case: Case) -> bool:
    """Whether every label that the case's frames can show wins at every minimum tree, so that each of a tree's inputs does."""
    least = set(range(case.labels)) - unreachable(case)
    return all(least <= labels for labels in winners(case).values())


def draw(number: int) -> Case:
    """The case with this number: one that discriminates. Numbers below :data:`ICARUS` are small."""
    small = number < ICARUS
    random = _Draw(np.random.default_rng([19, number]), small)
    kinds = [kind for kind, *shares in _KINDS for _ in range(shares[small])]
    name, engine = kinds[number % len(kinds)]
    for _ in range(_TRIES):
        try:
            case = random.case(name, engine)
            case.configs()
        except ValueError:      # parameters that exclude one another
            continue
        if discriminates(case):
            return case
    raise ValueError(f"none of {_TRIES} cases with number {number} discriminates")

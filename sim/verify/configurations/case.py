"""A case: a matcher, and frames that follow one another, each with its settings and stalls; in plain values, so that it can be printed."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.config import METHODS, PIXEL_MAX, MatcherConfig, changed
from golden.pictures.scenes import NOISE, scene

from ...kit.cases import noise
from ...kit.harness import Traffic


__all__ = ["SCENES", "Case", "CaseFrame", "literal"]


Picture = NDArray[np.uint8]


def _bands(width: int, height: int, labels: int, seed: int) -> tuple[Picture, Picture]:
    """Lines of one label each, ``seed``, ``seed + 1`` and so on: a support along the line, however long, agrees."""
    rng = np.random.default_rng(seed)
    right = rng.integers(0, 256, (height, width), dtype=np.uint8)
    column = np.arange(width) - (np.arange(height)[:, None] + seed) % labels
    left = np.take_along_axis(right, np.maximum(column, 0), axis=1) + rng.integers(-NOISE, NOISE + 1, (height, width))
    return np.clip(left, 0, PIXEL_MAX).astype(np.uint8), right


def _steps(width: int, height: int, labels: int, seed: int) -> tuple[Picture, Picture]:
    left, right, _ = scene(width, height, labels, seed)
    return left, right


def _noise(width: int, height: int, labels: int, seed: int) -> tuple[Picture, Picture]:
    left, right = noise(width, height, seed).astype(np.uint8)
    return left, right


def _even(width: int, height: int, labels: int, seed: int) -> tuple[Picture, Picture]:
    """One grey level a picture, black or white by ``seed``: ties everywhere, and the greatest costs."""
    left, right = (np.full((height, width), PIXEL_MAX * (seed >> bit & 1), dtype=np.uint8) for bit in (0, 1))
    return left, right


#: Kinds of pictures, by name.
SCENES = {"bands": _bands, "steps": _steps, "noise": _noise, "even": _even}


@dataclass(frozen=True)
class CaseFrame:
    """A frame: its size, its pictures by kind and seed, and what is around it, as of :class:`sim.kit.harness.Traffic`."""
    width: int
    height: int
    scene: str = "steps"
    seed: int = 0
    settings: Mapping[str, int] | None = None
    stall_i: float = 0.0
    stall_o: float = 0.0
    burst_i: int = 0
    burst_o: int = 0

    def pictures(self, labels: int, minimum: int) -> tuple[Picture, Picture]:
        """Left and right picture; label 0 of the scene is the disparity ``minimum``."""
        left, right = SCENES[self.scene](self.width, self.height, labels, self.seed)
        return left, right[:, np.clip(np.arange(self.width) + minimum, 0, self.width - 1)]

    @property
    def traffic(self) -> Traffic:
        """Settings and stalls."""
        return Traffic(self.stall_i, self.stall_o, self.burst_i, self.burst_o, self.settings)


@dataclass(frozen=True)
class Case:
    """A matcher and its frames.

    Parameters
    ----------
    method : str
        One of :data:`golden.config.METHODS`.
    labels, max_width, minimum, in_use, engine
        As of :class:`golden.config.MatcherConfig`.
    frames : tuple of CaseFrame
    parameters : dict of str to value
        Those of the method that differ from their defaults, as :func:`golden.config.changed` takes them.
    seed : int
        Of the stalls.
    """
    method: str
    labels: int
    max_width: int
    frames: tuple[CaseFrame, ...]
    minimum: int = 0
    in_use: int | None = None
    engine: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 1

    @property
    def config(self) -> MatcherConfig:
        """The matcher; :class:`ValueError` if there is none of these parameters."""
        method = changed(METHODS[self.method](), **self.parameters)
        return MatcherConfig(self.labels, self.max_width, self.minimum, self.in_use, self.engine, method)  # type: ignore[arg-type]

    def pictures(self) -> list[tuple[Picture, Picture]]:
        """Left and right pictures of all frames."""
        return [frame.pictures(self.labels, self.minimum) for frame in self.frames]

    def configs(self) -> list[MatcherConfig]:
        """The configuration of each frame: a frame without settings has those of the one before."""
        result, now = [], self.config
        for frame in self.frames:
            now = now if frame.settings is None else self.config.with_settings(frame.settings)
            result.append(now)
        return result


def literal(value: Any) -> str:
    """A case as Python text that makes it again, without what has its default.

    Examples
    --------
    >>> literal(Case("thesis", 2, 5, (CaseFrame(5, 1, stall_o=0.9), CaseFrame(1, 1)), engine="sequential"))
    "Case('thesis', 2, 5, (CaseFrame(5, 1, stall_o=0.9), CaseFrame(1, 1)), engine='sequential')"
    """
    if isinstance(value, tuple):
        return f"({', '.join(map(literal, value))}{',' * (len(value) == 1)})"
    if not isinstance(value, (Case, CaseFrame)):
        return repr(value)
    needed = {"method", "labels", "max_width", "frames", "width", "height"}
    plain = {each.name: each.default_factory() if callable(each.default_factory) else each.default for each in fields(value)}
    parts = [literal(getattr(value, name)) if name in needed else f"{name}={getattr(value, name)!r}"
             for name, default in plain.items() if name in needed or getattr(value, name) != default]
    return f"{type(value).__name__}({', '.join(parts)})"

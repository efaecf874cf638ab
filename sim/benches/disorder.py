"""What a bare matcher must get over: ragged frames, a reset within a frame, settings that change. As steps for ``disorder_tb.py``."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.config import MatcherConfig
from golden.matcher.matcher import match
from golden.pictures.scenes import scene

from ..kit.cases import pixel_words
from ..kit.ragged import frame, in_a_row, repaired
from ..kit.simulators import build, run


__all__ = ["run_disorder", "steps"]


Words = list[int]


def _sent(words: Sequence[Mapping[str, int]]) -> Words:
    """Pixels as the matcher's input has them."""
    return [word["left"] | word["right"] << 8 | word["first"] << 16 | word["last"] << 17 | word["end"] << 18 for word in words]


def _expected(pair: Iterable[NDArray[Any]], config: MatcherConfig) -> Words:
    """The golden model's output of a pair, as the matcher's output has it."""
    left, right = (np.asarray(side, np.uint8) for side in pair)
    fields = match(left, right, config)
    height, width = left.shape
    words = []
    for y, x in np.ndindex(height, width):
        word = place = 0
        for name, bits in config.result_fields.items():
            word |= (int(fields[name][y, x]) & (1 << bits) - 1) << place
            place += bits
        flags = (x == y == 0, x == width - 1, x == width - 1 and y == height - 1)
        words.append(word | sum(flag << place + number for number, flag in enumerate(flags)))
    return words


def steps(config: MatcherConfig, height: int) -> list[dict[str, Any]]:
    """What is sent, one after another, and what must come of it.

    Each step has ``words`` and ``expected``, and may have: ``settings``, set before; ``cut``, pixels after which a reset ends a frame
    that is sent before; ``error``, whether it is raised, which is cleared then.
    """
    width = config.max_width
    too_long = [*frame(width + 3, 2, seed=1), *frame(5, 2, seed=2)]
    ragged = [*in_a_row(), *too_long]
    frames, _ = repaired(ragged, width)
    first, second = (scene(width, height, config.labels, seed)[:2] for seed in (1, 2))
    whole = {"words": _sent(pixel_words(*first)), "expected": _expected(first, config)}
    found: list[dict[str, Any]] = [
        {"words": _sent(ragged), "expected": [word for pair in frames for word in _expected(pair, config)], "error": True}, whole,
        *({**whole, "cut": cut} for cut in (1, width + 3, width * height // 2, width * height - 1))]
    for end in ("maximum", "minimum", "maximum", "default"):
        values = {name: int(getattr(setting, end)) for name, setting in config.settings.items()}
        # More labels than there are count as all.
        meant = config.with_settings({**values, "in_use": min(values["in_use"], config.labels)})
        found.append({"settings": values, "words": _sent(pixel_words(*second)), "expected": _expected(second, meant)})
    return found


def run_disorder(config: MatcherConfig, height: int, simulator: str, verilog: Path, folder: Path) -> None:
    """Play :func:`steps` to the Verilog of ``Matcher(config)``; :class:`sim.kit.simulators.SimulationError` if it is not as golden."""
    build(simulator, [verilog], "matcher", folder / f"{simulator}_disorder", brief=True)
    plan = folder / "steps.json"
    bits = {name: setting.bits for name, setting in config.settings.items()}
    plan.write_text(json.dumps({"bits": bits, "steps": steps(config, height)}))
    assert run(simulator, "matcher", folder / f"{simulator}_disorder", "sim.benches.disorder_tb", env={"STEPS": plan.resolve()}) == 1

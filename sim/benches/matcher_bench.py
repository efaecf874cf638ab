"""Shared by the benches of the whole matcher: its Verilog runs on pictures, and is compared with the golden model."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from golden.config import MatcherConfig
from golden.errors import UserError
from golden.pictures.dataset import StereoPair, data_folder, load_pair
from golden.pictures.scenes import scene
from hdl.emit import write_verilog
from hdl.matcher.matcher import Matcher

from ..kit.cases import noise
from ..kit.harness import Frame, Result, mismatches, simulate


__all__ = ["MatcherBench", "middlebury", "names", "pictures"]


def names(case: Any) -> str:
    """Name of a test's parameter; pytest numbers those that are equal."""
    if isinstance(case, MatcherConfig):
        return f"{case.engine}-{case.labels}-{case.method.name}-{case.method.arithmetic}"
    return "+".join(f"{width}x{height}" for width, height in case) if isinstance(case, list) else str(case)


def pictures(sizes: Iterable[tuple[int, int]], labels: int) -> tuple[list[NDArray[np.uint8]], list[NDArray[np.uint8]]]:
    """Left and right pictures of these widths and heights: scenes, or noise if a picture is too narrow for one."""
    pairs = [scene(width, height, labels, seed)[:2] if width > 2 else noise(width, height, seed).astype(np.uint8)
             for seed, (width, height) in enumerate(sizes)]
    return [left for left, _ in pairs], [right for _, right in pairs]


def middlebury(name: str) -> StereoPair:
    """A pair of the Middlebury benchmark; skips the test if the data are not on this machine."""
    try:
        folder = data_folder()
    except UserError as error:
        pytest.skip(str(error))
    return load_pair(folder, name)


class MatcherBench:
    """A matcher's Verilog, for several runs."""
    def __init__(self, case: MatcherConfig, folder: Path):
        self.matcher = Matcher(case)
        self.case = case
        self.folder = folder
        self.verilog = write_verilog(self.matcher, folder / "matcher.v", name="matcher")

    def check(self, lefts: Sequence[NDArray[np.uint8]], rights: Sequence[NDArray[np.uint8]], simulator: str, *,
              settings: Mapping[str, int] | None = None, **arguments: Any) -> Result:
        """Bit-exact in every frame; no hang, no violated rule, no wrong flag, no extra word, no ``error``."""
        result = simulate(self.case, lefts, rights, simulator=simulator, work_dir=self.folder, verilog=self.verilog, settings=settings,
                          **arguments)
        case = self.case.with_settings(settings or {})
        assert len(result.fields) == len(lefts)
        for number, (left, right) in enumerate(zip(lefts, rights, strict=True)):
            assert mismatches(result, number, left, right, case) == 0
        assert result.report["pixels_in"] == result.report["pixels_out"] == sum(left.size for left in lefts)
        for fault in ("hang", "error", "rule_errors", "flag_errors", "unknown_words", "extra_words"):
            assert result.report[fault] == 0
        return result

    def check_timing(self, frames: Sequence[Frame]) -> None:
        """Clocks per pixel, and latency, of consecutive frames without stalls."""
        matcher = self.matcher
        clocks = matcher.clocks_per_pixel
        for number, frame in enumerate(frames):
            # The first lines of a frame wait while the last lines of each frame before it leave.
            width = max(frame.width for frame in frames[:number + 1])
            if min(frame.width for frame in frames[:number + 1]) < matcher.full_rate_width:
                continue  # no bound for short lines: pixels enter faster than disparities leave, and wait
            assert frame.latency <= (number + 1) * (matcher.latency_lines * width * clocks + matcher.latency_clocks)
        assert clocks <= 8 and matcher.latency_lines <= 12 and matcher.latency_clocks <= 1500
        first = frames[0]
        if first.width >= matcher.full_rate_width:
            assert first.clocks_per_pixel <= clocks + (matcher.line_clocks + 40) / first.width
        else:
            assert first.clocks_per_pixel <= matcher.frame_clocks(first.width, first.height) / (first.width * first.height)

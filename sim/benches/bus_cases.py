"""What the benches of the cores with a bus have in common: configurations, streams of frames, words of the golden model."""

import random
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass
from golden.host.core_registers import core_register_map
from golden.matcher.matcher import match
from golden.pictures.scenes import scene
from golden.video.frame_rule import Closes, ReceivedWord
from hdl.interfaces.cores import OutputData


__all__ = ["CASES", "BusCase", "pauses", "pixel_words", "result_words"]


class BusCase(NamedTuple):
    """A core with a bus, for frames of ``config.max_width`` times ``height`` pixels after reset."""
    config: MatcherConfig
    height: int

    @property
    def registers(self) -> Any:
        """Its register map."""
        return core_register_map(self.config, self.height)

    def pairs(self, count: int, width: int | None = None, height: int | None = None,
              seed: int = 0) -> list[tuple[NDArray[np.uint8], NDArray[np.uint8]]]:
        """Pairs of pictures."""
        size = (width or self.config.max_width, height or self.height)
        return [scene(*size, self.config.labels, seed + number)[:2] for number in range(count)]


CASES = {
    "thesis": BusCase(MatcherConfig(4, 12, method=OnePass(Arithmetic.LINEAR)), 6),
    "fused": BusCase(MatcherConfig(8, 40, -3, method=FUSED_1), 12),
}


def pixel_words(left: NDArray[np.uint8], right: NDArray[np.uint8], closes: Closes) -> list[ReceivedWord]:
    """A frame as its pixels, line by line from the top."""
    height, width = left.shape
    return [ReceivedWord(int(left[y, x]), int(right[y, x]), x == y == 0,
                         x == width - 1 and (closes is Closes.LINE or y == height - 1)) for y in range(height) for x in range(width)]


def result_words(left: NDArray[np.uint8], right: NDArray[np.uint8], config: MatcherConfig, settings: Mapping[str, int]) -> list[list[int]]:
    """The golden model's disparities as words of the output, a list for each line."""
    result = match(left, right, config.with_settings(settings))
    fields = {name: (field.offset, (1 << field.width) - 1) for name, field in OutputData(config)}
    return [[sum((int(result[name][y, x]) & mask) << offset for name, (offset, mask) in fields.items()) for x in range(left.shape[1])]
            for y in range(left.shape[0])]


def pauses(seed: int, probability: float) -> Iterator[bool]:
    """For each clock whether a side stalls, without an end; some stalls are long."""
    rng = random.Random(seed)
    while True:
        for _ in range(rng.choice([1, 1, 1, 12]) if rng.random() < probability else 0):
            yield True
        yield False

"""The books of a camera: each frame that it has sent is in a pair that was matched, or a counter has it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.video.bt656 import decode, encode
from golden.video.formats import CameraFormat
from sim.models.camera import STOPPED


__all__ = ["COUNTERS", "Ledger"]


#: Counters of a camera that a ledger is compared with, without the camera's prefix.
COUNTERS = ("corrected", "rejected", "dropped", "overflow", "skipped", "unpaired")


@dataclass
class Ledger:
    """What a camera has sent since its counters were 0.

    Parameters
    ----------
    format : CameraFormat
    tape : list
        Frames of bytes and :data:`STOPPED`, from the first one that begins after the counters were 0.
    fewer, more : int
        Frames that may be missing in the counters, and that they may have beside those: they were begun before, or during a reset.
    """
    format: CameraFormat
    tape: list[NDArray[Any]] = field(default_factory=list)
    fewer: int = 0
    more: int = 0

    def begin(self, fewer: int = 0, more: int = 0) -> None:
        """The counters are 0."""
        self.tape.clear()
        self.fewer, self.more = fewer, more

    def unsure(self) -> None:
        """The camera's domain was reset: a frame may not have been seen, and another one be seen in two parts."""
        self.fewer += 1
        self.more += 1

    @property
    def frames(self) -> int:
        """Frames that were sent."""
        return sum(not self._stopped(frame) for frame in self.tape)

    @staticmethod
    def _stopped(frame: NDArray[Any]) -> bool:
        return bool((frame == STOPPED).all())

    def errors(self, pairs: int, counts: Mapping[str, int]) -> list[str]:
        """What the counters of a camera, which has stopped, say against its bytes; nothing if they add up.

        Golden: :func:`golden.video.bt656.decode`. A frame whose clock stops may be dropped or not. One that was skipped is dropped, too, if
        it is bad.
        """
        data = np.concatenate([*self.tape, encode(np.zeros((self.format.height, self.format.width), np.uint8), self.format)])
        sent = decode(data[data != STOPPED], self.format)
        frames = len(sent.pictures) + sent.dropped - 1      # a good frame closes the one that the stop may have left open
        stops = sum(bool((frame == STOPPED).any()) for frame in self.tape) + 1
        dropped, skipped = counts["dropped"], counts["skipped"]
        total = pairs + dropped + skipped + counts["unpaired"]
        found = []
        for what, value, limits in (
                ("pairs, dropped, skipped and unpaired frames", total, (frames - self.fewer, frames + skipped + self.more)),
                ("dropped frames", dropped, (sent.dropped - self.fewer, sent.dropped + counts["overflow"] + stops + self.more)),
                ("corrected codes", counts["corrected"], (sent.corrected, sent.corrected)),
                ("rejected codes", counts["rejected"], (sent.rejected, sent.rejected))):
            if not limits[0] <= value <= limits[1]:
                found.append(f"{value} {what}, and the bytes have {' to '.join(map(str, sorted(set(limits))))}")
        return found

    def check(self, side: str, pairs: int, counts: Sequence[int]) -> None:
        """Raise :class:`AssertionError` unless the counters, in the order of :data:`COUNTERS`, add up."""
        errors = self.errors(pairs, dict(zip(COUNTERS, counts, strict=True)))
        assert not errors, f"{side} camera: {'; '.join(errors)}"

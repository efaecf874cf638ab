"""`console put`: a pair of pictures into the memory of a running system with cameras, in place of theirs; and such a system as a board."""

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.config import MatcherConfig
from golden.errors import UserError
from golden.host.blocks import PLANES, line_bytes, stored_line
from golden.host.protocol import block_bits

from .chip import Chip
from .grab import kept_pair
from .loop import Board, BoardRun, Report, sent_lines
from .transfer import get_lines, put_lines


__all__ = ["CameraBoard", "put"]


# Not the matcher's: the pair is matched as it was sent.
_AS_SENT = {"rectify": 0, "balance": 0}


@contextlib.contextmanager
def _host_as_source(chip: Chip) -> Iterator[None]:
    """Pairs are the host's from now on; the cameras' again if what is done meanwhile fails."""
    try:
        chip.write("keep", 0)   # of an earlier command that was killed: it refuses all lines
        chip.write("source", 1)
        yield
    except BaseException:
        with contextlib.suppress(UserError):    # the first error is what is told
            chip.write("source", 0)
        raise


def _send(chip: Chip, left: NDArray[np.uint8], right: NDArray[np.uint8], baud: int, report: Callable[[int, int], None]) -> None:
    """Both pictures into the chip's memory."""
    put_lines(chip, sent_lines((left, right), stored_line), baud, report)
    if not chip.read("pair_whole"):
        raise UserError("the chip does not hold the whole pair; another program may be using it: end that, and try again")


def _check_size(size: tuple[int, int], held: tuple[int, int]) -> None:
    if size != held:
        raise UserError(f"the pictures have {size[0]}x{size[1]} pixels, and the chip's cameras send {held[0]}x{held[1]}; choose pictures "
                        "of that size")


def put(chip: Chip, left: NDArray[np.uint8], right: NDArray[np.uint8], baud: int, report: Callable[[int, int], None]) -> None:
    """Have a pair matched and shown in place of the cameras' pairs, until ``source`` is set to the cameras again.

    The pair goes the way of the cameras': it is rectified and balanced as the settings say. It is matched only once all of it is in memory;
    where this fails, or is interrupted, the cameras' pairs are matched again, and nothing of the host's is ever shown. A pair of 720x576
    pixels takes 73.4 s on the line at 115,200 baud, and what the computer waits for each of 1,152 replies.

    Parameters
    ----------
    chip : Chip
    left, right : (H, W) ndarray of uint8
        Of the size that the cameras have; :class:`UserError` for another one.
    baud : int
        Of the line.
    report : callable
        Is given the number of lines sent, and that of all.
    """
    if not chip.system.cameras:
        raise UserError(f"put is for a system with cameras, and this is {chip.system.about}; use python -m sim.run LEFT RIGHT "
                        "--hardware PORT")
    height, width = left.shape
    _check_size((width, height), chip.size)
    if chip.read("hold"):
        raise UserError("the picture on the monitor is frozen, and no pair is matched; set hold=live first")
    with _host_as_source(chip):
        _send(chip, left, right, baud, report)
        chip.write("start_pair", 1)


class CameraBoard(Board):
    """A system with cameras: pairs of their size, matched as they were sent, of whose results it stores the whole disparities.

    After each pair the cameras are the source again, and rectification and balance are as before.
    """
    def _check_size(self, size: tuple[int, int], held: tuple[int, int]) -> None:
        _check_size(size, held)

    def line_seconds(self, width: int, height: int, config: MatcherConfig) -> float:
        # Each block waits for the reply to the one before.
        return len(PLANES) * height * block_bits(line_bytes(width)) / self.baud

    def seen(self, fields: Mapping[str, NDArray[Any]], config: MatcherConfig) -> dict[str, NDArray[Any]]:
        scale = config.method.disparity_scale
        return {"disparity": np.asarray(fields["disparity"]) // scale * scale}

    def match(self, left: NDArray[np.uint8], right: NDArray[np.uint8], config: MatcherConfig,
              report: Report = lambda what, done, total: None) -> BoardRun:
        chip, repeated = self.chip, self.chip.repeated
        height, width = left.shape
        changed = {name: value for name, value in {**_AS_SENT, "hold": 0}.items() if name in chip.registers}
        before = {"source": 0, **{name: chip.read(name) for name in changed}}
        try:
            self._set({**changed, **config.defaults, "source": 1})
            start = time.perf_counter()
            _send(chip, left, right, self.baud, lambda done, total: report("left and right to the board", done, total))
            sent = time.perf_counter()
            with kept_pair(chip):
                matched = time.perf_counter()
                lines = get_lines(chip, PLANES.index("disparity"), height, line_bytes(width), self.baud,
                                  lambda done, total: report("result from the board", done, total))
            end = time.perf_counter()
            clocks = chip.read("clocks_high") << 16 | chip.read("clocks_low")
        except BaseException:
            with contextlib.suppress(UserError):    # the first error is what is told
                self._restore(before)
            raise
        self._restore(before)
        labels = np.frombuffer(b"".join(lines), np.uint8).reshape(height, -1)[:, :width].astype(np.int32)
        return BoardRun({"disparity": (labels + config.minimum) * config.method.disparity_scale}, clocks, sent - start, matched - sent,
                        end - matched, chip.repeated - repeated)

    def _restore(self, values: Mapping[str, int]) -> None:
        for name, value in values.items():
            self.chip.write(name, value)

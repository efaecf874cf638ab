"""`console grab`: pictures of one pair out of the memory of a running system, line by line."""

import contextlib
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from golden.cli import progress
from golden.errors import UserError
from golden.host.blocks import PLANES

from .chip import Chip


__all__ = ["grab", "grab_pair", "kept_pair", "showing"]


# A pair is kept after some frames, 1/25 s each; readings of `kept`, and seconds between two.
_READINGS = 100
_PAUSE = 0.02


def _no_report(done: int, total: int) -> None:
    """Tell nobody."""


def _start_of_the_host(chip: Chip) -> None:
    """Where pairs are the host's none starts by itself: match the one that is in memory."""
    if chip.read("source"):
        if not chip.read("pair_whole"):
            raise UserError("pairs are the host's, and its pair is not whole in the chip's memory; put it again, or set source=cameras")
        chip.write("start_pair", 1)


@contextlib.contextmanager
def kept_pair(chip: Chip) -> Iterator[None]:
    """Keep a pair that starts from now on, and let it go at the end, however that is reached."""
    chip.write("keep", 0)   # of an earlier command that was killed: its pair would be an old one
    try:
        chip.write("keep", 1)
        if chip.system.cameras:
            _start_of_the_host(chip)
        for _ in range(_READINGS):
            if chip.read("kept"):
                break
            time.sleep(_PAUSE)
        else:
            raise UserError(f"no pair of pictures was received in {_READINGS * _PAUSE:g} s; check the cameras, see left_signal, "
                            "right_signal and pairs, and that hold is live")
        yield
    except BaseException:
        with contextlib.suppress(UserError):    # the first error is what is told
            chip.write("keep", 0)
        raise
    chip.write("keep", 0)


def _pictures(chip: Chip, planes: Sequence[str], report: Callable[[int, int], None]) -> list[NDArray[np.uint8]]:
    width, height = chip.size
    pictures = [np.empty((height, width), np.uint8) for _ in planes]
    with kept_pair(chip):
        lines = [(plane, picture, line) for plane, picture in zip(planes, pictures, strict=True) for line in range(height)]
        for number, (plane, picture, line) in enumerate(lines, 1):
            picture[line] = np.frombuffer(chip.block(PLANES.index(plane), line, width), np.uint8)[:width]
            report(number, len(lines))
    return pictures


def grab(chip: Chip, plane: str, report: Callable[[int, int], None] = _no_report) -> NDArray[np.uint8]:
    """A picture of the next pair; the system runs on, and the pair is let go at the end, also when this fails.

    Where pairs are the host's (:func:`hdl.host.put.put`), the next pair is the one that it has put, matched once more.

    A line of 720 pixels takes 7,340 bits on the line (:func:`golden.host.protocol.block_bits`), 720x576 pixels take 36.7 s at 115,200 baud,
    4.6 s at 921,600 and 1.4 s at 3,000,000; what the computer waits between a block and its next request is added for each line.

    Parameters
    ----------
    chip : Chip
    plane : str
        One of :data:`golden.host.blocks.PLANES`. Those of the cameras are as they were sent, not rectified; disparities are labels, as the
        monitor shows them: whole disparities less the least one.
    report : callable
        Is given the number of lines read, and that of all.

    Returns
    -------
    (H, W) ndarray of uint8
        :class:`UserError` if no pair is kept in time, or a line is refused or garbled each time.
    """
    return _pictures(chip, [plane], report)[0]


def grab_pair(chip: Chip, report: Callable[[int, int], None] = _no_report) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Left and right picture of one pair, (H, W) uint8 each, as the cameras sent them; else as :func:`grab`."""
    left, right = _pictures(chip, ["left", "right"], report)
    return left, right


@contextlib.contextmanager
def showing(what: str) -> Iterator[Callable[[int, int], None]]:
    """A ``report`` that shows a bar on stderr."""
    with progress() as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)

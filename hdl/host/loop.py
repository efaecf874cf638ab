"""A board at a serial line, as a host uses it: a pair in, its result out, and what the board was built for."""

import dataclasses
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.config import METHODS, MatcherConfig
from golden.errors import UserError
from golden.host.blocks import SENT_PLANES
from golden.host.build_id import parameter_digest, release
from golden.host.loop_device import unpacked_result
from golden.host.loop_registers import LOOP_PLANES, result_bytes

from .chip import Chip
from .transfer import get_lines, put_lines, seconds_of_pair


__all__ = ["Board", "BoardRun", "LoopBoard", "Report", "sent_lines"]


#: Is given what is done, and the number of lines done and of all.
Report = Callable[[str, int, int], None]


# Longest time of a match, and seconds between two readings.
_MATCH_SECONDS = 10.0
_PAUSE = 0.001


@dataclass(frozen=True)
class BoardRun:
    """Result of a pair, and what it took.

    ``fields`` : names as in ``config.result_fields``, (H, W) int32. ``clocks``: of the board, from start to the last disparity.
    ``put_seconds``, ``match_seconds``, ``get_seconds``: to send the pair, until the host knew that it was matched, to read the result.
    ``repeated``: requests and blocks that were sent again.
    """
    fields: dict[str, NDArray[Any]]
    clocks: int
    put_seconds: float
    match_seconds: float
    get_seconds: float
    repeated: int

    @property
    def seconds(self) -> float:
        """Of the whole pair."""
        return self.put_seconds + self.match_seconds + self.get_seconds


def sent_lines(pair: Sequence[NDArray[np.uint8]], line: Callable[[NDArray[np.uint8]], bytes]) -> list[tuple[int, int, bytes]]:
    """Lines of a pair in their order, each with the number of its plane and its own; ``line`` gives the bytes of one."""
    return [(plane, number, line(pixels)) for plane, picture in enumerate(pair) for number, pixels in enumerate(picture)]


class Board(ABC):
    """A board that a host sends pairs to.

    Parameters
    ----------
    chip : Chip
        :class:`UserError` if it is another system, or built from another version of this project.
    baud : int
        Of its line.
    """
    def __init__(self, chip: Chip, baud: int) -> None:
        self.chip = chip
        self.baud = baud
        built = chip.read("release")
        if built != release():
            raise UserError(f"the board's bitstream was built from release {_release_text(built)} of this project, and this is "
                            f"{_release_text(release())}; build the bitstream again, or use that release")

    @property
    def labels(self) -> int:
        """Labels built in."""
        return self.chip.registers["disparities"].reset

    def check(self, config: MatcherConfig, width: int, height: int) -> None:
        """:class:`UserError` unless the board computes ``config``, and holds pictures of that size."""
        registers = self.chip.registers
        method = list(METHODS)[registers["method"].reset]
        if method != config.method.name:
            raise UserError(f"the board holds the method {method}, the command says {config.method.name}; say --method {method}, or build "
                            f"again with --method {config.method.name}")
        if config.labels != self.labels:
            raise UserError(f"the board holds {self.labels} disparities, the command says {config.labels}; say --disparities "
                            f"{self.labels}, or build again with --disparities {config.labels}")
        greatest = registers["width"].reset, registers["height"].reset
        self._check_size((width, height), greatest)
        lead = registers["lead"].reset
        if config.lead > lead:
            raise UserError(f"the board holds disparities from {-lead} on, the command says {config.minimum}; say --minimum {-lead}, or "
                            f"build again with --minimum {config.minimum}")
        if self.chip.read("parameters_high") << 16 | self.chip.read("parameters_low") != parameter_digest(config):
            raise UserError(f"the board was built with other parameters of the method {method} than this command's; give the options of "
                            "its build, which its manifest.json tells, or build again with this command's")
        # With the settings of this configuration's parameters, which the constants of the method alone do not tell.
        self.chip.registers = self.chip.system.registers(dataclasses.replace(config, max_width=greatest[0], minimum=-lead), greatest[1],
                                                         registers["rectify_lines"].reset)

    @abstractmethod
    def _check_size(self, size: tuple[int, int], held: tuple[int, int]) -> None:
        """:class:`UserError` unless a board that holds pictures of one size takes those of the other, width and height each."""

    @abstractmethod
    def line_seconds(self, width: int, height: int, config: MatcherConfig) -> float:
        """Time on the line of a pair and its result, without the matcher, and without what the computer waits."""

    @abstractmethod
    def seen(self, fields: Mapping[str, NDArray[Any]], config: MatcherConfig) -> dict[str, NDArray[Any]]:
        """What the board tells of a result of :func:`golden.matcher.matcher.match`."""

    @abstractmethod
    def match(self, left: NDArray[np.uint8], right: NDArray[np.uint8], config: MatcherConfig,
              report: Report = lambda what, done, total: None) -> BoardRun:
        """Send a pair, let it be matched, and read its result.

        Parameters
        ----------
        left, right : (H, W) ndarray of uint8
        config : MatcherConfig
            One that :meth:`check` has accepted: its settings are written first.
        report : callable
            Is given what is done, and the number of lines done and of all.

        Returns
        -------
        BoardRun
            :class:`UserError` if the board does not answer, sends garbage, refuses, or does not finish in 10 s.
        """

    def _set(self, values: dict[str, int]) -> None:
        """Write settings, and read them back: noise may have changed one that was not meant."""
        chip = self.chip
        for name, value in {"keep": 0, **values}.items():
            chip.write(name, value)
        wrong = [name for name, value in values.items() if chip.read(name) != value]
        if wrong:
            raise UserError(f"the board does not hold what was written to {wrong[0]}; check the wires, or choose a lower --baud")


class LoopBoard(Board):
    """A matcher behind a serial line: pictures up to the size of its stores, and all fields of the results."""
    def _check_size(self, size: tuple[int, int], held: tuple[int, int]) -> None:
        if size[0] > held[0] or size[1] > held[1]:
            raise UserError(f"the pictures have {size[0]}x{size[1]} pixels, and the board holds {held[0]}x{held[1]} at most; choose "
                            f"smaller ones, or build again with --width {size[0]} --height {size[1]}")

    def line_seconds(self, width: int, height: int, config: MatcherConfig) -> float:
        return seconds_of_pair(width, height, result_bytes(config), self.baud)

    def seen(self, fields: Mapping[str, NDArray[Any]], config: MatcherConfig) -> dict[str, NDArray[Any]]:
        return dict(fields)

    def match(self, left: NDArray[np.uint8], right: NDArray[np.uint8], config: MatcherConfig,
              report: Report = lambda what, done, total: None) -> BoardRun:
        chip, repeated = self.chip, self.chip.repeated
        height, width = left.shape
        self._set({"picture_width": width, "picture_height": height, **config.defaults})
        start = time.perf_counter()
        put_lines(chip, sent_lines((left, right), lambda pixels: pixels.tobytes()), self.baud,
                  lambda done, total: report(f"{' and '.join(SENT_PLANES)} to the board", done, total))
        sent = time.perf_counter()
        chip.write("start", 1)
        while not chip.read("kept"):
            if time.perf_counter() - sent > _MATCH_SECONDS:
                raise UserError(f"the board has not matched the pair in {_MATCH_SECONDS:g} s: busy is {chip.read('busy')}, matcher_error "
                                f"{chip.read('matcher_error')}; reset the board, and build its bitstream again if that does not help")
            time.sleep(_PAUSE)
        matched = time.perf_counter()
        count = chip.read("result_bytes")
        lines = get_lines(chip, LOOP_PLANES.index("result"), height, width * count, self.baud,
                          lambda done, total: report("result from the board", done, total))
        end = time.perf_counter()
        clocks = chip.read("clocks_high") << 16 | chip.read("clocks_low")
        parts = np.frombuffer(b"".join(lines), np.uint8).reshape(height, width, count).astype(np.int64)
        words = sum(parts[:, :, place] << 8 * place for place in range(count))
        return BoardRun(unpacked_result(np.asarray(words), config), clocks, sent - start, matched - sent, end - matched,
                        chip.repeated - repeated)


def _release_text(number: int) -> str:
    """A release as versions are written.

    Examples
    --------
    >>> _release_text(release("0.2.1"))
    '0.2.1'
    """
    return f"{number >> 12}.{number >> 6 & 63}.{number & 63}"

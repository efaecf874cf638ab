"""The memory's bandwidth: demands of cameras, matcher and monitor against what the memory serves, and the FIFO depths that follow."""

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar

from rich.table import Table

from ..errors import UserError
from .formats import DISPLAYS, PAL, CameraFormat, DisplayFormat
from .memory_map import WORD_BYTES, MemoryMap
from .pairing import WINDOW, check_window


__all__ = ["Budget", "Demand", "MemoryTiming", "grant_clocks", "served_clocks"]


def grant_clocks(masters: int, burst: int, pace: float, stall: int) -> int:
    """Most clocks from a master's request to its grant, :class:`hdl.video.arbiter.Arbiter`.

    ``masters`` bursts of ``burst`` words may be served before it: the master's previous burst, and one of each other master. The memory
    accepts a word each ``pace`` clocks at the slowest, except for one stall of ``stall`` clocks.
    """
    return math.ceil(masters * burst * pace) + stall + 2


def served_clocks(masters: int, burst: int, pace: float, stall: int) -> int:
    """Most clocks from a master's request until the memory has accepted the last word of its burst."""
    return math.ceil((masters + 1) * burst * pace) + stall + 3


@dataclass(frozen=True)
class MemoryTiming:
    """Overheads of the memory controller, in clocks of its local interface (two clocks of the memory each); conservative.

    Parameters
    ----------
    clock_hz : int
        Of the local interface, which transfers a word a clock at best.
    row_clocks : int
        To close a row and open another: precharge and activate, 15 ns each, and the controller's overhead. Counted once for each burst,
        because a burst lies within one row.
    turn_clocks : int
        Bus turnaround: CAS latency 5, burst of 4, write to read 7.5 ns. Counted once for each burst, as if reads and writes alternated.
    refresh_clocks : int
        A refresh, 105 ns, with all rows closed before it and opened after it.
    refresh_ns : int
        From a refresh to the next.
    latency_clocks : int
        From a read's acceptance to its first word.
    stall_clocks : int
        The longest further stall that the FIFOs of cameras and monitor must bridge: 100 us.
    """
    clock_hz: int = 75_000_000
    row_clocks: int = 8
    turn_clocks: int = 6
    refresh_clocks: int = 24
    refresh_ns: int = 7800
    latency_clocks: int = 30
    stall_clocks: int = 7500

    STALL_SECONDS: ClassVar[float] = 100e-6

    @classmethod
    def at(cls, clock_hz: int) -> "MemoryTiming":
        """The memory with another clock of its local interface: the longest stall is the same time."""
        return cls(clock_hz=clock_hz, stall_clocks=round(clock_hz * cls.STALL_SECONDS))

    def __post_init__(self) -> None:
        if self.clock_hz < 1:
            raise ValueError(f"clock_hz must be at least 1, not {self.clock_hz!r}")
        for name in ("row_clocks", "turn_clocks", "refresh_clocks", "latency_clocks", "stall_clocks"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must not be negative, not {getattr(self, name)!r}")
        if self.refresh_share >= 1:
            raise ValueError(f"a refresh of {self.refresh_clocks} clocks each {self.refresh_ns} ns leaves no time for data at "
                             f"{self.clock_hz} Hz: choose a faster clock")

    @property
    def refresh_share(self) -> float:
        """Fraction of the time that refreshes take."""
        return self.refresh_clocks / (self.refresh_ns * 1e-9 * self.clock_hz)

    def efficiency(self, words: int, bursts: int) -> float:
        """Fraction of the clocks that transfer a word, if ``words`` are transferred in so many bursts."""
        return words / (words + bursts * (self.row_clocks + self.turn_clocks)) * (1 - self.refresh_share)


@dataclass(frozen=True)
class Demand:
    """Demand of a writer or reader on the memory."""
    name: str
    words_per_second: float

    @property
    def bytes_per_second(self) -> float:
        return self.words_per_second * WORD_BYTES


@dataclass(frozen=True)
class Budget:
    """All demands on the memory, against what it serves.

    Cameras and monitor, which have no back-pressure, count with their rate within the active lines of a picture. The matcher, which can
    stall, counts with its average rate: a pair is read, and its results are written, within :attr:`reading_seconds`.

    Parameters
    ----------
    memory_map : MemoryMap
    camera : CameraFormat
        Of each of the two cameras.
    display : DisplayFormat
    timing : MemoryTiming
    matcher_clocks : float
        Clocks of the local interface that the matcher takes for a pixel.
    masters, burst : int
        As given to the arbiter.
    window : Fraction or float
        Greatest time between the beginnings of a pair's frames, in frames.
    kept : int
        Buffers of each kind that a kept pair may occupy. That its lines are read, or those of the host's pair written, is not a demand:
        even at 3,000,000 baud they are 18,750 words a second, :class:`hdl.video.line_access.LineAccess`.
    """
    memory_map: MemoryMap = field(default_factory=MemoryMap)
    camera: CameraFormat = PAL
    display: DisplayFormat = DISPLAYS["720x576"]
    timing: MemoryTiming = field(default_factory=MemoryTiming)
    matcher_clocks: float = 1.01
    masters: int = 7
    burst: int = 16
    window: Fraction | float = WINDOW
    kept: int = 0

    # Lines of the picture that the monitor reads in the time of one of its lines, in mode both: every second one is skipped.
    DISPLAY_LINES = 2

    def __post_init__(self) -> None:
        if (self.memory_map.width, self.memory_map.height) != (self.camera.width, self.camera.height):
            raise ValueError(f"the memory is laid out for {self.memory_map.width}x{self.memory_map.height} pixels, and the cameras send "
                             f"{self.camera.width}x{self.camera.height}: choose the same size")
        if self.matcher_clocks <= 0:
            raise ValueError(f"matcher_clocks must be above 0, not {self.matcher_clocks!r}")
        check_window(self.window)

    @property
    def efficiency(self) -> float:
        """Fraction of the clocks that transfer a word."""
        line_words = self.memory_map.line_words
        return self.timing.efficiency(line_words, math.ceil(line_words / self.burst))

    @property
    def available(self) -> float:
        """Words a second that the memory serves."""
        return self.timing.clock_hz * self.efficiency

    @property
    def buffers(self) -> int:
        """Buffers of each kind without those of a kept pair."""
        return self.memory_map.buffers - self.kept

    @property
    def reading_seconds(self) -> float:
        """Time to read a pair: a frame less the window with double buffers, a whole frame with more.

        With double buffers the earlier frame of a pair is overwritten a frame after it was complete, and the later one may be complete
        only a window after it.
        """
        return self.camera.frame_seconds * float(1 - self.window if self.buffers == 2 else 1)

    @property
    def matcher_seconds(self) -> float:
        """Time that the matcher takes to read a pair."""
        return self.memory_map.width * self.memory_map.height * self.matcher_clocks / self.timing.clock_hz

    @property
    def display_pixels(self) -> float:
        """Pixels a second of a plane that the monitor reads, in the mode that needs most."""
        return self.DISPLAY_LINES * self.memory_map.width * self.display.pixel_clock_hz / self.display.h_total

    @property
    def demands(self) -> tuple[Demand, ...]:
        """Every writer, then every reader."""
        line_words = self.memory_map.line_words
        camera = line_words * self.camera.byte_clock_hz / self.camera.line_bytes
        matcher = line_words * self.memory_map.height / self.reading_seconds
        display = self.display_pixels * line_words / self.memory_map.width
        return (
            Demand("left camera, written", camera), Demand("right camera, written", camera),
            Demand("disparity, written", matcher), Demand("left picture shown, written", matcher),
            Demand("left of the pair, read", matcher), Demand("right of the pair, read", matcher),
            Demand("disparity shown, read", display), Demand("left picture shown, read", display),
        )

    @property
    def used(self) -> float:
        """Words a second of all demands together."""
        return sum(demand.words_per_second for demand in self.demands)

    def check(self) -> None:
        """:class:`UserError` if the memory cannot serve all demands."""
        if self.used > self.available:
            raise UserError(f"cameras, matcher and monitor need {self.used / 1e6:.1f} million words a second of memory, and it serves "
                            f"{self.available / 1e6:.1f} at {self.timing.clock_hz / 1e6:g} MHz: choose a smaller picture, a monitor of "
                            "fewer pixels or a faster memory clock")
        if self.display_pixels > self.timing.clock_hz:
            raise UserError(f"the monitor needs {self.display_pixels / 1e6:.1f} million pixels a second, and the frame store sends one a "
                            f"clock, of {self.timing.clock_hz / 1e6:g} MHz: choose a slower monitor or a faster memory clock")
        if self.matcher_seconds > self.reading_seconds:
            buffers = self.buffers
            remedy = "3 buffers, " if buffers == 2 and self.matcher_seconds <= self.camera.frame_seconds else ""
            raise UserError(f"the matcher takes {self.matcher_seconds * 1e3:.1f} ms to read a pair, and with {buffers} buffers it has "
                            f"{self.reading_seconds * 1e3:.1f} ms: choose {remedy}a matcher of fewer clocks a pixel or a smaller picture")

    def table(self) -> Table:
        """The demands as a table for a terminal."""
        table = Table(title=f"memory, {self.available / 1e6:.1f} million words of {WORD_BYTES} bytes a second at "
                            f"{self.timing.clock_hz / 1e6:g} MHz", title_justify="left")
        table.add_column("")
        for title in ("MB/s", "words/s", "share of all"):
            table.add_column(title, justify="right")
        for demand in (*self.demands, Demand("all", self.used)):
            table.add_row(demand.name, f"{demand.bytes_per_second / 1e6:.1f}", f"{demand.words_per_second:,.0f}",
                          f"{demand.words_per_second / self.available:.1%}")
        return table

    def latency_clocks(self, stall: int) -> int:
        """Most clocks from a request to the last word of its burst, written or returned, with one stall of ``stall`` clocks."""
        return served_clocks(self.masters, self.burst, 1 / self.efficiency, stall) + self.timing.latency_clocks

    def _depth(self, words: int) -> int:
        """A burst is collected, ``words`` arrive while it waits for its grant, and one is in the register in front of the FIFO."""
        return self.burst + words + 1

    def _line_words_within(self, clocks: int, line_seconds: float, pixel_hz: float) -> int:
        """Most words of video in ``clocks``: whole lines, and the beginning of one more."""
        lines, rest = divmod(clocks / self.timing.clock_hz, line_seconds)
        pixels = min(math.ceil(rest * pixel_hz), self.memory_map.width)
        return int(lines) * self.memory_map.line_words + math.ceil(pixels / WORD_BYTES)

    @property
    def camera_depth(self) -> int:
        """Words that a camera's FIFO must hold so that no frame is lost in the longest stall."""
        camera = self.camera
        return self._depth(self._line_words_within(self.latency_clocks(self.timing.stall_clocks),
                                                   camera.line_bytes / camera.byte_clock_hz, camera.byte_clock_hz / 2))

    @property
    def display_depth(self) -> int:
        """Words that each FIFO of the shown picture must hold so that the longest stall causes no underflow."""
        display = self.display
        words = self._line_words_within(self.latency_clocks(self.timing.stall_clocks), display.h_total / display.pixel_clock_hz,
                                        display.pixel_clock_hz)
        return self._depth(self.DISPLAY_LINES * words)

    @property
    def matcher_depth(self) -> int:
        """Words that each FIFO of the matcher must hold so that it waits in stalls of the memory only."""
        return self._depth(math.ceil(self.latency_clocks(0) / (self.matcher_clocks * WORD_BYTES)))

"""Strict model of a DVI monitor: checks the timing to the pixel, and captures pictures."""

from collections import deque
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

import numpy as np
from amaranth.hdl import Cat

from golden.video.formats import DisplayFormat


__all__ = ["PINS", "Monitor", "TimingError", "watch_amaranth", "watch_cocotb"]


#: The pins by name, in the order of their bits in a word of :meth:`Monitor.clock`, lowest first, and how many bits each has.
PINS = {"blue": 8, "green": 8, "red": 8, "de": 1, "hsync": 1, "vsync": 1}


class TimingError(AssertionError):
    """The signal violates the monitor's format."""


class Monitor:
    """The model itself; :meth:`clock` is called once a pixel clock.

    Everything before the first falling edge of ``vsync`` is ignored. From then on every clock of every line must follow the format, with
    ``vsync`` changing at a line's first pixel, and colours must be 0 outside ``de``; otherwise :class:`TimingError` is raised. So it is if
    there is no edge of ``vsync`` for the time of two frames.

    Parameters
    ----------
    display : :class:`DisplayFormat`
    keep : int
        Number of pictures to keep, the latest ones; all by default.

    Attributes
    ----------
    pictures : deque of (height, width, 3) uint8 ndarray
        Red, green, blue of the whole active area; a picture is appended at the end of its frame, just before ``vsync`` falls.
    frames : int
        Complete frames.
    """
    def __init__(self, display: DisplayFormat, *, keep: int | None = None):
        self.display = display
        self.pictures: deque[np.ndarray] = deque(maxlen=keep)
        self.frames = 0
        x = np.arange(display.h_total)
        de = (x < display.width).astype(np.uint32)
        hsync = ~np.isin(x, display.h_sync) & 1
        # The flags of a line, by whether it is active and whether vsync is low in it.
        self._flags = {(active, low): de * active | hsync << 1 | (not low) << 2 for active in (False, True) for low in (False, True)}
        self._picture = np.zeros((display.height, display.width), dtype=np.uint32)
        self._line: list[int] = []
        self._y: int | None = None  # not locked
        self._before = 0

    def restart(self) -> None:
        """Ignore everything up to the next falling edge of ``vsync``, as at first."""
        self._y = None
        self._before = 0
        self._line.clear()

    def clock(self, word: int) -> None:
        """Sample the :data:`PINS` in a pixel clock."""
        line = self._line
        if self._y is None:
            falls = self._before >> 26 & ~(word >> 26) & 1
            self._before = word
            if not falls:
                line.append(0)
                if len(line) > 2 * self.display.h_total * self.display.v_total:
                    raise TimingError("vsync has not fallen for the time of two frames")
                return
            self._y = self.display.v_sync.start
            line.clear()
        line.append(word)
        if len(line) == self.display.h_total:
            self._end_line(self._y)
            line.clear()

    def _end_line(self, y: int) -> None:
        display = self.display
        words = np.array(self._line, dtype=np.uint32)
        flags = self._flags[y < display.height, y in display.v_sync]
        wrong = np.flatnonzero(words >> 24 != flags)
        if wrong.size:
            found, wanted = ({name: int(value) >> bit & 1 for bit, name in enumerate(("de", "hsync", "vsync"))}
                             for value in (words[wrong[0]] >> 24, flags[wrong[0]]))
            raise TimingError(f"frame {self.frames}, line {y}, column {wrong[0]}: {found} instead of {wanted}")
        coloured = np.flatnonzero(words[flags & 1 == 0] & 0xFFFFFF)
        if coloured.size:
            raise TimingError(f"frame {self.frames}, line {y}: a colour outside de")
        if y < display.height:
            self._picture[y] = words[:display.width]
        self._y = (y + 1) % display.v_total
        if self._y == display.v_sync.start:
            self.frames += 1
            self.pictures.append(np.stack([self._picture >> place & 255 for place in (16, 8, 0)], axis=-1).astype(np.uint8))


def watch_amaranth(monitor: Monitor, pins: Any, *, domain: str = "display") -> Callable[[Any], Coroutine[Any, Any, None]]:
    """Background testbench for Amaranth's simulator; ``pins`` has the members :data:`PINS`."""
    async def testbench(ctx: Any) -> None:
        async for _, _, word in ctx.tick(domain).sample(Cat(getattr(pins, name) for name in PINS)):
            monitor.clock(word)
    return testbench


async def watch_cocotb(monitor: Monitor, clock: Any, pins: Mapping[str, Any]) -> None:
    """Run in the background (``cocotb.start_soon``); ``pins``: handles by the names of :data:`PINS`.

    Pins change with the rising edge and are sampled with the falling one; X is an error.
    """
    from cocotb.triggers import FallingEdge  # here, so that the model can be used without cocotb

    places = [(pins[name], sum(bits for _, bits in list(PINS.items())[:index])) for index, name in enumerate(PINS)]
    edge = FallingEdge(clock)
    while True:
        await edge
        word = 0
        for handle, place in places:
            word |= int(handle.value) << place
        monitor.clock(word)

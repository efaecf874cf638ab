"""The frame store's rule: which buffer a camera fills, which two frames are a pair, which picture is shown.

**Frames.** The *latest* frame of a camera is complete and not yet in a pair; it is replaced when a newer one is complete, and expires when
it is ``life`` clocks old. The latest frames of both cameras are a pair if they began no more than ``window`` clocks apart, no other pair is
being read, the pictures of the pair before are finished, and a slot for new ones is free. Otherwise they wait.

**Buffers.** A frame that begins gets the lowest buffer that is neither being read nor holds the latest frame. If there is none it is
skipped: giving up the latest frame instead would lose more pairs where reading is too slow for double buffers (with a reading time of 3/4
of a period 18 of 100, not 12).

**Slots.** A shown picture has two planes, disparity and left grey, written in parallel into a slot. It is complete when both are, and
abandoned if either is. The display locks a slot from one fetch to the next, and each fetch switches to the latest complete picture.

**Keeping.** While it is asked for, the first pair that starts is kept: its two buffers and its slot are not written again until the pair is
let go, so that a slow reader finds three pictures of one moment. If the picture of that pair is abandoned, the pair is let go at once, and
the next one that starts is kept in its place. With a buffer more of each kind than :func:`buffers_needed` cameras, matcher and display do
not notice: those that are not kept are as many as without.

**The host's pair.** While pairs are the host's, frames of the cameras are written as ever and expire without a partner, and no pair of them
starts. The host's pair has buffers of its own, which no camera fills. It is matched once for each time that this is asked for, as soon as
no other pair is being read, and a slot is free; it may be kept as any other. Then the cameras' next two frames are a pair again.

**Why** a window of 5/8 of a period: from 1/2 on, every frame of the slower camera has a partner at any phase. The additional eighth is
hysteresis: once the phase has drifted past it, frames pair the other way round, 3/8 apart, and jitter does not reverse that. A frame waits
at most 5/8 of a period for its partner, and must then be read before its buffer is needed again: within two periods, less the time in
which a frame fills a buffer, less those 5/8. So double buffers are enough for a reading time of 3/8 of a period (:func:`buffers_needed`).

Guarantees, checked by :func:`golden.video.drift.violations`: no buffer is written while it is read, shown or kept; frames of a pair began
no more than ``window`` apart, hence less than a period; each is used once at most, and in order; none is older than ``life``, whatever
cameras and memory do; the shown picture changes at a fetch only.

Times are whole clocks.
"""

from collections.abc import Collection
from fractions import Fraction
from typing import NamedTuple

from .buffers import Camera, Pictures


__all__ = ["CAMERAS", "LIVES", "PLANES", "WINDOW", "Pair", "Pairing", "buffers_needed", "check_window"]


#: Greatest time between the beginnings of a pair's frames, in frame periods.
WINDOW = Fraction(5, 8)
#: Age at which a frame without a partner expires, in windows: 2.5 periods. Only a lost camera or a stalled memory leads to it.
LIVES = 4

#: Writers of frames, and of the two planes of shown pictures, by the names of the gateware's interfaces.
CAMERAS = ("left_camera", "right_camera")
PLANES = ("disparity_plane", "left_plane")


class Pair(NamedTuple):
    """Buffers of a pair's frames, and the slot of its picture."""
    left: int
    right: int
    slot: int


class Pairing:
    """The rule, clock by clock or event by event.

    Attributes
    ----------
    buffers : int
        Of each camera, and slots; also the number of the host's buffer.
    cameras : tuple of :class:`Camera`
        Left, right.
    pictures : :class:`Pictures`
    hold : bool
        No new pair starts.
    keep : bool
        The next pair is kept, unless one is.
    kept : :class:`Pair` or None
        The pair that is kept, from its start on.
    reading : bool
        A pair is being read.
    host : bool
        Pairs are the host's.
    host_waits, host_reads : bool
        The host's pair is to be matched; it is the pair that is being read, or was read last.
    pairs : int
        Pairs started.
    """
    def __init__(self, buffers: int, window: int, life: int | None = None) -> None:
        if buffers < 2:
            raise ValueError(f"a frame store has at least 2 buffers for each picture, not {buffers!r}")
        self.buffers = buffers
        self.window = window
        self.life = LIVES * window if life is None else life
        self.cameras = (Camera(buffers, self.life), Camera(buffers, self.life))
        self.pictures = Pictures(buffers)
        self.hold = self.keep = False
        self.kept: Pair | None = None
        self._kept_read = False
        self.reading = False
        self.host = self.host_waits = self.host_reads = False
        self.read_at = 0
        self.pairs = 0

    def decide(self, now: int) -> Pair | None:
        """Start a pair if the state before clock ``now`` allows it."""
        left, right = self.cameras
        slot = self.pictures.free()
        if self.hold or self.reading or slot is None:
            return None
        if self.host:
            if not self.host_waits:
                return None
            pair = Pair(self.buffers, self.buffers, slot)
        else:
            if left.latest is None or right.latest is None:
                return None
            oldest = min(left.latest_began, right.latest_began)
            if abs(left.latest_began - right.latest_began) > self.window or now - oldest >= self.life:
                return None
            pair = Pair(left.latest, right.latest, slot)
            for camera in self.cameras:
                camera.reading, camera.latest = camera.latest, None
        self.pictures.start(slot)
        self.reading, self.host_waits, self.host_reads = True, False, self.host
        self.pairs += 1
        if self.keep and self.kept is None:
            self._set_kept(pair)
        return pair

    def _set_kept(self, pair: Pair | None) -> None:
        self.kept = pair
        left, right = self.cameras
        # No camera fills the host's buffers.
        left.kept, right.kept = pair[:2] if pair and pair.left < self.buffers else (None, None)
        self.pictures.kept = pair and pair.slot
        self._kept_read = self.pictures.kept_complete = False

    @property
    def kept_whole(self) -> bool:
        """A kept pair has been read, and its picture is complete: all of it may be read from memory."""
        return self._kept_read and self.pictures.kept_complete

    def settle_kept(self) -> None:
        """The end of a clock: a pair is let go that is not to be kept any more, or whose picture was abandoned."""
        abandoned = self.kept is not None and not self.pictures.kept_complete and self.pictures.writing != self.kept.slot
        if abandoned or not self.keep:
            self._set_kept(None)

    def done(self, now: int) -> None:
        """The pair has been read; no effect if none is being read."""
        if self.reading:
            self.reading = False
            self.read_at = now
            self._kept_read = self.kept is not None
            for camera in self.cameras:
                camera.reading = None

    def clock(self, now: int, events: Collection[str] = ()) -> Pair | None:
        """Simulate one clock; to be called for each.

        Events of one clock are processed in this order:

        1. a pair starts, if the state before allows it; a pair is read (``done``), if it started before
        2. frames expire; a picture is given up if it is not finished ``life`` clocks after its pair was read
        3. frames end: ``abandoned``, else ``complete``
        4. frames ``begin``
        5. planes end, then planes ``begin``, the picture may thereby be finished
        6. the display's ``fetch``
        7. ``hold`` or ``release``, ``keep`` or ``let_go``, ``host`` or ``cameras`` as the source of pairs, ``put`` to have the host's
           matched, which take effect in the next clock, as does it that the picture of a kept pair was abandoned

        Parameters
        ----------
        now : int
            One more than in the previous call.
        events : collection of str
            ``"done"``, ``"fetch"``, ``"hold"``, ``"release"``, ``"keep"``, ``"let_go"``, ``"host"``, ``"cameras"``, ``"put"``, and
            ``begin``, ``complete``, ``abandoned`` of each writer after its name and a dot: ``"left_camera.begin"``.

        Returns
        -------
        :class:`Pair` or None
            The pair that starts in this clock; the gateware's ``start`` is a clock later.
        """
        give_up = self.pictures.writing is not None and not self.reading and now - self.read_at >= self.life
        pair = self.decide(now)
        if "done" in events and pair is None:
            self.done(now)
        if give_up:
            self.pictures.give_up()
        for name, camera in zip(CAMERAS, self.cameras, strict=True):
            camera.expire(now)
            if f"{name}.abandoned" in events or f"{name}.complete" in events:
                camera.end(now, f"{name}.abandoned" not in events)
            if f"{name}.begin" in events:
                camera.begin(now)
        # Events of a plane in the clock of the start do not belong to this pair: ``start`` is a clock later.
        for plane, name in enumerate(PLANES if pair is None else ()):
            if f"{name}.abandoned" in events or f"{name}.complete" in events:
                self.pictures.end(plane, f"{name}.abandoned" not in events)
            if f"{name}.begin" in events:
                self.pictures.begin(plane)
        self.pictures.settle()
        if "fetch" in events:
            self.pictures.fetch()
        if "hold" in events or "release" in events:
            self.hold = "hold" in events
        if "keep" in events or "let_go" in events:
            self.keep = "keep" in events
        if "host" in events or "cameras" in events:
            self.host = "host" in events
        self.host_waits = self.host and (self.host_waits or "put" in events)
        self.settle_kept()
        return pair


def check_window(window: Fraction | float) -> None:
    """Raise :class:`ValueError` unless ``window``, in frame periods, is valid."""
    if not 0 < window < 1:
        raise ValueError(f"the window of a pair must be above 0 and below 1 frame, not {window}")


def buffers_needed(read_seconds: float, period_seconds: float, window: Fraction | float = WINDOW) -> int:
    """Buffers for each picture with which no frame is skipped, whatever the phase of the cameras.

    Assumes that a frame takes a whole period to fill its buffer, slightly more than it does. The display must fetch at least twice a
    period: otherwise a pair waits for a slot.

    Parameters
    ----------
    read_seconds : float
        From a pair's start to the last pixel read: the matcher's time for a frame.
    period_seconds : float
        Of the cameras' frames.
    window : Fraction or float
        Greatest time between the beginnings of a pair's frames, in periods.

    Examples
    --------
    A pixel a clock, and 6 clocks a pixel, at 75 MHz:

    >>> [buffers_needed(720 * 576 * clocks / 75e6, 1 / 25) for clocks in (1, 6)]
    [2, 3]
    """
    if not 0 < read_seconds < period_seconds:
        raise ValueError(f"a pair must be read in less than the frame period of {period_seconds * 1e3:.4g} ms, "
                         f"not in {read_seconds * 1e3:.4g} ms")
    check_window(window)
    return 2 if read_seconds <= (1 - window) * period_seconds else 3

"""Buffers of the frame store: those of a camera's frames, and the slots of the shown pictures; :mod:`golden.video.pairing` has the rule."""

from enum import Enum


__all__ = ["Camera", "Pictures", "PlaneState"]


class Camera:
    """The buffers of one camera.

    Attributes
    ----------
    filling, latest, reading : int or None
        Buffers: the one being written, that of the latest frame, the one being read. No two are the same.
    kept : int or None
        Buffer of the kept pair's frame, which may be the one being read, and is neither of the other two.
    latest_began : int
        When the latest frame began.
    skipped, unpaired : int
        Frames for which no buffer was free; complete frames given up without a partner.
    """
    __slots__ = ("buffers", "filling", "filling_began", "kept", "latest", "latest_began", "life", "reading", "skipped", "unpaired")

    def __init__(self, buffers: int, life: int) -> None:
        self.buffers = buffers
        self.life = life
        self.filling: int | None = None
        self.latest: int | None = None
        self.reading: int | None = None
        self.kept: int | None = None
        self.filling_began = self.latest_began = 0
        self.skipped = self.unpaired = 0

    def expire(self, now: int) -> None:
        """Give up the latest frame if it has expired."""
        if self.latest is not None and now - self.latest_began >= self.life:
            self.latest = None
            self.unpaired += 1

    def end(self, now: int, complete: bool) -> None:
        """The frame being written is complete, or abandoned; no effect if there is none."""
        self.expire(now)
        if complete and self.filling is not None:
            if now - self.filling_began >= self.life:
                self.unpaired += 1
            else:
                self.unpaired += self.latest is not None
                self.latest, self.latest_began = self.filling, self.filling_began
        self.filling = None

    def begin(self, now: int) -> int | None:
        """A frame begins: the buffer for it, or ``None`` to skip it. A frame still being written is abandoned."""
        self.expire(now)
        self.filling = None
        for buffer in range(self.buffers):
            if buffer not in (self.latest, self.reading, self.kept):
                self.filling, self.filling_began = buffer, now
                return buffer
        self.skipped += 1
        return None


class PlaneState(Enum):
    """State of one plane of the picture that is being written."""
    AWAITED = 0
    FILLING = 1
    COMPLETE = 2
    ABANDONED = 3


class Pictures:
    """The slots of the shown pictures.

    Attributes
    ----------
    writing, latest, shown : int or None
        Slots: the one being written, that of a complete picture not shown yet, the one being shown. No two are the same.
    kept : int or None
        Slot of the kept pair, which may be any of the three; once its picture is complete, it is not written.
    kept_complete : bool
        The picture of the kept pair is complete.
    planes : list of :class:`PlaneState`
        Of the picture being written.
    dropped, abandoned : int
        Complete pictures replaced by another one before a fetch; pictures that were not completed.
    """
    __slots__ = ("abandoned", "dropped", "kept", "kept_complete", "latest", "planes", "shown", "slots", "writing")

    def __init__(self, slots: int) -> None:
        self.slots = slots
        self.writing: int | None = None
        self.latest: int | None = None
        self.shown: int | None = None
        self.kept: int | None = None
        self.kept_complete = False
        self.planes = [PlaneState.AWAITED] * 2
        self.dropped = self.abandoned = 0

    def free(self) -> int | None:
        """The slot for a new picture; ``None`` while one is being written, or if no slot is free."""
        if self.writing is None:
            for slot in range(self.slots):
                if slot not in (self.latest, self.shown, self.kept):
                    return slot
        return None

    def start(self, slot: int) -> None:
        """A pair starts, whose picture is written into ``slot``."""
        self.writing = slot
        self.planes = [PlaneState.AWAITED] * 2

    def end(self, plane: int, complete: bool) -> None:
        """A plane is complete, or abandoned; no effect if it had not begun since the pair started."""
        if self.writing is not None and self.planes[plane] is PlaneState.FILLING:
            self.planes[plane] = PlaneState.COMPLETE if complete else PlaneState.ABANDONED

    def begin(self, plane: int) -> bool:
        """A plane begins: whether it may be written, once for each pair. If it begins twice the picture is abandoned."""
        if self.writing is None:
            return False
        if self.planes[plane] is PlaneState.FILLING:
            self.planes[plane] = PlaneState.ABANDONED
        if self.planes[plane] is not PlaneState.AWAITED:
            return False
        self.planes[plane] = PlaneState.FILLING
        return True

    def settle(self) -> None:
        """Finish the picture if both planes are finished."""
        if self.writing is None or PlaneState.AWAITED in self.planes or PlaneState.FILLING in self.planes:
            return
        if PlaneState.ABANDONED in self.planes:
            self.give_up()
            return
        self.dropped += self.latest is not None
        self.kept_complete |= self.writing == self.kept
        self.latest, self.writing = self.writing, None

    def give_up(self) -> None:
        """The picture being written will not be completed."""
        self.writing = None
        self.abandoned += 1

    def fetch(self) -> None:
        """The display begins a frame: it switches to the latest picture, if there is one."""
        if self.latest is not None:
            self.shown, self.latest = self.latest, None

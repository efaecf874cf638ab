"""Video formats of cameras and monitors, shared by gateware, models and boards."""

from dataclasses import dataclass


__all__ = ["DISPLAYS", "PAL", "VGA", "CameraFormat", "DisplayFormat"]


@dataclass(frozen=True)
class CameraFormat:
    """Interlaced video in bytes, after ITU-R BT.656: each line is EAV, blanking, SAV, then ``Cb Y Cr Y`` for each two pixels.

    A frame is a top field (``F`` = 0), whose first active line is the picture's line 0, and a bottom field (``F`` = 1).

    Parameters
    ----------
    width : int
        Active pixels of a line, even.
    field_lines : int
        Active lines of a field; the picture has twice as many.
    blanking : int
        Bytes between EAV and SAV.
    before_top, after_top, before_bottom, after_bottom : int
        Blank lines (``V`` = 1) of each field before and after its active ones, where the ``F`` bit is that of the field.
    byte_clock_hz : int
        Nominal rate of the bytes.
    """
    width: int = 720
    field_lines: int = 288
    blanking: int = 280
    before_top: int = 22
    after_top: int = 2
    before_bottom: int = 23
    after_bottom: int = 2
    byte_clock_hz: int = 27_000_000

    def __post_init__(self) -> None:
        if self.width < 2 or self.width % 2:
            raise ValueError(f"width must be an even number from 2 on, not {self.width!r}")
        for name in ("field_lines", "blanking", "before_top", "after_top", "before_bottom", "after_bottom"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, not {getattr(self, name)!r}")

    @property
    def height(self) -> int:
        """Lines of the picture."""
        return 2 * self.field_lines

    @property
    def line_bytes(self) -> int:
        """Bytes of a line, timing codes and blanking included."""
        return 8 + self.blanking + 2 * self.width

    @property
    def frame_lines(self) -> int:
        """Lines of a frame, blank ones included."""
        return self.before_top + self.after_top + self.before_bottom + self.after_bottom + self.height

    @property
    def frame_bytes(self) -> int:
        """Bytes of a frame."""
        return self.line_bytes * self.frame_lines

    @property
    def frame_seconds(self) -> float:
        """Nominal time of a frame."""
        return self.frame_bytes / self.byte_clock_hz


#: 625 lines, 50 fields a second.
PAL = CameraFormat()


@dataclass(frozen=True)
class DisplayFormat:
    """Timing of a progressive monitor picture, in pixels and lines, counted from the first active one.

    ``h_sync`` and ``v_sync`` are the ranges in which the sync signals are active; both are low active.
    """
    width: int
    h_sync: range
    h_total: int
    height: int
    v_sync: range
    v_total: int
    pixel_clock_hz: int

    def __post_init__(self) -> None:
        for active, sync, total in ((self.width, self.h_sync, self.h_total), (self.height, self.v_sync, self.v_total)):
            if not 0 < active <= sync.start < sync.stop <= total:
                raise ValueError(f"{active} active, sync {sync.start} to {sync.stop} and {total} in all are not in this order")

    @property
    def frames_per_second(self) -> float:
        return self.pixel_clock_hz / (self.h_total * self.v_total)


#: By name: CEA-861's 576p at 50 Hz, and VESA's XGA at 60 Hz.
DISPLAYS = {
    "720x576": DisplayFormat(720, range(732, 796), 864, 576, range(581, 586), 625, 27_000_000),
    "1024x768": DisplayFormat(1024, range(1048, 1184), 1344, 768, range(771, 777), 806, 65_000_000),
}

#: 640x480 at 60 Hz, with 25 MHz in place of 25.175: 0.7 % is within what monitors take.
VGA = DisplayFormat(640, range(656, 752), 800, 480, range(490, 492), 525, 25_000_000)

"""The whole chip in simulation: sizes of its benches."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from golden.bandwidth import MemoryTiming
from golden.config import Arithmetic, Engine, MatcherConfig
from golden.formats import CameraFormat, DisplayFormat
from hdl.emit import write_verilog
from hdl.video.system import StereoSystem


__all__ = ["CLOCK_HZ", "SETUP_HZ", "SIZES", "UART_CYCLES", "Size", "emit"]


#: Of ``sync``.
CLOCK_HZ = 75_000_000

#: As the set-up of the chips counts: a second of the chips has few clocks. The chips' models count as fast.
SETUP_HZ = 500_000

#: Clocks of a bit on the host's line.
UART_CYCLES = 16

TOP = "stereo_system"


@dataclass(frozen=True)
class Size:
    """A system of a size: matcher, cameras, monitor, timing that the memory is promised to have."""
    config: MatcherConfig
    camera: CameraFormat
    display: DisplayFormat
    timing: MemoryTiming


_CONFIG: dict[str, Any] = {"arithmetic": Arithmetic.LINEAR, "engine": Engine.STREAMING}

#: By name. A monitor's frame takes half as long as a camera's or less, as the frame store wants it.
SIZES = {
    "small": Size(
        MatcherConfig(disparities=8, max_width=32, **_CONFIG),
        CameraFormat(32, 12, blanking=8, before_top=2, after_top=1, before_bottom=2, after_bottom=1),
        DisplayFormat(40, range(44, 50), 80, 28, range(30, 32), 36, 65_000_000),
        MemoryTiming(row_clocks=2, turn_clocks=2)),
}


def emit(size: Size, path: Path) -> Path:
    """Write the Verilog of the system, module ``stereo_system``; return the path."""
    system = StereoSystem(size.config, size.display, camera=size.camera, timing=size.timing, baud=CLOCK_HZ // UART_CYCLES,
                          setup_hz=SETUP_HZ)
    return write_verilog(system, path, name=TOP)

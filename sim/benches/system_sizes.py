"""Systems that benches simulate, from two cameras to the monitor: their sizes, clocks and the rate of the host's line."""

from dataclasses import dataclass

from golden.config import FUSED_1, RECURSIVE_2, Arithmetic, Engine, MatcherConfig, Method, OnePass, changed
from golden.video.bandwidth import MemoryTiming
from golden.video.formats import DISPLAYS, PAL, CameraFormat, DisplayFormat
from hdl.video.system import StereoSystem


__all__ = ["CLOCK_HZ", "SETUP_HZ", "SIZES", "TOP", "UART_CYCLES", "Size"]


#: Clock rate of the domain ``sync``.
CLOCK_HZ = 75_000_000

#: Clock rate that the set-up of the chips assumes, and their models use: low, so that their pauses have few clocks.
SETUP_HZ = 500_000

#: Clocks of a bit on the host's line.
UART_CYCLES = 16

#: Name of the Verilog module.
TOP = "stereo_system"


@dataclass(frozen=True)
class Size:
    """Parameters of a system: matcher, cameras, monitor, worst timing of the memory."""
    config: MatcherConfig
    camera: CameraFormat
    display: DisplayFormat
    timing: MemoryTiming

    def system(self) -> StereoSystem:
        return StereoSystem(self.config, self.display, camera=self.camera, timing=self.timing, baud=CLOCK_HZ // UART_CYCLES,
                            setup_hz=SETUP_HZ)


def _small(method: Method, minimum: int = 0) -> Size:
    return Size(
        MatcherConfig(8, 32, minimum, engine=Engine.STREAMING, method=method),
        CameraFormat(32, 12, blanking=8, before_top=2, after_top=1, before_bottom=2, after_bottom=1),
        DisplayFormat(40, range(44, 50), 80, 28, range(30, 32), 36, 65_000_000),
        MemoryTiming(row_clocks=2, turn_clocks=2))


#: By name. A monitor's frame is at most half as long as a camera's, as the frame store requires.
SIZES = {
    "small": _small(OnePass(Arithmetic.LINEAR)),
    "small fused": _small(changed(FUSED_1, sub_pixel=True), minimum=-2),  # with all of it that the monitor sees
    "small recursive": _small(changed(RECURSIVE_2, sub_pixel=True), minimum=-2),
    "full": Size(MatcherConfig(80, PAL.width, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR)),
                 PAL, DISPLAYS["720x576"], MemoryTiming()),
}

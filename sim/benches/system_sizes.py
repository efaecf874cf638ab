"""Systems that benches simulate, from two cameras to the monitor: their sizes, clocks and the rate of the host's line."""

import dataclasses
from dataclasses import dataclass

from golden.config import FUSED_1, RECURSIVE_2, Arithmetic, Engine, MatcherConfig, Method, OnePass, changed
from golden.lab.mounting import Mounting
from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.video.bandwidth import MemoryTiming
from golden.video.formats import DISPLAYS, PAL, CameraFormat, DisplayFormat
from hdl.video.system import StereoSystem
from sim.kit.rig_cases import noise_map


__all__ = ["CLOCK_HZ", "MOUNTING", "SETUP_HZ", "SIZES", "TOP", "UART_CYCLES", "Size", "mounted", "noise_rig"]


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
    """Parameters of a system: matcher, cameras, monitor, worst timing of the memory, rectification and balance."""
    config: MatcherConfig
    camera: CameraFormat
    display: DisplayFormat
    timing: MemoryTiming
    rig: RigConfig | None = None

    def system(self) -> StereoSystem:
        return StereoSystem(self.config, self.display, camera=self.camera, timing=self.timing, baud=CLOCK_HZ // UART_CYCLES,
                            setup_hz=SETUP_HZ, rig=self.rig)


def _small(method: Method, minimum: int = 0, rig: RigConfig | None = None) -> Size:
    return Size(
        MatcherConfig(8, 32, minimum, engine=Engine.STREAMING, method=method),
        CameraFormat(32, 12, blanking=8, before_top=2, after_top=1, before_bottom=2, after_bottom=1),
        DisplayFormat(40, range(44, 50), 80, 28, range(30, 32), 36, 65_000_000),
        MemoryTiming(row_clocks=2, turn_clocks=2), rig)


#: Two cameras as one mounts them, for pictures of the full size.
MOUNTING = Mounting(vignetting=0.3, noise=2.0)


def noise_rig(seed: int, row_offset: int, width: int = 32, height: int = 24) -> Rig:
    """A rig for the small systems, of random displacements up to three pixels."""
    left, right = (noise_map(width, height, 90, seed + camera) for camera in (0, 1))
    return Rig(left, right, row_offset)


def _least(method: Method, minimum: int = 0, rig: RigConfig | None = None) -> Size:
    """The smallest pictures."""
    return Size(
        MatcherConfig(5, 20, minimum, engine=Engine.STREAMING, method=method),
        CameraFormat(20, 8, blanking=20, before_top=2, after_top=1, before_bottom=2, after_bottom=1),
        DisplayFormat(24, range(28, 34), 56, 18, range(20, 22), 29, 65_000_000),
        MemoryTiming(row_clocks=2, turn_clocks=2), rig)


#: By name. A monitor's frame is at most half as long as a camera's, as the frame store requires.
SIZES = {
    "small": _small(OnePass(Arithmetic.LINEAR)),
    # With all of it that the monitor sees.
    "small fused": _small(changed(FUSED_1, sub_pixel=True), minimum=-2, rig=RigConfig(22, noise_rig(1, 2))),
    # The same in the smallest pictures.
    "glance": _least(changed(FUSED_1, sub_pixel=True), minimum=-2, rig=RigConfig(22, noise_rig(1, 2, 20, 16))),
    "least": _least(OnePass(Arithmetic.LINEAR)),
    "least recursive": _least(changed(RECURSIVE_2, sub_pixel=True), minimum=-2),
    "small recursive": _small(changed(RECURSIVE_2, sub_pixel=True), minimum=-2),
    "full": Size(MatcherConfig(80, PAL.width, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR)),
                 PAL, DISPLAYS["720x576"], MemoryTiming(), RigConfig()),
}


def mounted() -> Size:
    """The full size, built for :data:`MOUNTING`."""
    return dataclasses.replace(SIZES["full"], rig=RigConfig(rig=MOUNTING.rig(PAL.width, PAL.height)))

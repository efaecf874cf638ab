"""Both stages of mounted cameras in one design: rectification, then balance."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from golden.rig.maps import WORD_BITS, RectifyMap
from hdl.matcher.stream import PixelPair
from hdl.rig.balance import Balance, BalanceMode
from hdl.rig.rectifier import Rectifier
from sim.kit.cases import noise
from sim.kit.rig_cases import camera_map, noise_map


__all__ = ["RigStages", "maps_of", "pictures_of"]


class RigStages(wiring.Component):
    """A rectifier and a balance behind it; members as of both."""
    def __init__(self, max_width: int, max_height: int, lines: int, labels: int, maps: Mapping[str, Sequence[int]]):
        self.rectifier = Rectifier(max_width, max_height, lines, maps=maps)
        self.balance = Balance(max_width, max_height, labels)
        settings: dict[str, ShapeLike] = {
            "enable": 1, "map_write": 2, "map_address": range(self.rectifier.words), "map_data": WORD_BITS, "swap": 1, "clear": 1,
            "mode": BalanceMode, "fixed_gain": 10, "fixed_offset": signed(16), "width": range(max_width + 1),
            "height": range(max_height + 1), "minimum": signed(9),
        }
        super().__init__({
            "i": In(stream.Signature(PixelPair())), "o": Out(stream.Signature(PixelPair())),
            **{name: In(shape) for name, shape in settings.items()},
            "error": Out(1), "fault": Out(1), "abandoned": Out(8), "swapping": Out(1), "gain": Out(10), "offset": Out(signed(16)),
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.rectifier = rectifier = self.rectifier
        m.submodules.balance = balance = self.balance
        wiring.connect(m, wiring.flipped(self.i), rectifier.i)
        wiring.connect(m, rectifier.o, balance.i)
        wiring.connect(m, balance.o, wiring.flipped(self.o))
        for stage in (rectifier, balance):
            for name, member in stage.signature.members.items():
                if member.is_port and name in self.signature.members:
                    if member.flow is In:
                        m.d.comb += getattr(stage, name).eq(getattr(self, name))
                    else:
                        m.d.comb += getattr(self, name).eq(getattr(stage, name))
        return m


def maps_of(case: Mapping[str, Any], second: bool) -> list[RectifyMap]:
    """Maps of both cameras: the first ones, or those that are loaded later."""
    width, height = case["width"], case["height"]
    if width < 64:      # too few pixels to fit a lens to
        return [noise_map(width, height, 90, seed) for seed in ((3, 4) if second else (1, 2))]
    left, right = {"roll": 1, "lens": -0.1, "gain": 200}, {"roll": -1, "offset": 1.3, "lens": -0.05}
    return [camera_map(width, height, **camera) for camera in ((right, left) if second else (left, right))]


def pictures_of(case: Mapping[str, Any]) -> list[tuple[NDArray[Any], NDArray[Any]]]:
    """Pairs: noise, the right one darker."""
    pairs = [noise(case["width"], case["height"], seed) for seed in range(case["frames"])]
    return [(left, (np.where(right < 250, left, right) * 3) >> 2) for left, right in pairs]

"""Rectification and balance of the pairs of the video system, with members as the host's registers."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.rig.config import MapsInUse, RigConfig
from golden.video.formats import CameraFormat

from ..matcher.matcher import Matcher
from ..matcher.stream import PixelPair
from ..rig.control import ROWS, RigControl
from ..rig.stages import RigStages


__all__ = ["PairRig"]


class PairRig(wiring.Component):
    """:class:`RigStages`, with settings that hold for a pair.

    Golden: :meth:`golden.rig.files.Rig.rectified`, then :class:`golden.rig.balance.Auto` or :class:`golden.rig.balance.Fixed`.

    Parameters
    ----------
    rig : RigConfig
        :class:`ValueError` if it is for pictures of another size.
    config : MatcherConfig
    camera : CameraFormat

    Members
    -------
    i, o : streams of PixelPair
    start, clear : In(1)
        A pair starts, whose first pixel is not before the next cycle; counters are set to 0.
    rectify .. map_high : In, map_start, map_next, map_swap : In(1), map .. map_abandoned : Out
        Settings, actions and status of :func:`golden.host.registers.register_map`, by their names.
    minimum : In(signed(9))
        Least disparity.
    used_row_offset : Out(signed(8))
        Of the pair that starts, in the cycle of ``start``.
    """
    SETTINGS = ("rectify", "balance", "fixed_gain", "fixed_offset", "row_offset", "map_side", "map_address", "map_low", "map_middle",
                "map_high")
    ACTIONS = ("map_start", "map_next", "map_swap")
    STATUS = ("map", "map_swapping", "map_sum", "map_fault", "left_mean", "right_mean", "left_deviation", "right_deviation", "gain",
              "offset", "map_abandoned")

    def __init__(self, rig: RigConfig, config: MatcherConfig, camera: CameraFormat):
        rig.check_size(camera.width, camera.height)
        self.camera = camera
        self.stages = stages = RigStages(camera.width, camera.height, config.labels, rig.lines, maps=rig.maps)
        self.control = RigControl(built_in=rig.rig is not None, row_offset=rig.row_offset)
        of_stages = stages.signature.members
        super().__init__({
            "i": In(stream.Signature(PixelPair())), "o": Out(stream.Signature(PixelPair())),
            "start": In(1), "clear": In(1), "minimum": of_stages["minimum"], "row_offset": In(ROWS), "used_row_offset": Out(ROWS),
            **{name: of_stages[name] for name in (*self.SETTINGS, *self.ACTIONS) if name in of_stages},
            "map_swap": In(1), "map": Out(MapsInUse), "map_swapping": Out(1), "map_fault": Out(1), "map_abandoned": Out(8),
            **{name: of_stages[name] for name in self.STATUS if name in of_stages},
        })

    def frame_clocks(self, matcher: Matcher) -> int:
        """Bound of the cycles that a pair takes through the stages and a matcher behind them, for maps as those of
        :meth:`RigStages.frame_clocks`.
        """
        return self.stages.frame_clocks(self.camera.width, self.camera.height, matcher.frame_clocks)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.stages = stages = self.stages
        m.submodules.control = control = self.control
        wiring.connect(m, wiring.flipped(self.i), stages.i)
        wiring.connect(m, stages.o, wiring.flipped(self.o))
        held = control.held
        m.d.comb += [
            control.start.eq(self.start), control.swap.eq(self.map_swap), control.wanted_row_offset.eq(self.row_offset),
            *(control.settings[name].eq(getattr(self, name)) for name in held.shape().members),
            *(getattr(stages, name).eq(held[name]) for name in held.shape().members),
            stages.swap.eq(control.stages_swap), control.swapping.eq(stages.swapping), self.used_row_offset.eq(control.row_offset),
            stages.width.eq(self.camera.width), stages.height.eq(self.camera.height), stages.clear.eq(self.clear),
            *(getattr(stages, name).eq(getattr(self, name)) for name in (*self.SETTINGS, *self.ACTIONS)
              if name.startswith("map_") and name != "map_swap"),
            self.map.eq(control.maps), self.map_swapping.eq(control.waits), self.map_fault.eq(stages.fault),
            self.map_abandoned.eq(stages.abandoned),
            *(getattr(self, name).eq(getattr(stages, name)) for name in self.STATUS if name in stages.signature.members),
        ]
        return m

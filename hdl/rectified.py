"""A matcher for the pictures of two mounted cameras: rectification and balance, and behind them the matcher."""

from collections.abc import Mapping

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig, Setting
from golden.rig.balance import GAIN_ONE, GAINS, OFFSETS
from golden.rig.config import RigConfig

from .matcher.matcher import Matcher, matcher_ports
from .matcher.settings import setting_ports, setting_shape
from .rig.balance import BalanceMode
from .rig.stages import RigStages


__all__ = ["PIXEL_ORDER", "RectifiedMatcher"]


#: In which order pixels are received, for the manifest.
PIXEL_ORDER = ("raw pictures, progressive, line by line from the top and from left to right; the pixels of both cameras at a place are one "
               "word, and the right one's line y is line y + row_offset of its picture, whose first and last lines are repeated")


class RectifiedMatcher(wiring.Component):
    """Disparities of the raw pictures of two mounted cameras: :class:`hdl.rig.stages.RigStages` in front of a :class:`Matcher`.

    Golden: :func:`golden.matcher.matcher.match` of what :class:`RigStages` states: the pair of :meth:`golden.rig.files.Rig.rectified`, its
    right picture balanced by :class:`golden.rig.balance.Auto` or :class:`golden.rig.balance.Fixed`.

    Pixels are received line by line from the top, progressive, as the cameras saw them; the pixels of both cameras at a place are one word.
    The lines that maps need are buffered inside. The row offset of a rig is not: whoever reads the pictures sends line ``y + row_offset``
    of the right picture in the place of its line ``y``, with its first and last lines repeated beyond its edges
    (:func:`golden.rig.rectify.move_rows`).

    Frames have at most ``config.max_width`` times ``max_height`` pixels. A map is for one size, and so are the windows of the balance: the
    settings ``width`` and ``height``. Disparities of a ragged frame are those of the frame that :class:`hdl.rig.rectifier.Rectifier` makes
    of it.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles, and what a frame takes is in :meth:`frame_clocks`. A disparity is output
    :attr:`latency_lines` lines and at most :attr:`latency_clocks` cycles after the pixel of its place was accepted, as of :class:`Matcher`,
    if no line is taken from further below than the rectifier holds lines. ``i.ready`` does not depend on ``o.ready``.

    Parameters
    ----------
    config : MatcherConfig
    max_height : int
        Of a picture, pixels.
    rig : RigConfig
        :class:`ValueError` if its maps are for another size than ``config.max_width`` times ``max_height``.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(DisparityWord(config)))
    rectify, balance, fixed_gain, fixed_offset, width, height : In
        As of :class:`RigStages`.
    u1, u2, u3, in_use, further settings of the method, apply_settings : In
        As of :class:`Matcher`. A pulse of ``apply_settings`` puts the values of both rows into force; until the first one both pictures are
        rectified and the balance is *auto*, for frames of the greatest size.
    swap, map_side, map_start, map_address, map_next, map_low, map_middle, map_high : In
        Loading of maps, as of :class:`RigStages`. A reset changes no maps.
    swapping, map_sum, fault, abandoned, gain, offset, left_mean, right_mean, left_deviation, right_deviation : Out
        As of :class:`RigStages`.
    error : Out(1)
        A ragged frame was accepted; set until ``clear``.
    clear : In(1)
        As of the matcher, and of the rectifier.
    """
    #: Inputs that act or hold, and that no ``apply_settings`` puts into force.
    LOADING = ("swap", "map_side", "map_start", "map_address", "map_next", "map_low", "map_middle", "map_high")
    STATUS = ("swapping", "map_sum", "fault", "abandoned", "gain", "offset", "left_mean", "right_mean", "left_deviation", "right_deviation")

    def __init__(self, config: MatcherConfig, max_height: int, rig: RigConfig):
        rig.check_size(config.max_width, max_height)
        self.config = config
        self.rig = rig
        self.max_height = max_height
        self.stages = RigStages(config.max_width, max_height, config.labels, rig.lines, maps=rig.maps)
        self.matcher = Matcher(config)
        of_stages = self.stages.signature.members
        super().__init__({
            **matcher_ports(config),
            **{name: In(setting_shape(setting)) for name, setting in self.rig_settings.items()},
            **{name: In(of_stages[name].shape) for name in self.LOADING},
            **{name: Out(of_stages[name].shape) for name in self.STATUS},
        })

    @property
    def rig_settings(self) -> Mapping[str, Setting]:
        """The settings of rectification and balance, by name."""
        return {
            "rectify": Setting(1, 1, "both pictures are rectified"),
            "balance": Setting(max(BalanceMode), BalanceMode.AUTO, "of the right picture: off, auto, fixed"),
            "fixed_gain": Setting(GAINS[-1], GAIN_ONE, "of the right picture with the balance fixed", GAINS[0], "1/256"),
            "fixed_offset": Setting(OFFSETS[-1], 0, "of the right picture with the balance fixed", OFFSETS[0], "1/256 grey level"),
            "width": Setting(self.config.max_width, self.config.max_width, "of the pictures", 2, "pixels"),
            "height": Setting(self.max_height, self.max_height, "of the pictures", 2, "lines"),
        }

    @property
    def settings(self) -> Mapping[str, Setting]:
        """All settings, by name: those of rectification and balance, and those of the matcher."""
        return {**self.rig_settings, **self.config.settings}

    @property
    def clocks_per_pixel(self) -> int:
        """Cycles a pixel inside a line."""
        return self.matcher.clocks_per_pixel

    @property
    def full_rate_width(self) -> int:
        """As of the matcher."""
        return self.matcher.full_rate_width

    @property
    def latency_lines(self) -> int:
        """Lines from a pixel to the disparity of its place: those that the rectifier holds, and those of the matcher."""
        return self.rig.lines + self.matcher.latency_lines

    @property
    def latency_clocks(self) -> int:
        """Bound of a disparity's latency beyond :attr:`latency_lines` lines of ``clocks_per_pixel`` a pixel, in cycles."""
        rectifier, balancer = self.stages.rectifier, self.stages.balancer
        in_front = rectifier.latency + rectifier.QUEUE + balancer.latency + balancer.frame_clocks
        return self.latency_lines * rectifier.line_clocks + in_front + self.matcher.latency_clocks

    def frame_clocks(self, width: int, height: int) -> int:
        """Bound of the cycles from one frame's first disparity to the next one's, if neither ``i`` nor ``o`` stalls, and no line is taken
        from further below than the rectifier holds lines.
        """
        return self.stages.frame_clocks(width, height, self.matcher.frame_clocks)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.rig = stages = self.stages
        m.submodules.matcher = matcher = self.matcher
        wiring.connect(m, wiring.flipped(self.i), stages.i)
        wiring.connect(m, stages.o, matcher.i)
        wiring.connect(m, matcher.o, wiring.flipped(self.o))

        for name, setting in self.rig_settings.items():
            held = Signal.like(getattr(self, name), name=f"{name}_set", init=setting.default)
            with m.If(self.apply_settings):
                m.d.sync += held.eq(getattr(self, name))
            m.d.comb += getattr(stages, name).eq(held)
        # The least disparity is the matcher's setting, if its method has one, and moves the windows of the balance.
        if "minimum" in self.config.settings:
            minimum = Signal.like(self.minimum, name="minimum_of_balance", init=self.config.minimum)
            with m.If(self.apply_settings):
                m.d.sync += minimum.eq(self.minimum)
            m.d.comb += stages.minimum.eq(minimum)

        m.d.comb += [
            *(getattr(matcher, name).eq(getattr(self, name)) for name in (*setting_ports(self.config), "clear")),
            *(getattr(stages, name).eq(getattr(self, name)) for name in (*self.LOADING, "clear")),
            *(getattr(self, name).eq(getattr(stages, name)) for name in self.STATUS),
        ]
        # The matcher receives no ragged frame: the rectifier has made it whole, unless it copies.
        ragged = Signal()
        with m.If(stages.error):
            m.d.sync += ragged.eq(1)
        with m.Elif(self.clear):
            m.d.sync += ragged.eq(0)
        m.d.comb += self.error.eq(ragged | matcher.error)
        return m

"""All that stands between the cameras' pictures and the matcher, with members as registers of 16 bits drive them."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.rig.lines import DEFAULT_LINES
from golden.rig.maps import SUM_BITS, WORD_BITS

from ..matcher.stream import PixelPair
from .balance import Balance, BalanceMode
from .rectifier import Rectifier


__all__ = ["MapLoader", "RigStages"]


_NO_MAPS: Mapping[str, Sequence[int]] = MappingProxyType({})


class MapLoader(wiring.Component):
    """Writes the words of a map one after the other, from three parts each, and sums them up.

    Golden: :func:`golden.rig.maps.map_sum`.

    Timing: a word is written in the cycle of ``next``; its sum is there 4 cycles later, before which no other word must follow.

    Parameters
    ----------
    words : int
        Of a map.

    Members
    -------
    start : In(1)
        The next word is the one at ``address``, and the sum 0.
    address : In(range(words))
    next : In(1), low : In(16), middle : In(16), high : In(4)
        A word; they must hold for 4 cycles.
    write : Out(1), write_address : Out(range(words)), write_data : Out(36)
    sum : Out(16)
    """
    def __init__(self, words: int):
        super().__init__({
            "start": In(1), "address": In(range(words)),
            "next": In(1), "low": In(SUM_BITS), "middle": In(SUM_BITS), "high": In(WORD_BITS - 2 * SUM_BITS),
            "write": Out(1), "write_address": Out(range(words)), "write_data": Out(WORD_BITS), "sum": Out(SUM_BITS),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        adding = Signal(3)
        part   = Signal(SUM_BITS)
        m.d.comb += [self.write.eq(self.next), self.write_data.eq(Cat(self.low, self.middle, self.high))]
        m.d.comb += part.eq(Mux(adding[0], self.low, Mux(adding[1], self.middle, self.high)))
        m.d.sync += adding.eq(Cat(self.next, adding))
        with m.If(self.start):
            m.d.sync += [self.write_address.eq(self.address), self.sum.eq(0)]
        with m.Else():
            m.d.sync += self.write_address.eq(self.write_address + self.next)
            with m.If(adding.any()):
                m.d.sync += self.sum.eq(self.sum.rotate_left(1) + part)
        return m


class RigStages(wiring.Component):
    """Rectification and, behind it, balance of a pair.

    Golden: :meth:`golden.rig.files.Rig.rectified`, for cameras whose rows have been moved, then :class:`golden.rig.balance.Auto` or
    :class:`golden.rig.balance.Fixed`.

    Timing: a pixel a cycle; a frame takes :meth:`frame_clocks`.

    Parameters
    ----------
    max_width, max_height, lines, maps
        As of :class:`hdl.rig.rectifier.Rectifier`.
    labels : int
        Disparities.

    Members
    -------
    i, o : streams of PixelPair
    rectify, swap, swapping, error, fault, abandoned, clear
        As of the rectifier, whose ``enable`` is ``rectify``.
    balance : In(BalanceMode), fixed_gain, fixed_offset, width, height, minimum, gain, offset, and means and deviations
        As of :class:`hdl.rig.balance.Balance`, whose ``mode`` is ``balance``.
    map_side : In(1), map_start, map_address, map_next, map_low, map_middle, map_high, map_sum
        As of :class:`MapLoader`; side 0 is the left one.
    """
    _BALANCE = ("left_mean", "right_mean", "left_deviation", "right_deviation", "gain", "offset")

    def __init__(self, max_width: int, max_height: int, labels: int, lines: int = DEFAULT_LINES, *,
                 maps: Mapping[str, Sequence[int]] = _NO_MAPS):
        self.rectifier = Rectifier(max_width, max_height, lines, maps=maps)
        self.balancer = Balance(max_width, max_height, labels)
        self.loader = MapLoader(self.rectifier.words)
        of_balance = self.balancer.signature.members
        inputs: dict[str, ShapeLike] = {
            "rectify": 1, "swap": 1, "clear": 1, "balance": BalanceMode, "map_side": 1,
            **{name: of_balance[name].shape for name in ("fixed_gain", "fixed_offset", "width", "height", "minimum")},
            **{f"map_{name}": self.loader.signature.members[name].shape for name in ("start", "address", "next", "low", "middle", "high")},
        }
        super().__init__({
            "i": In(stream.Signature(PixelPair())), "o": Out(stream.Signature(PixelPair())),
            **{name: In(shape) for name, shape in inputs.items()},
            **{name: Out(of_balance[name].shape) for name in self._BALANCE},
            "swapping": Out(1), "error": Out(1), "fault": Out(1), "abandoned": Out(8), "map_sum": Out(SUM_BITS),
        })

    def frame_clocks(self, width: int, height: int, matcher: Callable[[int, int], int] | None = None) -> int:
        """Bound of the cycles from a frame's first pixel to the next one's, if neither ``i`` nor what is behind ``o`` stalls, and no line
        is taken from further below than the rectifier holds lines.

        Parameters
        ----------
        width, height : int
            Pixels.
        matcher : function
            The same bound of a matcher behind the stages. Each line then takes as long as in the slower of both, and between two frames
            the rectifier receives the lines that its maps need, while the matcher outputs its last ones.
        """
        if matcher:
            of_stages, of_matcher = self.frame_clocks(width, height), matcher(width, height)
            of_line = width + self.rectifier.line_clocks, matcher(width, height + 1) - of_matcher
            between = of_stages - height * of_line[0], of_matcher - height * of_line[1]
            return height * max(of_line) + max(between)
        lines = height + min(self.rectifier.lines, height)
        return lines * (width + self.rectifier.line_clocks) + self.balancer.frame_clocks + self.balancer.evaluation_clocks

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.rectifier = rectifier = self.rectifier
        m.submodules.balance = balancer = self.balancer
        m.submodules.loader = loader = self.loader
        wiring.connect(m, wiring.flipped(self.i), rectifier.i)
        wiring.connect(m, rectifier.o, balancer.i)
        wiring.connect(m, balancer.o, wiring.flipped(self.o))
        m.d.comb += [
            rectifier.enable.eq(self.rectify), rectifier.swap.eq(self.swap), rectifier.clear.eq(self.clear),
            rectifier.map_write.eq(Mux(loader.write, 1 << self.map_side, 0)), rectifier.map_address.eq(loader.write_address),
            rectifier.map_data.eq(loader.write_data), balancer.mode.eq(self.balance), self.map_sum.eq(loader.sum),
            *(getattr(loader, name).eq(getattr(self, f"map_{name}")) for name in ("start", "address", "next", "low", "middle", "high")),
            *(getattr(balancer, name).eq(getattr(self, name)) for name in ("fixed_gain", "fixed_offset", "width", "height", "minimum")),
            *(getattr(self, name).eq(getattr(rectifier, name)) for name in ("swapping", "error", "fault", "abandoned")),
            *(getattr(self, name).eq(getattr(balancer, name)) for name in self._BALANCE),
        ]
        return m

"""The support of a pixel: its arms with limits that get tighter, where their ends are in the rings of running sums, its reciprocal."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, GradedArms, MatcherConfig, Propagation, Recursive

from ...parts.delay import Delay
from ..stream import FLAGS
from ..streaming.support import StepDelay, SupportArms
from .source import SLOTS, Entry, Step


__all__ = ["JOINING", "TOTAL", "ArmSource", "LowerPixel", "Mean", "Summand", "SupportedPixel", "Supports", "mean_latency", "share_of",
           "sparing_delay"]


#: Cycles from carried costs to the sum of their share, :func:`share_of`, and a pixel's own.
JOINING = 3

#: Cycles from the ends of a support to the sum over it.
TOTAL = 3

# Words of a ring that starts of lines take: at most two lines are in a ring, each with one.
_STARTS = 4
# As many bits in flight for each memory block side by side are delayed in registers: here a block is scarcer than these.
_SMALL_DELAY = 240
_BLOCK_WIDTH = 36  # bits of the widest word of an M9K


def sparing_delay(shape: ShapeLike, clocks: int, *, clean: bool = False) -> Delay:
    """A :class:`hdl.parts.delay.Delay` that takes a memory block only for more than a few words."""
    width = Shape.cast(shape).width
    return Delay(shape, clocks, clean=clean, registers=clocks * width <= _SMALL_DELAY * -(-width // _BLOCK_WIDTH))


def share_of(m: Module, config: MatcherConfig, name: str, value: Value, share: Value) -> Signal:
    """``value * share >> 3``, floor, two cycles later; ``value`` at most ``carried_max``, ``share`` four bits."""
    method = config.method_as(Recursive)
    maximum = method.carried_max
    result = Signal(range((Propagation.SHARE_MAX * maximum >> Propagation.SHARE_BITS) + 1), name=f"{name}_share", reset_less=True)
    if not method.soft_multipliers:
        factor  = Signal.like(value, name=f"{name}_factor", reset_less=True)
        other   = Signal.like(share, name=f"{name}_other", reset_less=True)
        product = Signal(len(value) + len(share), name=f"{name}_product", reset_less=True)
        m.d.sync += [factor.eq(value), other.eq(share), product.eq(factor * other)]
        m.d.comb += result.eq(product >> Propagation.SHARE_BITS)
        return result
    low, high = (Signal(range(3 * maximum + 1), name=f"{name}_{part}", reset_less=True) for part in ("low", "high"))
    m.d.sync += [
        low.eq(Mux(share[0], value, 0) + Mux(share[1], value << 1, 0)), high.eq(Mux(share[2], value, 0) + Mux(share[3], value << 1, 0)),
        result.eq((low + (high << 2)) >> Propagation.SHARE_BITS),
    ]
    return result


def mean_latency(config: MatcherConfig) -> int:
    """Cycles from the ends of a support to its mean."""
    if config.method_as(Recursive).soft_multipliers:
        return TOTAL + GradedArms.RECIPROCAL_BITS.bit_length()    # a level for each bit of the number of rows
    return TOTAL + 2


class ArmSource(SupportArms):
    """Arms of the method recursive; golden: :func:`golden.matcher.recursive.arms.graded_arms`.

    Members
    -------
    Those of :class:`hdl.matcher.streaming.support.SupportArms`, and
    near, far, smooth : In(PIXEL_BITS)
        Grey levels by which a pixel may differ from the centre, near and far, and from the one stepped from.
    """
    def __init__(self, config: MatcherConfig):
        self.limits = config.method_as(Recursive).arms
        super().__init__(self.limits.reach, **dict.fromkeys(("near", "far", "smooth"), In(PIXEL_BITS)))

    def _comparisons(self, m: Module, taps: list[Signal], near: list[Signal], stepped: Signal) -> tuple[list[Value], list[Value]]:
        # In step with the differences, and negated here: a comparison with what is still to be negated would be two carry chains long.
        limits = {}
        for name in ("near", "far", "smooth"):
            most  = Signal(signed(PIXEL_BITS + 1), name=f"{name}_most", reset_less=True)
            least = Signal(signed(PIXEL_BITS + 1), name=f"{name}_least", reset_less=True)
            m.d.sync += [most.eq(getattr(self, name)), least.eq(-getattr(self, name))]
            limits[name] = most, least

        def within(value: Value, limit: str) -> Value:
            most, least = limits[limit]
            return (value <= most) & (value >= least)

        alike, differences = [], []
        for j, tap in enumerate(taps, 1):
            difference = Signal(signed(PIXEL_BITS + 1), name=f"difference_{j}", reset_less=True)
            flag       = Signal(name=f"alike_{j}", reset_less=True)
            m.d.sync += difference.eq(self.grey - tap)
            # A cycle later the pixel is among the taps: `near` includes it.
            m.d.sync += flag.eq(near[j - 1] & within(difference, "near" if j < self.limits.far_step else "far"))
            alike.append(flag)
            differences.append(difference)
        # Of the steps before, too.
        smooth = [Signal(name=f"smooth_{j}", reset_less=True) for j in range(self.reach)]
        m.d.sync += smooth[0].eq(within(differences[0], "smooth"))
        with m.If(stepped):
            m.d.sync += [flag.eq(source) for flag, source in zip(smooth[1:], smooth)]
        return [flag & level for flag, level in zip(alike, smooth)], [flag & smooth[0] for flag in alike]


class Summand(data.StructLayout):
    """A completion in step with its pixel's joined costs, and the address of the running sums."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"enter": 1, "clear": 1, "place": range(Supports.ring_of(config))})


class Mean(data.StructLayout):
    """Addresses of a support's running sums, before its first pixel and including its last one; its reciprocal."""
    def __init__(self, config: MatcherConfig):
        place = range(Supports.ring_of(config))
        super().__init__({"low": place, "high": place, "reciprocal": range((1 << GradedArms.RECIPROCAL_BITS) + 1)})


class SupportedPixel(data.StructLayout):
    """A pixel whose support is complete.

    ``step``: there is one, or padding. ``size``: pixels of its support. ``leads``, ``closes``, with a lead only: as of
    :class:`hdl.matcher.streaming.waves.Completion`.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({
            **({"leads": 1, "closes": 1} if config.lead else {}),
            "step": 1, "starts_line": 1, "in_picture": 1, "column": range(config.max_width), "grey": PIXEL_BITS,
            "size": range(config.method_as(Recursive).arms.support_max + 1), **FLAGS,
        })


class LowerPixel(data.StructLayout):
    """As :class:`SupportedPixel`, of the line below: all that is needed of it is its slot."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"step": 1, "in_picture": 1, "slot": range(SLOTS)})


class Supports(wiring.Component):
    """Addresses for the means over supports; golden: :func:`golden.matcher.recursive.arms.support_means`.

    Every label keeps the sums of its joined costs along the line in a ring, one more a line than it has pixels, as
    :class:`hdl.matcher.streaming.support.SupportSource` does.

    Timing: ``sums`` in the cycle of ``i``; ``mean``, ``centre`` and ``pixel`` ``latency + 1`` cycles after it, for the pixel completed
    ``reach + 1`` completions before.

    Parameters
    ----------
    config : MatcherConfig
    latency : int
        Cycles by which the sums are computed later than ``sums``.
    word, pixel : StructLayout
        A step and a pixel: of the line that is labelled, or of the one below.

    Members
    -------
    i : In(word)
    near, far, smooth : In(PIXEL_BITS)
        As of :class:`ArmSource`.
    sums : Out(Summand(config))
    mean : Out(Mean(config))
    centre : Out(range(ring))
        Address of the pixel's own running sum.
    pixel : Out(pixel)
    """
    def __init__(self, config: MatcherConfig, latency: int, word: Step | Entry, pixel: SupportedPixel | LowerPixel):
        self.config = config
        self.latency = latency
        super().__init__({
            "i": In(word), **dict.fromkeys(("near", "far", "smooth"), In(PIXEL_BITS)),
            "sums": Out(Summand(config)), "mean": Out(Mean(config)), "centre": Out(range(self.ring_of(config))),
            "pixel": Out(pixel),
        })

    @staticmethod
    def lag_of(config: MatcherConfig) -> int:
        """Completions from that of a pixel to that of the last one of its support, and one more: the sum there is then in the ring."""
        return config.method_as(Recursive).arms.reach + 1

    @staticmethod
    def ring_of(config: MatcherConfig) -> int:
        """Words of a ring, a power of two, so that addresses wrap.

        At the last use of a running sum the support is complete, its pixel the lag before and the sum an arm before that one. At the last
        use of an eighth of the costs from above the mean is there, for which that of a pixel the lag later has been joined.
        """
        lag = Supports.lag_of(config)
        return 1 << (lag + max(lag, JOINING + mean_latency(config)) + _STARTS).bit_length()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        completion = self.i.completion
        place = Signal(range(self.ring_of(config)))
        enter = completion.clear | completion.complete
        m.d.sync += place.eq(place + enter)
        m.d.comb += [self.sums.enter.eq(enter), self.sums.clear.eq(completion.clear), self.sums.place.eq(place)]

        m.submodules.arms = arms = ArmSource(config)
        m.d.comb += [arms.step.eq(completion.complete), arms.starts_line.eq(completion.starts_line), arms.grey.eq(self.i.grey)]
        m.d.comb += [getattr(arms, name).eq(getattr(self, name)) for name in ("near", "far", "smooth")]

        shape = self.pixel.shape()
        carried = {name: field.shape for name, field in shape if name not in ("step", "size")}
        waiting = data.StructLayout({**carried, "place": place.shape()})
        m.submodules.waiting = wait = StepDelay(waiting, self.lag_of(config))
        m.submodules.aligned = aligned = Delay(waiting, ArmSource.LATENCY - StepDelay.LATENCY)
        of_completion = set(completion.shape().members)
        m.d.comb += [wait.i[name].eq((completion if name in of_completion else self.i)[name]) for name in carried]
        m.d.comb += [
            wait.i.place.eq(place),
            wait.step.eq(completion.complete), aligned.i.eq(wait.o),
        ]
        stepped = [completion.complete]
        for stage in range(ArmSource.LATENCY):
            stepped.append(Signal(name=f"stepped_{stage}"))
            m.d.sync += stepped[-1].eq(stepped[-2])

        # The ends; a cycle later the reciprocal.
        place_shape = place.shape()
        outputs = data.StructLayout({"mean": Mean(config), "centre": place_shape})
        given_mean = Signal(outputs, reset_less=True)
        mean = given_mean.mean
        pixel = Signal(shape, reset_less=True)
        ends  = Signal(data.StructLayout(dict.fromkeys(("low", "high", "centre"), place_shape)), reset_less=True)
        size  = Signal(range(config.method_as(Recursive).arms.support_max + 1), reset_less=True)
        held  = Signal(waiting, reset_less=True)
        shown = Signal(2)   # with a reset: a pixel of a frame before it must not be passed on
        size_max = config.method_as(Recursive).arms.support_max
        reciprocals = Array([0, *((1 << GradedArms.RECIPROCAL_BITS) // n for n in range(1, size_max + 1))])
        m.d.sync += [
            ends.low.eq(aligned.o.place - arms.left_arm), ends.high.eq(aligned.o.place + arms.right_arm + 1),
            ends.centre.eq(aligned.o.place), size.eq(arms.left_arm + arms.right_arm + 1),
            held.eq(aligned.o), shown.eq(Cat(stepped[-1], shown)),
            mean.low.eq(ends.low), mean.high.eq(ends.high), given_mean.centre.eq(ends.centre), mean.reciprocal.eq(reciprocals[size]),
            *(pixel[name].eq(held[name]) for name in carried), *([pixel.size.eq(size)] if "size" in shape.members else []),
        ]
        given = Signal.like(pixel)
        m.d.comb += [given.eq(pixel), given.step.eq(shown[1]), given.in_picture.eq(pixel.in_picture & shown[1])]
        rest = self.latency + 1 - ArmSource.LATENCY - 2
        m.submodules.mean = mean_later = sparing_delay(outputs, rest)
        m.submodules.pixel = pixel_later = sparing_delay(shape, rest, clean=True)
        m.d.comb += [
            mean_later.i.eq(given_mean), self.mean.eq(mean_later.o.mean), self.centre.eq(mean_later.o.centre),
            pixel_later.i.eq(given), self.pixel.eq(pixel_later.o),
        ]
        return m

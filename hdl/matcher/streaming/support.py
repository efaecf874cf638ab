"""The support of a pixel on its line: its arms, and where their ends are in the memories of running sums."""

from abc import ABC, abstractmethod

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Member, Out

from golden.config import PIXEL_BITS, Fused, MatcherConfig

from ...parts.delay import Delay, data_register
from .waves import Completion, Pixel


__all__ = ["Arms", "Ends", "Slot", "StepDelay", "SumWave", "SupportArms", "SupportSource"]


class StepDelay(wiring.Component):
    """Outputs every word ``steps`` steps later; zero before there was one.

    Timing: ``o`` is, two cycles after a ``step``, the word of ``steps`` steps before.

    Memory: ``steps`` words.

    Members
    -------
    i : In(shape)
    step : In(1)
    o : Out(shape)
    """
    LATENCY = 2

    def __init__(self, shape: ShapeLike, steps: int):
        self.shape = shape
        self.steps = steps
        super().__init__({"i": In(shape), "step": In(1), "o": Out(shape)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory(shape=self.shape, depth=self.steps, init=[])
        read = memory.read_port()
        write = memory.write_port()
        place  = Signal(range(self.steps))
        around = Signal()  # every place has been written
        with m.If(self.step):
            m.d.sync += place.eq(place + 1)
            with m.If(place == self.steps - 1):
                m.d.sync += [place.eq(0), around.eq(1)]
        m.d.comb += [
            read.addr.eq(place), read.en.eq(self.step),
            write.addr.eq(place), write.data.eq(self.i), write.en.eq(self.step),
        ]
        stepped = Signal()
        in_picture    = Signal()
        m.d.sync += [stepped.eq(self.step), in_picture.eq(around)]
        o = data_register(m, self.o)
        with m.If(stepped):
            m.d.sync += o.eq(Mux(in_picture, Value.cast(read.data), 0))
        return m


class SupportArms(wiring.Component, ABC):
    """Arms of the support of every pixel on its line; a subclass tells how far they reach.

    Two pixels ``j`` apart are compared once, for the left arm of the one and the right arm of the other.

    Timing: ``left_arm`` and ``right_arm`` are, :attr:`LATENCY` cycles after a ``step``, those of the pixel ``reach + 1`` steps before.

    Members
    -------
    step : In(1)
        Advances by one pixel; ``grey`` may be padding.
    starts_line : In(1)
        The pixel is the first of its line, or padding.
    grey : In(PIXEL_BITS)
    left_arm, right_arm : Out(range(reach + 1))
    """
    LATENCY = 6

    def __init__(self, reach: int, **members: Member):
        self.reach = reach
        length = range(reach + 1)
        super().__init__({
            "step": In(1), "starts_line": In(1), "grey": In(PIXEL_BITS), **members, "left_arm": Out(length), "right_arm": Out(length),
        })

    @abstractmethod
    def _comparisons(self, m: Module, taps: list[Signal], near: list[Signal], stepped: Signal) -> tuple[list[Value], list[Value]]:
        """For each ``j``, two cycles after a step: whether the pixel is like the one ``j`` before it.

        Parameters
        ----------
        m : Module
        taps : list of Signal
            Grey levels of the pixels before, the latest first.
        near : list of Signal
            Which of them are on the pixel's line; a cycle after the step the pixel itself is included.
        stepped : Signal
            ``step``, two cycles later.

        Returns
        -------
        left, right : list of Value
            For its left arm, and for the right arm of that one.
        """

    def elaborate(self, platform: object) -> Module:
        m = Module()
        reach = self.reach
        if not reach:
            return m  # no arms

        # Differences to the pixels before, and which of them are on this line.
        taps = [Signal(PIXEL_BITS, name=f"grey_{j}", reset_less=True) for j in range(1, reach + 1)]
        near = [Signal(name=f"near_{j}", reset_less=True) for j in range(1, reach + 1)]
        with m.If(self.step):
            m.d.sync += [tap.eq(source) for tap, source in zip(taps, [self.grey, *taps])]
            m.d.sync += [flag.eq(source & ~self.starts_line) for flag, source in zip(near, [Const(1, 1), *near])]
        steps = [self.step]
        for stage in range(1, 5):
            steps.append(Signal(name=f"step_{stage}"))
            m.d.sync += steps[stage].eq(steps[stage - 1])
        left_flags, right_flags = self._comparisons(m, taps, near, steps[2])

        # For the right arm of the pixel `reach + 1` steps before: the comparison of the pixel j to its right with the one j to the left.
        right = []
        for j, flag in enumerate(right_flags, 1):
            word = flag
            for stage in range(reach + 1 - j):
                later = Signal(name=f"right_{j}_{stage}", reset_less=True)
                with m.If(steps[2]):
                    m.d.sync += later.eq(word)
                word = later
            right.append(word)
        right_word = Signal(reach)
        m.d.comb += right_word.eq(Cat(right))

        lengths = {}
        for name, flags in (("left", Cat(left_flags)), ("right", right_word)):
            reached = Signal(reach, name=f"reached_{name}", reset_less=True)  # all steps up to this one
            m.d.sync += reached.eq(Cat(flags[:j].all() for j in range(1, reach + 1)))
            lengths[name] = Signal(range(reach + 1), name=f"length_{name}", reset_less=True)
            m.d.sync += lengths[name].eq(ones(reached))

        m.submodules.left = left = StepDelay(range(reach + 1), reach + 1)
        m.submodules.right = right_delay = Delay(range(reach + 1), StepDelay.LATENCY)
        m.d.comb += [
            left.i.eq(lengths["left"]), left.step.eq(steps[4]), self.left_arm.eq(left.o),
            right_delay.i.eq(lengths["right"]), self.right_arm.eq(right_delay.o),
        ]
        return m


class Arms(SupportArms):
    """Arms of the method fused: runs of pixels like the centre; golden: :func:`golden.matcher.support.arms`."""
    def __init__(self, config: MatcherConfig):
        self.limits = config.method_as(Fused).arms
        super().__init__(self.limits.reach)

    def _comparisons(self, m: Module, taps: list[Signal], near: list[Signal], stepped: Signal) -> tuple[list[Value], list[Value]]:
        # -threshold <= v <= threshold, as 0 <= v + threshold <= 2 * threshold.
        threshold = self.limits.arm_threshold
        alike: list[Value] = []
        for j, tap in enumerate(taps, 1):
            moved = Signal(signed(PIXEL_BITS + 2), name=f"moved_{j}", reset_less=True)
            flag  = Signal(name=f"alike_{j}", reset_less=True)
            m.d.sync += moved.eq(self.grey + Const(threshold) - tap)
            # A cycle later the pixel is among the taps: `near` includes it.
            m.d.sync += flag.eq(near[j - 1] & (moved >= 0) & (moved <= 2 * threshold))
            alike.append(flag)
        return alike, alike


def ones(reached: Value) -> Value:
    """Number of low bits that are set, if all below a set one are: each bit of the result depends on few of them."""
    bits = []
    for place in range(len(reached).bit_length()):
        # The bit is 1 from each odd multiple of its weight up to the next multiple.
        ranges = range(1 << place, len(reached) + 1, 2 << place)
        ends = [at + (1 << place) for at in ranges]
        bits.append(Cat(reached[at - 1] & (~reached[end - 1] if end <= len(reached) else 1) for at, end in zip(ranges, ends)).any())
    return Cat(bits)


class SumWave(data.StructLayout):
    """A :class:`Completion` in step with its pixel's costs, and the address of the running sums."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"completion": Completion(config), "place": range(SupportSource.ring_of(config))})


class Ends(data.StructLayout):
    """Addresses of a support's running sums: before its first pixel, and including its last one."""
    def __init__(self, config: MatcherConfig):
        place = range(SupportSource.ring_of(config))
        super().__init__({"low": place, "high": place})


class Slot(data.StructLayout):
    """A pixel whose support is complete: its data for the labelling, whether its sums are kept, and the support's size."""
    def __init__(self, config: MatcherConfig):
        size = range(config.method_as(Fused).arms.support_max + 1)
        super().__init__({"pixel": Pixel(), "pixel_valid": 1, "in_picture": 1, "support_size": size})


class SupportSource(wiring.Component):
    """Addresses for the sums over supports; golden: :func:`golden.matcher.support.arms`, :func:`golden.matcher.support.support_sizes`.

    Every label keeps the sums of its costs along the line, ``R(x) = C(0) + .. + C(x - 1)``, one more a line than it has pixels, in a ring;
    the sum over a support is ``S(x) = R(x + right_arm + 1) - R(x - left_arm)``. All labels share these addresses.

    Timing: ``sums`` ``latency`` cycles after ``completion``; ``ends`` and ``slot`` one more, for the pixel completed ``reach + 1``
    completions before.

    Members
    -------
    completion : In(Completion(config))
    pixel : In(Pixel()), pixel_valid : In(1)
        Of :class:`hdl.matcher.streaming.waves.WaveSource`; ``pixel.lower`` is the pixel completed.
    sums : Out(SumWave(config))
    ends : Out(Ends(config))
    slot : Out(Slot(config))
    """
    def __init__(self, config: MatcherConfig, latency: int):
        self.config = config
        self.latency = latency
        super().__init__({
            "completion": In(Completion(config)),
            "pixel": In(Pixel()),
            "pixel_valid": In(1),
            "sums": Out(SumWave(config)),
            "ends": Out(Ends(config)),
            "slot": Out(Slot(config)),
        })

    @staticmethod
    def lag_of(config: MatcherConfig) -> int:
        """Completions from that of a pixel to that of the last one of its support, and one more: the sum there is then in the ring."""
        return config.method_as(Fused).arms.reach + 1

    @staticmethod
    def ring_of(config: MatcherConfig) -> int:
        """Words of a ring of running sums: an arm, the lag, a few for starts of lines; a power of two, so that addresses wrap."""
        return 1 << (2 * SupportSource.lag_of(config) + 4).bit_length()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        completion = self.completion

        sums = Signal(SumWave(config))
        place = Signal(range(self.ring_of(config)))
        m.d.sync += place.eq(place + (completion.clear | completion.complete))
        m.d.comb += [sums.completion.eq(completion), sums.place.eq(place)]
        m.submodules.sums = later = Delay(SumWave(config), self.latency, clean=True)
        m.d.comb += [later.i.eq(sums), self.sums.eq(later.o)]

        m.submodules.arms = arms = Arms(config)
        m.d.comb += [arms.step.eq(completion.complete), arms.starts_line.eq(completion.starts_line), arms.grey.eq(self.pixel.lower)]

        waiting = data.StructLayout({"pixel": Pixel(), "pixel_valid": 1, "in_picture": 1, "place": place.shape()})
        m.submodules.waiting = wait = StepDelay(waiting, self.lag_of(config))
        m.submodules.slot_delay = slot_place = Delay(waiting, Arms.LATENCY - StepDelay.LATENCY)
        m.d.comb += [
            wait.i.pixel.eq(self.pixel), wait.i.pixel_valid.eq(self.pixel_valid), wait.i.in_picture.eq(completion.in_picture),
            wait.i.place.eq(place), wait.step.eq(completion.complete), slot_place.i.eq(wait.o),
        ]
        stepped = [completion.complete]
        for stage in range(Arms.LATENCY):
            stepped.append(Signal(name=f"stepped_{stage}"))
            m.d.sync += stepped[-1].eq(stepped[-2])

        ends = Signal(Ends(config), reset_less=True)
        slot = Signal(Slot(config))
        pixel, size = (Signal.like(slot[name], name=f"slot_{name}", reset_less=True) for name in ("pixel", "support_size"))
        valid, in_picture = Signal(), Signal()  # with a reset: a slot of a frame before it must not be passed on
        m.d.comb += slot.eq(Cat(pixel, valid, in_picture, size))
        m.d.sync += [
            ends.low.eq(slot_place.o.place - arms.left_arm), ends.high.eq(slot_place.o.place + arms.right_arm + 1),
            pixel.eq(slot_place.o.pixel), size.eq(arms.left_arm + arms.right_arm + 1),
            valid.eq(slot_place.o.pixel_valid & stepped[-1]), in_picture.eq(slot_place.o.in_picture & stepped[-1]),
        ]
        rest = self.latency + 1 - Arms.LATENCY - 1
        m.submodules.ends = ends_later = Delay(Ends(config), rest)
        m.submodules.slot = slot_later = Delay(Slot(config), rest, clean=True)
        m.d.comb += [ends_later.i.eq(ends), self.ends.eq(ends_later.o), slot_later.i.eq(slot), self.slot.eq(slot_later.o)]
        return m

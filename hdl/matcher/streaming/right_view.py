"""The right picture's labels, by a running least along the array of costs, and the check of the left picture's against them."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import MINIMUM_BITS, Fused, MatcherConfig

from ...parts.delay import NO_COLLISION, Delay, data_register
from ..stream import Least
from .waves import Completion


__all__ = ["LeftRightCheck", "RightCell", "RightWave"]


class RightWave(data.StructLayout):
    """A pixel of the right picture along the labels: the least cost so far and its label.

    ``closed``: its line has ended, no more candidates exist. ``in_picture``: it is no padding.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "least": Least(range(config.method_as(Fused).joined_max + 1), config.labels), "closed": 1, "in_picture": 1,
        })


class RightCell(wiring.Component):
    """One label of the right view, ``r(x_r) = argmin_d V(x_r + d, y, d)``; golden: :func:`golden.matcher.refine.right_view`.

    A pixel of the right picture advances by a label as a pixel of the left one is completed, and so is compared with its candidates in
    turn.

    Timing: ``o`` is valid from the cycle after a ``complete`` to the next one.

    Members
    -------
    completion : In(Completion())
    cost : In(range(joined_max + 1))
        ``V``, in the cycle of ``completion``.
    i : In(RightWave(config)), o : Out(RightWave(config))
        ``i`` of the label below, as it was before the ``complete``; ignored by label 0, where a pixel starts.
    """
    def __init__(self, config: MatcherConfig, label: int):
        self.config = config
        self.label = label
        wave = RightWave(config)
        super().__init__({
            "completion": In(Completion()), "cost": In(range(config.method_as(Fused).joined_max + 1)),
            "i": In(wave), "o": Out(wave),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        least, closed_o = data_register(m, self.o.least, "least"), data_register(m, self.o.closed, "closed")
        in_picture = Signal()  # with a reset: pixels of a frame before it must not be counted
        m.d.comb += self.o.in_picture.eq(in_picture)
        with m.If(self.completion.complete):
            if self.label == 0:
                m.d.sync += [least.value.eq(self.cost), least.index.eq(0), closed_o.eq(0), in_picture.eq(self.completion.in_picture)]
            else:
                closed = self.i.closed | self.completion.starts_line
                m.d.sync += [least.eq(self.i.least), closed_o.eq(closed), in_picture.eq(self.i.in_picture)]
                with m.If((self.cost < self.i.least.value) & ~closed):
                    m.d.sync += [least.value.eq(self.cost), least.index.eq(self.label)]
        return m


class LeftRightCheck(wiring.Component):
    """Whether a pixel's match lies in the picture, and the right view agrees with it; golden: :func:`golden.matcher.refine.check`.

    Timing: ``passed`` :attr:`LATENCY` cycles after ``label``. The right labels must be written in the order of their pixels, and
    are kept for ``depth`` pixels.

    Memory: ``depth`` labels, rounded up to a power of two.

    Members
    -------
    right : In(range(D)), right_valid : In(1)
    enable : In(1)
        Off: every pixel passes.
    x : In(range(max_width)), label : In(range(D)), valid : In(1)
        ``minimum`` and ``enable`` are sampled with them.
    minimum : In(MINIMUM_BITS)
        Least disparity, pixels.
    passed : Out(1)
    """
    LATENCY = 5

    def __init__(self, config: MatcherConfig, depth: int):
        self.config = config
        self.depth = 1 << (depth - 1).bit_length()
        label = range(config.labels)
        super().__init__({
            "right": In(label), "right_valid": In(1),
            "enable": In(1), "minimum": In(MINIMUM_BITS),
            "x": In(range(config.max_width)), "label": In(label), "valid": In(1),
            "passed": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        label = range(config.labels)
        m.submodules.memory = memory = Memory(shape=label, depth=self.depth, init=[], attrs=NO_COLLISION)
        read = memory.read_port()
        write = memory.write_port()
        written = Signal(range(self.depth))  # right labels
        issued  = Signal(range(self.depth))  # pixels checked or being checked
        with m.If(self.right_valid):
            m.d.sync += written.eq(written + 1)
        with m.If(self.valid):
            m.d.sync += issued.eq(issued + 1)

        # The match: `label` pixels to the left, in the picture and in the memory alike.
        matched = Signal(range(-config.labels, config.max_width + 1), reset_less=True)
        inside  = Signal(reset_less=True)
        place   = Signal(range(self.depth), reset_less=True)
        least   = Signal(MINIMUM_BITS, reset_less=True)
        m.d.sync += [matched.eq(self.x - self.label), least.eq(self.minimum), place.eq(issued - self.label)]
        m.d.sync += inside.eq(matched >= least)
        m.d.comb += [
            write.addr.eq(written), write.data.eq(self.right), write.en.eq(self.right_valid), read.addr.eq(place), read.en.eq(1),
        ]
        seen = Signal(label, reset_less=True)
        m.d.sync += seen.eq(read.data)

        m.submodules.own = own_label = Delay(data.StructLayout({"label": label, "enable": 1}), 3)
        m.submodules.inside = inside_later = Delay(1, 2)
        apart  = Signal(range(-config.labels, config.labels), reset_less=True)
        checks = Signal(reset_less=True)
        m.d.comb += [own_label.i.label.eq(self.label), own_label.i.enable.eq(self.enable), inside_later.i.eq(inside)]
        m.d.sync += [apart.eq(seen - own_label.o.label), checks.eq(own_label.o.enable)]
        tolerance = config.method_as(Fused).refinement.tolerance
        m.d.sync += data_register(m, self.passed).eq(~checks | (inside_later.o & (apart >= -tolerance) & (apart <= tolerance)))
        return m

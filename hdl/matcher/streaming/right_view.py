"""The right picture's labels, by a running least along the array of costs, and the check of the left picture's against them."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ...parts.delay import NO_COLLISION, Delay, data_register
from ..settings import minimum_shape
from ..stream import Least
from .waves import Completion


__all__ = ["LeftRightCheck", "RightCell", "RightWave"]


class RightWave(data.StructLayout):
    """A pixel of the right picture along the labels: the least cost so far and its label.

    ``closed``: its line has ended, no more candidates exist. ``in_picture``: it is no padding. ``none``, with a lead only: it had no
    candidate yet.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "least": Least(range(config.refined.view_max + 1), config.labels), "closed": 1, "in_picture": 1,
            **({"none": 1} if config.lead else {}),
        })


class RightCell(wiring.Component):
    """One label of the right view, ``r(x_r) = argmin_d V(x_r + d, y, d)``; golden: :func:`golden.matcher.refine.right_view`.

    A pixel of the right picture advances by a label as a pixel of the left one is completed, and so is compared with its candidates in
    turn. In a line's lead it advances without a candidate.

    Timing: ``o`` is valid from the cycle after a ``complete`` to the next one.

    Members
    -------
    completion : In(Completion(config))
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
            "completion": In(Completion(config)), "cost": In(range(config.refined.view_max + 1)),
            "i": In(wave), "o": Out(wave),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        least, closed_o = data_register(m, self.o.least, "least"), data_register(m, self.o.closed, "closed")
        completion, lead = self.completion, self.config.lead
        in_picture = Signal()  # with a reset: pixels of a frame before it must not be counted
        m.d.comb += self.o.in_picture.eq(in_picture)
        none = data_register(m, self.o.none, "none") if lead else Signal()  # never driven without a lead
        with m.If(completion.complete | completion.leads if lead else completion.complete):
            if self.label == 0:
                m.d.sync += [least.value.eq(self.cost), least.index.eq(0), closed_o.eq(0), in_picture.eq(completion.in_picture)]
                if lead:
                    m.d.sync += none.eq(completion.leads)
            else:
                closed = self.i.closed | (completion.closes if lead else completion.starts_line)
                less = self.cost < self.i.least.value
                m.d.sync += [least.eq(self.i.least), closed_o.eq(closed), in_picture.eq(self.i.in_picture)]
                if lead:
                    less = (less | self.i.none) & ~completion.leads
                    m.d.sync += none.eq(self.i.none)
                with m.If(less & ~closed):
                    m.d.sync += [least.value.eq(self.cost), least.index.eq(self.label)]
                    if lead:
                        m.d.sync += none.eq(0)
        return m


class LeftRightCheck(wiring.Component):
    """Whether a pixel's match lies in the picture, and the right view agrees with it; golden: :func:`golden.matcher.refine.check`.

    Timing: ``passed`` :attr:`LATENCY` cycles after ``label``. The right labels must be written in the order of their pixels, and
    are kept for ``depth`` pixels, and those of a line's lead precede it.

    Memory: ``depth`` labels, rounded up to a power of two.

    Members
    -------
    right : In(range(D)), right_valid : In(1)
    enable : In(1)
        Off: every pixel passes.
    x : In(range(max_width)), label : In(range(D)), valid : In(1)
        ``minimum`` and ``enable`` are sampled with them.
    minimum : In(minimum_shape(config))
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
            "enable": In(1), "minimum": In(minimum_shape(config)),
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
        place_now = issued  # of the right label that started with this pixel
        if config.lead:
            # A line's lead has started right labels before its first pixel.
            place_now = issued + Mux(self.x == 0, config.lead, 0)
        with m.If(self.valid):
            m.d.sync += issued.eq(place_now + 1)

        # The match: `label` pixels to the left, in the picture and in the memory alike.
        matched = Signal(range(-config.labels, config.max_width + 1), reset_less=True)
        inside  = Signal(reset_less=True)
        place   = Signal(range(self.depth), reset_less=True)
        least   = Signal(minimum_shape(config), reset_less=True)
        m.d.sync += [matched.eq(self.x - self.label), least.eq(self.minimum), place.eq(place_now - self.label)]
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
        tolerance = config.refined.refinement.tolerance
        m.d.sync += data_register(m, self.passed).eq(~checks | (inside_later.o & (apart >= -tolerance) & (apart <= tolerance)))
        return m

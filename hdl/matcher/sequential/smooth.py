"""Smoothness energies of the sequential engine."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, WEIGHT_BITS, WEIGHT_MAX, Arithmetic, MatcherConfig


__all__ = ["LookUpTable", "Smooth"]


class LookUpTable(wiring.Component):
    """``k * u`` for all labels at once: row ``p`` holds ``abs(d - p) * u`` of every label ``d`` (thesis figure 27).

    LINEAR multiplies its slope by ``k`` itself, so ``u`` is 1 and the table is read-only. THESIS fills it at a frame's start: rows
    differ by a shift of one label, so one row in flip-flops and one running multiple of ``u`` make all of them.

    Timing: latency :attr:`LATENCY` cycle from ``read``, held until the next. Filling takes :attr:`fill_clocks` cycles after ``fill``,
    ``filled`` is low meanwhile; ``weight`` is sampled with ``fill``.

    Memory: ``D * D`` multiples of ``(D - 1) * WEIGHT_MAX`` at most, of ``D - 1`` in LINEAR.

    Members
    -------
    label : In(range(D))
    read : In(1)
    row : Out(row_layout)
    weight : In(WEIGHT_BITS)
        Ignored in LINEAR.
    fill : In(1)
    filled : Out(1)
    """
    LATENCY = 1

    def __init__(self, config: MatcherConfig):
        self.labels = config.labels
        self.fixed = config.method.arithmetic is Arithmetic.LINEAR
        multiple = range((self.labels - 1) * (1 if self.fixed else WEIGHT_MAX) + 1)
        self.row_layout = data.ArrayLayout(multiple, self.labels)
        super().__init__({
            "label": In(range(self.labels)),
            "read": In(1),
            "row": Out(self.row_layout),
            "weight": In(WEIGHT_BITS),
            "fill": In(1),
            "filled": Out(1),
        })

    @property
    def fill_clocks(self) -> int:
        """Cycles from ``fill`` to ``filled``."""
        return 0 if self.fixed else 2 * self.labels

    def elaborate(self, platform: object) -> Module:
        m = Module()
        labels = self.labels
        rows = [[abs(d - p) for d in range(labels)] for p in range(labels)] if self.fixed else []
        m.submodules.memory = memory = Memory(shape=self.row_layout, depth=labels, init=rows)
        read_port = memory.read_port()
        m.d.comb += [read_port.addr.eq(self.label), read_port.en.eq(self.read), self.row.eq(read_port.data)]
        if self.fixed:
            m.d.comb += self.filled.eq(1)
            return m

        write_port = memory.write_port()
        weight   = Signal(WEIGHT_BITS, reset_less=True)
        multiple = Signal(self.row_layout.elem_shape, reset_less=True)
        row      = Signal(self.row_layout, reset_less=True)
        step     = Signal(range(2 * labels + 1), init=2 * labels)
        m.d.comb += self.filled.eq(step == 2 * labels)
        with m.If(self.fill):
            m.d.sync += [step.eq(0), weight.eq(self.weight), multiple.eq(0)]
        with m.Elif(~self.filled):
            m.d.sync += step.eq(step + 1)
            m.d.sync += multiple.eq(Mux(step == labels - 1, weight, multiple + weight))
            with m.If(step < labels):
                # 0, u, 2u, ... enter at label 0 and make the last row: (D-1)u, ..., u, 0.
                m.d.sync += [row[0].eq(multiple), *(row[d].eq(row[d - 1]) for d in range(1, labels))]
            with m.Else():
                # u, 2u, ... enter at label D-1: each shift makes the row before.
                m.d.sync += [row[-1].eq(multiple), *(row[d].eq(row[d + 1]) for d in range(labels - 1))]
        # After `labels` steps the row is the last one; each further step makes the row before.
        m.d.comb += [
            write_port.addr.eq(2 * labels - 1 - step), write_port.data.eq(row),
            write_port.en.eq((step >= labels) & ~self.filled),
        ]
        return m


class Smooth(wiring.Component):
    """Smoothness energy (2-13) of all labels against one neighbour (thesis figures 27 .. 29: Smooth1, Smooth2, Smooth3).

    The golden model is :func:`golden.matcher.smooth.smooth`. THESIS: ``(256*k*u - k*u*dI) >> 8``, floor, computed as
    ``(k*u * (256 - dI)) >> 8``: the same number, with one difference for all labels instead of one each. LINEAR:
    ``k * ((2*u*(256 - dI) << q) >> 8)``; the slope's product is made of shifted additions, so that multipliers serve labels only.
    The energy of a neighbour that is not ``present`` is 0.

    Width: a product is exact; a term is at most ``config.smooth_max``.

    Timing: ``label`` is read with ``read``, and ``energy`` follows :attr:`LATENCY` cycles later. ``pixel``, ``neighbour``, ``present``
    and ``weight`` must be valid :attr:`PIXEL_LATENCY` cycles before ``energy`` is used. Only the look-up table's row is held.

    Multipliers: one a label.

    Members
    -------
    label : In(range(D))
        Of the neighbour, pixels.
    read : In(1)
    pixel, neighbour : In(8)
        Grey levels of the pixel and of its neighbour.
    present : In(1)
        The neighbour is inside the picture.
    weight : In(WEIGHT_BITS)
        ``u``; may change with ``fill`` only.
    fill : In(1)
    filled : Out(1)
        As of :class:`LookUpTable`.
    energy : Out(ArrayLayout(range(smooth_max + 1), D))
    """
    LATENCY = LookUpTable.LATENCY + 1
    PIXEL_LATENCY = 3

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.table = LookUpTable(config)
        super().__init__({
            "label": In(range(config.labels)),
            "read": In(1),
            "pixel": In(PIXEL_BITS),
            "neighbour": In(PIXEL_BITS),
            "present": In(1),
            "weight": In(WEIGHT_BITS),
            "fill": In(1),
            "filled": Out(1),
            "energy": Out(data.ArrayLayout(range(config.smooth_max + 1), config.labels)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        m.submodules.look_up_table = table = self.table
        m.d.comb += [
            table.label.eq(self.label), table.read.eq(self.read),
            table.weight.eq(self.weight), table.fill.eq(self.fill), self.filled.eq(table.filled),
        ]

        # Stage 1: 256 - |Ip - Iq|, 0 without a neighbour.
        likeness = Signal(range(257), reset_less=True)
        difference = Mux(self.pixel > self.neighbour, self.pixel - self.neighbour, self.neighbour - self.pixel)
        m.d.sync += likeness.eq(Mux(self.present, 256 - difference, 0))

        # Stage 2: what the table's row is multiplied by.
        if config.method.arithmetic is Arithmetic.LINEAR:
            factor = Signal(range(config.rule.slope_max + 1), reset_less=True)
            product = sum((Mux(bit, likeness << place, 0) for place, bit in enumerate(self.weight)), Const(0, 1))
            m.d.sync += factor.eq((product << config.rule.slope_shift) >> 8)
            dropped_bits = 0
        else:
            factor = Signal.like(likeness, reset_less=True)
            m.d.sync += factor.eq(likeness)
            dropped_bits = 8

        # Stage 3: products.
        for d, (multiple, energy) in enumerate(zip(table.row, self.energy, strict=True)):
            product = Signal(range(self._product_max + 1), name=f"product_{d}", reset_less=True)
            m.d.sync += product.eq(multiple * factor)
            m.d.comb += energy.eq(product >> dropped_bits)
        return m

    @property
    def _product_max(self) -> int:
        return self.config.smooth_max << (8 if self.config.method.arithmetic is Arithmetic.THESIS else 0)

"""The gates by the difference of grey levels: tables, and what fills them as the settings change."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, PIXEL_MAX, MatcherConfig, Propagation, Recursive

from ...parts.delay import NO_COLLISION
from ..settings import setting_shape


__all__ = ["GateFill", "GateTable", "GateWord"]


class GateWord(data.StructLayout):
    """A word for the tables: the ``gate`` of a ``difference`` of grey levels, if ``write``."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"write": 1, "difference": PIXEL_BITS, "gate": range(config.method_as(Recursive).carried_max + 1)})


class GateFill(wiring.Component):
    """Fills the tables of gates with each frame whose settings differ from those that the tables are of; at first the built-in ones.

    Golden: :attr:`golden.config.Propagation.gate`, ``min(max(floor, numerator // (offset + difference)), spread_jump)``.

    No divider: the quotients do not rise with the difference. From the one before each is found by counting down while its product with the
    divisor, which follows by one addition or subtraction, exceeds the numerator.

    Width: exact.

    Timing: ``busy`` from the cycle after ``start`` until all is written, at most :attr:`CLOCKS` cycles. ``o`` is a register: the way to the
    tables does not share a period with the comparison.

    Members
    -------
    start : In(1)
        The settings are those of a frame that starts.
    gate_numerator, gate_offset, gate_floor : In
    o : Out(GateWord(config))
    busy : Out(1)
    """
    SETTINGS = ("gate_numerator", "gate_offset", "gate_floor")
    CLOCKS = 2 + PIXEL_MAX + 1 + 1 + Propagation.LIMITS["spread_jump"][-1]

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "start": In(1), **{name: In(setting_shape(config.settings[name])) for name in self.SETTINGS},
            "o": Out(GateWord(config)), "busy": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        jump = self.config.method_as(Recursive).propagation.spread_jump
        shape = data.StructLayout({name: setting_shape(self.config.settings[name]) for name in self.SETTINGS})
        # What the tables are of, and whether they are whole: a reset, perhaps while they are filled, does not change them.
        settings = Signal(shape, init={name: self.config.settings[name].default for name in self.SETTINGS}, reset_less=True)
        whole    = Signal(init=1, reset_less=True)
        now      = Signal(shape)
        m.d.comb += [now[name].eq(getattr(self, name)) for name in self.SETTINGS]
        divisor    = Signal(range((1 << len(self.gate_offset)) + PIXEL_MAX + 1), reset_less=True)
        quotient   = Signal(range(jump + 1), reset_less=True)
        product    = Signal(range(jump * ((1 << len(self.gate_offset)) + PIXEL_MAX) + 1), reset_less=True)
        difference = Signal(PIXEL_BITS, reset_less=True)
        first      = Signal.like(product, reset_less=True)  # the register of a multiplier
        word       = Signal(self.o.shape())
        m.d.sync += [
            first.eq(settings.gate_offset * jump), word.write.eq(0), word.difference.eq(difference),
            word.gate.eq(Mux(settings.gate_floor > quotient, settings.gate_floor, quotient)),
        ]
        m.d.comb += [self.o.eq(word), self.busy.eq(word.write)]
        if jump < self.config.settings["gate_floor"].maximum:
            with m.If(settings.gate_floor > jump):
                m.d.sync += word.gate.eq(jump)
        with m.FSM():
            with m.State("idle"):
                with m.If(self.start & (~whole | (now.as_value() != settings.as_value()))):
                    m.d.sync += [settings.eq(now), whole.eq(0)]
                    m.next = "multiply"
            with m.State("multiply"):
                m.d.comb += self.busy.eq(1)
                m.next = "load"
            with m.State("load"):
                m.d.comb += self.busy.eq(1)
                m.d.sync += [divisor.eq(settings.gate_offset), quotient.eq(jump), product.eq(first), difference.eq(0)]
                m.next = "fill"
            with m.State("fill"):
                m.d.comb += self.busy.eq(1)
                with m.If(product > settings.gate_numerator):
                    m.d.sync += [quotient.eq(quotient - 1), product.eq(product - divisor)]
                with m.Else():
                    m.d.sync += [word.write.eq(1), difference.eq(difference + 1), divisor.eq(divisor + 1), product.eq(product + quotient)]
                    with m.If(difference == PIXEL_MAX):
                        m.d.sync += whole.eq(1)
                        m.next = "idle"
        return m


class GateTable(wiring.Component):
    """A table of gates; at first the built-in ones.

    Timing: ``gate`` a cycle after ``difference``.

    Memory: 256 gates.

    Members
    -------
    i : In(GateWord(config))
    difference : In(PIXEL_BITS), gate : Out(range(carried_max + 1))
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        word = GateWord(config)
        super().__init__({"i": In(word), "difference": In(PIXEL_BITS), "gate": Out(word["gate"].shape)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        gates = self.config.method_as(Recursive).propagation.gate
        m.submodules.memory = memory = Memory(shape=self.gate.shape(), depth=PIXEL_MAX + 1, init=gates, attrs=NO_COLLISION)
        read, write = memory.read_port(), memory.write_port()
        m.d.comb += [
            read.addr.eq(self.difference), read.en.eq(1), self.gate.eq(read.data),
            write.addr.eq(self.i.difference), write.data.eq(self.i.gate), write.en.eq(self.i.write),
        ]
        return m

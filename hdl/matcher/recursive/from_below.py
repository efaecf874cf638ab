"""Costs from the line below: what all labels share, and the stages of a group of labels."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig, Propagation, Recursive

from ...parts.delay import NO_COLLISION, Delay, data_register
from .gates import GateTable, GateWord
from .source import SLOTS, Step
from .spread import SpreadGroup
from .support import JOINING, share_of


__all__ = ["FromBelowGroup", "FromBelowSource", "LowerFinal", "LowerGate", "OwnSlot"]


class LowerFinal(data.StructLayout):
    """The slot of a pixel whose mean is there, kept if ``write``."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"write": 1, "slot": range(SLOTS)})


class OwnSlot(data.StructLayout):
    """The slot of a pixel whose costs are written, and of the one whose costs are read."""
    def __init__(self, config: MatcherConfig):
        slot = range(SLOTS)
        super().__init__({"slot": slot, "tick": 1})


class LowerGate(data.StructLayout):
    """The gate to the pixel below; ``exists``: there is one, else nothing comes from below."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"exists": 1, "gate": range(config.method_as(Recursive).carried_max + 1)})


class FromBelowSource(wiring.Component):
    """Slots, least costs and gates for the costs from the line below; golden: :func:`golden.matcher.recursive.neighbours.from_below`.

    Timing: ``address`` :attr:`ADDRESS` cycles after ``i``; ``pixel_least``, ``gate`` and ``own_address`` as late after it as
    :class:`FromBelowGroup` states.

    Memory: a least cost a slot; a table of gates.

    Members
    -------
    i : In(Step(config))
    gates : In(GateWord(config))
    write : In(LowerFinal(config)), least : In(range(own_max + 1))
        The least mean of a pixel.
    address : Out(range(slots)), pixel_least : Out(range(own_max + 1)), gate : Out(LowerGate(config))
    own_address : Out(range(slots))
    """
    ADDRESS = 3

    def __init__(self, config: MatcherConfig):
        self.config = config
        method = config.method_as(Recursive)
        slot = range(SLOTS)
        super().__init__({
            "i": In(Step(config)), "gates": In(GateWord(config)), "write": In(LowerFinal(config)), "least": In(range(method.own_max + 1)),
            "address": Out(slot), "pixel_least": Out(range(method.own_max + 1)), "gate": Out(LowerGate(config)), "own_address": Out(slot),
        })

    @staticmethod
    def least_read() -> int:
        """Cycles from ``i`` to the read access of the least mean; a register is behind the memory."""
        return FromBelowSource.ADDRESS + FromBelowGroup.LEAST - 2

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config, step = self.config, self.i
        m.submodules.leasts = leasts = Memory(shape=self.least.shape(), depth=SLOTS, init=[], attrs=NO_COLLISION)
        read, write = leasts.read_port(), leasts.write_port()

        slots: list[Value] = [step.slot]
        for stage in range(1, self.ADDRESS + FromBelowGroup.OWN + 1):
            later = Signal.like(step.slot, name=f"slot_{stage}", reset_less=True)
            m.d.sync += later.eq(slots[-1])
            slots.append(later)
        m.d.comb += [
            self.address.eq(slots[self.ADDRESS]), self.own_address.eq(slots[-1]),
            read.addr.eq(slots[self.least_read()]), read.en.eq(1),
            write.addr.eq(self.write.slot), write.data.eq(self.least), write.en.eq(self.write.write),
        ]
        m.d.sync += data_register(m, self.pixel_least).eq(read.data)

        # Difference at 1, absolute at 2, gate at 3.
        difference = Signal(signed(PIXEL_BITS + 1), reset_less=True)
        absolute   = Signal(PIXEL_BITS, reset_less=True)
        m.submodules.table = table = GateTable(config)
        m.submodules.gate = gate_later = Delay(LowerGate(config), self.ADDRESS + FromBelowGroup.GATE - 3)
        m.submodules.exists = exists = Delay(1, 3)
        m.d.sync += [
            difference.eq(step.grey - step.lower_grey), absolute.eq(Mux(difference < 0, -difference, difference)),
        ]
        m.d.comb += [
            table.i.eq(self.gates), table.difference.eq(absolute),
            exists.i.eq(step.has_below), gate_later.i.gate.eq(table.gate), gate_later.i.exists.eq(exists.o),
            self.gate.eq(gate_later.o),
        ]
        return m


class FromBelowGroup(wiring.Component):
    """Means of the line below of a few neighbouring labels, spread, gated, and their share added to a pixel's own costs.

    Golden: :func:`golden.matcher.recursive.neighbours.from_below`.

    Width: exact.

    Timing, from ``address``: ``least`` and ``lower_i`` are due after :attr:`LEAST` cycles, ``gate`` after :attr:`GATE`, ``share`` and
    ``own_address`` after :attr:`OWN`; ``o`` after :attr:`LATENCY`. ``lower_i``, ``upper_i`` and their outputs: as of
    :class:`hdl.matcher.recursive.spread.SpreadGroup`.

    Memory: a mean and a pixel's own cost a slot and label.

    Members
    -------
    write : In(LowerFinal(config)), mean : In(ArrayLayout(range(own_max + 1), n))
        Of the lower pixel of a slot.
    own_write : In(OwnSlot(config)), own : In(ArrayLayout(range(own_max + 1), n))
        ``V`` of the pixel of a slot.
    address : In(range(slots)), least : In(range(own_max + 1)), gate : In(LowerGate(config)), own_address : In(range(slots))
    share : In(range(SHARE_MAX + 1))
        Eighths of the costs from below.
    lower_i, lower_o, upper_i, upper_o : range(own_max + 1)
    o : Out(ArrayLayout(range(own_max + low_max + 1), n))
        ``V + (share * low >> 3)``.
    """
    LEAST = 2
    GATE = LEAST + SpreadGroup.LATENCY
    OWN = GATE + 1
    LATENCY = OWN + JOINING

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        method = config.method_as(Recursive)
        own, slot = range(method.own_max + 1), range(SLOTS)
        costs = data.ArrayLayout(own, len(labels))
        low_max = Propagation.SHARE_MAX * method.carried_max >> Propagation.SHARE_BITS
        super().__init__({
            "write": In(LowerFinal(config)), "mean": In(costs), "own_write": In(OwnSlot(config)), "own": In(costs),
            "address": In(slot), "least": In(own), "gate": In(LowerGate(config)), "own_address": In(slot),
            "share": In(range(Propagation.SHARE_MAX + 1)),
            "lower_i": In(own), "lower_o": Out(own), "upper_i": In(own), "upper_o": Out(own),
            "o": Out(data.ArrayLayout(range(method.own_max + low_max + 1), len(labels))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        method = config.method_as(Recursive)
        count = len(self.labels)
        kept = {}
        for name, values, enable, place, address in (
                ("mean", self.mean, self.write.write, self.write.slot, self.address),
                ("own", self.own, self.own_write.tick, self.own_write.slot, self.own_address)):
            m.submodules[f"{name}s"] = memory = Memory(shape=values.shape(), depth=SLOTS, init=[], attrs=NO_COLLISION)
            read, write = memory.read_port(), memory.write_port()
            kept[name] = Signal(values.shape(), name=f"{name}_kept", reset_less=True)
            m.d.comb += [
                read.addr.eq(address), read.en.eq(1), write.addr.eq(place), write.data.eq(values), write.en.eq(enable),
            ]
            m.d.sync += kept[name].eq(read.data)
        m.submodules.spread = spread = SpreadGroup(config, self.labels, method.own_max)
        m.d.comb += [
            spread.cost.eq(kept["mean"]), spread.least.eq(self.least), spread.lower_i.eq(self.lower_i), spread.upper_i.eq(self.upper_i),
            self.lower_o.eq(spread.lower_o), self.upper_o.eq(spread.upper_o),
        ]

        # What the memory holds where there is no line below may be undefined: it is cleared, as no gate would make that known.
        result = data_register(m, self.o)
        gated = [Signal(range(method.carried_max + 1), name=f"gated_{n}", reset_less=True) for n in range(count)]
        for n in range(count):
            m.d.sync += gated[n].eq(Mux(spread.o[n] < self.gate.gate, spread.o[n], self.gate.gate))
        with m.If(~self.gate.exists):
            m.d.sync += [value.eq(0) for value in gated]
        for n in range(count):
            m.d.sync += result[n].eq(kept["own"][n] + share_of(m, config, f"low_{n}", gated[n], self.share))
        return m

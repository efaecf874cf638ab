"""Costs from the line above: what all labels share, and the stages of a group of labels."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig, Propagation, Recursive

from ...parts.delay import NO_COLLISION, Delay, data_register
from ...parts.line_memory import LineMemory
from .gates import GateTable, GateWord
from .source import Step
from .spread import SpreadGroup


__all__ = ["CarriedGroup", "CarriedSource", "Taps"]


class Taps(data.StructLayout):
    """A step on the line above.

    ``place``: in the rings of the taps. ``opens``, ``edge``: as of :class:`hdl.matcher.recursive.source.Step`. The gates of the centre tap
    and of those to its left and right. ``has_above``: there is a line above; else nothing is carried.
    """
    def __init__(self, config: MatcherConfig):
        method = config.method_as(Recursive)
        gate = range(method.carried_max + 1)
        super().__init__({
            "advance": 1, "place": range(method.propagation.fan), "opens": 1, "edge": 1, "has_above": 1,
            "centre": gate, "left": gate, "right": gate,
        })


class CarriedSource(wiring.Component):
    """Addresses, limits and gates for the costs from the line above; golden: :func:`golden.matcher.recursive.neighbours.from_above`.

    Timing: ``address`` in the cycle of ``i``, ``pixel_least`` :attr:`CarriedGroup.LEAST` cycles after it, ``place``
    :attr:`CarriedGroup.PLACE`, ``taps`` :attr:`CarriedGroup.TAPS`.

    Memory: ``max_width`` grey levels and least costs; a ring of ``fan`` pairs of grey levels; three tables of gates.

    Members
    -------
    i : In(Step(config))
    gates : In(GateWord(config))
    write : In(1), column : In(range(max_width)), least : In(range(data_max + 1))
        The least cost of a pixel of this line, for the next one.
    address : Out(range(max_width))
    pixel_least : Out(range(data_max + 1))
        The least cost at ``address``.
    place : Out(range(fan))
    taps : Out(Taps(config))
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        method = config.method_as(Recursive)
        super().__init__({
            "i": In(Step(config)), "gates": In(GateWord(config)),
            "write": In(1), "column": In(range(config.max_width)), "least": In(range(method.data_max + 1)),
            "address": Out(range(config.max_width)), "pixel_least": Out(range(method.data_max + 1)),
            "place": Out(range(method.propagation.fan)), "taps": Out(Taps(config)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config, step = self.config, self.i
        method = config.method_as(Recursive)
        propagation = method.propagation
        fan = propagation.fan
        m.d.comb += self.address.eq(step.ahead)

        # The least costs, and registers behind the memory.
        m.submodules.leasts = leasts = Memory(shape=self.least.shape(), depth=config.max_width, init=[], attrs=NO_COLLISION)
        read, write = leasts.read_port(), leasts.write_port()
        m.d.comb += [
            read.addr.eq(step.ahead), read.en.eq(1),
            write.addr.eq(self.column), write.data.eq(self.least), write.en.eq(self.write),
        ]
        least = Signal.like(self.least, reset_less=True)
        m.d.sync += [least.eq(read.data), data_register(m, self.pixel_least).eq(least)]

        # The place in the rings.
        place = Signal(range(fan))
        with m.If(step.advance):
            m.d.sync += place.eq(Mux(place == fan - 1, 0, place + 1))
        m.submodules.place = place_later = Delay(place.shape(), CarriedGroup.PLACE)
        m.d.comb += [place_later.i.eq(place), self.place.eq(place_later.o)]

        # Grey levels of the line above: a completed pixel's is kept after the last read of its column.
        m.submodules.greys = greys = Memory(shape=PIXEL_BITS, depth=config.max_width, init=[], attrs=NO_COLLISION)
        grey_read, grey_write = greys.read_port(), greys.write_port()
        stages = [step]
        for stage in range(1, 5):
            later = Signal(Step(config), name=f"step_{stage}")
            m.d.sync += later.eq(stages[-1])
            stages.append(later)
        m.d.comb += [
            grey_read.addr.eq(step.ahead), grey_read.en.eq(1), grey_write.addr.eq(stages[2].column), grey_write.data.eq(stages[2].grey),
            grey_write.en.eq(stages[2].completion.in_picture),
        ]
        # The ring of the taps: words of a right and a centre tap, `fan` steps before.
        pair = data.StructLayout({"right": PIXEL_BITS, "centre": PIXEL_BITS})
        m.submodules.ring = ring = Memory(shape=pair, depth=fan, init=[])
        ring_read, ring_write = ring.read_port(), ring.write_port()
        places = [place]
        for stage in range(1, 4):
            later = Signal.like(place, name=f"place_{stage}", reset_less=True)
            m.d.sync += later.eq(places[-1])
            places.append(later)
        right, opening = (Signal(PIXEL_BITS, name=name, reset_less=True) for name in ("right", "opening"))
        before = Signal(pair, reset_less=True)
        m.d.sync += [right.eq(grey_read.data), before.eq(ring_read.data)]
        # `right` is 2 cycles after the step; `before` is read so that it is there at the same time, as the last word was written.
        m.d.comb += [
            ring_read.addr.eq(places[0]), ring_read.en.eq(1),
            ring_write.addr.eq(places[2]), ring_write.data.right.eq(right), ring_write.data.centre.eq(before.right),
            ring_write.en.eq(stages[2].advance),
        ]
        centre = before.right
        left = Mux(stages[2].edge & ~stages[2].opens, opening, Mux(stages[2].opens, centre, before.centre))
        with m.If(stages[2].opens):
            m.d.sync += opening.eq(centre)

        # Differences at 3, absolute at 4, gates at 5.
        gates: dict[str, Value] = {}
        for name, value in (("centre", centre), ("left", left), ("right", right)):
            difference = Signal(signed(PIXEL_BITS + 1), name=f"difference_{name}", reset_less=True)
            absolute   = Signal(PIXEL_BITS, name=f"absolute_{name}", reset_less=True)
            m.submodules[f"table_{name}"] = table = GateTable(config)
            m.d.sync += [difference.eq(stages[2].grey - value), absolute.eq(Mux(difference < 0, -difference, difference))]
            m.d.comb += [table.i.eq(self.gates), table.difference.eq(absolute)]
            gates[name] = table.gate
        of_step = ("advance", "opens", "edge", "has_above")
        control = data.StructLayout({"place": place.shape(), **dict.fromkeys(of_step, 1)})
        m.submodules.control = control_later = Delay(control, CarriedGroup.TAPS)
        m.d.comb += [
            control_later.i.place.eq(place), *(control_later.i[name].eq(step[name]) for name in of_step),
            *(self.taps[name].eq(control_later.o[name]) for name in ("place", *of_step)),
        ]
        for name, value in gates.items():
            m.submodules[f"gate_{name}"] = gate_later = Delay(value.shape(), CarriedGroup.TAPS - 5)
            m.d.comb += [gate_later.i.eq(value), self.taps[name].eq(gate_later.o)]
        return m


class CarriedGroup(wiring.Component):
    """Costs from the line above of a few neighbouring labels: read, spread over the labels beside, taken at three columns, gated.

    Golden: :func:`golden.matcher.recursive.spread.spread`, :func:`golden.matcher.recursive.neighbours.from_above`.

    Width: exact.

    Timing, from ``address``: ``least`` and ``lower_i`` are due after :attr:`LEAST` cycles, ``place`` after :attr:`PLACE`, ``taps`` after
    :attr:`TAPS`; ``above`` :attr:`ABOVE` cycles after it. ``lower_i``, ``upper_i`` and their outputs: as of
    :class:`hdl.matcher.recursive.spread.SpreadGroup`.

    Memory: ``max_width`` costs a label; a ring of ``fan`` pairs of carried costs a label.

    Members
    -------
    address : In(range(max_width)), least : In(range(data_max + 1)), place : In(range(fan)), taps : In(Taps(config))
    write : In(1), column : In(range(max_width)), cost : In(ArrayLayout(range(data_max + 1), n))
        Costs ``A`` of this line, for the next one.
    lower_i, lower_o, upper_i, upper_o : range(data_max + 1)
    above : Out(ArrayLayout(range(carried_max + 1), n))
        ``t``.
    """
    LEAST = LineMemory.LATENCY
    PLACE = LineMemory.LATENCY + SpreadGroup.LATENCY - 1
    TAPS = PLACE + 2
    ABOVE = TAPS + 3

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        method = config.method_as(Recursive)
        cost = range(method.data_max + 1)
        super().__init__({
            "address": In(range(config.max_width)), "least": In(range(method.data_max + 1)),
            "place": In(range(method.propagation.fan)), "taps": In(Taps(config)),
            "write": In(1), "column": In(range(config.max_width)), "cost": In(data.ArrayLayout(cost, len(labels))),
            "lower_i": In(cost), "lower_o": Out(cost), "upper_i": In(cost), "upper_o": Out(cost),
            "above": Out(data.ArrayLayout(range(method.carried_max + 1), len(labels))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        method = config.method_as(Recursive)
        propagation: Propagation = method.propagation
        carried = data.ArrayLayout(range(method.carried_max + 1), len(self.labels))
        m.submodules.line = line = LineMemory(self.cost.shape(), config.max_width)
        m.submodules.spread = spread = SpreadGroup(config, self.labels, method.data_max)
        m.d.comb += [
            line.address.eq(self.address), line.column.eq(self.column), line.i.eq(self.cost), line.write.eq(self.write),
            spread.cost.eq(line.o), spread.least.eq(self.least), spread.lower_i.eq(self.lower_i), spread.upper_i.eq(self.upper_i),
            self.lower_o.eq(spread.lower_o), self.upper_o.eq(spread.upper_o),
        ]

        # 8: the taps.
        pair = data.StructLayout({"right": carried, "centre": carried})
        m.submodules.ring = ring = Memory(shape=pair, depth=propagation.fan, init=[])
        ring_read, ring_write = ring.read_port(), ring.write_port()
        right   = Signal(carried, reset_less=True)
        before  = Signal(pair, reset_less=True)
        opening = Signal(carried, reset_less=True)
        centre, taps = before.right, self.taps
        m.d.sync += [right.eq(spread.o), before.eq(ring_read.data)]
        m.d.comb += [
            ring_read.addr.eq(self.place), ring_read.en.eq(1),
            ring_write.addr.eq(taps.place), ring_write.data.right.eq(right), ring_write.data.centre.eq(centre),
            ring_write.en.eq(taps.advance),
        ]
        with m.If(taps.opens):
            m.d.sync += opening.eq(centre)

        # 9 to 11: gates, and the sum of four. What the memories hold before a picture's first line is complete may be undefined: the sum is
        # cleared, as no gate would make that known.
        has_above = Signal(2)
        m.d.sync += has_above.eq(Cat(taps.has_above, has_above))
        above = data_register(m, self.above)
        for n in range(len(self.labels)):
            left = Mux(taps.opens, centre[n], Mux(taps.edge, opening[n], before.centre[n]))
            gated = {}
            for name, value in (("centre", centre[n]), ("left", left), ("right", right[n])):
                gated[name] = Signal(range(method.carried_max + 1), name=f"gated_{name}_{n}", reset_less=True)
                m.d.sync += gated[name].eq(Mux(value < taps[name], value, taps[name]))
            both  = Signal(range(2 * method.carried_max + 1), name=f"both_{n}", reset_less=True)
            twice = Signal.like(gated["centre"], name=f"twice_{n}", reset_less=True)
            m.d.sync += [both.eq(gated["left"] + gated["right"]), twice.eq(gated["centre"]), above[n].eq((both + (twice << 1)) >> 2)]
        with m.If(~has_above[1]):
            m.d.sync += above.eq(0)
        return m

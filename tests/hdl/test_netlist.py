import json

import pytest
from amaranth import *
from amaranth.back import rtlil
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.emit import emit_rtlil
from hdl.netlist import BlackBox, Cell, Netlist, Pin, Port, clock_sources, read_netlist, set_attribute


# `and` of two inputs, twice; a constant; a name that Yosys made.
DOCUMENT = {"modules": {"top": {
    "attributes": {},
    "ports": {"a": {"direction": "input", "bits": [2, 3]}, "y": {"direction": "output", "bits": [5, 4, "0"]},
              "io": {"direction": "inout", "bits": [6]}},
    "cells": {
        "first": {"type": "$and", "port_directions": {"A": "input", "B": "input", "Y": "output", "Z": "output"}, "attributes": {},
                  "parameters": {"WIDTH": "01"}, "connections": {"A": [2], "B": ["1"], "Y": [4], "Z": ["x"]}},
        "second": {"type": "$and", "port_directions": {"A": "input", "B": "input", "Y": "output"}, "parameters": {},
                   "attributes": {"n": "1"}, "connections": {"A": [4], "B": [3], "Y": [5]}},
        "box": {"type": "vendor", "parameters": {}, "attributes": {}, "connections": {"pad": [6], "o": [7]}},
    },
    "netnames": {"a": {"bits": [2, 3]}, "$1": {"bits": [4]}, "inner": {"bits": [4]}, "$2": {"bits": [7]}},
}}}


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "design.json"
    path.write_text(json.dumps(DOCUMENT))
    return path


def test_read(path):
    module = read_netlist(path)["top"]
    assert module.ports == {"a": Port("input", [2, 3]), "y": Port("output", [5, 4, "0"]), "io": Port("inout", [6])}
    assert module.cells["box"] == Cell("vendor", {"pad": [6], "o": [7]})
    assert (module.cells["first"].parameters, module.cells["second"].attributes) == ({"WIDTH": "01"}, {"n": "1"})


def test_drivers_and_users(path):
    module = read_netlist(path)["top"]
    assert module.drivers == {4: Pin("first", "Y", 0), 5: Pin("second", "Y", 0)}
    assert module.users == {2: [Pin("first", "A", 0)], 3: [Pin("second", "B", 0)],
                            4: [Pin("second", "A", 0), Pin("", "y", 1)], 5: [Pin("", "y", 0)]}
    assert module.inputs == {2: Pin("", "a", 0), 3: Pin("", "a", 1), 6: Pin("", "io", 0)}


def test_names(path):
    module = read_netlist(path)["top"]
    assert [module.net_of(bit) for bit in (3, 4, 7, 9, "1")] == ["a", "inner", "$2", "9", "constant"]
    assert [module.port_bit(pin) for pin in (Pin("", "a", 1), Pin("", "io", 0))] == ["a[1]", "io"]


def test_attribute(path):
    before = read_netlist(path)["top"]
    set_attribute(path, "top", "BEL", {"first": "X1", "box": "X2"})
    after = read_netlist(path)["top"]
    attributes = {name: cell.attributes for name, cell in after.cells.items()}
    assert attributes == {"first": {"BEL": "X1"}, "second": {"n": "1"}, "box": {"BEL": "X2"}}
    assert (after.ports, after.nets) == (before.ports, before.nets)


# --- Clocks ---

BOXES = {"buffer": BlackBox(repeats={"o": "pad"}), "pll": BlackBox(generates=("clocks",), clocked=("reference",)),
         "synchroniser": BlackBox(clocked=("clk",))}


class Register(wiring.Component):
    """A register in the domain ``sync``, and one in ``falling`` which has the same clock."""
    def __init__(self):
        super().__init__({"i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.domains.falling = ClockDomain(reset_less=True, local=True, clk_edge="neg")
        between = Signal(4)
        m.d.comb += ClockSignal("falling").eq(ClockSignal())
        m.d.falling += between.eq(self.i)
        m.d.sync += self.o.eq(between)
        return m


class Pad(wiring.Component):
    """A pin's buffer below the top level."""
    def __init__(self):
        super().__init__({"pad": In(2), "o": Out(2)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.buffer_ = Instance("buffer", i_pad=self.pad, o_o=self.o)
        return m


class Board(wiring.Component):
    """Clocks through buffers of two levels, from a PLL, and of a synchroniser.

    ``other(board, clocks)`` gives the clock of a third domain, ``reference`` that of the PLL, if they are given.
    """
    def __init__(self, other=lambda board, clocks: clocks[0], reference=None):
        self.other, self.reference = other, reference
        super().__init__({"pads": In(2), "enable": In(1), "i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.domains += [ClockDomain(name, reset_less=True, local=True) for name in ("camera", "display", "other")]
        clocks = Signal(2)
        m.submodules.pad = pad = Pad()
        m.d.comb += [pad.pad.eq(self.pads), ClockSignal("camera").eq(pad.o[1]), ClockSignal("display").eq(clocks[0]),
                     ClockSignal("other").eq(self.other(self, clocks))]
        divided = Signal()
        m.d.camera += divided.eq(~divided)
        reference = pad.o[0] if self.reference is None else self.reference(self, divided)
        m.submodules.pll = Instance("pll", i_reference=Cat(reference, C(0, 1)), o_clocks=clocks)
        value = self.i
        for domain in ("camera", "display", "other"):
            m.submodules[f"{domain}_register"] = register = DomainRenamer(domain)(Register())
            m.d.comb += register.i.eq(value)
            value = register.o
        m.submodules.synchroniser = Instance("synchroniser", i_clk=self.enable, i_i=value, o_o=self.o)
        return m


class Outer(wiring.Component):
    """A board in a level below the top."""
    def __init__(self, other):
        self.other = other
        super().__init__({"pads": In(2), "enable": In(1), "i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.board = board = Board(self.other)
        m.d.comb += [board.pads.eq(self.pads), board.enable.eq(self.enable), board.i.eq(self.i), self.o.eq(board.o)]
        return m


def clocks_of(board):
    design = emit_rtlil(rtlil.convert(board, name="board", emit_src=False))
    return clock_sources(design.netlist, "board", BOXES)


SOURCES = {
    "a port": (lambda board, clocks: board.i[2], "i[2]"),
    "the other output of the PLL": (lambda board, clocks: clocks[1], "pll.clocks"),
    "logic": (lambda board, clocks: board.enable & clocks[0], "? other_clk"),
}


@pytest.mark.parametrize("case", SOURCES)
def test_clock_sources(case):
    other, source = SOURCES[case]
    assert clocks_of(Board(other)) == {"pads[0]", "pads[1]", "pll.clocks", "enable", source}


def test_reference_of_a_generated_clock():
    """A PLL is clocked too: here by a register."""
    assert clocks_of(Board(reference=lambda board, divided: divided)) == {"pads[1]", "pll.clocks", "enable", "? divided"}
    assert "? constant" in clocks_of(Board(reference=lambda board, divided: 0))


def test_source_below_the_top():
    """A net is named with the path of its module."""
    outer = Outer(lambda board, clocks: board.enable & clocks[0])
    design = emit_rtlil(rtlil.convert(outer, name="top", emit_src=False))
    assert "? board.other_clk" in clock_sources(design.netlist, "top", BOXES)


class Store(wiring.Component):
    """A memory with two clocks, whose names are those of the domains; ``asynchronous``: the read port has none."""
    def __init__(self, asynchronous):
        self.asynchronous = asynchronous
        super().__init__({"read_clk": In(1), "sync_clk": In(1), "i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        for domain, clock in (("read", self.read_clk), ("sync", self.sync_clk)):
            m.domains += ClockDomain(domain, reset_less=True, local=True)
            m.d.comb += ClockSignal(domain).eq(clock)
        m.submodules.memory = memory = Memory(shape=4, depth=16, init=[])
        write, read = memory.write_port(), memory.read_port(domain="comb" if self.asynchronous else "read")
        m.d.comb += [write.addr.eq(self.i), write.data.eq(self.i), write.en.eq(1), read.addr.eq(self.i), self.o.eq(read.data)]
        return m


@pytest.mark.parametrize("asynchronous, sources", [(False, {"read_clk", "sync_clk"}), (True, {"sync_clk"})])
def test_clocks_of_a_memory(asynchronous, sources):
    design = emit_rtlil(rtlil.convert(Store(asynchronous), name="store", emit_src=False))
    assert clock_sources(design.netlist, "store", {}) == sources


def test_ports_of_a_memory_are_clocked_each():
    """The last digit of a parameter of Yosys belongs to the first port."""
    memory = Cell("$mem_v2", {"RD_CLK": [2, 3], "WR_CLK": [4, 5]}, {}, {"RD_CLK_ENABLE": "10", "WR_CLK_ENABLE": "01"})
    netlist = Netlist({f"c{bit}": Port("input", [bit]) for bit in range(2, 6)}, {"memory": memory}, {})
    assert clock_sources({"top": netlist}, "top", {}) == {"c3", "c4"}


def test_loop_and_floating_net():
    """A net that drives itself through a buffer, one without a driver, a constant: none is a clock, and the search ends."""
    cells = {"buffer_": Cell("buffer", {"pad": [2], "o": [2]}),
             **{str(bit): Cell("$dff", {"CLK": [bit]}, {"CLK": "input"}) for bit in (2, 3, "0")}}
    assert clock_sources({"top": Netlist({}, cells, {"loop": [2], "floating": [3]})}, "top", BOXES) == {
        "? loop", "? floating", "? constant"}

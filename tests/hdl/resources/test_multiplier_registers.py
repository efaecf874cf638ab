"""Registers around multipliers, moved into them: what may be, what may not, and that nothing else changes."""

import copy

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.emit import verilog_text
from hdl.netlist import read_netlist
from hdl.resources.ecp5 import ECP5
from hdl.resources.multiplier_registers import absorb_multiplier_registers
from tests.hdl.resources.ecp5_cells import CLOCK, ENABLE, moved_by, printed, register


def multiplier(a, b, p, **changed):
    """Two inputs of each side, two outputs."""
    pins = {f"{side}{n}": [bit] for side, bits in zip("ABP", (a, b, p)) for n, bit in enumerate(bits)}
    connections = pins | {pin: ["0"] for pin in ("C0", "SIGNEDA", "SIGNEDB", "SOURCEA", "SOURCEB")} | changed
    directions = {port: "output" if port[0] == "P" else "input" for port in connections}
    return {"type": "MULT18X18D", "parameters": {}, "port_directions": directions, "connections": connections}


def absorbed(path, cells, ports=()):
    return moved_by(absorb_multiplier_registers, path, cells, ports)


def around(enable=None, output_enable=None):
    """A multiplier of two bits by one, with its registers."""
    return {"mul": multiplier([20, 21], [22, "0"], [30, 31]), "a0": register(10, 20, enable), "a1": register(11, 21, enable),
            "b0": register(12, 22, enable), "p0": register(30, 40, output_enable), "p1": register(31, 41, output_enable)}


def modes(cell):
    """Clock and enable of each register that is in use."""
    parameters, connections = cell["parameters"], cell["connections"]
    return {which: (connections[parameters[f"REG_{which}_CLK"]], connections[parameters[f"REG_{which}_CE"]],
                    connections[parameters[f"REG_{which}_RST"]])
            for which in ("INPUTA", "INPUTB", "OUTPUT") if f"REG_{which}_CLK" in parameters}


@pytest.mark.parametrize("enable, output_enable", [(None, None), (ENABLE, None), (None, ENABLE), (ENABLE, 5)])
def test_moved(enable, output_enable, tmp_path):
    moved, after = absorbed(tmp_path / "design.json", around(enable, output_enable), [40, 41])
    assert moved == 5 and set(after) == {"mul"}
    pins = after["mul"]["connections"]
    assert [pins[port] for port in ("A0", "A1", "B0", "B1", "P0", "P1")] == [[10], [11], [12], ["0"], [40], [41]]
    inputs, output = (([CLOCK], ["1" if bit is None else bit], ["0"]) for bit in (enable, output_enable))
    assert modes(after["mul"]) == {"INPUTA": inputs, "INPUTB": inputs, "OUTPUT": output}
    assert all(after["mul"]["port_directions"][port] == "input" for port in ("CLK0", "CE0", "CE1", "RST0"))


INPUTS_ONLY, OUTPUT_ONLY = {"INPUTA", "INPUTB"}, {"OUTPUT"}


@pytest.mark.parametrize("changed, ports, left", [
    ({"a1": register(11, 21, LSR=[5])}, [], OUTPUT_ONLY), ({"a1": register(11, 21, REGSET="SET")}, [], OUTPUT_ONLY),
    ({"a1": register(11, 21, CLKMUX="INV")}, [], OUTPUT_ONLY), ({"a1": register(11, 21, CLK=[4])}, [], OUTPUT_ONLY),
    ({"b0": register(12, 22, ENABLE)}, [], OUTPUT_ONLY), ({"b0": register(12, 99)}, [], OUTPUT_ONLY), ({}, [21], OUTPUT_ONLY),
    ({"more": register(22, 50)}, [], OUTPUT_ONLY), ({"mul": multiplier([20, "1"], [22, "0"], [30, 31])}, [], OUTPUT_ONLY),
    ({"mul": multiplier([20, 21], [22, "0"], [30, 31], SIGNEDA=[99])}, [], OUTPUT_ONLY),
    ({"mul": multiplier([20, 21], [22, "0"], [30, 31], C0=[20])}, [], OUTPUT_ONLY),
    ({"p1": register(31, 41, LSR=[5])}, [], INPUTS_ONLY), ({"p1": register(31, 41, ENABLE)}, [], INPUTS_ONLY),
    ({"p0": register(30, 40, CLK=[4]), "p1": register(31, 41, CLK=[4])}, [], INPUTS_ONLY), ({}, [31], INPUTS_ONLY),
    ({"more": register(31, 50)}, [], INPUTS_ONLY), ({"p1": register(9, 41, M=[31])}, [], INPUTS_ONLY),
], ids=["reset", "set at first", "falling clock", "another clock", "another enable", "no register", "a port too", "another reader",
        "a one", "a sign that changes", "a third operand too", "reset behind", "another enable behind", "another clock behind",
        "a port behind", "another reader behind", "not the input"])
def test_side_left_alone(changed, ports, left, tmp_path):
    """One side's registers stay as they are; those of the other one are moved."""
    cells = around() | changed
    moved, after = absorbed(tmp_path / "design.json", copy.deepcopy(cells), [40, 41, *ports])
    assert set(modes(after["mul"])) == left and moved == (2 if left is OUTPUT_ONLY else 3)
    stay = {"a0", "a1", "b0"} if left is OUTPUT_ONLY else {"p0", "p1"}
    assert {name: after[name] for name in stay} == {name: cells[name] for name in stay}


def shared(**more):
    """Two multipliers with a factor in common."""
    return {name: cell for name, cell in around().items() if name[0] != "p"} | {
        "mul2": multiplier([23, "0"], [22, "0"], [32, 33]), "c0": register(13, 23)} | more


def test_shared_factor(tmp_path):
    """Both have a copy. If one of them cannot have its registers, the other one cannot either."""
    moved, after = absorbed(tmp_path / "design.json", shared(), [30, 32])
    assert moved == 4 and set(after) == {"mul", "mul2"}
    assert after["mul"]["connections"]["B0"] == after["mul2"]["connections"]["B0"] == [12]
    cells = shared(c0=register(13, 23, LSR=[5]))
    moved, after = absorbed(tmp_path / "design.json", copy.deepcopy(cells), [30, 32])
    assert moved == 0 and after == cells


def test_register_between_two_multipliers(tmp_path):
    """It is at the input of the second one; the first one then has none."""
    cells = around() | {"mul2": multiplier([40, 41], [22, "0"], [50, 51])}
    moved, after = absorbed(tmp_path / "design.json", cells, [50])
    assert moved == 5 and set(after) == {"mul", "mul2"}
    assert set(modes(after["mul"])) == set(modes(after["mul2"])) == INPUTS_ONLY
    assert after["mul2"]["connections"]["A0"] == after["mul"]["connections"]["P0"] == [30]


class Products(wiring.Component):
    """Two unsigned products with a factor in common, and a signed one with clock enables."""
    def __init__(self):
        super().__init__({"a": In(12), "b": In(12), "c": In(11), "d": In(signed(9)), "e": In(signed(10)), "go": In(1), "on": In(1),
                          "o": Out(46), "s": Out(signed(19))})

    def elaborate(self, platform):
        m = Module()
        a, b, c, d, e = (Signal.like(getattr(self, name), name=f"{name}_later", reset_less=True) for name in "abcde")
        products = [Signal(23, name=f"product_{n}", reset_less=True) for n in range(2)]
        signed_product = Signal.like(self.s, name="signed_product", reset_less=True)
        m.d.sync += [a.eq(self.a), b.eq(self.b), c.eq(self.c), products[0].eq(a * c), products[1].eq(b * c)]
        with m.If(self.go):
            m.d.sync += [d.eq(self.d), e.eq(self.e)]
        with m.If(self.on):
            m.d.sync += signed_product.eq(d * e)
        m.d.comb += [self.o.eq(Cat(products)), self.s.eq(signed_product)]
        return m


BENCH = """
module bench;
  reg clk = 0, rst = 0, go = 0, on = 0;
  reg [11:0] a = 0, b = 0;
  reg [10:0] c = 0;
  reg [8:0] d = 0;
  reg [9:0] e = 0;
  wire [45:0] o;
  wire [18:0] s;
  top dut(.clk(clk), .rst(rst), .a(a), .b(b), .c(c), .d(d), .e(e), .go(go), .on(on), .o(o), .s(s));
  integer n;
  initial for (n = 0; n < 1000; n = n + 1) begin
    #1 a = $random; b = $random; c = $random; d = $random; e = $random; go = $random; on = $random; rst = n == 500;
    #1 $display("%h %h", o, s);
    clk = 1; #1 clk = 0;
  end
endmodule
"""
REGISTERS = 2 * 12 + 11 + 9 + 10 + 2 * 23 + 19


@pytest.mark.slow  # seconds; the netlists above, made by hand, have each condition
def test_netlists_give_the_same(tmp_path):
    """All registers of three products are moved; both netlists on Icarus, cycle by cycle, through a reset."""
    (tmp_path / "design.v").write_text(verilog_text(Products(), name="top"))
    ECP5.synthesise(tmp_path, "top", lambda step: None)
    before = printed(tmp_path / "design.json", BENCH, tmp_path / "before")
    assert absorb_multiplier_registers(tmp_path / "design.json", "top") == REGISTERS
    assert {cell.kind for cell in read_netlist(tmp_path / "design.json")["top"].cells.values()} == {"MULT18X18D"}
    after = printed(tmp_path / "design.json", BENCH, tmp_path / "after")
    assert before == after and len(set(before)) > 900

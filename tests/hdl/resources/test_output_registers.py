"""Registers behind memory blocks, moved into them: what may be, what may not, and that nothing else changes."""

import copy

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.emit import verilog_text
from hdl.netlist import read_netlist
from hdl.parts.delay import Delay, StreamRegister
from hdl.parts.queue import Queue
from hdl.resources.ecp5 import ECP5
from hdl.resources.output_registers import absorb_output_registers
from tests.hdl.resources.ecp5_cells import CLOCK, ENABLE, moved_by, printed, register


def memory(outputs, width=18):
    connections = {f"DO{side}{n}": [] for side in "AB" for n in range(2)}
    connections |= {f"{pin}{side}": ["0"] for pin in ("RST", "OCE") for side in "AB"}
    connections |= {"CLKA": [CLOCK], "CLKB": [CLOCK]} | {port: [bit] for port, bit in outputs.items()}
    parameters = {"DATA_WIDTH_A": f"{width:b}", "REGMODE_A": "NOREG", "REGMODE_B": "NOREG", "CLKAMUX": "CLKA", "CLKBMUX": "CLKB"}
    directions = {port: "output" if port.startswith("DO") else "input" for port in connections}
    return {"type": "DP16KD", "parameters": parameters, "port_directions": directions, "connections": connections}


def absorbed(path, cells, ports=()):
    return moved_by(absorb_output_registers, path, cells, ports)


@pytest.mark.parametrize("enable", [None, ENABLE])
def test_moved(enable, tmp_path):
    """Both outputs of a port that are used; the other port is left alone."""
    cells = {"ram": memory({"DOB0": 10, "DOB1": 11, "DOA0": 12}), "b0": register(10, 20, enable), "b1": register(11, 21, enable),
             "reader": {"type": "LUT4", "parameters": {}, "port_directions": {"Z": "output"}, "connections": {"A": [12], "Z": [30]}}}
    moved, after = absorbed(tmp_path / "design.json", cells, [20, 21])
    assert moved == 2 and set(after) == {"ram", "reader"}
    ram = after["ram"]
    assert (ram["connections"]["DOB0"], ram["connections"]["DOB1"], ram["connections"]["DOA0"]) == ([20], [21], [12])
    assert (ram["parameters"]["REGMODE_A"], ram["parameters"]["REGMODE_B"]) == ("NOREG", "OUTREG")
    assert (ram["connections"]["OCEA"], ram["connections"]["OCEB"]) == (["0"], ["1"] if enable is None else [ENABLE])


def test_block_of_36_bits(tmp_path):
    """It has one read port, whose outputs have both letters."""
    outputs = {f"DO{side}{n}": 10 + 18 * (side == "B") + n for side in "AB" for n in range(18)}
    cells = {"ram": memory(outputs, 36)} | {f"r{bit}": register(bit, bit + 100) for bit in outputs.values()}
    moved, after = absorbed(tmp_path / "design.json", copy.deepcopy(cells))
    assert moved == 36 and set(after) == {"ram"}
    assert (after["ram"]["parameters"]["REGMODE_A"], after["ram"]["parameters"]["REGMODE_B"]) == ("OUTREG", "OUTREG")
    del cells["r45"]
    cells["r45"] = register(45, 145, ENABLE)
    assert absorbed(tmp_path / "design.json", cells)[0] == 0


@pytest.mark.parametrize("b1, ports", [
    (register(11, 21, LSR=[5]), []), (register(11, 21, REGSET="SET"), []), (register(11, 21, CLKMUX="INV"), []),
    (register(11, 21, CLK=[4]), []), (register(11, 21, ENABLE), []), (register(11, 21, CEMUX="INV", CE=[ENABLE]), []),
    (register(99, 21), [11]), (register(11, 21), [11]), (register(99, 21, M=[11]), []),
], ids=["reset", "set at first", "falling clock", "another clock", "another enable", "inverted enable", "a port", "a port too",
        "not the input"])
def test_left_alone(b1, ports, tmp_path):
    cells = {"ram": memory({"DOB0": 10, "DOB1": 11}), "b0": register(10, 20), "b1": b1}
    moved, after = absorbed(tmp_path / "design.json", copy.deepcopy(cells), ports)
    assert moved == 0 and after == cells


def test_memory_with_reset_is_left_alone(tmp_path):
    cells = {"ram": memory({"DOB0": 10}), "b0": register(10, 20)}
    cells["ram"]["connections"]["RSTB"] = [7]
    assert absorbed(tmp_path / "design.json", cells)[0] == 0


def test_delay(tmp_path):
    """All registers behind the block of a delay that is zero at first; it has further ones behind those."""
    (tmp_path / "design.v").write_text(verilog_text(Delay(18, 500, clean=True), name="top"))
    ECP5.synthesise(tmp_path, "top", lambda step: None)
    before = read_netlist(tmp_path / "design.json")["top"].cells
    assert absorb_output_registers(tmp_path / "design.json", "top") == 18
    after = read_netlist(tmp_path / "design.json")["top"].cells
    assert len(before) - len(after) == 18 and all(name in before for name in after)


class Memories(wiring.Component):
    """A queue with the register behind it, which has a clock enable, and a delay that is zero at first, whose has none."""
    def __init__(self):
        super().__init__({"i": In(30), "valid": In(1), "ready": In(1), "o": Out(30), "o_valid": Out(1), "later": Out(18)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = Queue(30, 20)
        m.submodules.register = register = StreamRegister(30)
        m.submodules.delay = delay = Delay(18, 40, clean=True)
        wiring.connect(m, queue.o, register.i)
        m.d.comb += [
            queue.i.payload.eq(self.i), queue.i.valid.eq(self.valid), self.o.eq(register.o.payload), self.o_valid.eq(register.o.valid),
            register.o.ready.eq(self.ready), delay.i.eq(self.i), self.later.eq(delay.o),
        ]
        return m


BENCH = """
module bench;
  reg clk = 0, rst = 0, valid = 0, ready = 0;
  reg [29:0] i = 0;
  wire [29:0] o;
  wire o_valid;
  wire [17:0] later;
  top dut(.clk(clk), .rst(rst), .i(i), .valid(valid), .ready(ready), .o(o), .o_valid(o_valid), .later(later));
  integer n;
  initial for (n = 0; n < 1000; n = n + 1) begin
    #1 i = $random; valid = $random; ready = $random; rst = n == 500;
    #1 $display("%h %b %h", o_valid ? o : 30'd0, o_valid, later);
    clk = 1; #1 clk = 0;
  end
endmodule
"""


@pytest.mark.slow  # three seconds; the netlists above, made by hand, have each condition
def test_netlists_give_the_same(tmp_path):
    """Both netlists on Icarus, cycle by cycle, through a reset."""
    (tmp_path / "design.v").write_text(verilog_text(Memories(), name="top"))
    ECP5.synthesise(tmp_path, "top", lambda step: None)
    before = printed(tmp_path / "design.json", BENCH, tmp_path / "before")
    assert absorb_output_registers(tmp_path / "design.json", "top") == 48
    after = printed(tmp_path / "design.json", BENCH, tmp_path / "after")
    assert before == after and len(set(before)) > 900

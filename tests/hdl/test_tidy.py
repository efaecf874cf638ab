import re

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.emit import rtlil_text, verilog_text
from hdl.tidy import tidy
from hdl.widths import pad_operands
from hdl.yosys import Tool, run_yosys


MODULE = """module {name}({ports});
{body}endmodule
"""

# Whether Verilog and RTLIL compute the same, from any state on, as registers are matched by name.
PROOF = """
read_rtlil {rtlil}
proc
flatten
memory -nomap
opt_clean
rename top gold
design -stash gold
read_verilog {verilog}
proc
flatten
memory -nomap
opt_clean
rename top gate
design -stash gate
design -copy-from gold -as gold gold
design -copy-from gate -as gate gate
miter -equiv -flatten -make_outputs gold gate miter
hierarchy -top miter
sat -verify -prove trigger 0 -set-init-zero -seq 1 -tempinduct miter
"""


class Operators(wiring.Component):
    """Every operator that Amaranth has, on operands of several widths, with and without signs."""
    SHAPES = unsigned(3), unsigned(6), signed(4), signed(7)

    def __init__(self):
        super().__init__({**{f"i{number}": In(shape) for number, shape in enumerate(self.SHAPES)}, "o": Out(1200)})

    def elaborate(self, platform):
        m = Module()
        operands = [getattr(self, f"i{number}") for number in range(len(self.SHAPES))]
        results = [result for value in operands for result in (~value, -value, value == 0, value != 0, value.bool(), abs(value), value + 21,
                                                               5 - value, value < 3, value >= -3)]
        results += [result for a in operands for b in operands for result in (
            a + b, a - b, a & b, a | b, a ^ b, a < b, a <= b, a == b, a != b, a > b, a >= b)]
        results += [operands[0] * operands[1], operands[2] * operands[3], operands[1] << operands[0], operands[3] >> operands[0],
                    (operands[1] >> operands[0])[:2], (operands[3] >> operands[0])[:3],
                    operands[1].bit_select(operands[0], 2), operands[3].word_select(operands[0], 3)]
        m.d.comb += self.o.eq(Cat(results))
        assert len(Cat(results)) < len(self.o)
        return m


def proved(component, folder, change=lambda text: text):
    """Whether Yosys's solver finds no difference between a component and its Verilog."""
    (folder / "design.il").write_text(rtlil_text(component, name="top"))
    (folder / "design.v").write_text(change(verilog_text(component, name="top")))
    try:
        run_yosys(Tool.PYOSYS, PROOF.format(rtlil="design.il", verilog="design.v"), folder)
    except RuntimeError as error:
        assert "proof did fail" in str(error)
        return False
    return True


def test_the_same_is_computed(tmp_path):
    pytest.importorskip("pyosys", reason="pyosys, which reads Verilog, is not installed")
    assert proved(Operators(), tmp_path)
    sign = "{ i3[6], i3 }"
    assert sign in verilog_text(Operators(), name="top")
    assert not proved(Operators(), tmp_path, lambda text: text.replace(sign, "{ 1'h0, i3 }", 1))


def test_operands_are_as_wide_as_the_operation():
    text = pad_operands(rtlil_text(Operators(), name="top"))
    kinds = set()
    for kind, body in re.findall(r"(?m)^  cell \$(\w+) .*\n((?:    .*\n)*)", text):
        widths = {side: int(width) for side, width in re.findall(r"\\([ABY])_WIDTH (\d+)", body)}
        if kind in ("add", "sub", "and", "or", "xor", "neg", "not"):
            kinds.add(kind)
            assert len(set(widths.values())) == 1, body
        elif kind in ("lt", "le", "eq", "ne", "ge", "gt"):
            kinds.add(kind)
            assert widths["A"] == widths["B"], body
        elif kind in ("shr", "shift", "shiftx"):
            kinds.add("shift")
            assert widths["A"] == widths["Y"], body
    assert len(kinds) == 14


def test_comparison_with_zero():
    nets = "  wire [5:0] a;\n  wire b;\n  reg signed [3:0] c;\n"
    operands = "a", "a[4:3]", "a[2]", "b", "c", "{ a[5:1], b, c }"
    body = nets + "".join(f"  assign x = ! {operand};\n" for operand in operands)
    text = tidy(MODULE.format(name="top", ports="a, b", body=body))
    assert re.findall("assign x = (.*);", text) == [
        "a == 6'h00", "a[4:3] == 2'h0", "! a[2]", "! b", "c == 4'h0", "{ a[5:1], b, c } == 10'h000"]


def test_initial_values_and_branches():
    body = ("  reg [3:0] a{};\n{}  reg [1:0] m [3:0];\n"
            "  always @(posedge clk)\n    if (x){}\n      if (y) a <= 4'h5;\n      else a <= b;\n{}")
    text = tidy(MODULE.format(name="top", ports="", body=body.format(" = 4'h5", "", "", "")))
    assert text == MODULE.format(name="top", ports="", body=body.format("", "  initial a = 4'h5;\n", " begin", "    end\n"))


def test_ports_and_nets_without_a_use():
    """They go, level by level; the top level's ports, black boxes and their pins stay. What some instances need is open at the others."""
    def module(name, ports, body):
        declared = "".join(f"  {direction} {port};\n  wire {port};\n" for direction, port in ports)
        return MODULE.format(name=name, ports=", ".join(port for _, port in ports), body=declared + body)

    def instance(kind, name, **pins):
        return f"  {kind} {name} (\n" + ",\n".join(f"    .{port}({net})" for port, net in pins.items()) + "\n  );\n"

    ports = [("input", "i"), ("input", "rst"), ("output", "o")]
    box = "  box #(\n    .rst(32'd1)\n  ) other (\n    .rst(rst)\n  );\n"
    text = tidy(
        module("top", [*ports, ("input", "never")], "  wire used;\n  wire alone;\n  wire spare;\n"
               + instance("inner", "one", i="i", o="used", rst="rst") + instance("inner", "two", i="used", o="spare", rst="rst") + box
               + "  wire nothing;\n  wire low;\n  wire high;\n" + instance("inner", "three", i="nothing", o="{ high, low }", rst="rst")
               + "  wire again;\n  assign again = unread;\n  wire unread;\n  assign unread = i;\n  assign o = used;\n")
        + module("inner", ports, instance("leaf", "leaf", i="i", o="o", rst="rst"))
        + module("leaf", ports, "  assign o = i;\n"))
    headers = dict(re.findall(r"module (\w+)\((.*)\);", text))
    assert headers == {"top": "i, rst, o, never", "inner": "i, o", "leaf": "i, o"}
    assert not re.search("spare|alone|low|high|again|unread", text) and "  wire used;\n" in text and "  wire never;\n" in text
    assert "  inner two (\n    .i(used),\n    .o()\n  );\n" in text and "  inner three (\n    .i(nothing),\n    .o()\n  );\n" in text
    assert box in text
    assert re.findall(r"input rst|wire rst|\.rst\(", text) == ["input rst", "wire rst", ".rst(", ".rst("]


class Memories(wiring.Component):
    """A memory, read and written, and a register that nothing reads."""
    def __init__(self):
        super().__init__({"i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=4, depth=16, init=[])
        read, write = memory.read_port(), memory.write_port()
        unread = Signal(4)
        m.d.sync += unread.eq(self.i)
        m.d.comb += [read.addr.eq(self.i), write.addr.eq(self.i + 1), write.data.eq(~self.i), write.en.eq(1), self.o.eq(read.data)]
        return m


def test_no_name_without_a_use():
    text = verilog_text(Memories(), name="top")
    names = re.findall(r"(?m)^  (?:wire|reg) (?:\[\d+:0\] )?(\w+)", text)
    assert {"i", "o", "clk"} <= set(names) and "unread" not in names
    assert [name for name in names if len(re.findall(rf"\b{name}\b", text)) == 1] == []

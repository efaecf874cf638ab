import re
from pathlib import Path

import pytest
from amaranth import *
from amaranth.back import rtlil
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass
from golden.errors import UserError
from hdl.emit import _plain_ports, emit_rtlil, rtlil_text, verilog_text, write_verilog
from hdl.matcher.matcher import Matcher
from hdl.matcher.sequential.smooth import LookUpTable
from hdl.netlist import read_netlist
from hdl.parts.delay import Delay
from hdl.yosys import Tool, run_yosys
from tests.kit import refused_components


class Store(wiring.Component):
    """A memory with initial content."""
    def __init__(self, init, *, names=("kept", "kept_too")):
        self.init = init
        self.names = names
        super().__init__({"i": In(4), "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=8, depth=16, init=self.init)
        read = memory.read_port()
        write = memory.write_port()
        first, second = (Signal(8, name=name) for name in self.names)
        m.d.sync += [first.eq(read.data), second.eq(first)]
        m.d.comb += [read.addr.eq(self.i), write.addr.eq(self.i), write.en.eq(self.i[0]), write.data.eq(second), self.o.eq(first ^ second)]
        return m


class Outer(wiring.Component):
    """A hierarchy with the sub-module names that Verilog and SystemVerilog reserve."""
    def __init__(self):
        super().__init__({"i": In(4), "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.table = table = Store([])
        m.submodules.priority = priority = Store(range(16))
        m.d.comb += [table.i.eq(self.i), priority.i.eq(self.i), self.o.eq(table.o ^ priority.o)]
        with m.FSM():
            with m.State("between frames"):
                with m.If(self.i[1]):
                    m.next = "last line"
            with m.State("last line"):
                m.d.comb += self.o.eq(0)
                m.next = "between frames"
        return m


def code(text):
    """Without strings and comments."""
    return re.sub(r'"[^"\n]*"|//[^\n]*|/\*.*?\*/', "", text, flags=re.DOTALL)


def test_names():
    text = verilog_text(Outer(), name="outer")
    assert re.findall(r"(?m)^module (\w+)", text) == ["outer", "outer_priority", "outer_table"]
    assert re.findall(r"(?m)^  (outer_\w+) (\w+) \($", text) == [("outer_priority", "priority_"), ("outer_table", "table_")]
    assert "\\" not in text


def test_no_trace_of_the_source():
    """No file names, attributes or banners of tools: the same gateware gives the same bytes in every checkout."""
    text = verilog_text(Outer(), name="outer")
    assert not re.search(r"\.py|\(\*|Generated|Yosys|Amaranth|/\*", text)
    assert "always @*" not in text
    assert verilog_text(Outer(), name="outer") == text


class Marked(wiring.Component):
    """A register with attributes of which one is to be kept, and logic that Yosys writes attributes for."""
    def __init__(self):
        super().__init__({"i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        register = Signal(4, attrs={"wanted": "-name A B; -name C D", "unwanted": 1})
        m.d.sync += register.eq(self.i)
        with m.Switch(register):
            for value in range(5):
                with m.Case(value):
                    m.d.comb += self.o.eq(value ^ 5)
            with m.Default():
                m.d.comb += self.o.eq(self.i)
        return m


def test_attributes_that_are_kept():
    """By name, in front of what they belong to; the rest of the text is what it is without them."""
    source = rtlil.convert(Marked(), name="marked", emit_src=False)
    plain, marked = emit_rtlil(source).verilog, emit_rtlil(source, attributes=("wanted",)).verilog
    line = '  (* wanted = "-name A B; -name C D" *)\n'
    assert f"{line}  reg [3:0] register;\n  initial register = 4'h0;\n" in marked
    assert marked.replace(line, "") == plain
    assert "(*" not in plain and "parallel_case" in plain
    assert emit_rtlil(source, attributes=("other",)).verilog == plain


def test_keyword_as_signal_name():
    text = code(verilog_text(Store([], names=("reg", "a.b")), name="store"))
    assert re.search(r"\breg \[7:0\] reg_;\n  initial reg_ = 8'h00;", text)
    assert re.search(r"\ba_b\b", text)
    assert "\\" not in text


@pytest.mark.parametrize("names, plain", [
    (("a.b", "a_b"), {"a_b", "a_b_"}),
    (("a.b", "a-b"), {"a_b", "a_b_"}),
    (("reg", "reg_"), {"reg_", "reg__"}),
])
def test_names_that_meet_stay_two(names, plain):
    text = code(verilog_text(Store([], names=names), name="store"))
    found = set(re.findall(r"(?:wire|reg) \[7:0\] ((?:a_b|reg)\w*)", text))
    assert found == plain
    for name in plain:
        assert len(re.findall(rf"\b{name} <= |assign {name} = ", text)) in (1, 2)  # a register: reset and value


class Ports(wiring.Component):
    """A sub-module with the same ports, whose inverse is in a net of some name."""
    def __init__(self, names, net="net", inner=True):
        self.net = net
        self.inner = Ports(names, net, inner=False) if inner else None
        self.names = names
        super().__init__({"given": In(8), **{name: Out(8) for name in names}})

    def elaborate(self, platform):
        m = Module()
        net = Signal(8, name=self.net)
        m.d.sync += net.eq(~self.given)
        if self.inner:
            m.submodules.inner = inner = self.inner
            m.d.comb += [inner.given.eq(net), *(getattr(self, name).eq(getattr(inner, name)) for name in self.names)]
        else:
            m.d.comb += [getattr(self, name).eq(net + number) for number, name in enumerate(self.names)]
        return m


def test_names_for_other_languages():
    """Ports have single underscores, no name is a keyword of Verilog-AMS; a net in the way of a port's new name gives way."""
    text = code(verilog_text(Ports(("a__b", "timer", "last__word"), net="a_b"), name="top"))
    assert re.findall(r"output \[7:0\] (\w+)", text) == 2 * ["a_b", "last_word", "timer_"]
    assert set(re.findall(r"\.(\w+)\(", text)) == {"clk", "rst", "given", "a_b", "timer_", "last_word"}
    assert "a_b_ <= " in text and not {"timer", "a__b"} & set(re.findall(r"\w+", text))
    assert "floor_ <= " in verilog_text(Ports(("one",), net="floor"), name="top")


def test_ports_that_meet_are_refused():
    with refused_components(), pytest.raises(ValueError, match=r"two ports have the same name with single underscores: .*a__b"):
        verilog_text(Ports(("a__b", "a_b"), inner=False), name="top")


@pytest.mark.parametrize("content", [[], [0] * 16])
def test_memory_of_zeros_is_not_initialised(content):
    text = verilog_text(Store(content), name="store")
    assert re.search(r"reg \[7:0\] memory \[15:0\];", text)
    assert not re.search(r"initial begin|memory\[\d+\] =", text)


def test_content_is_kept():
    content = [0, 0, 7, *range(13)]
    text = verilog_text(Store(content), name="store")
    assert [int(word, 16) for word in re.findall(r"memory\[\d+\] = 8'h(\w+);", text)] == content


def test_look_up_tables():
    """LINEAR's table is a ROM of distances; that of THESIS is filled and needs no content."""
    labels = 5
    text = verilog_text(LookUpTable(MatcherConfig(labels=labels, method=OnePass(Arithmetic.LINEAR))), name="table")
    rows = [int(row, 16) for row in re.findall(r"memory\[\d+\] = 15'h(\w+);", text)]
    assert rows == [sum(abs(d - p) << 3 * d for d in range(labels)) for p in range(labels)]
    assert "initial begin" not in verilog_text(LookUpTable(MatcherConfig(labels=labels, method=OnePass(Arithmetic.THESIS))), name="table")


def test_ports_follow_the_signature():
    text = verilog_text(Outer(), name="outer")
    assert re.search(r"module outer\(([^)]*)\)", text)[1].split(", ") == ["clk", "rst", "i", "o"]


def test_netlist_is_that_of_the_text(tmp_path):
    """Ports and instances of the netlist are those that another Yosys reads from the Verilog, except for names that are not plain."""
    pytest.importorskip("pyosys", reason="pyosys, which reads Verilog, is not installed")
    emitted = emit_rtlil(rtlil.convert(Outer(), name="outer", emit_src=False))
    assert sorted(_plain_ports(emitted.verilog)) == sorted(verilog_text(Outer(), name="outer"))      # but for the order of ports
    (tmp_path / "outer.v").write_text(emitted.verilog)
    run_yosys(Tool.PYOSYS, "read_verilog outer.v\nhierarchy -top outer\nproc\nwrite_json outer.json\n", tmp_path)
    read = read_netlist(tmp_path / "outer.json")

    def facts(modules):
        return {name.replace(".", "_"): (
            {port: (told.direction, len(told.bits)) for port, told in module.ports.items()},
            sorted(cell.kind.replace(".", "_") for cell in module.cells.values() if not cell.kind.startswith("$")))
            for name, module in modules.items()}

    assert facts(emitted.netlist) == facts(read)
    assert facts(read)["outer"][1] == ["outer_priority", "outer_table"]


def test_write(tmp_path):
    path = write_verilog(Outer(), tmp_path / "new" / "outer.v", name="outer")
    assert path.read_text() == verilog_text(Outer(), name="outer")
    assert [file.name for file in path.parent.iterdir()] == ["outer.v"]


def test_write_that_fails_leaves_nothing(tmp_path):
    (tmp_path / "outer.v").mkdir()
    with pytest.raises(UserError):
        write_verilog(Outer(), tmp_path / "outer.v", name="outer")
    assert [file.name for file in tmp_path.iterdir()] == ["outer.v"]


class Delays(wiring.Component):
    """Memories with and without the mark."""
    def __init__(self):
        super().__init__({"i": In(40), "o": Out(40)})

    def elaborate(self, platform):
        m = Module()
        value = self.i
        for number, clocks in enumerate((100, 4, 6)):
            m.submodules[f"delay_{number}"] = delay = Delay(40, clocks)
            m.d.comb += delay.i.eq(value)
            value = delay.o
        m.submodules.bit = bit = Delay(1, 73)
        m.submodules.store = store = Store([])
        m.d.comb += [bit.i.eq(value[0]), store.i.eq(value), self.o.eq(Cat(value[8:], bit.o) ^ store.o)]
        return m


def test_marks_of_memories():
    """Those of the design, and no others; what is too small for a block is not forced into one."""
    source = rtlil_text(Delays(), name="top")
    marked = {name.replace(".", "_") for name, body in re.findall(r"(?ms)^module \\(\S+)$(.*?)^end$", source) if "no_rw_check" in body}
    found = {}
    for name, body in re.findall(r"(?ms)^module (\w+)(.*?)^endmodule", verilog_text(Delays(), name="top")):
        for attributes in re.findall(r"(?m)^((?:(?:  \(\*|`).*\n)*)  reg (?:\[\d+:0\] )?memory \[", body):
            found[name] = re.findall(r"\(\* (.*) \*\)", attributes)
    assert {name for name, attributes in found.items() if attributes} == marked == {"top_delay_0", "top_delay_2", "top_bit"}
    assert found == {
        "top_delay_0": ["no_rw_check", 'ramstyle = "M9K, no_rw_check"'], "top_delay_2": ["no_rw_check", 'ramstyle = "M9K, no_rw_check"'],
        "top_bit": ["no_rw_check", 'ramstyle = "no_rw_check"'], "top_store": [],
    }


def test_ports_are_in_the_order_of_the_readme():
    config = MatcherConfig(labels=2, max_width=4, method=FUSED_1)
    text = verilog_text(Matcher(config), name="matcher")
    readme = (Path(__file__).parents[2] / "README.md").read_text().partition("## The core's ports")[2]
    told = [port for row in re.findall(r"(?m)^\| (`.*?) \|", readme) for port in re.findall(r"`(\w+)", row)]
    assert re.search(r"module matcher\((.*)\);", text)[1].split(", ") == told

"""The mapping for the count: from the Verilog, a block for each instance."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.resources import mapping
from hdl.resources.count import Resources, count
from tests.kit import Circuit


class Inner(wiring.Component):
    def __init__(self, width):
        super().__init__({"a": In(width), "y": Out(width)})

    def elaborate(self, platform):
        m = Module()
        m.d.sync += self.y.eq(self.y + self.a)
        return m


def test_blocks():
    def build(c, m):
        m.submodules.first = first = Inner(8)
        m.submodules.second = second = Inner(12)
        m.submodules.memory = memory = Memory(shape=12, depth=256, init=[])
        read, write = memory.read_port(), memory.write_port()
        # `a & b` leads to both blocks: it belongs to the one around them.
        both = c.a & c.b
        m.d.comb += [first.a.eq(both), second.a.eq(both), c.y.eq(read.data)]
        m.d.comb += [write.en.eq(1), write.addr.eq(first.y), write.data.eq(second.y), read.addr.eq(c.a)]
    result = count(mapping.map_cyclone3(Circuit(build, a=In(8), b=In(8), y=Out(12)), "top"))
    assert result.blocks == {
        "top": Resources(logic_elements=8, memory_bits=3072, m9k=1),
        "top.first": Resources(logic_elements=8),
        "top.second": Resources(logic_elements=12),
    }
    assert result.total == Resources(28, 3072, 1, 0)


def test_equal_blocks_are_one_module_and_count_each():
    """Blocks have the names of instances in the Verilog, in which `output` is a keyword of the language."""
    def build(c, m):
        m.submodules.output = first = Inner(8)
        m.submodules.second = second = Inner(8)
        m.d.comb += [first.a.eq(c.a), second.a.eq(c.b), c.y.eq(first.y ^ second.y)]
    assert count(mapping.map_cyclone3(Circuit(build, a=In(8), b=In(8), y=Out(8)), "top")).blocks == {
        "top": Resources(logic_elements=8), "top.output_": Resources(logic_elements=8), "top.second": Resources(logic_elements=8),
    }


def test_memory_addressed_by_another_one():
    """The register behind a memory is that memory's, not the address register of the next one."""
    def build(c, m):
        m.submodules.queue = queue = Memory(shape=8, depth=256, init=[])
        m.submodules.table = table = Memory(shape=12, depth=256, init=[])
        for memory, address, port in ((queue, c.b, queue.read_port()), (table, c.queued, table.read_port())):
            write = memory.write_port()
            m.d.comb += [write.en.eq(1), write.addr.eq(c.a), write.data.eq(c.b), port.addr.eq(address), port.en.eq(c.enable)]
            m.d.comb += (c.queued if memory is queue else c.y).eq(port.data)
    counted = count(mapping.map_cyclone3(Circuit(build, a=In(8), b=In(8), enable=In(1), queued=Out(8), y=Out(12)), "top"))
    assert counted.total == Resources(logic_elements=0, memory_bits=4096, m9k=2)


# What blocks hold leads out of them: it must be marked to count for its block, be it a cell or a process.
VERILOG = """
module sums(a, b, y);
  input [7:0] a, b;
  output [7:0] y;
  assign y = a + b;
endmodule
module registers(clk, d, q);
  input clk;
  input [7:0] d;
  output reg [7:0] q;
  always @(posedge clk)
    q <= d;
endmodule
module top(clk, d, y, q);
  input clk;
  input [7:0] d;
  output [7:0] y, q;
  sums adder(.a(d), .b(q), .y(y));
  registers held(.clk(clk), .d(d), .q(q));
endmodule
"""


def test_what_is_counted_is_the_verilog(monkeypatch):
    monkeypatch.setattr(mapping, "verilog_text", lambda component, *, name: VERILOG)
    blocks = count(mapping.map_cyclone3(None, "top")).blocks
    assert blocks == {"top.adder": Resources(logic_elements=8), "top.held": Resources(logic_elements=8)}

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.emit import verilog_text
from hdl.verilog import clock_sources, modules


# What hdl.emit writes of a board's top level, shortened: a clock through buffers of two levels, one from a PLL, one made of logic.
TEXT = """
module top(osc__io, cam__io, bus__io, led__io
, enable);
  wire _0_;
  inout [3:0] bus__io;
  input cam__io;
  input enable;
  wire camera_clk;
  output led__io;
  input [1:0] osc__io;
  wire [4:0] clocks;
  reg [7:0] count = 8'h00;
  assign _0_ = camera_clk & enable;
  assign display = clocks[0];
  always @(posedge display)
    count <= 8'h01;
  altpll #(
    .clk0_divide_by(32'd10),
    .operation_mode("NORMAL")
  ) pll (
    .areset(1'h0),
    .clk(clocks),
    .inclk({ 1'h0, osc__io[1] }),
    .locked(locked)
  );
  top_buffer buffer_ (
    .cam__io(cam__io),
    .i(camera_clk)
  );
  top_user user (
    .clk(camera_clk),
    .o(led__io)
  );
  top_user gated (
    .clk(_0_),
    .o(led__io)
  );
endmodule

module top_buffer(cam__io, i);
  input cam__io;
  output i;
  altiobuf_in #(
    .number_of_channels(32'd1)
  ) buf_ (
    .datain(cam__io),
    .dataout(i)
  );
endmodule

module top_user(clk, o);
  input clk;
  output o;
  reg o;
  always @(posedge clk, negedge rst_n)
    o <= 1'h1;
endmodule
"""


def test_modules():
    found = modules(TEXT)
    assert list(found) == ["top", "top_buffer", "top_user"]
    assert found["top"].ports == {"bus__io": ("inout", 4), "cam__io": ("input", 1), "enable": ("input", 1), "led__io": ("output", 1),
                                  "osc__io": ("input", 2)}
    assert [(child.kind, child.name) for child in found["top"].instances] == [
        ("altpll", "pll"), ("top_buffer", "buffer_"), ("top_user", "user"), ("top_user", "gated")]
    assert found["top"].instances[0].connections == {"areset": "1'h0", "clk": "clocks", "inclk": "{ 1'h0, osc__io[1] }", "locked": "locked"}


def test_clock_sources():
    assert clock_sources(modules(TEXT), "top") == {"osc__io", "cam__io", "altpll.clk", "? _0_"}


@pytest.mark.parametrize("change, source", [
    (("always @(posedge display)", "always @(posedge count)"), "? count"),
    (("assign display = clocks[0];", "assign display = other;"), "? other"),
    (("assign display = clocks[0];", "assign display = back;\n  assign back = display;"), "? back"),
    ((".inclk({ 1'h0, osc__io[1] })", ".inclk(2'h0)"), "? constant"),
    (("always @(posedge display)", "always @(negedge enable)"), "enable"),
    (("always @(posedge clk, negedge rst_n)", "always @(posedge o)"), "? user.o"),
])
def test_other_sources(change, source):
    assert change[0] in TEXT
    assert source in clock_sources(modules(TEXT.replace(*change)), "top")


class Inner(wiring.Component):
    def __init__(self):
        super().__init__({"i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.d.sync += self.o.eq(self.i)
        return m


class Outer(wiring.Component):
    """Two clocks, one of them made of the other by logic."""
    def __init__(self):
        super().__init__({"clock": In(1), "i": In(4), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.domains.slow = slow = ClockDomain(reset_less=True, local=True)
        m.submodules.first = first = Inner()
        m.submodules.second = second = DomainRenamer("slow")(Inner())
        m.d.comb += [slow.clk.eq(self.clock ^ self.i[0]), first.i.eq(self.i), second.i.eq(first.o), self.o.eq(second.o)]
        return m


def test_emitted_text():
    found = modules(verilog_text(Outer(), name="outer"))
    assert set(found) == {"outer", "outer_first", "outer_second"}
    assert found["outer"].ports == {"clk": ("input", 1), "rst": ("input", 1), "clock": ("input", 1), "i": ("input", 4), "o": ("output", 4)}
    sources = clock_sources(found, "outer")
    assert "clk" in sources and len(sources) == 2
    assert any(source.startswith("? ") for source in sources)

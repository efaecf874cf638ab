"""The harness, with a stand-in for the matcher: correct output is accepted, and each fault of the stand-in is reported."""

import numpy as np
import pytest

from golden.config import MatcherConfig
from sim.kit.harness import Traffic, simulate
from sim.kit.simulators import SIMULATORS, SimulationError, build, run
from sim.kit.store import models


CONFIG = MatcherConfig(labels=16)

# A register stage whose disparity is the low bits of the left pixel, plus those of u1 once `apply_settings` has been seen.
STAND_IN = """
module matcher(input clk, input rst, input [5:0] u1, input [5:0] u2, input [5:0] u3, input [8:0] in_use,
               input apply_settings, input clear, output error, input i_valid, output i_ready,
               input [18:0] i_payload, output o_valid, input o_ready, output [6:0] o_payload);
  reg valid; reg [18:0] word; reg [3:0] weight; reg [7:0] count; reg [3:0] never; reg beat;
  assign i_ready = {i_ready};
  assign o_valid = {o_valid};
  assign o_payload = {o_payload};
  assign error = {error};
  initial begin valid = 0; count = 0; weight = 0; beat = 0; end
  always @(posedge clk) begin
    beat <= !beat;
    if (apply_settings) weight <= u1[3:0];
    if (o_valid && o_ready) begin valid <= 0; count <= count + 1; end
    if (i_valid && i_ready) begin valid <= 1; word <= i_payload; end
  end
endmodule
"""
GOOD = {"i_ready": "!valid || o_ready", "o_valid": "valid", "o_payload": "{word[18:16], word[3:0] + weight}", "error": "1'b0"}

# Changed expressions, and the harness's message.
FAULTS = {
    "payload changes while stalled": ({"o_payload": "{word[18:16], word[3:0] ^ {3'b0, beat}}"}, "rule_errors"),
    "valid drops": ({"o_valid": "valid && beat", "i_ready": "!valid || o_ready && beat"}, "rule_errors"),
    "valid waits for ready": ({"o_valid": "valid && o_ready"}, "hang 1"),
    "first is missing": ({"o_payload": "{word[18:17], 1'b0, word[3:0]}"}, "flag_errors 2"),
    "last is missing": ({"o_payload": "{word[18], 1'b0, word[16], word[3:0]}"}, "flag_errors 6"),
    "end is missing": ({"o_payload": "{1'b0, word[17:16], word[3:0]}"}, "flag_errors 2"),
    "unknown bit": ({"o_payload": "{word[18:16], word[3:0] ^ never}"}, "unknown_words"),
    "word is lost": ({"o_valid": "valid && count != 5", "i_ready": "!valid || o_ready || count == 5"}, "hang 1"),
    "word is invented": ({"o_valid": "valid || count >= 35"}, "extra_words"),
    "nothing is taken": ({"i_ready": "count < 9 && (!valid || o_ready)"}, "hang 1"),
    "ready is unknown": ({"i_ready": "(!valid || o_ready) ^ (count == 3 && never[0])"}, "rule_errors"),
    "frame was taken for ragged": ({"error": "1'b1"}, "error 1"),
}


def pictures(*sizes):
    rng = np.random.default_rng(1)
    return [rng.integers(0, 256, (height, width), dtype=np.uint8) for width, height in sizes]


def stand_in(folder, **changes):
    text = STAND_IN
    for name, expression in (GOOD | changes).items():
        text = text.replace("{" + name + "}", expression)
    path = folder / "stand_in.v"
    path.write_text(text)
    return path


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_good(tmp_path, simulator):
    """Frames of different sizes in a row, stalls, weights, and the counts: all on one build, in a folder of any name."""
    verilog = stand_in(tmp_path)
    work = tmp_path / "a b$'%;"
    lefts, rights = pictures((7, 3), (1, 1), (300, 1), (1, 9)), pictures((7, 3), (1, 1), (300, 1), (1, 9))
    lines = []
    plain = simulate(CONFIG, lefts, rights, simulator=simulator, work_dir=work, verilog=verilog, progress=lines.append)
    assert lines[-1] == 3 + 1 + 1 + 9
    assert [fields["disparity"].tolist() for fields in plain.fields] == [(left % 16).tolist() for left in lefts]
    # The stage has a latency of one clock; without stalls a pixel a clock.
    assert [frame.latency for frame in plain.frames] == [frame.latency_first for frame in plain.frames] == [1, 1, 1, 1]
    assert [frame.in_clocks for frame in plain.frames] == [21, 1, 300, 9]
    assert [frame.out_clocks for frame in plain.frames] == [20, 0, 299, 8]
    assert [frame.clocks for frame in plain.frames] == [22, 2, 301, 10]
    assert plain.frames[2].clocks_per_pixel == 1.0

    stalled = simulate(CONFIG, lefts, rights, simulator=simulator, work_dir=work, verilog=verilog, stall_i=0.5, stall_o=0.5,
                       settings={"u1": 3, "u2": 0, "u3": 0})
    assert [fields["disparity"].tolist() for fields in stalled.fields] == [((left + 3) % 16).tolist() for left in lefts]
    assert stalled.build_seconds < 0.5   # used again
    # And the runtime libraries of Verilator are compiled once for all models.
    assert simulator == "icarus" or {"verilated.o", "verilated_vpi.o"} <= {path.name.split("-")[-1] for path in models().folder.glob("*.o")}
    assert 2 < stalled.frames[2].clocks_per_pixel < 4


# The stand-in with settings as a matcher has them: each frame keeps those that were in force as its first pixel was accepted.
SETTLED = {"o_payload": "{word[18:16], word[3:0] + used}"}


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_traffic(tmp_path, simulator):
    """Settings and stalls of each frame."""
    verilog = stand_in(tmp_path, **SETTLED)
    taken = "i_valid && i_ready && i_payload[16] ? weight : used"
    verilog.write_text(verilog.read_text().replace("reg beat;", "reg beat; reg [3:0] used;").replace(
        "beat <= !beat;", f"beat <= !beat; used <= {taken};"))
    traffic = [Traffic(stall_i=0.5), Traffic(settings={"u1": 3}), Traffic(0.03, 0.0, 200, 0), Traffic(0.0, 0.03, 0, 200, {"u1": 9}),
               Traffic(settings={})]
    lefts = pictures(*[(40, 10)] * len(traffic))
    result = simulate(CONFIG, lefts, lefts, simulator=simulator, work_dir=tmp_path, verilog=verilog, traffic=traffic)
    weights = [0, 3, 3, 9, CONFIG.method.weights.u1]
    found = [np.unique((fields["disparity"] - left) % 16).tolist() for fields, left in zip(result.fields, lefts)]
    assert found == [[weight] for weight in weights]
    rates = [frame.clocks_per_pixel for frame in result.frames]
    assert 1.7 < rates[0] < 2.4 and rates[1] < 1.02 and rates[4] < 1.02
    # A burst lasts 100 clocks on average.
    assert all(2 < rate < 7 for rate in rates[2:4])


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_reported(tmp_path, fault):
    changes, told = FAULTS[fault]
    lefts, rights = pictures((6, 3), (6, 3)), pictures((6, 3), (6, 3))
    with pytest.raises(SimulationError, match=told):
        simulate(CONFIG, lefts, rights, simulator="icarus", work_dir=tmp_path, verilog=stand_in(tmp_path, **changes), stall_i=0.3,
                 stall_o=0.3, timeout=500)


@pytest.mark.parametrize("stall", [0.0, 0.5])
@pytest.mark.parametrize("fault", [None, "payload changes while stalled", "valid drops", "valid waits for ready", "unknown bit",
                                   "word is invented"])
def test_cocotb_drivers(tmp_path, stall, fault):
    """The drivers of :mod:`sim.kit.cocotb_streams` on the stand-in."""
    changes = FAULTS[fault][0] if fault else {}
    build("icarus", [stand_in(tmp_path, **changes)], "matcher", tmp_path / "icarus", debug=True)
    arguments = ("icarus", "matcher", tmp_path / "icarus", "sim.benches.streams_tb")
    # Who never stalls cannot see whether `valid` waits.
    if fault is None or (fault == "valid waits for ready" and stall == 0):
        assert run(*arguments, env={"STALL": stall}) == 1
    else:
        with pytest.raises(SimulationError, match="1 of 1 tests"):
            run(*arguments, env={"STALL": stall})


def test_missing_bench_is_reported(tmp_path):
    build("icarus", [stand_in(tmp_path)], "matcher", tmp_path / "icarus")
    for module in ("sim.none_tb", "sim.kit.simulators"):   # no such module; a module without tests
        with pytest.raises(SimulationError, match=r"ended abnormally|no test"):
            run("icarus", "matcher", tmp_path / "icarus", module)


def test_bad_verilog_is_reported(tmp_path):
    verilog = tmp_path / "bad.v"
    verilog.write_text("module matcher(input clk; endmodule\n")
    with pytest.raises(SimulationError, match=r"(?s)did not build.*bad\.v"):
        build("icarus", [verilog], "matcher", tmp_path / "icarus")

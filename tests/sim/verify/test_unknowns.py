"""Matchers that start without initial values; that this is so, and that an unknown bit would be seen."""

import argparse
import json
import re

import pytest

from sim.verify.configurations import Case, CaseFrame, emitted, failure
from sim.verify.initial_values import KEPT, Kept, without_initial_values
from sim.verify.parts import unknowns as part
from sim.verify.parts.unknowns import STANDING, unknown


@pytest.mark.parametrize("name", STANDING)
def test_no_unknown_bit_leaves(name, tmp_path):
    """Nor has the text initial values but of look-up tables."""
    assert unknown(STANDING[name], "icarus", tmp_path) is None
    bare = without_initial_values(emitted(STANDING[name].config))
    assert "initial" not in re.sub(r"(?m)^  initial begin\n(    \w+\[\d+\] = \d+'\w+;\n)+  end\n", "", bare)


@pytest.mark.slow
@pytest.mark.parametrize("name", STANDING)
def test_noise_changes_nothing(name, tmp_path):
    """Slow: compiles each with Verilator; registers without a reset are few in what the test above does not see."""
    assert unknown(STANDING[name], "verilator", tmp_path) is None


# A register or memory that is read before it is written, for a small matcher.
SMALL = Case("thesis", 3, 8, (CaseFrame(8, 3), CaseFrame(4, 2)), engine="sequential")
PLANTED = {
    # The disparities of the line above are never written.
    "memory": lambda text: re.sub(r"result_memory\[\w+\] <= [^;]*;", ";", text),
    # A reset is forgotten: what is valid is unknown until it is set.
    "reset": lambda text: re.sub(r"(?m)^( +)if \(rst\) (o_valid\w*) <= 1'h0;\n +else ", r"\1", text),
}


@pytest.mark.parametrize("fault", PLANTED)
def test_fault_is_seen(fault, tmp_path):
    plant = PLANTED[fault]
    assert plant(emitted(SMALL.config)) != emitted(SMALL.config)
    told = failure(SMALL, "icarus", tmp_path, change=lambda text: without_initial_values(plant(text), KEPT))
    assert re.search("unknown_words|rule_errors|hang", told)


@pytest.mark.parametrize("name", ["thesis", "streaming", pytest.param("recursive", marks=pytest.mark.slow)])
def test_registers_that_keep_their_values_must(name, tmp_path):
    """The list of them is not longer than it need be. Slow: the method that takes longest."""
    assert unknown(STANDING[name], "icarus", tmp_path, kept=False) is not None


def test_initial_values_are_removed():
    text = """\
module matcher_a(clk);
  reg [3:0] x;
  initial x = 4'h3;
  reg y;
  initial y = 1'h1;
  initial begin
    table_[0] = 4'h1;
  end
endmodule
module matcher_b(clk);
  reg [3:0] x;
  initial x = 4'h3;
endmodule
"""
    bare = text.replace("  initial x = 4'h3;\n", "").replace("  initial y = 1'h1;\n", "")
    assert without_initial_values(text) == bare
    kept = without_initial_values(text, [Kept("matcher_b", "x", "because")])
    assert kept.count("initial x") == 1 and kept.index("initial x") > kept.index("matcher_b") and "initial y" not in kept


@pytest.mark.parametrize("fault", [False, True])
def test_command(tmp_path, monkeypatch, capsys, fault):
    """With a stand-in for the run."""
    records = {}
    monkeypatch.setattr(part, "unknown", lambda case, simulator, folder, store: "wrong" if fault and case.seed == 2 else None)
    monkeypatch.setattr(part, "write_record", lambda name, command, figures: records.update({name: (command, figures)}))
    options = argparse.Namespace(cases=1, seeds=2, workers=1, work=tmp_path, restart=False, record=True)
    assert part.PART.run(options) == fault
    told = capsys.readouterr().out
    assert f"{len(STANDING) + 1} matchers without initial values; {(len(STANDING) + 1) * fault} runs" in told
    command, figures = records["unknowns"]
    assert command == "python -m sim.verify unknowns --cases 1 --seeds 2"
    section = "\n".join(part.PART.section(json.loads(json.dumps(figures))))
    assert "| thesis, sequential, linear | 1 |" in section and all(each.reason in section for each in KEPT)
    assert ("wrong" in section) == ("wrong" in told) == fault
    for name, bad in (("cases", -1), ("seeds", 0)):
        with pytest.raises(ValueError, match=f"--{name} must be at least"):
            part.PART.run(argparse.Namespace(**{**vars(options), name: bad}))

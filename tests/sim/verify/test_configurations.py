"""Whole matchers of drawn configurations, those for Icarus; and that the campaign finds faults and makes what fails smaller.

All of them: ``python -m sim.verify configurations``.
"""

import argparse
import itertools
import json
import re

import numpy as np
import pytest

from golden.config import METHODS
from sim.kit.simulators import SIMULATORS
from sim.verify.configurations import ICARUS, Case, CaseFrame, draw, failure, literal, smallest, unreachable, winners
from sim.verify.configurations.drawing import discriminates
from sim.verify.configurations.shrink import smaller
from sim.verify.parts import configurations as part


DRAWN = 240


@pytest.fixture(scope="module")
def cases():
    return [draw(number) for number in range(DRAWN)]


@pytest.mark.parametrize("number", range(ICARUS))
def test_configuration(number, tmp_path):
    assert failure(draw(number), "icarus", tmp_path) is None


def test_draw_is_seeded(cases):
    assert draw(7) == cases[7] != cases[8]
    assert all(case == eval(literal(case)) for case in cases)


def test_draws_cover_what_they_are_drawn_over(cases):
    assert {(case.method, case.engine) for case in cases} >= {("thesis", "sequential"), ("thesis", "streaming")}
    for few in (cases[:ICARUS], cases[ICARUS:]):
        assert {case.method for case in few} == set(METHODS)
    frames = list(itertools.chain.from_iterable(case.frames for case in cases))
    assert {frame.stall_i for frame in frames} == {frame.stall_o for frame in frames} == {0, 0.03, 0.1, 0.5, 0.9}
    assert {frame.scene for frame in frames} == {"bands", "steps", "noise", "even"}
    assert {case.config.method.arithmetic for case in cases if case.engine == "sequential"} == {"thesis", "linear"}
    assert {case.parameters.get("fraction_bits", 3) for case in cases} == {0, 1, 2, 3, 4}
    settings = set().union(*(frame.settings or {} for frame in frames))
    assert settings == set().union(*(case.config.settings for case in cases))
    assert min(case.minimum for case in cases) < -9 and max(case.minimum for case in cases) > 3
    assert min(frame.width for frame in frames) == 1 and max(case.labels for case in cases) > 24
    # Switches of stages, off as built and as set.
    for name in ("check", "fill", "median"):
        assert any(case.parameters.get(name) is False for case in cases)
        assert any((frame.settings or {}).get(name) == 0 for frame in frames)


def test_scenes_discriminate(cases):
    for case in cases[::20]:
        assert all(won >= set(range(case.labels)) - unreachable(case) for won in winners(case).values())
    assert 0.6 < np.mean([not unreachable(case) for case in cases]) < 1


def test_scene_that_does_not_discriminate():
    even, steps = (Case("fused", 4, 20, (CaseFrame(20, 8, scene),), parameters={"reach": 2}) for scene in ("even", "bands"))
    assert not discriminates(even)
    assert discriminates(steps) and not unreachable(steps)
    assert unreachable(Case("thesis", 6, 4, (CaseFrame(4, 2),))) == {4, 5}
    assert unreachable(Case("fused", 6, 4, (CaseFrame(4, 2),), minimum=-4)) == {0}
    assert unreachable(Case("thesis", 6, 9, (CaseFrame(9, 2, settings={"in_use": 2}), CaseFrame(9, 1)))) == {2, 3, 4, 5}


def test_settings_of_a_frame_stay():
    case = Case("thesis", 6, 9, (CaseFrame(9, 2), CaseFrame(9, 2, settings={"u1": 1}), CaseFrame(3, 1), CaseFrame(3, 1, settings={})))
    assert [config.method.weights.u1 for config in case.configs()] == [15, 1, 1, 15]


# A matcher, and a fault in its Verilog.
PLANTED = {
    # A weight that is applied stays what it was.
    "setting": (Case("thesis", 5, 14, (CaseFrame(14, 5, stall_o=0.5), CaseFrame(14, 5, "noise", 5, {"u1": 60, "u2": 3}, 0.1)),
                     engine="streaming", parameters={"arithmetic": "linear"}, in_use=4),
                lambda text: re.sub(r"if \(apply_settings\) (u1\w*) <= u1;", r"if (apply_settings) \1 <= \1;", text)),
    # An input of the minimum trees has the label of another.
    "label": (Case("thesis", 4, 10, (CaseFrame(10, 4, stall_o=0.9), CaseFrame(8, 2)), engine="sequential", parameters={"u2": 20}),
              lambda text: re.sub(r"\{ (\d)'h2, i\[", r"{ \1'h1, i[", text)),
}


@pytest.mark.parametrize("fault", ["label", pytest.param("setting", marks=pytest.mark.slow)])
def test_fault_is_found_and_shrunk(fault, tmp_path):
    """Slow: a second one, for twenty more builds."""
    case, change = PLANTED[fault]

    def told(candidate, fault=change):
        return failure(candidate, "icarus", tmp_path, change=fault)

    assert told(case, str) is None
    assert re.fullmatch(r"frame \d: disparity differs in \d+ of \d+ pixels, first at x \d+, y \d+: \d+, golden \d+", told(case))
    least = smallest(case, lambda candidate: told(candidate) is not None, runs=25)
    assert told(least) is not None and told(least, str) is None
    assert len(least.frames) <= 2 and least.labels <= 3 and len(literal(least)) < len(literal(case))
    assert not any(frame.stall_i or frame.stall_o for frame in least.frames) and least.in_use is None
    assert eval(literal(least)) == least


def test_shrinks_to_what_fails():
    """Without a simulator: a case is reduced to the one thing that fails."""
    case = next(case for case in map(draw, range(40, 200)) if case.method == "fused" and case.config.method.refinement.check)
    assert smallest(case, lambda each: True, runs=1000) == smallest(case, lambda each: True, runs=500)
    least = smallest(case, lambda each: True, runs=1000)
    assert (least.labels, least.max_width, len(least.frames)) == (2, 1, 1)
    assert not least.config.method.refinement.check and least.config.method.arms.reach == 0 and not list(smaller(least))
    kept = smallest(case, lambda each: each.labels >= 3 and any(frame.height > 2 for frame in each.frames), runs=1000)
    assert kept.labels == 3 and [frame.height for frame in kept.frames] == [3]
    assert smallest(case, lambda each: False, runs=1000) == case


def options(folder, **changes):
    return argparse.Namespace(**{"cases": 1, "icarus": 1, "workers": 1, "work": folder, "restart": False, "record": True, **changes})


@pytest.mark.parametrize("fault", [False, True])
def test_command(tmp_path, monkeypatch, capsys, fault):
    """With a stand-in for the run: figures, exit status, what is told, and the section of the report."""
    records = {}
    monkeypatch.setattr(part, "failure", lambda case, simulator, folder, store: "wrong" if fault and simulator == "icarus" else None)
    monkeypatch.setattr(part, "write_record", lambda name, command, figures: records.update({name: (command, figures)}))
    assert part.PART.run(options(tmp_path, cases=3, icarus=2)) == fault
    told = capsys.readouterr().out
    assert "3 configurations on Verilator, 2 on Icarus" in told
    command, figures = records["configurations"]
    assert command == "python -m sim.verify configurations --cases 3 --icarus 2"
    section = "\n".join(part.PART.section(json.loads(json.dumps(figures))))
    assert "3 matchers drawn by a seeded generator on Verilator, 2 of them on Icarus too" in section
    assert [(each["number"], each["simulator"]) for each in figures["faults"]] == [(0, "icarus"), (1, "icarus")] * fault
    for output in (told, section):
        assert ("wrong" in output) == fault
    assert not fault or isinstance(eval(figures["faults"][0]["smallest"]), Case)


@pytest.mark.parametrize("changes, sentence", [
    ({"cases": 0}, "--cases must be at least 1, not 0"), ({"icarus": 41}, "from 0 to 40, not 41")])
def test_bad_numbers(tmp_path, changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        part.PART.run(options(tmp_path, **changes))


def test_both_simulators_are_used():
    assert {simulator for _, _, simulator, _ in part._jobs(options(".")).values()} == set(SIMULATORS)

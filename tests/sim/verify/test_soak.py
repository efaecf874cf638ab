"""The soak: its schedules, its books and its run, and that it finds faults which were planted into the Verilog."""

import json
import re

import numpy as np
import pytest

from golden.host.registers import Kind, Register, RegisterMap, register_map
from sim.benches.system_faults import FAULTS
from sim.benches.system_sizes import SIZES
from sim.models.camera import FAULTS as CAMERA_FAULTS
from sim.models.camera import Camera
from sim.verify.__main__ import main
from sim.verify.parts import soak as part
from sim.verify.soak.ledger import COUNTERS, Ledger
from sim.verify.soak.memory import GROWTH, growth, resident_bytes
from sim.verify.soak.runs import emit, run_seed, soak
from sim.verify.soak.schedule import KINDS, first, schedule, smallest, written


FORMAT = SIZES["least"].camera


def registers(*more):
    found = register_map(SIZES["least"].config, FORMAT.height)
    return RegisterMap((*found, *more))


# Schedules.

def test_schedule():
    """A seed has its schedule, as JSON; all disturbances that there are occur, and all writes of registers that the map has."""
    more = Register("later", 0xE0, Kind.SETTING, 100, "added later"), Register("once", 0xE1, Kind.ACTION, 1, "added later", minimum=1)
    plan = schedule(3, registers(*more), 60, 10)
    assert json.loads(json.dumps(plan)) == plan == schedule(3, registers(*more), 60, 10) != schedule(4, registers(*more), 60, 10)
    drawn = [each for each_round in plan for each in each_round]
    assert {each["kind"] for each in drawn} == {*KINDS}
    assert {each[side][0] for each in drawn for side in ("left", "right") if side in each} == {*CAMERA_FAULTS, "domain reset"}
    others = {each[where] for each in drawn for where in ("memory", "host") if where in each}
    assert others == {name for name in FAULTS if re.search("memory|refresh|host|acknowledge", name)}
    reached = written(plan, registers(*more))
    assert {"later", "once", "in_use", "clear_counters"} <= {*reached} and all(reached.values()) and {*map(tuple, reached.values())} == {
        (True, True)}


def test_written_counts_what_is_legal():
    """Of the frames of `docs/registers.md`: 15 to `u1` is, 64 is not; a wrong sum, and a read, write nothing."""
    found = registers()
    for frames, expected in ((["a5ad10000f8f"], [True, False]), (["a5ad1000405e"], [False, True]), (["a5ad10000f90"], [False, False]),
                             (["a55210000fea"], [False, False])):
        assert written([[{"kind": "writes", "requests": frames}]], found)["u1"] == expected


def test_smallest_schedule():
    """Only what fails together is left, down to one fault of several and one request of several."""
    plan = schedule(5, registers(), 6, 6)
    wanted = [next(each for each_round in plan for each in each_round if test(each)) for test in (
        lambda each: "left" in each and "right" in each, lambda each: each["kind"] == "writes")]
    request, fault = wanted[1]["requests"][1], wanted[0]["left"]
    tries = []

    def fails(less):
        tries.append(less)
        drawn = [each for each_round in less for each in each_round]
        return any(each.get("left") == fault for each in drawn) and any(request in each.get("requests", ()) for each in drawn)

    assert fails(plan)
    left = [each for each_round in smallest(plan, fails, 1000) for each in each_round]
    assert {part for each in left for part in each} - {"kind", "delay"} == {"left", "requests"}
    assert [each["requests"] for each in left if "requests" in each] == [[request]] and len(left) == 2
    tries.clear()
    smallest(plan, fails, 7)
    assert len(tries) == 7


def test_first_disturbances():
    """A round whose accounts are wrong is begun with its first disturbance, and ends with the next round's."""
    plan = [[{"n": 1}, {"n": 2}], [], [{"n": 3}, {"n": 4}]]
    assert [first(plan, count) for count in range(5)] == [
        [[]], [[{"n": 1}]], [[{"n": 1}, {"n": 2}]], [[{"n": 1}, {"n": 2}], [], [{"n": 3}]], plan]


# Books.

def _ledger(*faults):
    camera, picture = Camera(FORMAT, seed=1), np.full((FORMAT.height, FORMAT.width), 90)
    return Ledger(FORMAT, [camera.frame(picture, fault)[0] for fault in faults])


@pytest.mark.parametrize("faults, pairs, counts", [
    ([None] * 5, 5, {}), ([None] * 5, 2, {"unpaired": 2, "skipped": 1}), ([None, "short line", None], 2, {"dropped": 1}),
    ([None, "one-bit errors of all codes"], 2, {"corrected": 2 * FORMAT.frame_lines}),
    (["two-bit error of a code", None], 1, {"dropped": 1, "rejected": 1}), ([None, "clock stopped", None], 2, {"dropped": 1}),
    ([None, "bottom field missing"], 1, {"dropped": 1})])
def test_books_that_balance_and_that_do_not(faults, pairs, counts):
    ledger = _ledger(*faults)
    counts = {**dict.fromkeys(COUNTERS, 0), **counts}
    assert not ledger.errors(pairs, counts)
    ledger.check("left", pairs, list(counts.values()))
    assert ledger.errors(pairs - 1, counts) and ledger.errors(pairs + 1 + counts["skipped"], counts)
    for name in ("corrected", "rejected"):
        assert ledger.errors(pairs, counts | {name: counts[name] + 1})
    if counts["dropped"] and "clock stopped" not in faults:
        assert ledger.errors(pairs + 1, counts | {"dropped": counts["dropped"] - 1})
    with pytest.raises(AssertionError, match=rf"left camera: {pairs - 1 + sum(counts[name] for name in COUNTERS[2:])} pairs, dropped"):
        ledger.check("left", pairs - 1, list(counts.values()))


def test_books_after_a_reset():
    """A frame more or less may have been seen, not two."""
    ledger = _ledger(None, None, None)
    ledger.unsure()
    zero = dict.fromkeys(COUNTERS, 0)
    assert [not ledger.errors(pairs, zero) for pairs in range(1, 6)] == [False, True, True, True, False]
    ledger.begin()
    assert not ledger.errors(0, zero) and ledger.errors(1, zero)


# Memory.

def test_memory():
    """A picture of a camera that is kept each frame is over the bound; what is allocated once is not."""
    rng = np.random.default_rng(1)
    flat = [(frames, 80_000_000 + 4096 * int(rng.integers(8)) + 3_000_000 * (frames > 200)) for frames in range(50, 1000, 50)]
    assert growth(flat) < GROWTH / 2
    assert growth([(frames, resident + frames * FORMAT.frame_bytes) for frames, resident in flat]) > GROWTH
    before = resident_bytes()
    kept = np.ones(8_000_000)
    assert 50_000_000 < resident_bytes() - before < 100_000_000 and kept.all()


# The command.

@pytest.mark.parametrize("arguments, sentence", [
    (["--segments", "0"], "--segments must be at least 1, not 0"), (["--disturbances", "0"], "--disturbances must be at least 1"),
    (["--rounds", "3"], "--rounds must be 0 or at least 8, not 3"), (["--only", "--record"], "choose one of them")])
def test_bad_options(arguments, sentence, tmp_path, capsys):
    assert main(["soak", *arguments, "--work", str(tmp_path)]) == 2
    assert sentence in capsys.readouterr().err and not any(tmp_path.iterdir())


@pytest.mark.parametrize("what, status", [("good", 0), ("failed", 1), ("grows", 1)])
def test_command(tmp_path, monkeypatch, capsys, what, status):
    """The figures of the runs, and the status if one failed or the process grew."""
    keep = FORMAT.frame_bytes if what == "grows" else 0
    asked = {}

    def run(name, cases, options, sources):
        asked.update(cases)
        results = {key: {"recovered": 4, "frames": 30, "shown": 90, "seconds": 9.0,
                         "resident": [[30 * n, 80_000_000 + 30 * n * keep] for n in range(1, 9)]} for key in cases}
        if what == "failed":
            results[next(iter(cases))] = {"failed": "AssertionError: lost", "schedule": [[{"kind": "pause"}]]}
        return results

    monkeypatch.setattr(part, "emit", lambda size, folder: folder / "none.v")
    monkeypatch.setattr(part, "run_campaign", run)
    assert main(["soak", "--segments", "3", "--rounds", "8", "--work", str(tmp_path)]) == status
    told = capsys.readouterr()
    assert len(asked) == 4 and len({case[2] for case in asked.values()}) == 4
    assert ("segment 1: AssertionError: lost\n  smallest schedule: [[{\"kind\": \"pause\"}]]" in told.out) == (what == "failed")
    assert ("grows by 1" in told.err) == (what == "grows")
    assert f"{30 * (3 + (what != 'failed'))} frames of each camera" in told.out


# Runs.

def test_sample(tmp_path):
    """A reset of everything and faults of both cameras, with the model of `test_system.py`'s glance."""
    plan = [[{"kind": "reset", "delay": 20_000_000, "clocks": 300, "init": 20, "in_request": False},
             {"kind": "faults", "delay": 5_000_000, "left": ["short line"], "right": ["one-bit errors of all codes"]}]]
    told = soak(plan, 1, "glance", emit("glance", tmp_path), brief=True)
    assert "failed" not in told, told
    assert told["recovered"] == 2 and told["frames"] > 8 and len(told["resident"]) == 1


#: A line of the Verilog, what becomes of it, the smallest schedule that shows it, and what is told.
PLANTED = {
    "frames without a partner are not counted": (
        r"(left_unpaired_counted <=) unpaired;", r"\1 1'h0;", [{"kind": "faults", "delay": 1, "right": ["short line"]}],
        "pairs, dropped, skipped and unpaired frames, and the bytes have"),
    "a dropped frame is not counted": (
        r"(else if \(_\d+_\) dropped(?:_\d+)?\[0\] <=) .*;", r"\1 1'h0;",
        [{"kind": "faults", "delay": 1, "left": ["short line"]}], "left_dropped has not counted"),
    "a picture that was held is never let go": (
        r"(if \(rst\) hold <= 1'h0;\s*else hold <=) (.*);", r"\1 hold | \2;", [{"kind": "pause", "delay": 1, "hold": True}],
        "the monitor has not shown the pair in 24 frames"),
}


@pytest.fixture(scope="module")
def least(tmp_path_factory):
    """The Verilog of the smallest system."""
    return emit("least", tmp_path_factory.mktemp("least"))


# Slow: a model for each.
@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTED)
def test_planted_fault_is_found(name, least, tmp_path):
    """The schedule of one has more than that, which is dropped again."""
    line, becomes, needed, told = PLANTED[name]
    text, changed = re.subn(line, becomes, least.read_text(), count=1)
    assert changed == 1
    source = tmp_path / "planted.v"
    source.write_text(text)
    if "left" in str(needed):
        found = run_seed([[{"kind": "pause", "delay": 1000, "hold": False}, *needed]], 1, "least", source, brief=True)
        assert found["schedule"] == [needed]
    else:
        found = soak([needed], 1, "least", source, brief=True)
    assert told in found["failed"]

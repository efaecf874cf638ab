"""golden.lab.tune: the search is reproducible, never worse than its start, and the command's file is read by the others."""

import pathlib
from dataclasses import dataclass

import numpy as np
import pytest

from golden.__main__ import main
from golden.config import FUSED_1, FUSED_2, FUSED_3, METHODS, Fused, changed, value_of
from golden.lab import tune
from golden.lab.evaluate import average
from golden.lab.workers import workers
from golden.matcher.matcher import MATCHERS
from golden.matcher.parameters import NAMED, read_parameters, write_parameters
from golden.pictures.dataset import StereoPair
from golden.pictures.images import write_picture
from golden.pictures.scenes import layers


def pair(name, seed=1, width=60, height=30, disparities=8):
    left, right, truth, visible = layers(width, height, disparities, seed)
    return StereoPair(name, left, right, truth.astype(float), {"all": np.ones_like(visible)}, disparities)


@pytest.fixture
def lab():
    for module in ("optuna", "dask"):
        pytest.importorskip(module, reason=f"{module}, of the extra lab, is not installed")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with two small pairs."""
    monkeypatch.chdir(tmp_path)
    for name, seed in (("one", 1), ("two", 2)):
        (tmp_path / name).mkdir()
        this = pair(name, seed)
        write_picture(tmp_path / name / "left.png", this.left)
        write_picture(tmp_path / name / "right.png", this.right)
        write_picture(tmp_path / name / "disp_left.png", (16 * this.truth + (this.truth == 0)).astype(np.uint8))
        (tmp_path / name / "meta.json").write_text('{"scale": 16}')
    return tmp_path


def test_space_is_allowed_and_holds_the_default():
    for method, space in tune.SPACES.items():
        start = next(iter(NAMED[method].values()))
        for name, values in space.items():
            assert value_of(start, name) in values
            assert values[0] in start.LIMITS[name] and values[-1] in start.LIMITS[name]


def rows_of(page):
    """Cells of the table's rows by their first cell."""
    text = (pathlib.Path(__file__).parents[3] / "docs" / page).read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("| ").split("|")] for line in text.splitlines() if line.startswith("|")]
    return {head: cells for head, *cells in rows}


def test_page_of_the_parameter_sets():
    """docs/tuning.md, which is written by hand, has the figures of the pairs that the search does not see."""
    pytest.importorskip("skimage", reason="scikit-image, which carries the Motorcycle pair, is not installed")
    rows = rows_of("tuning.md")
    for place, row in (("motorcycle", "Motorcycle, reduced as the search reads it (not seen)"),
                       ("scenes", "three synthetic scenes with occlusions (not seen)")):
        pairs = tune._pairs([place], "")
        measured = [average({pair.name: tune.objective(pair, params) for pair in pairs}) for params in (FUSED_1, FUSED_2, FUSED_3)]
        assert rows[row] == [f"{value:.2f}" for value in measured]
    full_size = rows["Motorcycle at full size, `python -m golden compare` (not seen)"]
    compared = rows_of("compare.md")
    by_method = dict(zip(compared["scene"], compared["motorcycle 741x500x61"], strict=True))
    assert full_size[:2] == [by_method["`fused-1`"], by_method["`fused-2`"]]


def test_search(lab):
    pairs, names = [pair("one")], ["u1", "reach", "census_columns"]
    poor = changed(FUSED_1, u1=63, reach=4, arm_threshold=9)
    seen = []
    with workers(1) as run:
        first = tune.search(run, pairs, names, 20, 1, poor, lambda *told: seen.append(told))
        assert first == tune.search(run, pairs, names, 20, 1, poor)
        assert tune.search(run, pairs, names, 20, 2, poor) != first
        alone = tune.search(run, pairs, names, 1, 1, poor)
    assert alone == (poor, sum(tune.objective(pairs[0], poor).values()))
    params, least = first
    assert least == sum(tune.objective(pairs[0], params).values()) < alone[1]
    assert changed(params, u1=63, reach=4, census_columns=7) == poor  # nothing else was touched
    assert [done for done, *_ in seen] == [8, 16, 20] and seen[-1][1:] == (least, params)


def test_search_learns(lab, monkeypatch):
    # A bowl instead of the pairs. A search without results reaches 182 in 120 trials, this one 1.
    def bowl(run, pairs, candidates):
        best = {"u1": 40, "u2": 10, "u3": 25, "arm_threshold": 20}
        return [{"bowl": {"all": sum((value_of(p, name) - at)**2 for name, at in best.items())}} for p in candidates]

    monkeypatch.setattr(tune, "_figures", bowl)
    assert tune.search(None, [], ["u1", "u2", "u3", "arm_threshold"], 120, 1)[1] < 25


def test_search_survives_what_cannot_be(lab, monkeypatch):
    # Half of the space is beyond the 8 bits of the cost.
    monkeypatch.setitem(tune.SPACES["fused"], "truncation", range(156, 1024))
    with workers(1) as run:
        params, _ = tune.search(run, [pair("one")], ["truncation"], 16, 1)
    assert params.cost.maximum <= 255


@pytest.mark.parametrize("bits", [3, 5])
def test_cost_bits(lab, bits):
    start = changed(FUSED_1, cost_shift=7, cost_outside=3, truncation=60, cost_factor=2, census_weight=12)
    assert start.cost.maximum.bit_length() == 3
    tried = []
    with workers(1) as run:
        def watched(jobs, put):
            tried.extend(params for _, _, params in jobs)
            return run(jobs, put)

        tune.search(watched, [pair("one")], ["truncation", "census_weight", "cost_outside"], 16, 1, start, cost_bits=bits)
    assert len(tried) == 16  # those that cannot be are not counted
    assert max(params.cost.maximum.bit_length() for params in tried) == bits


def test_nothing_fits(lab, folder, monkeypatch, capsys):
    monkeypatch.setattr(tune, "_suggest", lambda *_: None)
    assert main(["tune", "--train", "one", "--test", "two", "--trials", "8", "--workers", "1", "--output", "b.toml"]) == 2
    assert "none of 400 parameter sets has a cost of 8 bits at most" in capsys.readouterr().err
    assert not (folder / "b.toml").exists()


def test_an_interrupted_search_keeps_its_best(lab, folder, monkeypatch):
    figures, calls = tune._figures, []

    def breaks(*arguments):
        calls.append(read_parameters("a.toml", "fused") if calls else None)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return figures(*arguments)

    monkeypatch.setattr(tune, "_figures", breaks)
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        raise SystemExit(main(["tune", "--train", "one", "--test", "two", "--trials", "24", "--workers", "1", "--output", "a.toml"]))
    assert calls[1] is not None and "of 24 trials" in (folder / "a.toml").read_text()


def test_command(lab, folder, capsys):
    command = ["tune", "--train", "one", "--test", "two", "--trials", "9", "--search", "u1", "u2"]
    assert main([*command, "--workers", "1", "--output", "a.toml"]) == 0
    assert main([*command, "--workers", "2", "--output", "b.toml"]) == 0
    assert (folder / "a.toml").read_bytes() == (folder / "b.toml").read_bytes()  # whatever the number of processes
    printed = capsys.readouterr()
    assert printed.err == ""
    best = read_parameters("a.toml", "fused")
    line = next(line for line in printed.out.splitlines() if "one" in line)
    expected = [f"{average({'one': tune.objective(tune._pairs(['one'], '')[0], params)}):.2f}" for params in (FUSED_1, best)]
    assert line.replace("│", " ").split() == ["train", "one", *expected]
    assert any("test" in line and "two" in line for line in printed.out.splitlines())


def test_further_method(lab, folder, monkeypatch, capsys):
    """A method with rows of its own is searched from its own start, among its own parameters, into a table of its own."""
    @dataclass(frozen=True)
    class Mine(Fused):
        name = "mine"

    for rows, row in ((METHODS, Mine), (NAMED, {"mine-1": changed(Mine(), u1=5)}), (tune.SPACES, {"u1": range(4, 7)})):
        monkeypatch.setitem(rows, "mine", row)
    monkeypatch.setitem(MATCHERS, Mine, MATCHERS[Fused])
    command = ["tune", "--method", "mine", "--train", "one", "--test", "two", "--trials", "3", "--workers", "1", "--output", "a.toml"]
    assert main(command) == 0
    best = read_parameters("a.toml", "mine")
    assert isinstance(best, Mine) and value_of(best, "u1") in range(4, 7) and changed(best, u1=5) == NAMED["mine"]["mine-1"]
    assert "[mine]\n" in (folder / "a.toml").read_text()
    assert main([*command[:-1], "b.toml", "--start", "fused-2"]) == 2
    assert "fused-2 has parameters of the method fused; choose --method fused, or one of mine-1" in capsys.readouterr().err


def test_the_file_is_read(folder, capsys):
    write_parameters("a.toml", changed(FUSED_1, u1=63, u2=1, median_size=3), "worse")
    match = ["match", "one/left.png", "one/right.png", "--disparities", "8", "--method", "fused"]
    outputs = []
    for number, options in enumerate([["--parameters", "a.toml"], ["--parameters", "a.toml", "--u1", "17"], []]):
        assert main([*match, *options, "--output", f"{number}.npy"]) == 0
        outputs.append(np.load(f"{number}.npy"))
    assert (outputs[0] != outputs[1]).any() and (outputs[1] != outputs[2]).any()
    assert main([*match[:-2], "--parameters", "a.toml", "--output", "3.npy"]) == 2
    assert "--parameters a.toml belongs to the method fused" in capsys.readouterr().err


@pytest.mark.parametrize("arguments, message", [
    ([], "required: --train"),
    (["--train", "none"], "the folder none does not exist"),
    (["--train", "one", "one"], "the pair one is given more than once for --train"),
    (["--train", "one", "--test", "."], "the pair one is given for --train and for --test"),
    (["--train", "one", "--trials", "0"], "--trials must be at least 1, not 0"),
    (["--train", "one", "--workers", "0"], "--workers must be at least 1, not 0"),
    (["--train", "one", "--seed", "-1"], "--seed must be at least 0, not -1"),
    (["--train", "one", "--search", "u1", "u4"], "--search u4 is no parameter that is searched of the method fused; choose"),
    (["--train", "one", "--method", "thesis"], "argument --method: invalid choice: 'thesis'"),
    (["--train", "one", "--cost-bits", "9"], "--cost-bits must be 1 to 8, not 9"),
    (["--train", "one", "--cost-bits", "4"], "the cost of the start reaches 138, more than --cost-bits 4 hold"),
    (["--train", "one", "--start", "none.toml"], "cannot read none.toml"),
    (["--train", "one", "--start", "far.toml"], "far.toml has u2 = 0, which is not within the 1 to 63 of the search"),
])
def test_bad_input(folder, capsys, arguments, message):
    write_parameters("far.toml", changed(FUSED_1, u2=0), "far")
    assert main(["tune", *arguments, "--output", "a.toml"]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith("golden tune: ") and message in printed.err
    assert not (folder / "a.toml").exists()

"""golden.lab.evaluate: the published rows, and the command."""

import json
import pathlib
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from golden.config import FUSED_1, FUSED_2, FUSED_3, METHODS, Arithmetic, Fused, MatcherConfig, OnePass, Refinement, changed
from golden.errors import UserError
from golden.lab.evaluate import _rows, average, evaluate, main, parser
from golden.pictures.dataset import PAIRS
from golden.pictures.images import write_picture
from golden.pictures.scenes import layers
from golden.pictures.sets import sets_in, with_noise
from tests.kit import middlebury, only


# nonocc, all, disc of the four pairs, percent; the last is the average of the twelve.
PUBLISHED = {
    "float": "5.17 7.16 18.21  8.83 10.38 26.80  18.78 27.09 31.79  21.26 29.90 32.34  19.81",
    "thesis": "5.11 7.09 17.35  9.82 11.35 25.79  20.41 28.54 32.94  22.96 31.41 33.27  20.50",
    "linear": "5.13 7.12 18.25  8.75 10.30 26.88  18.80 27.11 31.78  21.30 29.93 32.38  19.81",
}


def numbers(figures):
    return [f"{value:.2f}" for pair in figures.values() for value in pair.values()] + [f"{average(figures):.2f}"]


@pytest.mark.parametrize("arithmetic", Arithmetic)
def test_published(arithmetic):
    figures = evaluate(map(middlebury, PAIRS), lambda disparities: MatcherConfig(labels=disparities, method=OnePass(arithmetic)))
    assert list(figures) == ["tsukuba", "venus", "teddy", "cones"]
    assert all(list(pair) == ["nonocc", "all", "disc"] for pair in figures.values())
    assert numbers(figures) == PUBLISHED[arithmetic].split()


# Refinement of the fused cost, threshold in pixels.
ALONE, ALL, FINE = Refinement(check=False, fill=False, median=False), Refinement(), Refinement(sub_pixel=True)
FUSED = [
    (FUSED_1, ALONE, 1, "4.34 5.88 11.42  1.60 2.62 7.72  6.57 14.71 17.03  4.85 13.65 13.49  8.66"),
    (FUSED_1, ALL, 1, "3.17 4.12 9.51  0.78 1.30 5.28  6.14 12.21 15.96  3.55 9.03 10.32  6.78"),
    (FUSED_1, ALL, 0.5, "31.72 32.55 27.88  7.41 8.10 13.74  12.64 19.75 26.62  8.88 14.91 18.44  18.56"),
    (FUSED_1, FINE, 0.5, "28.32 29.22 25.67  2.68 3.35 12.37  9.70 17.33 23.68  5.70 12.18 15.63  15.48"),
    (FUSED_2, ALONE, 1, "3.38 4.80 10.99  0.99 1.71 4.41  6.56 14.29 16.06  4.28 12.32 11.92  7.64"),
    (FUSED_3, ALL, 1, "2.55 3.36 10.73  0.55 0.90 4.11  5.93 11.81 15.22  4.26 9.38 11.95  6.73"),
    (FUSED_2, ALL, 1, "2.57 3.51 9.21  0.48 0.87 3.55  5.92 11.96 14.83  3.10 8.31 8.99  6.11"),
]


@pytest.mark.parametrize("params, refinement, threshold, expected", FUSED)
def test_fused(params, refinement, threshold, expected):
    """*fused-1* as section 7 of the design has it; *fused-2* as measured."""
    method = changed(params, refinement=refinement)
    figures = evaluate(map(middlebury, PAIRS), lambda disparities: MatcherConfig(disparities, method=method), threshold)
    assert numbers(figures) == expected.split()


def test_page_of_the_parameter_sets():
    """docs/tuning.md, which is written by hand, has the averages above."""
    page = (pathlib.Path(__file__).parents[3] / "docs" / "tuning.md").read_text(encoding="utf-8")
    averages = {params: expected.split()[-1] for params, refinement, threshold, expected in FUSED if (refinement, threshold) == (ALL, 1)}
    row = " | ".join(averages[params] for params in (FUSED_1, FUSED_2, FUSED_3))
    assert f"| the four Middlebury pairs, average of twelve (searched on) | {row} |" in page


@pytest.fixture
def quick():
    """The command on one pair: it reads the list of pairs when it runs. Skips without data."""
    with only("tsukuba"):
        yield


def test_command(quick, capsys, tmp_path):
    assert main(["--json", str(tmp_path / "a.json")]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    document = json.loads((tmp_path / "a.json").read_text())
    assert [row["arithmetic"] for row in document["rows"]] == ["float", "thesis", "linear"]
    for row in document["rows"]:
        expected = PUBLISHED[row["arithmetic"]].split()[:3]
        assert [f"{row['pairs']['tsukuba'][mask]:.2f}" for mask in ("nonocc", "all", "disc")] == expected
        assert row["average"] == pytest.approx(sum(row["pairs"]["tsukuba"].values()) / 3)
        line = next(line for line in printed.out.splitlines() if f"│ {row['name']} " in line)
        assert [word for word in line.split() if word[0].isdigit()] == expected
    assert len(list(tmp_path.iterdir())) == 1


def test_options(quick, capsys, tmp_path):
    def row(*options):
        assert main([*options, "--json", str(tmp_path / "a.json")]) == 0
        document = json.loads((tmp_path / "a.json").read_text())
        assert len(document["rows"]) == 1
        return document["rows"][0]["pairs"]["tsukuba"]

    base = row("--arithmetic", "linear")
    for options in (["--fraction-bits", "0"], ["--u1", "3"], ["--u2", "3"], ["--u3", "3"]):
        assert row("--arithmetic", "linear", *options) != base
    document = json.loads((tmp_path / "a.json").read_text())
    assert document["rows"][0]["method_parameters"] == {
        "arithmetic": "linear", "fraction_bits": 3, "weights": {"u1": 15, "u2": 10, "u3": 3}}


@pytest.fixture
def folder(tmp_path):
    """A folder with two sets in either layout."""
    for seed, (name, left, right, truth) in enumerate([("a", "left", "right", "disp_left"), ("b", "view1", "view5", "disp1")]):
        (tmp_path / name).mkdir()
        *pair, labels, _ = layers(60, 40, 8, seed)
        for file, picture in zip((left, right, truth), (*pair, np.uint8(3) * labels.astype(np.uint8))):
            write_picture(tmp_path / name / f"{file}.png", picture)
        (tmp_path / name / "meta.json").write_text('{"scale": 3}')
    return tmp_path


def test_sets(folder, capsys):
    """A folder without the benchmark: one table of its sets, with computed masks."""
    asked = ["--data", str(folder), "--method", "fused", "--refine", "--json", str(folder / "a.json")]
    assert main(asked) == 0
    printed = capsys.readouterr()
    pairs = sets_in(folder)
    expected = evaluate(pairs, lambda disparities: MatcherConfig(disparities, method=FUSED_1))
    row, = json.loads((folder / "a.json").read_text())["rows"]
    assert row["pairs"] == expected and row["average"] == pytest.approx(average(expected)) and printed.err == ""
    lines = [line.replace("│", " ").split() for line in printed.out.splitlines()]
    for name in "ab":
        shown = next(line for line in lines if name in line)
        assert shown[-3:] == [f"{expected[name][mask]:.2f}" for mask in ("nonocc", "all", "disc")]
    assert ["average", "of", "6", f"{average(expected):.2f}"] in lines


def test_noise(folder, capsys):
    def figures(*options):
        assert main(["--data", str(folder), "--arithmetic", "linear", *options, "--json", str(folder / "a.json")]) == 0
        document = json.loads((folder / "a.json").read_text())
        return document["noise"], document["rows"][0]["pairs"]

    without, noisy = figures(), figures("--noise", "20")
    title = " ".join(capsys.readouterr().out.split())  # it is wrapped
    assert without[0] == 0 and noisy[0] == 20 and "noise of 20 grey levels" in title
    assert figures("--noise", "0") == without != noisy == figures("--noise", "20")
    pairs = [with_noise(pair, 20) for pair in sets_in(folder)]
    assert noisy[1] == evaluate(pairs, lambda labels: MatcherConfig(labels, method=OnePass(Arithmetic.LINEAR)))


@pytest.mark.parametrize("arguments, expected", [
    ([], {"unrefined": "4.34 5.88 11.42", "refined": "3.17 4.12 9.51"}),
    (["--refine"], {"refined": "3.17 4.12 9.51"}),
    (["--no-check", "--no-fill", "--no-median"], {"unrefined": "4.34 5.88 11.42"}),
    (["--refine", "--sub-pixel", "--threshold", "0.5"], {"refined": "31.72 32.55 27.88", "refined + sub-pixel": "28.32 29.22 25.67"}),
    (["--no-median"], {"check + fill": None}),
    (["--no-refine", "--median", "--sub-pixel"], {"median": None, "median + sub-pixel": None}),
])
def test_fused_rows(quick, capsys, tmp_path, arguments, expected):
    assert main(["--method", "fused", *arguments, "--json", str(tmp_path / "a.json")]) == 0
    document = json.loads((tmp_path / "a.json").read_text())
    assert document["method"] == "fused"
    for row in document["rows"]:
        told = row["method_parameters"]
        assert (told["weights"], told["energy_shift"]) == ({"u1": 17, "u2": 30, "u3": 22}, 3)
        assert told["refinement"]["sub_pixel"] == ("sub-pixel" in row["name"])
        assert told["refinement"]["median"] == ("refined" in row["name"].split() or "median" in row["name"])
    assert [row["name"] for row in document["rows"]] == list(expected)
    assert {row["arithmetic"] for row in document["rows"]} == {"linear"}
    printed = capsys.readouterr().out
    for row, figures in zip(document["rows"], expected.values()):
        line = next(line for line in printed.splitlines() if f"│ {row['name']} " in line and "tsukuba" in line)
        shown = [f"{value:.2f}" for value in row["pairs"]["tsukuba"].values()]
        assert line.replace("│", " ").split()[-3:] == shown
        assert figures is None or shown == figures.split()
    threshold = arguments[-1] if "--threshold" in arguments else "1"
    assert f"off by more than {threshold} pixel" in document["unit"] and f"off by more than {threshold} pixel" in printed


@pytest.mark.parametrize("words, rows", [("", ["bare"]), ("--sub-pixel --u1 3", ["bare", "bare + sub-pixel"])])
def test_rows_of_a_method_without_switches(monkeypatch, words, rows):
    """They have its name; the options reach it."""
    @dataclass(frozen=True)
    class Bare(Fused):
        name = "bare"
        SWITCHES: ClassVar = {}

    monkeypatch.setitem(METHODS, "bare", Bare)
    found = _rows(parser().parse_args(["--method", "bare", *words.split()]))
    assert list(found) == rows
    expected = changed(Bare(), u1=3) if words else Bare()
    assert [configure(9) for configure in found.values()] == [
        MatcherConfig(9, method=changed(expected, sub_pixel="sub-pixel" in row)) for row in rows]


@pytest.mark.parametrize("arguments, message", [
    (["--method", "fused", "--arithmetic", "float"], "--arithmetic float cannot compute the method fused; choose --arithmetic linear"),
    (["--cost", "fused"], "--cost is now --method; write --method fused"),
    (["--method", "fused", "--u3", "64"], "--u3 must be a whole number from 0 to 63, not 64"),
    (["--no-refine"], "--no-refine belongs to the method fused"),
    (["--threshold", "-1"], "--threshold must be a number of pixels from 0, not -1"),
    (["--threshold", "nan"], "--threshold must be a number of pixels from 0, not nan"),
    (["--threshold", "half"], "half"),
    (["--data", "none"], "the data folder none does not exist"),
    (["--data", "."], "the folder . holds no set; give the benchmark, one with tsukuba, venus, teddy, cones, or a folder of sets"),
    (["--noise", "-1"], "--noise must be a number of grey levels from 0 to 255, not -1"),
    (["--noise", "nan"], "--noise must be a number of grey levels from 0 to 255, not nan"),
    (["--noise", "256"], "--noise must be a number of grey levels from 0 to 255, not 256"),
    (["--json", "a.txt"], "suffix .txt"),
    (["--json", "none/a.json"], "the folder none of a.json does not exist"),
    (["--arithmetic", "decimal"], "decimal"),
    (["--u1", "64"], "--u1 must be a whole number from 0 to 63, not 64"),
    (["--fraction-bits", "9"], "--fraction-bits must be a whole number from 0 to 4, not 9"),
    (["surplus"], "unrecognized arguments: surplus"),
])
def test_bad_input(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, *([] if "--json" in arguments else ["--json", "a.json"])]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("golden evaluate: ") and message in printed.err
    assert printed.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_broken_data_is_not_a_skip(tmp_path, monkeypatch):
    monkeypatch.setenv("STEREO_DATA", str(tmp_path))
    middlebury.cache_clear()
    with pytest.raises(UserError, match=r"left\.png does not exist"):
        middlebury("tsukuba")

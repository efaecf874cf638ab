"""`python -m golden thesis`: both pages from small pairs, its cache, its search, and bad input."""

import contextlib
import dataclasses
import itertools
import json
import re

import numpy as np
import pytest

from golden.__main__ import main
from golden.lab.cache import Cache
from golden.lab.thesis import command, results, sweeps, weights
from golden.lab.thesis.choices import Choice
from golden.lab.thesis.laboratory import Laboratory
from golden.lab.workers import workers
from golden.matcher.labelling import match
from golden.pictures.dataset import MASKS, PAIRS, load_pair
from golden.pictures.images import write_picture
from golden.pictures.scenes import layers

from .inputs import RESOURCES, RIVALS


for package in ("dask", "jinja2"):
    pytest.importorskip(package, reason=f"{package}, of the extra lab, is not installed")


TITLES = ["Table 1", "Tsukuba", "Table 2", "Table 3", "Figure 34", "Figure 35", "Figure 36", "Figure 37", "Figure 38", "Figure 42",
          "Figure 45", "Figure 46"]


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Four small pairs laid out as the benchmark's."""
    folder = tmp_path_factory.mktemp("data")
    for seed, (name, (disparities, scale)) in enumerate(PAIRS.items()):
        (folder / name).mkdir()
        left, right, truth, visible = layers(30, 20, min(disparities, 8), seed)
        for side, levels in (("left", left), ("right", right)):
            colours = np.stack([levels, levels // 2, 255 - levels], axis=-1)
            write_picture(folder / name / f"{side}.png", colours)
        write_picture(folder / name / "disp_left.png", (scale * np.maximum(truth, 1)).astype(np.uint8))
        edge = np.zeros_like(visible)
        edge[:, 10:20] = True
        for mask, counted in zip(MASKS, (visible, np.ones_like(visible), visible & edge), strict=True):
            write_picture(folder / name / f"{mask}.png", np.where(counted, 255, 0).astype(np.uint8))
    return folder


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder, and fewer weights, gains and lenses than the command takes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(weights, "SEARCHED", (0, 15))
    monkeypatch.setattr(weights, "EQUAL", (0, 15, 63))
    monkeypatch.setattr(results.choices, "all_choices", lambda: iter([Choice(), Choice(numbers="thesis"), Choice(border="zero")]))
    return tmp_path


def thesis(data, *arguments):
    return main(["thesis", "--data", str(data), "--workers", "1", "--output", "out", *arguments])


def test_pages(data, folder, capsys, monkeypatch):
    sgm = RIVALS["methods"]["sgm"]
    (folder / "rivals.json").write_text(json.dumps({"methods": RIVALS["methods"] | {"one-pass-linear": sgm, "one-pass-expansion": sgm}}))
    (folder / "resources.md").write_text(RESOURCES)
    assert thesis(data, "--rivals", "rivals.json", "--resources", "resources.md") == 0
    printed = capsys.readouterr()
    assert printed.err == "" and "12 sections, 11 pictures" in printed.out
    page, text = ((folder / "out" / f"thesis.{suffix}").read_text() for suffix in ("html", "md"))
    assert [line[3:].partition(":")[0] for line in text.splitlines() if line.startswith("## ")] == TITLES
    pictures = re.findall(r"\]\((thesis/.*?)\)", text)
    assert len(pictures) == len(set(pictures)) == 11 and page.count("data:image/png;base64,") == 11
    for name in pictures:
        assert (folder / "out" / name).read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in (folder / "out" / "thesis").iterdir()) == sorted(name.partition("/")[2] for name in pictures)
    # Ours, the thesis's and a rival's in table 1.
    pair = load_pair(data, "tsukuba")
    bad = sweeps.bad(match(pair.left, pair.right, sweeps.method_config("float", 16)), pair)
    ours = [f"{value:.2f}" for value in bad]
    apart = [f"{value - theirs:+.2f}" for value, theirs in zip(bad, (5.09, 7.08, 18.2), strict=True)]
    assert f"| one pass, float | 5.09 | 7.08 | 18.20 | {' | '.join([*ours, *apart])} | 0.04 FPGA |" in text
    assert "| scan | 4.12 | 5.04 | 12.00 | 4.00 | 5.50 | 12.00 | -0.12 | +0.46 | +0.00 | 1 CPU | 1.00 |" in text
    assert "| sgm | - | - | - | 3.00 | 4.00 | 9.00 | - | - | - | - | 0.10 |" in text
    assert "| one-pass-expansion | - |" in text and "one-pass-linear" not in text  # which is measured here
    assert "| Graph Cut Method | 1.19 | 2.01 | 6.24 | - |" in text and "| Dynamic Programming |" not in text
    assert "| logic elements | 119,088 | 66,123 | 9,000 | 60,123 | 90,000 |" in text
    assert "15/10/5, the thesis's: rank" in text

    # A second run computes nothing and writes the same bytes.
    monkeypatch.setattr(command, "workers", lambda count, scheduler: nothing())
    assert thesis(data, "--rivals", "rivals.json", "--resources", "resources.md") == 0
    assert (folder / "out" / "thesis.html").read_text() == page


@contextlib.contextmanager
def nothing():
    """Workers that refuse to compute."""
    yield lambda jobs, done: pytest.fail(f"{len(jobs)} jobs")


@pytest.fixture
def lab(data, tmp_path):
    pairs = {name: load_pair(data, name) for name in PAIRS}
    with workers(1) as run:
        yield Laboratory(pairs, (pairs["tsukuba"].left, pairs["tsukuba"].right), run, Cache(tmp_path / "cache", "1"))


def test_the_search_finds_the_least(lab, monkeypatch):
    monkeypatch.setattr(weights, "SEARCHED", (0, 10, 40))
    average = weights._best(lab, ["tsukuba"])
    assert list(average)[:27] == list(itertools.product((0, 10, 40), repeat=3)) and len(average) > 50 and (15, 10, 5) in average
    best = min(average, key=average.get)
    for at in (*list(average)[::9], best):
        assert average[at] == pytest.approx(sweeps.labels_of(lab.tsukuba, "float", at)["bad"].mean())
    # Nothing beside the best is untried.
    assert set(itertools.product(*([u for u in (middle - 1, middle, middle + 1) if 0 <= u <= 63] for middle in best))) <= set(average)


def test_the_thesis_s_optimum_is_ranked(lab, monkeypatch):
    """Where all other weights are worse it is the optimum, and the page says so."""
    def figures(pair, method, sets):
        return {"bad": np.array([[float(each != (15, 10, 5))] * 3 for each in sets]), "extended": np.zeros(len(sets))}

    monkeypatch.setattr(weights, "SEARCHED", (0, 15))
    monkeypatch.setattr(sweeps, "weight_figures", figures)
    section = weights.figure_37(lab)
    assert section.paragraphs[1].endswith("So 15/10/5 is the optimum of what was tried.") and "rank 1 of" in section.paragraphs[1]

    monkeypatch.setattr(sweeps, "weight_figures", lambda pair, method, sets: {
        "bad": np.array([[float(sum(each))] * 3 for each in sets]), "extended": np.zeros(len(sets))})
    section = weights.figure_37(dataclasses.replace(lab, cache=Cache(lab.cache.folder, "2")))
    assert section.paragraphs[1].endswith("is near the optimum but not it.") and "0/0/0 gives 0.00 %" in section.paragraphs[1]


@pytest.mark.parametrize("arguments, message", [
    (["--workers", "0"], "--workers must be at least 1, not 0"),
    (["--scheduler", "nonsense://x"], "no Dask scheduler answers at nonsense://x"),
    (["--rivals", "none.json"], "cannot read none.json"),
    (["--resources", "none.md"], "cannot read none.md"),
    (["--output", "file/out"], "the folder file/out cannot be written"),
    (["--data", "none"], "the data folder none does not exist"),
])
def test_bad_input(data, folder, capsys, arguments, message):
    (folder / "file").touch()
    assert thesis(data, *arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and message in printed.err and printed.err.startswith("golden thesis: ") and printed.err.count("\n") == 1
    assert not list(folder.rglob("thesis.*"))

"""`python -m golden thesis`: both pages from small pairs, its cache, its search, and bad input."""

import contextlib
import dataclasses
import itertools
import re

import numpy as np
import pytest

from golden.__main__ import main
from golden.lab.cache import Cache
from golden.lab.rivals import cuts, scanline
from golden.lab.rivals.registry import measure
from golden.lab.thesis import command, plots, results, specimen, sweeps, tables, weights
from golden.lab.thesis.choices import Choice
from golden.lab.thesis.laboratory import Laboratory
from golden.lab.thesis.page import Table
from golden.lab.workers import workers
from golden.matcher.labelling import match
from golden.pages import read_origin
from golden.pictures.dataset import MASKS, PAIRS, load_pair
from golden.pictures.images import write_picture

from .inputs import RESOURCES


for package in ("dask", "jinja2", "cv2", "maxflow"):
    pytest.importorskip(package, reason=f"{package}, of the extra lab, is not installed")


TITLES = ["Table 1", "Tsukuba", "Table 2", "Table 3", "Figure 34", "Figure 35", "Figure 36", "Figure 37", "Figure 38", "Figure 42",
          "Figure 45", "Figure 46"]


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Four small pairs laid out as the benchmark's."""
    folder = tmp_path_factory.mktemp("data")
    for name, pair in specimen.specimens().items():
        (folder / name).mkdir()
        for side, levels in (("left", pair.left), ("right", pair.right)):
            write_picture(folder / name / f"{side}.png", np.stack([levels, levels // 2, 255 - levels], axis=-1))
        write_picture(folder / name / "disp_left.png", (16 * np.maximum(pair.truth, 1)).astype(np.uint8))
        for mask in MASKS:
            write_picture(folder / name / f"{mask}.png", np.where(pair.masks[mask], 255, 0).astype(np.uint8))
    return folder


@pytest.fixture(autouse=True)
def few_labels(monkeypatch):
    """The benchmark's numbers of disparities and scales become those of the small pairs."""
    for name in PAIRS:
        monkeypatch.setitem(PAIRS, name, (8, 16))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with a page of resources, and fewer weights and choices than the command takes."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "resources.md").write_text(RESOURCES)
    monkeypatch.setattr(weights, "SEARCHED", (0, 15))
    monkeypatch.setattr(weights, "EQUAL", (0, 15, 63))
    monkeypatch.setattr(results.choices, "all_choices", lambda: iter([Choice(), Choice(numbers="thesis"), Choice(border="zero")]))
    return tmp_path


def thesis(data, *arguments):
    return main(["thesis", "--data", str(data), "--workers", "1", "--output", "out", *arguments])


def test_pages(data, folder, capsys, monkeypatch):
    assert thesis(data) == 0
    printed = capsys.readouterr()
    assert printed.err == "" and "12 sections, 12 pictures" in printed.out and "left out" not in printed.out
    page, text = ((folder / "out" / f"thesis.{suffix}").read_text() for suffix in ("html", "md"))
    assert [line[3:].partition(":")[0] for line in text.splitlines() if line.startswith("## ")] == TITLES
    pictures = re.findall(r"\]\((thesis/.*?)\)", text)
    assert len(pictures) == len(set(pictures)) == 12 and page.count("data:image/png;base64,") == 12
    for name in pictures:
        assert (folder / "out" / name).read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in (folder / "out" / "thesis").iterdir()) == sorted(name.partition("/")[2] for name in pictures)
    # Ours, the thesis's and the rivals' in table 1.
    pair = load_pair(data, "tsukuba")
    bad = sweeps.bad(match(pair.left, pair.right, sweeps.method_config("float", 8)), pair)
    ours = [f"{value:.2f}" for value in bad]
    apart = [f"{value - theirs:+.2f}" for value, theirs in zip(bad, (5.09, 7.08, 18.2), strict=True)]
    assert f"| one pass, float | 5.09 | 7.08 | 18.20 | {' | '.join([*ours, *apart])} | 0.04 FPGA |" in text
    scan = sweeps.bad(scanline.disparities(pair.left, pair.right, 8), pair)
    assert f"| dynamic-programming | 4.12 | 5.04 | 12.00 | {' | '.join(f'{value:.2f}' for value in scan)} | " in text
    assert text.count("\n| opencv-sgbm | - |") == 1 and "\n| one-pass-linear |" not in text  # which is ours
    assert "\n| alpha-beta-swap | 1.19 | 2.01 | 6.24 |" in text and "\n| Graph Cut Method |" not in text
    wide = next(line for line in text.splitlines() if line.startswith("| alpha-expansion |") and line.count("|") == 15)
    figures = [float(cell) for cell in wide.split("|")[2:-1]]
    assert figures[-1] == pytest.approx(sum(figures[:-1]) / 12, abs=0.01)
    assert "| logic elements | 119,088 | 66,123 | 9,000 | 60,123 | 90,000 |" in text
    assert "15/10/5, the thesis's: rank" in text and "Left out" not in text
    assert read_origin(text) == read_origin(page) and read_origin(text)[0] == "python -m golden thesis"

    # A second run computes nothing and writes the same text. Pictures of the same numbers are the same, see test_page.
    monkeypatch.setattr(command, "workers", lambda count, scheduler: nothing())
    monkeypatch.setattr(plots, "_png", lambda figure: b"")
    monkeypatch.setattr(specimen, "inputs", lambda *_: read_origin(text)[1])
    assert thesis(data) == 0
    assert (folder / "out" / "thesis.md").read_text() == text


def test_quick_names_what_it_leaves_out(data, folder, capsys, monkeypatch):
    seen = []
    monkeypatch.setattr(command, "check_installed", lambda *names: seen.extend(names))
    monkeypatch.setattr(cuts, "alpha_expansion", lambda *_: pytest.fail("a graph cut"))
    monkeypatch.setattr(sweeps, "choice_figures", lambda *_: pytest.fail("a reading"))
    monkeypatch.setattr(weights, "_best", lambda *_: pytest.fail("a search"))
    monkeypatch.setattr(plots, "_png", lambda figure: b"")
    (folder / "docs" / "resources.md").unlink()
    assert thesis(data, "--quick") == 0
    assert "maxflow" not in seen and "cv2" in seen
    text = (folder / "out" / "thesis.md").read_text()
    assert read_origin(text)[0] == "python -m golden thesis --quick"
    assert [line[3:].partition(":")[0] for line in text.splitlines() if line.startswith("## ")] == TITLES
    left_out = re.findall(r"Left out by `--quick`: (.*)\.", text)
    assert left_out == [
        "alpha-expansion, graph cuts by expansions, Potts; alpha-beta-swap, graph cuts by swaps, Potts; "
        "one-pass-expansion, expansions that minimise the energy of one-pass-linear",
        "the 3 readings of what the thesis leaves open", "the resources of our engines", "the rates of our engines",
        "the search for the best weights"]
    assert "| Graph Cut Method | 1.19 |" in text and "\n| alpha-expansion |" not in text and "\n| opencv-bm |" in text
    printed = capsys.readouterr().out.splitlines()
    assert printed[1:] == [f"left out of {title}: {names}" for title, names in
                           zip(("Table 1", "Tsukuba", "Table 2", "Table 3", "Figure 37"), left_out, strict=True)]


def test_digest_is_of_the_inputs(folder, monkeypatch):
    def found(quick=True, pictures="1", resources=None):
        def sections(lab):
            return [tables.table_1(lab), tables.table_2(resources), weights.figure_34(lab), results.tsukuba(lab)]

        return specimen.inputs(sections, {"left.png": pictures}, quick)

    first = found()
    others = [found(pictures="2"), found(quick=False), found(resources={2: Table(["thesis"], [["1"]])})]
    for module, name, value in ((weights, "EQUAL", (0, 15, 62)), (results, "TSUKUBA", {"nonocc": 5.08, "all": 7.08, "disc": 18.2}),
                                (scanline.disparities, "__defaults__", (50,)), (specimen, "source_digest", lambda files: "other plots")):
        with monkeypatch.context() as context:
            context.setattr(module, name, value)
            others.append(found())
    assert len({first, *others}) == 1 + len(others)
    assert found() == first


def test_the_digest_does_not_depend_on_the_machine():
    found = {}
    pair = specimen.specimens()["venus"]
    specimen._timeless([(sweeps.labels_of, pair, "float"), (measure, pair, "dynamic-programming")], found.__setitem__)
    assert [result["seconds"] for result in found.values()] == [0, 0] and found[0]["labels"].any() and found[1]["bad"].any()


@contextlib.contextmanager
def nothing():
    """Workers that refuse to compute."""
    yield lambda jobs, done: pytest.fail(f"{len(jobs)} jobs")


@pytest.fixture
def lab(data, tmp_path):
    pairs = {name: load_pair(data, name) for name in PAIRS}
    with workers(1) as run:
        yield Laboratory(pairs, (pairs["tsukuba"].left, pairs["tsukuba"].right), run, Cache(tmp_path / "cache"))


def test_the_search_finds_the_least(lab, monkeypatch):
    monkeypatch.setattr(weights, "SEARCHED", (0, 10, 40))
    average = weights._best(lab, ["tsukuba"])
    assert list(average)[:27] == list(itertools.product((0, 10, 40), repeat=3)) and len(average) > 50 and (15, 10, 5) in average
    best = min(average, key=average.get)
    for at in (*list(average)[::9], best):
        assert average[at] == pytest.approx(sweeps.labels_of(lab.tsukuba, "float", at)["bad"].mean())
    # No neighbour of the best is untried.
    assert set(itertools.product(*([u for u in (middle - 1, middle, middle + 1) if 0 <= u <= 63] for middle in best))) <= set(average)


def test_the_thesis_s_optimum_is_ranked(lab, monkeypatch):
    """Where all other weights are worse it is the optimum, and the page says so."""
    def figures(pair, method, sets):
        return {"bad": np.array([[float(each != (15, 10, 5))] * 3 for each in sets]), "extended": np.zeros(len(sets))}

    monkeypatch.setattr(weights, "SEARCHED", (0, 15))
    monkeypatch.setattr(sweeps, "weight_figures", figures)
    lab = dataclasses.replace(lab, cache=None)
    section = weights.figure_37(lab)
    assert section.paragraphs[1].endswith("So 15/10/5 is the optimum of what was tried.") and "rank 1 of" in section.paragraphs[1]

    monkeypatch.setattr(sweeps, "weight_figures", lambda pair, method, sets: {
        "bad": np.array([[float(sum(each))] * 3 for each in sets]), "extended": np.zeros(len(sets))})
    section = weights.figure_37(lab)
    assert section.paragraphs[1].endswith("is near the optimum but not it.") and "0/0/0 gives 0.00 %" in section.paragraphs[1]


@pytest.mark.parametrize("arguments, message", [
    (["--workers", "0"], "--workers must be at least 1, not 0"),
    (["--scheduler", "nonsense://x"], "no Dask scheduler answers at nonsense://x"),
    (["--cache", "file/cache"], "the folder file/cache cannot be written"),
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

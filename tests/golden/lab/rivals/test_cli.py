"""`python -m golden rivals` and `golden gaps`: figures, files, bad input."""

import itertools
import json

import numpy as np
import pytest

from golden.__main__ import main
from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.lab.evaluate import evaluate
from golden.lab.rivals import gaps, registry
from golden.lab.rivals.registry import METHODS, measure
from golden.pictures.dataset import MASKS, PAIRS, load_pair
from golden.pictures.images import read_picture, write_picture
from golden.pictures.scenes import layers
from golden.pictures.sets import sets_in


FREE = ["one-pass-linear", "dynamic-programming"]  # need no package of the extra


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A working folder with small pictures in place of the benchmark's."""
    monkeypatch.chdir(tmp_path)
    for seed, name in enumerate(("tsukuba", "venus")):
        (tmp_path / name).mkdir()
        labels, scale = PAIRS[name]
        left, right, truth, visible = layers(50, 30, labels, seed)
        edges = np.zeros(left.shape, bool)
        edges[:, 10:20] = True
        for file, picture in (("left", left), ("right", right), ("disp_left", (scale * truth + (truth == 0)).astype(np.uint8)),
                              *((mask, np.uint8(255) * on) for mask, on in zip(MASKS, (visible, np.ones_like(edges), edges)))):
            write_picture(tmp_path / name / f"{file}.png", picture)
        (tmp_path / name / "meta.json").write_text(json.dumps({"scale": scale, "disp_range": [0, labels - 1]}))
    return tmp_path


def needs(*modules):
    for module in modules:
        pytest.importorskip(module, reason=f"{module}, of the extra lab, is not installed")


RIVALS = ["rivals", "--data", ".", "--pairs", "tsukuba", "venus", "--methods", *FREE, "--output", "a.json"]


def stripped(document):
    """A document without its times."""
    for row in document["methods"].values():
        assert row.pop("seconds") == pytest.approx(sum(one["seconds"] for one in row["pairs"].values()))
        assert all(one.pop("seconds") > 0 for one in row["pairs"].values())
    return document


def test_rivals(folder, capsys):
    needs("dask")
    assert main([*RIVALS, "--workers", "1"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    document = stripped(json.loads((folder / "a.json").read_text()))
    rows = document["methods"]
    assert list(rows) == FREE
    pairs = [load_pair(".", name) for name in ("tsukuba", "venus")]
    expected = evaluate(pairs, lambda disparities: MatcherConfig(labels=disparities, method=OnePass(Arithmetic.LINEAR)))
    assert {pair: one["figures"] for pair, one in rows["one-pass-linear"]["pairs"].items()} == expected
    mean = np.mean([list(row.values()) for row in expected.values()])
    assert list(rows["one-pass-linear"]["averages"].values()) == [pytest.approx(mean)]
    # Printed figures are separate from measured ones, in another part and in other columns.
    assert rows["dynamic-programming"]["published"] == "Dynamic Programming" and "published" not in rows["one-pass-linear"]
    assert document["published"]["rows"]["Graph Cut Method"] == {"nonocc": 1.19, "all": 2.01, "disc": 6.24, "tool": "CPU", "seconds": 69.8}
    lines = [line.split() for line in printed.out.splitlines()]
    figures = {(line[0], above[0]): line[1:] for above, line in itertools.pairwise(lines) if line and line[0] == "tsukuba"}
    assert figures["tsukuba", "one-pass-linear"][:3] == [f"{expected['tsukuba'][mask]:.2f}" for mask in MASKS]
    assert len(figures["tsukuba", "one-pass-linear"]) == 4
    assert figures["tsukuba", "dynamic-programming"][4:] == ["4.12/5.04/12", "1"]
    assert printed.out.count("4.12/") == 1  # next to the printed pair only
    assert max(map(len, printed.out.splitlines())) <= 80


def test_processes_change_nothing(folder, capsys):
    needs("dask")
    documents = []
    for workers in ("1", "2"):
        assert main([*RIVALS, "--workers", workers, "--cache", f"kept-{workers}"]) == 0
        documents.append(stripped(json.loads((folder / "a.json").read_text())))
    assert documents[0] == documents[1]


def test_results_are_kept(folder, capsys, monkeypatch):
    needs("dask")
    asked = [*RIVALS, "--workers", "1"]
    assert main(asked) == 0
    first, document = capsys.readouterr().out, (folder / "a.json").read_text()
    assert len(list((folder / "build" / "rivals").iterdir())) == 2 * len(FREE)
    measured = []
    monkeypatch.setattr(registry, "bad_pixels", lambda *arguments: measured.append(arguments) or 50.0)
    assert main(asked) == 0
    assert capsys.readouterr().out == first and (folder / "a.json").read_text() == document and not measured
    picture = read_picture(folder / "venus" / "left.png")
    picture[0, 0] ^= 1
    write_picture(folder / "venus" / "left.png", picture)
    assert main(asked) == 0
    assert len(measured) == len(FREE) * len(MASKS)  # venus only


def test_folders_side_by_side(folder, capsys):
    needs("dask")
    (folder / "first").mkdir()
    (folder / "tsukuba").rename(folder / "first" / "tsukuba")
    (folder / "second").mkdir()
    (folder / "venus").rename(folder / "second" / "venus")
    left, right, truth, _ = layers(50, 30, 8, 5)
    (folder / "second" / "other").mkdir()
    for name, picture in (("view1", left), ("view5", right), ("disp1", (2 * truth).astype(np.uint8))):
        write_picture(folder / "second" / "other" / f"{name}.png", picture)
    (folder / "second" / "other" / "meta.json").write_text('{"scale": 2}')
    asked = ["rivals", "--data", "second", "first", "--methods", *FREE, "--workers", "1", "--output", "a.json"]
    assert main(asked) == 0
    printed = capsys.readouterr()
    lines = [line.split() for line in printed.out.splitlines()]
    rows = json.loads((folder / "a.json").read_text())["methods"]
    second, first = ([pair.name for pair in sets_in(place)] for place in ("second", "first"))
    assert (second, first) == (["other", "venus"], ["tsukuba"])
    start = lines.index(["method", "6", "figures", "3", "figures", "seconds"])
    for name, row in rows.items():
        assert list(row["pairs"]) == ["other", "venus", "tsukuba"]
        means = [np.mean([list(row["pairs"][pair]["figures"].values()) for pair in pairs]) for pairs in (second, first)]
        assert list(row["averages"].items()) == [("second", pytest.approx(means[0])), ("first", pytest.approx(means[1]))]
        shown = next(line for line in lines[start:] if line[:1] == [name])
        assert shown == [name, f"{means[0]:.2f}", f"{means[1]:.2f}", f"{row['seconds']:.2f}"]
    assert sum(line[:3] == ["average", "of", "6"] for line in lines) == len(FREE)


@pytest.mark.filterwarnings("default")  # of Tornado and asyncio
def test_a_cluster_changes_nothing(folder):
    needs("dask", "distributed")
    from distributed import LocalCluster
    assert main([*RIVALS, "--workers", "1"]) == 0
    here = stripped(json.loads((folder / "a.json").read_text()))
    with LocalCluster(n_workers=1, threads_per_worker=2, processes=False, protocol="tcp", dashboard_address=None) as cluster:
        assert main([*RIVALS, "--scheduler", cluster.scheduler_address, "--cache", "other"]) == 0
    assert stripped(json.loads((folder / "a.json").read_text())) == here


def test_every_task_advances_the_bar(monkeypatch):
    needs("dask")
    advanced = []
    monkeypatch.setattr("rich.progress.Progress.advance", lambda bar, task: advanced.append(task))
    assert main([*RIVALS, "--workers", "1"]) == 0
    assert len(advanced) == 2 * len(FREE)


def test_energies_are_shown(folder, capsys):
    needs("dask", "maxflow")
    assert main(["rivals", "--data", ".", "--pairs", "venus", "--methods", "one-pass-linear", "one-pass-expansion", "--workers", "1",
                 "--output", "a.json"]) == 0
    rows = json.loads((folder / "a.json").read_text())["methods"]
    before, after = (rows[name]["pairs"]["venus"]["energy"] for name in ("one-pass-linear", "one-pass-expansion"))
    assert after < before
    percent = 100 * (before - after) / before
    sentence = f"venus: expansions lower the energy of the one-pass labels from {before} to {after}, by {percent:.2f} %"
    assert sentence in capsys.readouterr().out


def test_only_those_that_lower_it_have_an_energy():
    pair = load_pair(".", "venus")
    assert "energy" not in measure(pair, "ssd-min-filter") and "energy" in measure(pair, "one-pass-linear")


def test_seconds_are_those_of_the_method(monkeypatch):
    clock = iter([5.0, 7.5])
    monkeypatch.setattr(registry.time, "thread_time", lambda: next(clock))
    assert measure(load_pair(".", "venus"), "one-pass-linear")["seconds"] == 2.5


def test_gaps(folder, capsys, monkeypatch):
    needs("maxflow", "ortools")
    clock = itertools.count(0, 0.25)
    monkeypatch.setattr(gaps.time, "thread_time", lambda: next(clock))
    assert main(["gaps", "--data", ".", "--pairs", "venus", "tsukuba", "--every", "7", "--output", "a.png", "--json", "a.json"]) == 0
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")
    rows = json.loads((folder / "a.json").read_text())["pairs"]
    assert list(rows) == ["venus", "tsukuba"]
    rule, least = (np.array(rows["venus"][name]) for name in ("rule", "least"))
    assert len(rule) == 5 and (rule >= least).all()
    percents = 100 * (rule / least - 1)
    rows_of = [line.replace("│", " ").split() for line in capsys.readouterr().out.splitlines()]
    distribution = [line for line in rows_of if line[:1] == ["gap,"]]
    expected = [*np.percentile(percents, (0, 10, 25, 50, 75, 90, 100)), percents.mean()]
    assert [line[-4] for line in distribution] == [f"{value:.2f}" for value in expected]  # the column before the last; "%" is a word
    assert ["lines", "5", "5"] in rows_of
    assert ["augmenting", "paths,", "ms", "a", "line,", "median", "250.00", "250.00"] in rows_of
    assert ["push-relabel,", "ms", "a", "line,", "median", "250.00", "250.00"] in rows_of
    assert next(line for line in rows_of if "optimal" in line)[-2] == str((rule == least).sum())


BAD = [
    ("rivals", ["--methods", "none"], "none"),
    ("rivals", ["--methods", *FREE, FREE[0]], "--methods names one-pass-linear more than once"),
    ("rivals", ["--pairs", "venus", "venus"], "--pairs names venus more than once"),
    ("rivals", ["--pairs", "motorcycle"], "motorcycle"),
    ("rivals", ["--workers", "0", "--methods", *FREE, "--pairs", "venus"], "--workers must be at least 1, not 0"),
    ("rivals", ["--output", "a.txt"], "a.txt has the suffix .txt"),
    ("rivals", ["--data", "none", "--methods", *FREE], "the data folder none does not exist"),
    ("rivals", ["--methods", *FREE, "--pairs", "cones"], ". holds no set cones; those there are tsukuba, venus"),
    ("rivals", ["--methods", *FREE, "--data", ".", "."], "--data names two folders "),
    ("rivals", ["--methods", *FREE, "--data", ".", "tsukuba"], "the set tsukuba is in tsukuba and in another folder of --data"),
    ("rivals", ["--methods", *FREE, "--data", ".", "venus", "--pairs", "venus"], "--pairs venus chooses in one folder, but --data names 2"),
    ("rivals", ["--methods", *FREE, "--cache", "venus/left.png"], "--cache"),
    ("gaps", ["--pairs", "cones"], ". holds no set cones; those there are tsukuba, venus"),
    ("gaps", ["--every", "0"], "--every must be at least 1, not 0"),
    ("gaps", ["--pairs", "venus", "venus"], "--pairs names venus more than once"),
    ("gaps", ["--output", "a.json"], "a.json has the suffix .json"),
    ("gaps", ["--json", "a.png"], "choose one of these for --json"),
    ("gaps", ["--data", "none"], "the data folder none does not exist"),
]


@pytest.mark.parametrize("command, arguments, message", BAD)
def test_bad_input(folder, capsys, command, arguments, message):
    needs("dask", "maxflow", "ortools")
    assert main([command, "--data", ".", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith(f"golden {command}: ") and message in printed.err
    assert not list(folder.glob("a.*")) and not (folder / "build").exists()


def test_no_cluster(capsys, folder):
    needs("dask", "distributed")
    assert main([*RIVALS, "--scheduler", "nonsense://"]) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("golden rivals: no Dask scheduler answers at nonsense://") and printed.err.count("\n") == 1
    assert not (folder / "a.json").exists()


@pytest.mark.parametrize("arguments", [["rivals", "--methods", "alpha-expansion"], ["rivals", "--methods", "opencv-bm"], ["gaps"]])
def test_package_missing(monkeypatch, capsys, arguments):
    monkeypatch.setattr("golden.lab.workers.importlib.util.find_spec", lambda name: None)
    assert main([*arguments, "--data", "."]) == 2
    assert capsys.readouterr().err.endswith("is not installed; install the extra lab of this package\n")


def test_help_names_all(capsys):
    with pytest.raises(SystemExit):
        main(["rivals", "--help"])
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert all([name, *method.about.split()] in lines for name, method in METHODS.items())

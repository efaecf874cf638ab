"""golden.lab.thesis.tables and .resources: the page of the resources is read, or written first; sections show it."""

import sys

import pytest

from golden.errors import UserError
from golden.lab.published import TABLE_1, TABLE_2, TABLE_3
from golden.lab.thesis import resources
from golden.lab.thesis.resources import find_resources, read_resources
from golden.lab.thesis.tables import table_2, table_3
from golden.pictures.dataset import MASKS

from .inputs import RESOURCES


def test_published_is_what_the_thesis_prints():
    assert {name: (*row.figures.values(), row.seconds) for name, row in TABLE_1.items()} == {
        "Dynamic Programming": (4.12, 5.04, 12.0, 1.0), "Graph Cut Method": (1.19, 2.01, 6.24, 69.8),
        "SSD+min filter": (5.08, 7.22, 24.1, 1.1), "Proposed Method": (5.09, 7.08, 18.2, 0.04)}
    assert all(tuple(row.figures) == MASKS for row in TABLE_1.values())
    assert len(TABLE_3) == 5 and TABLE_2["logic elements"] == (66_123, 119_088)


def test_resources(tmp_path):
    file = tmp_path / "resources.md"
    file.write_text(RESOURCES)
    found = read_resources(file)
    assert found[2].head[0] == "EP3C120" and found[2].rows[1] == ["DSP", "576", "-", "1", "2", "3"]
    assert (found[3].head, found[3].rows) == (["hardware", "frames/s"], [["Virtex", "60"]])
    section = table_2(found)
    assert section.tables == [found[2]]
    assert "logic elements -6,000 (sequential); logic elements +23,877 (streaming)." in section.paragraphs[0]
    assert "DSP" not in section.paragraphs[0]
    assert table_3(found).tables == [found[3]] and "No clock rate of ours is in the page" in table_3(found).paragraphs[0]
    found[3].rows.append(["ours, streaming", "200"])
    assert "a stand-in" in table_3(found).paragraphs[0]


def test_without_resources():
    assert table_2(None).tables[0].rows[0] == ["logic elements", "119,088", "66,123"]
    assert table_3(None).tables[0].rows[-1] == ["Cyclone III, the thesis", "720x576", "80", "modified graph cut", "25"]
    assert table_2(None).left_out == ["the resources of our engines"] and table_3(None).left_out == ["the rates of our engines"]


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """A working folder without a kept page, and the commands that were started there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cache").mkdir()
    started = []

    def run(command, **options):
        started.append(command)
        path = command[command.index("--output") + 1]
        (tmp_path / path).write_text(RESOURCES)
        return 0

    monkeypatch.setattr(resources, "run_program", run)
    monkeypatch.setattr(resources, "source_digest", lambda files: f"{len(list(files)):064}")
    return started


def test_resources_are_counted_once(counted, tmp_path, monkeypatch):
    cache = tmp_path / "cache"
    assert find_resources(cache, quick=True) is None and not counted
    first = find_resources(cache, quick=False)
    assert [command[:3] for command in counted] == [[sys.executable, "-m", "hdl.resources.tables"]]
    assert find_resources(cache, quick=False) == find_resources(cache, quick=True) == first and len(counted) == 1
    # Other gateware is counted anew.
    monkeypatch.setattr(resources, "source_digest", lambda files: "f" * 64)
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "clock.json").touch()
    find_resources(cache, quick=False)
    assert len(counted) == 2 and "--clock" not in counted[0] and counted[1][-2:] == ["--clock", "docs/clock.json"]


def test_the_kept_page_is_read(counted, tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "resources.md").write_text(RESOURCES.replace("9,000", "8,000"))
    assert find_resources(tmp_path / "cache", quick=False)[2].rows[0][3] == "8,000" and not counted


def test_a_count_that_fails(counted, tmp_path, monkeypatch):
    monkeypatch.setattr(resources, "run_program", lambda command, **options: 2)
    with pytest.raises(UserError, match=r"hdl\.resources\.tables ended with status 2; .*--resources, .*--quick"):
        find_resources(tmp_path / "cache", quick=False)

    def run(command, stderr, **options):
        stderr.write(b"note: x\nhdl.resources.tables: that is wrong; correct it\n")
        return 2

    monkeypatch.setattr(resources, "run_program", run)      # its sentence is part of ours: there is one
    with pytest.raises(UserError, match=r"ended with status 2 \(hdl\.resources\.tables: that is wrong; correct it\); "):
        find_resources(tmp_path / "cache", quick=False)


def test_without_the_gateware(counted, tmp_path, monkeypatch):
    monkeypatch.setattr(resources.importlib.util, "find_spec", lambda name: None)
    assert find_resources(tmp_path / "cache", quick=True) is None
    with pytest.raises(UserError, match="the package hdl, which counts the resources, is not installed"):
        find_resources(tmp_path / "cache", quick=False)


@pytest.mark.parametrize("old, new", [
    ("## Table 2:", "## Table 4:"), ("| Virtex | 60 |\n", ""), ("| Virtex | 60 |", "| Virtex |"), ("## Table 3:", "# Table 3:")])
def test_bad_resources(tmp_path, old, new):
    file = tmp_path / "resources.md"
    assert old in RESOURCES
    file.write_text(RESOURCES.replace(old, new))
    with pytest.raises(UserError, match=r"resources.md holds no table under '## Table"):
        read_resources(file)
    with pytest.raises(UserError, match=r"cannot read .*none.md"):
        read_resources(tmp_path / "none.md")

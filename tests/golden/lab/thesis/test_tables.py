"""golden.lab.thesis.tables: what other commands wrote is read, and nothing else."""

import copy
import json

import pytest

from golden.errors import UserError
from golden.lab.published import TABLE_1, TABLE_2, TABLE_3
from golden.lab.thesis.tables import read_resources, read_rivals, table_2, table_3
from golden.pictures.dataset import MASKS

from .inputs import RESOURCES, RIVALS


def test_published_is_what_the_thesis_prints():
    assert {name: (*row.figures.values(), row.seconds) for name, row in TABLE_1.items()} == {
        "Dynamic Programming": (4.12, 5.04, 12.0, 1.0), "Graph Cut Method": (1.19, 2.01, 6.24, 69.8),
        "SSD+min filter": (5.08, 7.22, 24.1, 1.1), "Proposed Method": (5.09, 7.08, 18.2, 0.04)}
    assert all(tuple(row.figures) == MASKS for row in TABLE_1.values())
    assert len(TABLE_3) == 5 and TABLE_2["logic elements"] == (66_123, 119_088)


def test_rivals(tmp_path):
    file = tmp_path / "rivals.json"
    file.write_text(json.dumps(RIVALS))
    rivals = read_rivals(file)
    assert list(rivals) == ["scan", "sgm"] and rivals["sgm"]["published"] is None and rivals["scan"]["published"] == "Dynamic Programming"
    assert rivals["sgm"]["pairs"]["tsukuba"] == {"figures": {"nonocc": 3.0, "all": 4.0, "disc": 9.0}, "seconds": 0.1}


@pytest.mark.parametrize("change", [
    lambda document: document.pop("methods"), lambda document: document.update(methods=[1]), lambda document: document.update(methods={}),
    lambda document: document["methods"]["sgm"].pop("about"), lambda document: document["methods"]["sgm"].update(pairs=3),
    lambda document: document["methods"]["sgm"]["pairs"]["tsukuba"]["figures"].pop("disc"),
    lambda document: document["methods"]["sgm"]["pairs"]["tsukuba"].update(seconds="long"),
])
def test_bad_rivals(tmp_path, change):
    document = copy.deepcopy(RIVALS)
    change(document)
    file = tmp_path / "rivals.json"
    file.write_text(json.dumps(document))
    with pytest.raises(UserError, match=r"rivals.json .*golden rivals --output"):
        read_rivals(file)


@pytest.mark.parametrize("content", ["", "no JSON", "[]", "\udcff"])
def test_rivals_that_are_no_document(tmp_path, content):
    file = tmp_path / "rivals.json"
    file.write_bytes(content.encode("utf-8", "surrogateescape"))
    with pytest.raises(UserError, match="is not what"):
        read_rivals(file)
    with pytest.raises(UserError, match="cannot read"):
        read_rivals(tmp_path / "none.json")


def test_resources(tmp_path):
    file = tmp_path / "resources.md"
    file.write_text(RESOURCES)
    resources = read_resources(file)
    assert resources[2].head[0] == "EP3C120" and resources[2].rows[1] == ["DSP", "576", "-", "1", "2", "3"]
    assert (resources[3].head, resources[3].rows) == (["hardware", "frames/s"], [["Virtex", "60"]])
    section = table_2(resources)
    assert section.tables == [resources[2]]
    assert "logic elements -6,000 (sequential); logic elements +23,877 (streaming)." in section.paragraphs[0]
    assert "DSP" not in section.paragraphs[0]
    assert table_3(resources).tables == [resources[3]]


def test_without_resources():
    assert table_2(None).tables[0].rows[0] == ["logic elements", "119,088", "66,123", "not given"]
    assert table_3(None).tables[0].rows[-1] == ["Cyclone III, the thesis", "720x576", "80", "modified graph cut", "25"]
    assert "python -m hdl.resources.tables" in table_2(None).paragraphs[0]


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

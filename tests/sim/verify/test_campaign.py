"""What all parts of the verification share: journal, campaign, records and the report."""

import argparse
import json

import pytest

from golden.errors import UserError
from sim.verify import campaign, report
from sim.verify.__main__ import main, parts_of_verification
from sim.verify.campaign import Part, digest_of_sources, run_campaign, write_record
from sim.verify.journal import Journal


def options(folder, *, restart=False, workers=1):
    return argparse.Namespace(workers=workers, work=folder, restart=restart, record=False)


def square(x, computed):
    """A job that leaves a trace, so that a test sees whether it was computed."""
    (computed / str(x)).touch()
    return x * x


@pytest.mark.parametrize("workers", [1, 2])
def test_campaign_keeps_results_and_goes_on(tmp_path, workers):
    computed = tmp_path / "computed"
    computed.mkdir()
    cases = {str(x): (square, x, computed) for x in (3, 1, 2)}
    assert run_campaign("squares", {"3": cases["3"]}, options(tmp_path, workers=workers), "a") == {"3": 9}
    (computed / "3").unlink()
    assert [*run_campaign("squares", cases, options(tmp_path, workers=workers), "a").items()] == [("3", 9), ("1", 1), ("2", 4)]
    assert sorted(path.name for path in computed.iterdir()) == ["1", "2"]
    run_campaign("squares", cases, options(tmp_path, restart=True), "a")
    assert (computed / "3").exists()


def test_campaign_refuses_no_workers(tmp_path):
    with pytest.raises(UserError, match="--workers must be at least 1, not 0"):
        run_campaign("squares", {}, options(tmp_path, workers=0), "a")


def test_journal_of_a_killed_run(tmp_path):
    path = tmp_path / "folder" / "run.jsonl"
    with Journal(path, "a") as journal:
        journal.add("first", [1, None])
    whole = path.read_bytes()
    path.write_bytes(whole + b'{"case": "sec')
    with Journal(path, "a") as journal:
        assert journal.results == {"first": [1, None]}
        journal.add("third", 3)
    assert path.read_bytes() == whole + b'{"case": "third", "result": 3}\n'


@pytest.mark.parametrize(("contents", "sentence"), [
    (b'{"sources": "b"}\n', "has results of other sources"),
    (b"junk\n", "no journal"), (b"[]\n", "no journal"), (b'{"sources": "a"}\n{"x": 1}\n', "no journal")])
def test_journal_refuses_what_is_not_its_own(tmp_path, contents, sentence):
    path = tmp_path / "run.jsonl"
    path.write_bytes(contents)
    with pytest.raises(UserError, match=sentence):
        Journal(path, "a")
    assert path.read_bytes() == contents
    with Journal(path, "a", restart=True) as journal:
        assert journal.results == {}


def test_journal_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match="choose another folder with --work"):
        Journal(tmp_path / "file" / "run.jsonl", "a")


def test_digest_of_sources():
    assert digest_of_sources("golden/config") != digest_of_sources("golden/host")
    with pytest.raises(ValueError, match="no sources in nowhere"):
        digest_of_sources("nowhere")


def test_report(tmp_path, monkeypatch):
    for module in (campaign, report):
        monkeypatch.setattr(module, "ROOT", tmp_path)
        monkeypatch.setattr(module, "RECORDS", tmp_path / "records")
    part = Part("toys", "toys that are counted", lambda parser: None, lambda options: 0, lambda record: [f"{record['count']} toys."])
    with pytest.raises(UserError, match=r"records/toys\.json does not exist; write it with python -m sim\.verify toys --record"):
        report.page([part])
    write_record("toys", "count toys", {"count": 3})
    assert json.loads((tmp_path / "records" / "toys.json").read_text()) == {"command": "count toys", "commit": "", "count": 3}
    text = report.page([part])
    assert "## Toys\n\nToys that are counted: `count toys`.\n\n3 toys.\n" in text
    write_record("toys", "count toys", {"count": 4})
    assert report.page([part]) != text


def test_page_is_what_the_figures_say():
    parts = parts_of_verification()
    assert parts
    assert report.PAGE.read_text(encoding="utf-8") == report.page(parts)


def test_command_names_its_parts(capsys):
    assert main(["nothing"]) == 2
    told = capsys.readouterr().err
    assert all(part.name in told for part in parts_of_verification()) and len(told.splitlines()) == 1

"""hdl.resources.tables: what was measured before is checked before anything is counted."""

import json

import pytest

from hdl.resources import tables


CLOCK = {"engine": "streaming", "width": 16, "height": 8, "disparities": 4, "clock_mhz": 100.0, "clock_device": "x"}


@pytest.mark.parametrize("change", [
    {"engine": "other"}, {"width": 0}, {"width": "16"}, {"height": None}, {"disparities": 1000}, {"clock_mhz": "fast"}, {"clock_device": 1},
    {"clock_mhz": ...}, None])
def test_clock_file_is_refused_before_the_count(tmp_path, monkeypatch, capsys, change):
    monkeypatch.setattr(tables, "_counts", lambda bar: pytest.fail("counted"))
    document = {name: value for name, value in {**CLOCK, **(change or {})}.items() if value is not ...}
    (tmp_path / "clock.json").write_text(json.dumps(document) if change else "[" * 100_000)
    assert tables.main(["--clock", str(tmp_path / "clock.json"), "--output", str(tmp_path / "page.md")]) == 2
    told = capsys.readouterr().err
    assert "is not what `python -m hdl.resources --clock --json" in told and "; run that command" in told


def test_clock_file_is_read(tmp_path):
    (tmp_path / "clock.json").write_text(json.dumps({**CLOCK, "more": 1}))
    assert tables._read_clock(tmp_path / "clock.json") == CLOCK

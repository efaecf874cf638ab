"""`python -m golden.lab.pairing_bench`."""

import pytest

from golden.lab import pairing_bench


def rows(printed):
    """Cells of a table's rows, by the first one."""
    table = [[cell.strip() for cell in line.strip("│").split("│")] for line in printed.splitlines() if line.startswith("│")]
    return {name: cells for name, *cells in table}


def test_figures(capsys):
    """72 seconds hold 1800 frames; of the camera that starts later one less, and the last picture is not shown yet."""
    assert pairing_bench.main(["--hours", "0.02", "--ppm", "0", "2000", "--start", "0.5"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "0.02 hours, 2 buffers, pairs read in 5.6 ms" in printed.out and "window 25.000 ms" in printed.out
    table = rows(printed.out)
    assert table["0"] == ["1799", "1799", "1798", "20.000", "58.464", "40.000", "0, 0", "0, 0"]
    assert table["2000"][0] == table["2000"][1] == "1795" and table["2000"][6:] == ["0, 0", "4, 0"]
    assert table["0.375"] == ["15.00", "0, 0", "0", "0, 0", "0"]
    assert table["0.420"] == ["16.80", "1, 0", "0", "0, 0", "0"]
    assert table["0.600"][3:] == ["0, 0", "0"] and int(table["0.600"][2]) > 100


def test_buffers_by_the_reading_time(capsys):
    assert pairing_bench.main(["--hours", "0.001", "--ppm", "0", "--read-ms", "33.2", "--display", "1024x768", "--clock-mhz", "100"]) == 0
    assert "0.001 hours, 3 buffers, pairs read in 33.2 ms" in capsys.readouterr().out


def test_broken_promise(monkeypatch):
    monkeypatch.setattr(pairing_bench, "violations", lambda trace: ["pair 7: torn"])
    with pytest.raises(AssertionError, match=r"^pair 7: torn$"):
        pairing_bench.main(["--hours", "0.001"])


@pytest.mark.parametrize("arguments, message", [
    ("--hours 0", "--hours must be from 0.001 to 100, not 0"),
    ("--hours nan", "not nan"),
    ("--ppm 0 20000", "--ppm must be from -10000 to 10000, not 20000"),
    ("--start -1", "--start must be from 0 to 1000, not -1"),
    ("--read-ms 40", "less than the frame period of 40 ms, not in 40 ms"),
    ("--buffers 1", "at least 2 buffers for each picture, not 1"),
    ("--clock-mhz 0", "--clock-mhz must be"),
    ("--hours 0.001 --start 90", "--hours 0.001 is too short for two pairs"),
    ("--display 640x480", "640x480"),
])
def test_bad_input(capsys, arguments, message):
    assert pairing_bench.main(arguments.split()) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith("golden.lab.pairing_bench: ") and message in printed.err

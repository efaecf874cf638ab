"""`python -m golden.lab.bench`."""

import pytest

from golden.config import MatcherConfig
from golden.lab import bench


def test_figures(capsys, monkeypatch):
    # Fast 2 s, plain 3 s on 2 rows of 8: 12 s on all, a ratio of 6.
    def timed(function, left, right, config):
        rows, columns = left.shape
        assert (columns, rows) == {"match": (16, 8), "match_plain": (16, 2)}[function.__name__]
        return (2.0, 1.5) if function.__name__ == "match" else (3.0, 3.0)

    monkeypatch.setattr(bench, "timed", timed)
    assert bench.main(["--width", "16", "--height", "8", "--disparities", "4", "--plain-rows", "2"]) == 0
    printed = capsys.readouterr()
    for arithmetic in ("float", "thesis", "linear"):
        line = next(line for line in printed.out.splitlines() if arithmetic in line)
        assert line.replace("│", " ").split() == [arithmetic, "2.00", "1.50", "12", "6"]
    assert "single-threaded NumPy" in printed.out and "measured on 2 of 8 rows" in printed.out
    assert printed.err == ""


def test_runs(capsys):
    assert bench.main(["--width", "9", "--height", "3", "--disparities", "4", "--arithmetic", "linear"]) == 0
    printed = capsys.readouterr().out
    assert "measured on 3 of 3 rows" in printed and "thesis" not in printed


@pytest.mark.parametrize("arguments, message", [
    ("--disparities 1000", f"--disparities must be a whole number from 2 to {MatcherConfig.LABELS[-1]}, not 1000"),
    ("--width 5000", "5000x576"),
    ("--height 0", "720x0"),
    ("--plain-rows 0", "--plain-rows must be at least 1, not 0"),
    ("--arithmetic decimal", "decimal"),
])
def test_bad_input(capsys, arguments, message):
    assert bench.main(arguments.split()) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    assert printed.err.startswith("golden.lab.bench: ") and message in printed.err

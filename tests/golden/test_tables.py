"""golden.tables: figures are whole in terminals of any width, and every command prints its tables that way."""

import re
from pathlib import Path

import pytest
from rich.table import Table

from golden.tables import print_table


ROOT = Path(__file__).resolve().parents[2]
FIGURES = ["1,318,220,337", "9.26 %", "(12.50 / 8.01)", "-"]
WORDS = ["mismatching pixels against golden", "Bögen", "a_name_without_any_blank_in_it", ""]


def table(right, left, no_wrap):
    result = Table(title="Bad pixels: off by more than 1 pixel, percent", caption="a caption that is longer than a narrow terminal")
    for number in range(left):
        result.add_column(f"long heading {number}", no_wrap=no_wrap)
    for number in range(right):
        result.add_column(f"figure {number}\nin units", justify="right")
    for row, (word, figure) in enumerate(zip(WORDS, FIGURES)):
        result.add_row(*([word] * left), *(f"{row}{number}:{figure}" for number in range(right)))
    return result


@pytest.mark.parametrize("columns", [1, 20, 40, 80, 300])
@pytest.mark.parametrize("right, left, no_wrap", [(1, 1, False), (2, 1, False), (6, 2, False), (3, 1, True), (0, 2, False), (4, 0, False)])
def test_nothing_is_cut(monkeypatch, capsys, columns, right, left, no_wrap):
    monkeypatch.setenv("COLUMNS", str(columns))
    print_table(table(right, left, no_wrap))
    out = capsys.readouterr().out
    assert "…" not in out
    for row, figure in enumerate(FIGURES):
        for number in range(right):
            assert re.search(rf"(?m)^.*[│┃] +{re.escape(f'{row}{number}:{figure}')} [│┃]", out)
    assert all(part in out for word in WORDS for part in word.split() if left)
    assert len({len(line) for line in out.splitlines() if line[:1] in "│┃┏┡└"}) == 1


def test_as_wide_as_the_terminal_at_most_if_that_will_do(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "55")
    print_table(table(1, 1, False))
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 55 < len(WORDS[0]) + len(FIGURES[0]) + 12


@pytest.mark.parametrize("package", ["golden", "hdl", "sim", "boards"])
def test_tables_are_printed_here_only(package):
    """Rich's console is for progress on stderr elsewhere, and for the live table of registers."""
    other = re.compile(r"(?<!Live\(table\(\), console=)Console\((?!stderr)")
    found = [str(path.relative_to(ROOT)) for path in (ROOT / package).rglob("*.py") if other.search(path.read_text(encoding="utf-8"))]
    assert {*found} <= {"golden/tables.py"}

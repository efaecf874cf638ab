"""golden.lab.thesis.disturbances: columns and curves of the cures hold what is measured, and the page tells of Tsukuba what is so."""

import pathlib

import pytest

from golden.lab.thesis import disturbances, specimen, sweeps
from golden.lab.thesis.laboratory import Laboratory
from tests.kit import middlebury


WORDS = disturbances.METHODS.values()


@pytest.fixture
def lab(monkeypatch):
    """Small pairs, and few gains, noises and lenses."""
    for name, values in (("GAINS", (1.0, 0.7)), ("NOISES", (0.0, 8.0)), ("LENSES", (-0.1, 0.05, 0.1))):
        monkeypatch.setattr(disturbances, name, values)
    pairs = specimen.specimens()
    tsukuba = pairs["tsukuba"]

    def run(jobs, done):
        for number, (function, *arguments) in enumerate(jobs):
            done(number, function(*arguments))

    return Laboratory(pairs, (tsukuba.left, tsukuba.right), run, None)


def shown(section, monkeypatch):
    """Cells of the section's table by row and column, and what its last picture draws: curves by title, and which are dashed."""
    (table,) = section.tables
    drawn = []
    monkeypatch.setattr(disturbances, "curves", lambda graphs, *_, dashed, **__: drawn.append((dict(graphs), dashed)) or b"png")
    assert section.pictures[-1].png == b"png"
    return [dict(zip(table.head, row, strict=True)) for row in table.rows], *drawn[0]


def test_figure_45(lab, monkeypatch):
    section = disturbances.figure_45(lab)
    rows, graphs, dashed = shown(section, monkeypatch)
    assert [(row["gain"], row["noise"]) for row in rows] == [("1", "0"), ("0.7", "0"), ("1", "8"), ("0.95", "2")]
    assert dashed == {f"{word}, balanced": word for word in WORDS}
    for method, word in disturbances.METHODS.items():
        seen, cured = ([sweeps.disturbed(lab.tsukuba, method, *setting, flag) for setting in ((1.0, 0.0), (0.7, 0.0), (1.0, 8.0))]
                       for flag in (False, True))
        for row, before, after in zip(rows, seen, cured):
            assert [row[f"{word}, {figure}"] for figure in ("all", "flicker", "all, balanced", "flicker, balanced")] == [
                f"{value:.2f}" for value in (before["bad"][1], before["flicker"], after["bad"][1], after["flicker"])]
        for title, places, at in (("all, against the gain", (1.0, 0.7), [0, 1]),
                                  ("all, against the noise, grey levels", (0.0, 8.0), [0, 2])):
            for name, found in ((word, seen), (f"{word}, balanced", cured)):
                assert graphs[title][name] == (places, [found[number]["bad"][1] for number in at])
        for before, after in zip(seen[1:], cured[1:]):
            assert f"from {before['bad'][1]:.2f} to {after['bad'][1]:.2f} % ({word})" in section.paragraphs[1]
    assert [*graphs["all, against the gain"]] == [name for word in WORDS for name in (word, f"{word}, balanced")]


def test_figure_46(lab, monkeypatch):
    section = disturbances.figure_46(lab)
    rows, graphs, dashed = shown(section, monkeypatch)
    assert [row["k"] for row in rows] == ["-0.1", "0.05", "0.1"] and dashed == {f"{word}, rectified": word for word in WORDS}
    for method, word in disturbances.METHODS.items():
        found = [sweeps.lens_figures(lab.tsukuba, method, k) for k in disturbances.LENSES]
        for row, result in zip(rows, found):
            assert [row[f"{word}, all{cure}"] for cure in ("", ", rectified", ", straightened")] == [
                f"{result[name][1]:.2f}" for name in ("bad", "rectified", "straight")]
            assert f"from {result['bad'][1]:.2f} to {result['rectified'][1]:.2f} % ({word})" in section.paragraphs[1]
        for name, figure in ((word, "bad"), (f"{word}, rectified", "rectified")):
            assert graphs["all, against the lens"][name] == (disturbances.LENSES, [result[figure][1] for result in found])


def page_rows(figure, keys):
    """The table of a figure in docs/thesis.md, as numbers by column, by the values of its first columns."""
    page = (pathlib.Path(__file__).parents[4] / "docs" / "thesis.md").read_text(encoding="utf-8")
    lines = [line for line in page.partition(f"## Figure {figure}:")[2].partition("\n## ")[0].splitlines() if line.startswith("|")]
    head, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")] for line in lines)
    return {tuple(map(float, row[:keys])): dict(zip(head, map(float, row), strict=True)) for row in rows}


def test_the_page_s_words_are_so():
    """What the paragraphs say of the cures, by the figures of the page."""
    intensity, lens = page_rows(45, 2), page_rows(46, 1)
    for word in WORDS:
        every, cured = f"{word}, all", f"{word}, all, balanced"
        still = intensity[1, 0][every]
        for gain in disturbances.GAINS:
            assert abs(intensity[gain, 0][cured] - still) < 0.5
        assert intensity[0.7, 0][every] > still + 3
        for noise in disturbances.NOISES[1:]:
            assert abs(intensity[1, noise][cured] - intensity[1, noise][every]) < 0.4
        cured = f"{word}, all, rectified"
        for k in (-0.1, 0.1):
            assert lens[0,][every] < lens[k,][cured] < lens[k,][every]
            assert abs(lens[k,][cured] - lens[k,][f"{word}, all, straightened"]) < 0.5
        assert lens[-0.05,][every] < lens[-0.05,][cured]


def test_the_page_shows_tsukuba():
    """Two of the cured cells, measured again."""
    pair = middlebury("tsukuba")
    balanced = sweeps.disturbed(pair, "float", 0.7, 0.0, True)["bad"][1]
    assert page_rows(45, 2)[0.7, 0]["thesis's method, all, balanced"] == round(balanced, 2)
    assert page_rows(46, 1)[0.1,]["thesis's method, all, rectified"] == round(sweeps.lens_figures(pair, "float", 0.1)["rectified"][1], 2)

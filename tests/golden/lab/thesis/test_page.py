"""golden.lab.thesis.page and .plots: pages that hold what they are given, and pictures that show it."""

import base64
import html.parser
import io
import re

import numpy as np
import pytest
from PIL import Image

from golden.lab.thesis.page import Picture, Section, Table, markdown
from golden.lab.thesis.page import html as html_page
from golden.lab.thesis.plots import curves, heat, panels


pytest.importorskip("jinja2", reason="jinja2, of the extra lab, is not installed")


def picture(png):
    with Image.open(io.BytesIO(png)) as opened:
        return np.asarray(opened.convert("RGB"))


SECTIONS = [
    Section("One & only", ["5 < 6, and `a<b`."], [Table(["what", "why", "n|m"], [["a", "b|c", "1.00"], ["<i>", "d", "-2"]], words=2)]),
    Section("Two", [], [], [Picture("dots", "Black & white.", lambda: b"\x89PNG no picture")]),
]


class Reader(html.parser.HTMLParser):
    """Collects texts, links and pictures; complains of tags that do not match."""
    def __init__(self):
        super().__init__()
        self.open, self.texts, self.sources, self.links, self.ids = [], [], [], [], []

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.sources += [attrs["src"]] if tag == "img" else []
        self.links += [attrs["href"]] if tag == "a" else []
        self.ids += [attrs["id"]] if "id" in attrs else []
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data.strip())


def test_html():
    reader = Reader()
    reader.feed(html_page("Title <1>", "Before.", SECTIONS))
    assert not reader.open
    for text in ("Title <1>", "Before.", "One & only", "5 < 6, and", "a<b", "b|c", "<i>", "-2", "Two", "Black & white."):
        assert text in reader.texts
    kind, _, data = reader.sources[0].partition(",")
    assert kind == "data:image/png;base64" and base64.b64decode(data) == SECTIONS[1].pictures[0].png and len(reader.sources) == 1
    assert [f"#{each}" for each in reader.ids] == reader.links == ["#s1", "#s2"]


def test_html_aligns_words_and_numbers():
    page = html_page("t", "f", SECTIONS)
    assert page.count("<td class=word>") == 4 and page.count("<td>") == 2 and page.count("<th class=word>") == 2


def test_one_column_is_words_by_default():
    section = Section("t", [], [Table(["pair", "n", "m"], [["a", "1", "2"]])])
    assert "| --- | ---: | ---: |" in markdown("t", "f", [section], "p") and html_page("t", "f", [section]).count("<td class=word>") == 1


def test_markdown():
    text = markdown("Title", "Before.", SECTIONS, "pics")
    assert text == """\
# Title

Before.

## One & only

5 < 6, and `a<b`.

| what | why | n\\|m |
| --- | --- | ---: |
| a | b\\|c | 1.00 |
| <i> | d | -2 |

## Two

![Black & white.](pics/dots.png)

*Black & white.*
"""


def test_pictures_are_drawn_once_and_only_for_the_files():
    drawn = []
    dots = Picture("dots", "Dots.", lambda: drawn.append(1) or b"png")
    markdown("t", "f", [Section("s", pictures=[dots])], "p")
    assert not drawn and dots.png == dots.png == b"png" and len(drawn) == 1


def test_what_is_left_out_is_named():
    section = Section("s", ["Words."], left_out=["one", "two"])
    assert "Words.\n\nLeft out by `--quick`: one; two.\n" in markdown("t", "f", [section], "p")
    assert "<p>Left out by <code>--quick</code>: one; two.</p>" in html_page("t", "f", [section])


def test_panels():
    disparity = np.array([[0.0, 7.0], [np.inf, 7.0]]).repeat(10, 0).repeat(15, 1)
    grey = np.full((20, 30), 250, np.uint8)
    red = np.zeros((20, 30, 3), np.uint8) + np.array([200, 20, 20], np.uint8)
    shown = picture(panels([("a", disparity, 7), ("b", grey, None), ("c", red, None)], 2))
    height, width = shown.shape[:2]

    def share(colour, part):
        return (np.abs(shown[part].astype(int) - colour) < 8).all(axis=-1).mean()

    upper_left, upper_right, lower_left, lower_right = (
        np.s_[y:y + height // 2, x:x + width // 2] for y in (0, height // 2) for x in (0, width // 2))
    assert share((253, 231, 36), upper_left) > 0.3  # the greatest of viridis
    assert share((68, 1, 84), upper_left) > 0.1 and share((0, 0, 0), upper_left) > 0.1
    assert share((250, 250, 250), upper_right) > 0.5
    assert share((200, 20, 20), lower_left) > 0.5
    assert share((255, 255, 255), lower_right) == 1


def test_curves_and_heat():
    graph = ("t", {"one": ([0, 1, 2], [0, 5, 1]), "two": ([0, 1, 2], [3, 3, 3])})
    for png, least in ((curves([graph], "x", "y", columns=1), 0.005), (curves([graph] * 3, "x", "y"), 0.001)):
        for colour in ((31, 119, 180), (255, 127, 14)):
            assert (np.abs(picture(png).astype(int) - colour) < 20).all(axis=-1).mean() > least / 2
    shown = picture(heat([("t", np.array([[0.0, 1.0], [2.0, 3.0]]))], [5, 10], "x", "y"))
    for colour in ((68, 1, 84), (253, 231, 36)):
        assert (np.abs(shown.astype(int) - colour) < 8).all(axis=-1).mean() > 0.05


def test_dashed_curves():
    """In the colour of another one, with gaps; the next one has the colour that it would have without."""
    graph = ("t", {name: ([0, 1], [1 + number, 4 + number]) for number, name in enumerate(("one", "one, cured", "two"))})
    solid, dashed = ([(np.abs(shown - colour) < 20).all(axis=-1).sum() for colour in ((31, 119, 180), (255, 127, 14), (44, 160, 44))]
                     for which in (None, {"one, cured": "one"}) for shown in [picture(curves([graph], "x", "y", dashed=which)).astype(int)])
    assert 1.3 * solid[0] < dashed[0] < 1.9 * solid[0]
    assert dashed[1] == pytest.approx(solid[2], rel=0.2) and dashed[2] == 0 < solid[2]


def test_the_same_numbers_give_the_same_bytes():
    one, two = (curves([("t", {"one": ([0, 1], [0, 5])})], "x", "y") for _ in range(2))
    assert one == two and re.match(rb"\x89PNG", one)

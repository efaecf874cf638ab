"""golden.pictures.sheet: what the colours of an error map say, that sheets show all panels, and that small PNG are small."""

import io

import numpy as np
import pytest
from PIL import Image

from golden.pictures.metrics import bad_pixels
from golden.pictures.sheet import BAD, GOOD, UNCOUNTED, UNKNOWN, Strip, error_map, small, write_comparison, write_judged, write_sheet


def test_error_map_counts_as_the_metric_does():
    rng = np.random.default_rng(1)
    disparity, truth = rng.integers(0, 5, (30, 40)), rng.integers(0, 5, (30, 40)).astype(float)
    truth[rng.random(truth.shape) < 0.1] = np.inf
    mask = rng.random(truth.shape) < 0.8
    for threshold in (0, 1, 2.5):
        colours = error_map(disparity, truth, mask, threshold)
        count = {colour: np.count_nonzero((colours == colour).all(axis=-1)) for colour in (GOOD, BAD, UNCOUNTED, UNKNOWN)}
        assert sum(count.values()) == truth.size
        assert count[UNKNOWN] == np.isinf(truth).sum() and count[UNCOUNTED] == (np.isfinite(truth) & ~mask).sum()
        assert 100 * count[BAD] / (count[BAD] + count[GOOD]) == pytest.approx(bad_pixels(disparity, truth, mask, threshold))


def colours(path):
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"))


def test_sheet(tmp_path):
    rng = np.random.default_rng(1)
    left, disparity = np.full((30, 40), 90, np.uint8), rng.integers(5, 21, (30, 40))
    truth = np.where(disparity == 7, np.inf, disparity + 3.0)
    write_sheet(tmp_path / "two.png", left, disparity, (5, 20))
    write_sheet(tmp_path / "four.png", left, disparity, (5, 20), (truth, np.isfinite(truth)))
    write_sheet(tmp_path / "four.svg", left, disparity, (5, 20), (truth, np.isfinite(truth)))
    two, four = (colours(tmp_path / f"{name}.png") for name in ("two", "four"))
    assert four.shape[1] == two.shape[1] and four.shape[0] > 1.9 * two.shape[0]

    def share(sheet, colour):
        return (sheet == colour).all(axis=-1).mean()

    assert share(four, BAD) > 0.1 and share(two, BAD) < 0.001
    assert min((np.abs(sheet.astype(int) - 90).max(axis=-1) <= 1).mean() for sheet in (two, four)) > 0.1
    assert len(np.unique(two[:, -two.shape[1] // 6:].reshape(-1, 3), axis=0)) > 150  # the colour bar
    # The ends of viridis: the scale reaches from the least disparity to the greatest, not from 0.
    assert share(two, (68, 1, 84)) > 0.005 and share(two, (253, 231, 36)) > 0.005
    assert (tmp_path / "four.svg").read_bytes().startswith(b"<?xml")


def test_comparison(tmp_path):
    rows, columns = np.indices((30, 40))
    one = Strip("one", np.full((30, 40), 90, np.uint8), {"a": columns.astype(float), "b": np.where(rows < 15, np.inf, 39.0)}, (0, 39))
    two = Strip("two", np.full((60, 40), 200, np.uint8), {"a": np.full((60, 40), 5.0), "b": np.full((60, 40), 12)}, (5, 12))
    for strips, name in (([one], "one"), ([one, two], "two")):
        write_comparison(tmp_path / f"{name}.png", strips)
        write_comparison(tmp_path / f"{name}.svg", strips)
        assert (tmp_path / f"{name}.svg").read_bytes().startswith(b"<?xml")
        with Image.open(tmp_path / f"{name}.png") as picture:
            assert picture.mode == "P"  # of few colours
    first, both = (colours(tmp_path / f"{name}.png").astype(int) for name in ("one", "two"))
    assert both.shape[0] > 2.2 * first.shape[0] and both.shape[1] == first.shape[1]  # as high as the pictures are
    least, greatest = (68, 1, 84), (253, 231, 36)  # of viridis

    def share(part, colour):
        return (np.abs(part - colour).max(axis=-1) <= 6).mean()

    upper, lower = np.split(both, [both.shape[0] * 38 // 100])
    for part, grey, thirds in ((upper, 90, None), (lower, 200, (least, greatest))):
        left, a, b = np.array_split(part, 3, axis=1)
        assert share(left, (grey,) * 3) > 0.7 and share(a, (grey,) * 3) < 0.01
        if thirds:
            assert share(a, least) > 0.7 and share(b, greatest) > 0.7  # each row has another scale
        else:
            assert share(b, (0, 0, 0)) > 0.3 and share(b, greatest) > 0.3  # black is not finite
            assert 0.005 < share(a, least) < 0.2 and len(np.unique(a.reshape(-1, 3), axis=0)) > 30


def test_small():
    def shown(png):
        return colours(io.BytesIO(png))

    rng = np.random.default_rng(1)
    noise = np.kron(rng.integers(0, 256, (40, 40, 3), dtype=np.uint8), np.ones((4, 4, 1), np.uint8))
    buffer = io.BytesIO()
    Image.fromarray(noise).save(buffer, format="PNG", compress_level=1)
    fewer = small(buffer.getvalue(), colours=16)
    assert len(fewer) < len(buffer.getvalue()) / 2 and shown(fewer).shape == noise.shape
    assert len(np.unique(shown(fewer).reshape(-1, 3), axis=0)) <= 16
    assert small(fewer, colours=64) in (fewer, small(fewer, colours=64)) and len(small(fewer, colours=64)) <= len(fewer)


def test_judged(tmp_path):
    """Each method's errors are below its disparities; all disparities share one colour scale."""
    rows, columns = np.indices((30, 40))
    truth = np.where(rows < 3, np.inf, columns / 2)
    mask = (rows >= 3) & (columns >= 4)
    methods = {"good": columns // 2, "bad": np.where(rows < 15, columns // 2, 0)}
    write_judged(tmp_path / "a.png", "title", np.full((30, 40), 90, np.uint8), methods, (truth, mask), (0, 40))
    write_judged(tmp_path / "a.svg", "title", np.full((30, 40), 90, np.uint8), methods, (truth, mask), (0, 40))
    text = (tmp_path / "a.svg").read_text()
    assert text.startswith("<?xml") and text.count("<image") == 7  # six panels and the colour bar
    for words in ("title", "left picture", "ground truth", *methods, "0.0 % of the pixels are off by more than 1", "disparity, pixels",
                  "within 1 pixel of the truth", "off by more than 1 pixel", "truth unknown", "not counted"):
        assert f"<!-- {words} -->" in text
    # Right from column 4 on; in the lower half 0 is right, within 1, up to column 2.
    assert f"<!-- {bad_pixels(methods['bad'], truth, mask):.1f} % of the pixels are off by more than 1 -->" in text
    sheet = colours(tmp_path / "a.png")
    height, width = sheet.shape[0], sheet.shape[1]
    bad = (sheet == BAD).all(axis=-1)
    places = np.argwhere(bad[:height * 17 // 20])
    assert places[:, 0].min() > height / 2 and places[:, 1].min() > width * 0.55
    # The scale ends at 40, so the pictures, up to 19, are far from the yellow at its end.
    pictures = sheet[:, width // 3:width * 9 // 10].astype(int)
    assert not ((pictures[..., 0] > 230) & (pictures[..., 2] < 60) & (pictures[..., 1] > 200)).any()


def test_judged_without_a_mask_has_no_class_of_uncounted_pixels(tmp_path):
    truth = np.full((30, 40), 5.0)
    write_judged(tmp_path / "a.svg", "title", np.zeros((30, 40), np.uint8), {"a": truth}, (truth, np.ones((30, 40), bool)), (0, 9))
    assert "<!-- not counted -->" not in (tmp_path / "a.svg").read_text()

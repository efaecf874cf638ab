"""golden.sheet: what the colours of an error map say, and that a sheet shows all panels."""

import numpy as np
import pytest
from PIL import Image

from golden.metrics import bad_pixels
from golden.sheet import BAD, GOOD, UNCOUNTED, UNKNOWN, error_map, write_sheet


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

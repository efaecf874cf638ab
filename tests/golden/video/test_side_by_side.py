import numpy as np
import pytest

from golden.video.display import colour_table
from golden.video.formats import VGA, DisplayFormat
from golden.video.side_by_side import layout, side_by_side


SMALL = DisplayFormat(12, range(13, 14), 16, 6, range(7, 8), 9, 1)


@pytest.mark.parametrize("size, step, columns, lines", [
    ((320, 240), 1, range(640), range(120, 360)), ((640, 480), 2, range(640), range(120, 360)),
    ((450, 375), 2, range(95, 545), range(146, 333)),
    ((321, 10), 2, range(160, 480), range(237, 242)), ((1, 1), 1, range(319, 321), range(239, 240)),
    ((100, 481), 2, range(270, 370), range(120, 360)),
])
def test_layout(size, step, columns, lines):
    found = layout(VGA, *size)
    assert (found.step, found.columns, found.lines, found.width) == (step, columns, lines, len(columns) // 2)


@pytest.mark.parametrize("size", [(4096, 3), (2, 1000)])
def test_cannot_be_shown(size):
    with pytest.raises(ValueError, match=rf"^pictures of {size[0]}x{size[1]} pixels cannot be shown on a display of 640x480; choose"):
        layout(VGA, *size)


def test_picture():
    """Left picture, disparities in colour, black where there is none and around; every pixel of a small one, every second of a large."""
    left, label, known = np.arange(6).reshape(2, 3) + 100, np.array([[0, 1, 2], [3, 3, 0]]), np.array([[1, 1, 1], [1, 0, 1]], dtype=bool)
    shown = side_by_side(left, label, known, SMALL, 4)
    assert shown.shape == (6, 12, 3) and shown.dtype == np.uint8
    assert shown[2:4, 3:6].tolist() == [[[level] * 3 for level in line] for line in left.tolist()]
    colours = colour_table()[[0, 85, 170, 255]]
    assert shown[2, 6:9].tolist() == colours[[0, 1, 2]].tolist()
    assert shown[3, 6:9].tolist() == [colours[3].tolist(), [0, 0, 0], colours[0].tolist()]
    shown[2:4, 3:9] = 0
    assert not shown.any()

    larger = np.arange(13 * 8).reshape(8, 13) % 4
    wide = side_by_side(larger * 9, larger, np.ones_like(larger, dtype=bool), SMALL, 4)
    taken = larger[:8:2, :12:2]
    assert wide[1:5, :6, 0].tolist() == (taken * 9).tolist()
    assert wide[1:5, 6:].tolist() == colours[taken].tolist()

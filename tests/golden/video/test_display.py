"""golden.video.display on hand-worked pictures."""

import numpy as np
import pytest

from golden.video.display import DisplayMode, colour_table, grey_level, monitor_picture, placement
from golden.video.formats import DISPLAYS, DisplayFormat


DISPLAY = DisplayFormat(7, range(8, 9), 10, 5, range(6, 7), 8, 1_000_000)
DISPARITY = np.array([[0, 1, 2, 3], [4, 0, 1, 2], [3, 4, 0, 1]])
LEFT = np.array([[10, 20, 30, 40], [50, 60, 70, 80], [90, 100, 110, 255]])

# matplotlib's turbo at 0, 63, 127, 191, 255.
TURBO = [(48, 18, 59), (42, 185, 237), (161, 252, 61), (251, 128, 34), (122, 4, 2)]


def test_codes():
    assert [DisplayMode(name).code for name in ("disparity", "left", "both")] == [0, 1, 2]


def test_grey_level_rounds_down():
    # 255 / 4 = 63.75
    assert grey_level(np.arange(5), 5).tolist() == [0, 63, 127, 191, 255]
    assert grey_level(np.arange(2), 2).tolist() == [0, 255]
    assert grey_level(np.arange(256, dtype=np.uint8), 256).tolist() == list(range(256))
    with pytest.raises(ValueError, match=r"from 0 to 5 are not within 0 \.\. 4"):
        grey_level(np.arange(6), 5)
    with pytest.raises(ValueError, match="from -1 to 0"):
        grey_level(np.array([-1, 0]), 5)


def test_colour_table():
    table = colour_table()
    assert table.shape == (256, 3) and table.dtype == np.uint8
    assert [tuple(colour) for colour in table[[0, 63, 127, 191, 255]].tolist()] == TURBO
    assert len(np.unique(table, axis=0)) == 256


def test_disparity_in_grey():
    """Three black columns, one left and two right; two black lines, one above and one below."""
    screen = monitor_picture(DISPARITY, LEFT, DISPLAY, "disparity", False, 5)
    assert screen.dtype == np.uint8
    assert screen[..., 0].tolist() == [
        [0, 0, 0, 0, 0, 0, 0],
        [0, 0, 63, 127, 191, 0, 0],
        [0, 255, 0, 63, 127, 0, 0],
        [0, 191, 255, 0, 63, 0, 0],
        [0, 0, 0, 0, 0, 0, 0],
    ]
    assert (screen == screen[..., :1]).all()


def test_disparity_in_colour():
    """Black is around the picture only: disparity 0 is dark blue."""
    screen = monitor_picture(DISPARITY, LEFT, DISPLAY, "disparity", True, 5)
    assert screen[2].tolist() == [[0, 0, 0], *(list(TURBO[d]) for d in (4, 0, 1, 2)), [0, 0, 0], [0, 0, 0]]
    assert not screen[[0, 4]].any()


@pytest.mark.parametrize("colour", [False, True])
def test_left_is_grey(colour):
    screen = monitor_picture(DISPARITY, LEFT, DISPLAY, DisplayMode.LEFT, colour, 5)
    for channel in range(3):
        assert screen[3, :, channel].tolist() == [0, 90, 100, 110, 255, 0, 0]


@pytest.mark.parametrize("colour", [False, True])
def test_both(colour):
    """Pixels 0 and 2 of line 0; line 2 has no second line to pair with. Two black lines above, two below."""
    screen = monitor_picture(DISPARITY, LEFT, DISPLAY, "both", colour, 5)
    disparities = [TURBO[0], TURBO[2]] if colour else [(0, 0, 0), (127, 127, 127)]
    assert screen[2].tolist() == [[0, 0, 0], *map(list, disparities), [10, 10, 10], [30, 30, 30], [0, 0, 0], [0, 0, 0]]
    assert not screen[[0, 1, 3, 4]].any()


def test_both_of_odd_width():
    """The last column of five has no second one to pair with."""
    left = np.arange(25).reshape(5, 5)
    screen = monitor_picture(np.zeros((5, 5), dtype=int), left, DISPLAY, "both", False, 5)
    assert screen[1:3, :, 0].tolist() == [[0, 0, 0, 0, 2, 0, 0], [0, 0, 0, 10, 12, 0, 0]]


def test_picture_of_the_displays_size():
    """No black at all, and uint8 pictures do not wrap."""
    disparity = np.full((5, 7), 79, dtype=np.uint8)
    assert (monitor_picture(disparity, disparity, DISPLAY, "disparity", False, 80) == 255).all()


def test_placement():
    assert placement(DISPLAYS["720x576"], 720, 576, "disparity") == (range(720), range(576))
    assert placement(DISPLAYS["720x576"], 720, 576, "both") == (range(720), range(144, 432))
    assert placement(DISPLAYS["1024x768"], 719, 575, "left") == (range(152, 871), range(96, 671))
    assert placement(DISPLAYS["1024x768"], 719, 575, "both") == (range(153, 871), range(240, 527))


@pytest.mark.parametrize("size", [(8, 5), (7, 6), (1, 5), (7, 1)])
def test_refuses_sizes(size):
    with pytest.raises(ValueError, match=f"picture of {size[0]}x{size[1]} pixels cannot be shown on a display of 7x5"):
        placement(DISPLAY, *size, "left")


def test_refuses_unequal_pictures_and_unknown_modes():
    with pytest.raises(ValueError, match=r"\(3, 4\) and a left picture of shape \(3, 3\)"):
        monitor_picture(DISPARITY, LEFT[:, :3], DISPLAY, "left", False, 5)
    with pytest.raises(ValueError, match="sideways"):
        monitor_picture(DISPARITY, LEFT, DISPLAY, "sideways", False, 5)

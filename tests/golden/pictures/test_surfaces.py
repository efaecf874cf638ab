"""golden.pictures.surfaces: pictures of planes against their geometry, pixel by pixel."""

import numpy as np
import pytest

from golden.pictures.surfaces import Box, Surface, photometric, render, texture


def ramp(width, height):
    """Levels that tell a place: linear, so that what lies between pixels is exact."""
    return np.add.outer(100.0 * np.arange(height), np.arange(width))


def surfaces(width=40, height=9):
    levels = ramp(width, height)
    return [
        Surface(levels, base=1, along=0.05, down=0.25),
        Surface(1000 + levels, base=6, along=-0.2, box=Box(10, 1, 22, 8)),
        Surface(5000 + levels, base=9.5, along=0.1, down=-0.5, box=Box(25, 2, 33, 9)),
    ]


def test_disparity_of_every_pixel():
    left, _, truth, _ = render(surfaces())
    for (y, x), d in np.ndenumerate(truth):
        planes = {0: 1 + 0.05 * x + 0.25 * y}
        if 10 <= x < 22 and 1 <= y < 8:
            planes[1000] = 6 - 0.2 * x
        if 25 <= x < 33 and 2 <= y < 9:
            planes[5000] = 9.5 + 0.1 * x - 0.5 * y
        nearest = max(planes, key=planes.__getitem__)
        assert d == pytest.approx(planes[nearest])
        assert left[y, x] == ramp(40, 9)[y, x] + nearest


def test_right_shows_what_is_visible():
    """Where the right picture has the neighbourhood of a visible point, between two pixels it has the level of the left one."""
    left, right, truth, visible = render(surfaces())
    checked = 0
    for y, x in np.argwhere(visible):
        at = x - truth[y, x]
        before, after = int(np.floor(at)), int(np.ceil(at))
        if x == 39 or abs(right[y, before] - right[y, after]) > 50:
            continue  # an edge is between
        mixed = right[y, before] + (right[y, after] - right[y, before]) * (at - before)
        assert mixed == pytest.approx(left[y, x], abs=1e-6)
        checked += 1
    assert checked > 250


def test_hidden_is_hidden():
    """A pixel is hidden if its place in the right picture is outside, or has a nearer point: sampled a hundred times finer."""
    _, _, truth, visible = render(surfaces())
    y, x = 4, np.arange(0, 40, 0.01)
    planes = [1 + 0.05 * x + 1, np.where((x >= 10) & (x < 22), 6 - 0.2 * x, -99), np.where((x >= 25) & (x < 33), 9.5 + 0.1 * x - 2, -99)]
    hidden = []
    for column in range(40):
        at = column - truth[y, column]
        nearest = max(plane[np.abs(x - plane - at) < 0.02].max(initial=-99) for plane in planes)
        hidden.append(at < 0 or nearest > truth[y, column] + 0.05)
    assert hidden == (~visible[y]).tolist()
    assert 3 < sum(hidden) < 20


def test_a_surface_from_behind_is_refused():
    with pytest.raises(ValueError, match="along must be below 1, not 1"):
        Surface(ramp(3, 3), base=0, along=1)


@pytest.mark.parametrize("objects", [[], [Surface(ramp(3, 3), base=0, box=Box(0, 0, 3, 3))]])
def test_the_first_is_everywhere(objects):
    with pytest.raises(ValueError, match="everywhere"):
        render(objects)


@pytest.mark.parametrize("width, height", [(1, 1), (40, 9), (200, 150)])
def test_texture(width, height):
    levels = texture(np.random.default_rng(1), width, height)
    assert levels.shape == (height, width) and levels.min() >= 0 and levels.max() <= 255
    if width > 100:
        assert 30 < levels.std() < 45 and 90 < levels.mean() < 165
        assert np.abs(np.diff(levels)).mean() > 5  # detail of a few pixels


def test_photometric():
    flat = np.full((200, 300), 100.0)
    picture = photometric(flat, np.random.default_rng(1), gain=1.5, offset=-20, noise=4)
    assert picture.dtype == np.uint8
    assert picture.mean() == pytest.approx(130, abs=0.1) and picture.std() == pytest.approx(4, abs=0.1)
    np.testing.assert_array_equal(photometric(flat, np.random.default_rng(1)), 100)

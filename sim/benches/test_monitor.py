"""The monitor's model: accepts a correct signal, and raises on each fault, with its place."""

import numpy as np
import pytest

from golden.video.formats import DisplayFormat
from sim.models.monitor import PINS, Monitor, TimingError


# 3x2 pixels in 6x5.
DISPLAY = DisplayFormat(3, range(4, 5), 6, 2, range(3, 4), 5, 1)


def frames(pictures):
    """Pixel clocks of whole frames, from the first active pixel on, as dicts of pins."""
    for picture in pictures:
        for y in range(5):
            for x in range(6):
                de = x < 3 and y < 2
                red, green, blue = picture[y, x].tolist() if de else (0, 0, 0)
                yield {"red": red, "green": green, "blue": blue, "de": int(de), "hsync": int(x != 4), "vsync": int(y != 3)}


def play(cycles, monitor):
    for pins in cycles:
        word = place = 0
        for name, bits in PINS.items():
            word |= pins[name] << place
            place += bits
        monitor.clock(word)
    return monitor


def noise(count):
    return np.random.default_rng(1).integers(1, 256, (count, 2, 3, 3))


def test_captures_pictures():
    """The first frame is not whole: the monitor sees it from vsync on. The last one is not over until vsync falls again."""
    pictures = noise(5)
    monitor = play(list(frames(pictures))[7:-13], Monitor(DISPLAY))
    assert monitor.frames == 3
    np.testing.assert_array_equal(monitor.pictures, pictures[1:4])
    assert monitor.pictures[0].dtype == np.uint8
    assert len(play(frames(pictures), Monitor(DISPLAY, keep=2)).pictures) == 2


def test_restart():
    """A gap in the signal is forgiven if it is announced."""
    pictures = noise(4)
    cycles = list(frames(pictures))
    monitor = play(cycles[:40], Monitor(DISPLAY))
    monitor.restart()
    play(cycles[44:], monitor)
    np.testing.assert_array_equal(monitor.pictures, pictures[2:4])


# The frame that begins at clock 60 is the second one that is watched; vsync fell at clock 18.
@pytest.mark.parametrize("pin", ["de", "hsync", "vsync"])
@pytest.mark.parametrize("at", [0, 2, 3, 4, 5, 8, 12, 17, 18, 20, 23, 24, 29])
def test_one_wrong_bit(at, pin):
    cycles = list(frames(noise(5)))
    cycles[60 + at][pin] ^= 1
    y, x = divmod(at, 6)
    with pytest.raises(TimingError, match=rf"frame {1 + (y >= 3)}, line {y}, column {x}: .*'{pin}'"):
        play(cycles, Monitor(DISPLAY))


@pytest.mark.parametrize("pin", ["red", "green", "blue"])
@pytest.mark.parametrize("at", [3, 12, 23])
def test_colour_outside_de(at, pin):
    cycles = list(frames(noise(5)))
    cycles[60 + at][pin] = 1
    with pytest.raises(TimingError, match=f"line {at // 6}: a colour outside de"):
        play(cycles, Monitor(DISPLAY))


@pytest.mark.parametrize("at", [1, 16, 21, 29])
@pytest.mark.parametrize("change", ["lost", "twice"])
def test_a_clock_too_few_or_too_many(at, change):
    cycles = list(frames(noise(5)))
    if change == "lost":
        del cycles[60 + at]
    else:
        cycles.insert(60 + at, cycles[60 + at])
    with pytest.raises(TimingError, match=r"frame \d, line \d, column"):
        play(cycles, Monitor(DISPLAY))


def test_no_vsync():
    """And no edge where the signal begins with vsync low."""
    quiet = [{**pins, "vsync": 1} for pins in frames(noise(3))]
    with pytest.raises(TimingError, match="vsync has not fallen"):
        play(quiet, Monitor(DISPLAY))
    assert play(list(frames(noise(2)))[18:], Monitor(DISPLAY)).frames == 0

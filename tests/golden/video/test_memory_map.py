"""golden.video.memory_map: numbers worked by hand, and pictures there and back."""

import numpy as np
import pytest

from golden.video.memory_map import MemoryMap, Plane


def test_numbers_of_pal():
    # 720 pixels are 45 words, 64 is the next power of two; 576 lines of 64 words; four planes of two buffers.
    memory_map = MemoryMap()
    assert (memory_map.line_words, memory_map.pitch, memory_map.picture_words, memory_map.total_words) == (45, 64, 36864, 294912)
    bases = [memory_map.base(plane, buffer) for plane in Plane for buffer in range(2)]
    assert bases == [0, 36864, 73728, 110592, 147456, 184320, 221184, 258048]
    assert memory_map.line(Plane.RIGHT, 1) == 3 * 576


@pytest.mark.parametrize("width, words, pitch",
                         [(1, 1, 1), (16, 1, 1), (17, 2, 2), (33, 3, 4), (64, 4, 4), (65, 5, 8), (1024, 64, 64), (1025, 65, 128)])
def test_pitch(width, words, pitch):
    memory_map = MemoryMap(width, 3, 3)
    assert (memory_map.line_words, memory_map.pitch) == (words, pitch)
    assert memory_map.base(Plane.SHOWN_LEFT, 2) == 11 * 3 * pitch
    assert memory_map.total_words == 12 * 3 * pitch


def test_words():
    """18 pixels: the first in the lowest byte, two in the second word, and the next line two words on."""
    picture = np.arange(36).reshape(2, 18)
    memory_map = MemoryMap(18, 2)
    words = memory_map.words(picture)
    assert list(words) == [0, 1, 2, 3]
    assert words[0] == int.from_bytes(bytes(range(16)), "little")
    assert words[1] == 16 + (17 << 8)
    assert words[3] == 34 + (35 << 8)


@pytest.mark.parametrize("width, height", [(1, 1), (5, 2), (16, 3), (37, 5), (48, 1)])
def test_there_and_back(width, height):
    memory_map = MemoryMap(width, height)
    picture = np.random.default_rng(1).integers(0, 256, (height, width))
    words = memory_map.words(picture)
    assert len(words) == height * memory_map.line_words
    assert memory_map.picture(words).tolist() == picture.tolist()
    if width % 16:
        last = memory_map.line_words - 1
        assert memory_map.picture({**words, last: words[last] | 0xff << 120}).tolist() == picture.tolist()


@pytest.mark.parametrize("name, limits", [("width", (1, 4096)), ("height", (1, 4096)), ("buffers", (2, 4))])
def test_limits(name, limits):
    least, most = limits
    for value in (least - 1, most + 1, 20.0):
        with pytest.raises(ValueError, match=rf"^{name} must be a whole number from {least} to {most}, not {value}$"):
            MemoryMap(**{name: value})
    for value in limits:
        assert getattr(MemoryMap(**{"width": 16, "height": 16, name: value}), name) == value


def test_must_fit():
    # 4096 pixels are 256 words; 8 pictures of 4096 lines fill the memory exactly.
    assert MemoryMap(4096, 4096, 2).total_words == 2**23
    with pytest.raises(ValueError, match=r"^12 pictures of 4096x4096 take 12582912 words of memory, which has 8388608: choose a smaller "
                                         r"picture or fewer buffers than 3$"):
        MemoryMap(4096, 4096, 3)


def test_bad_picture_or_buffer():
    with pytest.raises(ValueError, match=r"a picture of this map is \(2, 18\), not \(18, 2\)"):
        MemoryMap(18, 2).words(np.zeros((18, 2)))
    with pytest.raises(ValueError, match="buffer must be from 0 to 1, not 2"):
        MemoryMap(18, 2).base(Plane.LEFT, 2)

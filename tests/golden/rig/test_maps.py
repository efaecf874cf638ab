"""golden.rig.maps: words and back, limits, displacements between control points."""

import dataclasses

import numpy as np
import pytest

from golden.rig.maps import displacement, grid, identity, map_sum, pack, unpack, word_count


def random_map(width, height, seed=1, reach=8191):
    rng = np.random.default_rng(seed)
    shape = grid(width, height)
    return dataclasses.replace(identity(width, height), dx=rng.integers(-reach, reach, shape), dy=rng.integers(-reach, reach, shape),
                               gain=rng.integers(0, 256, shape), bounds=rng.integers(-8192, 8192, shape[:1]))


@pytest.mark.parametrize("size", [(2, 2), (33, 32), (97, 65), (720, 576)])
def test_words_and_back(size):
    before = random_map(*size)
    words = pack(before)
    after = unpack(words, *size)
    assert len(words) == word_count(*size) and all(0 <= word < 2**36 for word in words)
    for field in ("dx", "dy", "gain", "bounds"):
        assert (getattr(after, field) == getattr(before, field)).all()


def test_place_of_the_fields_in_a_word():
    zero = np.zeros((2, 2), int)
    word, *_ = pack(dataclasses.replace(identity(2, 2), dx=zero - 1, dy=zero + 5, gain=zero + 200))
    assert word == 200 << 28 | 5 << 14 | 0x3FFF
    *_, bound = pack(dataclasses.replace(identity(2, 2), bounds=np.array([0, -8192])))
    assert bound == 0x2000


def test_map_of_the_documents_size():
    assert word_count(720, 576) == 19 * 25


def test_displacement_by_hand():
    """Between 0 and 64 at the left, and 32 and 96 at the right: planes, except for the rounding."""
    which = dataclasses.replace(identity(32, 32), dx=np.array([[0, 32], [64, 96]]), dy=np.array([[0, 1], [0, 1]]))
    dx, dy, gain = displacement(which)
    y, x = np.mgrid[:32, :32]
    assert (dx == x + 2 * y).all() and (dy == (x >= 16)).all() and (gain == 512).all()


def test_negative_halves_round_up():
    dx, _, _ = displacement(dataclasses.replace(identity(32, 2), dx=np.array([[0, -1], [0, -1]])))
    assert dx[0, 16] == 0 and dx[0, 17] == -1


@pytest.mark.parametrize("change, message", [
    ({"dx": 8192}, r"dx of the control point \(0, 0\) is 8192, but must be from -8192 to 8191 in 1/32 pixel"),
    ({"dy": -8193}, "dy of the control point .* is -8193"),
    ({"gain": 256}, "gain .* is 256, but must be from 0 to 255 where 128 is 1"),
    ({"bounds": 9000}, "bounds .* is 9000, but must be from -8192 to 8191 in lines"),
])
def test_limits(change, message):
    (name, value), = change.items()
    array = np.zeros(2 if name == "bounds" else (2, 2), int)
    array.flat[0] = value
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(identity(9, 9), **{name: array})


@pytest.mark.parametrize("width, height, name", [(1, 5, "width"), (5, 4097, "height"), (5.0, 5, "width")])
def test_sizes(width, height, name):
    plain = identity(9, 9)
    with pytest.raises(ValueError, match=f"{name} must be a whole number from 2 to 4096"):
        dataclasses.replace(plain, width=width, height=height)


def test_arrays_of_another_shape():
    with pytest.raises(ValueError, match=r"gain of a map for 9x9 .* must be whole numbers of shape \(2, 2\), not int64 of shape \(3, 2\)"):
        dataclasses.replace(identity(9, 9), gain=np.zeros((3, 2), int))
    with pytest.raises(ValueError, match="not float64"):
        dataclasses.replace(identity(9, 9), dx=np.zeros((2, 2)))


def test_wrong_words():
    with pytest.raises(ValueError, match="a map for 9x9 pixels has 6 words, not 5"):
        unpack([0] * 5, 9, 9)
    with pytest.raises(ValueError, match="word 2 of a map is 0x1000000000, which has not 36 bits"):
        unpack([0, 0, 1 << 36, 0, 0, 0], 9, 9)


def test_sum_sees_what_was_loaded_wrong():
    words = pack(identity(40, 40))
    words[1] += 5
    changed = [words[1:], words[:-1] + [words[-1] ^ 1], [words[0] ^ 1 << 35, *words[1:]], [words[1], words[0], *words[2:]],
               [word << 16 & (1 << 36) - 1 | word >> 20 for word in words]]
    assert map_sum(words) not in [map_sum(each) for each in changed]

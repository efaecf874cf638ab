"""golden.rig.balance: fast equals plain, off copies, hand-worked numbers, smoothing from pair to pair."""

import numpy as np
import pytest

from golden.rig.balance import (
    BALANCE_OFF,
    GAINS,
    OFFSETS,
    Auto,
    Fixed,
    Statistics,
    apply,
    apply_plain,
    balance,
    measure,
    measure_plain,
    target,
    windows,
)


def scene(width=90, height=40, seed=1, low=40, high=200):
    return np.random.default_rng(seed).integers(low, high, (height, width), dtype=np.uint8)


def darker(picture, gain=0.7, offset=5):
    return np.rint(gain * picture + offset).astype(np.uint8)


@pytest.mark.parametrize("size", [(2, 2), (33, 17), (64, 32), (90, 40)])
@pytest.mark.parametrize("minimum, labels", [(0, 16), (-64, 16), (100, 64), (-3, 5)])
def test_measured_alike(size, minimum, labels):
    left, right = scene(*size), scene(*size, seed=2, low=0, high=256)
    own = measure(left, right, minimum, labels)
    assert own == measure_plain(left, right, minimum, labels)
    before = Statistics(0, 3000, 1, 1)
    assert measure(left, right, minimum, labels, before) == measure_plain(left, right, minimum, labels, before) != own


@pytest.mark.parametrize("gain, offset", [(256, 0), (366, -10), (128, 16384), (512, -16384), (129, 77)])
def test_applied_alike(gain, offset):
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert (apply(levels, gain, offset) == apply_plain(levels, gain, offset)).all()


def test_off_is_an_exact_copy():
    levels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    result = BALANCE_OFF.pair(levels, levels)
    assert result.dtype == np.uint8 and (result == levels).all()


@pytest.mark.parametrize("width, height, minimum, labels", [(720, 576, 0, 80), (640, 480, 0, 80), (450, 375, 0, 60), (256, 256, 0, 64),
                                                            (257, 255, 0, 64), (384, 288, -64, 16), (720, 576, 255, 255)])
def test_windows_are_powers_of_two_within_the_picture(width, height, minimum, labels):
    sides = windows(width, height, minimum, labels)
    for rows, columns in sides:
        assert rows == sides[0][0]
        for place, size in ((rows, height), (columns, width)):
            length = place.stop - place.start
            assert 0 <= place.start and place.stop <= size and length & (length - 1) == 0 and size < 2 * length


def test_windows_see_the_middle_disparity():
    (_, left), (_, right) = windows(720, 576, 10, 81)
    assert left.start - right.start == 50 and left.start - 104 == 25
    assert windows(512, 512, 0, 80)[0] == windows(512, 512, 0, 80)[1]       # no room


def test_statistics_by_hand():
    left = np.array([[10, 20], [30, 40]])
    found = measure(left, left + 3, 0, 2)
    assert found == Statistics(400, 448, 160, 160)
    assert measure(left, left + 3, 0, 2, Statistics(0, 0, 0, 0)) == Statistics(400, 448, 400, 448)


def test_target_by_hand():
    assert target(Statistics(1600, 1120, 400, 400)) == (256, 7680)          # 30 grey levels
    assert target(Statistics(1600, 1120, 400, 31)) is None
    assert target(Statistics(1600, 1120, 400, 32))[0] == GAINS[-1]
    assert target(Statistics(1600, 1120, 4, 400))[0] == GAINS[0]
    assert target(Statistics(0, 4080, 600, 300)) == (512, OFFSETS[0])
    assert target(Statistics(4080, 0, 300, 300)) == (256, OFFSETS[-1])


def test_single_pair_is_cured():
    left = scene()
    right = darker(left)
    assert np.abs(right.astype(int) - left).mean() > 20
    assert np.abs(balance(left, right, 0, 2).astype(int) - left).max() <= 2


def test_flat_pictures_are_copied():
    flat = np.full((20, 20), 7, np.uint8)
    assert (balance(scene(20, 20), flat, 0, 2) == flat).all()


def test_pairs_one_after_the_other():
    left = scene()
    right = darker(left)
    auto = Auto(0, 2)
    results = [auto.pair(left, right) for _ in range(3)]
    assert (results[0] == right).all() and (results[1] == right).all()      # means first, then deviations
    assert (results[2] == balance(left, right, 0, 2)).all() and not (results[2] == right).all()
    assert (auto.gain, auto.offset) == target(measure(left, right, 0, 2))


@pytest.mark.parametrize("gain", [0.6, 0.75, 1.0])
def test_smoothing_ends_at_the_target_from_both_sides(gain):
    """A step is followed by an eighth of the difference a pair, and ends there exactly."""
    left = scene()
    auto = Auto(0, 2)
    for _ in range(2):
        auto.pair(left, darker(left, 0.8, 9))
    start, goal = auto.gain, target(measure(left, darker(left, gain, 0), 0, 2))
    auto.pair(left, darker(left, gain, 0))      # its deviations are taken around the means of the pair before
    auto.pair(left, darker(left, gain, 0))
    assert min(start, goal[0]) < auto.gain < max(start, goal[0])
    for _ in range(150):
        auto.pair(left, darker(left, gain, 0))
    assert (auto.gain, auto.offset) == goal


def test_first_step_by_hand():
    """From a = 256 to a = 512: 256 + 256 / 8 = 288."""
    auto = Auto(0, 2)
    left = np.array([[60, 100], [140, 180]], np.uint8)
    half = (left // 2).astype(np.uint8)
    for right in (left, left, half, half):
        auto.pair(left, right)
        found = auto.gain
    assert auto.statistics == Statistics(1920, 960, 640, 320)
    # The third pair's right deviations are taken around 1920: 960, and 640 / 960 gives 171. 256 - 85 / 8, then towards 512.
    third = 4096 + ((171 * 16 - 4096) >> 3)
    assert found == (third + ((512 * 16 - third) >> 3) + 8) >> 4


def test_held_without_contrast():
    left = scene()
    auto = Auto(0, 2)
    for _ in range(2):
        auto.pair(left, darker(left))
    held = auto.gain, auto.offset
    auto.pair(left, np.zeros_like(left))        # around the means of before, black has much deviation
    after = auto.gain, auto.offset
    for _ in range(5):
        auto.pair(left, np.zeros_like(left))
    assert (auto.gain, auto.offset) == after != held


def test_fixed():
    levels = np.arange(256, dtype=np.uint8)[None]
    assert Fixed(512, -256).pair(levels, levels)[0, :4].tolist() == [0, 1, 3, 5]
    with pytest.raises(ValueError, match="gain must be a whole number from 128 to 512, where 256 is 1, not 127"):
        Fixed(127, 0)
    with pytest.raises(ValueError, match="offset must be a whole number from -16384 to 16384, in 1/256 grey level, not 16385"):
        Fixed(256, 16385)


def test_gain_is_rounded_half_up():
    assert [target(Statistics(0, 0, left, 64))[0] for left in (40, 41)] == [160, 164]
    assert target(Statistics(0, 0, 100, 61))[0] == 420      # 419.67

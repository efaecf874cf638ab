"""golden.config: limits, and widths worked by hand."""

import dataclasses
import re

import pytest

from golden.config import Arithmetic, Engine, MatcherConfig


@pytest.mark.parametrize("name, good, bad", [
    ("disparities", (2, 128), (1, MatcherConfig.DISPARITIES[-1] + 1, -1, 16.5)),
    ("fraction_bits", (0, 4), (-1, 5)),
    ("u1", (0, 63), (-1, 64)),
    ("u2", (0, 63), (-1, 64)),
    ("u3", (0, 63), (-1, 64)),
    ("max_width", (1, 4096), (0, 4097)),
])
def test_limits(name, good, bad):
    for value in good:
        assert getattr(MatcherConfig(**{name: value}), name) == value
    for value in bad:
        with pytest.raises(ValueError, match=rf"{name} must be a whole number from {good[0]} to [0-9]+, not {value}"):
            MatcherConfig(**{name: value})


def test_arithmetic_is_an_enum():
    assert MatcherConfig(arithmetic="linear").arithmetic is Arithmetic.LINEAR
    with pytest.raises(ValueError, match="decimal"):
        MatcherConfig(arithmetic="decimal")


def test_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        MatcherConfig().disparities = 3


@pytest.mark.parametrize("arithmetic, expected", [
    # sub-pixel, cost, its bits, outside, factor of the cost in the energy
    ("float", (255, 1275, 11, 2047, 255)),
    ("thesis", (255, 1275, 11, 2047, 1)),
    ("linear", (510, 2550, 12, 4095, 8)),
])
def test_cost_numbers(arithmetic, expected):
    config = MatcherConfig(arithmetic=arithmetic)
    assert (config.sub_pixel_max, config.cost_max, config.cost_bits, config.cost_outside, config.energy_scale) == expected


def test_energy_numbers():
    # THESIS: 2047 + 3 * 63 * 79. LINEAR, q = 3: 4095 * 8 + 3 * (2 * 63 * 8) * 79.
    assert MatcherConfig(disparities=80).energy_max == 16978
    linear = MatcherConfig(disparities=80, arithmetic="linear")
    assert (linear.slope_max, linear.energy_max, linear.energy_bits) == (1008, 271656, 19)


@pytest.mark.parametrize("settings, message", [
    ({"disparities": 80.0}, "disparities must be a whole number from 2 to 256, not 80.0"),
    ({"engine": Engine.STREAMING}, "engine streaming computes the arithmetic linear only, not thesis"),
    ({"engine": Engine.STREAMING, "arithmetic": Arithmetic.FLOAT}, "engine streaming computes the arithmetic linear only, not float"),
])
def test_what_no_matcher_can_be(settings, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        MatcherConfig(**settings)

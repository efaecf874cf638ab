"""golden.config: limits, and widths worked by hand."""

import dataclasses
import re

import pytest

from golden.config import FUSED_1, FUSED_2, FUSED_3, Arithmetic, Cost, Engine, FusedParameters, MatcherConfig


@pytest.mark.parametrize("name, good, bad", [
    ("disparities", (2, 128), (1, MatcherConfig.DISPARITIES[-1] + 1, -1, 16.5)),
    ("fraction_bits", (0, 4), (-1, 5)),
    ("u1", (0, 63), (-1, 64)),
    ("u2", (0, 63), (-1, 64)),
    ("u3", (0, 63), (-1, 64)),
    ("max_width", (1, 4096), (0, 4097)),
    ("minimum", (0, 255), (-1, 256)),
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


def test_fused_1():
    # Section by section of the method: cost, census, support, weights in eighths, check and median; no vertical support.
    assert dataclasses.astuple(FUSED_1) == (156, 4, 47, 4, 30, 5, 7, 10, 16, 17, 30, 22, 3, 1, 5, 0, 10)
    assert FusedParameters() == MatcherConfig().fused == FUSED_1


def test_four_bits():
    assert FUSED_2.vertical and FUSED_2.cost_max.bit_length() == 4  # eight of them in a memory block's word
    assert not FUSED_3.vertical and FUSED_3.cost_max.bit_length() == 4 and FUSED_3.sum_max.bit_length() == 9


@pytest.mark.parametrize("name", FusedParameters.LIMITS)
def test_fused_limits(name):
    limits = FusedParameters.LIMITS[name]
    others = {"truncation": 100, "cost_factor": 1, "census_weight": 1}  # so that each greatest value has a cost that fits
    for value in (limits[0], limits[-1]):
        shift = {} if name == "cost_shift" else {"cost_shift": 7}
        assert getattr(FusedParameters(**{**others, **shift, name: value}), name) == value
    for value in (limits[0] - limits.step, limits[-1] + limits.step, limits[0] + 0.5, *([limits[0] + 1] if limits.step == 2 else [])):
        with pytest.raises(ValueError, match=rf"{name} must be an? (odd )?whole number from {limits[0]} to {limits[-1]}, not {value}"):
            FusedParameters(**{name: value})
    assert {field.name for field in dataclasses.fields(FusedParameters)} == set(FusedParameters.LIMITS)


def test_fused_cost_fits_its_bits():
    # 47 * 34 = 1598; (4 * 624 + 1598) >> 4 = 4094 >> 4 = 255; with 625 it is 4098 >> 4 = 256.
    assert FusedParameters(truncation=624).cost_max == 255 == FusedParameters.COST_MAX
    with pytest.raises(ValueError, match="the fused cost reaches 256, more than the 255 that its 8 bits hold"):
        FusedParameters(truncation=625)
    assert FusedParameters(cost_factor=0, census_weight=0).cost_max == 30  # outside


def test_fused_numbers():
    config = MatcherConfig(disparities=80, arithmetic="linear", cost="fused")
    assert config.cost is Cost.FUSED
    assert (config.fused.cost_max, config.fused.support_max, config.fused.sum_max) == (138, 33, 4554)
    # Slopes reach 33 * 63; energies 4554 * 8 + 3 * 2079 * 79. The costs E are those of LINEAR.
    assert (config.slope_max, config.energy_shift, config.energy_max, config.energy_bits) == (2079, 3, 529155, 20)
    assert (config.cost_max, config.weights, MatcherConfig().weights) == (2550, (17, 30, 22), (15, 10, 5))


def test_fused_is_linear():
    with pytest.raises(ValueError, match="cost fused is made from the arithmetic linear only, not thesis"):
        MatcherConfig(cost="fused")
    with pytest.raises(ValueError, match="blended"):
        MatcherConfig(cost="blended")


def test_in_use():
    """Labels in use: all by default, at least one, at most all."""
    assert MatcherConfig(disparities=6).labels_in_use == 6
    assert MatcherConfig(disparities=6, in_use=1).labels_in_use == 1
    for value in (0, 7, 2.0):
        with pytest.raises(ValueError, match=f"in_use must be a whole number from 1 to 6, not {value}"):
            MatcherConfig(disparities=6, in_use=value)

"""golden.config: limits, and widths worked by hand."""

import dataclasses
import re

import pytest

from golden.config import (
    FUSED_1,
    FUSED_2,
    FUSED_3,
    METHODS,
    Arithmetic,
    Engine,
    Fused,
    FusedCost,
    MatcherConfig,
    OnePass,
    Recursive,
    Vertical,
    Weights,
    changed,
    value_of,
)


@pytest.mark.parametrize("name, good, bad", [
    ("labels", (2, 256), (1, 257, -1, 16.5)),
    ("max_width", (1, 4096), (0, 4097)),
    ("minimum", (-64, 255), (-65, 256)),
])
def test_limits(name, good, bad):
    for value in good:
        assert getattr(MatcherConfig(**{name: value}), name) == value
    for value in bad:
        with pytest.raises(ValueError, match=rf"{name} must be a whole number from {good[0]} to {good[-1]}, not {value}"):
            MatcherConfig(**{name: value})


@pytest.mark.parametrize("name, good, bad", [("fraction_bits", (0, 4), (-1, 5)), *((f"u{n}", (0, 63), (-1, 64)) for n in (1, 2, 3))])
def test_one_pass_limits(name, good, bad):
    for value in good:
        assert value_of(changed(OnePass(), **{name: value}), name) == value
    for value in bad:
        with pytest.raises(ValueError, match=rf"{name} must be a whole number from {good[0]} to {good[-1]}, not {value}"):
            changed(OnePass(), **{name: value})


def test_arithmetic_is_an_enum():
    assert OnePass("linear").arithmetic is Arithmetic.LINEAR
    with pytest.raises(ValueError, match="decimal"):
        OnePass("decimal")


@pytest.mark.parametrize("method", [OnePass(), FUSED_1])
def test_frozen(method):
    with pytest.raises(dataclasses.FrozenInstanceError):
        MatcherConfig(method=method).labels = 3
    with pytest.raises(dataclasses.FrozenInstanceError):
        method.weights = Weights(1, 2, 3)


@pytest.mark.parametrize("arithmetic, expected", [
    # sub-pixel, cost, its bits, outside, factor of the cost in the energy
    ("float", (255, 1275, 11, 2047, 255)),
    ("thesis", (255, 1275, 11, 2047, 1)),
    ("linear", (510, 2550, 12, 4095, 8)),
])
def test_cost_numbers(arithmetic, expected):
    method = OnePass(arithmetic)
    cost = MatcherConfig(method=method).matching_cost
    assert (cost.sub_pixel_max, cost.inside_max, cost.bits, cost.outside, method.energy_scale) == expected


def test_energy_numbers():
    # THESIS: 2047 + 3 * 63 * 79. LINEAR, q = 3: 4095 * 8 + 3 * (2 * 63 * 8) * 79.
    assert MatcherConfig(80).energy_max == 16978
    linear = MatcherConfig(80, method=OnePass("linear"))
    assert (linear.method.slope_max, linear.energy_max, linear.energy_bits) == (1008, 271656, 19)


@pytest.mark.parametrize("arguments, message", [
    ({"labels": 80.0}, "labels must be a whole number from 2 to 256, not 80.0"),
    ({"engine": Engine.STREAMING},
     "engine streaming does not compute the method thesis in the arithmetic thesis; choose sequential"),
    ({"engine": "streaming", "method": OnePass(Arithmetic.FLOAT)},
     "engine streaming does not compute the method thesis in the arithmetic float; choose sequential"),
    ({"engine": "sequential", "method": FUSED_1},
     "engine sequential does not compute the method fused in the arithmetic linear; choose streaming"),
])
def test_what_no_matcher_can_be(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        MatcherConfig(**arguments)


def test_engine_by_default():
    """That of the method: no configuration names an engine that its method does not have."""
    assert [MatcherConfig(method=method).engine for method in (OnePass(), OnePass("linear"), FUSED_2)] == [
        Engine.SEQUENTIAL, Engine.SEQUENTIAL, Engine.STREAMING]
    assert MatcherConfig(engine="streaming", method=OnePass("linear")).engine is Engine.STREAMING


@pytest.mark.parametrize("method, name", [
    (OnePass(), "reach"), (OnePass(), "sub_pixel"), (FUSED_1, "fraction_bits"), (FUSED_1, "arithmetic"), (FUSED_1, "u4")])
def test_parameters_of_another_method(method, name):
    """Refused by name, whether given to the method or as a change of it."""
    with pytest.raises(ValueError, match=f"{name} is no parameter of the method {method.name}; those are "):
        changed(method, **{name: 1})
    with pytest.raises(TypeError, match=name):
        type(method)(**{name: 1})
    with pytest.raises(TypeError, match=name):
        MatcherConfig(**{name: 1})


def test_method_as():
    assert MatcherConfig(method=FUSED_2).method_as(Fused) is FUSED_2
    with pytest.raises(ValueError, match="the method must be fused, not thesis"):
        MatcherConfig().method_as(Fused)
    assert METHODS == {"thesis": OnePass, "fused": Fused, "recursive": Recursive}


def test_refined():
    for method in (FUSED_2, Recursive()):
        assert MatcherConfig(method=method).refined is method
    with pytest.raises(ValueError, match="the method must refine its labels, and thesis does not"):
        _ = MatcherConfig().refined


def test_changed():
    """Single parameters, whichever part holds them, and whole parts; all else stays."""
    method = changed(FUSED_1, reach=3, u2=9, truncation=100, fill=False, vertical=Vertical(vertical_threshold=7))
    assert (method.arms.reach, method.weights, method.cost.truncation, method.vertical.vertical_threshold) == (3, (17, 9, 22), 100, 7)
    assert not method.refinement.fill and method.refinement.median
    assert changed(method, reach=16, u2=30, truncation=156, fill=True, vertical_threshold=10) == FUSED_1


def test_fused_1():
    # Section by section of the method: cost, census, support, vertical support, weights in eighths, check and median.
    assert [value_of(FUSED_1, name) for name in Fused.LIMITS] == [156, 4, 47, 4, 30, 5, 7, 10, 16, 0, 10, 17, 30, 22, 3, 1, 5]
    assert Fused() == FUSED_1


def test_four_bits():
    assert FUSED_2.vertical and FUSED_2.cost.maximum.bit_length() == 4  # eight of them in a memory block's word
    assert not FUSED_3.vertical and FUSED_3.cost.maximum.bit_length() == 4 and FUSED_3.data_max.bit_length() == 9


@pytest.mark.parametrize("name", Fused.LIMITS)
def test_fused_limits(name):
    limits = Fused.LIMITS[name]
    others = {"truncation": 100, "cost_factor": 1, "census_weight": 1}  # so that each greatest value has a cost that fits
    for value in (limits[0], limits[-1]):
        shift = {} if name == "cost_shift" else {"cost_shift": 7}
        low = {"cost_outside": 3} if name == "vertical_lines" else {}
        assert value_of(changed(FUSED_1, **{**others, **shift, **low, name: value}), name) == value
    for value in (limits[0] - limits.step, limits[-1] + limits.step, limits[0] + 0.5, *([limits[0] + 1] if limits.step == 2 else [])):
        with pytest.raises(ValueError, match=rf"{name} must be an? (odd )?whole number from {limits[0]} to {limits[-1]}, not {value}"):
            changed(FUSED_1, **{name: value})


def test_fused_cost_fits_its_bits():
    # 47 * 34 = 1598; (4 * 624 + 1598) >> 4 = 4094 >> 4 = 255; with 625 it is 4098 >> 4 = 256.
    assert changed(FUSED_1, truncation=624).cost.maximum == 255 == FusedCost.MAX
    with pytest.raises(ValueError, match="the fused cost reaches 256, more than the 255 that its 8 bits hold"):
        changed(FUSED_1, truncation=625)
    assert FusedCost(cost_factor=0, census_weight=0).maximum == 30  # outside


def test_fused_numbers():
    config = MatcherConfig(80, method=FUSED_1)
    method = config.method
    assert (method.cost.maximum, method.arms.support_max, method.data_max) == (138, 33, 4554)
    # Slopes reach 33 * 63; energies 4554 * 8 + 3 * 2079 * 79. The costs E are those of LINEAR.
    assert (method.slope_max, method.energy_shift, config.energy_max, config.energy_bits) == (2079, 3, 529155, 20)
    assert (config.matching_cost.inside_max, method.weights, OnePass().weights) == (2550, (17, 30, 22), (15, 10, 5))


def test_in_use():
    """Labels in use: all by default, at least one, at most all."""
    assert MatcherConfig(6).labels_in_use == 6
    assert MatcherConfig(6, in_use=1).labels_in_use == 1
    for value in (0, 7, 2.0):
        with pytest.raises(ValueError, match=f"in_use must be a whole number from 1 to 6, not {value}"):
            MatcherConfig(6, in_use=value)


@pytest.mark.parametrize("config, fields", [
    (MatcherConfig(80), {"disparity": 7}), (MatcherConfig(2), {"disparity": 1}),
    # 79 + 255 pixels at most, in eighths up to the next pixel.
    (MatcherConfig(80, method=FUSED_1), {"disparity": 9, "passed": 1, "confidence": 4}),
    (MatcherConfig(80, method=changed(FUSED_1, sub_pixel=True)), {"disparity": 12, "passed": 1, "confidence": 4}),
])
def test_result_fields(config, fields):
    assert config.result_fields == fields


def test_settings():
    """Names, widths and defaults, in the order of the gateware's ports; set, they are the golden model's parameters."""
    config = MatcherConfig(6, in_use=5, method=OnePass(weights=(1, 2, 63)))
    assert {name: (setting.bits, setting.default) for name, setting in config.settings.items()} == {
        "u1": (6, 1), "u2": (6, 2), "u3": (6, 63), "in_use": (9, 5)}
    assert config.with_settings({"u2": 7, "in_use": 3}) == MatcherConfig(6, in_use=3, method=OnePass(weights=(1, 7, 63)))
    assert config.with_settings({}) == config
    fused = MatcherConfig(6, minimum=9, method=changed(FUSED_1, fill=False))
    assert {name: (setting.bits, setting.default) for name, setting in fused.settings.items()} == {
        "u1": (6, 17), "u2": (6, 30), "u3": (6, 22), "in_use": (9, 6), "minimum": (8, 9), "check": (1, 1), "fill": (1, 0), "median": (1, 1)}
    assert fused.with_settings({"minimum": 0, "fill": 1, "check": 0, "u1": 3}) == MatcherConfig(
        6, method=changed(FUSED_1, check=False, u1=3))

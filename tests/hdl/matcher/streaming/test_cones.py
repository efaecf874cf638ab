import itertools

import numpy as np
import pytest

from golden.config import FUSED_1, WEIGHT_MAX, Arithmetic, Fused, MatcherConfig, OnePass, changed
from golden.matcher.smooth import cones, slope
from hdl.matcher.streaming.cones import Cones
from sim.kit.clocked import run_clocked


def linear(labels, fraction_bits):
    return MatcherConfig(labels, method=OnePass(Arithmetic.LINEAR, fraction_bits))


def fused(labels, reach):
    return MatcherConfig(labels, method=changed(FUSED_1, reach=reach))


def neighbours(labels, count, rng):
    """Random pixels, then every corner: equal and opposite grey levels, outermost labels, each set of absent neighbours."""
    grey = rng.integers(0, 256, (count, 4)).tolist()
    label = rng.integers(0, labels, (count, 2)).tolist()
    present = rng.integers(0, 2, (count, 3)).tolist()
    corners = itertools.product([[0, 0, 0, 0], [0, 255, 255, 255], [255, 0, 255, 0]],
                                itertools.product([0, labels - 1], repeat=2), itertools.product([0, 1], repeat=3))
    for greys, (upper, lower), (has_left, has_upper, has_lower) in [*zip(grey, label, present), *corners]:
        yield {"pixel": greys[0], "left": greys[1], "upper": greys[2], "lower": greys[3], "has_left": has_left, "has_upper": has_upper,
               "has_lower": has_lower, "upper_label": upper, "lower_label": lower}


@pytest.mark.parametrize("weights", [(15, 10, 5), (WEIGHT_MAX,) * 3, (0, 1, 62)], ids=str)
@pytest.mark.parametrize("config", [
    *(linear(labels, fraction_bits) for labels, fraction_bits in [(2, 0), (3, 4), (13, 3), (80, 3), (256, 4)]),
    *(fused(labels, reach) for labels, reach in [(2, 0), (3, 7), (13, 3), (80, 16), (128, 31)]),
], ids=lambda config: f"{config.method.name}-{config.labels}")
def test_matches_golden(config, weights):
    labels = config.labels
    pixels = list(neighbours(labels, 40, np.random.default_rng(1)))
    size_max = 0
    if isinstance(config.method, Fused):
        size_max = config.method.arms.support_max
        # The size of the support; of the last pixel the greatest, which has a corner of the rest too.
        sizes = np.random.default_rng(2).integers(1, size_max + 1, len(pixels)).tolist()
        pixels = [pixel | {"size": n} for pixel, n in zip(pixels, sizes)]
        pixels += [pixel | {"size": size_max} for pixel in pixels[-96:]]
    dut = Cones(config, size_max)
    latency = Cones.latency_of(config, size_max)
    out = run_clocked(dut, [{"i": pixel, "weights": list(weights)} for pixel in pixels], ["up", "down"], drain=latency)

    for pixel, waves in zip(pixels, out[latency:], strict=True):
        w1, w2, w3 = (
            int(slope(np.array(abs(pixel["pixel"] - pixel[name])), weight, config)) * pixel.get("size", 1) if pixel[f"has_{name}"] else 0
            for weight, name in zip(weights, ("left", "upper", "lower")))
        upper = pixel["upper_label"] if pixel["has_upper"] else 0
        expected = cones(upper, pixel["lower_label"], w1, w2, w3, config).tolist()
        # What the cells make of the wave.
        up, cone, walked = waves["up"], waves["up"].cone, []
        step, rise, at_low, at_high = up.step, up.rise, up.at_low, up.at_high
        for label in range(labels):
            walked.append(cone - config.smooth_max)
            cone, step = cone + step, step + 2 * rise
            rise = up.low_rise if at_low else up.high_rise if at_high else 0
            at_low, at_high = up.low == label + 3, up.high == label + 3
        assert walked == expected
        assert (waves["down"].step, waves["down"].ramp) == (2 * w1, 2 * w1 * (labels - 1))

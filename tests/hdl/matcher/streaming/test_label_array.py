import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.labelling import transition
from golden.matcher.smooth import cones
from hdl.matcher.streaming.label_array import LabelArray
from sim.kit.clocked import run_clocked


def waves_of(upper, lower, w1, w2, w3, config):
    """The waves that :class:`hdl.matcher.streaming.cones.Cones` sends."""
    low, high = min(upper, lower), max(upper, lower)
    rises = (w2 + w3, 0) if upper == lower else (w2, w3) if upper < lower else (w3, w2)

    def rise(label):
        return rises[0] if label == low else rises[1] if label == high else 0

    return {
        "up": {"cone": w2 * upper + w3 * lower + config.smooth_max, "step": -w2 - w3 - w1 + 2 * rise(0), "rise": rise(1),
               "low_rise": rises[0], "high_rise": rises[1], "low": low, "high": high, "at_low": low == 2, "at_high": high == 2},
        "down": {"ramp": 2 * w1 * (config.labels - 1), "step": 2 * w1},
    }


def cases(config, count, rng):
    """Costs, vertices and slopes: random; few values, so that ties abound; the extremes."""
    labels, most, steep = config.labels, config.matching_cost.outside, config.rule.slope_max
    for kind in range(count):
        match kind % 5:
            case 0:
                cost, slopes = rng.integers(0, config.matching_cost.inside_max + 1, labels), rng.integers(0, steep + 1, 3)
            case 1:
                cost, slopes = rng.integers(0, 3, labels), rng.integers(0, 2, 3) << config.method.fraction_bits
            case 2:
                cost, slopes = np.full(labels, int(rng.integers(0, most + 1))), np.zeros(3, dtype=int)
            case 3:
                cost, slopes = np.full(labels, most), rng.choice([0, steep], 3)
                cost[rng.integers(0, labels)] = 0
            case _:
                cost, slopes = np.full(labels, most), np.array([0, 0, 0])
                cost[-1] = most - 1  # the last label wins for all
        yield cost.tolist(), *rng.choice([0, labels - 1, int(rng.integers(0, labels))], 2).tolist(), *slopes.tolist()


@pytest.mark.parametrize("labels, fraction_bits", [(2, 0), (3, 3), (5, 4), (6, 3), (13, 3), (41, 1)])
def test_matches_golden(labels, fraction_bits):
    config = MatcherConfig(labels=labels, method=OnePass(Arithmetic.LINEAR, fraction_bits))
    pixels = list(cases(config, 100, np.random.default_rng(labels)))
    dut = LabelArray(config)

    # Label d reads its cost d cycles after the wave started.
    complement = (config.matching_cost.outside - np.array([pixel[0] for pixel in pixels])).tolist()
    inputs = []
    for cycle, (_, upper, lower, *slopes) in enumerate(pixels):
        skewed = [complement[cycle - d][d] if cycle >= d else 0 for d in range(labels)]
        inputs.append({**waves_of(upper, lower, *slopes, config), "cost": skewed})
    for cycle in range(len(pixels), len(pixels) + dut.latency):
        inputs.append({"cost": [complement[cycle - d][d] if 0 <= cycle - d < len(pixels) else 0 for d in range(labels)]})
    out = run_clocked(dut, inputs, ["transition"])

    winners = set()
    for (cost, upper, lower, w1, w2, w3), cycle in zip(pixels, out[dut.latency:], strict=True):
        # With the ramp taken out again: the energy without the left neighbour's term.
        ramp = w1 * np.arange(labels)
        energy = (np.array(cost) << config.rule.energy_shift) + cones(upper, lower, w1, w2, w3, config) + ramp
        expected = transition(energy, w1)
        got = [cycle["transition"][p] for p in range(labels)]
        assert got == expected.tolist()
        assert (np.diff(got) >= 0).all()                    # monotone
        assert [got[label] for label in got] == got         # idempotent
        winners |= set(got)
    assert {0, labels - 1} <= winners

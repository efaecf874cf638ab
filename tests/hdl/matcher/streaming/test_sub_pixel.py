import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig
from golden.matcher.sub_pixel import fraction, neighbouring_sums
from hdl.matcher.streaming.sub_pixel import FractionCell, SubPixel
from sim.kit.clocked import run_clocked


def config_of(labels):
    return MatcherConfig(labels=labels, method=FUSED_1)


def sums_of(labels, count, rng, most):
    """Random; few values, so that ties abound; valleys and summits; the extremes."""
    for kind in range(count):
        match kind % 4:
            case 0:
                yield rng.integers(0, most + 1, labels)
            case 1:
                yield rng.integers(0, 4, labels)
            case 2:
                yield np.abs(np.arange(labels) * 8 - rng.integers(0, 8 * labels)) * int(rng.integers(1, 5))
            case _:
                yield rng.choice([0, most], labels)


def test_fraction_cell():
    config = config_of(3)
    rng = np.random.default_rng(1)
    # Both neighbours by all small steps above the label: eight times their difference is just a multiple, or one off it.
    steps = np.array([(before, 0, after) for before in range(17) for after in range(17)]) + 5
    sums = np.concatenate([list(sums_of(3, 2000, rng, config.method.data_max)), steps])
    complement = 2**config.data_bits - 1 - sums
    out = run_clocked(FractionCell(config), [dict(zip(("before", "centre", "after"), row)) for row in complement.tolist()], ["fraction"],
                      drain=FractionCell.LATENCY)
    expected = fraction(*sums.T)
    assert [word["fraction"] for word in out[FractionCell.LATENCY:]] == expected.tolist()
    assert set(expected.tolist()) == set(range(-4, 5))


@pytest.mark.parametrize("labels, latency", [(2, 9), (3, 9), (13, 29), (40, 83)])
def test_label_chosen(labels, latency):
    """Pixels in a row, each label read a cycle after the one below it; the fraction of one label of each."""
    config = config_of(labels)
    rng = np.random.default_rng(2)
    count = 120
    sums = np.array(list(sums_of(labels, count, rng, config.method.data_max)))
    complement = (2**config.data_bits - 1 - sums).tolist()
    chosen = [*range(labels), *rng.integers(0, labels, count).tolist()][:count]
    inputs = []
    for cycle in range(count + latency + 1):
        skewed = [complement[cycle - d][d] if 0 <= cycle - d < count else 0 for d in range(labels)]
        pixel = cycle - latency
        inputs.append({"sums": skewed, "label": chosen[pixel] if 0 <= pixel < count else 0})
    out = run_clocked(SubPixel(config, latency), inputs, ["fraction"])
    label = np.array(chosen)
    inside = (label > 0) & (label < labels - 1)
    expected = np.where(inside, fraction(*neighbouring_sums(sums, label)), 0)
    assert [out[pixel + latency + 1]["fraction"] for pixel in range(count)] == expected.tolist()

"""hdl.matcher.recursive: the line below and the costs from above, group by group, against the golden model."""

import numpy as np
import pytest

from golden.config import RECURSIVE_1, MatcherConfig, changed
from golden.matcher.recursive.line_below import line_below
from golden.matcher.recursive.neighbours import from_above
from golden.matcher.recursive.spread import spread
from hdl.matcher.recursive.carried import CarriedGroup
from hdl.matcher.recursive.group import LineBelowGroup
from sim.kit.clocked import run_clocked


@pytest.mark.parametrize("own, lower", [(5, 4), (1, 0), (7, 7)])
def test_line_below(own, lower):
    """Two lines of costs in a row: as the second one arrives, the first is joined with it."""
    config = MatcherConfig(3, 9, method=changed(RECURSIVE_1, own_share=own, lower_share=lower))
    rng = np.random.default_rng(own)
    cost, left = rng.integers(0, 16, (2, 9, 3), dtype=np.uint8), rng.integers(0, 60, (2, 9))
    expected = line_below(cost, left, config.method.line_below)[0]
    alike = np.abs(left[1] - left[0]) <= config.method.line_below.lower_threshold
    idle = {"i": {"column": 0, "write": 0, "below": 0}}
    inputs = [{"i": {"column": x, "write": 1, "below": int(alike[x])}, "cost": cost[y, x].tolist()} for y in range(2) for x in range(9)]
    inputs[9:9] = [idle] * 3
    dut = LineBelowGroup(config, range(3))
    out = run_clocked(dut, inputs, ["own"], idle=idle, drain=dut.LATENCY)
    given = [[word["own"][n] for n in range(3)] for word in out[12 + dut.LATENCY:]]
    np.testing.assert_array_equal(given, expected)


@pytest.mark.parametrize("fan, labels", [(3, 2), (3, 4), (8, 3)])
def test_costs_from_above(fan, labels):
    """A line of costs is written; then the steps of the next line read, spread and gate them."""
    method = changed(RECURSIVE_1, fan=fan)
    width = 20
    config = MatcherConfig(labels, width, method=method)
    rng = np.random.default_rng(fan + labels)
    cost = rng.integers(0, method.data_max + 1, (width, labels))
    gates = rng.integers(0, method.carried_max + 1, (3, width))
    least = cost.min(axis=1)
    silent = {"write": 0, "address": 0, "limits": {"least": 0, "limit": 0}, "place": 0,
              "taps": dict.fromkeys(("advance", "place", "opens", "edge", "has_above", "centre", "left", "right"), 0)}
    inputs = [{**silent, "write": 1, "column": x, "cost": cost[x].tolist()} for x in range(width)]
    inputs += [{key: {**value} if isinstance(value, dict) else value for key, value in silent.items()} for _ in range(width + fan + 12)]
    for step in range(-fan, width):         # the column that is completed in the cycle of the centre tap
        at, ahead = width + step + fan, min(step + fan, width - 1)
        inputs[at]["address"] = ahead
        inputs[at + 3]["limits"] = {"least": int(least[ahead]), "limit": int(least[ahead]) + method.propagation.spread_jump}
        inputs[at + 5]["place"] = (step + fan) % fan
        shown = max(step, 0)
        inputs[at + 7]["taps"] = {"advance": 1, "place": (step + fan) % fan, "opens": int(step <= 0), "edge": int(step < fan),
                                  "has_above": 1, **{name: int(gates[n, shown]) for n, name in enumerate(("centre", "left", "right"))}}
    dut = CarriedGroup(config, range(labels))
    out = run_clocked(dut, inputs, ["above"])
    given = [[out[width + fan + x + dut.ABOVE]["above"][n] for n in range(labels)] for x in range(width)]

    carried = spread(cost, method.propagation)
    column = np.arange(width)
    taps = carried, carried[np.maximum(column - fan, 0)], carried[np.minimum(column + fan, width - 1)]
    gated = [np.minimum(tap, gate[:, None]) for tap, gate in zip(taps, gates)]
    np.testing.assert_array_equal(given, (2 * gated[0] + gated[1] + gated[2]) >> 2)
    for word in inputs:  # on the first line nothing is carried, whatever is there
        word["taps"]["has_above"] = 0
    assert not any(word["above"][n] for word in run_clocked(CarriedGroup(config, range(labels)), inputs, ["above"]) for n in range(labels))
    # The golden model has the gates from grey levels: with open gates it gives the same.
    flat = np.zeros(width, dtype=int)
    open_gates = [np.minimum(tap, method.propagation.gate[0]) for tap in taps]
    np.testing.assert_array_equal(from_above(carried, flat, flat, method), (2 * open_gates[0] + open_gates[1] + open_gates[2]) >> 2)

"""hdl.matcher.recursive: the line below, means, the costs from above and from below, group by group, against the golden model."""

import numpy as np
import pytest

from golden.config import RECURSIVE_1, RECURSIVE_2, MatcherConfig, changed
from golden.matcher.recursive.arms import support_means
from golden.matcher.recursive.line_below import line_below
from golden.matcher.recursive.neighbours import from_above
from golden.matcher.recursive.spread import spread
from hdl.matcher.recursive.carried import CarriedGroup
from hdl.matcher.recursive.from_below import FromBelowGroup
from hdl.matcher.recursive.line_below import LineBelowGroup
from hdl.matcher.recursive.mean import MeanGroup
from hdl.matcher.recursive.source import SLOTS
from hdl.matcher.recursive.support import Supports
from sim.kit.clocked import run_clocked


@pytest.mark.parametrize("own, lower", [(5, 4), (1, 0), (7, 7)])
@pytest.mark.parametrize("from_below", [False, True])
def test_line_below(own, lower, from_below):
    """Lines of costs in a row: as one arrives, the one above is joined with it, and that above with this one once more."""
    config = MatcherConfig(3, 9, method=changed(RECURSIVE_1, own_share=own, lower_share=lower, from_below=from_below))
    rng = np.random.default_rng(own)
    lines, width, pause = 4, 9, 4
    cost, left = rng.integers(0, 16, (lines, width, 3), dtype=np.uint8), rng.integers(0, 60, (lines, width))
    expected = line_below(cost, left, config.method.line_below)
    alike = np.abs(np.diff(left, axis=0, prepend=0)) <= config.method.line_below.lower_threshold
    upper = {"upper_below": 0} if from_below else {}
    idle = {"i": {"column": 0, "write": 0, "below": 0, **upper}}
    inputs = []
    for y in range(lines):
        for x in range(width):
            more = {"upper_below": int(alike[max(y - 1, 0), x])} if from_below else {}
            inputs.append({"i": {"column": x, "write": 1, "below": int(alike[y, x]), **more}})
        inputs += [{**idle} for _ in range(pause)]
    dut = LineBelowGroup(config, range(3))
    for y, x in np.ndindex(lines, width):
        inputs[y * (width + pause) + x + dut.COST]["cost"] = cost[y, x].tolist()
    ports = ["own", "upper_own"] if from_below else ["own"]
    out = run_clocked(dut, inputs, ports, idle=idle, drain=dut.LATENCY)
    for port, later in zip(ports, (1, 2)):
        for y in range(lines - later):
            at = (y + later) * (width + pause) + dut.LATENCY
            given = [[word[port][n] for n in range(3)] for word in out[at:at + width]]
            np.testing.assert_array_equal(given, expected[y])


@pytest.mark.parametrize("soft_multipliers", [False, True])
@pytest.mark.parametrize("reach", [0, 2, 16])
def test_mean(reach, soft_multipliers):
    """Costs of a line, the greatest among them, are summed; supports of all lengths are averaged as soon as their last pixel is there."""
    config = MatcherConfig(3, 60, method=changed(RECURSIVE_1, reach=reach, soft_multipliers=soft_multipliers))
    rng = np.random.default_rng(reach)
    width, cost_max = 60, config.method.joined_max
    cost = np.where(rng.random((width, 3)) < 0.5, cost_max, rng.integers(0, cost_max + 1, (width, 3)))
    column = np.arange(width)
    left_arm, right_arm = (np.minimum(rng.integers(0, reach + 1, width), room) for room in (column, width - 1 - column))
    expected = support_means(cost, left_arm, right_arm)
    ring, start = Supports.ring_of(config), 5
    silent = {"sums": {"enter": 0, "clear": 0, "place": 0}, "ends": {"low": 0, "high": 0, "reciprocal": 0}}
    dut = MeanGroup(config, range(3), cost_max)
    inputs = [{**silent, "cost": [0] * 3} for _ in range(width + 2 * reach + 10)]
    # The word before a line clears the sum; the one behind it keeps the last sum.
    for n in range(-1, width + reach + 2):
        inputs[1 + n]["sums"] = {"enter": 1, "clear": int(n < 0), "place": (start + n) % ring}
        if 0 <= n < width:
            inputs[1 + n]["cost"] = cost[n].tolist()
    for x in range(width):
        inputs[x + reach + 3]["ends"] = {
            "low": int(start + x - left_arm[x]) % ring, "high": int(start + x + right_arm[x] + 1) % ring,
            "reciprocal": 1024 // int(left_arm[x] + right_arm[x] + 1)}
    out = run_clocked(dut, inputs, ["o"], drain=dut.latency_of(config))
    given = [[out[x + reach + 3 + dut.latency_of(config)]["o"][n] for n in range(3)] for x in range(width)]
    np.testing.assert_array_equal(given, expected)


@pytest.mark.parametrize("share", [0, 4, 15])
@pytest.mark.parametrize("labels", [2, 5])
def test_costs_from_below(labels, share):
    """Means and a pixel's own costs are kept by slots; read, spread, gated, and their share is added."""
    config = MatcherConfig(labels, 20, method=RECURSIVE_2)
    method = config.method
    rng = np.random.default_rng(labels + share)
    count = 40
    slots = (np.arange(count) + SLOTS - 10) % SLOTS                 # around the end of the rings
    mean, own = (rng.integers(0, method.own_max + 1, (count, labels)) for _ in range(2))
    gate, exists = rng.integers(0, method.carried_max + 1, count), rng.random(count) < 0.8
    dut = FromBelowGroup(config, range(labels))
    silent = {"write": {"write": 0, "slot": 0}, "own_write": {"tick": 0, "slot": 0}, "address": 0, "own_address": 0, "share": 0,
              "least": 0, "gate": {"exists": 0, "gate": 0}}
    inputs = [{**silent} for _ in range(2 * count + dut.LATENCY)]
    for n, slot in enumerate(slots.tolist()):
        inputs[n] |= {"write": {"write": 1, "slot": slot}, "mean": mean[n].tolist(),
                      "own_write": {"tick": 1, "slot": slot}, "own": own[n].tolist()}
        at = count + n
        inputs[at]["address"] = slot
        inputs[at + dut.LEAST]["least"] = int(mean[n].min())
        inputs[at + dut.GATE]["gate"] = {"exists": int(exists[n]), "gate": int(gate[n])}
        inputs[at + dut.OWN] |= {"own_address": slot, "share": share}
    out = run_clocked(dut, inputs, ["o"], drain=2)
    given = [[out[count + n + dut.LATENCY]["o"][label] for label in range(labels)] for n in range(count)]
    low = np.where(exists[:, None], np.minimum(spread(mean, method.propagation), gate[:, None]), 0)
    np.testing.assert_array_equal(given, own + (share * low >> 3))


@pytest.mark.parametrize("fan, labels", [(3, 2), (3, 4), (8, 3), (8, 8)])
def test_costs_from_above(fan, labels):
    """A line of costs is written; then the steps of the next line read, spread and gate them."""
    method = changed(RECURSIVE_1, fan=fan)
    width = 20
    config = MatcherConfig(labels, width, method=method)
    rng = np.random.default_rng(fan + labels)
    cost = rng.integers(0, method.data_max + 1, (width, labels))
    gates = rng.integers(0, method.carried_max + 1, (3, width))
    least = cost.min(axis=1)
    silent = {"write": 0, "address": 0, "least": 0, "place": 0,
              "taps": dict.fromkeys(("advance", "place", "opens", "edge", "has_above", "centre", "left", "right"), 0)}
    inputs = [{**silent, "write": 1, "column": x, "cost": cost[x].tolist()} for x in range(width)]
    inputs += [{key: {**value} if isinstance(value, dict) else value for key, value in silent.items()} for _ in range(width + fan + 13)]
    for step in range(-fan, width):         # the column that is completed in the cycle of the centre tap
        at, ahead = width + step + fan, min(step + fan, width - 1)
        inputs[at]["address"] = ahead
        inputs[at + CarriedGroup.LEAST]["least"] = int(least[ahead])
        inputs[at + CarriedGroup.PLACE]["place"] = (step + fan) % fan
        shown = max(step, 0)
        inputs[at + CarriedGroup.TAPS]["taps"] = {
            "advance": 1, "place": (step + fan) % fan, "opens": int(step <= 0), "edge": int(step < fan), "has_above": 1,
            **{name: int(gates[n, shown]) for n, name in enumerate(("centre", "left", "right"))}}
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

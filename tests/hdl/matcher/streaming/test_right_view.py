import numpy as np
import pytest
from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.refine import check, right_view
from hdl.matcher.streaming.right_view import LeftRightCheck, RightCell, RightWave
from hdl.matcher.streaming.waves import Completion
from sim.kit.clocked import run_clocked


def config_of(labels, width, minimum=0, tolerance=1):
    return MatcherConfig(labels=labels, max_width=width, minimum=minimum, method=changed(FUSED_1, tolerance=tolerance))


@pytest.mark.parametrize("labels, width, minimum, tolerance", [
    (2, 1, 0, 1), (2, 5, 0, 0), (13, 20, 0, 1), (13, 20, 3, 1), (16, 9, 0, 7), (80, 100, 0, 1), (80, 100, 255, 1), (128, 200, 37, 2),
])
def test_check(labels, width, minimum, tolerance):
    """Right labels are written up to a line before they are read, as far as the memory reaches; frames in a row, one of them unchecked."""
    config = config_of(labels, width, minimum, tolerance)
    rng = np.random.default_rng(1)
    height = 3
    expected, questions, answers = [], [], []
    for enable in (1, 0, 1):
        left = rng.integers(0, labels, (height, width))
        # In the delayed picture's columns: what golden has at x - minimum.
        seen = rng.integers(0, labels, (height, width))
        matched = np.arange(width) - left - minimum
        near = np.clip(left + rng.integers(-tolerance - 1, tolerance + 2, left.shape), 0, labels - 1)
        for y, x in np.argwhere(matched >= 0):
            seen[y, matched[y, x]] = near[y, x]
        passed = check(left, seen, config)
        expected += (passed | (not enable)).ravel().tolist()
        delayed = np.concatenate([np.zeros((height, min(minimum, width)), dtype=int), seen[:, :max(width - minimum, 0)]], axis=1)
        answers += delayed.ravel().tolist()
        questions += [{"x": x, "label": int(left[y, x]), "enable": enable, "minimum": minimum} for y in range(height) for x in range(width)]
    if width > 2 * labels and not minimum:
        assert 0.1 < np.mean(expected) < 0.9

    # The memory holds `depth` labels: as many as may be written between that of a pixel and its check, and the labels to its left.
    depth = width + labels
    dut = LeftRightCheck(config, depth)
    inputs, checked, written = [], [], 0
    while len(checked) < len(questions):
        cycle = {"right_valid": 0, "valid": 0}
        if written < len(answers) and written - len(checked) < depth - labels and rng.random() < 0.8:
            cycle |= {"right_valid": 1, "right": answers[written]}
        if len(checked) + 1 <= written and (written - len(checked) >= width or written == len(answers)) and rng.random() < 0.8:
            cycle |= {"valid": 1, **questions[len(checked)]}
            checked.append(len(inputs))
        written += cycle["right_valid"]
        inputs.append(cycle)
    out = run_clocked(dut, inputs, ["passed"], drain=dut.LATENCY, idle={"right_valid": 0, "valid": 0})
    assert [out[cycle + dut.LATENCY]["passed"] for cycle in checked] == expected


class Cells(wiring.Component):
    """The cells of all labels; all see a pixel's costs in the same cycle."""
    def __init__(self, config):
        self.cells = [RightCell(config, label) for label in range(config.labels)]
        super().__init__({"completion": In(Completion(config)), "o": Out(RightWave(config)),
                          "costs": In(data.ArrayLayout(range(config.refined.view_max + 1), config.labels))})

    def elaborate(self, platform):
        m = Module()
        for label, cell in enumerate(self.cells):
            m.submodules[f"cell_{label}"] = cell
            m.d.comb += [cell.completion.eq(self.completion), cell.cost.eq(self.costs[label])]
            if label:
                m.d.comb += cell.i.eq(self.cells[label - 1].o)
        m.d.comb += self.o.eq(self.cells[-1].o)
        return m


@pytest.mark.parametrize("labels, width, minimum, largest", [(2, 1, 0, 64), (5, 9, 0, 64), (5, 3, 0, 30), (4, 7, -2, 64), (8, 4, -5, 32)])
def test_cells(labels, width, minimum, largest):
    """Lines in a row with cycles between their pixels: labels, and that of flush cycles nothing counts.

    The largest cost is a power of two and wins where every candidate has it.
    """
    config = MatcherConfig(labels=labels, max_width=width, minimum=minimum, method=changed(
        FUSED_1, cost_outside=largest, census_weight=0, truncation=largest, cost_factor=1, cost_shift=0))
    assert config.refined.view_max == largest
    rng = np.random.default_rng(3)
    height = 6
    costs = rng.choice([largest, largest, largest - 1, 1, 0], (height, width, labels))
    inputs, expected = [], []

    def step(**completion):
        inputs.append({"completion": {"clear": 0, **completion}, "costs": costs[y, max(x, 0)].tolist()})
        for _ in range(int(rng.integers(3))):
            noise = {name: int(rng.integers(2)) for name in completion}
            inputs.append({"completion": {"clear": 0, **noise, "complete": 0, **({"leads": 0} if config.lead else {})},
                           "costs": rng.integers(0, largest + 1, labels).tolist()})

    for y in range(height):
        for x in range(-config.lead, width):
            lead = {"leads": int(x < 0), "closes": int(x == -config.lead)} if config.lead else {}
            step(complete=int(x >= 0), starts_line=int(x == 0), in_picture=1, **lead)
        expected += right_view(costs[y:y + 1].astype(np.uint8), config)[0].tolist()
    for _ in range(labels + config.lead):
        step(complete=1, starts_line=1, in_picture=0, **({"leads": 0, "closes": 1} if config.lead else {}))

    out = run_clocked(Cells(config), inputs, ["o"], drain=1, idle={"completion": {"complete": 0}})
    advanced = [number for number, cycle in enumerate(inputs) if cycle["completion"]["complete"] or cycle["completion"].get("leads")]
    given = [out[number + 1]["o"] for number in advanced]
    assert [int(word.least.index) for word in given if word.in_picture] == expected

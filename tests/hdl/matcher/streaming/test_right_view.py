import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.refine import check
from hdl.matcher.streaming.right_view import LeftRightCheck
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

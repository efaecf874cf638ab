import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, changed
from hdl.video.shown_label import ShownLabel
from sim.kit.clocked import run_clocked


@pytest.mark.parametrize("sub_pixel", [False, True])
@pytest.mark.parametrize("labels, minima", [(2, [7, 0, 255, 3, 200]), (13, [-12, 0, 255, -1, -3]), (128, [-64, 200, -63, 0, -20])])
def test_label(labels, minima, sub_pixel):
    """Each picture is shown by the least disparity that its pair started with, though the next pair starts before it has left."""
    config = MatcherConfig(labels=labels, minimum=minima[0], method=changed(FUSED_1, sub_pixel=sub_pixel))
    scale = config.method.disparity_scale
    rng = np.random.default_rng(1)
    inputs, expected = [], []
    for number, minimum in enumerate(minima):
        shown = [0, labels - 1, *rng.integers(0, labels, 10).tolist()]
        for place, label in enumerate(shown):
            # A fraction upwards keeps its label, one downwards belongs to the label below; the outermost have none.
            fraction = int(rng.integers(-4, 5)) if sub_pixel and 0 < label < labels - 1 else 0
            word = {"i": {"disparity": (minimum + label) * scale + fraction, "first": int(place == 0)}, "start": 0}
            # The word waits; what stands at the input while no pair starts does not count. The next pair starts in the midst.
            waits = [{**word, "step": 0, "minimum": int(rng.integers(256))} for _ in range(int(rng.integers(3)))]
            inputs += [*waits, {**word, "step": 1, "minimum": int(rng.integers(256))}]
            expected += [label - (fraction < 0)] * (len(waits) + 1)
            if place == 5 and number + 1 < len(minima):
                inputs.append({**word, "i": {"disparity": 0, "first": 0}, "step": 0, "start": 1, "minimum": minima[number + 1]})
                # No word there: what stands at its place is not taken for the first one of the next picture.
                inputs.append({**word, "i": {"disparity": 0, "first": 1}, "step": 0})
                expected += [None, None]
    out = run_clocked(ShownLabel(config), inputs, ["label"])
    assert [(word["label"] if label is not None else None) for word, label in zip(out, expected, strict=True)] == expected


def test_label_without_a_setting():
    """A method whose least disparity is not a setting: the label is the disparity, whatever pair starts."""
    config = MatcherConfig(labels=20)
    rng = np.random.default_rng(1)
    labels = rng.integers(0, 20, 50).tolist()
    dut = ShownLabel(config)
    inputs = [{"i": {"disparity": label, "first": int(rng.integers(2))}, "start": int(rng.integers(2)), "step": 1} for label in labels]
    assert "minimum" not in dut.signature.members
    assert [cycle["label"] for cycle in run_clocked(dut, inputs, ["label"])] == labels

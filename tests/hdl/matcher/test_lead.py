"""hdl.matcher.lead: lines wider by the lead, the right picture ahead."""

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig
from golden.matcher.cost import aligned
from hdl.matcher.lead import Lead
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.streams import run_stream
from tests.kit import refused_components


def config(lead):
    return MatcherConfig(labels=2, minimum=-lead, method=FUSED_1)


def run(words, lead, **options):
    """All words that come out; as many as go in, and ``lead`` for each line."""
    return [comparable(word) for word in run_stream(Lead(config(lead)), words, rng=np.random.default_rng(1), **options)]


def widened(words, lead):
    """What the component's docstring makes of any sequence of words, of whole frames or not."""
    lines: list[list] = []
    for number, word in enumerate(words):
        if number == 0 or word["first"] or words[number - 1]["last"] or words[number - 1]["end"]:
            lines.append([])
        lines[-1].append(word)
    result = []
    for line in lines:
        count = len(line) + lead
        for column in range(count):
            left, right = line[max(column - lead, 0)], line[min(column, len(line) - 1)]
            ends = column == count - 1
            result.append({"left": left["left"], "right": right["right"], "first": int(column == 0 and line[0]["first"]),
                           "last": int(ends and line[-1]["last"]), "end": int(ends and line[-1]["end"])})
    return result


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("lead", [1, 2, 3, 5, 64])
def test_matches_golden(lead, stall):
    """Frames of several sizes in a row, narrower and wider than the lead."""
    pairs = [noise(*size, seed) for seed, size in enumerate([(12, 3), (1, 1), (3, 2), (1, 4), (4, 2), (2, 3)])]
    words = [word for pair in pairs for word in pixel_words(*pair)]
    expected = [word for pair in pairs for word in pixel_words(*aligned(*pair, -lead))]
    assert run(words, lead, stall_i=stall, stall_o=stall, count=len(expected)) == expected
    assert widened(words, lead) == expected


@pytest.mark.parametrize("lead", [63, 64])
def test_wide(lead):
    """Lines longer than the ring."""
    pair = noise(300, 2, 1)
    expected = pixel_words(*aligned(*pair, -lead))
    assert run(pixel_words(*pair), lead, count=len(expected)) == expected


def test_latency_and_rate():
    lead, cycles = 3, {}
    dut = Lead(config(lead))
    run_stream(dut, pixel_words(*noise(9, 3, 1)), rng=np.random.default_rng(1), cycles=cycles, count=3 * (9 + lead))
    pixels = [cycle for n, cycle in enumerate(cycles["o"]) if n % (9 + lead) >= lead]
    assert pixels == [cycle + dut.latency for cycle in cycles["i"]]
    assert cycles["o"] == list(range(cycles["o"][0], cycles["o"][0] + 3 * (9 + dut.line_clocks)))


@pytest.mark.parametrize("stall", [0.0, 0.3])
@pytest.mark.parametrize("lead", [1, 3])
def test_ragged(lead, stall):
    """Flags at random: every word is output, and each good frame between is bit-exact."""
    rng = np.random.default_rng(lead)
    words = []
    for seed in range(20):
        frame = pixel_words(*noise(int(rng.integers(1, 9)), int(rng.integers(1, 4)), seed))
        words += [{**word, **{flag: word[flag] ^ (rng.random() < 0.15) for flag in ("first", "last", "end")}} for word in frame] + frame
    words[-1] |= {"last": 1, "end": 1}  # no line is left open
    expected = widened(words, lead)
    assert run(words, lead, stall_i=stall, stall_o=stall, count=len(expected)) == expected


def test_without_a_negative_disparity():
    with refused_components(), pytest.raises(ValueError, match="a lead is for negative disparities, and the least one is 3"):
        Lead(MatcherConfig(labels=2, minimum=3, method=FUSED_1))

import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.lines import line_store
from golden.pictures.scenes import scene
from hdl.matcher.streaming.bec_array import BecArray
from hdl.matcher.streaming.labels import LabelMemory, groups_of
from sim.kit.cases import noise
from sim.kit.clocked import run_clocked
from tests.kit import by_turns


SUMS = ("line", "above", "below", "across")


def waves_of(left, right, in_use, rng, stall, begin=0):
    """Waves of a picture: one before each line, its columns, one past it; each with the pixel that it completes."""
    columns = [line_store(side).tolist() for side in (left, right)]
    height, width = left.shape
    for y in range(height):
        for x in range(-1, width + 1):
            while rng.random() < stall:
                # A bubble: what it carries must not matter.
                wave = {"valid": 0, "pre": int(rng.integers(2)), "inside": 1,
                        "left": dict.fromkeys(SUMS, int(rng.integers(256))), "right": dict.fromkeys(SUMS, 0)}
                yield {"i": {"wave": wave, "store": 0, "pixel_valid": 0}}, None
            column = min(max(x, 0), width - 1)
            sides = {}
            for side, lines in zip(("left", "right"), columns):
                (minus, line, plus), before = lines[y][column], lines[y][min(max(x - 1, 0), width - 1)][1]
                sides[side] = dict(zip(SUMS, (line, line + minus, line + plus, line + before)))
            done = x >= 1
            wave = {"valid": 1, "pre": int(x < 0), "inside": int(x >= 0), "in_use": in_use, **sides}
            number = y * width + x - 1 + begin
            pixel = {"pixel": number % 256, "lower": number // 256 % 256}
            yield {"i": {"wave": wave, "store": int(done), "pixel": pixel, "pixel_valid": int(done)}}, (y, x - 1) if done else None


@pytest.mark.parametrize("labels, width, height, stall", by_turns([
    (2, 1, 1), (2, 6, 3), (3, 9, 2), (4, 5, 3), (5, 12, 3), (13, 30, 2), (13, 4, 3), (18, 40, 2), (33, 70, 1),
], (0.0, 0.4)))
def test_matches_golden(labels, width, height, stall):
    # The second picture may not use all labels.
    configs = [MatcherConfig(labels=labels, in_use=in_use, method=OnePass(Arithmetic.LINEAR)) for in_use in (None, labels - labels // 3)]
    config = configs[0]
    rng = np.random.default_rng(3)
    pictures = [scene(width, height, labels, seed=4)[:2], noise(width, height, seed=5)]
    count = 2 * width * height
    depth = count + 3  # all stay, so that any can be read at the end
    dut = BecArray(config, depth)
    latency = BecArray.latency_of(config)

    cycles = [cycle for number, (pair, config) in enumerate(zip(pictures, configs))
              for cycle in waves_of(*pair, config.labels_in_use, rng, stall, number * width * height)]
    waves = [inputs for inputs, _ in cycles]
    idle = {"i": {"wave": {"valid": 0, "in_use": configs[1].labels_in_use}, "store": 0, "pixel_valid": 0}}
    # Then every cost is read; label d shows it d + 2 cycles after the address.
    reads = [{**idle, "address": place} for place in range(count)]
    out = run_clocked(dut, [*waves, *[idle] * (latency + 5), *reads], ["queued", "queued_valid", "cost"], idle=idle, drain=labels + 2)

    costs = np.concatenate([matching_cost(*pair, config).reshape(-1, labels) for pair, config in zip(pictures, configs)])
    local = [out[cycle + latency]["queued"].local for cycle, (_, pixel) in enumerate(cycles) if pixel is not None]
    # The pixel that waits is taken along: here each by its number.
    given = [(word["queued"].pixel.pixel, word["queued"].pixel.lower) for word in out if word["queued_valid"]]
    assert given == [(number % 256, number // 256 % 256) for number in range(count)]
    assert local == local_disparity(costs).tolist()
    begin = len(waves) + latency + 5
    got = [[config.matching_cost.outside - out[begin + place + 2 + d]["cost"][d] for d in range(labels)] for place in range(count)]
    assert got == costs.tolist()
    if width > 2 * labels:
        assert {0, labels - 1} <= set(local)


@pytest.mark.parametrize("stall", [0.0, 0.4])
def test_label_memory(stall):
    """Around the memory several times; read as late as possible before the next word is written to the same address."""
    config = MatcherConfig(labels=10, method=OnePass(Arithmetic.LINEAR))
    rng = np.random.default_rng(6)
    labels, depth, late = config.labels, 14, 6
    given = rng.integers(0, 2**config.data_bits, (60, labels)).tolist()
    group = [number for number, members in enumerate(groups_of(config)) for _ in members]
    assert max(group) == 2
    written = []  # number of the words written in a cycle
    for number in range(len(given)):
        while rng.random() < stall:
            written.append(None)
        written.append(number)
    cycles = len(written) + late + labels + 3
    at = {number: cycle for cycle, number in enumerate(written) if number is not None}
    writes = {cycle: number for number, cycle in at.items()}
    inputs = []
    for cycle in range(cycles):
        # A group's words are written a cycle after those of the group below it; between them are words that must not be kept.
        words = [given[writes[cycle - group[label]]][label] if cycle - group[label] in writes else int(rng.integers(2**config.data_bits))
                 for label in range(labels)]
        inputs.append({"write": int(cycle in writes), "words": words, "address": writes.get(cycle - late, 0) % depth})
    out = run_clocked(LabelMemory(config, depth), inputs, ["o"])
    assert [[out[at[number] + late + label + 2]["o"][label] for label in range(labels)] for number in range(len(given))] == given

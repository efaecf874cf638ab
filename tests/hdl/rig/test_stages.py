"""hdl.rig.stages: a map is loaded as registers do it, and verified by its sum; frames take no longer than said."""

from itertools import pairwise

import numpy as np

from golden.rig.balance import Auto
from golden.rig.maps import map_sum, pack
from hdl.rig.balance import BalanceMode
from hdl.rig.stages import MapLoader, RigStages
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.clocked import run_clocked
from sim.kit.rig_cases import noise_map, rectified_words
from sim.kit.streams import run_stream


def parts(word):
    return {"low": word & 65535, "middle": word >> 16 & 65535, "high": word >> 32}


def test_loader():
    """Two maps one after the other, the second one from another address on: words, places and sums."""
    words = [pack(noise_map(40, 33, 8000, seed)) for seed in (1, 2)]
    steps, places = [], []
    for start, load in ((0, words[0]), (3, words[1][3:])):
        steps.append({"start": 1, "address": start, "next": 0})
        for word in load:
            steps += [{"start": 0, "address": 9, "next": 1, **parts(word)}, *[{"next": 0}] * 4]
        places.append(len(steps))
    given = run_clocked(MapLoader(16), [*steps, {}], ["write", "write_address", "write_data", "sum"])
    written = [(each["write_address"], each["write_data"]) for each in given if each["write"]]
    assert written == [*enumerate(words[0]), *enumerate(words[1][3:], start=3)]
    assert [given[place]["sum"] for place in places] == [map_sum(words[0]), map_sum(words[1][3:])]


def test_frames_take_no_longer_than_said():
    """Pairs through both stages, with maps that make the reader start late."""
    width, height = 34, 6
    frames = [noise(width, height, seed) for seed in (1, 2, 3)]
    maps = [noise_map(width, height, 200, seed) for seed in (1, 2)]
    stages = RigStages(width, height, 8, 22, maps=dict(zip(("left", "right"), map(pack, maps))))
    bound = stages.frame_clocks(width, height)
    cycles = {}
    inputs = {"rectify": 1, "balance": int(BalanceMode.AUTO), "width": width, "height": height}
    out = run_stream(stages, [word for pair in frames for word in pixel_words(*pair)], rng=np.random.default_rng(1), inputs=inputs,
                     cycles=cycles)
    auto, expected = Auto(0, 8), []
    for pair in frames:
        words = rectified_words(pair, maps)
        left, right = (np.array([word[side] for word in words]).reshape(height, width) for side in ("left", "right"))
        expected += pixel_words(left, auto.pair(left, right))
    assert [comparable(word) for word in out] == expected
    starts = cycles["o"][::width * height]
    assert all(bound / 2 < b - a <= bound for a, b in pairwise(starts))

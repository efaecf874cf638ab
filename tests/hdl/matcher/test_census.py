# amaranth: UnusedElaboratable=no

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.config import FUSED_1, RECURSIVE_1, MatcherConfig, changed
from hdl.matcher.census import BlindCensusStage, CensusStage
from hdl.matcher.lines import LineStore
from hdl.matcher.stream import CensusWord, ColumnWord, PixelPair
from sim.kit.cases import census_words, column_words, comparable, noise, pixel_words
from sim.kit.streams import check_rules, receive, run_stream, send


WINDOWS = [(1, 1), (1, 3), (3, 3), (5, 7), (7, 9), (5, 1)]
SIZES = [(12, 3), (1, 1), (2, 2), (1, 4), (3, 1), (4, 6), (9, 2)]


def config(rows, columns, max_width=16):
    return MatcherConfig(labels=2, max_width=max_width, method=changed(FUSED_1, census_rows=rows, census_columns=columns))


def run(cfg, words, **options):
    return [comparable(word) for word in run_stream(CensusStage(cfg), words, rng=np.random.default_rng(1), **options)]


def with_line_below(words, width):
    """A frame with the line below: here, its last line again, whose census the stage may not mix with that of the picture."""
    *picture, last = [{**word, "end": 0} for word in words], [{**word, "first": 0, "below": 1} for word in words[-width:]]
    return [*picture[0], *last]


def without_meaning(words):
    """The words without the census of the line below."""
    return [{**word, "left_census": None, "right_census": None} if word["below"] else word for word in words]


@pytest.mark.parametrize("below", [False, True])
@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("window", WINDOWS, ids=str)
def test_matches_golden(window, stall, below):
    """Frames of several sizes in a row, narrower and wider than the window."""
    cfg = config(*window)
    words, expected = [], []
    for seed, size in enumerate(SIZES):
        pair = noise(*size, seed)
        coming, leaving = column_words(*pair, CensusStage(cfg).rows), census_words(*pair, cfg)
        words += with_line_below(coming, size[0]) if below else coming
        expected += with_line_below(leaving, size[0]) if below else leaving
    assert without_meaning(run(cfg, words, stall_i=stall, stall_o=stall)) == without_meaning(expected)


@pytest.mark.parametrize("window", [(3, 3), (5, 7)], ids=str)
def test_one_side_stalls(window):
    cfg = config(*window)
    pair = noise(10, 4, 3)
    for stalls in ({"stall_i": 0.6}, {"stall_o": 0.6}):
        assert run(cfg, column_words(*pair, cfg.method.cost.census_rows), **stalls) == census_words(*pair, cfg)


def test_bits_by_hand():
    """A single darker pixel sets the bit of its place, in reading order without the centre; a brighter or an equal one sets none."""
    cfg = config(3, 5)
    for darker in (0, 99):
        places = [(y, x) for y in range(3) for x in range(5)]
        places.remove((1, 2))
        for bit, place in enumerate(places):
            left, right = np.full((3, 5), 100), np.full((3, 5), 100)
            left[place] = darker
            right[place] = 255
            word = run(cfg, column_words(left, right))[7]
            assert (word["left_census"], word["right_census"]) == (1 << bit, 0)


def test_extremes():
    """White among black and the reverse: all bits of a census, and none; at a corner the picture's repeated edge is equal to it."""
    cfg = config(5, 7)
    spot = np.zeros((7, 9), dtype=int)
    spot[3, 4] = spot[0, 0] = 255
    words = run(cfg, column_words(spot, 255 - spot, 5))
    assert (words[3 * 9 + 4]["left_census"], words[3 * 9 + 4]["right_census"]) == (2**34 - 1, 0)
    assert words == census_words(spot, 255 - spot, cfg)
    # The corner: rows -2 .. 0 and columns -3 .. 0 of the window are the corner itself.
    assert words[0]["left_census"].bit_count() == 34 - (3 * 4 - 1)


@pytest.mark.parametrize("window", WINDOWS, ids=str)
def test_timing(window):
    """A word a cycle; ``census_columns // 2`` cycles more a line; the last words of a frame leave though nothing follows."""
    cfg = config(*window)
    dut = CensusStage(cfg)
    reach, width, height = cfg.method.cost.census_columns // 2, 11, 4
    cycles = {}
    run_stream(dut, column_words(*noise(width, height, 1), dut.rows), rng=np.random.default_rng(1), cycles=cycles)
    expected = [y * (width + reach) + x + dut.latency for y in range(height) for x in range(width)]
    assert [cycle - cycles["i"][0] for cycle in cycles["o"]] == expected


@pytest.mark.parametrize("width", [1, 2, 5, 12])
def test_line_does_not_wait_for_the_next(width):
    cfg = config(5, 7)
    pair = noise(width, 3, 1)
    cycles = {}
    assert run(cfg, column_words(*pair, 5)[:width], cycles=cycles) == census_words(*pair, cfg)[:width]
    assert cycles["o"][-1] - cycles["i"][-1] == CensusStage(cfg).latency


class Chain(wiring.Component):
    """Line store and census as the matcher joins them."""
    def __init__(self, cfg):
        self.census = CensusStage(cfg)
        self.store = LineStore(cfg, rows=self.census.rows, lines_below=1)
        super().__init__({"i": In(stream.Signature(PixelPair())), "o": Out(stream.Signature(CensusWord(cfg)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.store, m.submodules.census = self.store, self.census
        wiring.connect(m, wiring.flipped(self.i), self.store.i)
        wiring.connect(m, self.store.o, self.census.i)
        wiring.connect(m, self.census.o, wiring.flipped(self.o))
        return m


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("window", WINDOWS, ids=str)
def test_behind_line_store(window, stall):
    """All but the minus pixels of the line below is that of the golden model; the window costs what it costs, not the store's cycle."""
    cfg = config(*window)
    sizes = [(12, 3), (3, 1), (1, 2), (7, 5)]
    pairs = [noise(*size, seed) for seed, size in enumerate(sizes)]
    expected = []
    for left, right in pairs:
        words = census_words(left, right, cfg)
        expected += [{**word, "end": 0} for word in words]
        expected += [{"first": 0, "last": word["last"], "end": word["end"], "left": word["left"]["line"], "right": word["right"]["line"]}
                     for word in words[-len(left[0]):]]
    cycles = {}
    out = run_stream(Chain(cfg), [word for pair in pairs for word in pixel_words(*pair)], count=len(expected),
                     rng=np.random.default_rng(1), stall_i=stall, stall_o=stall, cycles=cycles)
    given = [comparable(word) for word in out]
    assert [word if not word["below"] else {
        **{flag: word[flag] for flag in ("first", "last", "end")}, **{side: word[side]["minus"] for side in ("left", "right")},
    } for word in given] == expected
    if not stall:
        gaps = np.diff(cycles["o"][:12 * 4]).tolist()
        assert gaps == ([1] * 11 + [1 + max(1, cfg.method.cost.census_columns // 2)]) * 3 + [1] * 11


def test_words_hold_their_values():
    cfg = config(5, 7)
    pair = noise(4, 3, 1)
    assert [comparable(word, CensusWord(cfg)) for word in census_words(*pair, cfg)] == census_words(*pair, cfg)
    assert [comparable(word, ColumnWord(5)) for word in column_words(*pair, 5)] == column_words(*pair, 5)


@pytest.mark.parametrize("columns", [1, 3, RECURSIVE_1.cost.census_columns])
@pytest.mark.parametrize("stall", [0.0, 0.4])
def test_threshold(stall, columns):
    """A neighbour has a bit if it is darker by more than the threshold, which is sampled with a frame's first pixel."""
    thresholds = [0, 7, 2, 1]
    pairs = [noise(9, 3, seed) // 25 for seed in range(len(thresholds))]
    for left, right in pairs:
        left[0, 0] = right[0, 0] = 10       # the first pixel, too, has darker neighbours
    plain = MatcherConfig(labels=2, max_width=16, method=changed(RECURSIVE_1, census_columns=columns))
    expected = [word for pair, threshold in zip(pairs, thresholds)
                for word in census_words(*pair, plain.with_settings({"census_threshold": threshold}))]
    assert expected != [word for pair in pairs for word in census_words(*pair, plain)]
    dut = BlindCensusStage(plain)
    rng = np.random.default_rng(1)
    given: list = []

    async def source(ctx):
        for pair, threshold in zip(pairs, thresholds):
            ctx.set(dut.threshold, threshold)
            await send(ctx, dut.i, column_words(*pair, dut.rows), rng=rng, stall=stall)
            await ctx.tick().repeat(12)     # the frame's last word has been output

    async def sink(ctx):
        await receive(ctx, dut.o, len(expected), rng=rng, stall=0.0, timeout=300)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(sink)
    simulator.add_testbench(check_rules(dut.o, given), background=True)
    simulator.run()
    assert [comparable(word) for word in given] == expected

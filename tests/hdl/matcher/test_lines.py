# amaranth: UnusedElaboratable=no

from itertools import pairwise

import numpy as np
import pytest
from amaranth.lib import data
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from golden.matcher.lines import edata_memory
from hdl.matcher.lines import EdataMemory, LineStore
from hdl.matcher.stream import line_names
from sim.kit.cases import column_words, comparable, noise, pixel_words
from sim.kit.ragged import MAX_WIDTH, RAGGED, frame, repaired
from sim.kit.streams import check_rules, receive, run_stream, send


ROWS = [3, 5, 7]
ROWS_STALL = [(3, 0.0), (3, 0.4), (5, 0.0), (7, 0.4)]


def store(max_width=MAX_WIDTH, rows=3, **options):
    return LineStore(MatcherConfig(labels=2, max_width=max_width), rows=rows, **options)


def run_store(dut, words, count, *, stall=0.0, seed=1):
    """Run the words through; return the words output and the number of ``error`` pulses."""
    rng = np.random.default_rng(seed)
    taken, given, pulses = [], [], []

    async def source(ctx):
        await send(ctx, dut.i, words, rng=rng, stall=stall)

    async def sink(ctx):
        await receive(ctx, dut.o, count, rng=rng, stall=stall, timeout=1000)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(4 * MAX_WIDTH + dut.PLUS_DEPTH)

    async def count_errors(ctx):
        async for _, _, error in ctx.tick().sample(dut.error):
            pulses.append(error)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(dut.i, taken), background=True)
    sim.add_testbench(check_rules(dut.o, given), background=True)
    sim.add_testbench(count_errors, background=True)
    sim.run()
    assert len(taken) == len(words)
    return [comparable(word) for word in given], sum(pulses)


def check(words, *, stall=0.0, seed=1, max_width=MAX_WIDTH, rows=3):
    """The store does what :func:`repaired` says; returns that."""
    frames, errors = repaired(words, max_width)
    expected = [word for frame in frames for word in column_words(*frame, rows)]
    given, pulses = run_store(store(max_width, rows), words, len(expected), stall=stall, seed=seed)
    assert given == expected
    assert pulses == errors
    return frames, errors


@pytest.mark.parametrize("rows, stall", ROWS_STALL)
@pytest.mark.parametrize("max_width", [1, 2, 5, 8])
def test_matches_golden(rows, max_width, stall):
    """Frames of all sizes, in a row: each begins where another size left the memories."""
    sizes = [(width, height) for height in (3, 1, 2, 6, 5, 4) for width in (max_width, 1, 2, 5) if width <= max_width]
    pairs = [noise(*size, seed) for seed, size in enumerate(sizes)]
    words = [word for pair in pairs for word in pixel_words(*pair)]
    frames, errors = check(words, stall=stall, max_width=max_width, rows=rows)
    assert [frame.tolist() for frame in frames] == [pair.tolist() for pair in pairs]
    assert errors == 0


@pytest.mark.parametrize("rows", ROWS)
def test_rate(rows):
    """A column a cycle within a line, one cycle more between lines."""
    width, height = 8, 5
    cycles = {}
    run_stream(store(rows=rows), pixel_words(*noise(width, height, 1)), rng=np.random.default_rng(1), cycles=cycles)
    gaps = np.diff(cycles["o"]).reshape(-1)
    assert np.delete(gaps, slice(width - 1, None, width)).tolist() == [1] * (width - 1) * height
    assert gaps[width - 1::width].tolist() == [2] * (height - 1)


@pytest.mark.parametrize("rows", ROWS)
def test_last_line_does_not_wait_for_the_next_frame(rows):
    """One frame and nothing after it: all of it is output (run_stream would time out)."""
    words = pixel_words(*noise(5, 3, 1))
    assert len(run_stream(store(rows=rows), words, rng=np.random.default_rng(1), timeout=50)) == 15


@pytest.mark.parametrize("rows, lines, stall", [(rows, lines, stall) for rows in ROWS for lines in (1, 2, 3) for stall in (0.0, 0.4)
                                                 if lines <= rows // 2])
def test_lines_below(rows, lines, stall):
    """More lines after the last one: what of them is above the picture's end is its last lines, and ``end`` is that of the last of them."""
    pairs = [noise(width, height, height) for height in range(1, 7) for width in (5, 1)]
    names = line_names(rows)
    expected = []
    for left, right in pairs:
        words = column_words(left, right, rows)
        last = words[-len(left[0]):]
        expected += [{**word, "end": 0} for word in words]
        for below in range(1, lines + 1):
            # Column names move up by a line each time.
            expected += [{"below": 1, "first": 0, "last": word["last"], "end": int(word["end"] and below == lines),
                          **{side: {name: word[side][names[at + below]] for at, name in enumerate(names[:rows // 2 + 1 - below])}
                             for side in ("left", "right")}} for word in last]
    words = [word for pair in pairs for word in pixel_words(*pair)]
    given, errors = run_store(store(rows=rows, lines_below=lines), words, len(expected), stall=stall)
    assert [{key: {name: value[name] for name in other[key]} if isinstance(value, dict) else value for key, value in word.items()}
            for word, other in zip(given, expected)] == expected
    assert errors == 0


@pytest.mark.parametrize("rows, lines", [(3, 2), (5, 3), (5, -1)])
def test_bad_lines_below(rows, lines):
    with pytest.raises(ValueError, match=f"columns of {rows} lines hold pixels for 0 to {rows // 2} lines, not {lines}"):
        store(rows=rows, lines_below=lines)


@pytest.mark.parametrize("rows", [1, 4, 9])
def test_bad_rows(rows):
    with pytest.raises(ValueError, match=f"3, 5 or 7 lines, not {rows}"):
        store(rows=rows)


@pytest.mark.parametrize("case", RAGGED)
def test_ragged_frame_of_the_model(case):
    """The ragged frame is cut, the output is rectangular and closed, and the good frames around it are as they were."""
    words, size, errors = RAGGED[case]
    before, after, smaller = noise(5, 3, 20), noise(5, 4, 21), noise(2, 2, 22)
    frames, pulses = repaired([*pixel_words(*before), *words, *pixel_words(*after), *pixel_words(*smaller)])
    assert pulses == errors
    assert frames[0].tolist() == before.tolist()
    assert [frame.tolist() for frame in frames[-2:]] == [after.tolist(), smaller.tolist()]
    assert (frames[1].shape[:0:-1] if len(frames) > 3 else None) == size


@pytest.mark.parametrize("rows, stall", ROWS_STALL)
def test_ragged(rows, stall):
    """Bit-exact with the model, whose frames are those of the test above; after each a good frame, and a smaller one."""
    words = frame(5, 3, seed=20)
    for case in RAGGED.values():
        words += [*case[0], *frame(5, 4, seed=21), *frame(2, 2, seed=22)]
    _, errors = check(words, stall=stall, rows=rows)
    assert errors == sum(case[2] for case in RAGGED.values())


def test_first_after_reset_may_be_missing():
    """The store is switched on in mid-frame."""
    frames, errors = check([*frame()[7:], *frame(seed=9)])
    assert len(frames) == 1
    assert errors == 1


@pytest.mark.parametrize("rows, seed", [(3, 0), (3, 1), (3, 2), (3, 3), (5, 4), (5, 5), (7, 6), (7, 7)])
def test_ragged_at_random(rows, seed):
    """Flags at random, good frames between them."""
    rng = np.random.default_rng(seed)
    words = []
    for _ in range(25):
        good = frame(int(rng.integers(1, MAX_WIDTH + 1)), int(rng.integers(1, 4)), int(rng.integers(1000)))
        bad = [{**word, **{flag: word[flag] ^ (rng.random() < 0.1) for flag in ("first", "last", "end")}} for word in good]
        words += [*bad, *good]
    frames, errors = check(words, stall=0.3 * (seed % 2), seed=seed, rows=rows)
    assert len(frames) > 25
    assert errors > 5


def test_model_of_ragged_frames():
    """The oracle above, by hand."""
    words = frame(2, 3)
    assert repaired(words)[1] == 0
    frames, errors = repaired([*words[:3], *words])
    assert errors == 1
    (left, right), whole = frames
    assert left.tolist() == [[words[n]["left"] for n in (0, 1)], [words[2]["left"]] * 2]
    assert right.tolist() == [[words[n]["right"] for n in (0, 1)], [words[2]["right"]] * 2]
    assert whole[0].ravel().tolist() == [word["left"] for word in words]


# EdataMemory

def simulate_exchange(shape, max_width, steps):
    """Each step is (column, exchange, write, word); return ``o`` after each."""
    dut = EdataMemory(shape, max_width)
    given = []

    async def testbench(ctx):
        for column, exchange, write, word in steps:
            ctx.set(dut.column, column)
            ctx.set(dut.exchange, exchange)
            ctx.set(dut.write, write)
            ctx.set(dut.i, word)
            await ctx.tick().repeat(dut.LATENCY)
            given.append(ctx.get(dut.o))

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    return given


@pytest.mark.parametrize("width, max_width", [(1, 1), (1, 4), (2, 2), (5, 8)])
def test_edata_memory(width, max_width):
    """Each word is given up as the one below it is taken, in the same cycle: also where there is one column only."""
    words = np.random.default_rng(1).integers(0, 2**12, (4, width))
    steps = [(x, 1, 1, int(words[y, x])) for y in range(4) for x in range(width)]
    given = simulate_exchange(12, max_width, steps)
    assert given[width:] == edata_memory(words).ravel().tolist()


def test_edata_memory_holds():
    steps = [(0, 1, 1, 5), (1, 1, 1, 6), (0, 1, 1, 7),   # gives 5
             (1, 0, 1, 8), (1, 0, 0, 9),                 # no exchange: holds, writes nothing
             (1, 1, 0, 10),                              # gives 6, writes nothing
             (1, 1, 1, 11), (0, 1, 0, 0)]
    assert simulate_exchange(4, 2, steps)[2:] == [5, 5, 5, 6, 6, 7]


def test_edata_memory_of_structures():
    layout = data.StructLayout({"cost": data.ArrayLayout(3, 5), "pixel": 8})
    words = [{"cost": [n, 7, 0, 1, 7 - n], "pixel": 255 - n} for n in range(6)]
    given = simulate_exchange(layout, 3, [(n % 3, 1, 1, word) for n, word in enumerate(words)])
    assert [comparable(word) for word in given[3:]] == words[:3]


def test_memories_are_dense():
    """Two consecutive frames of the greatest width use every word of both memories."""
    pairs = [noise(MAX_WIDTH, 3, seed) for seed in range(2)]
    words = [word for pair in pairs for word in pixel_words(*pair)]
    given, _ = run_store(store(), words, len(words))
    middle = [word["left"]["minus"] for word in given[MAX_WIDTH:2 * MAX_WIDTH]]
    assert middle == pairs[0][0][0].tolist()
    assert all(a != b for a, b in pairwise([given[:24], given[24:]]))

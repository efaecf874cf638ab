"""The cocotb half of ``test_blocks.py``: each block is compared with its golden function."""

import os
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge

from golden.config import WEIGHT_MAX
from golden.matcher.argmin import comparator_tree
from golden.matcher.labelling import cost_summation, labelling
from golden.matcher.lines import edata_memory
from golden.matcher.smooth import smooth
from golden.pictures.scenes import scene
from hdl.matcher.sequential.cost import BuffersWord, CostWord, EdataWord, SubPixelWord
from hdl.matcher.sequential.smooth import LookUpTable, Smooth
from hdl.matcher.stream import BecWord, ColumnWord, DisparityWord, PixelPair
from sim.benches.blocks import CONFIGS
from sim.kit.cases import (
    bec_words,
    bec_words_of,
    between_frames,
    buffers_words,
    camera,
    column_words,
    comparable,
    cost_words,
    disparity_words,
    edata_words,
    noise,
    pixel_words,
    sub_pixel_words,
)
from sim.kit.cocotb_streams import check_rules, drain, sink, source
from sim.kit.payloads import pack


CONFIG = CONFIGS[os.environ["ARITHMETIC"]]
LABELS = CONFIG.labels
INPUTS = os.environ["INPUTS"].split()
STALLS = [0.0, 0.4]


async def start(dut):
    """Clock, reset; all inputs are 0, except the number of labels in use."""
    for name in INPUTS:
        getattr(dut, name).value = CONFIG.labels_in_use if name.endswith("_in_use") else 0
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0


async def stream(dut, name, layout_i, layout_o, frames, expected, stall, *, before_frame=None):
    """Send frames of words through a block: its output, see :func:`comparable`, must be ``expected``, without extra words."""
    cocotb.start_soon(check_rules(dut, f"{name}_i"))
    transfers = []
    cocotb.start_soon(check_rules(dut, f"{name}_o", transfers))

    async def send():
        for number, words in enumerate(frames):
            if before_frame:
                before_frame(number)
            await source(dut, f"{name}_i", [pack(layout_i, word) for word in words], rng=random.Random(number), stall=stall)

    sender = cocotb.start_soon(send())
    received = await sink(dut, f"{name}_o", len(expected), rng=random.Random(2), stall=stall)
    await sender
    assert received == transfers
    for at, (word, wanted) in enumerate(zip(received, expected)):
        assert comparable(word, layout_o) == comparable(wanted), f"word {at}"
    assert await drain(dut, f"{name}_o") == []


async def play(dut, name, steps, outputs):
    """Set the inputs of each step for one clock; return the outputs in each clock, ``None`` if they are unknown."""
    given = []
    for step in steps:
        for member, value in step.items():
            getattr(dut, f"{name}_{member}").value = value
        await ReadOnly()
        values = [getattr(dut, f"{name}_{member}").value for member in outputs]
        given.append([int(value) if value.is_resolvable else None for value in values])
        await RisingEdge(dut.clk)
    return given


def split(word, count):
    """Parts of equal width of a packed word, the lowest first."""
    bits, word = word
    return None if word is None else [word >> n * bits & (1 << bits) - 1 for n in range(count)]


def join(values, bits):
    return sum(int(value) << n * bits for n, value in enumerate(values))


def pairs():
    """A scene in which each label wins somewhere, and noise of odd sizes."""
    left, right, _ = scene(13, 4, LABELS, seed=5)
    return [(left, right), noise(1, 1, 1), noise(5, 3, 2), noise(1, 3, 3), noise(2, 1, 4)]


def each(words, *arguments):
    return [words(*pair, *arguments) for pair in pairs()]


def flat(frames):
    return [word for frame in frames for word in frame]


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def line_store(dut, stall):
    await start(dut)
    await stream(dut, "line_store", PixelPair(), ColumnWord(), each(pixel_words), flat(each(column_words)), stall)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def line_store_ragged(dut, stall):
    """A frame that ends in its second line is padded and closed; one error, and the next frame is bit-exact."""
    await start(dut)
    ragged, good = noise(5, 3, 1), noise(4, 2, 2)
    padded = ragged[:, :2].copy()
    padded[:, 1, 3:] = padded[:, 1, 2:3]
    pulses = []

    async def count():
        while True:
            await ReadOnly()
            pulses.append(int(dut.line_store_error.value))
            await RisingEdge(dut.clk)

    cocotb.start_soon(count())
    await stream(dut, "line_store", PixelPair(), ColumnWord(), [pixel_words(*ragged)[:8], pixel_words(*good)],
                 column_words(*padded) + column_words(*good), stall)
    assert sum(pulses) == 1


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def sub_pixels(dut, stall):
    await start(dut)
    await stream(dut, "sub_pixels", ColumnWord(), SubPixelWord(CONFIG), each(column_words), flat(each(sub_pixel_words, CONFIG)), stall)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def sub_pixel_buffers(dut, stall):
    await start(dut)
    await stream(dut, "sub_pixel_buffers", SubPixelWord(CONFIG), BuffersWord(CONFIG), each(sub_pixel_words, CONFIG),
                 flat(each(buffers_words, CONFIG)), stall)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def cost_energy(dut, stall):
    await start(dut)
    await stream(dut, "cost_energy", BuffersWord(CONFIG), CostWord(CONFIG), each(buffers_words, CONFIG), flat(each(cost_words, CONFIG)),
                 stall)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def edata(dut, stall):
    await start(dut)
    await stream(dut, "edata", CostWord(CONFIG), EdataWord(CONFIG), each(cost_words, CONFIG), flat(each(edata_words, CONFIG)), stall)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def bec(dut, stall):
    await start(dut)
    await stream(dut, "bec", ColumnWord(), BecWord(CONFIG), each(column_words), flat(each(bec_words_of, CONFIG)), stall)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def comparator_tree_(dut, stall):
    """Two stages; a low ``enable`` freezes both."""
    await start(dut)
    inputs, stages = 13, 2
    rng = np.random.default_rng(1)
    bits = CONFIG.energy_bits
    top = 2**bits - 1
    winners = np.full((inputs, inputs), top)
    np.fill_diagonal(winners, 0)
    sets = np.vstack([winners, rng.integers(0, 3, (60, inputs)), rng.integers(0, 2**bits, (20, inputs)), np.full((1, inputs), top)])
    enables = [int(rng.random() >= stall) for _ in range(300)]
    steps, wanted, taken = [], [], []
    for enable in enables:
        wanted.append(taken[-stages] if len(taken) >= stages else None)
        at = len(taken) % len(sets)
        steps.append({"i": join(sets[at], bits), "enable": enable})
        if enable:
            taken.append(at)
    value, index = comparator_tree(sets)
    for (found,), at in zip(await play(dut, "comparator_tree", steps, ["o"]), wanted):
        if at is not None:
            assert (found & top, found >> bits) == (value[at], index[at])


@cocotb.test()
async def edata_memory_(dut):
    """A word is output as the one below it is written: at the full width, and with one column."""
    await start(dut)
    for width in (CONFIG.max_width, 1):
        words = np.random.default_rng(width).integers(0, 2**62, (5, width))
        exchange = {"exchange": 1, "write": 1}
        steps = [{"column": x, "i": int(words[y, x]), **exchange} for y in range(5) for x in range(width)]
        hold = {"exchange": 0, "write": 1, "column": 0, "i": 1}   # no write, and the output holds
        given = [word for word, in await play(dut, "edata_memory", [*steps, hold, hold, hold], ["o"])]
        assert given[width + 1:-2] == edata_memory(words).ravel().tolist()
        assert given[-3:] == given[-3:-2] * 3


@cocotb.test()
async def smooth_(dut):
    """A pixel, a neighbour and a label in each clock; the tables are filled three times."""
    await start(dut)
    rng = np.random.default_rng(1)
    dut.smooth_read.value = 1
    largest = 0
    bits = len(dut.smooth_energy) // LABELS
    for weight in (WEIGHT_MAX, 15, 0):
        fill_clocks = 0 if CONFIG is CONFIGS["linear"] else 2 * LABELS
        filled = await play(dut, "smooth", [{"weight": weight, "fill": 1, "label": 0}, *[{"fill": 0}] * (fill_clocks + 1)], ["filled"])
        assert [value for value, in filled[1:]] == [0] * fill_clocks + [1]
        steps = [{"pixel": int(rng.choice([0, 255, rng.integers(256)])), "neighbour": int(rng.choice([0, 255, rng.integers(256)])),
                  "label": int(rng.choice([0, LABELS - 1, rng.integers(LABELS)])), "present": int(rng.random() < 0.8)} for _ in range(150)]
        given = [split((bits, word), LABELS) for word, in await play(dut, "smooth", steps, ["energy"])]
        for at in range(Smooth.PIXEL_LATENCY, len(steps)):
            pixels, label = steps[at - Smooth.PIXEL_LATENCY], steps[at - Smooth.LATENCY]["label"]
            difference = abs(pixels["pixel"] - pixels["neighbour"])
            wanted = pixels["present"] * smooth(np.abs(np.arange(LABELS) - label), difference, weight, CONFIG)
            assert given[at] == wanted.tolist(), (weight, at)
            largest = max(largest, *wanted.tolist())
    assert largest == CONFIG.smooth_max
    assert LookUpTable.LATENCY == 1


@cocotb.test()
async def cost_summation_(dut):
    await start(dut)
    rng = np.random.default_rng(1)
    bits = {"cost": CONFIG.data_bits, **dict.fromkeys(("s1", "s2", "s3"), CONFIG.smooth_max.bit_length())}
    limits = {"cost": CONFIG.method.data_max, **dict.fromkeys(("s1", "s2", "s3"), CONFIG.smooth_max)}
    terms = {name: rng.integers(0, limit + 1, (60, LABELS)) for name, limit in limits.items()}
    for name, values in terms.items():
        values[20:24] = limits[name]
    steps = [{name: join(values[at], bits[name]) for name, values in terms.items()} for at in range(60)]
    given = [split((CONFIG.energy_bits, word), LABELS) for word, in await play(dut, "cost_summation", steps, ["energy"])]
    assert max(max(energies) for energies in given[2:]) == CONFIG.energy_max
    for at in range(2, 60):
        early = (terms[name][at - 2] for name in ("cost", "s2", "s3"))
        cost, s2, s3 = early
        assert given[at] == cost_summation(cost, terms["s1"][at - 1], s2, s3, CONFIG).tolist()


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def sequential_engine(dut, stall):
    """Random costs and local disparities; the weights change with each frame, and the first frame is narrow."""
    await start(dut)
    rng = np.random.default_rng(1)
    sizes = [(1, 3), (13, 3), (2, 2), (5, 1), (1, 1)]
    weights = [(63, 63, 63), (15, 10, 5), (0, 63, 1), (63, 0, 0), (1, 2, 3)]
    frames, expected = [], []
    for (width, height), (u1, u2, u3) in zip(sizes, weights):
        cost = rng.integers(0, 80, (height, width, LABELS))
        cost[rng.random(cost.shape) < 0.2] = CONFIG.method.data_max
        local = rng.integers(0, LABELS, (height, width))
        left = noise(width, height, 1, pictures=1)[0]
        frames.append(bec_words(cost, local, left))
        expected += disparity_words(labelling(cost, local, left, CONFIG.with_settings({"u1": u1, "u2": u2, "u3": u3})))
    assert {word["disparity"] for word in expected} == set(range(LABELS))

    def weigh(number):
        for name, weight in zip(("u1", "u2", "u3"), weights[number]):
            getattr(dut, f"sequential_engine_{name}").value = weight

    await stream(dut, "sequential_engine", BecWord(CONFIG), DisparityWord(CONFIG), frames, expected, stall, before_frame=weigh)


@cocotb.test()
@cocotb.parametrize(stall=STALLS)
async def frame_timing(dut, stall):
    await start(dut)
    rng = np.random.default_rng(1)
    frames = [pixel_words(*noise(*size, seed)) for seed, size in enumerate([(5, 3), (1, 4), (1, 1), (7, 1), (2, 2)])]
    cycles = between_frames(3)
    for words in frames:
        # At most half a pixel a clock: a consumer that stalls keeps pace.
        cycles += camera(words, rng=rng, gaps=0.6, line_gap=2, before=1) + between_frames(40)
    names = ("frame_valid", "line_valid", "pixel_valid", "left", "right")
    sender = cocotb.start_soon(play(dut, "frame_timing", [dict(zip(names, cycle)) for cycle in cycles], ["dropped"]))
    cocotb.start_soon(check_rules(dut, "frame_timing_o"))
    received = await sink(dut, "frame_timing_o", len(flat(frames)), rng=random.Random(2), stall=stall)
    assert [comparable(word, PixelPair()) for word in received] == flat(frames)
    dropped = await sender
    assert dropped[-1] == [0]
    assert await drain(dut, "frame_timing_o") == []


@cocotb.test()
async def frame_timing_overflow(dut):
    """``ready`` is low: the first frame is cut and the second dropped, both are counted; the third is bit-exact."""
    await start(dut)
    rng = np.random.default_rng(1)
    frames = [pixel_words(*noise(5, 3, seed)) for seed in range(3)]
    names = ("frame_valid", "line_valid", "pixel_valid", "left", "right")

    async def show(words):
        cycles = between_frames(3) + camera(words, rng=rng) + between_frames(3)
        return (await play(dut, "frame_timing", [dict(zip(names, cycle)) for cycle in cycles], ["dropped"]))[-1]

    assert await show(frames[0]) == [1]
    assert await show(frames[1]) == [2]
    begun = [comparable(word, PixelPair()) for word in await drain(dut, "frame_timing_o")]
    assert begun == frames[0][:len(begun)]
    assert 8 <= len(begun) <= 9
    third = cocotb.start_soon(show(frames[2]))
    received = await sink(dut, "frame_timing_o", 15, rng=random.Random(1))
    assert [comparable(word, PixelPair()) for word in received] == frames[2]
    assert await third == [2]

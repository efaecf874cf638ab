import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import FUSED_1, RECURSIVE_1, MatcherConfig
from hdl.matcher.refine.window import LabelColumns
from sim.kit.cases import comparable, label_words
from sim.kit.streams import send


def slots(reach, labels, passed, n, *grey, enable, minimum):
    """What concerns a pixel, by hand: the column ``reach`` to the right of it, and what leaves with it."""
    height, width = labels.shape
    rows = 2 * reach + 1
    labels, passed, *grey = (np.pad(part, ((reach, reach), (0, reach)), mode="edge").astype(int) for part in (labels, passed, *grey))
    sizes = np.pad(n, ((0, 0), (0, reach)), mode="edge")
    for y in range(height):
        for x in range(width + reach):
            yield {
                "column": {"label": labels[y:y + rows, x].tolist(), "passed": sum(passed[y + line, x] << line for line in range(rows)),
                           "size": int(sizes[y, x]).bit_length(), **dict(zip(["grey"], (part[y:y + rows, x].tolist() for part in grey)))},
                "opens": int(x == 0), "shown": int(x >= reach), "enable": enable, "minimum": minimum,
                "first": int(x == reach and y == 0), "last": int(x == width + reach - 1),
                "end": int(x == width + reach - 1 and y == height - 1)}


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("max_width", [1, 6])
@pytest.mark.parametrize("method, rows", [(FUSED_1, 5), (RECURSIVE_1, 7), (RECURSIVE_1, 9)], ids=["5", "7", "9"])
def test_columns(method, rows, max_width, stall):
    """Frames of all sizes in a row; every column that belongs to a pixel's window, and ``issued`` once a pixel."""
    rng = np.random.default_rng(1)
    dut = LabelColumns(MatcherConfig(labels=80, max_width=max_width, method=method), rows)
    reach = dut.reach
    assert reach == rows // 2
    sizes = [(width, height) for height in (3, 1, 2, 4, 5) for width in (1, 6, 2) if width <= max_width]
    frames = []
    for width, height in sizes:
        part = rng.integers(0, 80, (height, width)), rng.random((height, width)) < 0.5, rng.integers(1, 34, (height, width))
        grey = [rng.integers(0, 256, (height, width))] if method is RECURSIVE_1 else []
        frames.append((*part, *grey, int(rng.integers(2)), int(rng.integers(256))))
    expected = [slot for *part, enable, minimum in frames for slot in slots(reach, *part, enable=enable, minimum=minimum)]
    given, issued, allowed = [], [], []

    async def source(ctx):
        for *part, enable, minimum in frames:
            ctx.set(dut.enable, enable)
            ctx.set(dut.minimum, minimum)
            await send(ctx, dut.i, label_words(*part), rng=rng, stall=stall)

    async def sink(ctx):
        lines = 0
        cycles = sum((width + reach) * (height + reach) for width, height in sizes) * (5 if stall else 1) + dut.LATENCY
        for _ in range(cycles):
            allowed.append(rng.random() >= stall)
            ctx.set(dut.go, allowed[-1])
            _, _, valid, word, started = await ctx.tick().sample(dut.valid, dut.o, dut.issued)
            issued.append(started)
            if valid:
                assert allowed[-1 - dut.LATENCY]
                word = comparable(word)
                lines += word["opens"]
                # A frame's first lines show nothing: what concerns their pixels is not known.
                if lines > reach:
                    given.append(word)
                if word["shown"] and word["end"]:
                    lines = 0

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.run()
    for word, right in zip(given, expected, strict=True):
        if not right["shown"]:
            for name in ("first", "last", "end"):
                word[name] = right[name]
        assert word == right
    assert sum(issued) == sum(width * height for width, height in sizes)

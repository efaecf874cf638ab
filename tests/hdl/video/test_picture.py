"""The gate in front of the display's FIFO, against a model on lists, and the scan behind it with invalid words; pictures: test_dvi.py."""

import random

import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from golden.config import MatcherConfig, OnePass
from golden.video.formats import DisplayFormat
from hdl.video.picture import PictureGate, PictureScan, QueuedPixel
from sim.kit.cases import comparable
from sim.kit.display_cases import shown_pictures, shown_words


CONFIG = MatcherConfig(labels=5)


def passed(words, width, lines, step):
    """The words that pass, and whether more are expected. ``step``: every second pixel and, of so many lines, the first one."""
    start = next((at for at, word in enumerate(words) if word["first"]), len(words))
    passing = []
    for n, word in enumerate(words[start:]):
        y, x = divmod(n, width)
        if y == lines or word["first"] != (n == 0) or word["last"] != (x == width - 1):
            return passing, False
        if step is None or (x % 2 == 0 and x < width // 2 * 2 and y % step == 0 and y < lines // step * step):
            passing.append(word)
    return passing, len(words) - start < width * lines


@pytest.mark.parametrize("reader_skips", [False, True])
@pytest.mark.parametrize("size", [(4, 4), (5, 3), (2, 2)])
def test_gate(size, reader_skips):
    """Good pictures, faulty ones, incomplete ones, and unannounced ones; words with ``first`` in the two cycles that discard all."""
    rng = random.Random(1)
    width, height = size
    dut = PictureGate(CONFIG, *size, reader_skips=reader_skips)
    payload = Value.cast(dut.i.payload)
    outcomes = []

    async def cycle(ctx, word=None, **inputs):
        """Whether the word was accepted, and the word written."""
        for name, value in inputs.items():
            ctx.set(getattr(dut, name), value)
        ctx.set(dut.i.valid, word is not None)
        if word is None:
            ctx.set(payload, rng.getrandbits(len(payload)))
        else:
            ctx.set(dut.i.payload, word)
        room = rng.randrange(2)
        ctx.set(dut.ready, room)
        _, _, ready, write, written, unfinished = await ctx.tick().sample(dut.i.ready, dut.write, dut.word, dut.unfinished)
        assert ready == (room or not unfinished or ctx.get(dut.fetch))
        assert word or not write
        return ready, comparable(written) if write and room else None

    async def testbench(ctx):
        old = {"halves": 0, "tag": 0}
        for number in range(100):
            halves, announced, tag = number % 3 == 1, number % 5 != 2, 1 - number % 2
            lines, step = (height // 2, 1) if halves and reader_skips else (height, 2 if halves else None)
            pair = shown_pictures(*size, 5, number)
            words = shown_words(*pair, halves and reader_skips) + shown_words(*pair)
            words = words[rng.choice([0, 0, 0, 1]):rng.choice([len(words), rng.randrange(len(words))])]
            if words and number % 4 == 0:
                at = rng.randrange(min(len(words), width * lines))
                words[at] = {**words[at], rng.choice(["first", "last"]): rng.randrange(2)}

            head = shown_words(*pair)[0]
            for inputs in ({"fetch": 1, "shown_valid": not announced, **old},
                           {"fetch": 0, "shown_valid": announced, "halves": halves, "tag": tag}):
                assert await cycle(ctx, head, **inputs) == (1, None)
            assert ctx.get(dut.announced) == announced
            ctx.set(dut.shown_valid, not announced)
            given = []
            for word in words:
                taken = False
                while not taken:
                    if rng.random() < 0.2:
                        await cycle(ctx)
                    taken, written = await cycle(ctx, word)
                    given += [written] if written else []
            await cycle(ctx)
            expected, unfinished = passed(words, width, lines, step) if announced else ([], False)
            names = ("disparity", "left", "first")
            assert given == [{**{name: word[name] for name in names}, "tag": tag} for word in expected]
            assert ctx.get(dut.unfinished) == unfinished
            old = {"halves": halves, "tag": tag}
            outcomes.append((len(given), unfinished))

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    # Whole pictures and halves, incomplete pictures that were given up and that were not.
    assert {(width * height, False), ((width // 2) * (height // 2), False), (0, True), (0, False)} <= set(outcomes)


def scan(words):
    """Show 4x2 left pixels on a display of that size, from vertical blanking on; ``words``: from which clock on each is there, the word.

    Returns the red of each pixel, the pixels with an underflow, and the number of words left.
    """
    display = DisplayFormat(4, range(4, 5), 6, 2, range(2, 3), 4, 1)
    dut = PictureScan(CONFIG, display, 4, 2)
    queue, reds, underflows = list(words), [], []

    async def testbench(ctx):
        ctx.set(dut.settings, {"announced": 1, "only_left": 1})
        ctx.set(dut.tag, 1)
        for clock in range(26):
            y, x = divmod((clock + 12) % 24, 6)
            ctx.set(dut.x, x)
            ctx.set(dut.y, y)
            ctx.set(dut.frame_start, clock == 0)
            valid = bool(queue) and queue[0][0] <= clock
            ctx.set(dut.i.valid, valid)
            ctx.set(dut.i.p, queue[0][1] if valid else {"tag": 1, "first": 1})
            underflow, ready = ctx.get(dut.underflow), ctx.get(dut.i.ready)
            _, _, red = await ctx.tick().sample(dut.red)
            if underflow:
                underflows.append(4 * y + x)
            if ready and valid:
                queue.pop(0)
            at = clock - 12 - PictureScan.LATENCY
            if at >= 0 and at % 6 < 4:
                reds.append(red)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return reds, underflows, len(queue)


def queued(left, **flags):
    return {"left": left, "tag": 1, "first": left == 1, **flags}


GOOD = [(0, queued(left)) for left in range(1, 9)]


@pytest.mark.parametrize("words, shown, left", [
    (GOOD, 8, 0),
    ([*GOOD, (0, queued(9))], 8, 1),
    ([(0, queued(9, tag=0, first=1)), (0, queued(9)), *GOOD], 8, 0),                        # drained in blanking
    ([*GOOD[:3], (0, queued(4, first=1)), *GOOD[4:]], 3, 5),                                # the first pixel of another picture
    ([*GOOD[:3], (0, queued(4, tag=0)), *GOOD[4:]], 3, 4),                                  # a pixel of the picture before: it is drained
    ([*GOOD[:3], (16, queued(4)), *GOOD[4:]], 3, 5),                                        # a cycle too late
    ([*GOOD[:3], (15, queued(4)), *GOOD[4:]], 8, 0),
    ([(12, queued(1, tag=0)), *GOOD], 0, 8),                                                # too late to be drained
    ([(12, queued(9)), *GOOD], 0, 8),
    ([(13, queued(1)), *GOOD[1:]], 0, 8),                                                   # no word for the first pixel
])
def test_scan(words, shown, left):
    wanted = [value if value <= shown else 0 for value in range(1, 9)]
    assert scan(words) == (wanted, [shown] if shown < 8 else [], left)


def test_width():
    """At most a word of an M9K block, 512 x 18."""
    configs = [MatcherConfig(labels=labels, engine="streaming", method=OnePass("linear")) for labels in (80, 256)]
    assert [QueuedPixel(config).size for config in configs] == [17, 18]

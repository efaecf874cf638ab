# amaranth: UnusedElaboratable=no
from dataclasses import replace

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.video.bandwidth import Budget, MemoryTiming
from golden.video.formats import DISPLAYS, CameraFormat
from golden.video.memory_map import MemoryMap, Plane
from hdl.video.arbiter import Arbiter
from hdl.video.frame_write import FrameWriter, PictureWriter
from sim.kit.cases import noise
from sim.kit.streams import check_rules, send
from sim.kit.video_cases import camera_words, plane_words
from sim.models.ddr2 import Ddr2Timing, LocalMemory, serve


HOSTILE = Ddr2Timing(busy=0.5, refresh=(150, 30))
PULSES = ("begin", "complete", "abandoned")


class Run:
    """A writer alone at an arbiter, its frames, and what it did.

    ``choices``: (buffer, accept) for each ``begin``, in turn; noise in all other cycles. ``events``: pulses in their order, with the
    buffer; ``pictures``: what the memory held in the cycle of each ``complete``. ``contents``: all words before and after.
    """
    def __init__(self, dut, memory_map, words, choices, *, timing=HOSTILE, stall=0.0, seed=1, size=1, gap=0, inputs=()):
        self.events, self.pictures, self.overflows = [], [], 0
        self.cycles: list = []
        taken: list = []
        rng = np.random.default_rng(seed)
        self.memory = memory = LocalMemory(memory_map.total_words, size=size, timing=timing, seed=seed)
        self.before = [int.from_bytes(rng.bytes(16), "little") for _ in range(memory_map.total_words)]
        for address, word in enumerate(self.before):
            memory[address] = word
        m = Module()
        m.submodules.dut = dut
        m.submodules.arbiter = arbiter = Arbiter(1, 1, burst=dut.burst, size=size)
        wiring.connect(m, dut.port, arbiter.write[0])

        async def control(ctx):
            turn = iter(choices)
            buffer = None
            async for *_, overflow, waits, begin, complete, abandoned, ragged in ctx.tick().sample(
                    dut.overflow, dut.i.valid & ~dut.i.ready, *[getattr(dut.control, name) for name in PULSES], dut.ragged):
                assert waits or not overflow
                self.overflows += overflow
                for name, pulse in zip((*PULSES, "ragged"), (begin, complete, abandoned, ragged)):
                    if pulse:
                        if name == "begin":
                            buffer, accept = next(turn)
                        self.events.append((name, buffer))
                        if name == "complete":
                            self.pictures.append(memory.picture(memory_map, dut.plane, buffer))
                ctx.set(dut.control.buffer, buffer if begin else int(rng.integers(memory_map.buffers)))
                ctx.set(dut.control.accept, accept if begin else int(rng.integers(2)))

        async def source(ctx):
            for name, value in inputs:
                ctx.set(getattr(dut, name), value)
            for word in words:
                await send(ctx, dut.i, [word], rng=rng, stall=stall)
                if gap:
                    await ctx.tick().repeat(gap)
            await ctx.tick().repeat(300)
            self.skipped, self.fill = ctx.get(dut.skipped), ctx.get(dut.fill)

        sim = Simulator(m)
        sim.add_clock(1e-6)
        sim.add_testbench(source)
        sim.add_process(control)
        sim.add_process(serve(arbiter.bus, memory))
        sim.add_testbench(check_rules(dut.i, taken, self.cycles), background=True)
        sim.add_testbench(check_rules(dut.port.request, []), background=True)
        sim.run()
        assert len(taken) == len(words)
        assert next(iter(choices[sum(name == "begin" for name, _ in self.events):]), None) is None
        self.after = [memory[address] for address in range(memory_map.total_words)]

    def names(self):
        return [name for name, _ in self.events]


def expected_contents(before, memory_map, plane, pictures):
    """Words after ``pictures``, by buffer, were put in: neither padding nor anything else is touched."""
    after = list(before)
    mask = 2**(8 * (memory_map.width - 16 * (memory_map.line_words - 1))) - 1
    for buffer, picture in pictures.items():
        for offset, word in memory_map.words(picture).items():
            address = memory_map.base(plane, buffer) + offset
            padded = offset % memory_map.pitch == memory_map.line_words - 1
            after[address] = before[address] & ~mask | word & mask if padded else word
    return after


WRITERS = {
    "camera": (FrameWriter, Plane.RIGHT, camera_words),
    "picture": (PictureWriter, Plane.DISPARITY, plane_words),
}


@pytest.mark.parametrize("kind, width, height, burst, size, stall", [
    ("camera", 20, 6, 16, 1, 0.0), ("camera", 37, 4, 2, 4, 0.4), ("camera", 2, 2, 4, 1, 0.0), ("camera", 64, 2, 4, 3, 0.0),
    ("picture", 20, 3, 1, 1, 0.4), ("picture", 37, 3, 16, 1, 0.0), ("picture", 1, 1, 4, 1, 0.4),
])
def test_frames(kind, width, height, burst, size, stall):
    """Frames into their buffers; some are skipped. The memory holds each one when ``complete`` is high, and nothing else changes."""
    writer, plane, words_of = WRITERS[kind]
    memory_map = MemoryMap(width, height, 3)
    pictures = noise(width, height, 1, pictures=6)
    choices = [(1, 1), (0, 1), (2, 0), (2, 1), (0, 0), (1, 1)]
    run = Run(writer(memory_map, plane, burst=burst, depth=20), memory_map, [word for picture in pictures for word in words_of(picture)],
              choices, stall=stall, size=size)
    accepted = [(picture, buffer) for picture, (buffer, accept) in zip(pictures, choices) if accept]
    assert run.events == [event for buffer, accept in choices for event in [("begin", buffer), ("complete", buffer)][:1 + accept]]
    assert [picture.tolist() for picture in run.pictures] == [picture.tolist() for picture, _ in accepted]
    assert run.after == expected_contents(run.before, memory_map, plane, {buffer: picture for picture, buffer in accepted})
    assert run.skipped == 2
    assert run.memory.words_written == 4 * height * memory_map.line_words
    assert 0 < run.fill <= 20


def with_flags(words, place, **flags):
    return [*words[:place], {**words[place], **flags}, *words[place + 1:]]


# Faulty frames of 20x4, and how often each is reported as ragged.
def faults(words):
    dropped = {**words[0], "drop": 1, "first": 0, "last": 1, "end": 1}
    return {
        "short line": (words[:27] + words[28:], 1),
        "long line": (words[:27] + words[26:], 1),
        "short first line": (words[:7] + words[8:], 1),
        "line missing": (words[:20] + words[40:], 1),
        "line too many": (words[:40] + words[20:], 1),
        "last missing": (with_flags(words, 39, last=0), 1),
        "last too early": (with_flags(words, 30, last=1), 1),
        "end missing": (with_flags(words, 79, end=0), 1),
        "end too early": (with_flags(words, 59, end=1), 1),
        "end of first pixel": (with_flags(words, 0, end=1), 1),
        "one pixel": (words[:1], 1),
        "cut in mid-line": (words[:33], 1),
        "cut after a line": (words[:60], 1),
        "cut before its last pixel": (words[:79], 1),
        "first in mid-frame": (with_flags(words, 45, first=1)[:60], 2),
        "dropped at once": ([words[0], dropped], 0),
        "dropped in mid-line": ([*words[:50], dropped], 0),
        "dropped before its last pixel": ([*words[:79], dropped], 0),
        "dropped by words with first": ([*words[:50], *[{**dropped, "first": 1}] * 2], 0),
        "dropped twice": ([*words[:30], dropped, dropped, *words[50:60]], 0),
        "dropped, then its rest": ([*words[:10], dropped, *words[11:]], 0),
    }


@pytest.mark.parametrize("case", faults(camera_words(np.zeros((4, 20), int))))
def test_frames_at_fault(case):
    """It is abandoned, nothing is written outside its buffer, and the good frames around it are exact."""
    memory_map = MemoryMap(20, 4, 3)
    good, bad, again = noise(20, 4, 2, pictures=3)
    words, ragged = faults(camera_words(bad))[case]
    begun = max(ragged, 1)
    run = Run(FrameWriter(memory_map, Plane.LEFT, burst=2, depth=8), memory_map, [*camera_words(good), *words, *camera_words(again)],
              [(0, 1), *[(1, 1)] * begun, (2, 1)], stall=0.4 * (len(words) % 2))
    names = run.names()
    assert names[:3] == ["begin", "complete", "begin"]
    assert names[-2:] == ["begin", "complete"]
    assert (names.count("abandoned"), names.count("ragged"), names.count("complete")) == (begun, ragged, 2)
    for at, name in enumerate(names):
        if name == "ragged":
            assert names[at + 1] == "abandoned"
    assert [picture.tolist() for picture in run.pictures] == [good.tolist(), again.tolist()]
    expected = expected_contents(run.before, memory_map, Plane.LEFT, {0: good, 2: again})
    outside = [address for address in range(memory_map.total_words)
               if not 0 <= address - memory_map.base(Plane.LEFT, 1) < memory_map.picture_words]
    assert [run.after[address] for address in outside] == [expected[address] for address in outside]


@pytest.mark.parametrize("case", ["cut in mid-line", "dropped in mid-line"])
def test_skipped_frames_may_be_at_fault(case):
    """Nobody sees it: a frame that is not accepted is not looked at."""
    memory_map = MemoryMap(20, 4)
    bad, again = noise(20, 4, 2, pictures=2)
    run = Run(FrameWriter(memory_map, Plane.LEFT, burst=2, depth=8), memory_map,
              [*faults(camera_words(bad))[case][0], *camera_words(again)], [(1, 0), (1, 1)])
    assert run.events == [("begin", 1), ("begin", 1), ("complete", 1)]
    assert run.skipped == 1
    assert run.pictures[0].tolist() == again.tolist()


def test_count_of_skipped_frames_stays_at_its_greatest():
    memory_map = MemoryMap(2, 2)
    dut = FrameWriter(memory_map, Plane.LEFT, burst=1, depth=4)
    seen = []

    async def testbench(ctx):
        ctx.set(dut.skipped, 2**16 - 2)
        for _ in range(3):
            await send(ctx, dut.i, camera_words(np.zeros((2, 2), int)), rng=np.random.default_rng(1))
            seen.append(ctx.get(dut.skipped))

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    assert seen == [2**16 - 1] * 3


def test_a_pixel_a_cycle():
    """Within a frame, as long as the memory keeps pace."""
    memory_map = MemoryMap(64, 8)
    picture, = noise(64, 8, 1, pictures=1)
    run = Run(PictureWriter(memory_map, Plane.DISPARITY, burst=4, depth=12), memory_map, plane_words(picture), [(0, 1)],
              timing=Ddr2Timing(init=1, busy=0.5))
    assert np.diff(run.cycles[1:]).tolist() == [1] * (64 * 8 - 2)
    assert run.overflows == 0
    assert run.fill <= 8


@pytest.mark.parametrize("depth", [6, 8])
def test_overflow_is_told(depth):
    """A stall longer than the FIFO bridges: the pixel waits, ``overflow`` is high, and nothing is lost. All its words are told of."""
    memory_map = MemoryMap(64, 4)
    picture, = noise(64, 4, 1, pictures=1)
    run = Run(FrameWriter(memory_map, Plane.LEFT, burst=4, depth=depth), memory_map, camera_words(picture), [(0, 1)],
              timing=Ddr2Timing(init=1, busy=0.0, stalls=((60, 16 * depth + 154),)), stall=0.2)
    assert 100 < run.overflows < 250
    assert run.fill == depth
    assert run.pictures[0].tolist() == picture.tolist()


def test_clear_fill():
    """While ``clear_fill`` is high, ``fill`` is the present level."""
    memory_map = MemoryMap(64, 4)
    picture, = noise(64, 4, 1, pictures=1)
    run = Run(FrameWriter(memory_map, Plane.LEFT, burst=4, depth=6), memory_map, camera_words(picture), [(0, 1)],
              inputs=[("clear_fill", 1)])
    assert run.fill == 0


# A camera of 13.5 million pixels a second at a memory clock of 54 MHz: a pixel each fourth clock.
CAMERA = CameraFormat(width=128, field_lines=3, blanking=40)
STALL = 700


def depth_that_suffices():
    budget = Budget(memory_map=MemoryMap(CAMERA.width, CAMERA.height), camera=CAMERA, masters=1, burst=4,
                    timing=MemoryTiming(clock_hz=54_000_000, stall_clocks=STALL, row_clocks=2, turn_clocks=2, latency_clocks=0))
    return budget.camera_depth, budget


@pytest.mark.parametrize("at", [200, 850])
def test_derived_depth(at):
    """The longest stall, in the first line or across lines: the depth that is derived bridges it, and six tenths of it do not."""
    depth, budget = depth_that_suffices()
    picture, = noise(CAMERA.width, CAMERA.height, 1, pictures=1)
    timing = Ddr2Timing(init=1, busy=1.0, patience=1, refresh=(10**9, 0), stalls=((at, STALL),))
    assert 1 / budget.efficiency >= 2

    def overflows(depth):
        return Run(FrameWriter(budget.memory_map, Plane.LEFT, burst=4, depth=depth), budget.memory_map, camera_words(picture), [(0, 1)],
                   timing=timing, gap=3)

    sized = overflows(depth)
    assert sized.overflows == 0
    assert sized.fill <= depth
    assert overflows(depth * 6 // 10).overflows > 0


def test_default_depths():
    """They are at least the depths in the budget of the thesis's system, and not twice that."""
    memory_map = MemoryMap()
    for display in DISPLAYS.values():
        budget = replace(Budget(), display=display)
        assert budget.camera_depth <= FrameWriter(memory_map, Plane.LEFT).depth < 2 * budget.camera_depth
        assert budget.matcher_depth <= PictureWriter(memory_map, Plane.DISPARITY).depth < 2 * budget.matcher_depth


def test_refuses():
    with pytest.raises(ValueError, match="must hold at least 18 words, two more than a burst, not 17"):
        FrameWriter(MemoryMap(), Plane.LEFT, depth=17)
    with pytest.raises(ValueError, match="interlaced picture must have an even number of lines, not 5"):
        FrameWriter(MemoryMap(20, 5), Plane.LEFT)

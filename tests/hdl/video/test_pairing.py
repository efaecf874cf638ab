# amaranth: UnusedElaboratable=no
import itertools
import random
from operator import attrgetter

import pytest
from amaranth import *
from amaranth.sim import Simulator

from golden.video.buffers import PlaneState
from golden.video.pairing import CAMERAS, PLANES, Pairing
from hdl.video.pairing import BufferControl


WRITERS = (*CAMERAS, *PLANES)
INPUTS = ("reader.done", "display.fetch", "hold", "keep", "clear", "host", "put",
          *(f"{writer}.{event}" for writer in WRITERS for event in ("begin", "complete", "abandoned")))
BITS = {name: 1 << place for place, name in enumerate(INPUTS)}
EVENTS = [name for name in INPUTS if name not in ("hold", "keep", "clear", "host", "put")]


class Reference:
    """What the gateware must show in each cycle, by the golden model; its counters show an event 2 cycles later, are set back by
    ``clear``, and stop at 16 bits.
    """

    def __init__(self, buffers, window, life):
        self.rule = Pairing(buffers, window, life)
        self.now = 0
        self.started = None
        self.shown = self.cleared = [0] * len(BufferControl.COUNTERS)

    def counts(self):
        left, right = self.rule.cameras
        pictures = self.rule.pictures
        return [self.rule.pairs, left.skipped, right.skipped, left.unpaired, right.unpaired, pictures.dropped, pictures.abandoned]

    def clock(self, names):
        """A cycle with these inputs high."""
        if "clear" in names:
            self.cleared = self.shown
        self.shown = self.counts()
        events = {name.removeprefix("reader.").removeprefix("display.") for name in names}
        levels = {"hold" if "hold" in names else "release", "keep" if "keep" in names else "let_go"}
        levels |= {"host" if "host" in names else "cameras"}
        self.started = self.rule.clock(self.now, events | levels)
        self.now += 1

    def expected(self):
        """Of each output its value, ``None`` if it may have any."""
        rule = self.rule
        pictures = rule.pictures
        read = [rule.buffers] * 2 if rule.reading and rule.host_reads else [camera.reading for camera in rule.cameras]
        values = [self.started is not None, *read, rule.host_waits or (rule.reading and rule.host_reads), pictures.shown is not None,
                  pictures.shown]
        for camera in rule.cameras:
            values += [camera.filling is not None, camera.filling]
        for plane in pictures.planes:
            accept = pictures.writing is not None and plane is PlaneState.FILLING
            values += [accept, pictures.writing if accept else None]
        values += [rule.kept_whole, *((rule.kept if rule.kept_whole else None) or [None] * 3)]
        values += [min(count - cleared, 2**16 - 1) for count, cleared in zip(self.shown, self.cleared)]
        return values


def outputs(dut):
    reader, display = dut.reader, dut.display
    values = [reader.start, reader.left_buffer, reader.right_buffer, dut.putting, display.shown_valid, display.shown_buffer]
    for writer in WRITERS:
        values += [getattr(dut, writer).accept, getattr(dut, writer).buffer]
    return values + [getattr(dut, name) for name in ("kept", "kept_left", "kept_right", "kept_slot", *BufferControl.COUNTERS)]


def compare(dut, cycles):
    """Run ``cycles``, sets of inputs that are high, or functions of the golden model that give one; compare all outputs in every cycle.

    Returns the golden model.
    """
    reference = Reference(dut.buffers, dut.window_clocks, dut.life_clocks)
    shown = outputs(dut)
    places = list(itertools.accumulate((len(value) for value in shown), initial=0))
    m = Module()
    m.submodules.dut = dut
    driven = Signal(len(INPUTS))
    seen = Signal(places[-1])
    m.d.comb += [Cat(attrgetter(name)(dut) for name in INPUTS).eq(driven), seen.eq(Cat(shown))]

    async def testbench(ctx):
        for number, names in enumerate(cycles):
            if callable(names):
                names = names(reference)
            got = ctx.get(seen)
            for index, value in enumerate(reference.expected()):
                if value is not None:
                    found = got >> places[index] & (1 << len(shown[index])) - 1
                    assert found == value, f"cycle {number}: {shown[index].name} is {found}, not {value}"
            ctx.set(driven, sum(BITS[name] for name in names))
            reference.clock(names)
            await ctx.tick()

    simulator = Simulator(m)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return reference


def of_a_host(cycles, mean, puts=0.0):
    """With ``keep`` as well, which changes every ``mean`` cycles on average, and ``host``, every 4 times as many, if there are ``puts``."""
    rng = random.Random(2)
    levels = {"keep": False, "host": False}

    def with_host(names):
        levels["keep"] ^= rng.random() < 1 / mean
        levels["host"] ^= puts > 0 and rng.random() < 1 / (4 * mean)
        added = {name for name, level in levels.items() if level} | ({"put"} if rng.random() < puts else set())
        return (lambda reference: names(reference) | added) if callable(names) else names | added

    return [with_host(names) for names in cycles]


@pytest.mark.parametrize("puts", [0.0, 0.1])
@pytest.mark.parametrize("buffers, window, life, chance", [
    (2, 2, 5, 0.3), (2, 6, None, 0.12), (2, 14, 15, 0.08), (3, 5, None, 0.15), (3, 1, 3, 0.4), (5, 7, 40, 0.1),
])
def test_random(buffers, window, life, chance, puts):
    """Every event at any time, whether it makes sense or not."""
    rng = random.Random(1)
    names = [*EVENTS, "hold", "clear"]
    weights = {"hold": 0.2, "clear": 0.02, **{name: 0.3 for name in EVENTS if name.endswith("abandoned")}}
    cycles = [{name for name in names if rng.random() < chance * weights.get(name, 1.0)} for _ in range(3000)]
    reference = compare(BufferControl(buffers, window, life), of_a_host(cycles, 60, puts))
    assert reference.rule.pairs > 10 and min(camera.unpaired for camera in reference.rule.cameras) > 50


class World:
    """Cameras, reader, matcher and display that keep the contract, with all that may go wrong in it; durations are random.

    Called once a cycle with the reference, for the inputs of that cycle.
    """
    def __init__(self, seed, period, reading, fetch, *, trouble=0.1):
        self.rng = random.Random(seed)
        self.period, self.reading, self.fetch, self.trouble = period, reading, fetch, trouble
        self.now = 0
        self.due = []

    def later(self, least, most, name):
        self.due.append((self.now + self.rng.randint(least, most), name))

    def __call__(self, reference):
        rng, period = self.rng, self.period
        if self.now == 0:
            for camera in CAMERAS:
                self.later(0, 2 * period, f"{camera}.begin")
            self.later(0, self.fetch, "display.fetch")
        if reference.started is not None:
            self.later(0, self.reading, "reader.done")
            for plane in PLANES:
                if rng.random() >= self.trouble / 4:    # now and then a picture is missing
                    self.later(1, 4, f"{plane}.begin")
        names = {name for at, name in self.due if at <= self.now}
        self.due = [(at, name) for at, name in self.due if at > self.now]
        for name in sorted(names):  # the same whatever the order of a set
            writer, _, event = name.partition(".")
            trouble = rng.random() < self.trouble
            if name == "display.fetch":
                self.later(self.fetch, self.fetch, name)
            elif event == "begin":
                fill = period * 15 // 16 if writer in CAMERAS else self.reading
                self.later(1 if trouble else fill - 1, fill, f"{writer}.{'abandoned' if trouble else 'complete'}")
                if writer in CAMERAS:   # sometimes the camera is lost for a while
                    self.later(period - 1, period * (1 if rng.random() > self.trouble / 2 else 5), name)
        self.now += 1
        return names


@pytest.mark.parametrize("puts", [0.0, 0.02])
@pytest.mark.parametrize("buffers, period, reading, fetch, trouble", [
    (2, 16, 5, 7, 0.0), (2, 16, 14, 7, 0.1), (3, 16, 14, 7, 0.1), (3, 24, 22, 50, 0.05), (4, 16, 40, 30, 0.2),
])
def test_plausible(buffers, period, reading, fetch, trouble, puts):
    """Components that keep the contract, with jitter, frames abandoned, cameras lost, pictures that go missing."""
    world = World(1, period, reading, fetch, trouble=trouble)
    reference = compare(BufferControl(buffers, 5 * period // 8), of_a_host([world] * 3000, 5 * period, puts))
    pictures = reference.rule.pictures
    assert reference.rule.pairs > 40
    assert (pictures.abandoned > 0) == (trouble > 0)
    assert puts or (pictures.dropped > 0) == (fetch == 50)


def test_every_combination_of_inputs():
    """Every combination of inputs in one cycle, each once, in states that a plausible system and the combinations lead to."""
    rng = random.Random(1)
    world = World(1, 6, 4, 5, trouble=0.2)
    combinations = list(itertools.chain.from_iterable(itertools.combinations(EVENTS, count) for count in range(len(EVENTS) + 1)))
    assert len(combinations) == 2**14
    rng.shuffle(combinations)
    cycles = []
    for names in combinations:
        cycles += [world] * rng.randrange(3)
        cycles.append({*names, *(["hold"] if rng.random() < 0.1 else [])})
    reference = compare(BufferControl(2, 4), of_a_host(cycles, 10, 0.1))
    *counts, dropped, abandoned = reference.counts()
    assert min(*counts, abandoned) > 100 and dropped == 0   # a new picture waits for the fetch of the one before


def play(events, cycles):
    """``{cycle: names}`` as one set a cycle."""
    return [{*events.get(cycle, "").split()} for cycle in range(cycles)]


PAIR = {0: "left_camera.begin", 2: "right_camera.begin", 10: "left_camera.complete", 12: "right_camera.complete"}


def test_kept_pair():
    """By hand: asked for in cycle 0, kept once both planes are complete and the pair is read; let go in the cycle after ``keep`` falls."""
    dut = BufferControl(3, 4, 100)
    seen = []
    events = PAIR | {15: "disparity_plane.begin left_plane.begin", 20: "disparity_plane.complete left_plane.complete", 24: "reader.done"}

    async def testbench(ctx):
        for cycle, names in enumerate(play(events, 40)):
            for name in INPUTS:
                ctx.set(attrgetter(name)(dut), name in names or (name == "keep" and cycle < 30))
            seen.append(ctx.get(dut.kept))
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    assert [cycle for cycle, kept in enumerate(seen) if kept] == [*range(25, 31)]


def test_pair_of_the_host():
    """By hand: asked for twice, the second time while it is read; kept."""
    dut = BufferControl(3, 4, 100)
    events = PAIR | {14: "put", 18: "disparity_plane.begin left_plane.begin", 20: "put", 25: "reader.done",
                     26: "disparity_plane.complete left_plane.complete"}
    seen = []

    async def testbench(ctx):
        for cycle, names in enumerate(play(events, 60)):
            for name in INPUTS:
                ctx.set(attrgetter(name)(dut), name in names or (name == "host" and cycle < 40) or name == "keep")
            seen.append([ctx.get(value) for value in (dut.reader.start, dut.reader.left_buffer, dut.putting, dut.kept, dut.kept_right)])
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    assert [cycle for cycle, (start, *_) in enumerate(seen) if start] == [16, 28]
    assert all(buffer == 3 for _, buffer, putting, *_ in seen[16:] if putting)
    assert [cycle for cycle, (*_, putting, _, _) in enumerate(seen) if not putting] == [*range(15)]
    assert [cycle for cycle, (*_, kept, _) in enumerate(seen) if kept] == [*range(27, 60)] and seen[-1][-1] == 3


@pytest.mark.parametrize("until, pairs", [(20, 1), (200, 0)])
def test_cameras_after_the_host(until, pairs):
    """Their frames wait while pairs are the host's, and expire as ever."""
    held = [{*names, "host"} if cycle < until else names for cycle, names in enumerate(play(PAIR, 250))]
    reference = compare(BufferControl(2, 4, 100), held)
    assert reference.rule.pairs == pairs and [camera.unpaired for camera in reference.rule.cameras] == [1 - pairs] * 2


def test_start_after_two_cycles():
    """By hand: the second frame is complete in cycle 12, ``start`` is high in cycle 14, and the buffers stay."""
    dut = BufferControl(2, 4, 100)
    seen = []

    async def testbench(ctx):
        for names in play(PAIR | {16: "left_camera.begin right_camera.begin", 20: "reader.done"}, 24):
            for name in INPUTS:
                ctx.set(attrgetter(name)(dut), name in names)
            left = dut.left_camera
            seen.append([ctx.get(value) for value in (dut.reader.start, dut.reader.left_buffer, left.accept, left.buffer)])
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    assert [cycle for cycle, (start, *_) in enumerate(seen) if start] == [14]
    assert [seen[cycle] for cycle in (1, 10, 11, 14, 17, 23)] == [
        [0, 0, 1, 0], [0, 0, 1, 0], [0, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 1], [0, 0, 1, 1]]


@pytest.mark.parametrize("apart, pairs", [(3, 1), (4, 1), (5, 0)])
@pytest.mark.parametrize("first, second", [CAMERAS, CAMERAS[::-1]])
def test_window(first, second, apart, pairs):
    events = {0: f"{first}.begin", apart: f"{second}.begin", 10: f"{first}.complete", 20: f"{second}.complete"}
    assert compare(BufferControl(2, 4, 100), play(events, 30)).rule.pairs == pairs


@pytest.mark.parametrize("last, pairs", [(18, 1), (19, 0), (31, 0), (32, 0), (40, 0), (50, 0), (300, 0)])
def test_life(last, pairs):
    """A frame may be 19 cycles old as its pair is decided, in the cycle after ``last``; no wrap-around makes an old one young again."""
    events = PAIR | {12: "", last: "right_camera.complete"}
    assert compare(BufferControl(2, 4, 20), play(events, last + 300)).rule.pairs == pairs
    # The same frame complete, but the pair kept waiting.
    held = [{*names, "hold"} if cycle < last else names for cycle, names in enumerate(play(PAIR, last + 300))]
    assert compare(BufferControl(2, 4, 20), held).rule.pairs == pairs


def test_ages_of_a_real_system():
    """Both latest frames very old, far beyond the range of any counter; then a new pair."""
    dut = BufferControl(2, 60, 255)
    events = PAIR | {12: "", 1000 + 2: "right_camera.complete", 2000: "left_camera.begin right_camera.begin",
                     2100: "left_camera.complete right_camera.complete"}
    reference = compare(dut, play(events, 2200))
    assert reference.rule.pairs == 1 and [camera.unpaired for camera in reference.rule.cameras] == [1, 1]


def test_stalled_reader_only_delays():
    """A memory that returns nothing for 20 periods: the pair's buffers stay locked, and the next pair is a new one."""
    period = 16
    frames = {}
    for number in range(60):
        for camera, begin in zip(CAMERAS, (number * period, number * period + 5)):
            for at, event in ((begin, "begin"), (begin + period - 1, "complete")):
                frames[at] = frames.get(at, "") + f" {camera}.{event}"
    stall = {22: frames.get(22, "") + " disparity_plane.begin left_plane.begin", 342: frames.get(342, "") + " reader.done",
             343: frames.get(343, "") + " disparity_plane.complete left_plane.complete"}
    begun = []

    def watch(names):
        def cycle(reference):
            if reference.started is not None:
                begun.append(reference.now - 1)
            return names
        return cycle

    reference = compare(BufferControl(2, 10), [watch(names) for names in play(frames | stall, 400)])
    # During the stall the latest frames expired and were replaced, at intervals of 3 periods.
    assert begun[0] == 21 and 344 <= begun[1] <= 344 + 2 * period and len(begun) == 2
    assert reference.rule.cameras[0].skipped > 10


@pytest.mark.parametrize("buffers, reading, fetch, idle", [(2, 20, 5, {"pictures_dropped"}), (3, 4, 40, {"left_skipped", "right_skipped"})])
def test_counters_stay_at_their_greatest(buffers, reading, fetch, idle):
    dut = BufferControl(buffers, 4)
    counters = [getattr(dut, name) for name in BufferControl.COUNTERS]
    rng = random.Random(1)

    async def testbench(ctx):
        for counter in counters:
            ctx.set(counter, 2**16 - 3)
        world = World(2, 8, reading, fetch, trouble=0.2)
        reference = Reference(dut.buffers, dut.window_clocks, dut.life_clocks)
        for _ in range(1000):
            names = world(reference) | {name for name in sorted(EVENTS) if name.endswith("begin") and rng.random() < 0.03}
            for name in INPUTS:
                ctx.set(attrgetter(name)(dut), name in names)
            reference.clock(names)
            await ctx.tick()
            assert [ctx.get(counter) for counter in counters] == [min(2**16 - 3 + count, 2**16 - 1) for count in reference.shown]
        assert {name for name, count in zip(BufferControl.COUNTERS, reference.counts()) if count <= 2} == idle

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()


@pytest.mark.parametrize("arguments, message", [
    ((1, 5), r"at least 2 buffers for each picture, not 1$"),
    ((2, 0), r"at least 1 cycle, not 0$"),
    ((2, 5, 5), r"longer than the window of 5 cycles, not 5$"),
])
def test_bad_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        BufferControl(*arguments)

# amaranth: UnusedElaboratable=no
"""Both parts in every state that they can reach, with every input: a tour, planned on the golden model."""

import copy
import itertools
from collections import deque
from operator import attrgetter

import pytest
from amaranth import *
from amaranth.sim import Simulator

from golden.video.buffers import Camera, Pictures, PlaneState
from hdl.video.buffers import CameraBuffers, PictureSlots


def tour(model):
    """Inputs that make every move in every state; ``model`` is stepped along.

    A model has ``key()``, its state; ``moves()``, the inputs allowed in it; ``clock(move)``.
    """
    new = {}        # state: moves not made yet
    known = {}      # state: where the moves lead
    while True:
        here = model.key()
        if here not in new:
            new[here] = list(model.moves())
            known[here] = {}
        if new[here]:
            path = [new[here].pop()]
        else:
            path = shortest(here, new, known)
            if path is None:
                return
        for move in path:
            before = model.key()
            yield move
            model.clock(move)
            known[before][move] = model.key()


def shortest(start, new, known):
    """The moves to the nearest state with a new one."""
    reached_by = {start: None}
    queue = deque([start])
    while queue:
        state = queue.popleft()
        if state not in new or new[state]:
            path = []
            while reached_by[state] is not None:
                state, move = reached_by[state]
                path.append(move)
            return path[::-1]
        for move, then in known[state].items():
            if then not in reached_by:
                reached_by[then] = state, move
                queue.append(then)
    return None


def walk(dut, model, inputs, outputs):
    """Take the tour with the gateware; the number of steps.

    The model's ``high(move)`` is the set of inputs that are high, its ``expected()``
    gives outputs that depend on the state alone, its ``clock(move)`` those that the move shows in the same cycle; both only those that
    mean something.
    """
    m = Module()
    m.submodules.dut = dut
    members = [attrgetter(name)(dut) for name in outputs]
    driven = Signal(len(inputs))
    seen = Signal(sum(len(member) for member in members))
    m.d.comb += [Cat(attrgetter(name)(dut) for name in inputs).eq(driven), seen.eq(Cat(members))]
    places = dict(zip(outputs, itertools.accumulate((len(member) for member in members), initial=0)))
    masks = {name: (1 << len(member)) - 1 for name, member in zip(outputs, members)}
    steps = 0

    async def testbench(ctx):
        nonlocal steps
        twin = copy.deepcopy(model)
        for move in tour(model):
            expected = twin.expected()
            high = twin.high(move)
            ctx.set(driven, sum(1 << place for place, name in enumerate(inputs) if name in high))
            expected |= twin.clock(move)
            got = ctx.get(seen)
            for name, value in expected.items():
                assert got >> places[name] & masks[name] == value, (steps, move, name)
            await ctx.tick()
            steps += 1

    simulator = Simulator(m)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return steps


def subsets(names):
    return [frozenset(chosen) for count in range(len(names) + 1) for chosen in itertools.combinations(names, count)]


def index(value):
    return 0 if value is None else value


class CameraModel:
    """One camera, whether the frame taken last is being read, and, if it ``keeps`` any, the one that is kept."""
    WRITER = ("writer.begin", "writer.complete", "writer.abandoned")

    def __init__(self, buffers, life, keeps):
        self.camera = Camera(buffers, life)
        self.keeps = keeps
        self.now = 0

    def available(self):
        return self.camera.latest is not None and self.now - self.camera.latest_began < self.camera.life

    def key(self):
        camera = self.camera
        ages = [None if buffer is None else min(self.now - began, camera.life)
                for buffer, began in ((camera.filling, camera.filling_began), (camera.latest, camera.latest_began))]
        return camera.filling, camera.latest, camera.reading, camera.kept, *ages

    def moves(self):
        for writer in subsets(self.WRITER):
            yield writer
            if self.camera.reading is not None:
                yield writer | {"done"}
            elif self.available():
                yield writer | {"take"}
                if self.camera.kept is None and self.keeps:
                    yield writer | {"take", "keep"}
            if self.camera.kept is not None:
                yield writer | {"let go"}

    def high(self, move):
        locked = self.camera.reading is not None and "done" not in move
        return move | ({"locked"} if locked else set()) | ({"held"} if self.camera.kept is not None else set())

    def expected(self):
        camera = self.camera
        values = {"writer.accept": camera.filling is not None, "available": self.available()}
        if camera.filling is not None:
            values["writer.buffer"] = camera.filling
        if camera.reading is not None:
            values["reading"] = camera.reading
        if camera.kept is not None:
            values["kept"] = camera.kept
        if self.available():
            values |= {"latest": camera.latest, "age": self.now - camera.latest_began}
        return values

    def clock(self, move):
        camera = self.camera
        skipped, unpaired = camera.skipped, camera.unpaired
        if "take" in move:
            camera.reading, camera.latest = camera.latest, None
            if "keep" in move:
                camera.kept = camera.reading
        if "done" in move:
            camera.reading = None
        camera.expire(self.now)
        if "writer.complete" in move or "writer.abandoned" in move:
            camera.end(self.now, "writer.abandoned" not in move)
        if "writer.begin" in move:
            camera.begin(self.now)
        if "let go" in move:
            camera.kept = None
        self.now += 1
        return {"skipped": camera.skipped - skipped, "unpaired": camera.unpaired - unpaired}


@pytest.mark.parametrize("buffers, life, keeps, least", [(2, 6, False, 2000), (3, 5, False, 2000), (3, 3, True, 4000)])
def test_camera(buffers, life, keeps, least):
    dut = CameraBuffers(buffers, life)
    steps = walk(dut, CameraModel(buffers, life, keeps), (*CameraModel.WRITER, "take", "locked", "keep", "held"),
                 ("writer.accept", "writer.buffer", "available", "latest", "reading", "kept", "age", "skipped", "unpaired"))
    assert steps > least


class PicturesModel:
    """The slots, and the pair: started, being read, read for some cycles. If it ``keeps`` any, of the planes only likely moves."""
    PLANES = ("disparity_plane", "left_plane")

    def __init__(self, slots, life, keeps):
        self.pictures = Pictures(slots)
        self.life = life
        self.keeps = keeps
        self.reading = False
        self.since = life       # the pair was read

    def key(self):
        pictures = self.pictures
        writing = (*pictures.planes, self.reading, self.since) if pictures.writing is not None else (self.reading,)
        return pictures.writing, pictures.latest, pictures.shown, pictures.kept, *writing

    def moves(self):
        planes = [subsets([f"{plane}.{event}" for event in ("begin", "complete", "abandoned")]) for plane in self.PLANES]
        # The two are alike: one of them need not do the unlikely ones.
        planes[1] = [move for move in planes[1] if len(move) == 1 or "left_plane.abandoned" not in move]
        if self.keeps:
            planes = [[move for move in of_plane if len(move) < 2] for of_plane in planes]
            planes[1] = [frozenset({"left_plane.begin"}), frozenset({"left_plane.complete"})]
        for first, second, fetch in itertools.product(*planes, subsets(["display.fetch"])):
            move = first | second | fetch
            yield move
            if self.reading:
                yield move | {"done"}
            elif self.pictures.free() is not None:
                yield move | {"start"}
                if self.keeps and self.pictures.kept is None:
                    yield move | {"start", "keep"}
            if self.pictures.kept is not None:
                yield move | {"let go"}

    def high(self, move):
        return move | ({"reading"} if self.reading else set()) | ({"held"} if self.pictures.kept is not None else set())

    def expected(self):
        pictures = self.pictures
        values = {"free": pictures.free() is not None, "display.shown_valid": pictures.shown is not None}
        if pictures.free() is not None:
            values["slot"] = pictures.free()
        if pictures.kept is not None:
            values["kept"] = pictures.kept
        if pictures.shown is not None:
            values["display.shown_buffer"] = pictures.shown
        for plane, state in zip(self.PLANES, pictures.planes):
            accept = pictures.writing is not None and state is PlaneState.FILLING
            values[f"{plane}.accept"] = accept
            if accept:
                values[f"{plane}.buffer"] = pictures.writing
        return values

    def clock(self, move):
        pictures = self.pictures
        dropped, abandoned = pictures.dropped, pictures.abandoned
        slot, kept_complete = pictures.free(), pictures.kept_complete
        if pictures.writing is not None and not self.reading and self.since == self.life:
            pictures.give_up()
        for plane, name in enumerate(self.PLANES):
            if f"{name}.complete" in move or f"{name}.abandoned" in move:
                pictures.end(plane, f"{name}.abandoned" not in move)
            if f"{name}.begin" in move:
                pictures.begin(plane)
        pictures.settle()
        if "display.fetch" in move:
            pictures.fetch()
        if "start" in move:
            pictures.start(slot)
        if "keep" in move:
            pictures.kept, pictures.kept_complete = slot, False
        finished = pictures.kept_complete > kept_complete
        if "let go" in move:
            pictures.kept, pictures.kept_complete = None, False
        self.since = 1 if "done" in move else min(self.since + 1, self.life)
        self.reading = "start" in move or (self.reading and "done" not in move)
        result = {"dropped": pictures.dropped - dropped, "abandoned": pictures.abandoned - abandoned}
        return result | ({"complete": True} if finished else {})


# Slow: with a kept slot; its buffers are part of the random tests of the whole control.
@pytest.mark.parametrize("life, keeps, least", [(2, False, 20000), pytest.param(1, True, 1000, marks=pytest.mark.slow)])
def test_pictures(life, keeps, least):
    dut = PictureSlots(2, life)
    inputs = ["start", "reading", "done", "keep", "held", "display.fetch",
              *(f"{plane}.{event}" for plane in PicturesModel.PLANES for event in ("begin", "complete", "abandoned"))]
    outputs = ["free", "slot", "kept", "complete", "dropped", "abandoned", "display.shown_valid", "display.shown_buffer",
               *(f"{plane}.{member}" for plane in PicturesModel.PLANES for member in ("accept", "buffer"))]
    assert walk(dut, PicturesModel(2, life, keeps), inputs, outputs) > least

import dataclasses

import numpy as np
import pytest

from golden.video.drift import Frames, all_phases, camera_frames, figures, simulate, violations
from golden.video.pairing import CAMERAS, PLANES, Pairing


HZ = 75_000_000
PERIOD = HZ // 25
WINDOW = 5 * PERIOD // 8
#: The display's frames, at 50 Hz.
FETCH = HZ // 50


def run(left, right, *, buffers=2, read=0.375, **options):
    """Clocks of the system as built; ``read`` in periods."""
    trace = simulate(left, right, Pairing(buffers, WINDOW), np.rint(np.multiply(read, PERIOD)).astype(np.int64), FETCH, **options)
    assert violations(trace) == []
    return trace


def test_frames_by_hand():
    """A PAL frame takes 40 ms; 601 of its 625 lines lie between the first active one and the end of the last."""
    frames = camera_frames(1.0, HZ, start=0.5)
    assert frames.begins[:3].tolist() == [1_500_000, 4_500_000, 7_500_000]
    assert (frames.ends - frames.begins == 3_000_000 * 601 // 625).all() and frames.complete.all()
    # Only frames that end within the second; the 25th would not.
    assert len(frames.begins) == 24 and frames.ends[-1] <= HZ < frames.ends[-1] + PERIOD
    assert np.diff(camera_frames(1.0, HZ, ppm=100.0).begins).tolist() == [3_000_300] * 24


def test_lost_frames():
    """Frames 2 and 3 cut, 4 not seen at all; the signal returns within frame 5, which is not seen either."""
    frames = camera_frames(0.5, HZ, lost=[(0.09, 0.1), (0.13, 0.21)])
    number = np.rint(frames.begins / PERIOD).astype(int)
    assert number.tolist() == [0, 1, 2, 3, 6, 7, 8, 9, 10, 11]
    assert np.flatnonzero(~frames.complete).tolist() == [2, 3]
    assert (frames.ends[2:4] / HZ).tolist() == [0.09, 0.13]


def test_jitter():
    rng = np.random.default_rng(1)
    plain, shaken = camera_frames(400.0, HZ), camera_frames(400.0, HZ, jitter=0.01, rng=rng)
    off = shaken.begins - plain.begins[:len(shaken.begins)]
    assert 0.009 * PERIOD < abs(off).max() <= 0.01 * PERIOD and off.min() < 0 < off.max()
    with pytest.raises(ValueError, match=r"^jitter needs rng"):
        camera_frames(1.0, HZ, jitter=0.01)


def clock_by_clock(left, right, control, reads, fetch, *, first_fetch, after_read, keeps):
    """The result of :func:`simulate` by stepping the rule in every clock; rows of pairs, and the buffers of the frames."""
    end = max(*left.ends, *right.ends, *left.begins, *right.begins)
    events = [set() for _ in range(end + 2)]
    for name, frames in zip(CAMERAS, (left, right)):
        for at in frames.begins:
            events[at].add(f"{name}.begin")
        for at, complete in zip(frames.ends, frames.complete):
            events[at].add(f"{name}.complete" if complete else f"{name}.abandoned")
    for asked, let_go in keeps:
        events[asked].add("keep")
        events[let_go].add("let_go")
    rows, buffers, done, finish = [], ([], []), None, None
    newest, begun = [-1, -1], [0, 0]
    for now in range(end + 1):
        events[now] |= {"done"} if now == done else set()
        events[now] |= {f"{plane}.complete" for plane in PLANES} if now == finish else set()
        events[now] |= {"fetch"} if now in range(first_fetch, end + 1, fetch) else set()
        was_shown = control.pictures.shown
        taken = list(newest)
        for side, name in enumerate(CAMERAS):
            if f"{name}.complete" in events[now] and control.cameras[side].filling is not None:
                newest[side] = begun[side] - 1
            begun[side] += f"{name}.begin" in events[now]
        pair = control.clock(now, events[now])
        for side, name in enumerate(CAMERAS):
            if f"{name}.begin" in events[now]:
                filling = control.cameras[side].filling
                buffers[side].append(-1 if filling is None else filling)
        if now == done:
            rows[-1][4] = now
        if now == finish:
            rows[-1][5] = now
        if control.pictures.shown != was_shown:
            next(row for row in reversed(rows) if row[5] >= 0 and row[2] == control.pictures.shown)[6] = now
        if pair is not None:
            done = now + reads[len(rows) % len(reads)]
            finish = done + after_read
            rows.append([*taken, pair.slot, now, -1, -1, -1])
            events[now + 1] |= {f"{plane}.begin" for plane in PLANES}
    return rows, buffers


@pytest.mark.parametrize("seed", range(12))
def test_event_by_event_is_clock_by_clock(seed):
    """With small numbers, where much falls into one clock; frames abandoned, cameras lost, pairs read for longer than a period."""
    rng = np.random.default_rng(seed)
    sides = []
    for _ in range(2):
        starts = rng.integers(0, 40) + np.cumsum(rng.choice([16, 16, 17, 60], 60, p=[0.5, 0.3, 0.15, 0.05]))
        fills = rng.choice([3, 15, 16], 60, p=[0.1, 0.5, 0.4])
        sides.append(Frames(starts, starts + fills, rng.random(60) > 0.1))
    reads = rng.integers(2, (8, 14, 30)[seed % 3], 7)
    buffers, fetch = 2 + seed % 2, int(rng.integers(5, 20))
    options = {"first_fetch": int(rng.integers(0, 200)), "after_read": int(rng.integers(1, 4))}
    edges = np.cumsum(rng.integers(1, 150, 8)).reshape(-1, 2) if seed % 4 else np.zeros((0, 2), dtype=np.int64)
    options["keeps"] = edges.tolist()
    trace = simulate(*sides, Pairing(buffers, 10), reads, fetch, **options)
    rows, used = clock_by_clock(*sides, Pairing(buffers, 10), reads.tolist(), fetch, **options)
    columns = [*trace.numbers, trace.slots, trace.started, trace.read, trace.finished, trace.shown]
    # The last pair may or may not have been read in the clock in which the simulation ends.
    assert np.stack(columns, axis=1)[:-1].tolist() == rows[:len(trace.started) - 1] and len(rows) - len(trace.started) in (0, 1)
    assert [list(side) for side in trace.buffers] == list(used)
    assert len(rows) > 15 and violations(trace) == []


def slips(left, right):
    """How often one camera gains a frame on the other."""
    return abs(len(left.begins) - len(right.begins)) + 1


@pytest.mark.parametrize("ppm, buffers, read, start", [(-50.0, 2, 0.375, 0.6), (10.0, 3, 0.97, 0.3)])
def test_hours(ppm, buffers, read, start):
    """Three hours: no frame skipped, a pair for each frame of the slower camera but one a beat, all pictures shown."""
    left, right = camera_frames(3 * 3600, HZ), camera_frames(3 * 3600, HZ, ppm=ppm, start=start)
    assert len(left.begins) + len(right.begins) > 539_990
    found = figures(run(left, right, buffers=buffers, read=read))
    slower = min(len(left.begins), len(right.begins))
    assert slower - slips(left, right) <= found.pairs <= slower
    assert found.skipped == (0, 0)
    assert found.apart <= WINDOW and found.gap <= 11 * PERIOD // 8 + PERIOD // 1000
    assert sum(found.unpaired) <= slips(left, right)
    assert found.pairs - found.shown <= 2


@pytest.mark.parametrize("ppm", [0.0, 300.0, -1000.0, 20_000.0])
@pytest.mark.parametrize("buffers, read", [(2, 0.05), (2, 0.36), (3, 0.9)])
def test_jitter_and_drift(ppm, buffers, read):
    """Ten minutes; frames begin up to 1/100 of a period early or late, reading times vary. Jitter does not throw pairs back and forth."""
    rng = np.random.default_rng(1)
    left, right = (camera_frames(600.0, HZ, ppm=drift, start=start, jitter=0.01, rng=rng) for drift, start in ((0.0, 0.01), (ppm, 0.63)))
    found = figures(run(left, right, buffers=buffers, read=rng.uniform(0.02, read, 101), after_read=2000))
    slower = min(len(left.begins), len(right.begins))
    assert slower - slips(left, right) <= found.pairs <= slower
    assert found.skipped == (0, 0) and sum(found.unpaired) <= 2 * slips(left, right)


@pytest.mark.parametrize("start", [0.0, 0.49, 0.5, 0.51, 0.62, 0.63, 0.9, 7.3, 50.0])
def test_started_apart(start):
    """The frames of the camera that was there first find no partner until the other one starts; from then on each does."""
    left, right = camera_frames(10.0, HZ), camera_frames(10.0, HZ, start=start)
    trace = run(left, right, read=0.14)
    found = figures(trace)
    assert len(right.begins) - 1 <= found.pairs <= len(right.begins)
    assert found.unpaired == (int(max(0, np.ceil(start - 0.625))), 0)
    assert found.gap == PERIOD


@pytest.mark.parametrize("buffers, read", [(2, 0.14), (2, 0.375), (3, 0.95)])
@pytest.mark.parametrize("which", [0, 1])
def test_lost_camera(which, buffers, read):
    """Lost at any moment for any time, again and again: nothing starts in between, the first pair after it is of the frames after it."""
    rng = np.random.default_rng(which)
    edges = np.cumsum(rng.uniform(0.1, 0.6, 200))
    lost = list(zip(edges[::2].tolist(), edges[1::2].tolist()))
    seconds = edges[-1] + 1
    sides = [camera_frames(seconds, HZ, ppm=50.0 * side, start=0.4 * side, lost=lost if side == which else ()) for side in (0, 1)]
    trace = run(*sides, buffers=buffers, read=read)
    begins = [frames.begins[number] / HZ for frames, number in zip(trace.frames, trace.numbers)]
    for first, last in lost:
        pair = int(np.searchsorted(begins[which], last))
        # Both frames of the next pair began after the camera was back, but for the window.
        assert min(side[pair] for side in begins) >= last - 0.025
        assert begins[which][pair] <= last + 3 * 0.04
        during = (trace.started > (first + 0.1) * HZ) & (trace.started < last * HZ)
        assert not during.any()


def test_both_lost_while_a_pair_is_read():
    """What waits for the reader when both cameras go is used if it is not older than the life of a frame, and else is not."""
    for stall, pairs in ((1.5, 2), (3.0, 1)):
        frames = camera_frames(10.3, HZ, lost=[(0.081, 10.0)])
        trace = run(frames, frames, read=stall, buffers=3)
        assert np.count_nonzero(trace.started < 10 * HZ) == pairs < len(trace.started)


@pytest.mark.parametrize("read, buffers, skipped, lost", [
    (0.375, 2, False, False), (0.41, 2, False, False), (0.42, 2, True, False), (0.5, 2, True, False), (0.6, 2, True, True),
    (0.95, 2, True, True), (0.6, 3, False, False), (0.97, 3, False, False), (1.1, 3, False, True),
])
def test_where_buffers_stop_being_enough(read, buffers, skipped, lost):
    """Over all phases. Double buffers: 2 periods less the window less the time that a frame takes to fill one, 0.413 of a period."""
    trace = all_phases(buffers, read, ppm=1000.0)
    found = figures(trace)
    assert violations(trace) == []
    assert (sum(found.skipped) > 0) == skipped
    assert (min(len(frames.begins) for frames in trace.frames) - found.pairs > 1) == lost


@pytest.mark.parametrize("needed, read", [(2, 0.05), (2, 0.41), (3, 0.97)])
def test_no_frame_is_skipped_while_a_pair_is_kept(needed, read):
    """Over all phases, with one buffer more than needed, kept for any time, again and again: the pairs are those of one that keeps none."""
    edges = np.cumsum(np.random.default_rng(1).integers(1, 8 * PERIOD, 240))
    plain, *others = (all_phases(buffers, read, ppm=1000.0, keeps=keeps) for buffers, keeps in (
        (needed, []), (needed + 1, [(0, 10**12)]), (needed + 1, edges.reshape(-1, 2))))
    for trace in others:
        assert violations(trace) == [] and figures(trace).skipped == (0, 0)
        assert np.array_equal(trace.numbers, plain.numbers) and np.array_equal(trace.started, plain.started)
        assert np.array_equal(trace.shown, plain.shown)
    # One buffer less does not do.
    assert min(figures(all_phases(needed, read, ppm=1000.0, keeps=[(0, 10**12)])).skipped) > 0


@pytest.fixture(scope="module")
def kept():
    left, right = camera_frames(4.0, HZ), camera_frames(4.0, HZ, ppm=3000.0, start=0.3)
    trace = run(left, right, buffers=3, keeps=[(10 * PERIOD, 30 * PERIOD)])
    assert len(trace.started) > 90
    return trace


def changed(array, at, by):
    result = array.copy()
    result[at] += by
    return result


@pytest.mark.parametrize("what, changes", [
    ("began more than the window apart", lambda t: {"frames": (t.frames[0], t.frames[1]._replace(
        begins=changed(t.frames[1].begins, t.numbers[1][50], WINDOW)))}),
    ("left frame had been used", lambda t: {"numbers": (changed(t.numbers[0], 50, -1), t.numbers[1])}),
    ("right frame had been used", lambda t: {"numbers": (t.numbers[0], changed(t.numbers[1], 50, -1))}),
    ("right frame was not the latest complete one", lambda t: {"numbers": (t.numbers[0], changed(t.numbers[1], 50, -1))}),
    ("left frame was not the latest complete one", lambda t: {"frames": (t.frames[0]._replace(
        complete=t.frames[0].complete & (np.arange(len(t.frames[0].begins)) != t.numbers[0][50])), t.frames[1])}),
    ("left frame was stale", lambda t: {"frames": (t.frames[0]._replace(begins=changed(t.frames[0].begins, t.numbers[0][50], -2 * PERIOD)),
                                                   t.frames[1])}),
    ("overwritten while it was kept", lambda t: {"buffers": (t.buffers[0], np.arange(len(t.buffers[1])) % 3)}),
    ("overwritten while it was kept", lambda t: {"slots": np.arange(len(t.slots)) % 3}),
    ("overwritten while it was kept", lambda t: {"keeps": t.keeps + [[0, PERIOD]]}),
    ("left frame was overwritten while it was read", lambda t: {"buffers": (changed(t.buffers[0], t.numbers[0][50] + 1, 0) * 0,
                                                                            t.buffers[1])}),
    ("next one started while it was being read", lambda t: {"read": changed(t.read, 50, PERIOD)}),
    ("its picture was overwritten while it was shown", lambda t: {"slots": t.slots * 0}),
    ("its picture was finished before it was read", lambda t: {"finished": changed(t.finished, 50, -1)}),
    ("its picture was shown before it was finished", lambda t: {"shown": changed(t.shown, 50, -PERIOD)}),
])
def test_broken_promises_are_found(kept, what, changes):
    assert any(what in found for found in violations(dataclasses.replace(kept, **changes(kept))))

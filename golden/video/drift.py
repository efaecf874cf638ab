"""Event simulation of hours of drifting cameras under the rule of :mod:`golden.video.pairing`, and a check of its guarantees."""

import heapq
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .formats import PAL, CameraFormat
from .pairing import WINDOW, Pairing


__all__ = ["Figures", "Frames", "Trace", "all_phases", "camera_frames", "figures", "simulate", "violations"]


Integers = NDArray[np.int64]
_NEVER = np.iinfo(np.int64).max


class Frames(NamedTuple):
    """Frames of one camera, in order of time.

    ``begins``: clocks of the first pixel. ``ends``: clocks in which the memory accepts the last word, or in which the frame is abandoned.
    ``complete``: which of the two. A frame begins after the one before has ended, or in the same clock.
    """
    begins: Integers
    ends: Integers
    complete: NDArray[np.bool_]


def camera_frames(seconds: float, clock_hz: int, *, camera: CameraFormat = PAL, ppm: float = 0.0, start: float = 0.0,
                  jitter: float = 0.0, lost: Iterable[tuple[float, float]] = (), rng: np.random.Generator | None = None) -> Frames:
    """The frames that a camera sends.

    Parameters
    ----------
    seconds : float
        Duration from the start of the system.
    clock_hz : int
        Frequency of the control, in whose clocks times are counted.
    camera : :class:`CameraFormat`
    ppm : float
        Deviation of its period from nominal, in millionths; positive is longer.
    start : float
        Beginning of its first frame, in periods.
    jitter : float
        Each frame begins up to so many periods earlier or later; less than the blanking between frames.
    lost : iterable of (float, float)
        Intervals without a signal, in seconds. A frame whose end is lost is abandoned; one whose beginning is lost is not seen.
    rng : :class:`numpy.random.Generator`
        For the jitter.
    """
    period = camera.frame_seconds * (1 + ppm * 1e-6)
    # From the first active line of the top field to the last of the bottom one.
    fill = (camera.frame_lines - camera.before_top - camera.after_bottom) / camera.frame_lines * period
    count = int(max(0.0, (seconds - fill) / period - start - jitter)) + 1
    begins = (np.arange(count) + start) * period
    if jitter:
        if rng is None:
            raise ValueError("jitter needs rng, a generator of random numbers")
        begins += rng.uniform(-jitter, jitter, count) * period
    ends = begins + fill
    complete = np.ones(count, dtype=np.bool_)
    for first, last in lost:
        seen = (begins < first) | (begins >= last)
        begins, ends, complete = begins[seen], ends[seen], complete[seen]
        cut = (begins < first) & (ends > first)
        ends[cut], complete[cut] = first, False
    clocks = [np.rint(times * clock_hz).astype(np.int64) for times in (begins, ends)]
    return Frames(clocks[0], clocks[1], complete)


@dataclass(frozen=True)
class Trace:
    """Record of a simulation. Times are clocks, -1 for events that did not happen.

    ``frames``: of either camera. ``buffers``: the buffer of each frame, -1 if it was skipped.

    ``keeps``: shape (n, 2), in order of time: clocks in which keeping a pair was asked for, and in which it was let go.

    Of each pair: ``numbers`` of its left and right frames; ``slots`` of its pictures; and the times when it was ``started``, when its last
    pixel was ``read``, when its pictures were ``finished``, and of the fetch from which on they were ``shown``.

    ``control``: its final state, with its counters.
    """
    frames: tuple[Frames, Frames]
    buffers: tuple[Integers, Integers]
    numbers: tuple[Integers, Integers]
    slots: Integers
    started: Integers
    read: Integers
    finished: Integers
    shown: Integers
    control: Pairing
    keeps: Integers


# Events other than the cameras', in their order within a clock.
_LET_GO, _KEEP, _DECIDE, _DONE, _FINISH, _FETCH = range(6)


def simulate(left: Frames, right: Frames, control: Pairing, read: int | Integers, fetch: int, *, first_fetch: int = 0,
             after_read: int = 0, keeps: Iterable[tuple[int, int]] = ()) -> Trace:
    """Simulate the control from event to event, up to the cameras' last one.

    Parameters
    ----------
    left, right : :class:`Frames`
    control : :class:`Pairing`
    read : int or array of int
        Clocks in which a pair is read, at least 1; the values of an array are used in turn, again and again.
    fetch, first_fetch : int
        Clocks between two fetches of the display, and until the first one.
    after_read : int
        Clocks from the last pixel read until the pictures are complete.
    keeps : iterable of (int, int)
        Clocks in which keeping a pair is asked for, and in which it is let go; in order of time, no two clocks the same.
    """
    reads = np.atleast_1d(np.asarray(read, dtype=np.int64)).tolist()
    cameras, pictures = control.cameras, control.pictures
    buffers: tuple[list[int], list[int]] = ([], [])
    pairs: list[list[int]] = []             # rows of two frame numbers, slot, four times
    newest = [-1, -1]                       # frame in each camera's latest buffer
    # Both take effect in the next clock, before all else.
    keeps = np.array(list(keeps), dtype=np.int64).reshape(-1, 2)
    pending = [(at + 1, what) for asked, let_go in keeps.tolist() for at, what in ((asked, _KEEP), (let_go, _LET_GO))]
    heapq.heapify(pending)

    def look(now: int) -> None:
        if not control.reading and pictures.writing is None and cameras[0].latest is not None and cameras[1].latest is not None:
            heapq.heappush(pending, (now + 1, _DECIDE))

    for now, begins, side, number, whole in _events(left, right):
        while pending and pending[0][0] <= now:
            at, what = heapq.heappop(pending)
            if what in (_KEEP, _LET_GO):
                control.keep = what == _KEEP
                control.settle_kept()
                look(at - 1)
                continue
            if what == _DECIDE:
                if (pair := control.decide(at)) is not None:
                    heapq.heappush(pending, (at + reads[len(pairs) % len(reads)], _DONE))
                    pairs.append([*newest, pair.slot, at, -1, -1, -1])
                    for plane in (0, 1):
                        pictures.begin(plane)
                continue
            if what == _DONE:
                control.done(at)
                pairs[-1][4] = at
                heapq.heappush(pending, (at + after_read, _FINISH))
            elif what == _FINISH:
                for plane in (0, 1):
                    pictures.end(plane, complete=True)
                pictures.settle()
                pairs[-1][5] = at
                heapq.heappush(pending, (max(at + (first_fetch - at) % fetch, first_fetch), _FETCH))
            elif pictures.latest is not None:
                # No pair has started since the latest picture was finished, or the newest one is not finished yet.
                pairs[-1 if pairs[-1][5] >= 0 else -2][6] = at
                pictures.fetch()
            look(at)
        if begins:
            buffer = cameras[side].begin(now)
            buffers[side].append(-1 if buffer is None else buffer)
        else:
            if whole and cameras[side].filling is not None:
                newest[side] = number
            cameras[side].end(now, whole)
            look(now)

    of_left, of_right, slots, started, read_at, finished, shown = np.array(pairs, dtype=np.int64).reshape(-1, 7).T
    return Trace((left, right), (np.array(buffers[0], dtype=np.int64), np.array(buffers[1], dtype=np.int64)), (of_left, of_right),
                 slots, started, read_at, finished, shown, control, keeps)


def _events(left: Frames, right: Frames) -> Iterator[tuple[int, bool, int, int, bool]]:
    """Time, whether a frame begins, camera, frame, whether it is complete; in order of time, within a clock ends before beginnings."""
    rows = [np.stack([times, np.full(len(times), begins), np.full(len(times), side), np.arange(len(times)), frames.complete])
            for begins in (0, 1) for side, frames in enumerate((left, right)) for times in [frames.begins if begins else frames.ends]]
    table = np.concatenate(rows, axis=1)
    yield from zip(*table[:, np.argsort(table[0], kind="stable")].tolist(), strict=True)


def violations(trace: Trace) -> list[str]:
    """Guarantees that were violated, in words; derived from the times of the trace, not from the rule."""
    window, life = trace.control.window, trace.control.life
    found = []

    def demand(kept: NDArray[np.bool_], what: str) -> None:
        if not kept.all():
            found.append(f"pair {np.argmin(kept)}: {what}")

    read, shown = (np.where(times < 0, _NEVER, times) for times in (trace.read, trace.shown))
    demand(trace.started[1:] >= read[:-1], "the next one started while it was being read")
    began = [frames.begins[number] for frames, number in zip(trace.frames, trace.numbers, strict=True)]
    demand(abs(began[0] - began[1]) <= window, "its frames began more than the window apart")

    for camera, frames, buffers, number in zip(("left", "right"), trace.frames, trace.buffers, trace.numbers, strict=True):
        demand(np.diff(number, prepend=-1) > 0, f"its {camera} frame had been used")
        demand(trace.started - frames.begins[number] < life, f"its {camera} frame was stale")
        stored = np.flatnonzero((buffers >= 0) & frames.complete)
        latest = np.searchsorted(frames.ends[stored], trace.started) - 1
        demand(number == np.append(stored, -1)[latest], f"its {camera} frame was not the latest complete one")
        overwritten = _next_use(buffers, frames.begins)[number]
        demand(overwritten >= read, f"its {camera} frame was overwritten while it was read")

    # A slot is shown from a fetch to the next one that switched to another picture.
    turns = np.append(np.sort(shown), _NEVER)
    replaced = turns[np.searchsorted(turns, shown, side="right").clip(max=len(turns) - 1)]
    demand((_next_use(trace.slots, trace.started) >= replaced) | (shown == _NEVER), "its picture was overwritten while it was shown")
    # The first pair that started after it was asked for.
    for asked, let_go in trace.keeps.tolist():
        pair = int(np.searchsorted(trace.started, asked, side="right"))
        if pair < len(trace.started):
            uses = [_next_use(buffers, frames.begins)[number[pair]]
                    for buffers, frames, number in zip(trace.buffers, trace.frames, trace.numbers, strict=True)]
            if min(*uses, _next_use(trace.slots, trace.started)[pair]) <= let_go:
                found.append(f"pair {pair}: it was overwritten while it was kept")
    demand((trace.finished >= read) | (trace.finished < 0), "its picture was finished before it was read")
    demand((trace.shown >= trace.finished) & (trace.finished >= 0) | (trace.shown < 0), "its picture was shown before it was finished")
    return found


def _next_use(buffers: Integers, times: Integers) -> Integers:
    """Time of the next write to the buffer of each frame."""
    result = np.full(len(buffers), _NEVER)
    for buffer in np.unique(buffers[buffers >= 0]):
        users = np.flatnonzero(buffers == buffer)
        result[users[:-1]] = times[users[1:]]
    return result


@dataclass(frozen=True)
class Figures:
    """``pairs``, ``shown``: numbers of pairs and of pictures shown. ``apart``: greatest time between the beginnings of a pair's frames.
    ``gap``: longest time from one pair's start to the next. ``age``: greatest age of a frame as its pair starts. Times are clocks.
    ``skipped``, ``unpaired``: frames of either camera.
    """
    pairs: int
    shown: int
    apart: int
    gap: int
    age: int
    skipped: tuple[int, int]
    unpaired: tuple[int, int]


def figures(trace: Trace) -> Figures:
    """The figures of a trace, which must have at least two pairs."""
    left, right = (frames.begins[number] for frames, number in zip(trace.frames, trace.numbers, strict=True))
    cameras = trace.control.cameras
    return Figures(
        pairs=len(trace.started), shown=int((trace.shown >= 0).sum()),
        apart=int(abs(left - right).max()), gap=int(np.diff(trace.started).max()), age=int((trace.started - np.minimum(left, right)).max()),
        skipped=(cameras[0].skipped, cameras[1].skipped), unpaired=(cameras[0].unpaired, cameras[1].unpaired))


def all_phases(buffers: int, read: float, *, clock_hz: int = 75_000_000, ppm: float = 300.0, camera: CameraFormat = PAL,
               keeps: Iterable[tuple[int, int]] = ()) -> Trace:
    """Simulate cameras that drift by one frame against each other, through every phase, with a reading time of ``read`` periods.

    The display is the slowest one, 50 frames a second. ``keeps`` as of :func:`simulate`.

    Examples
    --------
    Double buffers are enough up to 3/8 of a period, slightly more thanks to blanking:

    >>> [figures(all_phases(2, read)).skipped for read in (0.375, 0.41, 0.42, 0.6)]
    [(0, 0), (0, 0), (1, 0), (104, 103)]
    """
    period = camera.frame_seconds * clock_hz
    seconds = (1e6 / ppm + 2) * camera.frame_seconds
    left, right = (camera_frames(seconds, clock_hz, camera=camera, ppm=drift, start=start) for drift, start in ((0.0, 0.0), (ppm, 0.5)))
    return simulate(left, right, Pairing(buffers, int(WINDOW * round(period))), int(read * period), clock_hz // 50,
                    keeps=keeps)

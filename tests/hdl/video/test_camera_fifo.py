# amaranth: UnusedElaboratable=no
"""Back-pressure, a full FIFO, stopped clocks and resets: whole frames are dropped, marked and counted."""

import numpy as np
import pytest

from golden.video.formats import PAL
from hdl.parts.crossing import ClockWatch
from hdl.video.bt656 import CameraInput
from sim.models.camera import STOPPED, Camera
from tests.hdl.video.camera_runs import SMALL, TINY, WIDE, pictures, run_camera
from tests.kit import by_turns


PIXELS = TINY.width * TINY.height


def receiver(format=TINY, depth=8):
    return CameraInput(format, "camera", depth=depth)


def film(count, format=TINY, seed=1):
    data, expected = Camera(format, seed=seed).film(pictures(count, format, seed))
    return data, [picture.tolist() for picture in expected]


def frames_of(run, format=TINY):
    return [None if frame is None else frame.tolist() for frame in run.frames(format)]


def whole(run, format=TINY):
    return [frame for frame in frames_of(run, format) if frame is not None]


def test_depth():
    for depth in (4, 12, 0):
        with pytest.raises(ValueError, match=rf"power of two of words, at least 8, not {depth}$"):
            receiver(depth=depth)


@pytest.mark.parametrize("ratio", [27 / 75, 1.01])
def test_stall_that_is_ridden_out(ratio):
    """As long as stated, at every place in a frame; half as long again costs the frame."""
    data, expected = film(2, WIDE)
    cycles = CameraInput.stall_cycles(WIDE, 16, WIDE.byte_clock_hz / ratio)
    assert cycles == int(24 / ratio)
    within = (WIDE.before_top * WIDE.line_bytes + 8 + WIDE.blanking + 2) / ratio
    for start in (within, within + 7 / ratio):
        run = run_camera(receiver(WIDE, depth=16), data, ratio=ratio, stall=lambda cycle: float(start <= cycle < start + cycles))
        assert frames_of(run, WIDE) == expected
        assert run.counters == {}
    # A line has no more than 16 pixels: the next one meets the full FIFO.
    longer = 2.5 * WIDE.line_bytes / ratio
    run = run_camera(receiver(WIDE, depth=16), data, ratio=ratio, stall=lambda cycle: float(within <= cycle < within + longer))
    assert frames_of(run, WIDE) == [None, *expected[1:]]
    assert run.counters == {"dropped": 1, "overflow": 1}


def test_stated_depth():
    assert CameraInput.stall_cycles(PAL, 512, 75e6) == 2822


def test_nobody_takes_a_word():
    """The first frame is cut, the others are not taken; all are counted, the camera stays present; the one after that is exact."""
    data, expected = film(5)
    until = 3.5 * TINY.frame_bytes / 1.01
    run = run_camera(receiver(), data, ratio=1.01, stall=lambda cycle: float(cycle < until))
    assert frames_of(run) == [None, *expected[4:]]
    assert run.counters == {"dropped": 4, "overflow": 4}
    assert run.member("present")[-1] == 1
    assert np.sum(np.diff(run.member("present")) != 0) == 1


def test_full_by_each_pixel():
    """The FIFO takes up words until the pixel that does not fit, wherever in the frame that is, and the drop word then."""
    data, expected = film(3)
    lost = set()
    for start in range(10, TINY.frame_bytes, 14):
        run = run_camera(receiver(), data, ratio=1.01, stall=lambda cycle: float(start <= cycle < start + 85))
        frames = frames_of(run)
        counters = run.counters
        assert whole(run) == [picture for picture in expected if picture in frames]
        assert frames[-1] == expected[-1]
        assert len(whole(run)) + counters.get("dropped", 0) == 3
        assert counters.get("overflow", 0) == counters.get("dropped", 0)
        lost.add(counters.get("dropped", 0))
    assert lost == {0, 1}


def test_full_as_a_frame_begins():
    """The last word of a frame is the last that finds room: it is whole, and the next one is not taken at all."""
    data, expected = film(3)
    until = TINY.frame_bytes + 60
    outcomes = []
    for start in range(56, 76, 3):
        run = run_camera(receiver(), data, ratio=1, stall=lambda cycle: float(start <= cycle < until))
        lost = 3 - len(whole(run))
        assert run.counters == {"dropped": lost, "overflow": lost}
        outcomes.append([frame in frames_of(run) for frame in (*expected, None)])
    assert [True, False, True, False] in outcomes


def test_room_as_a_frame_begins():
    """A drop word that waited is sent before it; if both are in the same cycle, the frame is discarded."""
    data, expected = film(2)
    begins = TINY.frame_bytes + TINY.before_top * TINY.line_bytes + 8 + TINY.blanking
    taken = set()
    for ready in range(begins - 6, begins + 8):
        run = run_camera(receiver(), data, ratio=1, stall=lambda cycle: float(cycle < ready))
        frames = frames_of(run)
        assert frames in ([None], [None, expected[1]])
        assert run.counters == {"dropped": 3 - len(frames), "overflow": 3 - len(frames)}
        taken.add(len(frames))
    assert taken == {1, 2}


@pytest.mark.parametrize("seed", range(3))
def test_moods_of_the_consumer(seed):
    """However the consumer stalls, each frame is complete or closed by a drop word, and is counted once."""
    count = 20
    data, expected = film(count, seed=seed)
    moods = np.random.default_rng(seed).choice([0.0, 0.4, 1.0], 80)
    moods[-4:] = 0.0
    cycles = count * TINY.frame_bytes / 1.01 / len(moods)
    run = run_camera(receiver(), data, ratio=1.01, seed=seed, stall=lambda cycle: moods[min(int(cycle / cycles), len(moods) - 1)])
    frames = whole(run)
    assert frames == [picture for picture in expected if picture in frames]
    assert run.counters == {"dropped": count - len(frames), "overflow": count - len(frames)}
    assert 2 < len(frames) < count - 1
    assert None in frames_of(run)


# A stop of the clock, in bytes' time, that is surely seen, and one that is surely not.
LONG, SHORT = ClockWatch.TIMEOUT + 60, ClockWatch.TIMEOUT // 2


def stopped_at(data, place, time):
    return np.insert(data, place, [STOPPED] * time)


ACTIVE = [place for line in (TINY.before_top, TINY.before_top + 1, TINY.before_top + TINY.field_lines + 3)
          for place in (line * TINY.line_bytes + 20, line * TINY.line_bytes + 17)]


@pytest.mark.parametrize("place, stall", by_turns([(place,) for place in (*ACTIVE, 5 * TINY.line_bytes)], (0, 0.3)))
def test_clock_stops(place, stall):
    """Long: the frame is dropped while the clock stands, and once; short: nothing happens."""
    data, expected = film(3)
    at = TINY.frame_bytes + place
    run = run_camera(receiver(), stopped_at(data, at, LONG), ratio=1, stall=stall)
    assert frames_of(run) == [expected[0], None, expected[2]]
    assert run.counters == {"dropped": 1}
    present = np.flatnonzero(np.diff(run.member("present")))
    assert len(present) == 3
    fall = present[1]
    assert ClockWatch.TIMEOUT - ClockWatch.DIVISOR - 4 < fall - at < ClockWatch.TIMEOUT + ClockWatch.DIVISOR + 8
    (drop,) = [cycle for word, cycle in zip(run.words, run.cycles) if word.drop]
    assert fall <= drop < at + LONG
    short = run_camera(receiver(), stopped_at(data, at, SHORT), ratio=1, stall=stall)
    assert frames_of(short) == expected
    assert short.counters == {}


def test_clock_stops_for_good():
    """Then nothing hangs: the frame is dropped, and no more is offered."""
    data, expected = film(2)
    cut = data[:TINY.frame_bytes + ACTIVE[2]]
    run = run_camera(receiver(), cut, ratio=1, drain=ClockWatch.TIMEOUT + 100)
    assert frames_of(run) == [expected[0], None]
    assert run.counters == {"dropped": 1}
    assert run.member("present")[-1] == 0


def test_clock_stops_between_frames():
    """Nothing is in progress: nothing is dropped, be it after a whole frame or after one that was dropped."""
    for fault in ({}, {0: "long line"}):
        data, expected = Camera(TINY, seed=1).film(pictures(3, TINY), fault)
        at = len(data) - 2 * TINY.frame_bytes + 5
        run = run_camera(receiver(), stopped_at(data, at, LONG), ratio=1)
        assert whole(run) == [picture.tolist() for picture in expected]
        assert frames_of(run).count(None) == len(fault)
        assert run.counters == ({"dropped": 1} if fault else {})


def test_clock_stops_while_the_consumer_stalls():
    """The word that is offered stays; the drop word follows, though the clock runs again by then."""
    data, expected = film(3)
    at = TINY.frame_bytes + ACTIVE[2]
    run = run_camera(receiver(depth=32), stopped_at(data, at, LONG), ratio=1, stall=lambda cycle: float(at - 12 <= cycle < at + LONG + 40))
    assert frames_of(run) == [expected[0], None, expected[2]]
    assert run.counters == {"dropped": 1}


@pytest.mark.parametrize("ratio", [27 / 75, 1.5])
def test_reset_of_the_camera(ratio):
    """Of its clock domain, in mid-frame: the frame is dropped, and the next one is exact; between frames it costs nothing."""
    data, expected = film(3, SMALL)
    first = SMALL.before_top * SMALL.line_bytes + 8 + SMALL.blanking
    for place in (-11, first + 16, first + SMALL.line_bytes + 3, first + 6 * SMALL.line_bytes):
        at = SMALL.frame_bytes + place
        run = run_camera(receiver(SMALL), data, ratio=ratio, camera_resets=[at, at + 8])
        assert frames_of(run, SMALL) == ([expected[0], None, expected[2]] if place > 0 else expected)
        assert run.counters == ({"dropped": 1} if place > 0 else {})


def test_reset_of_the_camera_while_the_consumer_stalls():
    data, expected = film(3)
    at = TINY.frame_bytes + ACTIVE[2]
    run = run_camera(receiver(depth=32), data, ratio=1, camera_resets=[at, at + 8], stall=lambda cycle: float(at - 12 <= cycle < at + 60))
    assert frames_of(run) == [expected[0], None, expected[2]]
    assert run.counters == {"dropped": 1}


def test_reset_of_the_consumer():
    """In mid-frame: the rest of the frame is discarded, and only later events are counted."""
    data, expected = film(4, SMALL)
    data[3] ^= 1    # an odd number of events before the reset
    for at in (SMALL.frame_bytes + 100, SMALL.frame_bytes + 3):
        resets = range(at, at + 4)
        run = run_camera(receiver(SMALL, depth=32), data, ratio=1, resets=resets)
        # Words of the frame that was cut off by the reset have no end.
        before = [word for word, cycle in zip(run.words, run.cycles) if cycle < at]
        run.words = run.words[len(before):]
        assert frames_of(run, SMALL) == (expected[2:] if at > SMALL.frame_bytes + 50 else expected[1:])
        assert run.counters == {}

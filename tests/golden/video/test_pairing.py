"""The frame store's rule, worked by hand. Cameras over hours: `test_drift.py`."""

import pytest

from golden.video.bandwidth import Budget
from golden.video.pairing import WINDOW, Pair, Pairing, buffers_needed, check_window


def play(control, events, until):
    """Each clock from 0 on; ``{clock: pair}`` of those in which one starts."""
    pairs = {}
    for now in range(until):
        pair = control.clock(now, events.get(now, "").split())
        if pair is not None:
            pairs[now] = pair
    return pairs


def test_first_pair():
    """Frames that begin 4 apart and take 12; the pair starts in the clock after the second is complete."""
    control = Pairing(2, 5)
    events = {0: "left_camera.begin", 4: "right_camera.begin", 12: "left_camera.complete", 16: "right_camera.complete"}
    assert play(control, events, 18) == {17: Pair(0, 0, 0)}
    left, right = control.cameras
    assert left.reading == right.reading == 0 and left.latest is right.latest is None
    assert control.reading and control.pairs == 1 and control.pictures.writing == 0


@pytest.mark.parametrize("apart, pairs", [(5, 1), (6, 0)])
@pytest.mark.parametrize("first, second", [("left_camera", "right_camera"), ("right_camera", "left_camera")])
def test_window(first, second, apart, pairs):
    events = {0: f"{first}.begin", apart: f"{second}.begin", 7: f"{first}.complete", 15: f"{second}.complete"}
    assert len(play(Pairing(2, 5, 100), events, 30)) == pairs


def test_double_buffers_swap():
    """The left camera alone: its frames go to one buffer and the other, each takes the place of the one before."""
    left = Pairing(2, 5, 100).cameras[0]
    for number, buffer in enumerate([0, 1, 0, 1]):
        assert left.begin(10 * number) == buffer
        left.end(10 * number + 9, complete=True)
        assert left.latest == buffer and left.filling is None
    assert (left.unpaired, left.skipped) == (3, 0)


@pytest.mark.parametrize("buffers, taken, skipped", [(2, None, 1), (3, 2, 0)])
def test_frame_without_a_buffer_is_skipped(buffers, taken, skipped):
    """Buffer 0 is being read and 1 holds the latest frame: with two buffers the new frame is skipped whole, its end means nothing."""
    control = Pairing(buffers, 5, 100)
    left = control.cameras[0]
    play(control, {0: "left_camera.begin right_camera.begin", 9: "left_camera.complete right_camera.complete",
                   11: "left_camera.begin", 20: "left_camera.complete"}, 21)
    assert (left.reading, left.latest) == (0, 1)
    assert left.begin(21) == taken and left.filling == taken and left.skipped == skipped
    left.end(30, complete=True)
    assert left.latest == (1 if taken is None else taken)


def test_abandoned_frame_frees_its_buffer():
    control = Pairing(2, 5, 100)
    left = control.cameras[0]
    events = {0: "left_camera.begin", 5: "left_camera.abandoned",
              6: "left_camera.begin", 9: "left_camera.complete left_camera.abandoned",      # abandoned counts
              10: "left_camera.begin", 12: "left_camera.begin", 13: "left_camera.complete"}  # without an end: abandoned
    assert play(control, events, 14) == {}
    assert (left.latest, left.latest_began, left.filling, left.unpaired) == (0, 12, None, 0)


def test_latest_frame_is_used():
    """The right frame was within the window of the first left one; by the time the control may decide, a newer left one is nearer."""
    control = Pairing(2, 8, 100)
    events = {0: "hold left_camera.begin", 8: "right_camera.begin", 9: "left_camera.complete", 10: "left_camera.begin",
              17: "right_camera.complete", 19: "left_camera.complete", 20: "release"}
    assert play(control, events, 30) == {21: Pair(1, 0, 0)}
    assert control.cameras[0].unpaired == 1


def test_waits_for_the_reader_and_for_a_slot():
    """Slot 0 is shown and 1 waits for the display: the third pair waits for a fetch, although it could have been read."""
    control = Pairing(2, 5, 1000)
    both = "left_camera.{0} right_camera.{0}"
    planes = "disparity_plane.{0} left_plane.{0}"
    events = {0: both.format("begin"), 9: both.format("complete"), 11: planes.format("begin"), 20: both.format("begin"),
              29: both.format("complete"), 34: "done", 35: planes.format("complete"), 36: "fetch",
              38: planes.format("begin"), 40: both.format("begin"), 41: "done", 42: planes.format("complete"), 49: both.format("complete"),
              60: "fetch"}
    assert play(control, events, 70) == {10: Pair(0, 0, 0), 36: Pair(1, 1, 1), 61: Pair(0, 0, 0)}
    assert control.pictures.shown == 1 and control.pictures.dropped == 0


def test_frame_expires():
    """19 clocks old it pairs, 20 clocks old it has expired, whether it was the first or the second to be complete."""
    for late, pairs in ((18, 1), (19, 0)):
        control = Pairing(2, 5, 20)
        events = {0: "left_camera.begin", 2: "right_camera.begin", 9: "left_camera.complete", late: "right_camera.complete"}
        assert len(play(control, events, 60)) == pairs
        assert [camera.unpaired for camera in control.cameras] == [1 - pairs] * 2
    control = Pairing(2, 5, 20)
    play(control, {0: "left_camera.begin", 25: "left_camera.complete"}, 30)
    assert control.cameras[0].latest is None and control.cameras[0].unpaired == 1


@pytest.mark.parametrize("age, taken", [(19, None), (20, 1)])
def test_expired_frame_frees_its_buffer(age, taken):
    """Buffer 0 is being read, 1 holds the latest frame, which began in clock 3: it is free in the very clock of its expiry."""
    control = Pairing(2, 5, 20)
    left = control.cameras[0]
    play(control, {0: "left_camera.begin right_camera.begin", 1: "left_camera.complete right_camera.complete", 3: "left_camera.begin",
                   9: "left_camera.complete", 3 + age: "left_camera.begin"}, 3 + age + 1)
    assert left.reading == 0 and left.filling == taken and left.skipped == (taken is None)


@pytest.mark.parametrize("age, buffer", [(19, 1), (20, 0)])
def test_frame_complete_too_late(age, buffer):
    """It is not kept: the frame that begins in the same clock takes its buffer."""
    for begin in ("", "left_camera.begin"):
        control = Pairing(2, 5, 20)
        play(control, {0: "left_camera.begin", age: f"left_camera.complete {begin}"}, age + 1)
        left = control.cameras[0]
        assert left.filling == (buffer if begin else None) and left.unpaired == (age == 20)


class TestPictures:
    def control(self, slots=2):
        """A pair in clock 2, being read."""
        control = Pairing(slots, 5, 20)
        play(control, {0: "left_camera.begin right_camera.begin", 1: "left_camera.complete right_camera.complete"}, 3)
        assert control.pictures.writing == 0
        return control

    def after(self, control, *clocks, start=3):
        for now, events in enumerate(clocks, start):
            control.clock(now, events.split())
        pictures = control.pictures
        return pictures.writing, pictures.latest, pictures.shown

    def test_complete_when_both_planes_are(self):
        control = self.control()
        assert self.after(control, "left_plane.begin disparity_plane.begin", "left_plane.complete", "fetch") == (0, None, None)
        assert self.after(control, "disparity_plane.complete", start=6) == (None, 0, None)
        assert self.after(control, "fetch", start=7) == (None, None, 0)
        assert self.after(control, "fetch", start=8) == (None, None, 0)

    def test_fetch_of_what_is_complete_in_the_same_clock(self):
        assert self.after(self.control(), "left_plane.begin disparity_plane.begin",
                          "left_plane.complete disparity_plane.complete fetch") == (None, None, 0)

    @pytest.mark.parametrize("events", [
        ("left_plane.abandoned", "disparity_plane.complete"),
        ("left_plane.complete disparity_plane.abandoned",),
        ("left_plane.begin", "disparity_plane.complete"),                               # begins again
        ("left_plane.complete left_plane.abandoned disparity_plane.complete",),
    ])
    def test_abandoned_if_either_plane_is(self, events):
        control = self.control()
        assert self.after(control, "left_plane.begin disparity_plane.begin", *events) == (None, None, None)
        assert control.pictures.abandoned == 1

    def test_slot_is_written_until_both_planes_have_ended(self):
        control = self.control()
        assert self.after(control, "left_plane.begin", "left_plane.abandoned done") == (0, None, None)
        assert self.after(control, "disparity_plane.begin", "disparity_plane.complete", start=5) == (None, None, None)

    def test_ends_before_the_begin_mean_nothing(self):
        """They are of the picture before, which was given up."""
        control = self.control()
        assert self.after(control, "left_plane.complete disparity_plane.complete", "left_plane.abandoned") == (0, None, None)
        assert control.pictures.abandoned == 0

    def test_second_picture_of_a_pair_is_refused(self):
        control = self.control()
        pictures = control.pictures
        assert pictures.begin(0) and pictures.begin(1)
        pictures.end(0, complete=True)
        assert not pictures.begin(0)
        pictures.end(1, complete=True)
        pictures.settle()
        assert not pictures.begin(1) and pictures.latest == 0

    def test_missing_picture_is_given_up(self):
        """20 clocks after the pair was read, not before; a memory that stalls while it is read has all the time."""
        control = self.control()
        assert self.after(control, *[""] * 100, "left_plane.begin done", *["left_plane.complete"] * 19) == (0, None, None)
        assert self.after(control, "", start=123) == (None, None, None)
        assert control.pictures.abandoned == 1

    def test_dropped_for_a_newer_one(self):
        """Nobody fetches: of three slots the next picture takes another, and the older of two complete ones gives way."""
        control = Pairing(3, 5, 100)
        both = "left_plane.{0} disparity_plane.{0}"
        for start in (0, 10):
            now = start
            for events in ("left_camera.begin right_camera.begin", "left_camera.complete right_camera.complete", "", both.format("begin"),
                           "done", both.format("complete")):
                control.clock(now, events.split())
                now += 1
        assert (control.pictures.latest, control.pictures.dropped) == (1, 1)


def test_done_before_the_start_means_nothing():
    """In the clock of the decision the reader has no ``start`` yet."""
    control = Pairing(2, 5, 100)
    play(control, {0: "left_camera.begin right_camera.begin", 1: "left_camera.complete right_camera.complete", 2: "done"}, 4)
    assert control.reading
    control.clock(4, ["done"])
    assert not control.reading


def test_plane_that_begins_as_its_pair_is_decided():
    """It cannot be of that pair."""
    control = Pairing(2, 5, 100)
    play(control, {0: "left_camera.begin right_camera.begin", 1: "left_camera.complete right_camera.complete", 2: "left_plane.begin"}, 3)
    assert control.pictures.begin(1)


def test_hold():
    control = Pairing(2, 5, 100)
    events = {0: "hold left_camera.begin right_camera.begin", 1: "left_camera.complete right_camera.complete", 20: "release"}
    assert play(control, events, 30) == {21: Pair(0, 0, 0)}


class TestKeep:
    FRAMES = "left_camera.{0} right_camera.{0}"
    PLANES = "disparity_plane.{0} left_plane.{0}"

    def pair(self, at):
        """Events of a pair that is decided in clock ``at`` and read, and whose picture is complete, in clock ``at + 5``."""
        return {at - 2: self.FRAMES.format("begin"), at - 1: self.FRAMES.format("complete"), at + 1: self.PLANES.format("begin"),
                at + 5: "done fetch " + self.PLANES.format("complete")}

    def test_first_pair_that_starts(self):
        control = Pairing(3, 5, 100)
        events = {0: "keep", **self.pair(10), **self.pair(20)}
        assert play(control, events, 11) == {10: Pair(0, 0, 0)}
        assert control.kept == Pair(0, 0, 0) and not control.kept_whole
        for now in range(11, 15):
            control.clock(now, events.get(now, "").split())
            assert not control.kept_whole
        control.clock(15, events[15].split())
        assert control.kept_whole
        # The next pairs go elsewhere.
        assert [control.clock(now, events.get(now, "").split()) for now in range(16, 21)][-1] == Pair(1, 1, 1)
        assert control.kept == Pair(0, 0, 0) and control.kept_whole

    def test_pair_being_read_is_not_kept(self):
        control = Pairing(3, 5, 100)
        play(control, {**self.pair(10), 10: "keep"}, 18)
        assert control.pairs == 1 and control.kept is None

    @pytest.mark.parametrize("last", ["done", "left_plane.complete", "disparity_plane.complete"])
    def test_not_before_all_of_it_is_in_memory(self, last):
        control = Pairing(3, 5, 100)
        events = {0: "keep", **self.pair(10)}
        play(control, events | {15: " ".join(name for name in events[15].split() if name != last)}, 30)
        assert not control.kept_whole
        control.clock(30, [last])
        assert control.kept_whole

    @pytest.mark.parametrize("end", ["disparity_plane.abandoned", "left_plane.begin", ""])
    def test_next_one_if_its_picture_is_abandoned(self, end):
        """Abandoned, begun twice, or given up 20 clocks after the pair was read: by then the pair is let go."""
        control = Pairing(3, 5, 20)
        events = {0: "keep", **self.pair(10)}
        play(control, events | {14: end, 15: "done" + (" left_plane.complete disparity_plane.complete" if end else "")}, 36)
        assert control.pictures.abandoned == 1 and control.kept is None and control.cameras[0].kept is control.pictures.kept is None
        for now in range(36, 50):
            control.clock(now, self.pair(40).get(now, "").split())
        assert control.kept == Pair(0, 0, 0) and control.kept_whole

    def test_let_go(self):
        """It takes effect in the next clock: a frame that begins in the same one still finds the buffer occupied."""
        for begin, buffer in ((20, 1), (21, 0)):
            control = Pairing(3, 5, 100)
            events = {0: "keep", **self.pair(10), 20: "let_go"}
            events[begin] = events.get(begin, "") + " left_camera.begin"
            play(control, events, 22)
            assert control.kept is None and control.cameras[0].filling == buffer


def test_life_by_default():
    assert Pairing(2, 5).life == 20


@pytest.mark.parametrize("read, buffers", [(0.001, 2), (0.015, 2), (0.0151, 3), (0.0399, 3)])
def test_buffers_needed(read, buffers):
    assert buffers_needed(read, 0.04) == buffers
    assert (read <= (1 - WINDOW) * 0.04) == (buffers == 2)


def test_buffers_needed_with_another_window():
    assert [buffers_needed(0.010, 0.04, window) for window in (0.5, 0.75, 0.76)] == [2, 2, 3]


@pytest.mark.parametrize("window", [0, -0.5, 1, 2.5])
def test_bad_window(window):
    for use in (check_window, lambda window: buffers_needed(0.01, 0.04, window), lambda window: Budget(window=window)):
        with pytest.raises(ValueError, match=f"^the window of a pair must be above 0 and below 1 frame, not {window}$"):
            use(window)


@pytest.mark.parametrize("read", [0.0, -1.0, 0.04, 1.0])
def test_bad_reading_time(read):
    with pytest.raises(ValueError, match=rf"less than the frame period of 40 ms, not in {read * 1e3:.4g} ms$"):
        buffers_needed(read, 0.04)


def test_too_few_buffers():
    with pytest.raises(ValueError, match=r"at least 2 buffers for each picture, not 1$"):
        Pairing(1, 5)

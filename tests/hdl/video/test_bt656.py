"""The camera's receiver between its two clocks: every fault is counted, costs its frame, and the next good frame is exact."""

import numpy as np
import pytest

from golden.video.bt656 import decode, encode, encode_line, lost_bytes
from hdl.parts.crossing import ClockWatch
from hdl.video.bt656 import CameraInput
from sim.kit.cases import comparable
from sim.models.camera import FAULTS, Camera
from tests.hdl.video.camera_runs import BYTE, RATIOS, SMALL, TINY, WIDE, pictures, run_camera


def receiver(format=SMALL, depth=32):
    return CameraInput(format, "camera", depth=depth)


def lists(frames):
    return [None if frame is None else frame.tolist() for frame in frames]


def whole(frames):
    return [frame.tolist() for frame in frames if frame is not None]


@pytest.mark.parametrize("ratio, stall", [("75 MHz", 0), ("75 MHz", 0.6), ("148.5 MHz", 0.7), ("faster", 0.3), ("slower", 0.3),
                                          ("slowest", 0)])
def test_frames_are_exact(ratio, stall):
    data, expected = Camera(WIDE, seed=1).film(pictures(2, WIDE))
    run = run_camera(receiver(WIDE), data, ratio=RATIOS[ratio], stall=stall)
    assert lists(run.frames(WIDE)) == lists(expected)
    assert run.counters == {}


def test_golden_agrees_with_the_model_of_the_camera():
    """The camera model predicts the effect of its faults; golden agrees, from the bytes alone."""
    for name, fault in FAULTS.items():
        for seed in range(6):
            data, expected = Camera(SMALL, seed=seed).film(pictures(4), {1: name})
            decoded = decode(data[data >= 0], SMALL)
            if name == "clock stopped":     # to golden no time passes
                continue
            assert lists(decoded.pictures) == lists(expected), name
            assert 1 - fault.kept <= decoded.dropped <= 2 * (not fault.kept) + 2 * ("noise" in name or "reset" in name), name


@pytest.mark.parametrize("name", FAULTS)
def test_fault(name):
    """Between two good frames only the faulty one is lost, and counted."""
    fault = FAULTS[name]
    for seed in range(2):
        data, expected = Camera(SMALL, seed=seed).film(pictures(3), {1: name})
        assert len(expected) == 2 + fault.kept
        run = run_camera(receiver(), data, ratio=1.01, stall=0.2, seed=seed)
        assert whole(run.frames(SMALL)) == lists(expected)
        counters = run.counters
        if fault.counter is None:
            assert counters == {}
        elif fault.kept:
            assert counters == {fault.counter: 2 * SMALL.frame_lines}
        else:
            assert counters[fault.counter] > 0
            assert 1 <= counters["dropped"] <= 2 + 2 * ("noise" in name or "reset" in name)
            assert counters["dropped"] >= sum(frame is None for frame in run.frames(SMALL))
        assert "overflow" not in counters
        # It shows in `present` until the next frame is whole, and no longer.
        changes = np.flatnonzero(np.diff(run.member("present")))
        assert len(changes) == (1 if fault.kept else 3)
        assert run.member("present")[-1] == 1
        ends = [cycle for word, cycle in zip(run.words, run.cycles) if word.end]
        assert abs(changes[0] - ends[0]) < 20
        if name != "clock stopped":     # the lines of that frame are all right
            assert abs(changes[-1] - ends[0 if fault.kept else 1]) < 20


def test_two_faults_in_a_row():
    names = [name for name, fault in FAULTS.items() if not fault.kept]
    names.sort(key=lambda name: name != "top field missing")    # after a frame without its bottom field it would complete that one
    faults = dict(enumerate(names, 1))
    data, expected = Camera(SMALL, seed=5).film(pictures(len(names) + 3), faults)
    run = run_camera(receiver(), data, ratio=1.01)
    assert whole(run.frames(SMALL)) == lists(expected)
    assert len(expected) == 3
    assert run.counters["dropped"] >= len(names) - 1      # a top field alone and a bottom field alone make a frame


def damaged(rng, count):
    """Bytes of frames with random faults, about one in a frame and a half."""
    parts = []
    for picture in pictures(count, TINY, int(rng.integers(100))):
        data = encode(picture, TINY)
        while rng.random() < 0.4:
            at = int(rng.integers(len(data)))
            line = at - at % TINY.line_bytes
            code = line + (3 if rng.integers(2) else 7 + TINY.blanking)
            length = int(rng.integers(1, 60))
            match rng.integers(8):
                case 0:
                    data = np.delete(data, range(at, min(at + length, len(data))))
                case 1:
                    data = np.insert(data, at, rng.integers(0, 256, length))
                case 2:
                    data = np.delete(data, range(line, min(line + TINY.line_bytes * int(rng.integers(1, 3)), len(data))))
                case 3:
                    data = np.insert(data, line, data[line:line + TINY.line_bytes])
                case 4 if code < len(data):
                    data[code] ^= 1 << rng.integers(8)
                case 5 if code < len(data):
                    data[code] = rng.integers(256)
                case 6:
                    data[at:at + length] = rng.choice([0, 0, 255, 128], len(data[at:at + length]))
                case 7:
                    data = np.insert(data, at, np.full(int(rng.integers(lost_bytes(TINY) - 6, lost_bytes(TINY) + 6)), 0x10))
        parts.append(data)
    return np.concatenate([*parts, *(encode(picture, TINY) for picture in pictures(2, TINY, 1))])


def check_against_golden(data, stall=0.0):
    wanted = decode(data, TINY)
    run = run_camera(receiver(TINY), data, ratio=0.8, stall=stall)
    assert whole(run.frames(TINY)) == lists(wanted.pictures)
    counts = {"corrected": wanted.corrected, "rejected": wanted.rejected, "dropped": wanted.dropped}
    assert run.counters == {name: value for name, value in counts.items() if value}
    return wanted


@pytest.mark.parametrize("seed", range(2))
def test_damaged_bytes(seed):
    """Bytes deleted, inserted, repeated, changed: the same frames, and the same counts."""
    wanted = check_against_golden(damaged(np.random.default_rng(seed), 20), stall=0.2 * seed)
    assert len(wanted.pictures) > 8
    assert wanted.dropped > 3


def test_codes_in_place_of_others():
    """Each code of a frame once replaced by each that it is not, in any order; among them are good frames."""
    rng = np.random.default_rng(1)
    frame = encode(pictures(1, TINY)[0], TINY)
    parts = [frame] * 20
    for line in range(TINY.frame_lines):
        for at in (line * TINY.line_bytes + 3, line * TINY.line_bytes + 7 + TINY.blanking):
            for code in (0x80, 0x9D, 0xAB, 0xB6, 0xC7, 0xDA, 0xEC, 0xF1):
                if code != frame[at] and rng.random() < 0.6:
                    parts.append(frame.copy())
                    parts[-1][at] = code
    wanted = check_against_golden(np.concatenate([parts[n] for n in rng.permutation(len(parts))]))
    assert len(wanted.pictures) > 20
    assert wanted.dropped > 20


def test_gaps():
    """As long without a code as may be, and a byte longer; codes in blanking; fields alone after all that."""
    frame = encode(pictures(1, TINY)[0], TINY)
    half = (TINY.before_top + TINY.field_lines + TINY.after_top) * TINY.line_bytes
    parts = [frame[half - TINY.line_bytes:], frame]     # switched on before a bottom field
    for line in (1, 2, 3, 4, 5, 6, 7):
        eav = line * TINY.line_bytes + 3
        for gap in (lost_bytes(TINY) - 1, lost_bytes(TINY), lost_bytes(TINY) + 1):
            # From EAV to SAV, four bytes and blanking; behind it a bottom field that may belong to nothing.
            parts += [np.insert(frame, eav + 1, [0x10] * (gap - 4 - TINY.blanking)), frame[half:]]
        intruder = frame.copy()
        intruder[eav + 1:eav + 5] = 0xFF, 0x00, 0x00, 0x61
        parts += [intruder, frame]
    parts += [np.full(2 * lost_bytes(TINY), 0x10), frame[half:], frame, frame[:half], frame, frame[half:], frame]
    wanted = check_against_golden(np.concatenate(parts))
    assert wanted.rejected == 7
    assert wanted.dropped > 10


def test_latency():
    """Cycles of sync from a byte's clock edge to the word: what the docstrings add up to."""
    dut = receiver()
    ratio = 27 / 75
    (picture,) = pictures(1)
    data = np.concatenate([encode(picture, SMALL), np.full(100, 0x10)])
    run = run_camera(dut, data, ratio=ratio)
    first = (SMALL.before_top * SMALL.line_bytes + 8 + SMALL.blanking + 1) * BYTE     # the byte of the first pixel
    for pixel, late in ((0, 0), (1, 0), (SMALL.width - 2, 0), (SMALL.width - 1, 4)):
        taken = first + (2 * pixel + 0.5) * BYTE                                      # its rising edge
        cycles = (run.cycles[pixel] * ratio * BYTE - taken - (dut.BYTE_LATENCY + late) * BYTE) / (ratio * BYTE)
        assert 2 <= cycles <= 5, pixel


def test_present():
    """High with the first whole frame; low without a code for two lines, without a frame for three frames, without a clock."""
    (frame, *_), (picture, *_) = zip(*(Camera(SMALL, seed=1).frame(picture) for picture in pictures(1)))
    blank = encode_line(0, 1, *np.full((2, SMALL.width), 0x10), SMALL)
    gap = SMALL.after_bottom * SMALL.line_bytes
    ratio = 1.01

    def edges(data):
        run = run_camera(receiver(), np.concatenate([frame, data]), ratio=ratio, drain=2)
        assert lists(run.frames(SMALL)) == [picture.tolist()]
        assert run.counters == {}
        present = run.member("present")
        rise = present.index(1)
        assert abs(rise * ratio - (len(frame) - gap)) < 15
        return present[rise:].index(0) * ratio if 0 in present[rise:] else None

    fall = edges(np.full(5 * SMALL.line_bytes, 0x80))
    # From the frame's last code on: the SAV of its last line.
    last = gap - 2 * SMALL.width - 4
    assert abs(fall - (last + lost_bytes(SMALL))) < 12
    fall = edges(np.tile(blank, 3 * SMALL.frame_lines + 2))
    assert abs(fall - 3 * SMALL.frame_lines * SMALL.line_bytes) < 2 * SMALL.line_bytes
    assert edges(np.tile(blank, 3 * SMALL.frame_lines - 3)) is None
    fall = edges(np.full(600, -1))
    assert abs(fall / ratio - (gap / ratio + ClockWatch.TIMEOUT)) < 20 + ClockWatch.DIVISOR


def test_a_frame_that_is_lost_before_it_began_is_counted():
    """Lone bottom fields, the second one in the very cycle in which a drop word leaves the FIFO."""
    line = TINY.line_bytes
    frame = encode(pictures(1, TINY)[0], TINY)
    half = (TINY.before_top + TINY.field_lines + TINY.after_top) * line
    # The bottom field's last line is short, and its frame's drop word waits in the FIFO.
    data = np.concatenate([np.delete(frame, len(frame) - 2 * line + 20), frame[half:], frame[half:], frame])
    opens = len(frame) + len(frame[half:]) + TINY.before_bottom * line + 12
    meetings = 0
    for ready in range(opens - 14, opens - 8):
        run = run_camera(receiver(TINY), data, ratio=1, stall=lambda cycle: float(cycle < ready))
        assert run.counters == {"dropped": 3}
        assert [frame is None for frame in run.frames(TINY)] == [True, False]
        dropped = run.member("dropped")
        meetings += dropped.index(3) == dropped.index(2) + 1
    assert meetings


def test_clear():
    """Counters begin again; an event in the same cycle counts."""
    data, _ = Camera(TINY, seed=1).film(pictures(1, TINY), {0: "one-bit errors of all codes"})
    counted = run_camera(receiver(TINY), data).member("corrected")
    events = np.flatnonzero(np.diff([0, *counted])).tolist()
    assert len(events) == counted[-1] == 2 * TINY.frame_lines
    for at, before in ((events[4], 4), (events[4] + 1, 5)):     # `events` tells when a counter shows it
        run = run_camera(receiver(TINY), data, inputs=lambda cycle: {"clear": int(cycle == at - 1)})
        assert run.member("corrected") == [*counted[:at], *(value - before for value in counted[at:])]


def test_counters_stay_at_their_greatest():
    data = np.concatenate([Camera(TINY, seed=seed).film(pictures(2, TINY), {0: name})[0] for seed, name in enumerate(
        ("one-bit errors of all codes", "two-bit error of a code", "two-bit error of a code", "two-bit error of a code"))])
    top = 2**16 - 1

    def start(cycle):
        return {name: top - 1 for name in ("corrected", "rejected", "dropped", "overflow")} if cycle == 0 else {}

    # Nobody takes a word after a while: three frames overflow.
    run = run_camera(receiver(TINY, depth=8), data, inputs=start, stall=lambda cycle: float(cycle > 2400))
    for name in ("corrected", "rejected", "dropped", "overflow"):
        values = run.member(name)
        assert values[0] == top - 1
        assert values[-1] == top, name
        assert values == sorted(values)


def test_words():
    """The stream by hand."""
    data = encode(np.array([[1, 2, 3, 4], [9, 10, 11, 12], [5, 6, 7, 8], [13, 14, 15, 16]]), TINY)
    run = run_camera(receiver(TINY), np.concatenate([data, data[:90]]))
    words = [comparable(word) for word in run.words]
    assert [word["luma"] for word in words[:16]] == list(range(1, 17))
    assert [place for place, word in enumerate(words) if word["first"]] == [0, 16]
    assert [place for place, word in enumerate(words) if word["last"]][:4] == [3, 7, 11, 15]
    assert [place for place, word in enumerate(words) if word["end"]] == [15]
    assert not any(word["drop"] for word in words)

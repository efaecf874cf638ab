"""golden.video.bt656 on numbers worked by hand."""

import itertools

import numpy as np
import pytest

from golden.video.bt656 import CORRECTED, clip, decode, encode, lost_bytes, xy
from golden.video.formats import PAL, CameraFormat


SMALL = CameraFormat(width=4, field_lines=2, blanking=6, before_top=2, after_top=1, before_bottom=1, after_bottom=2)
LINE = SMALL.line_bytes     # 22


def picture(seed, format=SMALL):
    return np.random.default_rng(seed).integers(0, 256, (format.height, format.width))


def frame(seed):
    return encode(picture(seed), SMALL)


def inverted(data, at, *bits):
    changed = data.copy()
    for bit in bits:
        changed[at] ^= 1 << bit
    return changed


def found(*parts):
    """What is in the bytes: which seeds' pictures, in order; frames dropped, codes corrected, codes rejected."""
    result = decode(np.concatenate(parts), SMALL)
    known = {clip(picture(seed)).tobytes(): seed for seed in range(10)}
    return [known.get(part.tobytes()) for part in result.pictures], result.dropped, result.corrected, result.rejected


def test_codes():
    """The table of BT.656: F, V, H from 000 to 111."""
    assert [xy(n >> 2, n >> 1 & 1, n & 1) for n in range(8)] == [0x80, 0x9D, 0xAB, 0xB6, 0xC7, 0xDA, 0xEC, 0xF1]


def test_correction():
    codes = [0x80, 0x9D, 0xAB, 0xB6, 0xC7, 0xDA, 0xEC, 0xF1]
    for code in codes:
        assert CORRECTED[code] == code
        assert [CORRECTED[code ^ 1 << bit] for bit in range(8)] == [code] * 8
        assert [CORRECTED[code ^ 1 << a ^ 1 << b] for a, b in itertools.combinations(range(8), 2)] == [-1] * 28
    assert np.sum(CORRECTED >= 0) == 8 * 9
    assert CORRECTED[[0x00, 0x7F, 0x10, 0xFF]].tolist() == [0x80, -1, -1, -1]


def test_clip():
    assert clip(np.array([[0, 1, 2], [253, 254, 255]])).tolist() == [[1, 1, 2], [253, 254, 254]]


def test_pal():
    """864 sample periods by 625 lines; the transitions of F and V at the lines where they belong."""
    assert (PAL.width, PAL.height, PAL.line_bytes, PAL.frame_lines) == (720, 576, 2 * 864, 625)
    lines = encode(picture(1, PAL), PAL).reshape(625, 1728)
    assert lines[:, :3].tolist() == lines[:, 284:287].tolist() == [[0xFF, 0, 0]] * 625
    eav, sav = lines[:, 3], lines[:, 287]
    wanted = [(0, 1)] * 22 + [(0, 0)] * 288 + [(0, 1)] * 2 + [(1, 1)] * 23 + [(1, 0)] * 288 + [(1, 1)] * 2
    assert eav.tolist() == [xy(f, v, 1) for f, v in wanted]
    assert sav.tolist() == [xy(f, v, 0) for f, v in wanted]
    clipped = clip(picture(1, PAL))
    assert lines[22, 289::2].tolist() == clipped[0].tolist()        # line 23 is the picture's line 0
    assert lines[309, 289::2].tolist() == clipped[574].tolist()
    assert lines[335, 289::2].tolist() == clipped[1].tolist()
    assert lines[622, 289::2].tolist() == clipped[575].tolist()
    assert set(lines[:, 288::2].ravel().tolist()) == {0x80}
    assert lines[0, 4:284].tolist() == [0x80, 0x10] * 140


def test_line_by_hand():
    grey = np.zeros((4, 4), np.uint8)
    grey[1] = [5, 0, 255, 7]
    chroma = np.full((4, 4), 9)
    chroma[1] = [0, 2, 3, 255]
    lines = encode(grey, SMALL, chroma).reshape(-1, LINE)
    # Two blank lines, two of the top field, a blank one of each field, then the bottom field.
    assert lines[6].tolist() == [0xFF, 0, 0, 0xDA, 0x80, 0x10, 0x80, 0x10, 0x80, 0x10, 0xFF, 0, 0, 0xC7, 1, 5, 2, 1, 3, 254, 254, 7]
    assert lines[5].tolist() == [0xFF, 0, 0, 0xF1, 0x80, 0x10, 0x80, 0x10, 0x80, 0x10, 0xFF, 0, 0, 0xEC, *[0x80, 0x10] * 4]


def test_wrong_size():
    with pytest.raises(ValueError, match="must be of 4 lines and 4 columns"):
        encode(np.zeros((4, 6)), SMALL)
    with pytest.raises(ValueError, match="must be of 4 lines and 4 columns"):
        encode(np.zeros((4, 4)), SMALL, np.zeros((2, 4)))


def test_decode():
    assert found(frame(1), frame(2), frame(3)) == ([1, 2, 3], 0, 0, 0)
    assert decode(encode(picture(1, PAL), PAL), PAL).pictures[0].tolist() == clip(picture(1, PAL)).tolist()


# Where codes of line n of a frame stand.
def eav(line):
    return line * LINE + 3


def sav(line):
    return line * LINE + 3 + 4 + SMALL.blanking


@pytest.mark.parametrize("bit", range(8))
def test_one_bit(bit):
    damaged = frame(2)
    for line in range(SMALL.frame_lines):
        damaged = inverted(inverted(damaged, eav(line), bit), sav(line), 7 - bit)
    assert found(frame(1), damaged, frame(3)) == ([1, 2, 3], 0, 20, 0)


# Line of a code of frame 2, and the frames received: lines 2, 3 and 6, 7 are active.
@pytest.mark.parametrize("at, kept", [
    (eav(0), True), (sav(1), True), (eav(2), True),     # not in the frame yet
    (sav(2), False), (eav(3), False), (sav(3), False),
    (eav(4), False),                                    # closes line 3
    (sav(4), True), (eav(5), True), (sav(5), True), (eav(6), True),
    (sav(6), False), (eav(7), False), (sav(7), False), (eav(8), False),
    (sav(8), True), (eav(9), True),
])
def test_two_bits(at, kept):
    assert found(frame(1), inverted(frame(2), at, 0, 5), frame(3)) == ([1, 2, 3] if kept else [1, 3], int(not kept), 0, 1)


def without(data, start, count):
    return np.delete(data, range(start, start + count))


@pytest.mark.parametrize("line", [2, 3, 6, 7])
@pytest.mark.parametrize("count", [1, 2, 8])
def test_line_length(line, count):
    at = sav(line) + 1
    assert found(frame(1), without(frame(2), at, count), frame(3)) == ([1, 3], 1, 0, 0)
    assert found(frame(1), np.insert(frame(2), at, [77] * count), frame(3)) == ([1, 3], 1, 0, 0)


@pytest.mark.parametrize("line", [2, 3, 6, 7])
def test_line_lost_and_line_repeated(line):
    start, end = line * LINE, (line + 1) * LINE
    assert found(frame(1), without(frame(2), start, LINE), frame(3)) == ([1, 3], 1, 0, 0)
    assert found(frame(1), np.insert(frame(2), start, frame(2)[start:end]), frame(3)) == ([1, 3], 1, 0, 0)


def test_lengths_of_blanking_are_free():
    free = np.insert(frame(2), [5, eav(1) + 3, eav(2) + 1, eav(3) + 1, 3 * LINE + 6], 77)
    assert found(frame(1), without(free, 0, LINE), frame(3)) == ([1, 2, 3], 0, 0, 0)


def test_fields():
    top, bottom = np.split(frame(2), [5 * LINE])
    assert found(frame(1), top, frame(3)) == ([1, 3], 1, 0, 0)
    assert found(frame(1), bottom, frame(3)) == ([1, 3], 1, 0, 0)
    assert found(frame(1), bottom, top, frame(3)) == ([1, 3], 2, 0, 0)      # neither has its partner
    assert found(frame(1), bottom, bottom, frame(3)) == ([1, 3], 2, 0, 0)
    assert found(bottom, frame(3)) == ([3], 0, 0, 0)                        # began before the first byte


def test_switched_on_in_mid_frame():
    for start in range(0, SMALL.frame_bytes, 7):
        pictures, dropped, *_ = found(frame(2)[start:], frame(3))
        assert pictures == ([2, 3] if start <= 32 else [3])     # a blank line must be seen: the SAV of line 1 ends at byte 35
        assert dropped == 0


def test_loss():
    nothing = np.full(lost_bytes(SMALL), 0x10)
    assert lost_bytes(SMALL) == 2 * LINE
    for line, kept, dropped in [(1, [1, 2, 3], 0), (5, [1, 3], 1), (9, [1, 2, 3], 0)]:
        parts = np.split(frame(2), [eav(line) + 1])
        assert found(frame(1), parts[0], nothing, parts[1], frame(3)) == (kept, dropped, 0, 0)
    # Between the fields a code may follow another one after two lines, but no later.
    before, after = frame(2)[:eav(5) + 1], frame(2)[sav(5) - 3:]
    for gap, kept in [(2 * LINE, [1, 2, 3]), (2 * LINE + 1, [1, 3])]:
        assert found(frame(1), before, np.full(gap - 4, 0x10), after, frame(3))[0] == kept
    # The frame to which a bottom field belongs was not there.
    bottom = frame(2)[5 * LINE:]
    assert found(frame(1), nothing, bottom, frame(3)) == ([1, 3], 0, 0, 0)

import random

import pytest

from golden.video.tmds import CONTROL_WORDS, LARGEST_DISPARITY, WORD_BITS, decode, encode, encode_byte


DISPARITIES = range(-LARGEST_DISPARITY, LARGEST_DISPARITY + 1, 2)


def flow_chart(level, count):
    """The encoder of DVI 1.0, figure 3-5, box by box; bits as lists."""
    d = [level >> place & 1 for place in range(8)]
    q_m = [d[0]]
    if sum(d) > 4 or (sum(d) == 4 and d[0] == 0):
        for bit in d[1:]:
            q_m.append(1 - (q_m[-1] ^ bit))
        q_m.append(0)
    else:
        for bit in d[1:]:
            q_m.append(q_m[-1] ^ bit)
        q_m.append(1)
    ones = sum(q_m[:8])
    zeros = 8 - ones
    if count == 0 or ones == zeros:
        out = [*(q_m[:8] if q_m[8] else [1 - bit for bit in q_m[:8]]), q_m[8], 1 - q_m[8]]
        count += ones - zeros if q_m[8] else zeros - ones
    elif (count > 0 and ones > zeros) or (count < 0 and zeros > ones):
        out = [*(1 - bit for bit in q_m[:8]), q_m[8], 1]
        count += 2 * q_m[8] + zeros - ones
    else:
        out = [*q_m[:8], q_m[8], 0]
        count += -2 * (1 - q_m[8]) + ones - zeros
    return sum(bit << place for place, bit in enumerate(out)), count


def transitions(word):
    return sum(word >> place & 1 != word >> place + 1 & 1 for place in range(WORD_BITS - 1))


@pytest.mark.parametrize("disparity", DISPARITIES)
def test_every_byte(disparity):
    """Equals the standard; at most five transitions; the monitor reads the byte; the disparity is the bits', and stays in its range."""
    for level in range(256):
        word, after = encode_byte(level, disparity)
        assert (word, after) == flow_chart(level, disparity)
        assert transitions(word) <= 5
        assert decode([word]) == [(True, level, 0)]
        assert after - disparity == 2 * word.bit_count() - WORD_BITS
        assert after in DISPARITIES


def test_disparities_that_occur():
    """All of the range, and no others."""
    found, left = {0}, [0]
    while left:
        disparity = left.pop()
        new = {encode_byte(level, disparity)[1] for level in range(256)} - found
        found |= new
        left += new
    assert found == {*DISPARITIES}


def test_control_words():
    """Those of DVI 1.0; seven transitions or more, which no byte has, so that a monitor finds the words by them."""
    assert [f"{word:010b}" for word in CONTROL_WORDS] == ["1101010100", "0010101011", "0101010100", "1010101011"]
    assert all(transitions(word) >= 7 for word in CONTROL_WORDS)
    assert [(each.de, each.control) for each in decode(CONTROL_WORDS)] == [(False, control) for control in range(4)]


def test_channel():
    """Lines of pixels with blanking: decoded they are as before, and a control word begins the count anew."""
    random.seed(1)
    pixels = [(de, random.randrange(256) if de else 0, 0 if de else random.randrange(4))
              for _ in range(50) for de, count in ((True, 40), (False, random.randrange(1, 9))) for _ in range(count)]
    words = encode(pixels)
    assert decode(words) == pixels
    assert encode([(True, 255, 0), (False, 0, 1), (True, 255, 0)]) == [0b1000000000, CONTROL_WORDS[1], 0b1000000000]


@pytest.mark.parametrize("level", [-1, 256])
def test_no_byte(level):
    with pytest.raises(ValueError, match=rf"from 0 to 255, not {level}$"):
        encode_byte(level, 0)

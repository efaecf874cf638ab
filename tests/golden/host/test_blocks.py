"""golden.host.blocks: block reads, and their CRC, by hand."""

import binascii
import itertools

import numpy as np
import pytest

from golden.host.blocks import block_answer, line_bytes, stored_line
from golden.host.protocol import (
    FRAME_BYTES,
    Operation,
    Request,
    Status,
    block_bits,
    crc,
    decode_block,
    decode_reply,
    encode_block,
    encode_request,
)
from golden.host.register_page import page
from golden.host.registers import register_map


PLANES = [np.full((3, 20), value, np.uint8) for value in (11, 22, 33)]


def asked(plane, line, planes=PLANES):
    return block_answer(planes, 3, encode_request(Request(Operation.BLOCK, plane, line)))


def test_operations_are_far_apart():
    assert min((a ^ b).bit_count() for a, b in itertools.combinations(Operation, 2)) == 4


def test_crc_is_that_of_the_standard_library():
    rng = np.random.default_rng(1)
    for length in (0, 1, 3, 723):
        data = rng.bytes(length)
        assert crc(data) == binascii.crc_hqx(data, 0xFFFF)


def test_a_line():
    answer = asked(2, 1)
    reply, block = decode_reply(answer[:FRAME_BYTES]), answer[FRAME_BYTES:]
    assert (reply.status, reply.address, reply.value) == (Status.OK, 2, 1)
    assert block[:-2] == bytes([33] * 20 + [0] * 12) and len(block) == line_bytes(20) + 2
    assert decode_block(2, 1, block) == block[:-2] == stored_line(PLANES[2][1])
    # Bits of request, reply and block, ten a byte.
    assert block_bits(line_bytes(20)) == 10 * (6 + len(answer))


@pytest.mark.parametrize("plane, line, planes, status", [
    (3, 0, PLANES, Status.UNKNOWN_ADDRESS), (255, 9, None, Status.UNKNOWN_ADDRESS), (0, 3, PLANES, Status.OUT_OF_RANGE),
    (2, 0xFFFF, None, Status.OUT_OF_RANGE), (0, 0, None, Status.NOT_KEPT),
])
def test_refused(plane, line, planes, status):
    answer = asked(plane, line, planes)
    reply = decode_reply(answer)
    assert (reply.status, reply.address, reply.value) == (status, plane, 0)


def test_block_of_another_line_or_with_an_error_is_none():
    data = bytes(range(32))
    block = encode_block(1, 0x102, data)
    assert decode_block(1, 0x102, block) == data
    assert decode_block(0, 0x102, block) is decode_block(1, 0x103, block) is decode_block(1, 0x202, block) is None
    for bit in range(8 * len(block)):
        wrong = bytearray(block)
        wrong[bit // 8] ^= 1 << bit % 8
        assert decode_block(1, 0x102, bytes(wrong)) is None
    # Inverted, as that of a pair that was let go.
    assert decode_block(1, 0x102, block[:-2] + bytes(byte ^ 0xFF for byte in block[-2:])) is None
    assert decode_block(1, 0x102, block[:-1]) is decode_block(1, 0x102, b"") is None


@pytest.mark.parametrize("frame", [b"", encode_request(Request(Operation.READ, 0)), encode_request(Request(Operation.BLOCK, 0))[:-1]])
def test_what_is_no_block_read(frame):
    with pytest.raises(ValueError, match="operation 0x61"):
        block_answer(None, 3, frame)


def test_page_describes_it():
    text = page(register_map())
    for words in ("`0x61` block read", "0 left, 1 right, 2 disparity", "7340 bits", "36.7 s at 115,200 baud", "4.6 s at 921,600 baud",
                  "1.4 s at 3,000,000 baud", encode_request(Request(Operation.BLOCK, 2, 300)).hex(" ")):
        assert words in " ".join(text.split())

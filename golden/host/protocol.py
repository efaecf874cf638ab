"""The wire protocol: six bytes each way with a checksum; a line of a kept picture follows the reply to a block read, with a CRC. To systems
that take pictures a line and its CRC are sent after the request of a block write, before its reply.

Shared by host, gateware, models and tests.
"""

import binascii
import enum
from dataclasses import dataclass


__all__ = ["BAUD", "CRC_BYTES", "FRAME_BYTES", "FRAME_SECONDS", "QUIET_SECONDS", "REPLY_SYNC", "REQUEST_SYNC", "Operation", "Reply",
           "Request", "Status", "block_bits", "check_byte", "crc", "decode_block", "decode_reply", "decode_request", "encode_block",
           "encode_reply", "encode_request", "first_reply"]


#: Bits a second, 8N1.
BAUD = 115_200

#: First byte of a request, and of a reply. They differ, so that an echo on the line is not taken for a reply.
REQUEST_SYNC = 0xA5
REPLY_SYNC = 0x5A

#: Bytes of a request and of a reply.
FRAME_BYTES = 6

#: Bytes of a block's CRC, after its data.
CRC_BYTES = 2

#: Longest pause within a request, in seconds: 115 times a byte, ten times what a USB adapter may wait between two bytes.
FRAME_SECONDS = 0.01

#: A pause after which the chip is ready for a request, whatever was on the line before: the time-out, and the six bytes of a reply to
#: noise.
QUIET_SECONDS = 0.011


class Operation(enum.IntEnum):
    """Second byte of a request; four bits or more differ between any two, so that noise does not turn one into another."""
    READ = 0x52
    WRITE = 0xAD
    BLOCK = 0x61
    BLOCK_WRITE = 0x9E


class Status(enum.IntEnum):
    """Second byte of a reply."""
    OK = 0
    BAD_SUM = 1
    UNKNOWN_ADDRESS = 2
    READ_ONLY = 3
    OUT_OF_RANGE = 4
    UNKNOWN_OPERATION = 5
    NOT_KEPT = 6
    BUSY = 7


@dataclass(frozen=True)
class Request:
    """A request of the host; ``operation`` may be another value than those of :class:`Operation`, ``value`` is ignored in a read.

    Of a block read or a block write, ``address`` is the plane (:class:`golden.video.memory_map.Plane`, the first three), and ``value`` is
    the line.
    """
    operation: int
    address: int
    value: int = 0


@dataclass(frozen=True)
class Reply:
    """A reply of the chip: ``value`` is the register's, or the line of a block; 0 unless ``status`` is ``OK``."""
    status: Status
    address: int
    value: int = 0


def check_byte(data: bytes) -> int:
    """Checksum: the byte that makes ``data`` and itself add up to 0 modulo 256.

    >>> hex(check_byte(bytes([0xA5, 0x52, 0x10, 0, 0])))
    '0xf9'
    """
    return -sum(data) % 256


def _encode(*head: int, value: int) -> bytes:
    data = bytes([*head, *value.to_bytes(2, "big")])
    return data + bytes([check_byte(data)])


def encode_request(request: Request) -> bytes:
    """The six bytes of a request.

    >>> encode_request(Request(Operation.WRITE, 0x10, 15)).hex(" ")
    'a5 ad 10 00 0f 8f'
    """
    return _encode(REQUEST_SYNC, request.operation, request.address, value=request.value)


def encode_reply(reply: Reply) -> bytes:
    """The six bytes of a reply.

    >>> encode_reply(Reply(Status.OK, 0x10, 15)).hex(" ")
    '5a 00 10 00 0f 87'
    """
    return _encode(REPLY_SYNC, reply.status, reply.address, value=reply.value)


def _is_frame(frame: bytes, sync: int) -> bool:
    return len(frame) == FRAME_BYTES and frame[0] == sync and sum(frame) % 256 == 0


def decode_request(frame: bytes) -> Request | None:
    """The request encoded in six bytes; ``None`` if they are not one."""
    if not _is_frame(frame, REQUEST_SYNC):
        return None
    return Request(frame[1], frame[2], int.from_bytes(frame[3:5], "big"))


def decode_reply(frame: bytes) -> Reply | None:
    """The reply encoded in six bytes; ``None`` if they are not one."""
    if not _is_frame(frame, REPLY_SYNC) or frame[1] not in set(Status):
        return None
    return Reply(Status(frame[1]), frame[2], int.from_bytes(frame[3:5], "big"))


def first_reply(data: bytes) -> Reply | None:
    """The first reply in ``data``, with noise before and after it; ``None`` if there is none.

    >>> first_reply(b"noise" + encode_reply(Reply(Status.OK, 0x10, 15))).value
    15
    """
    replies = (decode_reply(data[at:at + FRAME_BYTES]) for at in range(len(data) - FRAME_BYTES + 1))
    return next((reply for reply in replies if reply), None)


def crc(data: bytes) -> int:
    """CRC-16 of CCITT: polynomial 0x1021, from 0xFFFF on, most significant bit first.

    >>> hex(crc(b"123456789"))
    '0x29b1'
    """
    return binascii.crc_hqx(data, 0xFFFF)


def encode_block(plane: int, line: int, data: bytes) -> bytes:
    """What follows the reply to a block read, or the request of a block write: the line's bytes, and the CRC over plane, line and
    these bytes.

    >>> encode_block(0, 1, bytes(4)).hex(" ")
    '00 00 00 00 5b 9f'
    """
    return data + crc(bytes([plane, *line.to_bytes(2, "big")]) + data).to_bytes(CRC_BYTES, "big")


def decode_block(plane: int, line: int, block: bytes) -> bytes | None:
    """The data of a block that was asked for; ``None`` if it is not this block."""
    data = block[:-CRC_BYTES]
    return data if encode_block(plane, line, data) == block else None


def block_bits(data_bytes: int) -> int:
    """Bits on the line for a block read of so many bytes: request, reply, data and CRC, one after the other, 8N1.

    >>> block_bits(720)
    7340
    """
    return 10 * (2 * FRAME_BYTES + data_bytes + CRC_BYTES)

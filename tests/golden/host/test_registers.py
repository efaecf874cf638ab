"""golden.host.registers, golden.host.protocol, golden.host.register_page: the register map, its wire protocol and its page."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from golden.config import FUSED_1, RECURSIVE_2, MatcherConfig, OnePass, changed
from golden.host.protocol import (
    BAUD,
    FRAME_BYTES,
    FRAME_SECONDS,
    QUIET_SECONDS,
    Operation,
    Reply,
    Request,
    Status,
    decode_reply,
    decode_request,
    encode_reply,
    encode_request,
    first_reply,
)
from golden.host.register_page import main, page
from golden.host.registers import SETUPS, Kind, Register, RegisterMap, answer, register_map
from golden.rig.config import RigConfig
from golden.rig.files import Rig
from golden.rig.maps import identity
from golden.video.setup_steps import TFP410


REGISTERS = register_map()
ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("request_, frame", [
    (Request(Operation.READ, 0x00), "a5 52 00 00 00 09"),
    (Request(Operation.WRITE, 0x13, 0x1234), "a5 ad 13 12 34 55"),
    (Request(Operation.READ, 0xFF, 0xFFFF), "a5 52 ff ff ff 0c"),
    (Request(0x00, 0x01, 0x0100), "a5 00 01 01 00 59"),
])
def test_request(request_, frame):
    """Worked by hand: the bytes of each line add up to a multiple of 256."""
    assert encode_request(request_) == bytes.fromhex(frame)
    assert decode_request(bytes.fromhex(frame)) == request_


@pytest.mark.parametrize("reply, frame", [
    (Reply(Status.OK, 0x00, 0x5347), "5a 00 00 53 47 0c"),
    (Reply(Status.UNKNOWN_OPERATION, 0xFF), "5a 05 ff 00 00 a2"),
    (Reply(Status.BAD_SUM, 0x40, 0), "5a 01 40 00 00 65"),
])
def test_reply(reply, frame):
    assert encode_reply(reply) == bytes.fromhex(frame)
    assert decode_reply(bytes.fromhex(frame)) == reply


@pytest.mark.parametrize("decode, frame", [(decode_request, encode_request(Request(Operation.WRITE, 0x10, 15))),
                                           (decode_reply, encode_reply(Reply(Status.OK, 0x10, 15)))])
def test_every_fault_within_a_byte_is_found(decode, frame):
    assert decode(frame) is not None
    for place in range(FRAME_BYTES):
        for fault in range(1, 256):
            assert decode(frame[:place] + bytes([frame[place] ^ fault]) + frame[place + 1:]) is None
    assert decode(frame[:-1]) is decode(frame + b"\0") is decode(b"") is None


def test_request_is_no_reply():
    """A line that echoes does not answer itself."""
    assert decode_reply(encode_request(Request(Operation.READ, 0x10))) is None
    assert decode_request(encode_reply(Reply(Status.OK, 0x10))) is None


def test_unknown_status_is_no_reply():
    frame = bytes([0x5A, 8, 0, 0, 0, 0x100 - 0x62])
    assert sum(frame) % 256 == 0
    assert decode_reply(frame) is None


def test_first_reply_in_noise():
    rng = np.random.default_rng(1)
    reply, other = Reply(Status.OK, 0x40, 777), Reply(Status.OK, 0x41, 778)
    for before in range(12):
        noise = bytes(rng.integers(0, 256, before).tolist())
        data = noise + encode_reply(reply) + encode_reply(other)
        assert first_reply(data) == reply
        assert first_reply(data[:before + FRAME_BYTES]) == reply
        assert first_reply(data[:before + FRAME_BYTES - 1]) is None
    assert first_reply(bytes([0x5A, 0x5A]) + encode_reply(reply)) == reply
    assert first_reply(b"") is None


def test_silence_covers_time_out_and_a_reply():
    assert FRAME_SECONDS + 10 * FRAME_BYTES / BAUD < QUIET_SECONDS


def test_what_must_be_there():
    names = {register.name for register in REGISTERS}
    assert names >= {"identity", "version", "disparities", "width", "height", "u1", "u2", "u3", "in_use", "show", "colour", "hold",
                     "clear_counters", "restart_setup", "memory_ready", "matcher_error", "display_frames", "pairs", "pictures_dropped",
                     "pictures_abandoned", "display_underflows", "uart_errors"}
    assert names >= {f"{side}_{what}" for side in ("left", "right")
                     for what in ("locked", "signal", "corrected", "rejected", "dropped", "overflow", "skipped", "unpaired", "camera_fill")}
    assert names >= {f"{role}_{what}" for role in SETUPS for what in ("state", "step", "reason", "failures")}
    assert len(names) == len(REGISTERS)


def test_values_follow_the_configuration():
    registers = register_map(MatcherConfig(labels=256, max_width=4096, method=changed(OnePass(), u1=1, u2=2, u3=63)), height=2000)
    assert [registers[name].reset for name in ("disparities", "width", "height", "u1", "u2", "u3", "in_use")] == [
        256, 4096, 2000, 1, 2, 63, 256]
    assert [registers[name].width for name in ("u1", "in_use", "show", "colour", "pairs")] == [6, 9, 2, 1, 16]
    assert (registers["in_use"].minimum, registers["in_use"].maximum) == (1, 256)
    assert [register.reset for register in REGISTERS.of(Kind.SETTING)] == [15, 10, 5, 80, 0, 0, 0, 0, 0]
    fused = register_map(MatcherConfig(minimum=7, method=changed(FUSED_1, fill=False)))
    assert [register.reset for register in fused.of(Kind.SETTING)] == [17, 30, 22, 80, 0, 0, 0, 7, 1, 0, 1, 0, 0]
    assert [registers["method"].text(registers["method"].reset), fused["method"].text(fused["method"].reset)] == ["thesis", "fused"]
    assert registers["identity"].reset.to_bytes(2, "big") == b"SG"


def test_addresses():
    """Addresses are a contract: a change of one needs another version."""
    assert {register.name: register.address for register in REGISTERS if not register.address % 16} == {
        "identity": 0x00, "u1": 0x10, "clear_counters": 0x20, "decoder_state": 0x30, "display_frames": 0x40, "right_skipped": 0x50,
        "keep": 0x80}
    fused = register_map(MatcherConfig(method=FUSED_1))
    assert [fused[name].address for name in ("u1", "u2", "u3", "in_use", "show", "colour", "hold", "minimum", "check", "fill",
                                             "median")] == list(range(0x10, 0x1B))
    assert all(REGISTERS.at(address) is None for address in range(0x17, 0x20))
    recursive = register_map(MatcherConfig(method=RECURSIVE_2))
    assert [recursive[name].address for name in ("census_threshold", "near_threshold", "far_threshold", "step_threshold", "above_share",
                                                 "below_share")] == [*range(0x1B, 0x20), 0x22]
    for register in REGISTERS:
        assert REGISTERS.at(register.address) is register
    assert REGISTERS.at(0x08) is None

    rig = register_map(rig=RigConfig())
    some = (0x60, 0x64, 0x69, 0x6A, 0x6C, 0x70, 0x74, 0x79)
    assert {register.name: register.address for register in rig if register.address in some} == {
        "rectify": 0x60, "row_offset": 0x64, "map_high": 0x69, "map_start": 0x6A, "map_swap": 0x6C, "map": 0x70, "left_mean": 0x74,
        "offset": 0x79}
    assert len(rig) > len(REGISTERS) and REGISTERS.at(0x60) is None


def test_rig_registers():
    """Limits and reset values follow from the size of the pictures and from the rig that is built in."""
    which = identity(720, 576)
    registers = register_map(MatcherConfig(max_width=720), 576, RigConfig(44, Rig(which, which, -3)))
    assert registers["rectify_lines"].reset == 44 and REGISTERS["rectify_lines"].reset == 0
    assert registers["map_address"].maximum == 19 * 25 - 1 and registers["map_high"].maximum == 15
    assert (registers["row_offset"].reset, registers["row_offset"].minimum) == (-3, -128)
    assert registers["offset"].decode(registers["offset"].encode(-16384)) == -16384


def test_negative_values():
    """Two's complement of 16 bits on the line, whatever the width of the register."""
    registers = register_map(MatcherConfig(minimum=-16, method=FUSED_1))
    least = registers["minimum"]
    assert (least.minimum, least.reset, least.maximum, least.width, least.signed) == (-16, -16, 255, 9, True)
    assert registers["lead"].reset == 16 and REGISTERS["lead"].reset == 0 and not REGISTERS["lead"].signed
    assert [least.encode(value) for value in (-16, -1, 0, 255)] == [0xFFF0, 0xFFFF, 0, 255]
    assert [least.decode(bits) for bits in (0xFFF0, 0xFFFF, 0, 255, 0x7FFF)] == [-16, -1, 0, 255, 0x7FFF]
    assert REGISTERS["pairs"].decode(0xFFFF) == 0xFFFF
    assert replace(least, minimum=-300).width == 10
    for value, status in ((-16, Status.OK), (-17, Status.OUT_OF_RANGE), (256, Status.OUT_OF_RANGE), (3, Status.OK)):
        reply, written = answer(registers, {}, encode_request(Request(Operation.WRITE, least.address, least.encode(value))))
        assert reply.status is status and written == ({"minimum": value} if status is Status.OK else {})
    read = encode_request(Request(Operation.READ, least.address))
    assert answer(registers, {}, read)[0].value == 0xFFF0 and answer(registers, {"minimum": -3}, read)[0].value == 0xFFFD


def test_kinds():
    assert len(REGISTERS.of(*Kind)) == len(REGISTERS)
    assert {register.access for register in REGISTERS.of(Kind.CONSTANT, Kind.STATUS, Kind.COUNTER)} == {"read-only"}
    assert {register.access for register in REGISTERS.of(Kind.SETTING)} == {"read-write"}
    assert {register.access for register in REGISTERS.of(Kind.ACTION)} == {"write 1"}


def test_limits():
    assert [REGISTERS[name].limits for name in ("show", "in_use", "version", "decoder_state", "transmitter_step")] == [
        "0 disparity, 1 left, 2 both", "1 .. 80", "6", "0 busy, 1 done, 2 failed", f"0 .. {len(TFP410.steps) - 1}"]


@pytest.mark.parametrize("name, value, text", [
    ("u1", 15, "15 grey levels a pixel"), ("show", 2, "both"), ("show", 3, "3"), ("left_locked", 1, "yes"),
    ("decoder_step", 4, "decoder 1: write 7F = 00"), ("transmitter_reason", 1, "no acknowledge"), ("pairs", 7, "7 pairs"),
    ("identity", 0x5347, "stereo graph cut"),
])
def test_text(name, value, text):
    assert REGISTERS[name].text(value) == text


U1 = REGISTERS["u1"]


@pytest.mark.parametrize("changes, message", [
    ({"name": "u 1"}, "must be an identifier, not 'u 1'"),
    ({"address": 256}, "address of u1 must be from 0 to 255, not 256"),
    ({"maximum": 65536}, r"within 0 .. 65535 in rising order, not 0 .. 65536"),
    ({"minimum": 5, "maximum": 4}, "not 5 .. 4"),
    ({"reset": 64}, "from 0 to 63, not 64"),
    ({"minimum": 16}, "from 16 to 63, not 15"),
    ({"minimum": -1, "maximum": 32768}, r"within -32768 .. 32767 in rising order, not -1 .. 32768"),
    ({"minimum": -32769}, r"within -32768 .. 32767 in rising order, not -32769 .. 63"),
])
def test_bad_register(changes, message):
    with pytest.raises(ValueError, match=message):
        replace(U1, **changes)


def test_bad_map():
    with pytest.raises(ValueError, match="two registers have the name 'u1'"):
        RegisterMap((U1, replace(U1, address=1)))
    with pytest.raises(ValueError, match="two registers have the address 16"):
        RegisterMap((U1, replace(U1, name="other")))
    with pytest.raises(KeyError):
        REGISTERS["u4"]


@pytest.mark.parametrize("request_, reply, written", [
    (Request(Operation.READ, 0x10), Reply(Status.OK, 0x10, 15), {}),
    (Request(Operation.READ, 0x11), Reply(Status.OK, 0x11, 33), {}),
    (Request(Operation.READ, 0x20), Reply(Status.OK, 0x20, 0), {}),
    (Request(Operation.WRITE, 0x10, 63), Reply(Status.OK, 0x10, 63), {"u1": 63}),
    (Request(Operation.WRITE, 0x10, 64), Reply(Status.OUT_OF_RANGE, 0x10), {}),
    (Request(Operation.WRITE, 0x13, 0), Reply(Status.OUT_OF_RANGE, 0x13), {}),
    (Request(Operation.WRITE, 0x13, 1), Reply(Status.OK, 0x13, 1), {"in_use": 1}),
    (Request(Operation.WRITE, 0x20, 1), Reply(Status.OK, 0x20, 1), {"clear_counters": 1}),
    (Request(Operation.WRITE, 0x20, 0), Reply(Status.OUT_OF_RANGE, 0x20), {}),
    (Request(Operation.WRITE, 0x40, 0), Reply(Status.READ_ONLY, 0x40), {}),
    (Request(Operation.WRITE, 0x00, 1), Reply(Status.READ_ONLY, 0x00), {}),
    (Request(Operation.READ, 0x92), Reply(Status.UNKNOWN_ADDRESS, 0x92), {}),
    (Request(Operation.WRITE, 0x92, 1), Reply(Status.UNKNOWN_ADDRESS, 0x92), {}),
    (Request(Operation.BLOCK, 0x00, 1), Reply(Status.UNKNOWN_OPERATION, 0x00), {}),
    (Request(0x53, 0x10, 1), Reply(Status.UNKNOWN_OPERATION, 0x10), {}),
    (Request(0x53, 0x80, 1), Reply(Status.UNKNOWN_OPERATION, 0x80), {}),
])
def test_answer(request_, reply, written):
    assert answer(REGISTERS, {"u2": 33}, encode_request(request_)) == (reply, written)


def test_answer_to_a_bad_sum():
    frame = bytearray(encode_request(Request(Operation.WRITE, 0x10, 1)))
    frame[4] ^= 1
    assert answer(REGISTERS, {}, bytes(frame)) == (Reply(Status.BAD_SUM, 0x10), {})


def test_page_is_up_to_date(tmp_path):
    assert main(["--output", str(tmp_path / "registers.md")]) == 0
    text = (tmp_path / "registers.md").read_text()
    assert text == page(register_map(MatcherConfig(method=FUSED_1), rig=RigConfig()))
    assert (ROOT / "docs" / "registers.md").read_text() == text, "run python -m golden.host.register_page --output docs/registers.md"


def test_page_tells_all():
    text = page(REGISTERS)
    for register in REGISTERS:
        assert f"| `0x{register.address:02X}` | `{register.name}` | {register.width} |" in text
        assert register.description in text
        assert all(f"{value} {word}" in register.limits or f"| {value} | {word} |" in text for value, word in register.words.items())
    assert max(map(len, text.splitlines())) <= 140


@pytest.mark.parametrize("arguments, message", [
    ([], "--output"), (["--output", "a.txt"], "suffix .txt"), (["--output", "none/a.md"], "folder none"),
])
def test_bad_arguments(capsys, arguments, message):
    assert main(arguments) == 2
    err = capsys.readouterr().err
    assert err.startswith("golden.host.register_page: ") and err.count("\n") == 1 and message in err


def test_register_of_its_own():
    """Names of values may be added to a register of any kind."""
    register = Register("step", 1, Kind.STATUS, 3, "a step", words={2: "lock"})
    assert [register.text(value) for value in range(4)] == ["0", "1", "lock", "3"]
    assert hash(register) == hash(replace(register, words={}))

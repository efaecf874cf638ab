"""golden.host.loop_registers, golden.host.loop_device: the map of the matcher behind a serial line, its page, and its model by hand."""

from pathlib import Path

import numpy as np
import pytest

from golden.config import FUSED_1, FUSED_2, METHODS, RECURSIVE_1, RECURSIVE_2, MatcherConfig, OnePass, changed
from golden.host.build_id import parameter_digest, release
from golden.host.loop_device import LoopDevice, packed_result, plane_bytes, unpacked_result
from golden.host.loop_registers import loop_register_map, result_bytes
from golden.host.protocol import Operation, Reply, Request, Status, crc, encode_block, encode_reply, encode_request
from golden.host.register_page import LOOP_CONFIG, loop_page, main
from golden.host.registers import register_map
from golden.host.systems import SYSTEMS
from golden.matcher.matcher import match
from sim.kit.cases import noise


ROOT = Path(__file__).parents[3]
CONFIG = MatcherConfig(4, 7, method=OnePass())


@pytest.mark.parametrize("method", METHODS.values())
def test_shares_addresses_with_the_system(method):
    """And has what a host needs to know which it is."""
    config = MatcherConfig(method=method())
    loop, system = loop_register_map(config), register_map(config)
    shared = {register.name for register in loop} & {register.name for register in system}
    assert shared >= {"identity", "version", "disparities", "width", "height", "method", "lead", "rectify_lines", "keep", "kept", "pairs",
                      "uart_errors", "matcher_error", "clear_counters", *config.settings}
    assert all(loop[name].address == system[name].address for name in shared)
    assert loop["identity"].reset != system["identity"].reset and len(SYSTEMS) == 2


def test_digest_is_of_what_cannot_be_set():
    methods = [OnePass(), changed(OnePass(), fraction_bits=2), changed(OnePass(), arithmetic="linear"), FUSED_1, FUSED_2,
               changed(FUSED_1, sub_pixel=True), RECURSIVE_1, RECURSIVE_2]
    assert len({parameter_digest(MatcherConfig(method=method)) for method in methods}) == len(methods)
    same = [changed(RECURSIVE_1, soft_multipliers=True), changed(RECURSIVE_1, near_threshold=3, above_share=1, fill=False)]
    assert {parameter_digest(MatcherConfig(method=method)) for method in same} == {parameter_digest(MatcherConfig(method=RECURSIVE_1))}
    assert parameter_digest(MatcherConfig(in_use=3, minimum=5)) == parameter_digest(MatcherConfig())


def test_release():
    assert release("1.2.3-rc.1".partition("-")[0]) == 0x1083
    assert loop_register_map()["release"].reset == release()


@pytest.mark.parametrize("config", [
    MatcherConfig(256, 9, method=OnePass()), MatcherConfig(5, 9, minimum=-3, method=changed(FUSED_1, sub_pixel=True)),
    MatcherConfig(5, 9, minimum=40, method=RECURSIVE_1)], ids=["thesis", "fused", "recursive"])
def test_stored_results(config):
    """Labels and flags, in as many bytes as they need; disparities with sign and fraction are found again."""
    fields = match(*noise(9, 4, 1), config)
    words = packed_result(fields, config)
    assert words.min() >= 0 and words.max() < 256 ** result_bytes(config)
    found = unpacked_result(words, config)
    assert set(found) == set(config.result_fields)
    assert all(np.array_equal(found[name], fields[name]) for name in found)
    assert [plane_bytes(plane, 9, config) for plane in range(4)] == [9, 9, 9, 9 * result_bytes(config)]


def test_device_by_hand():
    """A block, bytes in its place that are not it, a pause in it; and that a pair is kept."""
    device = LoopDevice(CONFIG, 2)
    request, block = encode_request(Request(Operation.BLOCK_WRITE, 1, 1)), encode_block(1, 1, b"picture")
    good, bad = encode_reply(Reply(Status.OK, 1, 1)), encode_reply(Reply(Status.BAD_SUM, 1))
    assert device.receive(request + block) == good
    assert device.pictures[1][1].tobytes() == b"picture" and not device.pictures[0].any()
    spoiled = encode_block(1, 1, b"another")[:-1] + b"\0"
    assert device.receive(request + spoiled + request + block) == bad
    assert device.pictures[1][1].tobytes() == b"picture"
    assert device.pause() == b"" and device.receive(request + b"pic") == b"" and device.pause() == bad
    assert device.receive(request + block) == good and device.values["uart_errors"] == 2
    read = encode_request(Request(Operation.BLOCK, 0, 0))
    assert device.receive(read) == encode_reply(Reply(Status.NOT_KEPT, 0))
    start = device.registers["start"].address
    assert device.receive(encode_request(Request(Operation.WRITE, start, 1))) == encode_reply(Reply(Status.OK, start, 1))
    assert device.receive(read) == encode_reply(Reply(Status.OK, 0, 0)) + bytes(7) + crc(bytes(10)).to_bytes(2, "big")
    assert device.values["pairs"] == 1


def test_page(tmp_path):
    assert main(["--loop", "--output", str(tmp_path / "page.md")]) == 0
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert text == loop_page(loop_register_map(LOOP_CONFIG))
    assert text == (ROOT / "docs" / "loop_registers.md").read_text(encoding="utf-8"), (
        "run python -m golden.host.register_page --loop --output docs/loop_registers.md")
    for register in loop_register_map(LOOP_CONFIG):
        assert f"| `0x{register.address:02X}` | `{register.name}` |" in text

"""golden.host.core_registers: the map of the core with a bus, accesses of words, and the page of both."""

import pathlib

import pytest

from golden.config import METHODS, Fused, MatcherConfig
from golden.host.core_registers import core_register_map, word_access
from golden.host.protocol import Status
from golden.host.register_page import core_page, main
from golden.host.registers import Kind, register_map


ROOT = pathlib.Path(__file__).parents[3]
REGISTERS = core_register_map(MatcherConfig(20, 300, -16, method=Fused()), 200)


@pytest.mark.parametrize("method", METHODS.values())
def test_settings_are_those_of_the_board_and_the_size(method):
    config = MatcherConfig(method=method())
    core, board = core_register_map(config), register_map(config)
    settings = {register.name: register for register in core.of(Kind.SETTING)}
    assert [settings.pop(name).limits for name in ("width", "height")] == ["1 .. 720", "1 .. 4096"]
    assert settings == {name: board[name] for name in config.settings}


@pytest.mark.parametrize("name, data, strobes, status, value", [
    ("width", 300, 15, Status.OK, 300),
    ("width", 301, 15, Status.OUT_OF_RANGE, 0),
    ("width", 0x1_0000 + 5, 15, Status.OUT_OF_RANGE, 0),    # no bit is ignored
    ("width", 0xFFFF_FF02, 0b0001, Status.OK, 0x102),       # merged with 0x110
    ("width", 0, 0b0010, Status.OK, 0x10),
    ("width", 0, 0, Status.OK, 0x110),
    ("minimum", 2**32 - 16, 15, Status.OK, 2**32 - 16),
    ("minimum", 2**32 - 17, 15, Status.OUT_OF_RANGE, 0),
    ("minimum", 0xFFF0, 0b0011, Status.OK, 2**32 - 16),     # merged with -1
    ("minimum", 2**16 - 16, 15, Status.OUT_OF_RANGE, 0),    # it is not that of 16 bits
    ("apply", 1, 15, Status.OK, 1),
    ("apply", 1, 0b1110, Status.OUT_OF_RANGE, 0),
    ("apply", 0, 15, Status.OUT_OF_RANGE, 0),
    ("frames", 0, 15, Status.READ_ONLY, 0),
    ("frames", 0, 0, Status.OK, 7),
    ("frames", None, 15, Status.OK, 7),
    ("minimum", None, 15, Status.OK, 2**32 - 1),
])
def test_word_access(name, data, strobes, status, value):
    values = {"width": 0x110, "minimum": -1, "frames": 7}
    register = REGISTERS[name]
    given = word_access(REGISTERS, values, register.address, data, strobes)
    assert given[:2] == (status, value)
    number = value - 2**32 if value >> 31 else value
    assert given[2] == ({name: number} if status is Status.OK and data is not None and strobes else {})


def test_unknown_address():
    assert word_access(REGISTERS, {}, 0xFF) == word_access(REGISTERS, {}, 0xFF, 1) == (Status.UNKNOWN_ADDRESS, 0, {})


def test_page_is_up_to_date(tmp_path):
    assert main(["--core", "--output", str(tmp_path / "page.md")]) == 0
    text = (tmp_path / "page.md").read_text()
    assert text == core_page(core_register_map(MatcherConfig(method=Fused())))
    assert (ROOT / "docs" / "core_registers.md").read_text() == text, (
        "run python -m golden.host.register_page --core --output docs/core_registers.md")


def test_page_tells_all():
    text = core_page(REGISTERS)
    for register in REGISTERS:
        assert f"| `0x{register.address:02X}` | `{register.name}` | {register.width} |" in text
        assert register.description in text
        assert all(f"{value} {word}" in register.limits or f"| {value} | {word} |" in text for value, word in register.words.items())
    assert max(map(len, text.splitlines())) <= 140

"""Descriptions of registers against the map that they are made of: SystemRDL by its compiler, the header by gcc, the Python module."""

import functools
import importlib.util
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

from golden.config import FUSED_1, RECURSIVE_2, MatcherConfig
from golden.host.core_registers import core_register_map
from golden.host.registers import Kind, register_map
from golden.rig.config import RigConfig
from hdl.packages.core import RegisterSpace
from hdl.packages.registers import register_files


#: Maps of a core with the settings of each method, with negative values; and of the system, in words of two bytes.
SPACES = {
    "recursive": RegisterSpace(core_register_map(MatcherConfig(method=RECURSIVE_2, minimum=-8)), 4, "Registers, of a test"),
    "fused": RegisterSpace(core_register_map(MatcherConfig(method=FUSED_1)), 4, "Registers"),
    "system": RegisterSpace(register_map(MatcherConfig(16, 64), 48, RigConfig()), 2, "Registers"),
}


@functools.cache
def files(name):
    pytest.importorskip("peakrdl_cheader", reason="the Python packages of the extra registers are not installed")
    return register_files("left_eye", SPACES[name])


@pytest.fixture(params=SPACES)
def described(request):
    return SPACES[request.param], files(request.param)


def test_systemrdl(described, tmp_path):
    """Compiles; addresses, reset values, access and names of values are the map's."""
    from systemrdl import RDLCompiler

    space, texts = described
    (tmp_path / "left_eye.rdl").write_text(texts["left_eye.rdl"])
    compiler = RDLCompiler()
    compiler.compile_file(str(tmp_path / "left_eye.rdl"))
    top = compiler.elaborate().top
    assert (top.inst_name, top.get_property("desc")) == ("left_eye", space.title)
    found = {each.inst_name: each for each in top.registers()}
    assert [*found] == [register.name for register in space.registers]
    for register in space.registers:
        described = found[register.name]
        field, = described.fields()
        bits = space.word_bits if register.signed else field.width
        assert described.absolute_address == register.address * space.word_bytes
        assert described.get_property("regwidth") == space.word_bits and (field.low, field.width) == (0, bits)
        assert field.get_property("reset") == register.reset % (1 << space.word_bits) and register.maximum < 1 << bits
        assert field.is_sw_writable == register.writable and field.is_sw_readable == (register.kind is not Kind.ACTION)
        assert field.get_property("singlepulse") == (register.kind is Kind.ACTION)
        assert described.get_property("desc").startswith(f"{register.description}; {register.access}, ")
        named = field.get_property("encode")
        assert sorted(member.value for member in named or ()) == sorted(register.words)


def test_header(described, tmp_path):
    """Compiles without warnings; offsets in its struct, masks and reset values are the map's."""
    if not shutil.which("gcc"):
        pytest.skip("gcc is not on this machine; install the package g++")
    space, texts = described
    (tmp_path / "left_eye.h").write_text(texts["left_eye.h"])
    lines = ['#include <stddef.h>', '#include <stdio.h>', '#include "left_eye.h"', "int main(void) {"]
    for register in space.registers:
        macro = f"LEFT_EYE__{register.name.upper()}__VALUE"
        lines.append(f'  printf("{register.name} %zu %zu %llu %llu\\n", offsetof(left_eye_t, {register.name}), '
                     f'sizeof(((left_eye_t *)0)->{register.name}), (unsigned long long){macro}_bm, (unsigned long long){macro}_reset);')
    (tmp_path / "main.c").write_text("\n".join([*lines, "  return 0;", "}", ""]))
    subprocess.run(["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "main.c", "-o", "main"], cwd=tmp_path, check=True, timeout=60)
    told = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True, timeout=60).stdout
    for register, line in zip(space.registers, told.splitlines(), strict=True):
        name, offset, size, mask, reset = line.split()
        assert (name, int(offset), int(size)) == (register.name, register.address * space.word_bytes, space.word_bytes)
        assert int(reset) == register.reset % (1 << space.word_bits)
        # All values of the register are within the mask, and no more bits than they need.
        values = [register.minimum % (1 << space.word_bits), register.maximum, *register.words]
        assert all(value & ~int(mask) == 0 for value in values)
        assert int(mask) == (1 << (space.word_bits if register.signed else max(1, max(values).bit_length()))) - 1


def python_module(text):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "left_eye_registers.py")
        path.write_text(text)
        spec = importlib.util.spec_from_file_location("left_eye_registers", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module


def test_python(described):
    space, texts = described
    module = python_module(texts["left_eye_registers.py"])
    assert module.WORD_BITS == space.word_bits
    assert {name: (each.offset, each.minimum, each.maximum, each.reset, each.unit, each.description, each.values)
            for name, each in module.REGISTERS.items()} == {
        each.name: (each.address * space.word_bytes, each.minimum, each.maximum, each.reset, each.unit, each.description, dict(each.words))
        for each in space.registers}
    assert {name: each.access for name, each in module.REGISTERS.items()} == {
        each.name: {Kind.SETTING: "rw", Kind.ACTION: "w"}.get(each.kind, "r") for each in space.registers}


def test_words():
    """Values to words and back; what cannot be written is refused."""
    module = python_module(files("recursive")["left_eye_registers.py"])
    for value in (-8, 0, 100):
        assert module.decode("minimum", module.encode("minimum", value)) == value
    assert module.encode("minimum", -8) == 2**32 - 8
    assert module.decode("frames", 65535) == 65535 and module.decode("frames", 2**31) == 2**31
    with pytest.raises(ValueError, match="minimum takes -8 to "):
        module.encode("minimum", -9)
    with pytest.raises(ValueError, match="version is read-only"):
        module.encode("version", 5)


def test_values_with_names():
    """Names that are no identifiers, or are there twice, become identifiers of their own."""
    names = re.findall(r"(?m)^ +(\w+) = \d+;$", re.search(r"(?s)enum decoder_step_values \{(.*?)\}", files("system")["left_eye.rdl"])[1])
    words = register_map()["decoder_step"].words
    assert len({*names}) == len(names) == len(words)
    assert names[0] == "power_up_20_ms"

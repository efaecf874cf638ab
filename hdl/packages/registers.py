"""Registers for a host's software: SystemRDL, a C header and a Python module, of the same map as docs/registers.md."""

import pprint
import re
import tempfile
import textwrap
from pathlib import Path
from typing import Any

from golden.host.registers import Kind, Register

from .core import RegisterSpace


__all__ = ["register_files"]


#: How software accesses registers of a kind, and how the hardware does, in SystemRDL.
_ACCESS = {
    Kind.CONSTANT: ("r", "na"), Kind.SETTING: ("rw", "r"), Kind.ACTION: ("w", "r"), Kind.STATUS: ("r", "w"), Kind.COUNTER: ("r", "w")}

_PYTHON = '''"""{title}.

``REGISTERS`` is the map, by name. ``encode`` makes the word that is written, ``decode`` the value of a word that was read.
"""

from typing import NamedTuple


WORD_BITS = {word_bits}


class Register(NamedTuple):
    """A register: byte offset, access ``r``, ``rw`` or ``w``, limits and reset value, unit, names of values."""
    offset: int
    access: str
    minimum: int
    maximum: int
    reset: int
    unit: str
    description: str
    values: dict


REGISTERS = {{
{rows}
}}


def encode(name, value):
    """The word that sets a register; ValueError if it cannot be written or has other limits."""
    register = REGISTERS[name]
    if "w" not in register.access:
        raise ValueError(f"the register {{name}} is read-only")
    if not register.minimum <= value <= register.maximum:
        raise ValueError(f"the register {{name}} takes {{register.minimum}} to {{register.maximum}}, not {{value}}")
    return value % (1 << WORD_BITS)


def decode(name, word):
    """The value of a word that was read; negative ones are two's complement."""
    signed = REGISTERS[name].minimum < 0
    return word - (1 << WORD_BITS) if signed and word >> (WORD_BITS - 1) else word
'''


def _description(register: Register) -> str:
    unit = f" {register.unit}" if register.unit else ""
    return f"{register.description}; {register.access}, {register.limits}{unit}"


def _field_bits(register: Register, space: RegisterSpace) -> int:
    """Bits of the field: of a value that may be negative the whole word, which has the sign in all upper bits.

    A constant's field has room for all values that have names.
    """
    named = max(register.words, default=0)
    return space.word_bits if register.signed else max(register.width, named.bit_length())


def _identifiers(register: Register) -> dict[str, int]:
    """Names of values as identifiers, each once."""
    names: dict[str, int] = {}
    for value, word in register.words.items():
        name = re.sub(r"\W+", "_", word).strip("_")
        if not name[0].isalpha():
            name = f"value_{name}"
        names[f"{name}_{value}" if name in names else name] = int(value)
    return names


def _model(name: str, space: RegisterSpace) -> Any:
    """The registers as an elaborated model of systemrdl-compiler, an address map ``name``."""
    from systemrdl import RDLCompiler, RDLImporter
    from systemrdl.rdltypes.user_enum import UserEnum, UserEnumMemberContainer
    from systemrdl.source_ref import FileSourceRef

    compiler = RDLCompiler()
    importer = RDLImporter(compiler)
    importer.default_src_ref = FileSourceRef("docs/registers.md")

    def assign(component: Any, **properties: Any) -> None:
        for key, value in properties.items():
            importer.assign_property(component, key, value)

    space_map = importer.create_addrmap_definition(name)
    assign(space_map, name=name, desc=space.title)
    for register in space.registers:
        software, hardware = _ACCESS[register.kind]
        field = importer.instantiate_field(importer.create_field_definition(), "value", 0, _field_bits(register, space))
        assign(field, sw=_access(software), hw=_access(hardware), reset=register.reset % (1 << space.word_bits))
        if register.kind is Kind.ACTION:
            assign(field, singlepulse=True)
        if register.words:
            members = [UserEnumMemberContainer(word, value) for word, value in _identifiers(register).items()]
            assign(field, encode=UserEnum.define_new(f"{register.name}_values", members))
        definition = importer.create_reg_definition()
        importer.add_child(definition, field)
        assign(definition, name=register.name, desc=_description(register), regwidth=space.word_bits, accesswidth=space.word_bits)
        importer.add_child(space_map, importer.instantiate_reg(definition, register.name, register.address * space.word_bytes))
    importer.register_root_component(space_map)
    return compiler.elaborate(name)


def _access(word: str) -> Any:
    from systemrdl.rdltypes import AccessType

    return AccessType[word]


def _python(space: RegisterSpace) -> str:
    rows = []
    for register in space.registers:
        software, _ = _ACCESS[register.kind]
        values = pprint.pformat({int(value): word for value, word in register.words.items()}, width=120, sort_dicts=False)
        rows += [f"    {register.name!r}: Register(",
                 f"        0x{register.address * space.word_bytes:03X}, {software!r}, {register.minimum}, {register.maximum}, "
                 f"{register.reset}, {register.unit!r},",
                 f"        {register.description!r},",
                 textwrap.indent(values, "        ") + "),"]
    return _PYTHON.format(title=space.title, word_bits=space.word_bits, rows="\n".join(rows))


def register_files(name: str, space: RegisterSpace) -> dict[str, str]:
    """``NAME.rdl``, ``NAME.h`` and ``NAME_registers.py``: the registers in SystemRDL, for C and for Python.

    Parameters
    ----------
    name : str
        Of the address map, an identifier.
    space : RegisterSpace

    Notes
    -----
    A register has one field ``value``, which is the whole word if values may be negative. The header has a ``struct`` of the registers and
    the masks and reset values of their fields; it is PeakRDL's.
    """
    from peakrdl_cheader.exporter import CHeaderExporter
    from peakrdl_systemrdl import SystemRDLExporter
    from systemrdl import RDLCompiler

    with tempfile.TemporaryDirectory(prefix="registers-") as folder:
        rdl, header = Path(folder, f"{name}.rdl"), Path(folder, f"{name}.h")
        SystemRDLExporter().export(_model(name, space), str(rdl))
        # From the file that is delivered: what does not compile is not written, and names are those of its scopes.
        compiler = RDLCompiler()
        compiler.compile_file(str(rdl))
        CHeaderExporter().export(compiler.elaborate(), str(header))
        return {rdl.name: rdl.read_text(), header.name: header.read_text(), f"{name}_registers.py": _python(space)}

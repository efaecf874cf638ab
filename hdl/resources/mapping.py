"""The Verilog of a component, as it is delivered, mapped to the elements of a Cyclone III by Yosys passes."""

import re
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..emit import verilog_text
from ..netlist import Netlist, read_netlist
from ..yosys import Tool, run_yosys


__all__ = ["Mapped", "Memory", "block_of", "map_cyclone3"]


_FILES = Path(__file__).parent / "cyclone3"

# Marks the block of a cell in the attribute that usually holds a line of the source: Yosys's passes preserve it.
_MARK = "block="

# A copy of a module for each place where it is, named after its path.
_INSTANCES = """
# reading
read_verilog design.v
hierarchy -check -top {top}
uniquify
write_rtlil instances.il
"""

# Comments name the steps, for the display of progress. `memory_dff` takes registers into memories before `opt` can change them: a register
# with an enable behind a memory must be one cell (`opt_dff`, for these alone) to be its data register; else it would be taken for the
# address register of the next memory. `wreduce` and `opt -fine` make operands no wider than their values. Registers are
# mapped before the tables, because ABC would map the logic between registers of different clock enables separately.
_SCRIPT = """
# elaborating
read_rtlil marked.il
read_verilog -lib {files}/cells.v
hierarchy -check -top {top}
proc
flatten
opt_expr -mux_undef
opt_clean
opt_dff t:$memrd %co4 t:$dff %i
opt_clean
memory_dff
opt -nodffe -nosdff
wreduce
peepopt
opt_clean
# multipliers
wreduce t:$mul
techmap -map +/mul2dsp.v -D DSP_A_MAXWIDTH=18 -D DSP_B_MAXWIDTH=18 -D DSP_A_MINWIDTH=10 -D DSP_B_MINWIDTH=4 -D DSP_NAME=$__C3_MULT18
chtype -set $mul t:$__soft_mul
techmap -map +/mul2dsp.v -D DSP_A_MAXWIDTH=9 -D DSP_B_MAXWIDTH=9 -D DSP_A_MINWIDTH=4 -D DSP_B_MINWIDTH=4 -D DSP_NAME=$__C3_MULT9
chtype -set $mul t:$__soft_mul
techmap -map {files}/multipliers.v
opt -fine
# memories
memory -nomap
opt_clean
tee -q -o memories.il dump t:$mem_v2
memory_libmap -logic-cost-ram 0.25 -lib {files}/memories.txt
tee -q -o small_memories.il dump t:$mem_v2
techmap -map {files}/memories.v
opt -fast -mux_undef -undriven -fine
memory_map
opt -undriven -fine
# carry chains
techmap -map {files}/arithmetic.v
opt -fast
techmap
opt -fast
dfflegalize -cell $_DFF_P_ 0 -cell $_DFFE_PP_ 0 -cell $_SDFF_PP0_ 0 -cell $_SDFFCE_PP0P_ 0 -cell $_DFF_PP0_ 0 -cell $_DFFE_PP0P_ 0
opt_merge
techmap -map {files}/registers.v
opt_clean
# tables
abc -lut 4
clean
techmap -map {files}/tables.v
clean -purge
write_json netlist.json
"""


@dataclass(frozen=True)
class Memory:
    """A memory of the source: its path, and its size in bits."""
    name: str
    bits: int


@dataclass(frozen=True)
class Mapped:
    """A design that :func:`map_cyclone3` mapped: the flattened module, and the memories that are in memory blocks."""
    top: str
    module: Netlist
    memories: tuple[Memory, ...]


def block_of(attributes: Mapping[str, str]) -> str | None:
    """Path of the block that a cell was written in; the first in the alphabet if there are several."""
    marks = [mark.removeprefix(_MARK) for mark in attributes.get("src", "").split("|") if mark.startswith(_MARK)]
    return min(marks) if marks else None


def _marked(text: str) -> str:
    """RTLIL in which every cell and process is marked with the name of its module, which is its path, in place of source lines."""
    lines: list[str] = []
    module = ""
    for line in text.splitlines():
        if line.lstrip().startswith("attribute \\src "):
            continue
        if line.startswith("module \\"):
            module = line.removeprefix("module \\")
        elif line.startswith(("  cell ", "  process ")):
            lines.append(f'  attribute \\src "{_MARK}{module}"')
        lines.append(line)
    return "\n".join(lines) + "\n"


def _memories(text: str) -> dict[str, int]:
    """Sizes in bits of the memories in a dump."""
    sizes = {}
    for cell in re.split(r"(?m)^\s*cell ", text)[1:]:
        name = cell.split()[1].lstrip("\\")
        size, width = (int(re.search(rf"parameter (?:signed )?\\{key} (\d+)", cell)[1]) for key in ("SIZE", "WIDTH"))  # type: ignore[index]
        sizes[name] = size * width
    return sizes


def map_cyclone3(component: Any, name: str, report: Callable[[str], None] = lambda step: None, folder: Path | None = None) -> Mapped:
    """Map ``component``, flattened, to Cyclone III elements, beginning with its Verilog, :func:`hdl.emit.verilog_text`.

    With ``folder``, which exists, the netlist is left there as ``netlist.json``.
    """
    with tempfile.TemporaryDirectory(prefix="resources-") as temporary:
        work = Path(temporary) if folder is None else folder
        (work / "design.v").write_text(verilog_text(component, name=name))
        run_yosys(Tool.PYOSYS, _INSTANCES.format(top=name), work, report)
        (work / "marked.il").write_text(_marked((work / "instances.il").read_text()))
        run_yosys(Tool.PYOSYS, _SCRIPT.format(files=_FILES, top=name), work, report)
        written = _memories((work / "memories.il").read_text())
        small = _memories((work / "small_memories.il").read_text())
        memories = tuple(Memory(path, bits) for path, bits in written.items() if path not in small)
        return Mapped(name, read_netlist(work / "netlist.json")[name], memories)

"""A component mapped to what a Cyclone III consists of, by Yosys passes."""

import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amaranth.back import rtlil


__all__ = ["Memory", "Netlist", "block_of", "map_cyclone3", "marked_rtlil", "run_yosys"]


_FILES = Path(__file__).parent / "cyclone3"

# Where a cell comes from, as Yosys's passes hand it on: the attribute that elsewhere holds a line of the source.
_MARK = "block="

# Each with what the progress display says. `wreduce` and `opt -fine` make operands no wider than their values.
_READ = """
read_rtlil design.il
read_verilog -lib {files}/cells.v
hierarchy -check -top {top}
proc
flatten
opt_expr
opt_clean
opt -nodffe -nosdff
wreduce
peepopt
opt_clean
"""
_MULTIPLIERS = """
memory_dff
wreduce t:$mul
techmap -map +/mul2dsp.v -D DSP_A_MAXWIDTH=18 -D DSP_B_MAXWIDTH=18 -D DSP_A_MINWIDTH=10 -D DSP_B_MINWIDTH=4 -D DSP_NAME=$__C3_MULT18
chtype -set $mul t:$__soft_mul
techmap -map +/mul2dsp.v -D DSP_A_MAXWIDTH=9 -D DSP_B_MAXWIDTH=9 -D DSP_A_MINWIDTH=4 -D DSP_B_MINWIDTH=4 -D DSP_NAME=$__C3_MULT9
chtype -set $mul t:$__soft_mul
techmap -map {files}/multipliers.v
opt -fine
"""
_MEMORIES = """
memory -nomap
opt_clean
tee -q -o memories.il dump t:$mem_v2
memory_libmap -logic-cost-ram 0.25 -lib {files}/memories.txt
tee -q -o small_memories.il dump t:$mem_v2
techmap -map {files}/memories.v
opt -fast -mux_undef -undriven -fine
memory_map
opt -undriven -fine
"""
_CHAINS = """
techmap -map {files}/arithmetic.v
opt -fast
techmap
opt -fast
dfflegalize -cell $_DFF_P_ 0 -cell $_DFFE_PP_ 0 -cell $_SDFF_PP0_ 0 -cell $_SDFFCE_PP0P_ 0 -cell $_DFF_PP0_ 0 -cell $_DFFE_PP0P_ 0
opt_merge
techmap -map {files}/registers.v
opt_clean
"""
# The registers are mapped before: ABC would map what lies between registers of unlike clock enables each for itself.
_TABLES = """
abc -lut 4
clean
techmap -map {files}/tables.v
clean -purge
write_json netlist.json
"""
_STEPS = (
    ("reading", _READ), ("multipliers", _MULTIPLIERS), ("memories", _MEMORIES), ("carry chains", _CHAINS), ("tables", _TABLES),
)

# Runs in a process of its own: Yosys ends the process on an error, and memory comes back.
_WORKER = """
import sys
from pyosys import libyosys
design = libyosys.Design()
for line in sys.stdin:
    command, _, step = line.rstrip("\\n").partition("\\t")
    print(step, flush=True)
    design.run_pass(f"tee -q -a yosys.log {command}")
open("done", "w").close()
"""


@dataclass(frozen=True)
class Memory:
    """A memory as it was written: where it is, and its size in bits."""
    name: str
    bits: int


@dataclass(frozen=True)
class Netlist:
    """What :func:`map_cyclone3` made: the cells, as Yosys's JSON has them, and the memories that went into blocks."""
    top: str
    cells: dict[str, Any]
    ports: dict[str, Any]
    memories: tuple[Memory, ...]


def block_of(attributes: dict[str, Any]) -> str | None:
    """Path of the block that a cell comes from; of several the first."""
    marks = [mark.removeprefix(_MARK) for mark in attributes.get("src", "").split("|") if mark.startswith(_MARK)]
    return min(marks) if marks else None


def marked_rtlil(component: Any, name: str) -> str:
    """RTLIL of ``component`` in which every cell, process and memory carries the name of its module, that is its path."""
    lines: list[str] = []
    module = name
    for line in rtlil.convert(component, name=name, emit_src=False).splitlines():
        if line.startswith("module \\"):
            module = line.removeprefix("module \\").strip()
        elif line.startswith(("  cell ", "  process ", "  memory ")):
            lines.append(f'  attribute \\src "{_MARK}{module}"')
        lines.append(line)
    return "\n".join(lines) + "\n"


def run_yosys(steps: Iterable[tuple[str, str]], folder: Path, report: Callable[[str], None] = lambda step: None) -> None:
    """Run Yosys commands in ``folder``, a process of their own; ``report`` is told of each step, the first of a pair."""
    (folder / "done").unlink(missing_ok=True)
    commands = "".join(f"{command}\t{step}\n" for step, script in steps for command in script.strip().splitlines())
    with subprocess.Popen([sys.executable, "-c", _WORKER], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True) as worker:
        assert worker.stdin and worker.stdout
        worker.stdin.write(commands)
        worker.stdin.close()
        said = []
        for line in worker.stdout:
            said.append(line.strip())
            report(line.strip())
    if not (folder / "done").exists():
        log = folder / "yosys.log"
        raise RuntimeError(f"Yosys failed: {(log.read_text() if log.exists() else '')[-2000:]} {said[-3:]}")


def _memories(text: str) -> dict[str, int]:
    """Sizes in bits of the memories in a dump."""
    sizes = {}
    for cell in re.split(r"(?m)^\s*cell ", text)[1:]:
        name = cell.split()[1].lstrip("\\")
        size, width = (int(re.search(rf"parameter (?:signed )?\\{key} (\d+)", cell)[1]) for key in ("SIZE", "WIDTH"))  # type: ignore[index]
        sizes[name] = size * width
    return sizes


def map_cyclone3(component: Any, name: str, report: Callable[[str], None] = lambda step: None) -> Netlist:
    """Map ``component``, flattened, to Cyclone III elements."""
    with tempfile.TemporaryDirectory(prefix="resources-") as temporary:
        folder = Path(temporary)
        (folder / "design.il").write_text(marked_rtlil(component, name))
        run_yosys(((step, script.format(files=_FILES, top=name)) for step, script in _STEPS), folder, report)
        module = json.loads((folder / "netlist.json").read_text())["modules"][name]
        written = _memories((folder / "memories.il").read_text())
        small = _memories((folder / "small_memories.il").read_text())
        memories = tuple(Memory(path, bits) for path, bits in written.items() if path not in small)
        return Netlist(name, module["cells"], module["ports"], memories)

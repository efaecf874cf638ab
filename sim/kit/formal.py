"""Proofs: assertions that hold in every cycle, for all inputs. Yosys writes the circuit, ABC's `pdr` proves or refutes.

Both are part of pyosys. The method is property-directed reachability (Bradley, "SAT-based model checking without unrolling", 2011): it
finds the inductive invariant itself.
"""

import subprocess
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from amaranth.back import rtlil
from amaranth.hdl import ClockDomain, Elaboratable, Module, Value

from hdl.yosys import Tool, run_yosys


__all__ = ["prove"]


_CIRCUIT = """
read_rtlil design.il
hierarchy -top design
proc
flatten
chformal -lower
opt -full
techmap
opt -fast
dffunmap
aigmap
opt_clean
write_aiger -zinit design.aig
"""


def prove(elaboratable: Elaboratable, ports: Sequence[Value], folder: Path, *, timeout: float = 120) -> bool:
    """Whether no assertion in ``elaboratable`` can be violated. There is no reset: all registers start with their initial values.

    An assertion that is constantly true is ignored; :class:`ValueError` if there is no other.

    Parameters
    ----------
    elaboratable
        Has statements ``Assert(...)``, in the domain ``sync`` only.
    ports : sequence of Signal
        Inputs that may have any value in any cycle; others keep their initial value.
    folder : Path
        For the intermediate files.
    timeout : float
        Limit for ABC in seconds; :class:`TimeoutError` after it.
    """
    m = Module()
    m.domains.sync = sync = ClockDomain(reset_less=True)
    m.submodules.design = elaboratable
    (folder / "design.il").write_text(rtlil.convert(m, name="design", ports=[sync.clk, *ports], emit_src=False))
    run_yosys(Tool.PYOSYS, _CIRCUIT, folder)
    # `aig`, then numbers of nodes, inputs, latches, outputs, gates, and assertions.
    header = (folder / "design.aig").read_bytes().split(b"\n", 1)[0].split()
    if len(header) < 7 or header[3] == b"0":
        raise ValueError(f"{type(elaboratable).__name__} has no assertion about registers that depend on its inputs")
    pyosys = find_spec("pyosys")
    assert pyosys and pyosys.origin
    try:
        run = subprocess.run([Path(pyosys.origin).with_name("yosys-abc"), "-c", "read_aiger design.aig; fold; strash; pdr"], cwd=folder,
                             check=True, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        raise TimeoutError(f"neither proved nor refuted in {timeout:g} s") from None
    proved, refuted = "Property proved" in run.stdout, "was asserted in frame" in run.stdout
    assert proved != refuted, run.stdout[-500:]
    return proved

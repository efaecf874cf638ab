"""Proofs: assertions that hold in every cycle, for all inputs. Yosys writes the circuit, ABC's `pdr` proves or refutes.

Both are part of pyosys. The method is property-directed reachability (Bradley, "SAT-based model checking without unrolling", 2011): it
finds the inductive invariant itself. Where it does not, `bmc3` looks for a violation within a number of cycles.
"""

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from amaranth.back import rtlil
from amaranth.hdl import ClockDomain, Elaboratable, Module, Signal, Value

from hdl.yosys import Tool, run_yosys


__all__ = ["Circuit", "Verdict", "prove", "told"]


# Three circuits: assertions, the witness, and the outputs. Memories become registers.
_CIRCUITS = """
read_rtlil design.il
hierarchy -top design
proc
flatten
memory -nomap
opt -full
memory_map
async2sync
chformal -lower
opt -full
techmap
opt -fast
dffunmap
setundef -anyseq
aigmap
opt_clean
design -save whole
delete -port o:*
opt_clean
write_aiger -zinit -map design.map design.aig
design -load whole
chformal -assert -remove
delete -port o:out.*
opt_clean
write_aiger -zinit witness.aig
design -load whole
chformal -remove
delete -port o:witness
opt_clean
write_aiger -ascii -zinit -map outputs.map outputs.aag
"""

# Registers that are equal in all reachable states are merged first: harnesses remember what the circuit does, too.
_PREPARE = "fold; orpos; strash; scorr; dc2; "


@dataclass(frozen=True)
class Verdict:
    """What a prover found.

    Members
    -------
    holds : bool
        No violation: in any cycle, or within ``depth`` cycles.
    depth : int or None
        Cycles that were searched, of a bounded proof; ``None``: unbounded.
    trace : list of dict
        A violation: the inputs by name, cycle by cycle, the last one that of the violation. Empty if there is none.
    """
    holds: bool
    depth: int | None
    trace: list[dict[str, int]]


def told(trace: Sequence[Mapping[str, int]]) -> str:
    """A violation as a table: a row a cycle, a column an input; those that are 0 all the time are left out."""
    names = [name for name in trace[0] if any(cycle[name] for cycle in trace)] if trace else []
    columns = [[name, *(f"{cycle[name]:x}" for cycle in trace)] for name in names]
    columns.insert(0, ["cycle", *map(str, range(len(trace)))])
    widths = [max(map(len, column)) for column in columns]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in zip(*columns))


class Circuit:
    """An elaboratable as a circuit of gates for ABC. There is no reset: all registers start with their initial values.

    Parameters
    ----------
    elaboratable
        Has statements ``Assert(...)``, and ``Assume(...)`` of what its surroundings never do, in the domain ``sync`` only.
    ports : sequence of Signal
        Inputs that may have any value in any cycle; others keep their initial value.
    folder : Path
        For the intermediate files.
    witness : Signal
        For :meth:`reaches`.
    outputs : mapping
        Names to signals, for :meth:`inputs_of`.
    """
    def __init__(self, elaboratable: Elaboratable, ports: Sequence[Value], folder: Path, *, witness: Signal | None = None,
                 outputs: Mapping[str, Value] | None = None):
        self.name = type(elaboratable).__name__
        self.folder = folder
        m = Module()
        m.domains.sync = sync = ClockDomain(reset_less=True)
        m.submodules.design = elaboratable
        given = []
        named = {f"out.{name}": value for name, value in (outputs or {}).items()} | ({} if witness is None else {"witness": witness})
        for name, value in named.items():
            port = Signal(len(value), name=name)
            m.d.comb += port.eq(value)
            given.append(port)
        (folder / "design.il").write_text(rtlil.convert(m, name="design", ports=[sync.clk, *ports, *given], emit_src=False))
        run_yosys(Tool.PYOSYS, _CIRCUITS, folder)

    @property
    def registers(self) -> int:
        """Bits of state, before equal ones are merged."""
        return int((self.folder / "design.aig").read_bytes().split(None, 4)[3])

    def _places(self, kind: str, file: str) -> dict[int, tuple[str, int]]:
        """Numbers of inputs or outputs to the names of ports and their bits."""
        lines = (line.split() for line in (self.folder / file).read_text().splitlines())
        return {int(line[1]): (line[3].lstrip("\\"), int(line[2])) for line in lines if line[0] == kind}

    def _abc(self, commands: str, timeout: float) -> str:
        pyosys = find_spec("pyosys")
        assert pyosys and pyosys.origin
        try:
            run = subprocess.run([Path(pyosys.origin).with_name("yosys-abc"), "-c", commands], cwd=self.folder, check=True,
                                 capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"neither proved nor refuted in {timeout:g} s") from None
        return run.stdout

    def _is_zero(self, file: str) -> bool:
        """Whether merging has made the only output constantly 0. The provers call such a circuit undecided."""
        header, *lines = (self.folder / file).read_bytes().split(b"\n")
        return lines[int(header.split()[3])] == b"0"

    def _trace(self, file: str) -> list[dict[str, int]]:
        """The counterexample that ABC has written."""
        places = self._places("input", file)
        # A line with the initial state of the registers, a line a cycle, and a comment. Inputs without a name are undefined values.
        _, *lines = (self.folder / "found.cex").read_text().partition("#")[0].rstrip("\n").split("\n")
        trace = []
        for line in lines:
            cycle = dict.fromkeys(sorted({name for name, _ in places.values()} - {"clk"}), 0)
            for number, (name, bit) in places.items():
                if name != "clk":
                    cycle[name] |= int(line[number]) << bit
            trace.append(cycle)
        return trace

    def check(self, depth: int | None = None, *, timeout: float = 120) -> Verdict:
        """Whether no assertion can be violated, in any cycle or, with ``depth``, in the first so many cycles.

        An assertion that is constantly true is ignored; :class:`ValueError` if there is no other. :class:`TimeoutError` after ``timeout``
        seconds.
        """
        # `aig`, then numbers of nodes, inputs, latches, outputs, gates, and assertions.
        header = (self.folder / "design.aig").read_bytes().split(b"\n", 1)[0].split()
        if len(header) < 7 or header[3] == b"0":
            raise ValueError(f"{self.name} has no assertion about registers that depend on its inputs")
        (self.folder / "found.cex").unlink(missing_ok=True)
        prover = "pdr" if depth is None else f"bmc3 -F {depth}"
        said = self._abc(f"read_aiger design.aig; {_PREPARE} write_aiger merged.aig; {prover}; write_cex -a found.cex", timeout)
        if self._is_zero("merged.aig"):
            return Verdict(True, depth, [])
        refuted = "was asserted in frame" in said
        bounded = depth is not None and f"No output asserted in {depth} frames" in said
        proved = depth is None and "Property proved" in said
        assert refuted + bounded + proved == 1, said[-500:]
        return Verdict(not refuted, depth, self._trace("design.map") if refuted else [])

    def reaches(self, depth: int, *, timeout: float = 120) -> bool:
        """Whether the witness can be 1 in one of the first ``depth`` cycles, under the assumptions: a proof that says nothing is seen."""
        return "was asserted in frame" in self._abc(f"read_aiger witness.aig; {_PREPARE} bmc3 -F {depth}", timeout)

    def inputs_of(self, output: str) -> set[str]:
        """The inputs that an output depends on combinationally."""
        header, *lines = (self.folder / "outputs.aag").read_text().splitlines()
        inputs, registers, outputs, gates = (int(number) for number in header.split()[2:6])
        places = self._places("input", "outputs.map")
        named = {int(lines[number]) // 2: name for number, (name, _) in places.items()}
        first = inputs + registers
        waiting = [int(lines[first + number]) // 2 for number, (name, _) in self._places("output", "outputs.map").items()
                   if name == f"out.{output}"]
        assert waiting, output
        # Behind the outputs are lines of what else AIGER has, none here; then the gates: an output and its two inputs.
        fan_in = {}
        for line in lines[first + outputs:first + outputs + gates]:
            gate, *operands = (int(number) // 2 for number in line.split())
            fan_in[gate] = operands
        found, seen = set(), set(waiting)
        while waiting:
            node = waiting.pop()
            found |= {named[node]} if node in named else set()
            fresh = set(fan_in.get(node, ())) - seen
            seen |= fresh
            waiting += fresh
        return found


def prove(elaboratable: Elaboratable, ports: Sequence[Value], folder: Path, *, timeout: float = 120) -> bool:
    """Whether no assertion in ``elaboratable`` can be violated; see :class:`Circuit` and :meth:`Circuit.check`."""
    return Circuit(elaboratable, ports, folder).check(timeout=timeout).holds

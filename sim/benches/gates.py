"""Whole matchers after synthesis, on pictures: the cells of an FPGA in the place of the emitted Verilog."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, Engine, MatcherConfig, OnePass
from hdl.matcher.matcher import Matcher
from hdl.netlist import read_netlist

from ..kit.gate_level import cyclone3_level, gate_level
from .matcher_bench import MatcherBench, pictures


__all__ = ["FAMILIES", "MATCHERS", "Family", "GateBench", "check_pictures"]


class Family(NamedTuple):
    """Devices: the function that synthesises for them, its netlist, and the kinds of their cells that a matcher must have."""
    level: Callable[[Any, str, Path], Path]
    netlist: str
    kinds: frozenset[str]


FAMILIES = {
    "ECP5": Family(gate_level, "design.json", frozenset({"LUT4", "CCU2C", "TRELLIS_FF", "DP16KD"})),
    "Cyclone III": Family(cyclone3_level, "netlist.json", frozenset({"C3_LUT", "C3_ADD", "C3_FF", "C3_M9K"})),
}
#: A matcher of each method and engine.
MATCHERS = {
    "thesis": MatcherConfig(8, 24, engine=Engine.SEQUENTIAL, method=OnePass(Arithmetic.THESIS)),
    "linear": MatcherConfig(8, 24, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR)),
    "fused": MatcherConfig(8, 24, method=FUSED_1),
    "recursive": MatcherConfig(8, 24, method=RECURSIVE_1),
}


class GateBench(MatcherBench):
    """A matcher's netlist, for several runs.

    Parameters
    ----------
    case : MatcherConfig
    family : str
        One of :data:`FAMILIES`.
    folder : Path
        To work in.

    Members
    -------
    cells : Counter
        By kind.
    """
    def __init__(self, case: MatcherConfig, family: str, folder: Path):
        self.matcher = Matcher(case)
        self.case = case
        self.folder = folder
        level, netlist, kinds = FAMILIES[family]
        self.verilog = level(self.matcher, "matcher", folder / "gates")
        self.cells = Counter(cell.kind for cell in read_netlist(folder / "gates" / netlist)["matcher"].cells.values())
        assert kinds <= self.cells.keys()


def check_pictures(bench: GateBench, simulator: str) -> int:
    """Two frames in a row at full rate, and with stalls and other settings: bit-exact, or :class:`AssertionError`; the clocks."""
    width = bench.case.max_width
    lefts, rights = pictures([(width, 5), (width // 2, 2)], bench.case.labels)
    settings = {"in_use": bench.case.labels - 1}
    results = [bench.check(lefts, rights, simulator),
               bench.check(lefts, rights, simulator, stall_i=0.3, stall_o=0.3, settings=settings)]
    return sum(result.report["clocks"] for result in results)

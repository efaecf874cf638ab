"""Emitted Verilog in which nothing has a value before it is reset or written."""

import re
from collections.abc import Sequence
from typing import NamedTuple


__all__ = ["KEPT", "Kept", "without_initial_values"]


_MODULE = re.compile(r"(?m)^(?=module )")
_INITIAL = re.compile(r"(?m)^  initial (\w+) = \d+'\w+;\n")


class Kept(NamedTuple):
    """Registers of modules, both as regular expressions, that keep their initial values, and why they are not to start as X."""
    module: str
    register: str
    reason: str


#: What is wrong as X, though whichever bits it holds no result depends on them: with noise there the results are exact.
KEPT: Sequence[Kept] = (
    Kept("matcher_engine_comparison", "o", "the label of least energy is that of the next pixel's left neighbour; before the first pixel "
         "there is none, and its slope is 0, but in a simulator 0 * X is X"),
    Kept("matcher_engine_array", r"count\w*", "the counter of the addresses of delays may begin anywhere, but X + 1 is X for ever"),
    Kept(r"matcher_engine_gates\w*", r"(settings|whole)\w*", "whether the tables of gates, which the FPGA's configuration fills, are "
         "whole, and of which settings: a branch on X would not fill them again"),
)


def without_initial_values(verilog: str, kept: Sequence[Kept] = ()) -> str:
    """Verilog in which registers have no initial values, with or without a reset: they start as X in Icarus, as noise in Verilator.

    Contents of look-up tables stay. No other memory has any.

    Parameters
    ----------
    verilog : str
        Of :func:`hdl.emit.verilog_text`, top module ``matcher``.
    kept : sequence of Kept
        Registers that keep theirs.
    """
    def changed(part: str) -> str:
        module = part.partition("(")[0].removeprefix("module ")
        registers = [each.register for each in kept if re.fullmatch(each.module, module)]
        return _INITIAL.sub(lambda found: found[0] if any(re.fullmatch(each, found[1]) for each in registers) else "", part)

    return "".join(map(changed, _MODULE.split(verilog)))

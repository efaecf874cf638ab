"""What linters may say about our Verilog, with the reasons."""


__all__ = ["verilator_waivers"]


_WAIVERS = """\
`verilator_config
// For Verilator: verilator --lint-only -Wall {name}.vlt {name}.v

// One file has all modules of the core.
lint_off -rule DECLFILENAME -file "*{name}.v"
// A module that stands in several places has outputs that not all of them need.
lint_off -rule PINCONNECTEMPTY -file "*{name}.v"
// Streams and waves have the same fields everywhere, and not every module reads all of them. The result of an addition or a subtraction
// has a carry bit, whether it is used or not.
lint_off -rule UNUSEDSIGNAL -file "*{name}.v" -match "Bits of signal are not *"
// Where the low bits of such a result are a register's input, only the carry is left of its own name.
lint_off -rule UNUSEDSIGNAL -file "*{name}.v" -match "Signal is not used: '_*_'*"
"""


def verilator_waivers(name: str) -> str:
    """Configuration of Verilator that waives what ``NAME.v`` is warned of, and is right in; only with ``-Wall`` is there any warning."""
    return _WAIVERS.format(name=name)

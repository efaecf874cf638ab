"""The ECP5-85F: the device of the boards that one can buy, and the first stand-in for a clock rate."""

from pathlib import Path

from .floorplan import place_labels
from .lattice import Lattice, Limit
from .multiplier_registers import absorb_multiplier_registers
from .output_registers import absorb_output_registers


__all__ = ["ECP5", "MEMORIES", "MULTIPLIERS", "TABLES"]


#: What the largest device has: tables of four inputs, each with a register; memory blocks of 18 kbit; multipliers of 18x18 bits.
TABLES, MEMORIES, MULTIPLIERS = 83_640, 208, 156

# Where the device has too few multipliers for all products, narrow ones are tables; it has the wide ones only if those fit.
_WIDE_ONLY = """
proc
flatten
opt_expr
opt_clean
wreduce
techmap -map +/mul2dsp.v -map +/lattice/dsp_map_18x18.v {limits} -D DSP_NAME=$__MUL18X18
chtype -set $mul t:$__soft_mul
""".format(limits=" ".join(f"-D DSP_{side}_{limit}" for side in "AB" for limit in ("MAXWIDTH=18", "MINWIDTH=9")))


def _prepare(design: Path, top: str) -> None:
    """Move registers into blocks, and give labels their places."""
    for absorb in (absorb_output_registers, absorb_multiplier_registers):
        absorb(design, top)
    place_labels(design, top)


ECP5 = Lattice(
    device="ECP5-85F, speed grade 6", family="ecp5", options=("--85k", "--speed", "6", "--package", "CABGA756"), synthesis="synth_ecp5",
    tables=Limit("tables", TABLES, {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 4}), registers=Limit("registers", TABLES, {"TRELLIS_FF": 1}),
    memories=Limit("memory blocks", MEMORIES, {"DP16KD": 1}), multipliers=Limit("multipliers", MULTIPLIERS, {"MULT18X18D": 1}),
    wide_only=_WIDE_ONLY, prepare=_prepare)

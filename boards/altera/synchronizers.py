"""Synchronisers for FPGAs of Altera: registers that Quartus neither merges, moves nor removes, and that it counts as synchronisers.

Amaranth's platform for Altera instantiates ``altera_std_synchronizer``, which Quartus has in folders of its IP only, and which comes with a
false path to its first register: that would cut the bounds of :mod:`boards.altera.crossings`.
"""

from amaranth import *
from amaranth.lib.cdc import AsyncFFSynchronizer, FFSynchronizer


__all__ = ["ATTRIBUTE", "FIRST_STAGE", "LATER_STAGE", "STAGE", "async_ff_synchronizer", "ff_synchronizer"]


#: Attribute by which Verilog carries settings of Quartus.
ATTRIBUTE = "altera_attribute"
#: Settings of all registers: optimisation neither retimes, duplicates, merges nor removes them.
LATER_STAGE = "-name ADV_NETLIST_OPT_ALLOWED NEVER_ALLOW; -name DONT_MERGE_REGISTER ON; -name PRESERVE_REGISTER ON"
#: Settings of the first register: with them Quartus reports its time to settle, and places the next one near.
FIRST_STAGE = f"{LATER_STAGE}; -name SYNCHRONIZER_IDENTIFICATION FORCED_IF_ASYNCHRONOUS"
#: Name of the registers, before their number: the first is ``stage0``.
STAGE = "stage"


def _stages(count: int, width: int, *, reset_less: bool = False) -> list[Signal]:
    return [Signal(width, name=f"{STAGE}{number}", reset_less=reset_less, attrs={ATTRIBUTE: LATER_STAGE if number else FIRST_STAGE})
            for number in range(count)]


def _check(synchronizer: FFSynchronizer | AsyncFFSynchronizer) -> None:
    if synchronizer._max_input_delay is not None:
        raise ValueError("a synchroniser's greatest input delay is a constraint of the project: leave max_input_delay out")


def ff_synchronizer(synchronizer: FFSynchronizer) -> Module:
    """Registers in place of an ``FFSynchronizer``, with the same latency and initial value.

    Bits that start as 1 are stored inverted: the device's registers start as 0, and Quartus would have to move an inverter through
    registers that it must leave alone.
    """
    _check(synchronizer)
    m = Module()
    width = len(synchronizer.i)
    start = Const(synchronizer._init, width)
    stages = _stages(synchronizer._stages, width, reset_less=synchronizer._reset_less)
    for source, stage in zip((Value.cast(synchronizer.i) ^ start, *stages), stages, strict=False):
        m.d[synchronizer._o_domain] += stage.eq(source)
    m.d.comb += Value.cast(synchronizer.o).eq(stages[-1] ^ start)
    return m


def async_ff_synchronizer(synchronizer: AsyncFFSynchronizer) -> Module:
    """Registers in place of an ``AsyncFFSynchronizer``: cleared while the input is active, then filled with ones.

    The device's registers have a clear but no preset, so the output is the last one's inverse.
    """
    _check(synchronizer)
    m = Module()
    m.domains += ClockDomain("cleared", async_reset=True, local=True)
    m.d.comb += [
        ClockSignal("cleared").eq(ClockSignal(synchronizer._o_domain)),
        ResetSignal("cleared").eq(synchronizer.i if synchronizer._edge == "pos" else ~synchronizer.i),
    ]
    stages = _stages(synchronizer._stages, 1)
    for source, stage in zip((1, *stages), stages, strict=False):
        m.d.cleared += stage.eq(source)
    m.d.comb += synchronizer.o.eq(~stages[-1])
    return m

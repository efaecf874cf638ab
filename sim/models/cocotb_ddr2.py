"""The memory model of :mod:`sim.models.ddr2` for cocotb benches."""

from typing import Any

from cocotb.triggers import ReadOnly, RisingEdge

from hdl.video.words import WORD_BYTES

from .ddr2 import LocalMemory, Request


__all__ = ["serve"]


def _word(value: Any, be: int) -> int:
    """A word to write as a number; bytes that are not enabled may be unknown, and become 0 then."""
    if value.is_resolvable:
        return value.to_unsigned()
    text = str(value)
    places = [(n, len(text) - 8 * n) for n in range(WORD_BYTES) if be >> n & 1]
    assert all(set(text[end - 8:end]) <= {"0", "1"} for _, end in places), f"bytes to write are unknown: {text}, enabled {be:016b}"
    return sum(int(text[end - 8:end], 2) << 8 * n for n, end in places)


async def serve(dut: Any, name: str, memory: LocalMemory, clock: Any = None) -> None:
    """Run in the background (``cocotb.start_soon``): the memory at the local bus whose ports begin with ``name_``.

    ``clock`` is ``dut.clk`` by default. Start it before the reset ends; unknown requests count as none.
    """
    clock = dut.clk if clock is None else clock
    strobes = [getattr(dut, f"{name}_{member}") for member in ("write_req", "read_req", "burstbegin")]
    address, size, be, wdata = (getattr(dut, f"{name}_{member}") for member in ("address", "size", "be", "wdata"))
    outputs = {member: getattr(dut, f"{name}_{member}") for member in ("ready", "rdata", "rdata_valid", "init_done")}
    driven: dict[str, int] = {}
    while True:
        for member, handle in outputs.items():
            # An access to the simulator costs more than a clock of the model, and few outputs change in a clock.
            if driven.get(member) != (value := getattr(memory, member)):
                handle.value = driven[member] = value
        await ReadOnly()
        request = None
        values = [strobe.value for strobe in strobes]
        if all(value.is_resolvable for value in values):
            write_req, read_req, burstbegin = map(int, values)
            if write_req or read_req or burstbegin:
                enabled = int(be.value) if write_req else 0
                request = Request(address=int(address.value), write_req=write_req, read_req=read_req, burstbegin=burstbegin,
                                  wdata=_word(wdata.value, enabled) if write_req else 0, be=enabled, size=int(size.value))
        await RisingEdge(clock)
        memory.clock(request)

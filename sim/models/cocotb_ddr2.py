"""The memory model of :mod:`sim.models.ddr2` in a cocotb bench."""

from cocotb.triggers import ReadOnly, RisingEdge

from .ddr2 import Request


__all__ = ["serve"]


async def serve(dut, name, memory, clock=None):
    """Run in the background (``cocotb.start_soon``): the memory at the local bus whose ports begin with ``name__``.

    ``clock`` is ``dut.clk`` by default. Start it before the reset ends; while the requests are unknown there are none.
    """
    clock = dut.clk if clock is None else clock
    strobes = [getattr(dut, f"{name}__{member}") for member in ("write_req", "read_req", "burstbegin")]
    rest = {member: getattr(dut, f"{name}__{member}") for member in ("address", "wdata", "be", "size")}
    outputs = {member: getattr(dut, f"{name}__{member}") for member in ("ready", "rdata", "rdata_valid", "init_done")}
    driven: dict[str, int] = {}
    while True:
        for member, handle in outputs.items():
            # Most clocks change little, and each access costs more than the model's clock.
            if driven.get(member) != (value := getattr(memory, member)):
                handle.value = driven[member] = value
        await ReadOnly()
        request = None
        values = [strobe.value for strobe in strobes]
        if all(value.is_resolvable for value in values):
            write_req, read_req, burstbegin = map(int, values)
            if write_req or read_req or burstbegin:
                request = Request(write_req=write_req, read_req=read_req, burstbegin=burstbegin,
                                  **{member: handle.value.to_unsigned() for member, handle in rest.items()})
        await RisingEdge(clock)
        memory.clock(request)

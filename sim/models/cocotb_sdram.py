"""The memory model of :mod:`sim.models.sdram` for cocotb benches."""

from typing import Any

from cocotb.triggers import ReadOnly, RisingEdge

from .sdram import PinWord, SdramMemory


__all__ = ["serve_sdram_ports"]


async def serve_sdram_ports(dut: Any, memory: SdramMemory) -> None:
    """Run in the background (``cocotb.start_soon``): the memory at the ports of a :class:`hdl.loop.sdram.SdramPins` named ``memory``."""
    outputs = [getattr(dut, f"memory_{name}") for name in PinWord._fields]
    while True:
        dut.memory_found.value = memory.found
        await ReadOnly()
        pins = PinWord(*(int(output.value) for output in outputs))
        await RisingEdge(dut.clk)
        memory.edge(pins)

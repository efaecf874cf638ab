"""The cocotb half of ``test_coverage.py``."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles


async def start(dut):
    for name in ("go", "twice"):
        getattr(dut, name).value = 0
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0
    await pulse(dut, "go")


async def pulse(dut, name):
    getattr(dut, name).value = 1
    await ClockCycles(dut.clk, 1)
    getattr(dut, name).value = 0
    await ClockCycles(dut.clk, 2)


@cocotb.test()
async def once(dut):
    await start(dut)
    assert dut.out.value == 5


@cocotb.test()
async def again(dut):
    await start(dut)
    await pulse(dut, "twice")
    assert dut.out.value == 0
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)

"""The cocotb half of ``harness.v``: clock, reset, start; then wait until it is done."""

import time

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer


@cocotb.test()
async def pictures(dut):
    dut.go.value = 0
    dut.rst.value = 1
    # The first edge finds it so: an unknown reset would leave unknown bits in the registers of a netlist.
    await Timer(1, "ns")
    # A clock in C++: in Python it would cost more than the design.
    cocotb.start_soon(Clock(dut.clk, 10, "ns", impl="gpi").start())
    await ClockCycles(dut.clk, 4)
    dut.rst.value = 0
    dut.go.value = 1
    start = time.perf_counter()
    await RisingEdge(dut.done)
    seconds = time.perf_counter() - start
    # The harness has closed the report.
    with open(cocotb.plusargs["report"], "a") as report:
        report.write(f"seconds {seconds:.6f}\n")

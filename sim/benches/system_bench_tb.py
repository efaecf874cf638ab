"""The cocotb half of ``system.v``: clocks and resets; then wait until it is done."""

import os
import time

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, Timer


@cocotb.test()
async def pictures(dut):
    clocks = dict(zip(("clk", "display_clk", "left_camera_clk", "right_camera_clk"), map(int, os.environ["PERIODS"].split())))
    for name in clocks:
        getattr(dut, name.replace("clk", "rst")).value = 1
    for name, period in clocks.items():
        # Clocks in C++: in Python they would cost more than the design.
        cocotb.start_soon(Clock(getattr(dut, name), period, "ps", impl="gpi").start())
    await Timer(1, "us")
    for name in ("rst", "left_camera_rst", "right_camera_rst"):
        getattr(dut, name).value = 0
    start = time.perf_counter()
    # The monitor has just begun a frame as the picture is there: a bench need not wait for it.
    await Timer(int(os.environ["DISPLAY_NS"]), "ns")
    dut.display_rst.value = 0
    await RisingEdge(dut.done)
    with open(cocotb.plusargs["report"], "a") as report:
        report.write(f"seconds {time.perf_counter() - start:.3f}\n")

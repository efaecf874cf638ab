"""The cocotb half of a test of builds: the output ``a`` has the value of the environment variable ``A``."""

import os

import cocotb
from cocotb.triggers import Timer


@cocotb.test()
async def constant(dut):
    await Timer(1, "ns")
    assert dut.a.value == int(os.environ["A"])

"""The cocotb half of the test of :mod:`sim.kit.cocotb_streams`: words through a register stage."""

import os
import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles

from sim.kit.cocotb_streams import check_rules, drain, sink, source


@cocotb.test()
async def words_pass(dut):
    stall = float(os.environ["STALL"])
    for name in ("u1", "u2", "u3", "in_use", "apply_settings", "clear", "i_valid", "i_payload", "o_ready"):
        getattr(dut, name).value = 0
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0
    words = [random.Random(1).getrandbits(19) for _ in range(40)]
    transfers, clocks = [], []
    cocotb.start_soon(check_rules(dut, "i"))
    cocotb.start_soon(check_rules(dut, "o", transfers, clocks))
    sender = cocotb.start_soon(source(dut, "i", words, rng=random.Random(2), stall=stall, timeout=200))
    received = await sink(dut, "o", len(words), rng=random.Random(3), stall=stall, timeout=200)
    await sender
    expected = [word >> 16 << 4 | word & 15 for word in words]
    assert received == transfers == expected
    assert await drain(dut, "o") == []
    if stall == 0:
        assert clocks == list(range(clocks[0], clocks[0] + len(words)))

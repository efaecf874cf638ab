"""The cocotb half of :mod:`sim.benches.disorder`."""

import json
import os
import random
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles

from sim.kit.cocotb_streams import check_rules, drain, sink, source


STALL = 0.2
# Clocks in which a frame that is cut may give what it can.
WAIT = 300
FOREVER = 1 << 30


async def reset(dut):
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0


@cocotb.test()
async def disorder(dut):
    plan = json.loads(Path(os.environ["STEPS"]).read_text())
    rng = random.Random(1)
    for name in (*plan["bits"], "apply_settings", "clear", "i_valid", "i_payload", "o_ready"):
        getattr(dut, name).value = 0
    cocotb.start_soon(Clock(dut.clk, 10, "ns", impl="gpi").start())
    await reset(dut)
    for number, step in enumerate(plan["steps"]):
        rules = cocotb.start_soon(check_rules(dut, "o"))
        if "cut" in step:
            draining = cocotb.start_soon(drain(dut, "o", FOREVER))
            await source(dut, "i", step["words"][:step["cut"]], rng=rng)
            await ClockCycles(dut.clk, WAIT)
            draining.cancel()
            rules.cancel()
            await reset(dut)
            rules = cocotb.start_soon(check_rules(dut, "o"))
        if "settings" in step:
            for name, value in step["settings"].items():
                getattr(dut, name).value = value & (1 << plan["bits"][name]) - 1
            dut.apply_settings.value = 1
            await ClockCycles(dut.clk, 1)
            dut.apply_settings.value = 0
        sender = cocotb.start_soon(source(dut, "i", step["words"], rng=rng, stall=STALL))
        received = await sink(dut, "o", len(step["expected"]), rng=rng, stall=STALL)
        await sender
        wrong = [place for place, pair in enumerate(zip(received, step["expected"])) if pair[0] != pair[1]]
        assert not wrong, f"step {number}: {len(wrong)} of {len(received)} words, the first is {wrong[0]}"
        assert await drain(dut, "o") == []
        rules.cancel()
        assert int(dut.error.value) == step.get("error", 0), f"step {number}: error"
        dut.clear.value = 1
        await ClockCycles(dut.clk, 1)
        dut.clear.value = 0
        await ClockCycles(dut.clk, 1)
        assert int(dut.error.value) == 0, f"step {number}: error is not cleared"

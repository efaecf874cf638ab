"""Pairs of two cameras through the emitted Verilog of both stages; see ``test_rig.py``."""

import json
import os
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles

from golden.rig.balance import Auto
from golden.rig.maps import map_sum, pack
from golden.rig.rectify import rectify
from hdl.matcher.stream import PixelPair
from hdl.rig.balance import BalanceMode
from sim.benches.rig import maps_of, pictures_of
from sim.kit.cases import comparable, pixel_words
from sim.kit.cocotb_streams import check_rules, drain, sink, source
from sim.kit.payloads import pack as packed


CASE = json.loads(os.environ["CASE"])


@cocotb.test()
async def pairs(dut):
    """The map of the build, then another one, which is loaded as the frame before is received; the last pair is a copy."""
    width, height, labels, minimum, stall = (CASE[name] for name in ("width", "height", "labels", "minimum", "stall"))
    inputs = {"rectify": 1, "map_side": 0, "map_start": 0, "map_address": 0, "map_next": 0, "map_low": 0, "map_middle": 0, "map_high": 0,
              "swap": 0, "clear": 0, "balance": int(BalanceMode.AUTO),
              "fixed_gain": 0, "fixed_offset": 0, "width": width, "height": height, "minimum": minimum & 511,
              "i_valid": 0, "i_payload": 0, "o_ready": 0}
    for name, value in inputs.items():
        getattr(dut, name).value = value
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0

    frames = pictures_of(CASE)
    auto = Auto(minimum, labels)
    expected = []
    for number, frame in enumerate(frames):
        if number < len(frames) - 1:
            left, right = (rectify(side, which) for side, which in zip(frame, maps_of(CASE, number > 1)))
            expected += pixel_words(left, auto.pair(left, right))
        else:
            expected += pixel_words(*frame)
    transfers = []
    cocotb.start_soon(check_rules(dut, "i"))
    cocotb.start_soon(check_rules(dut, "o", transfers))

    async def load():
        async def act(name):
            getattr(dut, name).value = 1
            await ClockCycles(dut.clk, 1)
            getattr(dut, name).value = 0

        for side, which in enumerate(maps_of(CASE, True)):
            dut.map_side.value = side
            await act("map_start")
            words = pack(which)
            for word in words:
                dut.map_low.value, dut.map_middle.value, dut.map_high.value = word & 65535, word >> 16 & 65535, word >> 32
                await act("map_next")
                await ClockCycles(dut.clk, 4)
            assert int(dut.map_sum.value) == map_sum(words)

    async def send():
        rng = random.Random(1)
        for number, frame in enumerate(frames):
            words = [packed(PixelPair(), word) for word in pixel_words(*frame)]
            if number == len(frames) - 1:
                # Both stages sample as a frame enters them: the last pair of the other kind must have left first.
                while len(transfers) < len(expected) - len(words):
                    await ClockCycles(dut.clk, 1)
                dut.rectify.value = 0
                dut.balance.value = int(BalanceMode.OFF)
            if number == 2:
                dut.swap.value = 1
                await ClockCycles(dut.clk, 1)
                dut.swap.value = 0
            await source(dut, "i", words[:1], rng=rng, stall=stall, timeout=200_000)
            if number == 1:
                await load()
            await source(dut, "i", words[1:], rng=rng, stall=stall, timeout=200_000)

    sender = cocotb.start_soon(send())
    received = await sink(dut, "o", len(expected), rng=random.Random(2), stall=stall, timeout=200_000)
    await sender
    assert received == transfers
    for at, (word, wanted) in enumerate(zip(received, expected)):
        assert comparable(word, PixelPair()) == wanted, f"word {at}"
    assert await drain(dut, "o") == []
    assert (int(dut.fault.value), int(dut.abandoned.value), int(dut.swapping.value)) == (0, 0, 0)
    assert np.ptp([word["right"] for word in expected]) > 100

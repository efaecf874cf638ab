"""The cocotb half of ``test_video_setup.py``: the whole set-up of both chips, with chips that stretch the clock as far as they may."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer, ValueChange, with_timeout

from golden.video.setup_steps import TFP410, TVP5154, Failure, Write
from sim.benches.video_setup import CLOCK_HZ
from sim.models.i2c import I2cBus, cocotb_bus
from sim.models.i2c_chips import Fault
from sim.models.video_chips import Tfp410, Tvp5154


async def start(dut):
    """Clock, reset, both buses with their chips."""
    chips = {
        "decoder": (TVP5154, Tvp5154(seed=1, stretch=0.1)),
        "transmitter": (TFP410, Tfp410(seed=2, stretch=0.1)),
    }
    for name in chips:
        getattr(dut, f"{name}_restart").value = 0
        for line in ("scl_i", "sda_i"):
            getattr(dut, f"{name}_{line}").value = 1
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, 10**9 // CLOCK_HZ, "ns").start())
    await ClockCycles(dut.clk, 3)
    buses = {name: I2cBus(model, rise_ns=300) for name, (_, model) in chips.items()}
    for name, (chip, _) in chips.items():
        cocotb.start_soon(cocotb_bus(buses[name], dut, prefix=f"{name}_", pins=chip.pins))
    dut.rst.value = 0
    return [model for _, model in chips.values()], list(buses.values())


async def until(handle, value=1, milliseconds=200):
    """Wait for a level, and for the changes in the same clock."""
    async def wait():
        while handle.value != value:
            await ValueChange(handle)
    await with_timeout(wait(), milliseconds, "ms")
    await Timer(1, "ps")                    # what else changes at this edge has changed


def status(dut, name):
    step, reason, failures = (getattr(dut, f"{name}_{member}").value.to_unsigned() for member in ("step", "reason", "failures"))
    return step, Failure(reason), failures


@cocotb.test()
async def both_are_set_up(dut):
    """All values of the tables, in their order, within the rules of bus and chips; then lock."""
    (decoder, transmitter), buses = await start(dut)
    await until(dut.transmitter_done)
    await until(dut.decoder_done)
    assert transmitter.is_set_up()
    assert [decoder.is_set_up(number) for number in range(4)] == [True, True, False, False]
    for chip, model in ((TVP5154, decoder), (TFP410, transmitter)):
        wanted = [(step.register, step.value) for step in chip.setup if isinstance(step, Write)]
        assert model.writes[:len(wanted)] == wanted
    assert all(bus.starts > 2 for bus in buses)
    decoder.decoders[1].lock = 0x06
    await until(dut.decoder_locked, 2)
    decoder.decoders[0].lock = 0x06
    await until(dut.decoder_locked, 3)
    for name in ("decoder", "transmitter"):
        assert status(dut, name) == (0, Failure.NONE, 0)


@cocotb.test()
async def failures_are_told_and_got_over(dut):
    """Nobody answers; SDA is held low from the start; a chip forgets its settings; and all is set up again."""
    (_, transmitter), (_, bus) = await start(dut)
    bus.broken_allowed = True
    transmitter.faults = [Fault("no acknowledge", None)]
    await until(dut.transmitter_failed)
    assert status(dut, "transmitter") == (2, Failure.NO_ACKNOWLEDGE, 4)
    transmitter.faults = []
    transmitter.holding, transmitter.sda_low = 5, True
    dut.transmitter_restart.value = 1
    await RisingEdge(dut.clk)
    dut.transmitter_restart.value = 0
    await until(dut.transmitter_done)
    assert transmitter.is_set_up()
    assert status(dut, "transmitter") == (0, Failure.NONE, 4)
    transmitter.reset()
    await until(dut.transmitter_done, 0)
    assert status(dut, "transmitter") == (5, Failure.NOT_READY, 5)
    await until(dut.transmitter_done)
    assert transmitter.is_set_up()

"""The cocotb half of ``test_interfaces.py`` for any bus: what does not depend on it."""

import os
from importlib import import_module

import cocotb

from sim.benches.bus_cases import CASES
from sim.benches.bus_runs import late_settings, new_settings, pictures


CASE = CASES[os.environ["CASE"]]
SETTINGS = {name: CASE.registers[name] for name in CASE.config.settings}
start = import_module(f"sim.benches.{os.environ['BUS']}_tb").start


@cocotb.test(timeout_time=200, timeout_unit="us")
async def frames(dut):
    """With stalls; then of another size, with other settings."""
    host = await start(dut, 0.3)
    await pictures(host, CASE.pairs(2), {})
    settings = {name: register.maximum for name, register in SETTINGS.items()}
    await host.set(width=7, height=4, **settings)
    await host.applied()
    await pictures(host, CASE.pairs(2, 7, 4), settings)


@cocotb.test(timeout_time=200, timeout_unit="us")
async def full_rate(dut):
    await pictures(await start(dut), CASE.pairs(2), {})


@cocotb.test(timeout_time=200, timeout_unit="us")
async def settings_within_a_frame(dut):
    await new_settings(await start(dut, 0.2), {name: register.minimum for name, register in SETTINGS.items()})


@cocotb.test(timeout_time=200, timeout_unit="us")
async def settings_before_the_output(dut):
    await late_settings(await start(dut), {name: register.minimum for name, register in SETTINGS.items()})

"""The cocotb half of ``test_uart.py``: requests over the line, at rates that differ, and after noise."""

import os
import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge

from golden.host.protocol import FRAME_BYTES, Operation, Reply, Request, Status, decode_reply, encode_request
from golden.host.registers import register_map
from hdl.host.register_file import SettingLayout, StatusLayout
from sim.kit.payloads import pack
from sim.models.uart import UartHost


BIT_CYCLES = int(os.environ["BIT_CYCLES"])
FRAME_BITS = int(os.environ["FRAME_BITS"])
REGISTERS = register_map()
STATUS = StatusLayout(REGISTERS, ["uart_errors", "pair_whole"])


async def start(dut, **options):
    """Clock, reset, and a host on the line, which is returned."""
    host = UartHost(BIT_CYCLES, **options)
    dut.rx.value = 1
    dut.status.value = 0
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0
    await RisingEdge(dut.clk)

    async def drive():
        while True:
            assert dut.tx.value.is_resolvable
            dut.rx.value = host.step(int(dut.tx.value))
            await RisingEdge(dut.clk)

    cocotb.start_soon(drive())
    return host


async def ask(dut, host, request):
    """The reply to a request, without extra bytes."""
    host.send(encode_request(request))
    await ClockCycles(dut.clk, (2 * 10 * FRAME_BYTES + 10) * BIT_CYCLES)
    reply = decode_reply(bytes(host.received))
    host.received.clear()
    return reply


@cocotb.test()
@cocotb.parametrize(mismatch=[-0.03, 0.0, 0.03])
async def registers(dut, mismatch):
    host = await start(dut, mismatch=mismatch)
    status = {register: random.Random(register).getrandbits(REGISTERS[register].width) for register in STATUS.members}
    dut.status.value = pack(STATUS, status)
    for name in ("left_camera_fill", "decoder_step", "pairs"):
        assert await ask(dut, host, Request(Operation.READ, REGISTERS[name].address)) == Reply(
            Status.OK, REGISTERS[name].address, status[name])
    settings = {name: REGISTERS[name].reset for name in SettingLayout(REGISTERS).members}
    for name, value in (("u1", 63), ("in_use", 1), ("show", 2)):
        settings[name] = value
        assert await ask(dut, host, Request(Operation.WRITE, REGISTERS[name].address, value)) == Reply(
            Status.OK, REGISTERS[name].address, value)
        assert int(dut.settings.value) == pack(SettingLayout(REGISTERS), settings)
    assert (await ask(dut, host, Request(Operation.WRITE, REGISTERS["show"].address, 3))).status is Status.OUT_OF_RANGE
    assert int(dut.settings.value) == pack(SettingLayout(REGISTERS), settings)
    assert host.framing_errors == 0


@cocotb.test()
async def after_noise(dut):
    """Answered once the line has been silent for the time-out and a reply to the noise; noise is counted."""
    rng = random.Random(1)
    host = await start(dut, rng=rng)
    counted = 0
    for _ in range(6):
        host.send(rng.choices([0xA5, rng.randrange(256)], k=rng.randrange(1, 9)))
        host.send_noise(20)
        host.send_level(1, FRAME_BITS + 10 * FRAME_BYTES + 1)
        while not host.idle:
            await ClockCycles(dut.clk, BIT_CYCLES)
        host.received.clear()
        reply = await ask(dut, host, Request(Operation.READ, REGISTERS["uart_errors"].address))
        assert reply.status is Status.OK and reply.value > counted
        counted = reply.value

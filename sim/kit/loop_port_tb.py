"""The cocotb half of :mod:`sim.kit.loop_port`: the pins of a simulated board's serial line at one end, a pseudo-terminal at the other."""

import json
import os
import select
import tty
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge, Timer

from sim.models.cocotb_sdram import serve_sdram_ports
from sim.models.sdram import SdramMemory


CLOCK_NS = 10
BIT_NS = CLOCK_NS * int(os.environ.get("BIT_CYCLES", "0"))
FOLDER = Path(os.environ.get("LOOP_FOLDER", "."))

# Clocks that pass in a millisecond in which nothing is on the line: so the host's time-outs and the board's fit together.
IDLE_CLOCKS = int(os.environ.get("IDLE_CLOCKS", "1"))


class Line:
    """What happens to the bytes of a direction: after ``after`` bytes each ``every``-th one is ``lost``, ``doubled`` or ``changed``."""
    def __init__(self, kind="", every=1, after=1 << 30):
        self.becomes = {"lost": lambda byte: [], "doubled": lambda byte: [byte, byte], "changed": lambda byte: [byte ^ 0x10]}.get(kind)
        self.every, self.after = every, after
        self.count = 0

    def pass_on(self, data):
        result = bytearray()
        for byte in data:
            self.count += 1
            at = self.count - self.after
            result.extend(self.becomes(byte) if self.becomes and at > 0 and at % self.every == 0 else [byte])
        return bytes(result)


@cocotb.test()
async def port(dut):
    faults = json.loads(os.environ["LOOP_FAULTS"])
    to_board, to_host = (Line(**faults.get(direction, {})) for direction in ("to_board", "to_host"))
    dut.uart_rx.value = 1
    dut.rst.value = 1
    cocotb.start_soon(Clock(dut.clk, CLOCK_NS, "ns", impl="gpi").start())
    if clock_hz := int(os.environ["SDRAM_HZ"]):
        cocotb.start_soon(serve_sdram_ports(dut, SdramMemory(clock_hz)))
    await ClockCycles(dut.clk, 4)
    dut.rst.value = int(faults.get("dead", False))
    master, slave = os.openpty()
    tty.setraw(slave)
    (FOLDER / "port.tmp").write_text(os.ttyname(slave))
    (FOLDER / "port.tmp").rename(FOLDER / "port")
    busy = 0

    async def listen():
        nonlocal busy
        while True:
            await FallingEdge(dut.uart_tx)
            busy += 1
            await Timer(BIT_NS // 2, "ns")
            byte = 0
            for place in range(8):
                await Timer(BIT_NS, "ns")
                byte |= int(dut.uart_tx.value) << place
            await Timer(BIT_NS, "ns")
            assert int(dut.uart_tx.value) == 1
            os.write(master, to_host.pass_on([byte]))
            busy -= 1

    async def send(data):
        for byte in data:
            for level in (0, *(byte >> place & 1 for place in range(8)), 1):
                dut.uart_rx.value = level
                await Timer(BIT_NS, "ns")

    cocotb.start_soon(listen())
    received = 0
    while not (FOLDER / "stop").exists():
        if select.select([master], [], [], 0 if busy else 1e-3)[0]:
            data = os.read(master, 256)
            received += len(data)
            if received > faults.get("unplugged", 1 << 30):
                break
            await send(to_board.pass_on(data))
        else:
            await ClockCycles(dut.clk, IDLE_CLOCKS)
    os.close(master)
    os.close(slave)

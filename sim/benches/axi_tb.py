"""The cocotb half of ``test_interfaces.py`` for AXI: masters, source and sink are those of cocotbext-axi."""

import os
from collections.abc import Sequence

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiStreamBus, AxiStreamFrame, AxiStreamSink, AxiStreamSource

from golden.host.core_registers import WORD_BYTES
from golden.video.frame_rule import Closes, Fault, ReceivedWord
from sim.benches.bus_cases import CASES, pauses, pixel_words
from sim.benches.bus_runs import Host, accesses, contradictions


CASE = CASES[os.environ["CASE"]]


class AxiHost(Host):
    """Lines are packets, ``tuser`` is a flag of each pixel."""
    closes = Closes.LINE

    def __init__(self, dut, stall):
        super().__init__(CASE)
        self.clock = dut.aclk
        reset = {"clock": dut.aclk, "reset": dut.aresetn, "reset_active_level": False}
        self.source = AxiStreamSource(AxiStreamBus.from_prefix(dut, "s_axis"), **reset, byte_size=16)
        self.sink = AxiStreamSink(AxiStreamBus.from_prefix(dut, "m_axis"), **reset, byte_size=len(dut.m_axis_tdata))
        self.master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axi"), **reset)
        write, read = self.master.write_if, self.master.read_if
        for seed, channel in enumerate((self.source, self.sink, write.aw_channel, write.w_channel, write.b_channel,
                                        read.ar_channel, read.r_channel)):
            channel.log.setLevel("WARNING")
            if stall:
                channel.set_pause_generator(pauses(seed, stall))
        for interface in (write, read):
            interface.log.setLevel("WARNING")

    async def read(self, address):
        answer = await self.master.read(WORD_BYTES * address, WORD_BYTES)
        return answer.resp, int.from_bytes(answer.data, "little")

    async def write(self, address, data, strobes=15):
        write = self.master.write_if
        if strobes in (0b1, 0b10, 0b100, 0b1000, 0b11, 0b110, 0b1100, 0b111, 0b1110, 0b1111):
            # Consecutive bytes: the kit sets the strobes from the address and the length.
            low, count = (strobes & -strobes).bit_length() - 1, strobes.bit_count()
            piece = (data >> 8 * low & (1 << 8 * count) - 1).to_bytes(count, "little")
            return (await self.master.write(WORD_BYTES * address + low, piece)).resp
        await write.aw_channel.send(write.aw_channel._transaction_obj(awaddr=WORD_BYTES * address, awprot=0))
        await write.w_channel.send(write.w_channel._transaction_obj(wdata=data, wstrb=strobes))
        return int((await write.b_channel.recv()).bresp)

    async def send(self, words: Sequence[ReceivedWord]):
        assert words[-1].closes     # the kit's packets do
        begin = 0
        for end, word in enumerate(words, 1):
            if word.closes:
                line, begin = words[begin:end], end
                await self.source.send(AxiStreamFrame([pixel.left | pixel.right << 8 for pixel in line],
                                                      tuser=[int(pixel.first) for pixel in line]))
        await self.source.wait()

    async def frame(self, width, height):
        lines = []
        for y in range(height):
            line = await self.sink.recv(compact=False)
            assert line.tuser == [int(y == x == 0) for x in range(width)]
            lines.append(list(line.tdata))
        return lines

    def nothing_left(self):
        return self.sink.empty() and not self.sink.active


async def start(dut, stall=0.0):
    """Clock, reset, and the host, which starts in the reset."""
    for signal in (dut.aresetn, dut.s_axi_awvalid, dut.s_axi_wvalid, dut.s_axi_bready, dut.s_axi_arvalid, dut.s_axi_rready,
                   dut.s_axis_tvalid, dut.m_axis_tready):
        signal.value = 0
    cocotb.start_soon(Clock(dut.aclk, 10, "ns", impl="gpi").start())
    await ClockCycles(dut.aclk, 3)
    host = AxiHost(dut, stall)
    await ClockCycles(dut.aclk, 2)
    dut.aresetn.value = 1
    await ClockCycles(dut.aclk, 2)
    host.watch(dut.s_axis_tvalid, dut.s_axis_tready)
    return host


@cocotb.test(timeout_time=200, timeout_unit="us")
async def registers(dut):
    """One access after the other; then several reads in flight at a time, which the kit makes of a long one."""
    host = await start(dut, 0.3)
    await accesses(host, 60)
    settings = [register.address for register in host.registers if register.name in ("u1", "u2", "u3")]
    for value, address in enumerate(settings, 5):
        await host.write(address, value)
    data = await host.master.read(WORD_BYTES * settings[0], WORD_BYTES * len(settings))
    assert data.data == b"".join(value.to_bytes(WORD_BYTES, "little") for value in (5, 6, 7))


@cocotb.test(timeout_time=200, timeout_unit="us")
async def channels(dut):
    """Reads while the response to a write is not accepted, writes while that to a read is not; data before its address, and after it."""
    host = await start(dut)
    write, read = host.master.write_if, host.master.read_if
    for waiting, name, other in ((write.b_channel, "width", host.get), (read.r_channel, "height", lambda _: host.set(u1=3))):
        waiting.pause = True
        task = cocotb.start_soon(host.set(width=5) if waiting is write.b_channel else host.get(name))
        await ClockCycles(dut.aclk, 30)
        for _ in range(3):
            await other(name)
        assert not task.done()
        waiting.pause = False
        await task
    for late in (write.aw_channel, write.w_channel):
        late.pause = True
        task = cocotb.start_soon(host.set(width=6))
        await ClockCycles(dut.aclk, 30)
        assert await host.get("width") == 5
        late.pause = False
        await task
        assert await host.get("width") == 6
        await host.set(width=5)


@cocotb.test(timeout_time=200, timeout_unit="us")
async def wrong_size(dut):
    """Every kind of fault that a source can make."""
    host = await start(dut, 0.1)
    size = CASE.config.max_width, CASE.height
    words, = (pixel_words(*pair, host.closes) for pair in CASE.pairs(1, seed=30))
    width = size[0]
    at = 2 * width + 3
    await contradictions(host, [
        (words[:at] + words[at + 1:], Fault.EARLY_END),
        (words[:at] + words[at - 1:], Fault.LATE_END),
        (words[:2] + words[3:], Fault.EARLY_END),
        (words[:-width], Fault.EARLY_START),
        (words[:at], Fault.EARLY_START),
        (words + words[-width:], Fault.LATE_START),
    ], size)

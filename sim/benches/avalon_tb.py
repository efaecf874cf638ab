"""The cocotb half of ``test_interfaces.py`` for Avalon: host, source and sink are those of cocotbext-avalon."""

import os
from collections.abc import Sequence

import cocotb
from cocotb.clock import Clock
from cocotb.queue import Queue
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.avalon import AvalonFormat, AvalonMMMasterBFM, AvalonSTBus, AvalonSTFrame, AvalonSTSink, AvalonSTSource

from golden.video.frame_rule import Closes, Fault, ReceivedWord
from sim.benches.bus_cases import CASES, pauses, pixel_words
from sim.benches.bus_runs import Host, accesses, contradictions


CASE = CASES[os.environ["CASE"]]


class AvalonHost(Host):
    """Frames are packets. The kit's host does not read responses: they are collected beside it."""
    closes = Closes.FRAME

    def __init__(self, dut, stall):
        super().__init__(CASE)
        self.clock = dut.clk
        self.source = AvalonSTSource(AvalonSTBus.from_prefix(dut, "asi"), AvalonFormat(16), dut.clk, dut.reset)
        self.sink = AvalonSTSink(AvalonSTBus.from_prefix(dut, "aso"), AvalonFormat(len(dut.aso_data)), dut.clk, dut.reset)
        self.master = AvalonMMMasterBFM.from_prefix(dut, "avs", dut.clk, dut.reset)
        self.master.start()
        self.responses: Queue = Queue()
        cocotb.start_soon(self.collect(dut))
        for seed, stream in enumerate((self.source, self.sink)):
            stream.log.setLevel("WARNING")
            if stall:
                stream.set_pause_generator(pauses(seed, stall))

    async def collect(self, dut):
        """The response of each access, whether it is a read, and that it is one of both."""
        while True:
            await RisingEdge(dut.clk)
            if dut.avs_readdatavalid.value or dut.avs_writeresponsevalid.value:
                assert dut.avs_readdatavalid.value != dut.avs_writeresponsevalid.value
                self.responses.put_nowait((int(dut.avs_response.value), bool(dut.avs_readdatavalid.value)))

    async def read(self, address):
        value = await self.master.read(address, timeout_cycles=100)
        response, reading = await self.responses.get()
        assert reading and self.responses.empty()
        return response, value

    async def write(self, address, data, strobes=15):
        await self.master.write(address, data, strobes, timeout_cycles=100)
        response, reading = await self.responses.get()
        assert not reading and self.responses.empty()
        return response

    async def send(self, words: Sequence[ReceivedWord]):
        assert words[0].first and words[-1].closes  # the kit's packets do
        begin = 0
        for end, word in enumerate(words, 1):
            if word.closes:
                await self.source.send(AvalonSTFrame([pixel.left | pixel.right << 8 for pixel in words[begin:end]]))
                begin = end
        await self.source.wait()

    async def frame(self, width, height):
        packet = list(await self.sink.recv())
        assert len(packet) == width * height
        return [packet[y * width:(y + 1) * width] for y in range(height)]

    def nothing_left(self):
        return self.sink.empty() and not self.sink.active


async def start(dut, stall=0.0):
    """Clock, reset, and the host, which starts in the reset."""
    for name in ("avs_read", "avs_write", "asi_valid", "aso_ready"):
        getattr(dut, name).value = 0
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clk, 10, "ns", impl="gpi").start())
    await ClockCycles(dut.clk, 3)
    host = AvalonHost(dut, stall)
    await ClockCycles(dut.clk, 2)
    dut.reset.value = 0
    await ClockCycles(dut.clk, 2)
    host.watch(dut.asi_valid, dut.asi_ready)
    return host


@cocotb.test(timeout_time=200, timeout_unit="us")
async def registers(dut):
    await accesses(await start(dut), 60)


@cocotb.test(timeout_time=200, timeout_unit="us")
async def wrong_size(dut):
    """Packets that are too short, by a pixel, by lines, to less than a line, and too long."""
    host = await start(dut, 0.1)
    size = CASE.config.max_width, CASE.height
    words, = (pixel_words(*pair, host.closes) for pair in CASE.pairs(1, seed=30))

    def cut(length):
        return [*words[:length - 1], words[-1]]

    await contradictions(host, [
        (cut(len(words) - 1), Fault.EARLY_END),
        (cut(2 * size[0]), Fault.EARLY_END),
        (cut(3), Fault.EARLY_END),
        ([*words[:-1], words[3], words[-1]], Fault.LATE_END),
    ], size)

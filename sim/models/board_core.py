"""Stand-in for the video system: registers between the ports of :class:`hdl.video.ports.SystemPorts`, so that a bench can trace each."""

from functools import cache

from amaranth import *
from amaranth.lib import wiring

from boards.cyclone3.project import quartus_project
from boards.registry import Project
from golden.config import MatcherConfig
from golden.video.bandwidth import Budget, MemoryTiming
from golden.video.formats import DISPLAYS
from hdl.matcher.matcher import Matcher
from hdl.parts.queue import AsyncQueue
from hdl.video.ports import SystemPorts


__all__ = ["BoardCore", "board_project"]


class BoardCore(wiring.Component):
    """Connects inputs to outputs that a bench can observe.

    - left camera -> FIFO -> ``sync`` -> write data and address of the memory bus; right camera -> FIFO -> the other half of the data;
    - read data ``[23:0]`` -> FIFO -> red, green, blue in ``display``; ``[26:24]`` -> de, hsync, vsync;
    - each I2C line is driven low while a button is pressed: 0, 1 the decoder's SCL, SDA; 2, 3 the transmitter's;
    - LEDs 0..3 show the levels of those lines, 4 ``uart_rx``, 5 ``rdata_valid``, 6 ``ready``, 7 ``init_done``;
    - ``uart_tx`` is ``uart_rx``; the decoder's reset ends 1 cycle after that of ``sync``, its power-down 2 cycles after.
    """
    def __init__(self, config: MatcherConfig, timing: MemoryTiming | None = None):
        self.matcher = Matcher(config)
        self.budget = Budget(timing=timing or MemoryTiming())
        super().__init__(SystemPorts())

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.matcher = self.matcher
        memory = self.memory
        for number, (domain, data) in enumerate((("left_camera", self.left_data), ("right_camera", self.right_data))):
            m.submodules[f"{domain}_queue"] = queue = AsyncQueue(8, 8, i_domain=domain)
            m.d.comb += [queue.i.p.eq(data), queue.i.valid.eq(1), queue.o.ready.eq(1)]
            with m.If(queue.o.valid):
                m.d.sync += memory.wdata[64 * number:64 * number + 8].eq(queue.o.p)
                if number == 0:
                    m.d.sync += memory.address.eq(queue.o.p)
        m.d.comb += [memory.write_req.eq(self.buttons[0]), memory.read_req.eq(self.buttons[1]), memory.burstbegin.eq(self.buttons[2]),
                     memory.be.eq(Mux(self.buttons[3], 0xA5F0, 0)), memory.size.eq(1)]

        m.submodules.display_queue = queue = AsyncQueue(27, 8, o_domain="display")
        m.d.comb += [queue.i.p.eq(memory.rdata), queue.i.valid.eq(memory.rdata_valid), queue.o.ready.eq(1)]
        with m.If(queue.o.valid):
            m.d.display += Cat(self.red, self.green, self.blue, self.de, self.hsync, self.vsync).eq(queue.o.p)

        pulls = Cat(self.decoder_scl_low, self.decoder_sda_low, self.dvi_scl_low, self.dvi_sda_low)
        lines = Cat(self.decoder_scl, self.decoder_sda, self.dvi_scl, self.dvi_sda)
        m.d.sync += [
            pulls.eq(self.buttons),
            self.leds.eq(Cat(lines, self.uart_rx, memory.rdata_valid, memory.ready, memory.init_done)),
            self.uart_tx.eq(self.uart_rx),
            self.decoder_reset_n.eq(1), self.decoder_powerdown_n.eq(self.decoder_reset_n),
        ]
        return m


@cache
def board_project(display: str, local_clock_hz: int = 75_000_000) -> Project:
    """The board's project with the stand-in on it; ``display`` by its name, the clock of the memory controller's local interface."""
    config = MatcherConfig(labels=4, max_width=8)
    return quartus_project(BoardCore(config, MemoryTiming.at(local_clock_hz)), DISPLAYS[display], config)

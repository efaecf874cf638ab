"""Stand-ins for the system behind a serial line: few registers between its ports, so that a board's top level can be tried alone."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from boards.loop.system import LoopBoard
from boards.registry import Design, Project, find_board
from golden.config import MatcherConfig
from golden.video.formats import VGA, DisplayFormat
from golden.video.sdram import SDRAM
from golden.video.side_by_side import side_by_side
from hdl.loop.sdram import SdramController, SdramPins


__all__ = ["LoopDouble", "MemoryDouble", "double_picture", "double_project", "memory_project"]


# What the projects are made for.
_CONFIG = MatcherConfig(labels=4, max_width=9)
_HEIGHT = 6


def _pictures(config: MatcherConfig, height: int) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Left picture, labels, and where they are known, that the stand-in shows: noise that is the same each time."""
    rng, shape = np.random.default_rng(1), (height, config.max_width)
    return rng.integers(0, 256, shape), rng.integers(0, config.labels, shape), rng.random(shape) < 0.8


def double_picture(display: DisplayFormat) -> NDArray[Any]:
    """What a monitor shows at the board of :func:`double_project`."""
    return side_by_side(*_pictures(_CONFIG, _HEIGHT), display, _CONFIG.labels)


class LoopDouble(wiring.Component):
    """Sends back each bit of the line a clock later; the LEDs count its changes; shows noise.

    Members as of :class:`hdl.loop.system.LoopSystem` with :class:`hdl.loop.store.BlockStores`.
    """
    def __init__(self, config: MatcherConfig, height: int, display: bool):
        self.config, self.width, self.height, self.display = config, config.max_width, height, display
        self.stores = SimpleNamespace(about="a stand-in")
        super().__init__({
            "uart_rx": In(1, init=1), "uart_tx": Out(1, init=1), "leds": Out(8),
            **({"display_address": In(range(self.width * height)), "display_left": Out(8), "display_label": Out(range(config.labels)),
                "display_known": Out(1)} if display else {}),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        with m.If(self.uart_rx != self.uart_tx):
            m.d.sync += self.leds.eq(self.leds + 1)
        m.d.sync += self.uart_tx.eq(self.uart_rx)
        if self.display:
            words = [int(grey) | int(label) << 8 | int(known) << 16 for grey, label, known in zip(
                *(picture.flat for picture in _pictures(self.config, self.height)))]
            m.submodules.store = store = Memory(shape=17, depth=len(words), init=words)
            read = store.read_port(domain="pixel")
            m.d.comb += [read.addr.eq(self.display_address), self.display_left.eq(read.data[:8]),
                         self.display_label.eq(read.data[8:16]), self.display_known.eq(read.data[16])]
        return m


class MemoryDouble(wiring.Component):
    """Writes :attr:`WORDS` words into several rows and banks of a board's SDRAM, and reads them back once; the LEDs count those that are as
    they were. Members as of :class:`hdl.loop.system.LoopSystem` with :class:`hdl.loop.sdram_store.SdramStores`.
    """
    WORDS = 64
    #: Of the pause after power-up, which is shorter than the memory's.
    POWER_UP = 30

    def __init__(self, config: MatcherConfig, height: int, clock_hz: int):
        self.config, self.width, self.height = config, config.max_width, height
        self.stores = SimpleNamespace(about="a stand-in")
        self.controller = SdramController(replace(SDRAM.clocks(clock_hz), power_up=self.POWER_UP + 1), 1)
        super().__init__({"uart_rx": In(1, init=1), "uart_tx": Out(1, init=1), "leds": Out(8), "memory": Out(SdramPins())})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.controller = controller = self.controller
        wiring.connect(m, controller.memory, wiring.flipped(self.memory))
        number, returned = Signal(range(2 * self.WORDS + 1)), Signal(range(self.WORDS))
        place, access = number[:-2], controller.i.p

        def word(of: Value) -> Value:
            return Cat(of, Const(0, 8 - len(of)), ~of)

        m.d.comb += [
            controller.i.valid.eq(~number[-1]), access.write.eq(~number[-2]), access.bytes.eq(-1), access.data.eq(word(place)),
            # A row has four words, and each half of the memory eight rows.
            access.address.eq(Cat(place[:2], Const(0, 7), place[2:5], Const(0, 11), place[5])),
        ]
        with m.If(controller.i.valid & controller.i.ready):
            m.d.sync += number.eq(number + 1)
        with m.If(controller.valid):
            m.d.sync += [returned.eq(returned + 1), self.leds.eq(self.leds + (controller.found == word(returned)))]
        return m


@cache
def memory_project(board: str, clock_hz: int) -> Project:
    """The project of a board with :class:`MemoryDouble` on it, whose monitor is black."""
    core = MemoryDouble(_CONFIG, _HEIGHT, clock_hz)
    return find_board(board).project(LoopBoard(core, None), Design(_CONFIG, _HEIGHT, clock_hz, VGA, None, 3_000_000))


@cache
def double_project(board: str, display: DisplayFormat | None = VGA) -> Project:
    """The project of a board with the stand-in on it."""
    core = LoopDouble(_CONFIG, _HEIGHT, display is not None)
    return find_board(board).project(LoopBoard(core, None), Design(_CONFIG, _HEIGHT, 75_000_000, display, None, 3_000_000))

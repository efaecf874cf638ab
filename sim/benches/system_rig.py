"""All that is around the video system on its board, for cocotb benches on its Verilog: cameras, memory, chips, host, monitor."""

import os
from collections import deque
from typing import ClassVar

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, Timer

from golden.host.protocol import BAUD, FRAME_BYTES, FRAME_SECONDS, Operation, Request, Status, encode_request, first_reply
from golden.host.registers import register_map
from golden.matcher.matcher import disparities
from golden.pictures.scenes import scene
from golden.video.bt656 import BLANK_CHROMA, BLANK_LUMA, clip
from golden.video.display import DisplayMode, monitor_picture
from golden.video.setup_steps import TVP5154
from sim.benches.system_sizes import CLOCK_HZ, SETUP_HZ, SIZES, UART_CYCLES
from sim.models.camera import STOPPED, Camera, play_cocotb
from sim.models.cocotb_ddr2 import serve
from sim.models.ddr2 import Ddr2Timing, LocalMemory
from sim.models.i2c import I2cBus, cocotb_bus
from sim.models.monitor import PINS, Monitor, watch_cocotb
from sim.models.uart import UartHost
from sim.models.video_chips import Tfp410, Tvp5154


__all__ = ["NO_CLOCK", "NO_SIGNAL", "SIDES", "Film", "Rig"]


SIDES = ("left", "right")

#: Whole frames of a camera that is not there: blanking without a code, and a clock that stands still.
NO_SIGNAL, NO_CLOCK = "no signal", "no clock"


class Film:
    """What a camera sends, for ever: the picture in front of it, and the faults that wait for the frames to come.

    Attributes
    ----------
    picture : (H, W) uint8 ndarray
    faults : deque of str or None
        Of the next frames; names of :data:`sim.models.camera.FAULTS`, :data:`NO_SIGNAL`, :data:`NO_CLOCK`.
    frames : int
        Frames begun.
    """
    def __init__(self, format, picture, *, seed):
        self.format = format
        self.camera = Camera(format, seed=seed)
        self.picture = picture
        self.faults: deque[str | None] = deque()
        self.frames = 0

    def __iter__(self):
        while True:
            self.frames += 1
            fault = self.faults.popleft() if self.faults else None
            if fault == NO_CLOCK:
                yield from [STOPPED] * self.format.frame_bytes
            elif fault == NO_SIGNAL:
                yield from [BLANK_CHROMA, BLANK_LUMA] * (self.format.frame_bytes // 2)
            else:
                yield from self.camera.frame(self.picture, fault)[0].tolist()


class Rig:
    """The system between its models.

    Parameters
    ----------
    dut
        Handle of the module ``stereo_system``.
    seed : int
        Of the memory's timing, of the cameras' faults and of the pair in front of them.
    timing : Ddr2Timing
    """
    #: Cameras differ from their nominal clock, in parts of a million, and begin apart, in frames.
    DRIFT_PPM: ClassVar = {"left": -120, "right": 90}
    PHASE: ClassVar = {"left": 0.0, "right": 0.3}

    #: Silence after which a request is read from its beginning, in bits of the host's line.
    QUIET_BITS = round(FRAME_SECONDS * BAUD) + 10 * FRAME_BYTES + 10

    def __init__(self, dut, *, seed=1, timing=None):
        size = SIZES[os.environ["SYSTEM_SIZE"]]
        self.dut = dut
        self.config, self.camera, self.display = size.config, size.camera, size.display
        self.seed = seed
        self.pair = self._scene()
        self.films = {side: Film(self.camera, picture, seed=seed + n) for n, (side, picture) in enumerate(zip(SIDES, self.pair))}
        self.memory = LocalMemory(timing=timing or Ddr2Timing(), seed=seed)
        self.monitor = Monitor(self.display, keep=64)
        self.decoder = Tvp5154(seed=seed, stretch=0.05)
        self.transmitter = Tfp410(seed=seed, stretch=0.05)
        self.transmitter.set_pins(0, {"isel": 0})       # as the board does in its reset
        for decoder in self.decoder.decoders[:2]:
            decoder.lock = Tvp5154.LOCKED
        self.registers = register_map(self.config, self.camera.height)
        self.host = UartHost(UART_CYCLES)
        self.settings = {"mode": DisplayMode.DISPARITY, "colour": False}
        self.states = [(self.pair, self.settings)]      # what was in front of the cameras, and set, since the last check
        self.cut = 0                                    # pictures that broke off

    def _scene(self):
        self.seed += 1
        return tuple(map(clip, scene(self.camera.width, self.camera.height, self.config.labels, self.seed)[:2]))

    async def start(self):
        """Clocks, models, then the resets end as on the board: ``sync``, ``display``, cameras."""
        dut = self.dut
        resets = [dut.rst, dut.display_rst, dut.left_camera_rst, dut.right_camera_rst]
        for reset in resets:
            reset.value = 1
        dut.uart_rx.value = 1
        dut.buttons.value = 0
        for port in (dut.decoder_scl, dut.decoder_sda, dut.dvi_scl, dut.dvi_sda):
            port.value = 1
        # Clocks in C++; half a period is a whole number of picoseconds.
        for clock, hertz in ((dut.clk, CLOCK_HZ), (dut.display_clk, self.display.pixel_clock_hz)):
            cocotb.start_soon(Clock(clock, 2 * round(0.5e12 / hertz), "ps", impl="gpi").start())
        for side, film in self.films.items():
            period = 1e12 / self.camera.byte_clock_hz * (1 + 1e-6 * self.DRIFT_PPM[side])
            cocotb.start_soon(play_cocotb(getattr(dut, f"{side}_camera_clk"), getattr(dut, f"{side}_data"), film, period=round(period),
                                          phase=round(self.PHASE[side] * self.camera.frame_bytes * period) + 1))
        cocotb.start_soon(serve(dut, "memory", self.memory))
        await Timer(1, "us")
        cocotb.start_soon(watch_cocotb(self.monitor, dut.display_clk, {name: getattr(dut, name) for name in PINS}))
        scale = CLOCK_HZ / SETUP_HZ
        for bus, chip, pins, ports, levels in (
                ("decoder", self.decoder, TVP5154.pins, {"resetb": "decoder_reset_n", "pdn": "decoder_powerdown_n"}, {}),
                ("dvi", self.transmitter, (), {}, {"isel": 1})):
            lines = {f"{line}_{end}": f"{bus}_{line}{port}" for line in ("scl", "sda") for end, port in (("low", "_low"), ("i", ""))}
            model = I2cBus(chip)
            model.broken_allowed = True     # chips that do not answer are among the faults
            cocotb.start_soon(cocotb_bus(model, dut, pins=pins, ports=ports | lines, levels=levels, scale=scale))
        for reset in resets:
            await Timer(100, "ns")
            reset.value = 0

    # The host.

    async def exchange(self):
        """Let the line move for a clock."""
        self.dut.uart_rx.value = self.host.step(int(self.dut.uart_tx.value))
        await RisingEdge(self.dut.clk)

    async def ask(self, operation, name, value=0):
        """The value in the reply to a request; the chip must accept it."""
        self.host.received.clear()
        self.host.send(encode_request(Request(operation, self.registers[name].address, value)))
        for _ in range(400 * UART_CYCLES):
            await self.exchange()
            if (reply := first_reply(bytes(self.host.received))) and self.host.idle:
                assert (reply.status, reply.address) == (Status.OK, self.registers[name].address), f"{name}: {reply}"
                for _ in range(UART_CYCLES):
                    await self.exchange()
                return reply.value
        raise TimeoutError(f"no reply about {name}")

    async def read(self, name):
        return await self.ask(Operation.READ, name)

    async def until_reads(self, name, value, attempts=60):
        """Read a register until it has this value."""
        for _ in range(attempts):
            if await self.read(name) == value:
                return
        raise AssertionError(f"{name} does not become {value}")

    async def write(self, name, value):
        assert await self.ask(Operation.WRITE, name, value) == value

    # The monitor.

    def golden(self, pair, settings):
        """What the monitor must show of a pair."""
        config = self.config.with_settings(settings)
        left, right = pair
        # Labels: disparities without their fraction, from the least one on.
        labels = np.floor(disparities(left, right, config)).astype(int) - config.minimum
        return monitor_picture(labels, left, self.display, settings["mode"], settings["colour"], self.config.labels)

    def change(self, *, scene=True, **settings):
        """Put another pair in front of the cameras, from their next frames on, and note what is set."""
        if scene:
            self.pair = self._scene()
            for film, picture in zip(self.films.values(), self.pair):
                film.picture = picture
        self.settings = {**self.settings, **settings}
        self.states.append((self.pair, self.settings))

    def check(self):
        """Every picture since the last call is one of those that there may be, or the beginning of one and then black.

        What there may be: left and right of any two of the pairs that were in front of the cameras, with the settings of either time.
        """
        may_be = [self.golden((left, right), settings) for (left, _), _ in self.states for (_, right), _ in self.states
                  for _, settings in self.states] if self.monitor.pictures else []
        while self.monitor.pictures:
            picture = self.monitor.pictures.popleft()
            wrong = [(picture != expected).any(axis=-1).ravel() for expected in may_be]
            if all(each.any() for each in wrong):
                self.cut += 1
                black = ~picture.any(axis=-1).ravel()
                assert any(black[each.argmax():].all() for each in wrong), "the monitor shows what no camera has sent"
        del self.states[:-1]

    async def shows(self, frames=12):
        """Wait until the monitor shows the pair in front of the cameras as is set, exactly, for two frames."""
        expected = self.golden(self.pair, self.settings)
        seen = 0
        for _ in range(frames):
            await self.frame()
            seen = seen + 1 if np.array_equal(self.monitor.pictures[-1], expected) else 0
            if seen == 2:
                return self.check()
        raise AssertionError(f"the monitor has not shown the pair in {frames} frames")

    async def frame(self):
        """Wait for the end of a frame at the monitor."""
        before = self.monitor.frames
        while self.monitor.frames == before:
            await Timer(1, "us")

    async def until(self, condition, frames=20):
        """Wait for a condition, for so many frames of the cameras at most."""
        for _ in range(round(frames * self.camera.frame_seconds * 1e6) + 1):
            if condition():
                return
            await Timer(1, "us")
        raise TimeoutError(f"not in {frames} frames of the cameras")

"""Models around the video system, for cocotb benches on its Verilog: cameras, memory, chips, host, monitor."""

import os
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, Timer
from numpy.typing import NDArray

from golden.host.blocks import line_bytes, stored_line
from golden.host.protocol import (
    BAUD,
    CRC_BYTES,
    FRAME_BYTES,
    FRAME_SECONDS,
    Operation,
    Reply,
    Request,
    Status,
    block_bits,
    decode_block,
    encode_block,
    encode_request,
    first_reply,
)
from golden.host.registers import register_map
from golden.matcher.matcher import disparities
from golden.pictures.scenes import scene
from golden.rig.balance import GAIN_ONE, apply, measure, target
from golden.video.bt656 import BLANK_CHROMA, BLANK_LUMA, clip
from golden.video.display import DisplayMode, monitor_picture
from golden.video.formats import CameraFormat
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

#: Whole frames of a camera that is disconnected: blanking without timing codes, and a stopped clock.
NO_SIGNAL, NO_CLOCK = "no signal", "no clock"


class Film:
    """Bytes of a camera without end: frames of the picture in front of it, with the faults that are queued.

    Attributes
    ----------
    picture : (H, W) uint8 ndarray
    faults : deque of str or None
        Of the next frames: names of :data:`sim.models.camera.FAULTS`, :data:`NO_SIGNAL`, :data:`NO_CLOCK`.
    frames : int
        Number of frames that have begun.
    tape : list or None
        Takes the bytes of each frame that begins, with :data:`STOPPED`, unless it is ``None``.
    """
    def __init__(self, format: CameraFormat, picture: NDArray[Any], *, seed: int):
        self.format = format
        self.camera = Camera(format, seed=seed)
        self.picture = picture
        self.faults: deque[str | None] = deque()
        self.frames = 0
        self.tape: list[NDArray[Any]] | None = None

    def __iter__(self) -> Iterator[int]:
        while True:
            self.frames += 1
            fault = self.faults.popleft() if self.faults else None
            if fault == NO_CLOCK:
                data = np.full(self.format.frame_bytes, STOPPED)
            elif fault == NO_SIGNAL:
                data = np.resize([BLANK_CHROMA, BLANK_LUMA], self.format.frame_bytes)
            else:
                data = self.camera.frame(self.picture, fault)[0]
            if self.tape is not None:
                self.tape.append(data)
            yield from data.tolist()


class Rig:
    """The system, connected to its models.

    Parameters
    ----------
    dut
        Handle of the module ``stereo_system``.
    seed : int
        Of the memory's timing, the cameras' faults and the scenes in front of the cameras.
    timing : Ddr2Timing
    """
    #: Deviation of the cameras' clocks, in parts per million, and the time of their first frames, in frames.
    DRIFT_PPM: ClassVar = {"left": -120, "right": 90}
    PHASE: ClassVar = {"left": 0.0, "right": 0.3}

    #: Longest pause within a request or a block, and the idle time after which the receiver expects the start of a request, in bits of
    #: the host's line.
    TIMEOUT_BITS = round(FRAME_SECONDS * BAUD)
    QUIET_BITS = TIMEOUT_BITS + 10 * FRAME_BYTES + 10

    def __init__(self, dut: Any, *, seed: int = 1, timing: Ddr2Timing | None = None):
        size = SIZES[os.environ["SYSTEM_SIZE"]]
        self.dut = dut
        self.config, self.camera, self.display, self.rig = size.config, size.camera, size.display, size.rig
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
        self.registers = register_map(self.config, self.camera.height, self.rig)
        self.host = UartHost(UART_CYCLES)
        #: With ``maps``, a :class:`Rig` or ``None``, and ``balance``, gain and offset of the right picture.
        self.settings: dict[str, Any] = {"mode": DisplayMode.DISPARITY, "colour": False, "maps": self.rig and self.rig.rig,
                                         "balance": (GAIN_ONE, 0)}
        self.states = [(self.pair, self.settings)]      # scenes and settings since the last check
        self.cut = 0                                    # pictures that end early
        self._resets = [getattr(dut, name) for name in ("rst", "display_rst", "left_camera_rst", "right_camera_rst")]
        self._buses: list[I2cBus] = []
        self._watch: Any = None
        self._rx = 1                                    # level of the host's line

    def _scene(self):
        self.seed += 1
        left, right, *_ = scene(self.camera.width, self.camera.height, self.config.labels, self.seed)
        return clip(left), clip(3 * right.astype(int) // 4 if self.rig else right)

    async def start(self) -> None:
        """Start clocks and models; then release the resets in the order of the board: ``sync``, ``display``, cameras."""
        dut = self.dut
        for reset in self._resets:
            reset.value = 1
        dut.uart_rx.value = 1
        dut.buttons.value = 0
        for port in (dut.decoder_scl, dut.decoder_sda, dut.dvi_scl, dut.dvi_sda):
            port.value = 1
        # Clocks driven by C++; half a period is a whole number of picoseconds.
        for clock, hertz in ((dut.clk, CLOCK_HZ), (dut.display_clk, self.display.pixel_clock_hz)):
            cocotb.start_soon(Clock(clock, 2 * round(0.5e12 / hertz), "ps", impl="gpi").start())
        for side, film in self.films.items():
            period = 1e12 / self.camera.byte_clock_hz * (1 + 1e-6 * self.DRIFT_PPM[side])
            cocotb.start_soon(play_cocotb(getattr(dut, f"{side}_camera_clk"), getattr(dut, f"{side}_data"), film, period=round(period),
                                          phase=round(self.PHASE[side] * self.camera.frame_bytes * period) + 1))
        cocotb.start_soon(serve(dut, "memory", self.memory))
        await Timer(1, "us")
        scale = CLOCK_HZ / SETUP_HZ
        for bus, chip, pins, ports, levels in (
                ("decoder", self.decoder, TVP5154.pins, {"resetb": "decoder_reset_n", "pdn": "decoder_powerdown_n"}, {}),
                ("dvi", self.transmitter, (), {}, {"isel": 1})):
            lines = {f"{line}_{end}": f"{bus}_{line}{port}" for line in ("scl", "sda") for end, port in (("low", "_low"), ("i", ""))}
            model = I2cBus(chip)
            model.broken_allowed = True     # chips that do not answer are among the faults
            self._buses.append(model)
            cocotb.start_soon(cocotb_bus(model, dut, pins=pins, ports=ports | lines, levels=levels, scale=scale))
        await self._release()

    async def _release(self) -> None:
        dut = self.dut
        self._watch = cocotb.start_soon(watch_cocotb(self.monitor, dut.display_clk, {name: getattr(dut, name) for name in PINS}))
        for reset in self._resets:
            await Timer(100, "ns")
            reset.value = 0

    async def reset(self, clocks: int, init: int) -> None:
        """The board's reset, for so many clocks: that of all domains and of the memory's controller, which needs ``init`` clocks then."""
        for reset in self._resets:
            reset.value = 1
        self._watch.cancel()
        self.monitor.restart()
        self.memory.restart(clocks, init)
        for bus in self._buses:
            bus.restart()
        await ClockCycles(self.dut.clk, clocks)
        await self._release()

    # The host.

    async def exchange(self) -> None:
        """A clock of the host's line."""
        level = self.host.step(int(self.dut.uart_tx.value))
        if level != self._rx:   # a write costs the simulator a phase
            self.dut.uart_rx.value = self._rx = level
        await RisingEdge(self.dut.clk)

    async def ask(self, operation: Operation, name: str, value: int = 0) -> int:
        """Send a request; the value of the reply, whose status must be OK."""
        register = self.registers[name]
        reply = await self.reply(encode_request(Request(operation, register.address, register.encode(value))))
        assert (reply.status, reply.address) == (Status.OK, register.address), f"{name}: {reply}"
        return register.decode(reply.value)

    async def reply(self, request: bytes) -> Reply:
        """Send the bytes of a request; the reply."""
        self.host.received.clear()
        self.host.send(request)
        for _ in range(400 * UART_CYCLES):
            await self.exchange()
            if (reply := first_reply(bytes(self.host.received))) and self.host.idle:
                for _ in range(UART_CYCLES):
                    await self.exchange()
                return reply
        raise TimeoutError(f"no reply to the request {request.hex(' ')}")

    async def read(self, name: str) -> int:
        """The value of a register."""
        return await self.ask(Operation.READ, name)

    async def until_reads(self, name: str, value: int, attempts: int = 60) -> None:
        """Read a register until it has this value."""
        for _ in range(attempts):
            if await self.read(name) == value:
                return
        raise AssertionError(f"{name} does not become {value}")

    async def write(self, name: str, value: int) -> None:
        """Write a register."""
        assert await self.ask(Operation.WRITE, name, value) == value

    async def block(self, plane: int, line: int) -> bytes | Status:
        """A line of a kept picture, or why there is none; its CRC must be right."""
        self.host.received.clear()
        self.host.send(encode_request(Request(Operation.BLOCK, plane, line)))
        length = line_bytes(self.camera.width)
        wanted = FRAME_BYTES
        for _ in range(2 * block_bits(length) * UART_CYCLES):
            await self.exchange()
            received = bytes(self.host.received)
            if len(received) == FRAME_BYTES:
                reply = first_reply(received)
                assert reply and reply.address == plane
                if reply.status is not Status.OK:
                    return reply.status
                wanted = FRAME_BYTES + length + CRC_BYTES
            if len(received) == wanted:
                data = decode_block(plane, line, received[FRAME_BYTES:])
                assert data is not None, f"the CRC of line {line} is wrong"
                return data
        raise TimeoutError(f"no block of line {line}")

    async def put_line(self, plane: int, line: int, pixels: NDArray[Any], *, spoiled: bool = False, part: int | None = None) -> Status:
        """Send a line of the host's pair: the status of the reply. ``spoiled``: with a wrong CRC; or so many bytes of the block alone."""
        self.host.received.clear()
        data = encode_block(plane, line, stored_line(pixels))
        block = data[:-1] + bytes([data[-1] ^ spoiled])
        self.host.send(encode_request(Request(Operation.BLOCK_WRITE, plane, line)) + block[:part])
        if part is not None:
            while not self.host.idle:
                await self.exchange()
            await self.silence(self.TIMEOUT_BITS - 20)
        for _ in range(2 * block_bits(len(block)) * UART_CYCLES):
            await self.exchange()
            if (reply := first_reply(bytes(self.host.received))) and self.host.idle:
                assert reply.address == plane
                if reply.status is not Status.OK:
                    await self.silence(self.QUIET_BITS)
                return reply.status
        raise TimeoutError(f"no reply to line {line}")

    @staticmethod
    async def silence(bits: int) -> None:
        """So many bits of the host's line, in which nobody sends."""
        await Timer(round(bits * UART_CYCLES / CLOCK_HZ * 1e9), "ns")

    # The monitor.

    def golden(self, pair: tuple[NDArray[Any], NDArray[Any]], settings: dict[str, Any]) -> NDArray[np.uint8]:
        """The monitor's picture of a pair."""
        left, _ = self._rectified(pair, settings)
        return monitor_picture(self.labels(pair, settings), left, self.display, settings["mode"], settings["colour"], self.config.labels)

    def labels(self, pair: tuple[NDArray[Any], NDArray[Any]], settings: dict[str, Any]) -> NDArray[Any]:
        """Disparities of a pair without fraction, counted from the minimum."""
        config = self.config.with_settings(settings)
        left, right = self._rectified(pair, settings)
        right = apply(right, *settings["balance"])
        return np.floor(disparities(left, right, config)).astype(int) - config.minimum

    @staticmethod
    def _rectified(pair: tuple[NDArray[Any], NDArray[Any]], settings: dict[str, Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        return settings["maps"].rectified(*pair) if settings["maps"] else pair

    def auto(self) -> tuple[int, int]:
        """Gain and offset of the balance after some pairs of this scene."""
        minimum = self.settings.get("minimum", self.config.minimum)
        left, right = self._rectified(self.pair, self.settings)
        found = target(measure(left, right, minimum, self.config.labels))
        assert found, "a scene without contrast"
        return found

    def change(self, *, scene: bool = True, **settings: Any) -> None:
        """Another scene in front of the cameras, from their next frames on; ``settings`` that the host writes are recorded."""
        if scene:
            self.pair = self._scene()
            for film, picture in zip(self.films.values(), self.pair):
                film.picture = picture
        self.settings = {**self.settings, **settings}
        self.states.append((self.pair, self.settings))

    def check(self) -> None:
        """Each picture since the last call is a possible one, or its first part and then black.

        Possible are the left and the right picture of any two scenes since then, with any settings since then.
        """
        possible = [self.golden((left, right), settings) for (left, _), _ in self.states for (_, right), _ in self.states
                  for _, settings in self.states] if self.monitor.pictures else []
        while self.monitor.pictures:
            picture = self.monitor.pictures.popleft()
            wrong = [(picture != expected).any(axis=-1).ravel() for expected in possible]
            if all(each.any() for each in wrong):
                self.cut += 1
                black = ~picture.any(axis=-1).ravel()
                assert any(black[each.argmax():].all() for each in wrong), "the monitor shows a picture that no camera has sent"
        del self.states[:-1]

    async def shows(self, frames: int = 12, *, every: bool = True) -> None:
        """Wait until two consecutive pictures of the monitor are bit-exact for the scene and the settings.

        Unless ``every`` is false, those before are checked, too.
        """
        expected = self.golden(self.pair, self.settings)
        seen = 0
        for _ in range(frames):
            await self.frame()
            seen = seen + 1 if np.array_equal(self.monitor.pictures[-1], expected) else 0
            if seen == 2:
                if not every:
                    self.monitor.pictures.clear()
                return self.check()
        raise AssertionError(f"the monitor has not shown the pair in {frames} frames")

    async def frame(self) -> None:
        """Wait for the end of a frame of the monitor."""
        before = self.monitor.frames
        while self.monitor.frames == before:
            await Timer(1, "us")

    async def until(self, condition: Callable[[], bool], frames: int = 20) -> None:
        """Wait for a condition; :class:`TimeoutError` after so many frames of the cameras."""
        for _ in range(round(frames * self.camera.frame_seconds * 1e6) + 1):
            if condition():
                return
            await Timer(1, "us")
        raise TimeoutError(f"not in {frames} frames of the cameras")

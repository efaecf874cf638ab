"""Model of a PAL camera and its decoder: pictures to BT.656 bytes, with injected faults, and the pictures that a receiver must make."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from amaranth import Signal
from cocotb.triggers import Timer
from numpy.typing import NDArray

from golden.video.bt656 import BLANK_CHROMA, BLANK_LUMA, LUMA_MAX, LUMA_MIN, clip, encode
from golden.video.formats import CameraFormat


__all__ = ["FAULTS", "STOPPED", "Camera", "Fault", "frames_of", "play", "play_cocotb"]


Bytes = NDArray[Any]

#: In place of a byte: the clock is stopped for the time of a byte.
STOPPED = -1


@dataclass(frozen=True)
class Fault:
    """A fault in one frame.

    ``damage`` changes its bytes, ``(data, format, rng) -> data``. ``counter`` is the receiver's counter for it, ``None`` for what a
    receiver does not notice; ``kept``: whether the frame is received nevertheless, bit-exact.
    """
    damage: Callable[[Bytes, CameraFormat, np.random.Generator], Bytes]
    counter: str | None = "dropped"
    kept: bool = False


def _line(format: CameraFormat, rng: np.random.Generator, beyond: int = 0) -> int:
    """First byte of a random active line, but for the last ``beyond`` of its field."""
    line = format.before_top + int(rng.integers(format.field_lines - beyond))
    if rng.integers(2):
        line += format.field_lines + format.after_top + format.before_bottom
    return line * format.line_bytes


def _pixels(format: CameraFormat, rng: np.random.Generator) -> int:
    """A random byte of the active part of an active line."""
    return _line(format, rng) + 8 + format.blanking + int(rng.integers(2 * format.width))


def _noise(count: int, rng: np.random.Generator) -> Bytes:
    """Random bytes, half of them such as occur in timing codes."""
    return np.where(rng.random(count) < 0.5, rng.choice([0x00, 0xFF, 0x80], count), rng.integers(0, 256, count))


def _samples(count: int, rng: np.random.Generator) -> Bytes:
    return rng.integers(LUMA_MIN, LUMA_MAX + 1, count)


def _fields(data: Bytes, format: CameraFormat) -> list[Bytes]:
    return np.split(data, [(format.before_top + format.field_lines + format.after_top) * format.line_bytes])


def _lost(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    at = _pixels(format, rng)
    return np.concatenate([data[:at], np.resize([BLANK_CHROMA, BLANK_LUMA], len(data) - at)])


def _lost_in_noise(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    at = _pixels(format, rng)
    return np.concatenate([data[:at], _noise(len(data) - at, rng)])


def _clock_stopped(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    return np.insert(data, _pixels(format, rng), [STOPPED] * 600)


def _decoder_reset(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    return np.concatenate([data[:_pixels(format, rng)], _noise(int(rng.integers(1, 200)), rng)])


def _one_bit_codes(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    codes = np.arange(0, len(data), format.line_bytes)[:, None] + [3, 7 + format.blanking]
    data[codes] ^= 1 << rng.integers(8, size=codes.shape)
    return data


def _two_bit_code(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    # SAV of an active line, or the EAV that closes it.
    at = _line(format, rng) + int(rng.choice([7 + format.blanking, format.line_bytes + 3]))
    data[at] ^= np.sum(1 << rng.permutation(8)[:2])
    return data


def _short_line(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    at = _line(format, rng) + 8 + format.blanking
    return np.delete(data, range(at, at + int(rng.integers(1, 2 * format.width + 1))))


def _long_line(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    return np.insert(data, _pixels(format, rng), _samples(int(rng.integers(1, 2 * format.width)), rng))


def _dropped_lines(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    count = int(rng.integers(1, format.field_lines))
    at = _line(format, rng, beyond=count)
    return np.delete(data, range(at, at + count * format.line_bytes))


def _chroma_noise(data: Bytes, format: CameraFormat, rng: np.random.Generator) -> Bytes:
    for line in range(0, len(data), format.line_bytes):
        data[line + 8 + format.blanking:line + format.line_bytes:2] = _samples(format.width, rng)
    return data


#: By name.
FAULTS = {
    "signal lost": Fault(_lost),
    "signal lost in noise": Fault(_lost_in_noise),
    "clock stopped": Fault(_clock_stopped),
    "fields swapped": Fault(lambda data, format, rng: np.concatenate(_fields(data, format)[::-1])),
    "top field missing": Fault(lambda data, format, rng: _fields(data, format)[1]),
    "bottom field missing": Fault(lambda data, format, rng: _fields(data, format)[0]),
    "one-bit errors of all codes": Fault(_one_bit_codes, counter="corrected", kept=True),
    "two-bit error of a code": Fault(_two_bit_code, counter="rejected"),
    "short line": Fault(_short_line),
    "long line": Fault(_long_line),
    "lines dropped": Fault(_dropped_lines),
    "decoder reset": Fault(_decoder_reset),
    "noise on chroma": Fault(_chroma_noise, counter=None, kept=True),
}


class Camera:
    """Bytes of a camera, frame by frame, and the pictures that a receiver must make of them.

    Parameters
    ----------
    format : CameraFormat
    seed : int
        Seed of the faults and of the noise.
    noise : int
        Most grey levels by which pixels, and chroma, are changed.
    """
    def __init__(self, format: CameraFormat, *, seed: int = 0, noise: int = 0):
        self.format = format
        self.noise = noise
        self.rng = np.random.default_rng(seed)

    def frame(self, picture: NDArray[Any], fault: str | None = None) -> tuple[Bytes, NDArray[np.uint8] | None]:
        """Bytes of the next frame, and the picture that a receiver must make of it.

        Parameters
        ----------
        picture : (H, W) integer ndarray
            Grey levels.
        fault : str
            One of :data:`FAULTS`.

        Returns
        -------
        data : int16 ndarray
            Bytes, and :data:`STOPPED`.
        picture : (H, W) uint8 ndarray or None
            ``None`` if the frame must be dropped.
        """
        luma, chroma = (clip(values + self.rng.integers(-self.noise, self.noise + 1, np.shape(values)))
                        for values in (np.asarray(picture, dtype=int), np.full(np.shape(picture), BLANK_CHROMA)))
        data = encode(luma, self.format, chroma).astype(np.int16)
        if fault is None:
            return data, luma
        return FAULTS[fault].damage(data, self.format, self.rng), luma if FAULTS[fault].kept else None

    def film(self, pictures: Iterable[NDArray[Any]], faults: Mapping[int, str] | None = None) -> tuple[Bytes, list[NDArray[np.uint8]]]:
        """Bytes of a sequence of pictures, and the pictures to be received; ``faults`` by the number of the picture."""
        frames = [self.frame(picture, (faults or {}).get(number)) for number, picture in enumerate(pictures)]
        return np.concatenate([data for data, _ in frames]), [picture for _, picture in frames if picture is not None]


def _levels(data: Iterable[int]) -> Iterator[tuple[int | None, int | None]]:
    """Clock and byte of each half period: the byte changes with the falling edge, and is sampled with the rising one."""
    for byte in data:
        if byte == STOPPED:
            yield None, None
            yield None, None
        else:
            yield 0, int(byte)
            yield 1, None


async def play(ctx: Any, clock: Signal, port: Signal, data: Iterable[int], *, period: float, phase: float = 0.0) -> None:
    """Drive a clock and a byte port in a testbench of Amaranth's simulator.

    Parameters
    ----------
    clock, port : Signal
    data : iterable of int
        Bytes and :data:`STOPPED`.
    period, phase : float
        Seconds; the time of a byte, and the delay of the first one.
    """
    await ctx.delay(phase)
    for level, byte in _levels(data):
        if byte is not None:
            ctx.set(port, byte)
        if level is not None:
            ctx.set(clock, level)
        await ctx.delay(period / 2)


async def play_cocotb(clock: Any, port: Any, data: Iterable[int], *, period: int, phase: int = 0) -> None:
    """The same in cocotb, on handles: ``play_cocotb(dut.left_camera_clk, dut.left_bytes, data, period=37_037)``.

    ``data`` may be an endless generator. ``period`` and ``phase`` are whole picoseconds: cameras with different periods drift.
    """
    if phase:
        await Timer(phase, "ps")
    halves = [period // 2, period - period // 2]
    for half, (level, byte) in enumerate(_levels(data)):
        if byte is not None:
            port.value = byte
        if level is not None:
            clock.value = level
        await Timer(halves[half % 2], "ps")


def frames_of(words: Iterable[Mapping[str, int]], format: CameraFormat) -> list[NDArray[np.uint8] | None]:
    """Frames in a sequence of camera words: a picture for each complete one, ``None`` for each that was dropped.

    Raises :class:`AssertionError` for a violation of the stream's contract.

    Parameters
    ----------
    words : iterable of dict
        Fields of :class:`hdl.video.words.CameraWord` by name.
    """
    frames: list[Any] = []
    pixels: list[int] = []
    for number, word in enumerate(words):
        flags = {name: word[name] for name in ("first", "last", "end", "drop")}
        if word["drop"]:
            assert pixels, f"word {number} drops a frame that has not begun"
            assert flags == {"first": 0, "last": 0, "end": 0, "drop": 1}, f"word {number}: {flags}"
            frames.append(None)
            pixels = []
            continue
        index = len(pixels)
        last = index % format.width == format.width - 1
        end = index == format.width * format.height - 1
        assert flags == {"first": index == 0, "last": last, "end": end, "drop": 0}, f"word {number}, pixel {index} of its frame: {flags}"
        pixels.append(word["luma"])
        if end:
            picture = np.empty((format.height, format.width), np.uint8)
            picture[0::2], picture[1::2] = np.reshape(pixels, (2, format.field_lines, format.width))
            frames.append(picture)
            pixels = []
    assert not pixels, f"a frame is neither complete nor dropped: {len(pixels)} pixels"
    return frames

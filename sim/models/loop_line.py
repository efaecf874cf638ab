"""A line to a board that the host sends pairs to, without gateware: in memory, or at a pseudo-terminal."""

import contextlib
import os
import select
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

from golden.host.device import SerialDevice
from golden.host.protocol import FRAME_SECONDS


__all__ = ["LoopLine", "device_at_port"]


def _good(number: int, data: bytes) -> bytes:
    """A line without faults."""
    return data


class LoopLine:
    """A :class:`hdl.host.chip.Transport` in memory. Whoever waits for the time-out in vain has paused so long.

    Parameters
    ----------
    device : SerialDevice
    to_board, to_host : callable
        Are given the number of a write of the host, or of a byte of the board, counted from 0, and the bytes; what they return is passed
        on.

    Attributes
    ----------
    writes : int
        Of the host.
    """
    def __init__(self, device: SerialDevice, to_board: Callable[[int, bytes], bytes] = _good,
                 to_host: Callable[[int, bytes], bytes] = _good):
        self.device, self.to_board, self.to_host = device, to_board, to_host
        self.writes = 0
        self._sent = 0
        self._data = b""

    def _answer(self, data: bytes) -> None:
        for number in data:
            self._data += self.to_host(self._sent, bytes([number]))
            self._sent += 1

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self._answer(self.device.receive(self.to_board(self.writes, data)))
        self.writes += 1

    def read(self, count: int, seconds: float) -> bytes:
        """Up to ``count`` bytes; no time passes."""
        if len(self._data) < count and seconds > FRAME_SECONDS:
            self._answer(self.device.pause())
        data, self._data = self._data[:count], self._data[count:]
        return data

    def connect(self, port: str, baud: int) -> AbstractContextManager["LoopLine"]:
        """In the place of a port."""
        return contextlib.nullcontext(self)


@contextlib.contextmanager
def device_at_port(device: SerialDevice, unplugged: int | None = None) -> Iterator[str]:
    """Name of a port at which the device answers, for the block; after so many bytes of the host it disappears."""
    master, slave = os.openpty()
    tty.setraw(slave)
    stop = threading.Event()

    def serve() -> None:
        received, heard = 0, time.monotonic()
        while not stop.is_set():
            if select.select([master], [], [], FRAME_SECONDS / 4)[0]:
                data = os.read(master, 4096)
                received += len(data)
                if unplugged is not None and received > unplugged:
                    break
                answer, heard = device.receive(data), time.monotonic()
            elif time.monotonic() - heard > FRAME_SECONDS:
                answer = device.pause()
            else:
                continue
            while answer:
                answer = answer[os.write(master, answer):]
        os.close(slave)
        os.close(master)

    thread = threading.Thread(target=serve)
    name = os.ttyname(slave)
    thread.start()
    try:
        yield name
    finally:
        stop.set()
        thread.join()

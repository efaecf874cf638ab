"""Strict model of a DDR2 controller's local interface: checks the protocol, randomises the timing, stores the contents."""

import itertools
import random
from collections import deque
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from amaranth.hdl import Cat
from numpy.typing import NDArray

from golden.video.memory_map import MemoryMap, Plane
from hdl.video.words import ADDRESS_BITS, WORD_BYTES


__all__ = ["Ddr2Timing", "LocalMemory", "Request", "serve"]


@dataclass(frozen=True)
class Ddr2Timing:
    """Timing of the memory, in clocks of the local interface.

    Parameters
    ----------
    init : int
        Clocks until ``init_done``.
    busy : float
        Probability that ``ready`` is low in a clock.
    patience : int
        Most clocks in a row in which it is low at random.
    latency : (int, int)
        Least and most clocks from a read's acceptance to its first word.
    refresh : (int, int)
        Interval of the refreshes, and the clocks for which ``ready`` is low in each; 7.8 us are 585 clocks of 75 MHz.
    stalls : tuple of (int, int)
        Long stalls: the clock from which, and the number of clocks for which, ``ready`` is low.
    """
    init: int = 20
    busy: float = 0.3
    patience: int = 8
    latency: tuple[int, int] = (10, 30)
    refresh: tuple[int, int] = (585, 16)
    stalls: tuple[tuple[int, int], ...] = ()


class Request(NamedTuple):
    """The master's signals of one clock."""
    address: int
    write_req: int
    read_req: int
    burstbegin: int
    wdata: int
    be: int
    size: int


class LocalMemory:
    """The memory behind the local interface; :meth:`clock` is called once a clock.

    A violation of the protocol is an ``AssertionError``: a request before ``init_done``; one that changes or is withdrawn before
    ``ready``; a read and a write at once; ``burstbegin`` low in the first cycle of a burst, or high in another; an address or size out of
    range; a read within a write burst; a write burst whose address changes.

    A word that was never written reads as noise, different each time; so do bytes of a word that were never enabled.

    Parameters
    ----------
    words : int
        Words of the memory.
    size : int
        Most words of a local burst.
    timing : Ddr2Timing
    seed : int

    Attributes
    ----------
    ready, rdata, rdata_valid, init_done : int
        The memory's outputs in the next clock.
    now, words_read, words_written : int
        Clocks elapsed, and words transferred.
    """
    def __init__(self, words: int = 2**ADDRESS_BITS, *, size: int = 1, timing: Ddr2Timing | None = None, seed: int = 1):
        self.words = words
        self.size = size
        self.timing = timing or Ddr2Timing()
        self.now = self.words_read = self.words_written = 0
        self.ready = self.rdata_valid = self.init_done = 0
        self._rng = random.Random(seed)
        self._stalls = dict(self.timing.stalls)
        self.rdata = self._noise()
        self._contents: dict[int, int] = {}
        self._written_bytes: dict[int, int] = {}
        self._in_flight: deque[tuple[int, int]] = deque()       # clock, word
        self._waiting: Request | None = None
        self._burst: tuple[int, int, int] | None = None         # write burst in progress: address, size, words received
        self._low = 0                                           # clocks in a row without ready
        self._stalled_until = 0
        self._reset_until = self._ready_from = 0

    def __getitem__(self, address: int) -> int:
        """A word of the memory; ``KeyError`` if a byte of it was never written."""
        if self._written_bytes[address] != 2**WORD_BYTES - 1:
            raise KeyError(address)
        return self._contents[address]

    def __setitem__(self, address: int, word: int) -> None:
        self._write(address, word, 2**WORD_BYTES - 1)

    @property
    def in_flight(self) -> int:
        """Words read that have not been returned."""
        return len(self._in_flight)

    def stall(self, clocks: int) -> None:
        """Keep ``ready`` low for so many clocks from now on."""
        self._stalled_until = max(self._stalled_until, self.now + clocks)

    def restart(self, clocks: int, init: int) -> None:
        """Reset of the controller for so many clocks from now on, whatever the master does meanwhile; ``init`` clocks later it is
        initialised again. Words that were read and not returned are lost; the contents are kept, as by a memory without power-down.
        """
        self._reset_until = self.now + clocks
        self._ready_from = self._reset_until + init
        self._in_flight.clear()
        self._waiting = self._burst = None
        self.ready = self.rdata_valid = self.init_done = 0

    def picture(self, memory_map: MemoryMap, plane: Plane, buffer: int) -> NDArray[np.uint8]:
        """The picture in a buffer of a plane; ``KeyError`` where a pixel was never written."""
        base = memory_map.base(plane, buffer)
        words = {}
        for y in range(memory_map.height):
            for n in range(memory_map.line_words):
                offset = y * memory_map.pitch + n
                enabled = min(WORD_BYTES, memory_map.width - n * WORD_BYTES)
                if ~self._written_bytes.get(base + offset, 0) & (2**enabled - 1):
                    raise KeyError(base + offset)
                words[offset] = self._contents[base + offset]
        return memory_map.picture(words)

    def load(self, memory_map: MemoryMap, plane: Plane, buffer: int, picture: NDArray[Any]) -> None:
        """Store a picture in a buffer of a plane."""
        for offset, word in memory_map.words(picture).items():
            self[memory_map.base(plane, buffer) + offset] = word

    def clock(self, request: Request | None) -> None:
        """One clock edge: sample the master's signals of the clock that ends, and set the memory's outputs for the one that begins.

        ``request`` is ``None`` where all of ``write_req``, ``read_req`` and ``burstbegin`` are low.
        """
        if self.now < self._reset_until:
            request = None
        if request is not None:
            self._check(request)
            if self.ready:
                self._accept(request)
        elif self._waiting is not None:
            raise AssertionError(f"clock {self.now}: {self._waiting} withdrawn before ready")
        self._waiting = request if not self.ready else None
        self.now += 1
        self.init_done = int(self.now >= max(self.timing.init, self._ready_from))
        self._choose_ready()
        if self._in_flight and self._in_flight[0][0] <= self.now:
            self.rdata, self.rdata_valid = self._in_flight.popleft()[1], 1
        elif self.rdata_valid:
            self.rdata, self.rdata_valid = self._noise(), 0

    def _noise(self) -> int:
        return self._rng.getrandbits(8 * WORD_BYTES)

    def _choose_ready(self) -> None:
        timing, now = self.timing, self.now
        if now in self._stalls:
            self.stall(self._stalls[now])
        interval, length = timing.refresh
        if now < max(self._stalled_until, self._reset_until) or now % interval >= interval - length:
            self.ready = 0
        elif self._low < timing.patience and self._rng.random() < timing.busy:
            self.ready, self._low = 0, self._low + 1
        else:
            self.ready, self._low = 1, 0

    def _check(self, request: Request) -> None:
        if (fault := self._fault(request)) is not None:
            raise AssertionError(f"clock {self.now}: {request}: {fault}")

    def _fault(self, request: Request) -> str | None:
        """The violation in a request; ``None`` if there is none."""
        if not (request.write_req or request.read_req):
            return "burstbegin without a request"
        if request.write_req and request.read_req:
            return "read and write at once"
        if not self.init_done:
            return "before init_done"
        if (waiting := self._waiting) is not None:
            if request.burstbegin:
                return "burstbegin stays high"
            same = request.read_req == waiting.read_req and request.address == waiting.address and request.size == waiting.size
            if not same or (request.write_req and (request.wdata != waiting.wdata or request.be != waiting.be)):
                return f"changed before ready, from {waiting}"
        elif self._burst is not None:
            address, size, _ = self._burst
            if request.read_req:
                return "a read in a write burst"
            if request.burstbegin:
                return "burstbegin in a write burst"
            if (request.address, request.size) != (address, size):
                return f"changed in a write burst of {size} from {address}"
        else:
            if not request.burstbegin:
                return "burstbegin is missing"
            if not 1 <= request.size <= self.size:
                return f"size is not from 1 to {self.size}"
            if request.address + request.size > self.words:
                return f"beyond the {self.words} words of the memory"
        return None

    def _accept(self, request: Request) -> None:
        if request.read_req:
            due = self.now + self._rng.randint(*self.timing.latency)
            for address in range(request.address, request.address + request.size):
                known = self._written_bytes.get(address, 0)
                word = self._contents.get(address, 0)
                if known != 2**WORD_BYTES - 1:
                    word |= self._noise() & ~_bytes(known)
                self._in_flight.append((due, word))
            self.words_read += request.size
            return
        address, size, count = self._burst or (request.address, request.size, 0)
        self._write(address + count, request.wdata, request.be)
        self.words_written += 1
        self._burst = (address, size, count + 1) if count + 1 < size else None

    def _write(self, address: int, word: int, be: int) -> None:
        mask = _bytes(be)
        self._contents[address] = self._contents.get(address, 0) & ~mask | word & mask
        self._written_bytes[address] = self._written_bytes.get(address, 0) | be


_MASKS = {0: 0, 2**WORD_BYTES - 1: 2**(8 * WORD_BYTES) - 1}


def _bytes(enables: int) -> int:
    """Mask of the bits in enabled bytes."""
    if enables not in _MASKS:
        _MASKS[enables] = sum(0xff << 8 * n for n in range(WORD_BYTES) if enables >> n & 1)
    return _MASKS[enables]


def serve(bus: Any, memory: LocalMemory) -> Callable[[Any], Coroutine[Any, Any, None]]:
    """A process for Amaranth's simulator (``add_process``): the memory at a :class:`hdl.video.words.LocalBus`."""
    async def process(ctx: Any) -> None:
        driven: dict[str, int] = {}

        def drive() -> None:
            for name in ("ready", "rdata", "rdata_valid", "init_done"):
                if driven.get(name) != (value := getattr(memory, name)):
                    ctx.set(getattr(bus, name), value)
                    driven[name] = value

        drive()
        request = Cat(bus.address, bus.size, bus.be, bus.wdata)
        strobes = Cat(bus.write_req, bus.read_req, bus.burstbegin)
        offsets = list(itertools.accumulate((len(bus.address), len(bus.size), len(bus.be)), initial=0))
        masks = [2**len(signal) - 1 for signal in (bus.address, bus.size, bus.be, bus.wdata)]
        async for _, _, strobe, word in ctx.tick().sample(strobes, request):
            if strobe:
                address, size, be, wdata = (word >> offset & mask for offset, mask in zip(offsets, masks))
                memory.clock(Request(address=address, write_req=strobe & 1, read_req=strobe >> 1 & 1, burstbegin=strobe >> 2,
                                     wdata=wdata, be=be, size=size))
            else:
                memory.clock(None)
            drive()
    return process

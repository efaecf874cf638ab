"""Strict model of the DDR2 controller's local interface: protocol checked, timing hostile, contents kept."""

import itertools
import random
from collections import deque
from dataclasses import dataclass

from amaranth.hdl import Cat

from hdl.video.words import ADDRESS_BITS, WORD_BYTES


__all__ = ["Ddr2Timing", "LocalMemory", "Request", "serve"]


@dataclass(frozen=True)
class Ddr2Timing:
    """How unkind the memory is; all times in clocks of the local interface.

    Parameters
    ----------
    init : int
        Clocks until ``init_done``.
    busy : float
        Chance that ``ready`` is low in a clock.
    patience : int
        Most clocks in a row in which it is low by chance.
    latency : (int, int)
        Least and most clocks from a read's acceptance to its first word.
    refresh : (int, int)
        Interval of the refreshes, and how long ``ready`` is low in each; 7.8 us are 585 clocks of 75 MHz.
    stalls : tuple of (int, int)
        Long stalls: at which clock, and for how many ``ready`` stays low.
    """
    init: int = 20
    busy: float = 0.3
    patience: int = 8
    latency: tuple[int, int] = (10, 30)
    refresh: tuple[int, int] = (585, 16)
    stalls: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Request:
    """The master's signals of one clock."""
    address: int
    write_req: int
    read_req: int
    burstbegin: int
    wdata: int
    be: int
    size: int


class LocalMemory:
    """The memory behind the local interface, one call of :meth:`clock` a clock.

    A violation of the protocol is an ``AssertionError``: a request before ``init_done``; one that changes or goes before ``ready``; both
    kinds at once; ``burstbegin`` that is missing in a burst's first cycle, or high in another; an address or size out of range; a read
    within a write burst; a write burst whose address changes.

    A word that was never written reads as noise, other noise each time; so do the bytes of a word that were never enabled.

    Parameters
    ----------
    words : int
        Size of the memory.
    size : int
        Most words of a local burst.
    timing : Ddr2Timing
    seed : int

    Attributes
    ----------
    ready, rdata, rdata_valid, init_done : int
        What the memory drives in the coming clock.
    now, words_read, words_written : int
        Clocks gone by, and words moved.
    """
    def __init__(self, words=2**ADDRESS_BITS, *, size=1, timing=None, seed=1):
        self.words = words
        self.size = size
        self.timing = timing or Ddr2Timing()
        self.now = self.words_read = self.words_written = 0
        self.ready = self.rdata_valid = self.init_done = 0
        self._rng = random.Random(seed)
        self.rdata = self._noise()
        self._contents: dict[int, int] = {}
        self._written_bytes: dict[int, int] = {}
        self._on_their_way: deque[tuple[int, int]] = deque()    # clock, word
        self._waiting: Request | None = None
        self._burst: tuple[int, int, int] | None = None         # write burst under way: its address, its size, words that have come
        self._low = 0                                           # clocks in a row without ready
        self._stalled_until = 0

    def __getitem__(self, address):
        """A word as it is in the memory; ``KeyError`` if a byte of it was never written."""
        if self._written_bytes[address] != 2**WORD_BYTES - 1:
            raise KeyError(address)
        return self._contents[address]

    def __setitem__(self, address, word):
        self._write(address, word, 2**WORD_BYTES - 1)

    def stall(self, clocks):
        """Keep ``ready`` low for that long from now on."""
        self._stalled_until = max(self._stalled_until, self.now + clocks)

    def picture(self, memory_map, plane, buffer):
        """What a plane of the memory holds; ``KeyError`` where a pixel was never written."""
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

    def load(self, memory_map, plane, buffer, picture):
        """Put a picture into a plane."""
        for offset, word in memory_map.words(picture).items():
            self[memory_map.base(plane, buffer) + offset] = word

    def clock(self, request):
        """One clock edge: take the master's signals of the clock that ends, and set those of the memory for the one that begins.

        ``request`` is ``None`` where all of ``write_req``, ``read_req`` and ``burstbegin`` are low.
        """
        if request is not None:
            self._check(request)
            if self.ready:
                self._accept(request)
        else:
            assert self._waiting is None, f"clock {self.now}: {self._waiting} went before ready"
        self._waiting = request if not self.ready else None
        self.now += 1
        self.init_done = int(self.now >= self.timing.init)
        self._choose_ready()
        if self._on_their_way and self._on_their_way[0][0] <= self.now:
            self.rdata, self.rdata_valid = self._on_their_way.popleft()[1], 1
        elif self.rdata_valid:
            self.rdata, self.rdata_valid = self._noise(), 0

    def _noise(self):
        return self._rng.getrandbits(8 * WORD_BYTES)

    def _choose_ready(self):
        timing = self.timing
        for at, clocks in timing.stalls:
            if self.now == at:
                self.stall(clocks)
        interval, length = timing.refresh
        if self.now < self._stalled_until or self.now % interval >= interval - length:
            self.ready = 0
        elif self._rng.random() < timing.busy and self._low < timing.patience:
            self.ready, self._low = 0, self._low + 1
        else:
            self.ready, self._low = 1, 0

    def _check(self, request):
        where = f"clock {self.now}: {request}"
        assert request.write_req or request.read_req, f"{where}: burstbegin without a request"
        assert not (request.write_req and request.read_req), f"{where}: read and write at once"
        assert self.init_done, f"{where}: before init_done"
        if (waiting := self._waiting) is not None:
            assert not request.burstbegin, f"{where}: burstbegin stays high"
            same = request.read_req == waiting.read_req and request.address == waiting.address and request.size == waiting.size
            same_word = request.read_req or (request.wdata == waiting.wdata and request.be == waiting.be)
            assert same and same_word, f"{where}: changed before ready, from {waiting}"
        elif self._burst is not None:
            address, size, _ = self._burst
            assert not request.read_req, f"{where}: a read in a write burst"
            assert not request.burstbegin, f"{where}: burstbegin in a write burst"
            assert (request.address, request.size) == (address, size), f"{where}: changed in a write burst of {size} from {address}"
        else:
            assert request.burstbegin, f"{where}: burstbegin is missing"
            assert 1 <= request.size <= self.size, f"{where}: size is not from 1 to {self.size}"
            assert request.address + request.size <= self.words, f"{where}: beyond the {self.words} words of the memory"

    def _accept(self, request):
        if request.read_req:
            due = self.now + self._rng.randint(*self.timing.latency)
            for address in range(request.address, request.address + request.size):
                known = self._written_bytes.get(address, 0)
                word = self._contents.get(address, 0)
                if known != 2**WORD_BYTES - 1:
                    word |= self._noise() & ~_bytes(known)
                self._on_their_way.append((due, word))
            self.words_read += request.size
            return
        address, size, count = self._burst or (request.address, request.size, 0)
        self._write(address + count, request.wdata, request.be)
        self.words_written += 1
        self._burst = (address, size, count + 1) if count + 1 < size else None

    def _write(self, address, word, be):
        mask = _bytes(be)
        self._contents[address] = self._contents.get(address, 0) & ~mask | word & mask
        self._written_bytes[address] = self._written_bytes.get(address, 0) | be


_MASKS = {0: 0, 2**WORD_BYTES - 1: 2**(8 * WORD_BYTES) - 1}


def _bytes(enables):
    """Bits of the bytes that are enabled."""
    if enables not in _MASKS:
        _MASKS[enables] = sum(0xff << 8 * n for n in range(WORD_BYTES) if enables >> n & 1)
    return _MASKS[enables]


def serve(bus, memory):
    """The memory at a :class:`hdl.video.words.LocalBus` in Amaranth's simulator: a process (``add_process``)."""
    async def process(ctx):
        driven = {}

        def drive():
            for name in ("ready", "rdata", "rdata_valid", "init_done"):
                if driven.get(name) != (value := getattr(memory, name)):
                    ctx.set(getattr(bus, name), value)
                    driven[name] = value

        drive()
        request = Cat(bus.address, bus.size, bus.be, bus.wdata)
        strobes = Cat(bus.write_req, bus.read_req, bus.burstbegin)
        places = list(itertools.accumulate((len(bus.address), len(bus.size), len(bus.be)), initial=0))
        masks = [2**len(signal) - 1 for signal in (bus.address, bus.size, bus.be, bus.wdata)]
        async for _, _, strobe, word in ctx.tick().sample(strobes, request):
            if strobe:
                address, size, be, wdata = (word >> place & mask for place, mask in zip(places, masks))
                memory.clock(Request(address=address, write_req=strobe & 1, read_req=strobe >> 1 & 1, burstbegin=strobe >> 2,
                                     wdata=wdata, be=be, size=size))
            else:
                memory.clock(None)
            drive()
    return process

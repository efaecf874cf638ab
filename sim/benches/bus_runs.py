"""What is done with a core with a bus, whichever bus it is: accesses to registers, frames with stalls, frames of a wrong size."""

import random
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge

from golden.host.core_registers import WORD_BITS, word_access
from golden.host.protocol import Status
from golden.host.registers import Kind
from golden.video.frame_rule import Closes, Fault, ReceivedWord, received
from hdl.interfaces.axi_lite import BusResponse

from .bus_cases import BusCase, pixel_words, result_words


__all__ = ["Host", "accesses", "contradictions", "late_settings", "new_settings", "pictures"]


RESPONSES = {Status.OK: BusResponse.OKAY, Status.UNKNOWN_ADDRESS: BusResponse.DECERR}


class Host(ABC):
    """What drives the ports of a core: a kit's masters, sources and sinks."""
    clock: Any
    source: Any
    sink: Any
    closes: Closes

    @abstractmethod
    async def read(self, address: int) -> tuple[int, int]:
        """Response and word of the register ``address``."""

    @abstractmethod
    async def write(self, address: int, data: int, strobes: int = 15) -> int:
        """Write a word; the response."""

    @abstractmethod
    async def send(self, words: Sequence[ReceivedWord]) -> None:
        """Offer pixels to the core; return once all are accepted."""

    @abstractmethod
    async def frame(self, width: int, height: int) -> list[list[int]]:
        """Receive a frame of this size, and check its marks."""

    @abstractmethod
    def nothing_left(self) -> bool:
        """Whether everything that the core gave was received."""

    def __init__(self, case: BusCase) -> None:
        self.case = case
        self.registers = case.registers
        self.accepted = 0

    def watch(self, valid: Any, ready: Any) -> None:
        """Count pixels that are accepted, from now on."""
        async def count() -> None:
            while True:
                await RisingEdge(self.clock)
                self.accepted += bool(valid.value) and bool(ready.value)

        cocotb.start_soon(count())

    async def get(self, name: str) -> int:
        """Value of a register."""
        response, value = await self.read(self.registers[name].address)
        assert response == BusResponse.OKAY
        return value

    async def set(self, **values: int) -> None:
        """Write registers, in this order."""
        for name, value in values.items():
            response = await self.write(self.registers[name].address, value % (1 << WORD_BITS))
            assert response == BusResponse.OKAY, f"{name} = {value}: response {response}"

    async def applied(self) -> None:
        """Put settings into force, and wait until they are."""
        await self.set(apply=1)
        for _ in range(1000):
            if not await self.get("applying"):
                return
        raise TimeoutError("settings are not applied")


async def accesses(host: Host, count: int) -> None:
    """Random reads and writes, of addresses without a register, out of range, of some bytes; each response as the golden model's."""
    registers, rng = host.registers, random.Random(1)
    values = {register.name: register.reset for register in registers}
    for register in registers:
        assert await host.read(register.address) == (BusResponse.OKAY, word_access(registers, values, register.address)[1])
    told = set()
    for _ in range(count):
        register = rng.choice([*registers.of(Kind.SETTING), *registers])
        address = rng.choice([register.address, register.address, register.address, rng.randrange(256)])
        value = rng.choice([register.minimum, register.maximum, register.minimum - 1, register.maximum + 1,
                            rng.randint(register.minimum, register.maximum), rng.getrandbits(WORD_BITS)]) % (1 << WORD_BITS)
        strobes = rng.choice([15, 15, rng.randrange(16)])
        if registers["apply"].address == address:
            continue
        status, _, written = word_access(registers, values, address, value, strobes)
        told.add(status)
        assert await host.write(address, value, strobes) == RESPONSES.get(status, BusResponse.SLVERR)
        values.update({name: value for name, value in written.items() if registers[name].kind is Kind.SETTING})
        status, data, _ = word_access(registers, values, address)
        assert await host.read(address) == (RESPONSES.get(status, BusResponse.SLVERR), data), f"register {address:#x}"
    assert told == {Status.OK, Status.UNKNOWN_ADDRESS, Status.READ_ONLY, Status.OUT_OF_RANGE}


async def pictures(host: Host, pairs: Sequence[tuple[Any, Any]], settings: dict[str, int]) -> None:
    """Frames one after the other, while registers are read: bit-exact, and nothing else."""
    height, width = pairs[0][0].shape
    sending = cocotb.start_soon(host.send([word for pair in pairs for word in pixel_words(*pair, host.closes)]))
    before = await host.get("frames")
    for left, right in pairs:
        assert await host.frame(width, height) == result_words(left, right, host.case.config, settings)
        assert await host.get("disparities") == host.case.config.labels
    await sending
    await ClockCycles(host.clock, 100)
    assert host.nothing_left()
    assert await host.get("frames") == before + len(pairs)
    assert [await host.get(name) for name in ("fault", "matcher_error", "faults")] == [0, 0, 0]


async def new_settings(host: Host, settings: dict[str, int]) -> None:
    """Settings that are written and applied within a frame are in force from the next one on."""
    pairs = host.case.pairs(3, seed=20)
    width, height = host.case.config.max_width, host.case.height
    sending = cocotb.start_soon(host.send([word for pair in pairs for word in pixel_words(*pair, host.closes)]))
    receiving = cocotb.start_soon(receive(host, width, height, len(pairs)))
    await host.set(**settings)
    while host.accepted < width * height + width:
        await RisingEdge(host.clock)
    host.source.clear_pause_generator()
    host.source.pause = True
    await host.set(apply=1)
    assert await host.get("applying") == 1
    host.source.pause = False
    await sending
    assert await host.get("applying") == 0
    assert await receiving == [result_words(*pair, host.case.config, in_force) for pair, in_force in zip(pairs, ({}, {}, settings))]


async def late_settings(host: Host, settings: dict[str, int]) -> None:
    """Settings wait for a frame that is inside the core and has not begun to be output."""
    width, height = host.case.config.max_width, 2
    await host.set(height=height)
    await host.applied()
    pairs = host.case.pairs(2, height=height, seed=30)
    host.sink.pause = True
    await host.send(pixel_words(*pairs[0], host.closes))
    await ClockCycles(host.clock, 300)
    await host.set(**settings, apply=1)
    sending = cocotb.start_soon(host.send(pixel_words(*pairs[1], host.closes)))
    await ClockCycles(host.clock, 50)
    assert await host.get("applying") == 1 and host.accepted == width * height
    host.sink.pause = False
    for pair, in_force in zip(pairs, ({}, settings)):
        assert await host.frame(width, height) == result_words(*pair, host.case.config, in_force)
    await sending
    assert await host.get("applying") == 0


async def receive(host: Host, width: int, height: int, count: int) -> list[list[list[int]]]:
    """So many frames."""
    return [await host.frame(width, height) for _ in range(count)]


async def contradictions(host: Host, faulty: Sequence[tuple[Sequence[ReceivedWord], Fault]], size: tuple[int, int]) -> None:
    """Streams that contradict the size: the register tells which fault was first, and how many there were; the next frame is exact."""
    for number, (words, fault) in enumerate(faulty):
        (left, right), = host.case.pairs(1, *size, seed=40 + number)
        words = [*words, *pixel_words(left, right, host.closes)]
        expected = received(words, *size, host.closes)
        assert expected.faults[0] is fault and (expected.pairs[-1][0] == left).all()
        sending = cocotb.start_soon(host.send(words))
        for pair in expected.pairs:
            assert await host.frame(size[0], pair[0].shape[0]) == result_words(*pair, host.case.config, {}), fault.text
        await sending
        await ClockCycles(host.clock, 100)
        assert host.nothing_left()
        assert await host.get("fault") == fault and await host.get("faults") == len(expected.faults)
        await host.set(clear=1)
        assert [await host.get(name) for name in ("fault", "faults", "matcher_error", "frames")] == [0, 0, 0, 0]
        # Settings do not wait for a frame that was dropped.
        await host.applied()

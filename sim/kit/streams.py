"""Stream drivers, receiver and rule checker for Amaranth's simulator.

``rng`` is anything with a method ``random()`` (``numpy.random.default_rng(seed)``, ``random.Random(seed)``). Stalls are
probabilities for each cycle. Time-outs count cycles *without a transfer*, so they need no scaling with the amount of data.
"""

from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol

from amaranth.hdl import Cat, ShapeCastable, Value
from amaranth.sim import Simulator

from .payloads import pack


__all__ = ["TIMEOUT", "Random", "check_rules", "receive", "run_stream", "send"]


#: Cycles without a transfer.
TIMEOUT = 10_000


class Random(Protocol):
    """A source of random numbers."""
    def random(self) -> float:
        """From 0, including, to 1, excluding."""


def _noise(width: int, rng: Random) -> int:
    """Bits for the payload of an idle stream, so that a block that reads it without ``valid`` fails."""
    # A float has 53 bits, a payload may have thousands.
    chunks = [int(rng.random() * 2**32) << place for place in range(0, width, 32)]
    return sum(chunks) % 2**width


def _from_bits(stream: Any) -> Callable[[int], Any]:
    """What makes a payload of bits."""
    shape = stream.payload.shape()
    return shape.from_bits if isinstance(shape, ShapeCastable) else lambda bits: bits


async def send(ctx: Any, stream: Any, payloads: Sequence[Any], *, rng: Random, stall: float = 0.0, timeout: int = TIMEOUT) -> None:
    """Send ``payloads``; each cycle before one is idle with probability ``stall``."""
    shape, width = stream.payload.shape(), len(Value.cast(stream.payload))
    # Set at once: the simulator settles the design after each change.
    offer = Cat(Value.cast(stream.payload), stream.valid)
    valid = 1 << width
    for index, payload in enumerate(payloads):
        while rng.random() < stall:
            ctx.set(offer, _noise(width, rng))
            await ctx.tick()
        ctx.set(offer, valid | pack(shape, payload))
        for _ in range(timeout):
            _, _, ready = await ctx.tick().sample(stream.ready)
            if ready:
                break
        else:
            raise TimeoutError(f"payload {index} of {len(payloads)} not accepted for {timeout} cycles")
    ctx.set(offer, _noise(width, rng))


async def _receive(ctx: Any, stream: Any, count: int, rng: Random, stall: float, timeout: int) -> list[int]:
    """:func:`receive`, as bits."""
    received: list[int] = []
    idle = 0
    offered = False
    was_ready = None
    payload_bits = Value.cast(stream.payload)
    while len(received) < count:
        must_see_valid = stall > 0 and not offered and len(received) in (0, count - 1)
        ready = not must_see_valid and rng.random() >= stall
        if ready != was_ready:
            ctx.set(stream.ready, ready)
            was_ready = ready
        _, _, valid, payload = await ctx.tick().sample(stream.valid, payload_bits)
        offered = bool(valid) and not ready
        if valid and ready:
            received.append(payload)
            idle = 0
        elif (idle := idle + 1) >= timeout:
            raise TimeoutError(f"{len(received)} of {count} payloads, then none for {timeout} cycles")
    ctx.set(stream.ready, 0)
    return received


async def receive(ctx: Any, stream: Any, count: int, *, rng: Random, stall: float = 0.0, timeout: int = TIMEOUT) -> list[Any]:
    """Accept ``count`` payloads and return them; ``ready`` is low in a cycle with probability ``stall``.

    With stalls, the first and the last payload must be valid for a cycle before they are accepted: a block whose ``valid`` waits for
    ``ready`` then hangs, and this raises :class:`TimeoutError`.
    """
    return list(map(_from_bits(stream), await _receive(ctx, stream, count, rng, stall, timeout)))


def check_rules(stream: Any, transfers: list[Any], cycles: list[int] | None = None, *,
                name: str = "stream") -> Callable[[Any], Awaitable[None]]:
    """Background testbench: a payload holds until accepted. Appends each transfer to ``transfers``, its cycle to ``cycles``.

    Cycle 0 is the first one of the simulation.
    """
    payload_of = _from_bits(stream)

    async def testbench(ctx: Any) -> None:
        held = None
        cycle = 0
        async for _, reset, valid, ready, payload in ctx.tick().sample(stream.valid, stream.ready, Value.cast(stream.payload)):
            if held is not None and not reset:
                assert valid, f"{name}: valid dropped before a transfer, cycle {cycle}"
                assert payload == held, (f"{name}: payload changed while stalled, cycle {cycle}: "
                                         f"{payload_of(held)!r} -> {payload_of(payload)!r}")
            held = payload if valid and not ready else None
            if valid and ready and not reset:
                transfers.append(payload_of(payload))
                if cycles is not None:
                    cycles.append(cycle)
            cycle += 1
    return testbench


def run_stream(dut: Any, payloads: Iterable[Any], *, rng: Random, stall_i: float = 0.0, stall_o: float = 0.0, drain: int = 16,
               count: int | None = None, timeout: int = TIMEOUT, inputs: Mapping[str, Any] | None = None,
               cycles: dict[str, list[int]] | None = None, i: str = "i", o: str = "o") -> list[Any]:
    """Send ``payloads`` through ``dut``; return all payloads of the output, extra ones too.

    Parameters
    ----------
    stall_i, stall_o : float
        Probability of an idle cycle before an input payload; of a low ``ready`` in a cycle of the output.
    drain : int
        Cycles with ``ready`` high after the last expected payload, in which an extra one is received.
    count : int
        Payloads expected from the output; by default as many as are sent.
    inputs : dict
        Plain inputs, set before the first cycle, by member name.
    cycles : dict
        Receives the cycle of every transfer: ``cycles["i"]`` and ``cycles["o"]``.
    i, o : str
        Names of the streams.
    """
    payloads = list(payloads)
    count = len(payloads) if count is None else count
    stream_i, stream_o = getattr(dut, i), getattr(dut, o)
    taken: list = []
    given: list = []
    cycles = {} if cycles is None else cycles
    cycles["i"], cycles["o"] = [], []

    async def source(ctx):
        for name, value in (inputs or {}).items():
            ctx.set(getattr(dut, name), value)
        await send(ctx, stream_i, payloads, rng=rng, stall=stall_i, timeout=timeout)

    async def sink(ctx):
        await _receive(ctx, stream_o, count, rng, stall_o, timeout)
        ctx.set(stream_o.ready, 1)
        await ctx.tick().repeat(drain)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(stream_i, taken, cycles["i"], name=i), background=True)
    sim.add_testbench(check_rules(stream_o, given, cycles["o"], name=o), background=True)
    sim.run()
    assert len(taken) == len(payloads)
    return given

"""Stream drivers, receiver and rule checker for Amaranth's own simulator.

``rng`` is anything with a method ``random()`` (``numpy.random.default_rng(seed)``, ``random.Random(seed)``). Stalls are
probabilities for each cycle. Time-outs count cycles *without a transfer*, so they need no scaling with the amount of data.
"""

from amaranth.hdl import Value
from amaranth.sim import Simulator


__all__ = ["TIMEOUT", "check_rules", "receive", "run_stream", "send"]


TIMEOUT = 10_000


def _poison(ctx, stream, rng):
    """Leave noise in the payload of an idle stream: a block that reads it without looking at ``valid`` shows up."""
    payload = Value.cast(stream.payload)
    # A float has 53 bits, a payload may have thousands.
    chunks = [int(rng.random() * 2**32) << place for place in range(0, len(payload), 32)]
    ctx.set(payload, sum(chunks) % 2**len(payload))


async def send(ctx, stream, payloads, *, rng, stall=0.0, timeout=TIMEOUT):
    """Put ``payloads`` into ``stream``, idling with probability ``stall`` before each."""
    for index, payload in enumerate(payloads):
        while rng.random() < stall:
            _poison(ctx, stream, rng)
            await ctx.tick()
        ctx.set(stream.payload, payload)
        ctx.set(stream.valid, 1)
        for _ in range(timeout):
            _, _, ready = await ctx.tick().sample(stream.ready)
            if ready:
                break
        else:
            raise TimeoutError(f"payload {index} of {len(payloads)} not taken for {timeout} cycles")
        ctx.set(stream.valid, 0)
    _poison(ctx, stream, rng)


async def receive(ctx, stream, count, *, rng, stall=0.0, timeout=TIMEOUT):
    """Take ``count`` payloads from ``stream``, stalling with probability ``stall``; return them.

    With stalls, the first and the last payload are not taken before they have been offered for a cycle: a block whose ``valid``
    waits for ``ready`` then hangs, and the time-out tells.
    """
    received = []
    idle = 0
    offered = False
    while len(received) < count:
        must_see_valid = stall > 0 and not offered and len(received) in (0, count - 1)
        ready = not must_see_valid and rng.random() >= stall
        ctx.set(stream.ready, ready)
        _, _, valid, payload = await ctx.tick().sample(stream.valid, stream.payload)
        offered = bool(valid) and not ready
        if valid and ready:
            received.append(payload)
            idle = 0
        elif (idle := idle + 1) >= timeout:
            raise TimeoutError(f"{len(received)} of {count} payloads, then none for {timeout} cycles")
    ctx.set(stream.ready, 0)
    return received


def check_rules(stream, transfers, cycles=None, *, name="stream"):
    """Background testbench: a payload holds until taken. Appends every transfer to ``transfers``, its cycle to ``cycles``.

    Cycle 0 is the first one after the start of the simulation.
    """
    async def testbench(ctx):
        held = None
        cycle = 0
        async for _, reset, valid, ready, payload in ctx.tick().sample(stream.valid, stream.ready, stream.payload):
            if held is not None and not reset:
                assert valid, f"{name}: valid dropped before a transfer, cycle {cycle}"
                assert payload == held, f"{name}: payload changed while stalled, cycle {cycle}: {held!r} -> {payload!r}"
            held = payload if valid and not ready else None
            if valid and ready and not reset:
                transfers.append(payload)
                if cycles is not None:
                    cycles.append(cycle)
            cycle += 1
    return testbench


def run_stream(dut, payloads, *, rng, stall_i=0.0, stall_o=0.0, drain=16, count=None, timeout=TIMEOUT, inputs=None, cycles=None,
               i="i", o="o"):
    """Push ``payloads`` through ``dut``; return all that came out, extra words too.

    Parameters
    ----------
    stall_i, stall_o : float
        Probability of an idle cycle before each payload in, of a stall in each cycle out.
    drain : int
        Cycles with ``ready`` high after the last expected word: a duplicated or invented word shows up in them.
    count : int
        Words expected out; as many as ``payloads`` by default.
    inputs : dict
        Plain inputs to set before the start, by member name.
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
        await receive(ctx, stream_o, count, rng=rng, stall=stall_o, timeout=timeout)
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

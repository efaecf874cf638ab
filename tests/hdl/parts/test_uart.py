# amaranth: UnusedElaboratable=no
"""hdl.parts.uart: bytes onto a line and back, with noise on it and at another rate."""

from itertools import groupby

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.host.protocol import BAUD
from hdl.parts.uart import TOLERANCE, UartReceiver, UartTransmitter
from sim.kit.streams import check_rules, send
from sim.models.uart import UartHost


# Frames with edges everywhere, and nearly nowhere.
BYTES = [0x55, 0xAA, 0x00, 0xFF, 0x01, 0x80, 0x5A, 0xA5]


def receiver(bit_cycles=16):
    return UartReceiver(bit_cycles * BAUD)


def frame_levels(data, bit_cycles):
    """What the line shows in each cycle."""
    return [level for byte in data for level in (0, *(byte >> place & 1 for place in range(8)), 1) for _ in range(bit_cycles)]


def run_receiver(dut, levels):
    """Play levels, one a cycle, and take each byte at once; return bytes and framing errors."""
    taken, errors = [], []

    async def play(ctx):
        ctx.set(dut.o.ready, 1)
        for level, same in groupby([*levels, *[1] * 40]):
            ctx.set(dut.rx, level)
            await ctx.tick().repeat(len(list(same)))

    # Each is high for one cycle: to wake up for its changes is faster than to look at it in each cycle.
    async def take(ctx):
        async for valid, byte in ctx.changed(dut.o.valid).sample(dut.o.payload):
            if valid:
                taken.append(byte)

    async def note(ctx):
        async for error, in ctx.changed(dut.framing_error):
            errors.append(error)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(play)
    simulator.add_testbench(take, background=True)
    simulator.add_testbench(note, background=True)
    simulator.run()
    return taken, sum(errors)


def run_rules(dut, levels, *, ready=lambda cycle: True):
    """Play levels; ``ready`` tells for each cycle whether a byte is taken; return bytes, the cycles that took them, overruns."""
    taken, at = [], []
    overruns = 0

    async def play(ctx):
        nonlocal overruns
        for cycle, level in enumerate([*levels, *[1] * 40]):
            ctx.set(dut.rx, level)
            ctx.set(dut.o.ready, ready(cycle))
            _, _, overrun = await ctx.tick().sample(dut.overrun)
            overruns += overrun

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(play)
    simulator.add_testbench(check_rules(dut.o, taken, at), background=True)
    simulator.run()
    return taken, at, overruns


def host_levels(host, idle=1):
    """Levels of the host's line: ``idle`` bits of pause before and after what is queued."""
    levels = [1] * round(idle * host.bit_cycles)
    while not host.idle:
        levels.append(host.step(1))
    return levels + [1] * round(idle * host.bit_cycles)


@pytest.mark.parametrize("bit_cycles", [16, 24, 33])
@pytest.mark.parametrize("mismatch", [-TOLERANCE, 0.0, TOLERANCE])
def test_bytes(bit_cycles, mismatch):
    """All bit pairs, back to back, from a host that is too slow, right, and too fast; a pulse in about every third bit."""
    dut = receiver(bit_cycles)
    rng = np.random.default_rng(1)
    data = BYTES + rng.integers(0, 256, 24).tolist()
    host = UartHost(bit_cycles, mismatch=mismatch, rng=rng)
    # The model's edges fall on cycles: of a pulse as long as the filter removes, none is a cycle longer.
    host.send(data, pulses=0.3, pulse_bits=(dut.filtered_cycles - 0.5) / host.bit_cycles)
    assert run_receiver(dut, host_levels(host)) == (data, 0)


def test_all_bytes():
    data = np.random.default_rng(2).permutation(256).tolist()
    assert run_receiver(receiver(), frame_levels(data, 16)) == (data, 0)


@pytest.mark.parametrize("mismatch", [-0.045, 0.035])
def test_clean_line_has_more(mismatch):
    """Without noise a slow host has half a bit less a cycle of tolerance; a fast one, without a gap, the rest of the stop bit."""
    data = BYTES * 2
    host = UartHost(64, mismatch=mismatch)
    host.send(data)
    assert run_receiver(receiver(64), host_levels(host)) == (data, 0)


@pytest.mark.parametrize("mismatch", [-0.07, 0.07])
def test_wrong_rate_is_seen(mismatch):
    """The model is not so kind that any rate passes."""
    host = UartHost(64, mismatch=mismatch)
    host.send([0x00, 0x00, 0xFF, 0x55, 0x7F], gap=3)
    taken, framing_errors = run_receiver(receiver(64), host_levels(host))
    assert taken != [0x00, 0x00, 0xFF, 0x55, 0x7F]
    assert framing_errors or mismatch > 0


@pytest.mark.parametrize("bit_cycles, clock_hz, baud", [(651, 75_000_000, 115_200), (16, 16 * BAUD, BAUD), (40, 40.1 * BAUD, BAUD)])
def test_tolerance(bit_cycles, clock_hz, baud):
    """The derivation, once more. Half a bit less a cycle less two pulses, over 9.5 bits; 10 bits after the last sample; rounding."""
    dut = UartReceiver(clock_hz, baud)
    assert dut.bit_cycles == UartTransmitter(clock_hz, baud).bit_cycles == bit_cycles
    pulse = bit_cycles // 16
    assert dut.filtered_cycles == pulse
    slow = (bit_cycles / 2 - 1 - 2 * pulse) / (9.5 * bit_cycles)
    fast = 10 * bit_cycles / (9.5 * bit_cycles + bit_cycles // 8) - 1
    assert dut.tolerance == pytest.approx(min(slow, fast) - abs(bit_cycles / (clock_hz / baud) - 1))
    assert dut.tolerance >= TOLERANCE


@pytest.mark.parametrize("mismatch", [-TOLERANCE, TOLERANCE])
def test_pulse_at_every_place(mismatch):
    """A pulse of a sixteenth of a bit, in every cycle of a byte and of the silence around it, changes nothing."""
    dut = receiver()
    host = UartHost(16, mismatch=mismatch)
    host.send([0xB2])
    clean = host_levels(host, 0.5)
    levels: list = []
    for place in range(len(clean)):
        levels += [level ^ (at == place) for at, level in enumerate(clean)] + [1] * 3
    assert run_receiver(dut, levels) == ([0xB2] * len(clean), 0)


def test_longer_pulse_before_and_at_the_edge():
    """With more cycles a bit: pulses as long as the filter removes, at every place about the edge that opens a byte."""
    dut = receiver(64)
    host = UartHost(64, mismatch=TOLERANCE)
    host.send([0x7F])
    clean = host_levels(host)
    levels: list = []
    places = range(30, 80, 3)
    for place in places:
        levels += [level ^ (place <= at < place + dut.filtered_cycles) for at, level in enumerate(clean)]
    assert run_receiver(dut, levels) == ([0x7F] * len(places), 0)


@pytest.mark.parametrize("byte", [0x00, 0xFF])
def test_pulse_of_an_eighth_within_bits(byte):
    """Longer than what the filter removes: the majority does."""
    dut = receiver(64)
    clean = frame_levels([byte], 64)
    levels: list = []
    places = range(8, 56, 3)
    for place in places:
        levels += [level ^ (place <= at % 64 < place + 8) for at, level in enumerate(clean)] + [1] * 16
    assert run_receiver(dut, levels) == ([byte] * len(places), 0)


@pytest.mark.parametrize("bit_cycles", [16, 40])
def test_latency(bit_cycles):
    """From the start bit's edge: nine bits and 5/8 to the third sample of the stop bit, what the filter takes, and 4 cycles."""
    taken, at, _ = run_rules(receiver(bit_cycles), [1] * 10 + frame_levels([0xC4], bit_cycles))
    assert taken == [0xC4]
    assert at == [10 + 9 * bit_cycles + bit_cycles // 2 + bit_cycles // 8 + bit_cycles // 16 + 4]


def test_false_start():
    """A low of up to three eighths of a bit is no start bit, and a byte right after the check is received."""
    levels: list = []
    for length in range(1, 24):
        levels += [1] * 10 + [0] * length + [1] * (48 - length) + frame_levels([length], 64)
    assert run_receiver(receiver(64), levels) == (list(range(1, 24)), 0)


def test_after_reset():
    """The line counts as high: a byte is good wherever it begins."""
    for idle in range(1, 16, 2):
        host = UartHost(16, mismatch=-TOLERANCE)
        host.send([0x35])
        assert run_receiver(receiver(), host_levels(host, idle / 16)) == ([0x35], 0)


@pytest.mark.parametrize("low_bits", [1, 50])
def test_missing_stop_bit(low_bits):
    """A byte without a stop bit, and a line that is low for long: one error each, and the next byte is good."""
    broken = frame_levels([0x3C], 16)[:-16] + [0] * 16 * low_bits
    levels = frame_levels([0x11], 16) + broken + [1] * 16 + frame_levels([0x22], 16)
    assert run_receiver(receiver(), levels) == ([0x11, 0x22], 1)


def test_byte_that_nobody_takes():
    """The first one waits; those after it are lost, and counted."""
    data = [1, 2, 3, 4]
    levels = frame_levels(data, 16)
    taken, _, overruns = run_rules(receiver(), levels + [1] * 20, ready=lambda cycle: cycle > len(levels) + 10)
    assert (taken, overruns) == ([1], 3)


def test_byte_that_is_taken_in_time():
    """In the last cycle before the next byte: nothing is lost."""
    data = [1, 2, 3, 4]
    levels = frame_levels(data, 16)
    _, at, _ = run_rules(receiver(), levels)
    late = [*(cycle - 1 for cycle in at[1:]), at[-1] + 20]
    assert run_rules(receiver(), levels, ready=lambda cycle: cycle in late) == (data, late, 0)


@pytest.mark.parametrize("seed", range(2))
def test_after_noise(seed):
    """After noise of any kind and a byte's time of pause, bytes are received as they were sent."""
    rng = np.random.default_rng(seed)
    host = UartHost(20, rng=rng)
    for _ in range(6):
        host.send_noise(30)
        host.send_level(1, 11)
        host.send(BYTES)
        host.send_level(1, 2)
    taken, _ = run_receiver(receiver(20), host_levels(host))
    # Between the good ones there is what the receiver made of the noise.
    at = 0
    for _ in range(6):
        while taken[at:at + len(BYTES)] != BYTES:
            at += 1
            assert at < len(taken)
        at += len(BYTES)
    assert at == len(taken)


def run_transmitter(dut, data, *, rng, stall=0.0, cycles=0):
    """Send bytes; return the line in each cycle from the one after the first is taken, and the cycles in which they are taken."""
    line, taken, at = [], [], []

    async def feed(ctx):
        await send(ctx, dut.i, data, rng=rng, stall=stall)
        await ctx.tick().repeat(10 * dut.bit_cycles + cycles)

    async def watch(ctx):
        async for _, _, tx in ctx.tick().sample(dut.tx):
            line.append(tx)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(feed)
    simulator.add_testbench(watch, background=True)
    simulator.add_testbench(check_rules(dut.i, taken, at), background=True)
    simulator.run()
    assert taken == data
    assert all(line[:at[0] + 1])
    return line[at[0] + 1:], at


@pytest.mark.parametrize("bit_cycles", [16, 27])
def test_transmitter(bit_cycles):
    """Cycle by cycle: back to back bytes have no gap, and the line is high after them."""
    line, at = run_transmitter(UartTransmitter(bit_cycles * BAUD), BYTES, rng=np.random.default_rng(1), cycles=60)
    expected = frame_levels(BYTES, bit_cycles)
    assert line[:len(expected)] == expected
    assert all(line[len(expected):]) and len(line) > len(expected) + 50
    assert np.diff(at).tolist() == [10 * bit_cycles] * (len(BYTES) - 1)


def test_transmitter_with_gaps():
    """Gaps of any length: each byte begins in the cycle after it is taken, and the model receives them all."""
    data = np.random.default_rng(3).integers(0, 256, 12).tolist()
    line, at = run_transmitter(UartTransmitter(16 * BAUD), data, rng=np.random.default_rng(1), stall=0.995)
    expected = [1] * len(line)
    for byte, cycle in zip(data, at):
        expected[cycle - at[0]:cycle - at[0] + 160] = frame_levels([byte], 16)
    assert line == expected
    assert max(np.diff(at)) > 161
    host = UartHost(16)
    for level in line:
        host.step(level)
    assert list(host.received) == data and host.framing_errors == 0


@pytest.mark.parametrize("component", [UartReceiver, UartTransmitter])
@pytest.mark.parametrize("cycles, message", [(15, "15.00"), (16.49, "16.49")])
def test_bad_clock(component, cycles, message):
    with pytest.raises(ValueError, match=f"does not divide into {BAUD} baud: .*16 cycles or more.* not {message}; choose another baud$"):
        component(cycles * BAUD)
    component(16.02 * BAUD)


def test_model_hears():
    """The host's model is no better than a host: it counts bytes without a stop bit, and hears nothing in a short low."""
    host = UartHost(16)
    for level in [1] * 5 + frame_levels([0x47], 16) + frame_levels([0x48], 16)[:-16] + [0] * 16 + [1] * 20 + frame_levels([0x49], 16):
        host.step(level)
    assert (list(host.received), host.framing_errors) == ([0x47, 0x49], 1)

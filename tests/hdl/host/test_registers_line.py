# amaranth: UnusedElaboratable=no
"""hdl.host.registers behind its serial line: requests at rates that differ, and after noise."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import MatcherConfig, OnePass, changed
from golden.host.protocol import (
    BAUD,
    FRAME_BYTES,
    FRAME_SECONDS,
    REQUEST_SYNC,
    Operation,
    Reply,
    Request,
    Status,
    decode_reply,
    encode_request,
)
from golden.host.registers import Kind, register_map
from hdl.host.registers import SerialRegisters
from hdl.parts.uart import TOLERANCE
from sim.models.uart import SimulatedChip


REGISTERS = register_map(MatcherConfig(labels=20, method=changed(OnePass(), u1=1, u2=2, u3=3)))
READ_U1 = encode_request(Request(Operation.READ, REGISTERS["u1"].address))
FRAME_BITS = 30     # the time-out


def test_time_out_follows_the_clock():
    dut = SerialRegisters(REGISTERS, 75_000_000)
    Simulator(dut)
    assert dut.register_file.timeout == 75_000_000 * FRAME_SECONDS == 750_000
    assert dut.receiver.bit_cycles == dut.transmitter.bit_cycles == 651


def chip(**options):
    return SimulatedChip(REGISTERS, frame_seconds=FRAME_BITS / BAUD, **options)


def transact(chip, request):
    """The reply to a request on a good line; nothing else may be received."""
    chip.write(encode_request(request))
    data = chip.read(FRAME_BYTES, 3 * 10 * FRAME_BYTES / BAUD)
    return decode_reply(data)


@pytest.mark.parametrize("mismatch", [-TOLERANCE, TOLERANCE])
def test_line(mismatch):
    simulated = chip(mismatch=mismatch)
    simulated.status["pairs"] = 0x1234
    assert transact(simulated, Request(Operation.READ, REGISTERS["pairs"].address)).value == 0x1234
    for name, value in (("u1", 63), ("in_use", 5)):
        assert transact(simulated, Request(Operation.WRITE, REGISTERS[name].address, value)).status is Status.OK
        assert simulated.settings[name] == value
    assert transact(simulated, Request(Operation.WRITE, REGISTERS["in_use"].address, 21)).status is Status.OUT_OF_RANGE
    assert simulated.settings["in_use"] == 5
    assert transact(simulated, Request(Operation.WRITE, REGISTERS["restart_setup"].address, 1)).status is Status.OK
    assert simulated.actions == ["restart_setup"]
    assert transact(simulated, Request(Operation.READ, REGISTERS["uart_errors"].address)).value == 0
    assert simulated.line.framing_errors == 0


def bursts(rng, line):
    """One burst of each kind of noise."""
    yield lambda: line.send(rng.integers(0, 256, int(rng.integers(1, 12))).tolist())
    yield lambda: line.send([REQUEST_SYNC] * int(rng.integers(1, 8)))
    yield lambda: line.send(READ_U1[:int(rng.integers(1, 6))])
    yield lambda: line.send(READ_U1[:3], stop=0)
    yield lambda: line.send(READ_U1 * 2 + READ_U1[:int(rng.integers(1, 6))])       # a second request in the first one's reply
    yield lambda: line.send_noise(60)
    yield lambda: line.send_level(0, 25)
    yield lambda: line.send([REQUEST_SYNC, 0, 0, 0, 0, 0, REQUEST_SYNC, REQUEST_SYNC])


# Slow: the same bursts from another seed.
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_request_after_noise(seed):
    """After any burst, the time-out, and the reply that it may have caused, a good request is answered at once."""
    rng = np.random.default_rng(seed)
    simulated = chip(rng=rng)
    counted = 0
    for burst in bursts(rng, simulated.line):
        burst()
        simulated.line.send_level(1, FRAME_BITS + 10 * FRAME_BYTES + 1)
        while not simulated.line.idle:
            simulated.advance(16)
        simulated.line.received.clear()
        errors = transact(simulated, Request(Operation.READ, REGISTERS["uart_errors"].address))
        assert errors.status is Status.OK
        assert errors.value > counted     # each kind of noise shows
        counted = errors.value
    assert simulated.settings == {register.name: register.reset for register in REGISTERS.of(Kind.SETTING)}


def test_bytes_that_come_too_early():
    """While a reply is sent the first one waits, and begins no request then; the two after it are lost. All three are counted."""
    simulated = chip()
    simulated.write(READ_U1 + bytes(3))
    assert decode_reply(simulated.read(FRAME_BYTES, 2e-3)) == Reply(Status.OK, 0x10, 1)
    simulated.line.send_level(1, FRAME_BITS + 10)
    while not simulated.line.idle:
        simulated.advance(16)
    assert transact(simulated, Request(Operation.READ, REGISTERS["uart_errors"].address)).value == 3


def test_pulses_on_the_line_do_no_harm():
    rng = np.random.default_rng(5)
    simulated = SimulatedChip(REGISTERS, bit_cycles=32, rng=rng)
    for value in (5, 58):
        simulated.line.send(encode_request(Request(Operation.WRITE, 0x10, value)), pulses=0.7, pulse_bits=1.5 / 32)
        reply = decode_reply(simulated.read(FRAME_BYTES, 2e-3))
        assert reply == Reply(Status.OK, 0x10, value)
    assert transact(simulated, Request(Operation.READ, REGISTERS["uart_errors"].address)).value == 0

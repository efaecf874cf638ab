"""What a soak does to the system: disturbances drawn from a seed, as values that JSON has, and the smallest of them that still fail."""

import random
from collections.abc import Callable, Iterator
from typing import Any

from golden.host.protocol import Operation, Request, encode_request
from golden.host.registers import COUNT_MAX, Kind, Register, RegisterMap
from sim.benches.system_rig import NO_CLOCK, NO_SIGNAL
from sim.models.camera import FAULTS as CAMERA_FAULTS


__all__ = ["DOMAIN_RESET", "KINDS", "Disturbance", "Schedule", "draw", "first", "schedule", "smallest", "written"]


#: A disturbance: its ``kind``, one of :data:`KINDS`, and what belongs to that.
Disturbance = dict[str, Any]

#: Rounds, after each of which the accounts are settled.
Schedule = list[list[Disturbance]]

KINDS = ("faults", "reset", "writes", "pause")

#: Reset of a camera's domain, in place of faults in its frames.
DOMAIN_RESET = "domain reset"

# What may follow a camera's fault for whole frames.
_BEYOND = {"signal lost": NO_SIGNAL, "signal lost in noise": NO_SIGNAL, "clock stopped": NO_CLOCK}

#: Names of :data:`sim.benches.system_faults.FAULTS`: at the memory, and such as go with all others.
MEMORY_FAULTS = ("memory stalls for 100 us", "memory stalls for 400 us", "refreshes without end")
HOST_FAULTS = ("noise on the host's line", "video decoder does not acknowledge", "DVI transmitter does not acknowledge")

# Picoseconds: somewhat more than a frame of the smallest cameras.
_DELAY = 70_000_000
# Clocks of a reset: from what the FIFOs of the cameras need on.
_RESET_CLOCKS = 16, 600
# Clocks until the memory is initialised, mostly, and where its initialisation fails at first: some frames.
_INIT, _LATE_INIT = (1, 100), (10_000, 25_000)
# Writes at a time.
_WRITES = 3, 7


def _camera(rng: random.Random) -> list[str]:
    if rng.random() < 0.1:
        return [DOMAIN_RESET]
    name = rng.choice(list(CAMERA_FAULTS))
    return [name, *([_BEYOND[name]] * rng.randint(0, 3) if name in _BEYOND else [])]


def _faults(rng: random.Random) -> Disturbance:
    drawn: Disturbance = {"kind": "faults", "delay": rng.randrange(1, _DELAY)}
    if rng.random() < 0.2:
        # Alone: cameras that send nothing do not need the memory.
        return {**drawn, "memory": rng.choice(MEMORY_FAULTS)}
    sides = rng.choice((["left"], ["right"], ["left", "right"]))
    drawn |= {side: _camera(rng) for side in sides}
    if rng.random() < 0.3:
        drawn["host"] = rng.choice(HOST_FAULTS)
    return drawn


def _value(rng: random.Random, register: Register) -> int:
    """A value to write, legal or not."""
    if rng.random() < 0.4:
        return rng.randint(-2**15 if register.signed else 0, 2**15 - 1 if register.signed else COUNT_MAX)
    return rng.choice((register.minimum, register.maximum, rng.randint(register.minimum, register.maximum)))


def _request(rng: random.Random, registers: RegisterMap) -> str:
    """A request in hexadecimal: to a register that can be written, mostly."""
    kind = rng.random()
    if kind < 0.8:
        register = rng.choice(registers.of(Kind.SETTING, Kind.ACTION))
        return encode_request(Request(Operation.WRITE, register.address, register.encode(_value(rng, register)))).hex()
    address, value = rng.randrange(256), rng.randint(0, COUNT_MAX)
    if kind < 0.9:
        free = [address for address in range(256) if registers.at(address) is None]
        closed = [register.address for register in registers if not register.writable]
        return encode_request(Request(Operation.WRITE, rng.choice((rng.choice(free), rng.choice(closed))), value)).hex()
    if kind < 0.95:
        operation = rng.choice([code for code in range(256) if code not in set(Operation)])
        return encode_request(Request(operation, address, value)).hex()
    frame = encode_request(Request(Operation.WRITE, address, value))
    return (frame[:-1] + bytes([frame[-1] ^ rng.randint(1, 255)])).hex()


def draw(seed: int, registers: RegisterMap, count: int) -> list[Disturbance]:
    """So many disturbances of a seed; all writes are requests that this register map has, whichever registers it has."""
    rng = random.Random(seed)
    drawn = []
    for _ in range(count):
        kind = rng.choices(KINDS, (5, 2, 3, 1))[0]
        if kind == "faults":
            drawn.append(_faults(rng))
        elif kind == "reset":
            drawn.append({"kind": kind, "delay": rng.randrange(1, _DELAY), "clocks": rng.randint(*_RESET_CLOCKS),
                          "init": rng.randint(*(_LATE_INIT if rng.random() < 0.25 else _INIT)), "in_request": rng.random() < 0.3})
        elif kind == "writes":
            drawn.append({"kind": kind, "requests": [_request(rng, registers) for _ in range(rng.randint(*_WRITES))]})
        else:
            drawn.append({"kind": kind, "delay": rng.randrange(1, 4 * _DELAY), "hold": rng.random() < 0.5})
    return drawn


def schedule(seed: int, registers: RegisterMap, rounds: int, disturbances: int) -> Schedule:
    """So many rounds of so many disturbances each."""
    return [draw(seed * 1000 + number, registers, disturbances) for number in range(rounds)]


def written(done: Schedule, registers: RegisterMap) -> dict[str, list[bool]]:
    """By each register that can be written, whether the schedule writes a legal value to it, and an illegal one."""
    found = {register.name: [False, False] for register in registers.of(Kind.SETTING, Kind.ACTION)}
    for disturbance in (each for each_round in done for each in each_round):
        for frame in map(bytes.fromhex, disturbance.get("requests", [])):
            register = registers.at(frame[2])
            if frame[1] == Operation.WRITE and register and register.writable and sum(frame) % 256 == 0:
                legal = register.minimum <= register.decode(int.from_bytes(frame[3:5], "big")) <= register.maximum
                found[register.name][not legal] = True
    return found


def first(plan: Schedule, count: int) -> Schedule:
    """The rounds up to the one that has the disturbance of this number, counted from 1, and of that round what is up to it."""
    found: Schedule = []
    for each in plan:
        if count <= 0 and found:
            break
        found.append(each[:count])
        count -= len(each)
    return found


def _smaller(failing: Schedule) -> Iterator[Schedule]:
    """Schedules with less: one round, one disturbance, one of the faults of one, or one of its requests."""
    for number, each in enumerate(failing):
        others = failing[:number], failing[number + 1:]
        if len(failing) > 1:
            yield [*others[0], *others[1]]
        for at in range(len(each)):
            yield [*others[0], each[:at] + each[at + 1:], *others[1]]
        for at, disturbance in enumerate(each):
            parts = [name for name in ("left", "right", "host", "memory") if name in disturbance]
            less = [{key: value for key, value in disturbance.items() if key != part} for part in parts if len(parts) > 1]
            requests = disturbance.get("requests", [])
            less += [disturbance | {"requests": requests[:n] + requests[n + 1:]} for n in range(len(requests)) if len(requests) > 1]
            for smaller in less:
                yield [*others[0], [*each[:at], smaller, *each[at + 1:]], *others[1]]


def smallest(failing: Schedule, fails: Callable[[Schedule], bool], tries: int = 25) -> Schedule:
    """What is left of a failing schedule when everything is dropped without which it fails, too; after so many tries the least so far."""
    left = _smaller(failing)
    for _ in range(tries):
        candidate = next(left, None)
        if candidate is None:
            break
        if fails(candidate):
            failing, left = candidate, _smaller(candidate)
    return failing

"""Stream drivers, receiver and rule checker for cocotb 2; names as Amaranth's Verilog back end flattens them.

``rng`` is anything with a method ``random()``. Stalls are probabilities for each cycle. Time-outs count clocks *without a
transfer*. The design's clock is ``dut.clk``; the drivers start and end right after a rising edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from cocotb.triggers import ReadOnly, RisingEdge


if TYPE_CHECKING:
    from .streams import Random  # a simulator's Python need not load Amaranth


__all__ = ["TIMEOUT", "check_rules", "drain", "sink", "source"]


#: Clocks without a transfer.
TIMEOUT = 10_000


def _members(dut, name):
    """``payload``, ``valid``, ``ready`` of a stream."""
    return tuple(getattr(dut, f"{name}_{member}") for member in ("payload", "valid", "ready"))


def _bit(handle):
    """A handshake bit as a truth value; X and Z fail."""
    value = handle.value
    assert value.is_resolvable, f"{handle._path} is {value}"
    return value == 1


def _noise(payload, rng):
    """Random bits; a float has 53 of them, a payload may have thousands."""
    return sum(int(rng.random() * 2**32) << place for place in range(0, len(payload), 32)) % 2**len(payload)


async def source(dut: Any, name: str, words: Sequence[int], *, rng: Random, stall: float = 0.0, timeout: int = TIMEOUT) -> None:
    """Send ``words``, payloads packed to int, to the stream ``name``; each cycle before one is idle with probability ``stall``.

    In an idle cycle the payload is noise, so that a block that reads it without ``valid`` fails.
    """
    payload, valid, ready = _members(dut, name)
    for index, word in enumerate(words):
        while rng.random() < stall:
            payload.value = _noise(payload, rng)
            await RisingEdge(dut.clk)
        payload.value = word
        valid.value = 1
        for _ in range(timeout):
            await ReadOnly()
            taken = _bit(ready)
            await RisingEdge(dut.clk)
            if taken:
                break
        else:
            raise TimeoutError(f"{name}: word {index} of {len(words)} not accepted for {timeout} clocks")
        valid.value = 0
    payload.value = _noise(payload, rng)


async def sink(dut: Any, name: str, count: int, *, rng: Random, stall: float = 0.0, timeout: int = TIMEOUT) -> list[int]:
    """Accept ``count`` payloads, as ints, from the stream ``name``; ``ready`` is low in a cycle with probability ``stall``.

    With stalls, the first and the last word must be valid for a cycle before they are accepted: a block whose ``valid`` waits for
    ``ready`` then hangs, and this raises :class:`TimeoutError`.
    """
    payload, valid, ready = _members(dut, name)
    words: list[int] = []
    idle = 0
    offered = False
    while len(words) < count:
        must_see_valid = stall > 0 and not offered and len(words) in (0, count - 1)
        take = not must_see_valid and rng.random() >= stall
        ready.value = int(take)
        await ReadOnly()
        offer = _bit(valid)
        word = payload.value if offer and take else None
        await RisingEdge(dut.clk)
        offered = offer and not take
        if word is not None:
            assert word.is_resolvable, f"{name}: word {len(words)} is {word}"
            words.append(word.to_unsigned())
            idle = 0
        elif (idle := idle + 1) >= timeout:
            raise TimeoutError(f"{name}: {len(words)} of {count} words, then none for {timeout} clocks")
    ready.value = 0
    return words


async def drain(dut: Any, name: str, clocks: int = 64) -> list[int]:
    """Extra payloads of the stream ``name`` within ``clocks`` clocks: a correct block has none after its last word."""
    payload, valid, ready = _members(dut, name)
    ready.value = 1
    words = []
    for _ in range(clocks):
        await ReadOnly()
        if _bit(valid):
            words.append(payload.value.to_unsigned())
        await RisingEdge(dut.clk)
    ready.value = 0
    return words


async def check_rules(dut: Any, name: str, transfers: list[int] | None = None, clocks: list[int] | None = None) -> None:
    """Run in the background (``cocotb.start_soon``): a payload holds until accepted and is never X.

    Appends each transfer to ``transfers`` and its clock, counted from the start of the checker, to ``clocks``. Start it after the
    reset, with ``valid`` and ``ready`` driven.
    """
    payload, valid, ready = _members(dut, name)
    held = None
    clock = 0
    while True:
        await ReadOnly()
        offer, take = _bit(valid), _bit(ready)
        word = payload.value if offer else None
        if held is not None:
            assert offer, f"{name}: valid dropped before a transfer, clock {clock}"
            assert word == held, f"{name}: payload changed while stalled, clock {clock}: {held} -> {word}"
        if word is not None:
            assert word.is_resolvable, f"{name}: word valid at clock {clock} is {word}"
            if take:
                if transfers is not None:
                    transfers.append(word.to_unsigned())
                if clocks is not None:
                    clocks.append(clock)
        held = word if offer and not take else None
        await RisingEdge(dut.clk)
        clock += 1

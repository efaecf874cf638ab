"""Payloads as bits, against Amaranth's own constants."""

import random

import pytest
from amaranth.hdl import signed, unsigned
from amaranth.lib import data, enum

from sim.kit.payloads import pack, unpack


class Mode(enum.Enum, shape=2):  # type: ignore[call-arg]
    OFF = 0
    ON = 2


INNER = data.StructLayout({"x": range(11), "y": signed(5)})
LAYOUT = data.StructLayout({"flag": 1, "grey": 8, "inner": INNER, "costs": data.ArrayLayout(INNER, 3), "labels": data.ArrayLayout(7, 4),
                            "none": 0, "last": signed(9)})


def inner(rng):
    return {"x": rng.randrange(16), "y": rng.randrange(-16, 16)}


def payload(rng):
    return {"flag": rng.randrange(2), "grey": rng.randrange(256), "inner": inner(rng), "costs": [inner(rng) for _ in range(3)],
            "labels": [rng.randrange(128) for _ in range(4)], "none": 0, "last": rng.randrange(-256, 256)}


@pytest.mark.parametrize("seed", range(20))
def test_there_and_back(seed):
    word = payload(random.Random(seed))
    bits = LAYOUT.const(word).as_bits()
    assert pack(LAYOUT, word) == bits and unpack(LAYOUT, bits) == word
    assert pack(LAYOUT, LAYOUT.const(word)) == bits


def test_parts_of_a_payload():
    """What is not named is 0, what is too wide loses its upper bits; a name that the layout does not have is a mistake."""
    for word in ({}, {"grey": 300}, {"last": -300}, {"inner": {"y": -1}}, {"labels": [1, 200]}, {"flag": True}):
        assert pack(LAYOUT, word) == LAYOUT.const(word).as_bits()
    with pytest.raises(KeyError):
        pack(LAYOUT, {"gray": 1})


@pytest.mark.parametrize("shape, value, bits", [
    (unsigned(8), 255, 255), (8, 256, 0), (range(3), 2, 2), (signed(4), -1, 15), (Mode, Mode.ON, 2),
    (data.StructLayout({"m": Mode}), {"m": 2}, 2),
])
def test_shapes(shape, value, bits):
    assert pack(shape, value) == bits
    assert pack(shape, unpack(shape, bits)) == bits

"""Payloads as bits and as plain Python values.

Amaranth's constants do the same, field by field, at each call; in a test that looks at a payload in each clock they take longer than the
design takes to simulate.
"""

import functools
import operator
from collections.abc import Callable
from typing import Any

from amaranth.hdl import Const, Shape, ShapeCastable
from amaranth.lib import data


__all__ = ["pack", "unpack"]


@functools.cache
def _packer(shape: Any) -> Callable[[Any], int]:
    if not isinstance(shape, data.Layout):
        mask = (1 << Shape.cast(shape).width) - 1

        def number(value: Any) -> int:
            if isinstance(shape, ShapeCastable) and not isinstance(value, int):
                value = Const.cast(shape.const(value)).value
            return int(operator.index(value)) & mask
        return number
    fields = {key: (field.offset, _packer(field.shape)) for key, field in shape}

    def packed(value: Any) -> int:
        if not isinstance(value, dict | list):
            return int(Const.cast(shape.const(value)).value)
        bits = 0
        for key, part in value.items() if isinstance(value, dict) else enumerate(value):
            offset, inner = fields[key]
            bits |= inner(part) << offset
        return bits
    return packed


@functools.cache
def _unpacker(shape: Any) -> Callable[[int], Any]:
    if not isinstance(shape, data.Layout):
        plain = Shape.cast(shape)
        mask, sign = (1 << plain.width) - 1, 1 << plain.width - 1 if plain.signed else 0
        return lambda bits: ((bits & mask) ^ sign) - sign
    fields = [(key, field.offset, _unpacker(field.shape)) for key, field in shape]
    if all(isinstance(key, str) for key, *_ in fields):
        return lambda bits: {key: inner(bits >> offset) for key, offset, inner in fields}
    return lambda bits: [inner(bits >> offset) for _, offset, inner in fields]


def pack(shape: Any, payload: Any) -> int:
    """A payload as bits; fields that are not named are 0, and a value that is too wide loses its upper bits, as Amaranth's constants do."""
    return _packer(shape)(payload)


def unpack(shape: Any, bits: int) -> Any:
    """Bits as a dict by the names of the fields, a list of the parts of an array, or a number."""
    return _unpacker(shape)(bits)

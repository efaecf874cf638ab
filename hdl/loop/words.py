"""Words of the stores, and the ports to them: whatever pictures are stored in has these."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Member, Out, Signature

from golden.config import PIXEL_BITS, MatcherConfig
from golden.host.blocks import SENT_PLANES
from golden.host.loop_registers import result_bits

from ..matcher.stream import FLAGS


__all__ = ["FLAG_BITS", "PlacedResult", "ReadPort", "ReadRequest", "SentPixel", "StoredResult", "StoredWord", "Stores", "pass_on",
           "shown_known", "shown_label"]


#: Flags of a pixel that travel with its word.
FLAG_BITS = len(FLAGS)


class StoredResult(data.StructLayout):
    """A result as it is stored: the fields of :func:`golden.host.loop_registers.result_bits`."""
    def __init__(self, config: MatcherConfig):
        super().__init__({**result_bits(config)})


def shown_label(word: data.View, config: MatcherConfig) -> Value:
    """The whole label of a stored result."""
    return word.disparity[config.method.disparity_scale.bit_length() - 1:]  # the scale is a power of two


def shown_known(word: data.View, config: MatcherConfig) -> Value:
    """Whether the label of a stored result passed the check; 1 with methods that have none."""
    return word.passed if "passed" in config.result_fields else Const(1)


def pass_on(m: Module, members: Mapping[str, Member], inner: wiring.Component, outer: wiring.Component) -> None:
    """Connect members of a part to those of the same names of the whole."""
    for name, member in members.items():
        own, passed = getattr(inner, name), getattr(outer, name)
        if member.is_signature:
            wiring.connect(m, own, wiring.flipped(passed))
        else:
            m.d.comb += own.eq(passed) if member.flow is In else passed.eq(own)


class SentPixel(data.StructLayout):
    """A pixel from the host: ``plane`` 0 left, 1 right, and its place ``y * max_width + x``."""
    def __init__(self, depth: int):
        super().__init__({"plane": range(len(SENT_PLANES)), "address": range(depth), "level": PIXEL_BITS})


class PlacedResult(data.StructLayout):
    """A result and its place."""
    def __init__(self, config: MatcherConfig, depth: int):
        super().__init__({"address": range(depth), "result": StoredResult(config)})


class ReadRequest(data.StructLayout):
    """A place that is to be read: of both pictures, or of the ``results``; ``flags`` are returned with the word."""
    def __init__(self, depth: int):
        super().__init__({"address": range(depth), "results": 1, "flags": FLAG_BITS})


class StoredWord(data.StructLayout):
    """What is found at a place; the pictures or the result are undefined, whichever was not requested."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"left": PIXEL_BITS, "right": PIXEL_BITS, "result": StoredResult(config)})


class ReadPort(Signature):
    """Port to the stores, seen from a reader: ``found`` and ``flags`` are valid in the order of the requests, without back-pressure."""
    def __init__(self, config: MatcherConfig, depth: int):
        super().__init__({
            "request": Out(stream.Signature(ReadRequest(depth))),
            "valid": In(1), "found": In(StoredWord(config)), "flags": In(FLAG_BITS),
        })


class Stores(wiring.Component, ABC):
    """Stores for a pair and its results, one of which the system has: what all of them offer.

    Parameters
    ----------
    config : MatcherConfig
        ``max_width`` is the width of the stores.
    height : int
        Lines of the stores.
    outside : mapping
        Members that the system passes on to its board, by their names.

    Members
    -------
    busy : In(1)
        A pair is matched: ``scan`` and ``results`` are in use, otherwise ``write`` and ``read``.
    write : In(stream.Signature(SentPixel(depth)))
    scan, read : In(ReadPort(config, depth))
        A word that was accepted by ``write`` or ``results`` is found by all requests that are accepted later, and some cycles after
        ``results`` accepted its last one.
    results : In(stream.Signature(PlacedResult(config, depth)))
    """
    #: Pixels that ``scan`` reads ahead: those in flight, and the queue's that keeps the matcher busy.
    ahead: int
    #: In words, for people.
    about: str

    def __init__(self, config: MatcherConfig, height: int, outside: Mapping[str, Member]):
        self.config, self.height, self.outside = config, height, dict(outside)
        self.depth = depth = config.max_width * height
        super().__init__({
            "busy": In(1),
            "write": In(stream.Signature(SentPixel(depth))),
            "scan": In(ReadPort(config, depth)),
            "read": In(ReadPort(config, depth)),
            "results": In(stream.Signature(PlacedResult(config, depth))),
            **outside,
        })

    @abstractmethod
    def pair_clocks(self, width: int, height: int) -> int:
        """Bound of the clocks by which the stores delay a pair of that size."""

"""Payloads and bus of the video system. Both ends import them: ``connect()`` compares widths only."""

from amaranth.lib import data
from amaranth.lib.wiring import In, Out, Signature

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.memory_map import ADDRESS_BITS, WORD_BYTES

from ..matcher.stream import FLAGS


__all__ = ["ADDRESS_BITS", "WORD_BYTES", "CameraWord", "LocalBus", "PlanePixel", "ShownPixel"]


class CameraWord(data.StructLayout):
    """A pixel of a camera, fields one after the other: all lines of the top field, then all of the bottom field.

    ``first``: first of its frame; ``last``: last of its line; ``end``: last of its frame (then ``last`` is set too). With ``drop`` the
    word is no pixel: what came since ``first`` is to be dropped.
    """
    def __init__(self):
        super().__init__({"luma": PIXEL_BITS, "first": 1, "last": 1, "end": 1, "drop": 1})


class PlanePixel(data.StructLayout):
    """A pixel on its way into a picture in memory: a grey level or a disparity, in the order of lines."""
    def __init__(self):
        super().__init__({"value": PIXEL_BITS, **FLAGS})


class ShownPixel(data.StructLayout):
    """What the monitor may show of a pixel: its disparity and its grey level in the left picture.

    ``first``: first of its picture; ``last``: last of its line.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({"disparity": range(config.labels), "left": PIXEL_BITS, "first": 1, "last": 1})


class LocalBus(Signature):
    """Local interface of Altera's DDR2 high-performance controller (Avalon-MM), as its master sees it; addresses are of words.

    A request, ``read_req`` or ``write_req``, holds until ``ready``. ``burstbegin`` is high in the first cycle of each burst alone, even if
    ``ready`` is low then. Read data come in order, ``rdata_valid`` marks them, and cannot be held up. ``size`` is the burst's length in
    words; the controller generated for this board has bursts of one word, and then it is 1.
    """
    def __init__(self, *, size_bits: int = 1):
        self.size_bits = size_bits
        super().__init__({
            "address": Out(ADDRESS_BITS),
            "write_req": Out(1),
            "read_req": Out(1),
            "burstbegin": Out(1),
            "wdata": Out(8 * WORD_BYTES),
            "be": Out(WORD_BYTES),
            "size": Out(size_bits),
            "ready": In(1),
            "rdata": In(8 * WORD_BYTES),
            "rdata_valid": In(1),
            "init_done": In(1),
        })

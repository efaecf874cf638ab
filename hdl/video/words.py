"""Payloads and memory bus of the video system. Both ends of a stream import them, because ``connect()`` compares widths only."""

from amaranth.lib import data
from amaranth.lib.wiring import In, Out, Signature

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.memory_map import ADDRESS_BITS, WORD_BYTES

from ..matcher.stream import FLAGS


__all__ = ["ADDRESS_BITS", "WORD_BYTES", "CameraWord", "LocalBus", "PlanePixel", "ShownPixel"]


class CameraWord(data.StructLayout):
    """A pixel of a camera, field by field: all lines of the top field, then all of the bottom field.

    ``first``: first of its frame; ``last``: last of its line; ``end``: last of its frame (then ``last`` is set too). A word with ``drop``
    is not a pixel: the frame since ``first`` is abandoned.
    """
    def __init__(self) -> None:
        super().__init__({"luma": PIXEL_BITS, "first": 1, "last": 1, "end": 1, "drop": 1})


class PlanePixel(data.StructLayout):
    """A pixel of a picture to be stored: a grey level or a disparity, in raster order."""
    def __init__(self) -> None:
        super().__init__({"value": PIXEL_BITS, **FLAGS})


class ShownPixel(data.StructLayout):
    """A pixel of the picture that is shown: its disparity and its grey level in the left picture.

    ``first``: first of its picture; ``last``: last of its line.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({"disparity": range(config.labels), "left": PIXEL_BITS, "first": 1, "last": 1})


class LocalBus(Signature):
    """Local interface of a DDR2 controller (Avalon-MM, as of Altera's high-performance controller), seen from its master.

    Addresses count words. A request, ``read_req`` or ``write_req``, holds until ``ready``. ``burstbegin`` is high in the first cycle of
    each burst only, even if ``ready`` is low then. Read data are returned in order, marked by ``rdata_valid``, without back-pressure.
    ``size`` is the length of the burst in words; it is 1 for a controller with bursts of one word.
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

"""Payloads of the streams. Both ends import them: ``connect()`` compares widths only."""

from amaranth.lib import data

from golden.config import PIXEL_BITS, MatcherConfig


__all__ = ["FLAGS", "BecWord", "Column", "ColumnWord", "DisparityWord", "Least", "PixelPair", "copy_flags"]


#: ``first``: first word of its frame; ``last``: last of its line; ``end``: last of its frame (then ``last`` is set too).
FLAGS = {"first": 1, "last": 1, "end": 1}


class PixelPair(data.StructLayout):
    """A pixel of the left and of the right picture at the same place, in grey levels."""
    def __init__(self):
        super().__init__({"left": PIXEL_BITS, "right": PIXEL_BITS, **FLAGS})


class Column(data.StructLayout):
    """Pixels of three lines at the same ``x``, in grey levels: ``minus`` of line ``y-1``, ``line`` of ``y``, ``plus`` of ``y+1``."""
    def __init__(self):
        super().__init__({"minus": PIXEL_BITS, "line": PIXEL_BITS, "plus": PIXEL_BITS})


class ColumnWord(data.StructLayout):
    """The columns of both pictures at one ``x``; ``below``: the line below the picture, whose ``minus`` alone is a pixel of it."""
    def __init__(self):
        super().__init__({"left": Column(), "right": Column(), "below": 1, **FLAGS})


class BecWord(data.StructLayout):
    """What BEC knows of a pixel: ``E(x, y, d)`` for all ``d``, ``b(x, y)``, its grey level and that of the pixel above it (left)."""
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "cost": data.ArrayLayout(config.cost_bits, config.disparities),
            "local": range(config.disparities),
            "pixel": PIXEL_BITS,
            "upper": PIXEL_BITS,
            **FLAGS,
        })


class DisparityWord(data.StructLayout):
    """A disparity, in pixels."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"disparity": range(config.disparities), **FLAGS})


class Least(data.StructLayout):
    """A least energy so far, and its label."""
    def __init__(self, value, labels):
        super().__init__({"value": value, "index": range(labels)})


def copy_flags(target, source):
    """Assignments that copy the frame flags from one payload to another."""
    return [target[name].eq(source[name]) for name in FLAGS]

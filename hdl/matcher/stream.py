"""Payloads of the streams. Both ends import them: ``connect()`` compares widths only."""

from typing import Any

from amaranth.hdl import ShapeLike
from amaranth.lib import data

from golden.config import PIXEL_BITS, Fused, MatcherConfig


__all__ = ["FLAGS", "BecWord", "CensusWord", "Column", "ColumnWord", "DisparityWord", "LabelWord", "Least", "PixelPair", "copy_flags",
           "line_names"]


#: ``first``: first word of its frame; ``last``: last of its line; ``end``: last of its frame (then ``last`` is set too).
FLAGS = {"first": 1, "last": 1, "end": 1}


class PixelPair(data.StructLayout):
    """A pixel of the left and of the right picture at the same place, in grey levels."""
    def __init__(self):
        super().__init__({"left": PIXEL_BITS, "right": PIXEL_BITS, **FLAGS})


def line_names(rows: int) -> list[str]:
    """Names of the lines of a column from top to bottom: ``"minus2", "minus", "line", "plus", "plus2"`` for five."""
    reach = rows // 2
    above = [f"minus{n}" for n in range(reach, 1, -1)]
    return [*above, "minus", "line", "plus", *(name.replace("minus", "plus") for name in reversed(above))] if reach else ["line"]


class Column(data.StructLayout):
    """Pixels of neighbouring lines at the same ``x``, in grey levels: ``minus`` of line ``y-1``, ``line`` of ``y``, ``plus`` of ``y+1``.

    More than three lines go on with ``minus2`` of ``y-2`` and ``plus2`` of ``y+2``; the topmost comes first.
    """
    def __init__(self, rows: int = 3):
        super().__init__(dict.fromkeys(line_names(rows), PIXEL_BITS))


class ColumnWord(data.StructLayout):
    """The columns of both pictures at one ``x``; ``below``: a line below the picture, of which only what is above it is of the picture."""
    def __init__(self, rows: int = 3):
        super().__init__({"left": Column(rows), "right": Column(rows), "below": 1, **FLAGS})


class CensusWord(data.StructLayout):
    """A column of three lines, as :class:`ColumnWord`, and the census of both pictures at its middle pixel (not of a line below).

    ``above``, with vertical support only: the left pixel two lines above.
    """
    def __init__(self, config: MatcherConfig):
        bits = config.method_as(Fused).cost.neighbours
        above = {"above": PIXEL_BITS} if config.method_as(Fused).vertical else {}
        super().__init__({"left": Column(), "right": Column(), **above, "left_census": bits, "right_census": bits, "below": 1, **FLAGS})


class BecWord(data.StructLayout):
    """What BEC knows of a pixel: ``E(x, y, d)`` for all ``d``, ``b(x, y)``, its grey level and that of the pixel above it (left)."""
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "cost": data.ArrayLayout(config.method.matching_cost.bits, config.labels),
            "local": range(config.labels),
            "pixel": PIXEL_BITS,
            "upper": PIXEL_BITS,
            **FLAGS,
        })


class LabelWord(data.StructLayout):
    """A label on its way through the refinement, whether it passed the check, and the bit length of the support's size ``n``.

    ``label`` is in units of ``1 / config.method.disparity_scale`` pixel.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "label": range(config.labels * config.method.disparity_scale),
            "passed": 1,
            "size": range(config.method_as(Fused).arms.support_max.bit_length() + 1),
            **FLAGS,
        })


class DisparityWord(data.StructLayout):
    """The fields of :attr:`golden.config.MatcherConfig.result_fields`; ``disparity`` in units of ``1 / disparity_scale`` pixel."""
    def __init__(self, config: MatcherConfig):
        super().__init__({**config.result_fields, **FLAGS})


class Least(data.StructLayout):
    """A least energy so far, and its label."""
    def __init__(self, value: ShapeLike, labels: int):
        super().__init__({"value": value, "index": range(labels)})


def copy_flags(target: data.View, source: data.View) -> list[Any]:
    """Assignments that copy the frame flags from one payload to another."""
    return [target[name].eq(source[name]) for name in FLAGS]

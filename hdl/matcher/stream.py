"""Payloads of the streams. Both ends import them: ``connect()`` compares widths only."""

from typing import Any

from amaranth.hdl import ShapeLike, signed
from amaranth.lib import data

from golden.config import PIXEL_BITS, MatcherConfig


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

    With more than three lines also ``minus2`` of ``y-2``, ``plus2`` of ``y+2``, and so on; from top to bottom.
    """
    def __init__(self, rows: int = 3):
        super().__init__(dict.fromkeys(line_names(rows), PIXEL_BITS))


class ColumnWord(data.StructLayout):
    """The columns of both pictures at one ``x``; ``below``: of a line below the picture, where only lines above are in the picture."""
    def __init__(self, rows: int = 3):
        super().__init__({"left": Column(rows), "right": Column(rows), "below": 1, **FLAGS})


class CensusWord(data.StructLayout):
    """A column of three lines, as :class:`ColumnWord`, and the census of both pictures at its middle pixel, which is undefined if
    ``below``.

    ``above``, with vertical support only: the left pixel two lines above.
    """
    def __init__(self, config: MatcherConfig):
        bits = config.refined.cost.neighbours
        above = {"above": PIXEL_BITS} if config.refined.census_above else {}
        super().__init__({"left": Column(), "right": Column(), **above, "left_census": bits, "right_census": bits, "below": 1, **FLAGS})


class BecWord(data.StructLayout):
    """Result of BEC for a pixel: ``E(x, y, d)`` for all ``d``, ``b(x, y)``, and the left grey levels of the pixel and of the one above."""
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "cost": data.ArrayLayout(config.matching_cost.bits, config.labels),
            "local": range(config.labels),
            "pixel": PIXEL_BITS,
            "upper": PIXEL_BITS,
            **FLAGS,
        })


class LabelWord(data.StructLayout):
    """A label in the refinement, whether it passed the check, and the bit length ``size`` of its support's size.

    ``label`` is in units of ``1 / config.method.disparity_scale`` pixel. ``grey``, of methods whose refinement uses it only: the left
    grey level.
    """
    def __init__(self, config: MatcherConfig):
        grey = {"grey": PIXEL_BITS} if config.refined.refinement.USES_GREY else {}
        super().__init__({
            "label": range(config.labels * config.method.disparity_scale),
            "passed": 1,
            "size": range(config.refined.arms.support_max.bit_length() + 1),
            **grey,
            **FLAGS,
        })


class DisparityWord(data.StructLayout):
    """The fields of :attr:`golden.config.MatcherConfig.result_fields`; ``disparity`` in units of ``1 / disparity_scale`` pixel.

    ``disparity`` is signed in gateware that was built with a negative least disparity.
    """
    def __init__(self, config: MatcherConfig):
        shapes: dict[str, ShapeLike] = {**config.result_fields}
        if config.lead:
            shapes["disparity"] = signed(config.result_fields["disparity"])
        super().__init__({**shapes, **FLAGS})


class Least(data.StructLayout):
    """The least energy or cost of some labels, ``value``, and its label, ``index``."""
    def __init__(self, value: ShapeLike, labels: int):
        super().__init__({"value": value, "index": range(labels)})


def copy_flags(target: data.View, source: data.View) -> list[Any]:
    """Assignments that copy the frame flags from one payload to another."""
    return [target[name].eq(source[name]) for name in FLAGS]

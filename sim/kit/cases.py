"""Inputs and expected outputs of each block of the matcher, as payloads (dicts by member name) from the golden model.

The output of a stage is the input of the next one. Amaranth's simulator accepts payloads as dicts; a bench on Verilog packs them.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from amaranth.lib import data
from numpy.typing import NDArray

from golden.config import Fused, MatcherConfig
from golden.matcher.census import census
from golden.matcher.confidence import confidence
from golden.matcher.cost import aligned, cost_energy, local_disparity, matching_cost, sub_pixel_buffers, sub_pixels
from golden.matcher.fused import stages
from golden.matcher.lines import line_store
from golden.matcher.matcher import match
from golden.matcher.recursive.weighted_median import weighted_median
from golden.matcher.refine import median
from hdl.matcher.stream import line_names

from .payloads import pack, unpack


__all__ = ["bec_words", "bec_words_of", "between_frames", "buffers_words", "camera", "census_words", "checked_words", "column_words",
           "comparable", "cost_words", "disparity_words", "edata_words", "engine_words", "field_words", "fused_words", "label_words",
           "noise", "pixel_words", "refined_words", "sub_pixel_words", "weighted_words"]


# Names of the parts of a pixel, in the order of golden's arrays.
PARTS = ("pixel", "above", "below", "left")

# By member name.
Payload = dict[str, Any]


def noise(width: int, height: int, seed: int, pictures: int = 2) -> NDArray[np.int64]:
    """Random pictures, half of whose pixels are black or white, so that the greatest differences and equal neighbours occur."""
    rng = np.random.default_rng(seed)
    grey = rng.integers(0, 256, (pictures, height, width))
    return np.where(rng.random(grey.shape) < 0.5, rng.choice([0, 255], grey.shape), grey)


def _places(shape, beyond=0):
    """``(y, x, flags)`` in stream order; columns beyond the line have the flags of its last one."""
    height, width = shape
    for y in range(height):
        for x in range(width + beyond):
            last = x >= width - 1
            yield y, x, {"first": int(y == 0 and min(x, width - 1) == 0), "last": int(last), "end": int(last and y == height - 1)}


def pixel_words(left: NDArray[Any], right: NDArray[Any]) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.PixelPair`."""
    grey = {"left": np.asarray(left).tolist(), "right": np.asarray(right).tolist()}
    return [{**{side: picture[y][x] for side, picture in grey.items()}, **flags} for y, x, flags in _places(np.shape(left))]


def column_words(left: NDArray[Any], right: NDArray[Any], rows: int = 3) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.ColumnWord`."""
    lines = {side: line_store(picture, rows).tolist() for side, picture in (("left", left), ("right", right))}
    names = line_names(rows)
    return [{**{side: dict(zip(names, line[y][x])) for side, line in lines.items()}, "below": 0, **flags}
            for y, x, flags in _places(np.shape(left))]


def census_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.CensusWord`."""
    left_census, right_census = (census(picture, config.refined.cost).tolist() for picture in (left, right))
    above = {"above": line_store(left, 5)[..., 0].tolist()} if config.refined.census_above else {}
    return [{**word, "left_census": left_census[y][x], "right_census": right_census[y][x],
             **{name: picture[y][x] for name, picture in above.items()}}
            for (y, x, _), word in zip(_places(np.shape(left)), column_words(left, right))]


def engine_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of the streaming engine's input, method ``Fused``: :class:`hdl.matcher.stream.CensusWord`, with the padding lines below the
    picture."""
    left, right = aligned(left, right, config.minimum, config.lead)
    height, width = np.shape(left)
    words = [{**word, "end": 0} for word in census_words(left, right, config)]
    lines = 2 if config.refined.census_above else 1
    for below in range(lines):
        for x in range(width):
            last = int(x == width - 1)
            word: Payload = {"left_census": 0, "right_census": 0, "below": 1, "first": 0, "last": last, "end": last & (below == lines - 1)}
            word |= {side: {"minus": 0 if below else int(picture[-1][x]), "line": 0, "plus": 0}
                     for side, picture in (("left", left), ("right", right))}
            if config.method_as(Fused).vertical:
                word["above"] = int(left[-1 if below else max(height - 2, 0)][x])
            words.append(word)
    return words


def checked_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of the streaming engine's output, method ``Fused``: :class:`hdl.matcher.stream.LabelWord`."""
    result = stages(left, right, config)
    label = result.found.tolist()
    return [{"label": label[y][x], "passed": int(result.passed[y, x]), "size": int(result.support_size[y, x]).bit_length(), **flags}
            for y, x, flags in _places(np.shape(left))]


def field_words(fields: Mapping[str, NDArray[Any]]) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.DisparityWord` from the fields of a result."""
    parts = {name: values.tolist() for name, values in fields.items()}
    return [{**{name: int(part[y][x]) for name, part in parts.items()}, **flags}
            for y, x, flags in _places(np.shape(fields["disparity"]))]


def fused_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.DisparityWord`, method ``Fused``."""
    return field_words(match(left, right, config))


def _pixels(left, y, x):
    """Left pixel and the one above it."""
    x = min(x, len(left[0]) - 1)
    return {"pixel": int(left[y][x]), "upper": int(left[max(y - 1, 0)][x])}


def sub_pixel_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.sequential.cost.SubPixelWord`: one word more than pixels in each line."""
    parts = {side: dict(zip(PARTS, sub_pixels(picture, config))) for side, picture in (("left", left), ("right", right))}
    return [{**{side: {name: int(part[y, x]) for name, part in parts[side].items()} for side in parts},
             **_pixels(left, y, x), "beyond": int(x == np.shape(left)[1]), **flags} for y, x, flags in _places(np.shape(left), beyond=1)]


def _by_label(left, right, config):
    """Parts of the left picture, ``(H, W + 1, 1)``, and those of the right one for each label, ``(H, W + 1, D)``."""
    left_parts = [part[..., None] for part in sub_pixels(left, config)]
    right_parts = [np.stack([sub_pixel_buffers(line, config.labels) for line in part]) for part in sub_pixels(right, config)]
    return left_parts, right_parts


def _inside(x, config):
    return (1 << min(x + 1, config.labels_in_use)) - 1


def buffers_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.sequential.cost.BuffersWord`; see :func:`comparable`."""
    left_parts, right_parts = _by_label(left, right, config)
    return [{"left": {name: int(part[y, x, 0]) for name, part in zip(PARTS, left_parts)},
             "right": [{name: int(part[y, x, d]) for name, part in zip(PARTS, right_parts)} for d in range(config.labels)],
             "inside": _inside(x, config), **_pixels(left, y, x), "beyond": int(x == np.shape(left)[1]), **flags}
            for y, x, flags in _places(np.shape(left), beyond=1)]


def cost_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.sequential.cost.CostWord`; see :func:`comparable`."""
    costs = cost_energy(*_by_label(left, right, config))
    return [{"cost": [{name: int(cost[y, x, d]) for name, cost in zip(PARTS, costs)} for d in range(config.labels)],
             "inside": _inside(x, config), **_pixels(left, y, x), "beyond": int(x == np.shape(left)[1]), **flags}
            for y, x, flags in _places(np.shape(left), beyond=1)]


def edata_words(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.sequential.cost.EdataWord`."""
    cost = matching_cost(left, right, config)
    return [{"cost": cost[y, x].tolist(), **_pixels(left, y, x), **flags} for y, x, flags in _places(np.shape(left))]


def bec_words(cost: NDArray[Any], local: NDArray[Any], left: NDArray[Any], seed: int = 0) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.BecWord`; ``upper`` of the first line is noise, because nothing may depend on it."""
    rng = np.random.default_rng(seed)
    upper = np.vstack([rng.integers(0, 256, (1, np.shape(left)[1])), np.asarray(left)[:-1]])
    return [{"cost": cost[y, x].tolist(), "local": int(local[y, x]), "pixel": int(left[y, x]), "upper": int(upper[y, x]), **flags}
            for y, x, flags in _places(np.shape(left))]


def bec_words_of(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> list[Payload]:
    """Output of BEC for a pair of pictures, with edge replication above the first line."""
    cost = matching_cost(left, right, config)
    local = local_disparity(cost)
    return [{"local": int(local[y, x]), **word} for (y, x, _), word in zip(_places(np.shape(left)), edata_words(left, right, config))]


def disparity_words(labels: NDArray[Any]) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.DisparityWord`."""
    return [{"disparity": int(labels[y, x]), **flags} for y, x, flags in _places(np.shape(labels))]


def label_words(labels: NDArray[Any], passed: NDArray[Any], n: NDArray[Any], left: NDArray[Any] | None = None) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.LabelWord`, with ``grey`` where ``left`` is given."""
    return [{"label": int(labels[y, x]), "passed": int(passed[y, x]), "size": int(n[y, x]).bit_length(),
             **({} if left is None else {"grey": int(left[y, x])}), **flags} for y, x, flags in _places(np.shape(labels))]


def refined_words(filled: NDArray[Any], passed: NDArray[Any], n: NDArray[Any], config: MatcherConfig, *, enable: bool = True,
                  minimum: int = 0) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.DisparityWord`: the median of filled labels, with their confidence."""
    result = median(filled, config.method_as(Fused).refinement.median_size) if enable else filled
    return _refined(result, filled, passed, n, config, minimum)


def weighted_words(filled: NDArray[Any], passed: NDArray[Any], n: NDArray[Any], left: NDArray[Any], config: MatcherConfig, *,
                   enable: bool = True, minimum: int = 0) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.DisparityWord`: the weighted median of filled labels, with their confidence."""
    return _refined(weighted_median(filled, passed, left) if enable else filled, filled, passed, n, config, minimum)


def _refined(result, filled, passed, n, config, minimum):
    sure = confidence(result, filled, passed, n, config.method.disparity_scale)
    least = minimum * config.method.disparity_scale
    return [{"disparity": int(result[y, x]) + least, "passed": int(passed[y, x]), "confidence": int(sure[y, x]), **flags}
            for y, x, flags in _places(np.shape(filled))]


def camera(words: Sequence[Payload], *, rng: np.random.Generator, gaps: float = 0.0, line_gap: int = 1, before: int = 0,
           after: int = 0) -> list[tuple[int, ...]]:
    """Cycles of a camera that sends a frame: (frame valid, line valid, pixel valid, left, right).

    ``gaps``: probability of a cycle without a pixel inside a line. ``line_gap``: cycles of low line valid between lines. ``before``,
    ``after``: cycles of frame valid before the first pixel and after the last.
    """
    def blank(*signals):
        # Grey levels are noise without a pixel, and pixel valid without a line.
        frame_valid, line_valid = signals
        return frame_valid, line_valid, 0 if line_valid else int(rng.integers(2)), *rng.integers(0, 256, 2).tolist()

    cycles = [blank(1, 0) for _ in range(before)]
    for word in words:
        while rng.random() < gaps:
            cycles.append(blank(1, 1))
        cycles.append((1, 1, 1, word["left"], word["right"]))
        if word["last"] and not word["end"]:
            cycles += [blank(1, 0) for _ in range(line_gap)]
    return cycles + [blank(1, 0) for _ in range(after)]


def between_frames(cycles: int) -> list[tuple[int, ...]]:
    """Cycles in which frame valid is low and the other signals change."""
    return [(0, n & 1, n >> 1 & 1, 1, 2) for n in range(cycles)]


def comparable(word: Any, layout: data.Layout | None = None) -> Payload:
    """A payload in which the candidates that the word marks as outside the picture are ``None``: their values are undefined.

    ``layout`` unpacks bits, and checks that a payload fits it.
    """
    if layout is not None:
        word = unpack(layout, word if isinstance(word, int) else pack(layout, word))
    elif not isinstance(word, dict):
        word = unpack(word.shape(), word.as_bits())
    if "inside" not in word:
        return word
    key = "right" if "right" in word else "cost"
    return {**word, key: [value if word["inside"] >> d & 1 else None for d, value in enumerate(word[key])]}

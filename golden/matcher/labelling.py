"""The disparity rule (2-15): fast, and plain for reading."""

import numpy as np

from ..config import Arithmetic, MatcherConfig, OnePass
from .cost import local_disparity, matching_cost
from .smooth import slope, smooth


__all__ = ["cost_summation", "labelling", "labelling_plain", "match", "match_plain", "scan", "slopes", "transition"]


def slopes(left, config: MatcherConfig):
    """Slopes to the left, upper and lower neighbour of every pixel; 0 where the neighbour is outside the picture.

    Parameters
    ----------
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (3, H, W) ndarray
    """
    left = np.asarray(left, dtype=np.int32)
    horizontal = np.abs(np.diff(left, axis=1))
    vertical = np.abs(np.diff(left, axis=0))
    result = np.zeros((3, *left.shape), dtype=np.float64 if config.method.arithmetic is Arithmetic.FLOAT else np.int32)
    weights = config.rule.weights
    result[0, :, 1:] = slope(horizontal, weights.u1, config)
    result[1, 1:, :] = slope(vertical, weights.u2, config)
    result[2, :-1, :] = slope(vertical, weights.u3, config)
    return result


def scan(cost, local, weights, scale=1, shift=0):
    """Every pixel's label of least energy, given those of its left and upper neighbour: the fast core of the rule (2-15).

    ``f`` needs its left and its upper neighbour only, so all pixels of an anti-diagonal are computed at once. The energy is
    ``cost * scale`` plus ``(slope * |d - neighbour|) >> shift`` for each neighbour.

    Parameters
    ----------
    cost : (H, W, D) ndarray
    local : (H, W) integer ndarray
        Local disparities, labels: those of the lower neighbours enter the energy.
    weights : (3, H, W) ndarray
        Slopes to the left, upper and lower neighbour; 0 where it is outside the picture. float64 computes in float64.
    scale, shift : int

    Returns
    -------
    (H, W) int32 ndarray
        Labels ``0 .. D-1``.
    """
    height, width, labels = cost.shape
    number = np.float64 if np.result_type(weights) == np.float64 else np.int32
    # Row p holds |d - p| for every d: one gather gives the distances of all labels from a neighbour's.
    label = np.arange(labels)
    distance = np.abs(label - label[:, None]).astype(number)

    # A column of padding makes the step along an anti-diagonal of the flattened picture (stride - 1) positive for any width;
    # it is also the left neighbour of column 0, with a slope of zero.
    stride = width + 1
    padding = ((0, 0), (1, 0))
    below = np.zeros_like(local)
    below[:-1] = local[1:]
    below = np.pad(below, padding).ravel()
    weight = [np.pad(part, padding).ravel() for part in weights]
    result = np.zeros(stride * (height + 1), dtype=np.int32)  # the extra row is above the picture

    for diagonal in range(width + height - 1):
        y0, y1 = max(0, diagonal - width + 1), min(height - 1, diagonal)
        count = y1 - y0 + 1
        # Pixel (x, y) of the picture is at y*stride + x + 1; so is its upper neighbour in `result`.
        start = y0 * stride + (diagonal - y0) + 1
        at = slice(start, start + count * (stride - 1), stride - 1)
        source = slice(y0 * width + diagonal - y0, None, width - 1) if width > 1 else slice(y0, None)
        energy = cost.reshape(-1, labels)[source][:count].astype(number)
        energy *= scale
        centre = slice(start + stride, start + stride + count * (stride - 1), stride - 1)
        before = slice(centre.start - 1, centre.stop - 1, centre.step)
        for neighbour, w in zip((result[before], result[at], below[at]), weight, strict=True):
            term = distance[neighbour]
            term *= w[at, None]
            if shift:
                term >>= shift
            energy += term
        result[centre] = np.argmin(energy, axis=1)
    return result.reshape(height + 1, stride)[1:, 1:].copy()


def labelling(cost, local, left, config: MatcherConfig):
    """Disparity ``f(x, y)``, equation (2-15), of every pixel.

    Parameters
    ----------
    cost : (H, W, D) ndarray
        Of :func:`golden.matcher.cost.matching_cost`.
    local : (H, W) integer ndarray
        Of :func:`golden.matcher.cost.local_disparity`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W) int32 ndarray
        Labels ``0 .. D-1``.
    """
    # THESIS floors after the product with the disparity difference; the others' slopes are final.
    shift = 8 if config.method.arithmetic is Arithmetic.THESIS else 0
    return scan(cost, local, slopes(left, config), config.rule.energy_scale, shift)


def cost_summation(cost, s1, s2, s3, config: MatcherConfig):  # type: ignore[no-untyped-def]
    """The energy that rule (2-15) compares: matching cost and three smoothness terms.

    Parameters
    ----------
    cost, s1, s2, s3 : (..., D) ndarray
        Of :func:`golden.matcher.cost.matching_cost` and :func:`golden.matcher.smooth.smooth`.

    Returns
    -------
    (..., D) ndarray
        In units of the energy, at most ``config.energy_max``.
    """
    return np.asarray(cost, dtype=np.result_type(cost, np.int32)) * config.rule.energy_scale + s1 + s2 + s3


def transition(energy, slope):  # type: ignore[no-untyped-def]
    """The result for every label that the left neighbour may have: ``T(p) = argmin_d energy(d) + slope * |d - p|``.

    Evaluated directly; the smaller disparity on a tie. ``T`` is monotone and idempotent.

    Parameters
    ----------
    energy : (..., D) integer ndarray
        Of every label, without the smoothness against the left neighbour.
    slope : (...) integer ndarray
        Against the left neighbour.

    Returns
    -------
    (..., D) intp ndarray
        Pixels, for ``p = 0 .. D-1``.

    Examples
    --------
    >>> transition(np.array([4, 9, 0, 9]), 3).tolist()
    [0, 2, 2, 2]
    """
    energy = np.asarray(energy)
    label = np.arange(energy.shape[-1])
    distance = np.abs(label - label[:, None])
    return np.argmin(energy[..., None, :] + np.asarray(slope)[..., None, None] * distance, axis=-1)


def match(left, right, config: MatcherConfig):
    """Disparities of a rectified pair, by the method :class:`golden.config.OnePass`.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    (H, W) int32 ndarray
        Pixels, ``config.minimum .. config.minimum + D-1``.
    """
    config.method_as(OnePass)
    cost = matching_cost(left, right, config)
    return labelling(cost, local_disparity(cost), left, config) + config.minimum


def labelling_plain(cost, local, left, config: MatcherConfig):
    """:func:`labelling`, pixel by pixel: the rule for reading."""
    height, width, labels = cost.shape
    scale = config.rule.energy_scale
    result = np.zeros((height, width), dtype=np.int32)
    for y in range(height):
        for x in range(width):
            # (label of the neighbour, its grey level, weight); a neighbour outside the picture has no term.
            neighbours = []
            if x > 0:
                neighbours.append((result[y, x - 1], left[y, x - 1], config.rule.weights.u1))
            if y > 0:
                neighbours.append((result[y - 1, x], left[y - 1, x], config.rule.weights.u2))
            if y < height - 1:
                neighbours.append((local[y + 1, x], left[y + 1, x], config.rule.weights.u3))
            best = None
            for d in range(labels):
                energy = cost[y, x, d].item() * scale
                for f, grey, u in neighbours:
                    energy += smooth(abs(d - int(f)), abs(int(left[y, x]) - int(grey)), u, config)
                if best is None or energy < best:  # strictly less: ties stay with the smaller disparity
                    best, result[y, x] = energy, d
    return result


def match_plain(left, right, config: MatcherConfig):
    """:func:`match`, pixel by pixel, straight from the equations: for reading, and to test the fast version against."""
    height, width = np.shape(left)
    left, right = (np.asarray(side).astype(int).tolist() for side in (left, right))

    def pixel(picture, x, y, shift):
        # No column beyond the left picture's last one is ever compared.
        return picture[min(max(y, 0), height - 1)][min(max(min(x, width - 1) - shift, 0), width - 1)]

    def sub_pixel(picture, x, y, dx, dy, shift):
        total = pixel(picture, x, y, shift) + pixel(picture, x + dx, y + dy, shift)
        match config.method.arithmetic:
            case Arithmetic.FLOAT:
                return total * 0.5
            case Arithmetic.THESIS:
                return total >> 1
            case Arithmetic.LINEAR:
                return total

    def energy(x, y, d):
        if d + config.minimum > x or d >= config.labels_in_use:
            return config.matching_cost.outside
        return sum(
            abs(sub_pixel(left, x, y, dx, dy, 0) - sub_pixel(right, x - d, y, dx, dy, config.minimum))
            for dx, dy in ((0, 0), (0, -1), (0, 1), (-1, 0), (1, 0))
        )

    cost = np.array([[[energy(x, y, d) for d in range(config.labels)] for x in range(width)] for y in range(height)])
    local = np.array([[min(range(config.labels), key=line[x].__getitem__) for x in range(width)] for line in cost])
    return labelling_plain(cost, local, np.asarray(left), config) + config.minimum

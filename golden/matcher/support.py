"""The fused cost, the support of a pixel on its line, and the sums over it."""

import numpy as np

from ..config import FUSED_1, Arms, Fused, FusedCost, MatcherConfig
from .census import census, hamming
from .cost import delayed, matching_cost, outside, sub_pixel_buffers


__all__ = ["arms", "arms_plain", "fuse", "fused_cost", "support_sizes", "support_sums", "support_sums_plain"]


def fuse(cost, distance, params: FusedCost = FUSED_1.cost):
    """Fused cost ``C`` of a candidate inside the picture: ``(cost_factor * min(E, truncation) + census_weight * H) >> cost_shift``.

    The shift is a floor.

    Parameters
    ----------
    cost : integer ndarray
        Matching cost ``E`` in ``LINEAR`` arithmetic, of :func:`golden.matcher.cost.matching_cost`.
    distance : integer ndarray
        Hamming distance ``H``, of :func:`golden.matcher.census.hamming`.

    Returns
    -------
    uint8 ndarray
        At most ``params.maximum``.

    Examples
    --------
    >>> fuse(np.array([0, 3, 156, 2550]), np.array([0, 1, 34, 34])).tolist()
    [0, 3, 138, 138]
    """
    # Exact: the sum is below (COST_MAX + 1) << 7, which int16 holds.
    result = np.minimum(cost, params.truncation).astype(np.int16)
    result *= params.cost_factor
    result += np.asarray(distance, dtype=np.int16) * np.int16(params.census_weight)
    result >>= params.cost_shift
    return result.astype(np.uint8)


def fused_cost(left, right, config: MatcherConfig):
    """Fused cost ``C(x, y, d)`` of every pixel and label.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    (H, W, D) uint8 ndarray
        At most ``maximum`` of the cost; ``cost_outside`` where the right pixel lies outside the picture.
    """
    params = config.method_as(Fused).cost
    cost = matching_cost(left, right, config)
    left_bits, right_bits = census(left, params), census(delayed(right, config.minimum), params)
    beyond = outside(cost.shape[1], config)
    result = np.empty(cost.shape, dtype=np.uint8)
    for y in range(len(cost)):
        distance = hamming(left_bits[y, :, None], sub_pixel_buffers(right_bits[y], config.labels))
        result[y] = fuse(cost[y], distance, params)
        result[y][beyond] = params.cost_outside
    return result


def arms(left, params: Arms = FUSED_1.arms):
    """Arms of the support of every pixel: steps along the line over pixels that are like it.

    A step is taken while the pixel stepped on lies in the picture, differs from the centre by at most ``params.arm_threshold``, and the
    arm is no longer than ``params.reach``.

    Parameters
    ----------
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    l, r : (H, W) int16 ndarray
        Pixels, ``0 .. params.reach``: to the left and to the right.

    Examples
    --------
    >>> [arm.tolist() for arm in arms(np.array([[10, 20, 31, 21]]))]
    [[[0, 1, 0, 2]], [[1, 0, 1, 0]]]
    """
    left = np.asarray(left, dtype=np.int16)
    height, width = left.shape

    def steps(line):
        length = np.zeros((height, width), dtype=np.int16)
        alike = np.ones((height, width), dtype=bool)
        for step in range(1, min(params.reach, width - 1) + 1):
            alike[:, :step] = False
            alike[:, step:] &= np.abs(line[:, step:] - line[:, :-step]) <= params.arm_threshold
            length += alike
        return length

    return steps(left), steps(left[:, ::-1])[:, ::-1]


def support_sizes(l, r):
    """Number of pixels ``n`` of every support: both arms and the centre."""
    return l + r + 1


def support_sums(cost, l, r):
    """Support sums ``S(x, y, d)``: the costs of a label over ``x - l .. x + r``, as differences of a running sum along the line.

    Parameters
    ----------
    cost : (H, W, D) uint8 ndarray
        Of :func:`golden.matcher.vertical.vertical_support`.
    l, r : (H, W) integer ndarray
        Of :func:`arms`.

    Returns
    -------
    (H, W, D) int16 ndarray
        At most ``data_max`` of the method.
    """
    height, width, labels = cost.shape
    result = np.empty(cost.shape, dtype=np.int16)
    running = np.zeros((width + 1, labels), dtype=np.int32)
    column = np.arange(width)
    for y in range(height):
        np.cumsum(cost[y], axis=0, dtype=np.int32, out=running[1:])
        result[y] = running[column + r[y] + 1] - running[column - l[y]]
    return result


def arms_plain(left, params: Arms = FUSED_1.arms):
    """:func:`arms`, pixel by pixel: for reading, and to test the fast version against."""
    def arm(line, x, direction):
        length = 0
        while length < params.reach:
            stepped = x + direction * (length + 1)
            if not 0 <= stepped < len(line) or abs(line[stepped] - line[x]) > params.arm_threshold:
                break
            length += 1
        return length

    lines = np.asarray(left).tolist()
    return tuple(np.array([[arm(line, x, direction) for x in range(len(line))] for line in lines]) for direction in (-1, 1))


def support_sums_plain(cost, l, r):
    """:func:`support_sums`, pixel by pixel."""
    height, width, _ = cost.shape
    return np.array([[cost[y, x - l[y, x]:x + r[y, x] + 1].sum(axis=0, dtype=np.int64) for x in range(width)] for y in range(height)])

"""The fused cost, the support of a pixel on its line, and the sums over it."""

import numpy as np

from ..config import FUSED_1, Arms, FusedCost, MatcherConfig
from .census import census, hamming
from .cost import aligned, matching_cost, outside, sub_pixel_buffers


__all__ = ["arms", "arms_plain", "fuse", "fused_cost", "support_sizes", "support_sums", "support_sums_plain"]


def fuse(matching_cost, distance, cost: FusedCost = FUSED_1.cost):
    """Fused cost ``C`` of a candidate inside the picture: ``(cost_factor * min(E, truncation) + census_weight * H) >> cost_shift``.

    The shift is a floor; a cost above ``cost.cap`` is reduced to it.

    Parameters
    ----------
    matching_cost : integer ndarray
        ``E`` in ``LINEAR`` arithmetic, of :func:`golden.matcher.cost.matching_cost`.
    distance : integer ndarray
        Hamming distance ``H``, of :func:`golden.matcher.census.hamming`.

    Returns
    -------
    uint8 ndarray
        At most ``cost.maximum``.

    Examples
    --------
    >>> fuse(np.array([0, 3, 156, 2550]), np.array([0, 1, 34, 34])).tolist()
    [0, 3, 138, 138]
    """
    # Exact: the sum is below (FusedCost.MAX + 1) << 7, which int16 holds.
    result = np.minimum(matching_cost, cost.truncation).astype(np.int16)
    result *= cost.cost_factor
    result += np.asarray(distance, dtype=np.int16) * np.int16(cost.census_weight)
    result >>= cost.cost_shift
    return np.minimum(result, cost.cap).astype(np.uint8)


def fused_cost(left, right, config: MatcherConfig):
    """Fused cost ``C(x, y, d)`` of every pixel and label.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    (H, W, D) uint8 ndarray
        At most :attr:`golden.config.FusedCost.maximum`; ``cost_outside`` where the right pixel lies outside the picture.
    """
    cost = config.refined.cost
    energy = matching_cost(left, right, config)
    left_bits, right_bits = (census(side, cost) for side in aligned(left, right, config.minimum))
    beyond = outside(energy.shape[1], config)
    result = np.empty(energy.shape, dtype=np.uint8)
    for y in range(len(energy)):
        distance = hamming(left_bits[y, :, None], sub_pixel_buffers(right_bits[y], config.labels))
        result[y] = fuse(energy[y], distance[config.lead:], cost)
        result[y][beyond] = cost.cost_outside
    return result


def arms(left, limits: Arms = FUSED_1.arms):
    """Arms of the support of every pixel: the runs of similar pixels to its left and to its right on the scanline.

    An arm ends before the first pixel outside the picture or unlike the centre by more than ``limits.arm_threshold``, and after
    ``limits.reach`` pixels.

    Parameters
    ----------
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    left_arm, right_arm : (H, W) int16 ndarray
        Pixels, ``0 .. limits.reach``.

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
        for step in range(1, min(limits.reach, width - 1) + 1):
            alike[:, :step] = False
            alike[:, step:] &= np.abs(line[:, step:] - line[:, :-step]) <= limits.arm_threshold
            length += alike
        return length

    return steps(left), steps(left[:, ::-1])[:, ::-1]


def support_sizes(left_arm, right_arm):
    """Pixels of every support: both arms and the centre."""
    return left_arm + right_arm + 1


def support_sums(cost, left_arm, right_arm):
    """Support sums ``S(x, y, d)``: the costs of a label over ``x - left_arm .. x + right_arm``.

    Parameters
    ----------
    cost : (H, W, D) uint8 ndarray
        Of :func:`golden.matcher.vertical.vertical_support`.
    left_arm, right_arm : (H, W) integer ndarray
        Of :func:`arms`.

    Returns
    -------
    (H, W, D) int16 ndarray
        At most :attr:`golden.config.Fused.data_max`.
    """
    height, width, labels = cost.shape
    result = np.empty(cost.shape, dtype=np.int16)
    running = np.zeros((width + 1, labels), dtype=np.int32)
    column = np.arange(width)
    for y in range(height):  # differences of a running sum
        np.cumsum(cost[y], axis=0, dtype=np.int32, out=running[1:])
        result[y] = running[column + right_arm[y] + 1] - running[column - left_arm[y]]
    return result


def arms_plain(left, limits: Arms = FUSED_1.arms):
    """:func:`arms`, pixel by pixel: for reading, and to test the fast version against."""
    def arm(line, x, direction):
        length = 0
        while length < limits.reach:
            stepped = x + direction * (length + 1)
            if not 0 <= stepped < len(line) or abs(line[stepped] - line[x]) > limits.arm_threshold:
                break
            length += 1
        return length

    lines = np.asarray(left).tolist()
    return tuple(np.array([[arm(line, x, direction) for x in range(len(line))] for line in lines]) for direction in (-1, 1))


def support_sums_plain(cost, left_arm, right_arm):
    """:func:`support_sums`, pixel by pixel."""
    height, width, _ = cost.shape
    return np.array([[cost[y, x - left_arm[y, x]:x + right_arm[y, x] + 1].sum(axis=0, dtype=np.int64) for x in range(width)]
                     for y in range(height)])

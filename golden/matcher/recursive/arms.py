"""The support of a pixel: arms with limits that get tighter with the distance; means over it by a reciprocal."""

import numpy as np

from ...config import RECURSIVE_1, GradedArms


__all__ = ["graded_arms", "graded_arms_plain", "reciprocals", "support_means", "support_means_plain"]


def graded_arms(left, limits: GradedArms = RECURSIVE_1.arms):
    """Arms of the support of every pixel, to its left and to its right on the scanline.

    A step is taken while the pixel stepped on is in the picture, differs from the centre by at most ``near_threshold``, from step
    ``far_step`` on ``far_threshold``, and from the pixel stepped from by at most ``step_threshold``; at most ``reach`` steps.

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
    >>> [arm.tolist() for arm in graded_arms(np.array([[10, 16, 17, 24]]))]
    [[[0, 1, 2, 0]], [[2, 1, 0, 0]]]
    """
    left = np.asarray(left, dtype=np.int16)
    height, width = left.shape

    def steps(line):
        length = np.zeros((height, width), dtype=np.int16)
        smooth = np.abs(np.diff(line, axis=1)) <= limits.step_threshold
        taken = np.ones((height, width), dtype=bool)
        for step in range(1, min(limits.reach, width - 1) + 1):
            threshold = limits.near_threshold if step < limits.far_step else limits.far_threshold
            taken[:, :step] = False
            taken[:, step:] &= (np.abs(line[:, step:] - line[:, :-step]) <= threshold) & smooth[:, :width - step]
            length += taken
        return length

    return steps(left), steps(left[:, ::-1])[:, ::-1]


def reciprocals(support_size):
    """Reciprocals of the pixels of supports, ``1024 // n``: ten fraction bits, floor."""
    return (1 << GradedArms.RECIPROCAL_BITS) // np.asarray(support_size)


def support_means(cost, left_arm, right_arm):
    """Means of costs over the supports of a line, ``rec * sum >> 10`` with the reciprocal ``rec``: twice a floor.

    Parameters
    ----------
    cost : (W, D) integer ndarray
        Of one line.
    left_arm, right_arm : (W,) integer ndarray
        Of :func:`graded_arms`.

    Returns
    -------
    (W, D) int32 ndarray
        At most the greatest cost.
    """
    width, labels = cost.shape
    running = np.zeros((width + 1, labels), dtype=np.int32)
    np.cumsum(cost, axis=0, dtype=np.int32, out=running[1:])
    column = np.arange(width)
    sums = running[column + right_arm + 1]
    sums -= running[column - left_arm]
    sums *= reciprocals(left_arm + right_arm + 1).astype(np.int32)[:, None]
    sums >>= GradedArms.RECIPROCAL_BITS
    return sums


def graded_arms_plain(left, limits: GradedArms = RECURSIVE_1.arms):
    """:func:`graded_arms`, pixel by pixel: for reading, and to test the fast version against."""
    def arm(line, x, direction):
        length = 0
        while length < limits.reach:
            before, stepped = x + direction * length, x + direction * (length + 1)
            threshold = limits.near_threshold if length + 1 < limits.far_step else limits.far_threshold
            if not 0 <= stepped < len(line) or abs(line[stepped] - line[x]) > threshold \
                    or abs(line[stepped] - line[before]) > limits.step_threshold:
                break
            length += 1
        return length

    lines = np.asarray(left).tolist()
    return tuple(np.array([[arm(line, x, direction) for x in range(len(line))] for line in lines]) for direction in (-1, 1))


def support_means_plain(cost, left_arm, right_arm):
    """:func:`support_means`, pixel by pixel."""
    return np.array([[
        int(cost[x - left_arm[x]:x + right_arm[x] + 1, d].sum()) * (1024 // int(left_arm[x] + right_arm[x] + 1)) >> 10
        for d in range(cost.shape[1])] for x in range(len(cost))])

"""An order of points in which every half, quarter and so on of them lies together in a box.

A heap-ordered tree over it has boxes that hardly overlap, unlike one over Morton order: halves of
that end anywhere along the curve.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["order_by_halving"]


@kernel
def _select(centres, order, low, high, middle, axis):
    """Move the points [low, high) so that the least along the axis fill [low, middle).

    Of equal ones those with the lower numbers come first.
    """
    left, right = low, high - 1
    while left < right:
        at = (left + right) // 2
        pivot, number = centres[at, axis], order[at]
        i, j = left, right
        while i <= j:
            while centres[i, axis] < pivot or (centres[i, axis] == pivot and order[i] < number):
                i += 1
            while centres[j, axis] > pivot or (centres[j, axis] == pivot and order[j] > number):
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                for k in range(3):
                    centres[i, k], centres[j, k] = centres[j, k], centres[i, k]
                i += 1
                j -= 1
        if middle <= j:
            right = j
        elif middle >= i:
            left = i
        else:
            return


@kernel
def order_by_halving(centres, n_leaves, leaf_size, order):
    """Sort points into the leaves of a heap-ordered tree, halving boxes across their longest side.

    Parameters
    ----------
    centres : (T, 3) float32
        Sorted in place as well.
    n_leaves : int
        A power of two.
    leaf_size : int
        Points to each leaf; the leaves on the left are full.
    order : (T,) int32
        The points' numbers; sorted in place.
    """
    total = order.shape[0]
    size = n_leaves * leaf_size
    low_corner, high_corner = np.empty(3, np.float32), np.empty(3, np.float32)
    while size > leaf_size:
        half = size // 2
        for low in range(0, total, size):
            high = min(low + size, total)
            if high - low <= half:
                continue
            low_corner[:] = np.inf
            high_corner[:] = -np.inf
            for k in range(low, high):
                for axis in range(3):
                    value = centres[k, axis]
                    low_corner[axis] = min(low_corner[axis], value)
                    high_corner[axis] = max(high_corner[axis], value)
            axis = np.argmax(high_corner - low_corner)
            _select(centres, order, low, high, low + half, axis)
        size = half

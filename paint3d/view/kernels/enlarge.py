"""Pictures spread over more pixels than they have."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["enlarge"]

_APART = np.uint64(0x00FF00FF00FF00FF)  # red, blue, green and alpha, each in sixteen bits
_HALF = np.uint64(0x0080008000800080)
_WHOLE = np.uint64(256)
_FOUR, _EIGHT = np.uint64(24), np.uint64(8)


@kernel
def enlarge(small, rows, down, columns, across, mixed, large):
    """Write each pixel as the mean of the four nearest, by how near they are (bilinear).

    The four channels of a pixel are reckoned with side by side in one number.

    Parameters
    ----------
    small : (h, w) uint32
        Four channels of eight bits, the first row at the bottom.
    rows, columns : (H,), (W,) int32
        For each pixel of the large picture, from the bottom and from the left, the lower row and
        the left column that it lies between.
    down, across : (H,), (W,) int32
        How far it lies toward the next ones, of 256.
    mixed : (w + 1,) uint64
        Worked in.
    large : (H, W) uint32
        Written; the first row at the top.
    """
    height, width = small.shape
    last = large.shape[0] - 1
    for y in range(large.shape[0]):
        low = rows[y]
        high = low + 1 if low + 1 < height else low
        to_high = np.uint64(down[y])
        to_low = _WHOLE - to_high
        for x in range(width):
            p, q = np.uint64(small[low, x]), np.uint64(small[high, x])
            p, q = (p | (p << _FOUR)) & _APART, (q | (q << _FOUR)) & _APART
            mixed[x] = ((p * to_low + q * to_high + _HALF) >> _EIGHT) & _APART
        mixed[width] = mixed[width - 1]
        for x in range(large.shape[1]):
            k, weight = columns[x], np.uint64(across[x])
            both = mixed[k] * (_WHOLE - weight) + mixed[k + 1] * weight + _HALF
            both = (both >> _EIGHT) & _APART
            large[last - y, x] = np.uint32(both | (both >> _FOUR))

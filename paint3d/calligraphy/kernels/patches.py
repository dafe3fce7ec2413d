"""Patches of a mask: which pixels hang together, and how deep each lies within."""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["fill_depths", "label_patches"]


@kernel
def fill_depths(mask, out):
    """Distance of every pixel of a mask to the nearest that does not belong to it, in pixels.

    Parameters
    ----------
    mask : (H, W) bool
        Beyond its rim nothing is known. At least one pixel does not belong to it.
    out : (H, W) float64
        Filled; 0 outside of the mask.

    Notes
    -----
    Exact: first along columns, then along rows as far as it can get nearer; the time of a pixel
    grows with its distance.
    """
    rows, columns = mask.shape
    far = rows + columns
    along = np.empty((rows, columns), np.int64)
    for j in range(columns):
        apart = far
        for i in range(rows):
            apart = apart + 1 if mask[i, j] else 0
            along[i, j] = min(apart, far)
        apart = far
        for i in range(rows - 1, -1, -1):
            apart = apart + 1 if mask[i, j] else 0
            along[i, j] = min(along[i, j], apart)
    for i in range(rows):
        for j in range(columns):
            square = along[i, j] ** 2
            aside = 1
            while aside * aside < square:
                if j >= aside:
                    square = min(square, along[i, j - aside] ** 2 + aside * aside)
                if j + aside < columns:
                    square = min(square, along[i, j + aside] ** 2 + aside * aside)
                aside += 1
            out[i, j] = math.sqrt(square)


@kernel
def label_patches(mask, out):
    """Number the patches of a mask (H, W) from 1 on, as they are met row by row; 0 is no patch.

    Pixels hang together that have a side in common. Returns how many patches there are.
    """
    rows, columns = mask.shape
    out[:] = 0
    waiting = np.empty(rows * columns, np.int64)
    n = 0
    for start in range(rows * columns):
        if not mask[start // columns, start % columns] or out[start // columns, start % columns]:
            continue
        n += 1
        out[start // columns, start % columns] = n
        waiting[0] = start
        left = 1
        while left:
            left -= 1
            i, j = waiting[left] // columns, waiting[left] % columns
            for way in range(4):
                row = i + (way == 0) - (way == 1)
                column = j + (way == 2) - (way == 3)
                if row < 0 or row == rows or column < 0 or column == columns:
                    continue
                if mask[row, column] and not out[row, column]:
                    out[row, column] = n
                    waiting[left] = row * columns + column
                    left += 1
    return n

"""Rasters: polygons and painted triangles at the samples of a square grid.

A raster of H by W samples has sample (i, j) at (x, y) = (j + 0.5, i + 0.5) of its own units.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.core.kernel import kernel

__all__ = [
    "fill_depths",
    "fill_polygon",
    "fill_triangles",
    "first_sample",
    "label_patches",
    "last_sample",
]


@kernel
def first_sample(low):
    """Index of the first sample at or above a coordinate."""
    return math.ceil(low - 0.5)


@kernel
def last_sample(high):
    """Index of the last sample below a coordinate."""
    return math.ceil(high - 0.5) - 1


@kernel
def fill_polygon(polygon, out):
    """Set the samples inside a closed polygon (N, 2), by the non-zero rule.

    Parameters
    ----------
    polygon : (N, 2) float64
        Sample units.
    out : (H, W) bool
    """
    n = polygon.shape[0]
    crossings, turns = np.empty(n), np.empty(n, np.int64)
    top = min(out.shape[0] - 1, last_sample(polygon[:, 1].max()))
    for i in range(max(0, first_sample(polygon[:, 1].min())), top + 1):
        y = i + 0.5
        count = 0
        for k in range(n):
            px, py = polygon[k - 1, 0], polygon[k - 1, 1]
            qx, qy = polygon[k, 0], polygon[k, 1]
            if (py <= y) != (qy <= y):
                crossings[count] = px + (y - py) / (qy - py) * (qx - px)
                turns[count] = 1 if qy > py else -1
                count += 1
        order = np.argsort(crossings[:count])
        winding = 0
        for k in range(count - 1):
            winding += turns[order[k]]
            if winding != 0:
                first = max(0, first_sample(crossings[order[k]]))
                last = min(out.shape[1] - 1, last_sample(crossings[order[k + 1]]))
                out[i, first : last + 1] = True


@kernel
def fill_triangles(points, values, faces, out):
    """Interpolate vertex values over triangles, at the samples inside them.

    Parameters
    ----------
    points : (V, 2) float64
        Vertices, sample units; a triangle with one that is not finite is left out.
    values : (V,) float32
    faces : (F, 3) int32
    out : (H, W) float32
    """
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay = points[a, 0], points[a, 1]
        bx, by = points[b, 0], points[b, 1]
        cx, cy = points[c, 0], points[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not abs(area) > 1e-12:
            continue
        low = max(0, first_sample(min(ay, by, cy)))
        high = min(out.shape[0] - 1, last_sample(max(ay, by, cy)))
        left = max(0, first_sample(min(ax, bx, cx)))
        right = min(out.shape[1] - 1, last_sample(max(ax, bx, cx)))
        for i in range(low, high + 1):
            for j in range(left, right + 1):
                x, y = j + 0.5 - ax, i + 0.5 - ay
                u = (x * (cy - ay) - y * (cx - ax)) / area
                v = (y * (bx - ax) - x * (by - ay)) / area
                if u >= -1e-9 and v >= -1e-9 and u + v <= 1.0 + 2e-9:
                    out[i, j] = (1.0 - u - v) * values[a] + u * values[b] + v * values[c]


# ---- Patches of a mask ---------------------------------------------------------------------------
# Patches of a mask: which pixels hang together, and how deep each lies within.


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

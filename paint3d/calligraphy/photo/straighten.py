"""A sheet in a photograph laid flat: the projective map of its four corners.

The sheet's own proportions follow from the four corners and the picture's middle, where the
camera's axis is taken to go through (Zhang and He, *Whiteboard scanning and image enhancement*,
2007, section 3): with the homography from the unit square H = (h1, h2, h3), corners counted from
the middle, the focal length is f^2 = -(h1x h2x + h1y h2y) / (h1z h2z), and the ratio of the sides
is |diag(1/f, 1/f, 1) h1| / |diag(1/f, 1/f, 1) h2|.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = ["homography", "linear_light", "map_points", "sheet_size", "straightened"]

_FLAT = 0.02  # of perspective: below it the focal length says nothing
_FOCAL = (0.4, 6.0)  # longer sides of the picture: focal lengths that cameras have
_SLIMMEST = 12.0  # ratio of the sides
_ROWS = 256  # that are looked up at once: bounds the memory


def linear_light(codes: AnyArray) -> NDArray[np.float32]:
    """Linear values, 0 to 1, of sRGB codes (uint8) (IEC 61966-2-1)."""
    value = np.arange(256) / 255.0
    table = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    result: NDArray[np.float32] = table.astype(np.float32)[codes]
    return result


def homography(start: AnyArray, end: AnyArray) -> NDArray[np.float64]:
    """The projective map (3, 3) that carries four points (4, 2) to four others."""
    rows, right = [], []
    for (x, y), (u, v) in zip(start, end, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        right += [u, v]
    solved = np.linalg.solve(np.array(rows, np.float64), np.array(right, np.float64))
    return np.append(solved, 1.0).reshape(3, 3)


def map_points(matrix: AnyArray, points: AnyArray) -> NDArray[np.float64]:
    """Points (N, 2) under a projective map."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    result: NDArray[np.float64] = mapped[:, :2] / mapped[:, 2:]
    return result


def sheet_size(corners: AnyArray, shape: tuple[int, int], longest: int) -> tuple[int, int]:
    """Height and width, pixels, that a sheet is laid flat in.

    Parameters
    ----------
    corners : (4, 2) float64
        In the picture, pixels: upper left, upper right, lower right, lower left.
    shape : (int, int)
        Height and width of the picture.
    longest : int
        Of the longer side; less where the picture shows no more.
    """
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    ratio = _ratio(corners, shape) or float((sides[0] + sides[2]) / (sides[1] + sides[3]))
    ratio = min(max(ratio, 1.0 / _SLIMMEST), _SLIMMEST)
    long = min(longest, round(float(sides.max())))
    width, height = (long, long / ratio) if ratio > 1.0 else (long * ratio, long)
    return max(8, round(height)), max(8, round(width))


def _ratio(corners: AnyArray, shape: tuple[int, int]) -> float | None:
    """Width over height of a sheet, where the perspective is strong enough to tell."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    size = max(shape)
    matrix = homography(square, (corners - 0.5 * np.array(shape[::-1])) / size)
    h1, h2 = matrix[:, 0], matrix[:, 1]
    if abs(h1[2]) < _FLAT or abs(h2[2]) < _FLAT:
        return None
    focal2 = -(h1[0] * h2[0] + h1[1] * h2[1]) / (h1[2] * h2[2])
    if not _FOCAL[0] ** 2 < focal2 < _FOCAL[1] ** 2:
        return None
    scale = np.array([focal2, focal2, 1.0])
    return math.sqrt(float((h1**2 / scale).sum() / (h2**2 / scale).sum()))


def straightened(
    pixels: NDArray[np.uint8], corners: AnyArray, size: tuple[int, int]
) -> NDArray[np.float32]:
    """A sheet laid flat, in linear light.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
        sRGB codes.
    corners : (4, 2) float64
        As for `sheet_size`; pixel (i, j) of the picture lies at (j + 0.5, i + 0.5).
    size : (int, int)
        Height and width.

    Returns
    -------
    (height, width, 3) float32
    """
    from scipy.ndimage import gaussian_filter, map_coordinates

    height, width = size
    flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float64)
    matrix = homography(flat, corners)
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    shrink = float(sides.max()) / max(height, width)
    out = np.empty((height, width, 3), np.float32)
    x = np.arange(width) + 0.5
    for channel in range(3):
        plane = linear_light(pixels[..., channel])
        if shrink > 1.2:  # what the new pixels could not show
            plane = gaussian_filter(plane, 0.4 * math.sqrt(shrink**2 - 1.0), truncate=3.0)
        for first in range(0, height, _ROWS):
            rows = np.arange(first, min(first + _ROWS, height)) + 0.5
            places = np.stack(np.broadcast_arrays(x[None], rows[:, None]), axis=-1)
            at = map_points(matrix, places.reshape(-1, 2)) - 0.5
            values = map_coordinates(plane, at[:, ::-1].T, order=1, mode="nearest")
            out[first : first + len(rows), :, channel] = values.reshape(len(rows), width)
    return out

"""Likeness of a painted character to its copybook.

Both are drawn on a raster of 512 pixels an em, each pixel from 4 by 4 samples; a pixel belongs to
the character where at least half of it does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.calligraphy.kernels import raster
from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError

__all__ = ["MARGIN", "PIXELS", "Likeness", "compare", "copybook_mask", "painted_mask"]

PIXELS = 512
"""Pixels to a side of the em square."""
SAMPLES = 4
"""Samples to a side of a pixel."""
MARGIN = 32
"""Pixels around the em square that belong to the raster: what strays there counts too."""

_SIDE = PIXELS + 2 * MARGIN
_FLAT = 0.6  # slope of the distance below which a point lies on the middle line between two edges
_THINNEST = 1.5  # pixels of half width: thinner, and there is no middle line


@dataclass(frozen=True)
class Likeness:
    """Comparison of two shapes.

    Attributes
    ----------
    iou : float
        Area of the intersection over that of the union.
    precision, recall : float
        Fraction of the painted shape that is wanted, and of the wanted shape that is painted.
    hausdorff95 : float
        The distance, ems, within which 95 % of either edge lies from the other: the greater of the
        two directions.
    width_error : float
        Mean difference of the full widths along the middle line of the wanted shape, ems: twice the
        distances from there to the two edges.
    """

    iou: float
    precision: float
    recall: float
    hausdorff95: float
    width_error: float


def copybook_mask(
    outlines: Sequence[ArrayLike], em_mm: float, holes: Sequence[Sequence[ArrayLike]] = ()
) -> NDArray[np.bool_]:
    """Pixels (576, 576) of a character's outlines: row 0 lowest, the em square in the middle.

    Parameters
    ----------
    outlines : sequence of (N, 2) array_like
        Closed polygons, mm from the em square's lower left corner; non-zero rule.
    em_mm : float
        Side of the em square, mm.
    holes : sequence of sequences of (N, 2) array_like
        What each outline leaves out, mm; none where there are fewer of them than outlines.

    Raises
    ------
    InputError
        If an outline is not an array of points, or the em is not positive.
    """
    fine = np.zeros((_SIDE * SAMPLES, _SIDE * SAMPLES), np.bool_)
    for k, outline in enumerate(outlines):
        rings = [outline, *(holes[k] if k < len(holes) else ())]
        points = [as_array(ring, f"outline {k + 1}", (None, 2)) for ring in rings]
        if len(points) == 1:
            _fill_polygon(points[0], em_mm, fine)
            continue
        whole, left_out = np.zeros_like(fine), np.zeros_like(fine)
        _fill_polygon(points[0], em_mm, whole)
        for ring in points[1:]:
            _fill_polygon(ring, em_mm, left_out)
        fine |= whole & ~left_out
    return _pixel_means(fine) >= 0.5


def _fill_polygon(points: AnyArray, em_mm: float, fine: NDArray[np.bool_]) -> None:
    """Set the samples inside a polygon."""
    if len(points) > 2:
        raster.fill_polygon(_to_samples(points, em_mm), fine)


def painted_mask(
    points: ArrayLike, coverage: ArrayLike, faces: ArrayLike, em_mm: float
) -> NDArray[np.bool_]:
    """Pixels of a painted surface, whose coverage is linear between the vertices.

    Parameters
    ----------
    points : (V, 2) array_like
        Vertices, mm from the em square's lower left corner in the character's own plane; NaN for
        those that are not near it.
    coverage : (V,) array_like
        Fraction of each vertex's area that is under paint.
    faces : (F, 3) array_like
    em_mm : float

    Raises
    ------
    InputError
        If the arrays do not belong together, or the em is not positive.
    """
    points, faces = np.asarray(points, np.float64), np.asarray(faces, np.int32)
    coverage = np.asarray(coverage, np.float32)
    if points.ndim != 2 or points.shape[1] != 2 or coverage.shape != (len(points),):
        raise InputError(
            "points has shape {points_shape} and coverage {coverage_shape}; expected (V, 2) and "
            "(V,)",
            points_shape=points.shape,
            coverage_shape=coverage.shape,
        )
    fine = np.zeros((_SIDE * SAMPLES, _SIDE * SAMPLES), np.float32)
    touched = faces[(coverage[faces] > 0.0).any(axis=1)]
    raster.fill_triangles(_to_samples(points, em_mm), coverage, touched, fine)
    return _pixel_means(fine) >= 0.5


def compare(painted: NDArray[np.bool_], wanted: NDArray[np.bool_]) -> Likeness:
    """Compare two masks of the same raster.

    Raises
    ------
    InputError
        If the masks differ in shape, or one of them is empty.
    """
    if painted.shape != wanted.shape:
        raise InputError(
            "the masks are {painted_shape} and {wanted_shape}; expected the same",
            painted_shape=painted.shape,
            wanted_shape=wanted.shape,
        )
    if not painted.any() or not wanted.any():
        which = "painted" if wanted.any() else "wanted"
        raise InputError("the {which} shape is empty; expected pixels to compare", which=which)
    painted, wanted = _cut_out(painted, wanted)
    both = int((painted & wanted).sum())
    return Likeness(
        iou=both / int((painted | wanted).sum()),
        precision=both / int(painted.sum()),
        recall=both / int(wanted.sum()),
        hausdorff95=_hausdorff95(painted, wanted) / PIXELS,
        width_error=_width_error(painted, wanted) / PIXELS,
    )


def _to_samples(points: AnyArray, em_mm: float) -> NDArray[np.float64]:
    scale = PIXELS * SAMPLES / as_number(em_mm, "em (mm)", low=1e-6)
    return np.ascontiguousarray(points * scale + MARGIN * SAMPLES)


def _pixel_means(fine: AnyArray) -> NDArray[np.float32]:
    """Mean over each pixel's samples."""
    blocks = fine.reshape(_SIDE, SAMPLES, _SIDE, SAMPLES)
    result: NDArray[np.float32] = blocks.mean(axis=(1, 3), dtype=np.float32)
    return result


def _cut_out(a: AnyArray, b: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Crop two masks to their common bounding box and a pixel around it; distances stay."""
    rows, columns = (np.flatnonzero((a | b).any(axis=axis)) for axis in (1, 0))
    box = tuple(slice(max(0, at[0] - 1), at[-1] + 2) for at in (rows, columns))
    return a[box], b[box]


def _edge_pixels(mask: AnyArray) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_erosion  # a quarter of a second, and only who compares waits

    result: NDArray[np.bool_] = mask & ~binary_erosion(mask)
    return result


def _hausdorff95(a: AnyArray, b: AnyArray) -> float:
    """Pixels: 95 % of each edge lie nearer than this to the other edge."""
    from scipy.ndimage import distance_transform_edt

    one, two = _edge_pixels(a), _edge_pixels(b)
    there = np.percentile(distance_transform_edt(~two)[one], 95.0)
    back = np.percentile(distance_transform_edt(~one)[two], 95.0)
    return float(max(there, back))


def _width_error(painted: AnyArray, wanted: AnyArray) -> float:
    """Pixels: mean difference of full widths along the wanted shape's middle line."""
    from scipy.ndimage import distance_transform_edt

    depth, other = distance_transform_edt(wanted), distance_transform_edt(painted)
    slope = np.hypot(*np.gradient(depth))
    middle = (depth > _THINNEST) & (slope < _FLAT)
    if not middle.any():
        middle = depth == depth.max()
    return 2.0 * float(np.abs(depth[middle] - other[middle]).mean())

"""The centre line of a stroke: smoothed, led to the outline's ends, and kept in the middle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from paint3d.calligraphy.kernels import planning as kernels
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import headings_of, resample, signed_area
from paint3d.errors import InputError

__all__ = [
    "CentreLine",
    "OutlineField",
    "centre_line",
    "grid_step",
    "measure_line",
    "outline_field",
    "smooth_along",
]

_PER_EM = 512  # steps of the grid
_PER_HALF_WIDTH = 8.0  # of these across half a stroke: a frayed edge is finer than it
_FINEST_PER_EM = 2048  # of these, but where strokes are so thin that fewer are
_LEAST_PER_HALF_WIDTH = 4.0  # across half of them
_MOST_POINTS = 4_000_000  # of a grid
_LEAP = 0.25  # mm that the kernel goes at a time at the least


@dataclass(frozen=True, eq=False)
class OutlineField:
    """Signed distances of an outline on a grid of H by W points.

    Attributes
    ----------
    distance : (H, W) float64
        mm, positive inside.
    grid : (3,) float64
        x and y of the first point, and the step; mm.
    scale : float
        Magnification at which clearance is measured, so that nothing is leapt over.
    """

    distance: NDArray[np.float64]
    grid: NDArray[np.float64]
    scale: float = 1.0

    @property
    def inside(self) -> NDArray[np.bool_]:
        """Grid points inside the outline, (H, W) bool."""
        return self.distance > 0.0

    def depths(self, points: AnyArray) -> NDArray[np.float64]:
        """Signed distances (N,) of the grid points nearest to `points` (N, 2), mm."""
        at = np.rint((points - self.grid[:2]) / self.grid[2]).astype(np.int64)
        column, row = np.clip(at, 0, np.array(self.distance.shape[::-1]) - 1).T
        result: NDArray[np.float64] = self.distance[row, column]
        return result

    def clearance(
        self, points: AnyArray, directions: AnyArray, limit: float
    ) -> NDArray[np.float64]:
        """Distance (mm) from `points` (N, 2) to the outline along unit `directions` (N, 2)."""
        out = np.empty(len(points))
        scale = self.scale
        kernels.measure_room(
            scale * self.distance,
            scale * self.grid,
            np.ascontiguousarray(scale * points),
            np.ascontiguousarray(directions),
            scale * limit,
            out,
        )
        return out / scale


@dataclass(frozen=True, eq=False)
class CentreLine:
    """A centre line as S samples at an even distance, with the outline to both sides.

    Attributes
    ----------
    points : (S, 2) float64
        mm.
    headings : (S,) float64
        Direction of travel, rad, without jumps of a turn.
    clearance : (S, 2) float64
        Distance to the outline on the left and on the right, mm; at most 1.5 widths.
    width : float
        Median width of the stroke, mm.
    step : float
        Distance of the samples, mm.
    """

    points: NDArray[np.float64]
    headings: NDArray[np.float64]
    clearance: NDArray[np.float64]
    width: float
    step: float

    @property
    def normals(self) -> NDArray[np.float64]:
        """Unit vectors to the left (S, 2)."""
        return _normals(self.headings)


def grid_step(outline: AnyArray, em_mm: float, holes: Sequence[AnyArray] = ()) -> float:
    """Spacing of the grid that an outline (N, 2) needs, mm: a 512th of the em, less if thin.

    Half the width of a stroke is nearly its area by its perimeter.
    """
    step = em_mm / _PER_EM
    rings = [outline, *holes]
    areas = [abs(signed_area(ring)) for ring in rings]
    around = sum(
        float(np.linalg.norm(np.diff(r, axis=0, append=r[:1]), axis=1).sum()) for r in rings
    )
    half_width = (areas[0] - sum(areas[1:])) / around if around > 0.0 else 0.0
    if not half_width > 0.0:
        return step
    least = math.sqrt(float(np.prod(np.ptp(outline, axis=0))) / _MOST_POINTS)
    finest = min(em_mm / _FINEST_PER_EM, half_width / _LEAST_PER_HALF_WIDTH)
    return min(step, max(half_width / _PER_HALF_WIDTH, finest, least))


def outline_field(
    outline: AnyArray, step: float, holes: Sequence[AnyArray] = (), fine: bool = False
) -> OutlineField:
    """Signed distances around a closed polygon (N, 2) with holes, with a margin of four steps.

    What is `fine`, or has holes, has edges nearer to each other than the kernel's leaps.
    """
    low = outline.min(axis=0) - 4 * step
    columns, rows = np.ceil((outline.max(axis=0) + 4 * step - low) / step).astype(int) + 1
    distance = np.empty((rows, columns))
    kernels.signed_distances(np.ascontiguousarray(outline), low[0], low[1], step, distance)
    for hole in holes:
        around = np.empty_like(distance)
        kernels.signed_distances(np.ascontiguousarray(hole), low[0], low[1], step, around)
        distance = np.minimum(distance, -around)
    scale = max(1.0, _LEAP / step) if fine or holes else 1.0
    return OutlineField(distance, np.array([low[0], low[1], step]), scale)


def centre_line(median: AnyArray, field: OutlineField, step: float) -> CentreLine:
    """Smooth a median (M, 2), extend it to the outline's ends, and move it to the middle.

    Raises
    ------
    InputError
        If the median lies outside the outline, or has no length.
    """
    if not np.ptp(median, axis=0).any():
        raise InputError("the median has no length; expected two different points")
    points = resample(median, step, 5)
    headings = _headings(points)
    width = np.median(
        _measure_clearance(points, headings, field, 2.0 * field.distance.max()).sum(axis=1)
    )
    if width <= 0.0:
        raise InputError("most of the median lies outside the outline; expected it within")
    sigma = 0.25 * width / step
    points = smooth_along(points, sigma)
    points = resample(_extend_to_outline(points, field, width), step, 5)
    for _ in range(2):
        headings = _headings(points)
        clearance = _measure_clearance(points, headings, field, width)
        inner = np.minimum(clearance.min(axis=1), 0.3 * width)
        move = np.clip(0.5 * (clearance[:, 0] - clearance[:, 1]), -inner, inner)
        moved = points + move[:, None] * _normals(headings)
        points = resample(smooth_along(moved, sigma), step, 5)
    step = float(np.linalg.norm(np.diff(points, axis=0), axis=1).mean())
    return measure_line(points, width, step, field)


def smooth_along(points: AnyArray, sigma: float) -> NDArray[np.float64]:
    """Gaussian smoothing of values (N, K) along a line; both ends stay. `sigma` in samples."""
    sigma = max(sigma, 0.3)
    n = len(points)
    reach = min(n - 1, math.ceil(4 * sigma))
    head = 2 * points[0] - points[reach:0:-1]
    tail = 2 * points[-1] - points[-2 : -reach - 2 : -1]
    padded = np.concatenate([head, points, tail])
    result: NDArray[np.float64] = gaussian_filter1d(padded, sigma, axis=0, truncate=4.0)[
        reach : reach + n
    ]
    return result


def _headings(points: AnyArray) -> NDArray[np.float64]:
    return headings_of(np.gradient(points, axis=0))


def _normals(headings: AnyArray) -> NDArray[np.float64]:
    return np.stack([-np.sin(headings), np.cos(headings)], axis=1)


def _measure_clearance(
    points: AnyArray, headings: AnyArray, field: OutlineField, limit: float
) -> AnyArray:
    left = _normals(headings)
    sides = [field.clearance(points, direction, limit) for direction in (left, -left)]
    return np.stack(sides, axis=1)


def measure_line(points: AnyArray, width: float, step: float, field: OutlineField) -> CentreLine:
    """A line of samples (S, 2) about a step apart with its headings and its clearance."""
    headings = _headings(points)
    return CentreLine(
        points, headings, _measure_clearance(points, headings, field, 1.5 * width), width, step
    )


def _extend_to_outline(points: AnyArray, field: OutlineField, width: float) -> NDArray[np.float64]:
    """Go on straight from both ends until the outline is reached."""
    k = min(len(points) - 1, 6)
    directions = np.stack([points[0] - points[k], points[-1] - points[-1 - k]])
    directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-12)
    ends = (
        points[[0, -1]] + field.clearance(points[[0, -1]], directions, width)[:, None] * directions
    )
    return np.concatenate([ends[:1], points, ends[1:]])

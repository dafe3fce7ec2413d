"""Polylines of points (N, K) and rings (N, 2): arc length, resampling, area, Bezier curves."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray

__all__ = [
    "arc_lengths",
    "bezier_points",
    "cross_2d",
    "headings_of",
    "interpolate",
    "line_length",
    "points_at",
    "resample",
    "resample_to",
    "signed_area",
    "unit_vectors",
]


def arc_lengths(line: AnyArray) -> NDArray[np.float64]:
    """Compute the distance (N,) of each point from the first one, along the line."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def line_length(line: AnyArray) -> float:
    """Compute the length of a line."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def interpolate(at: ArrayLike, knots: AnyArray, rows: AnyArray) -> NDArray[np.float64]:
    """Interpolate rows (N, K) at rising knots (N,) linearly, at positions (...): (..., K)."""
    positions = np.asarray(at, np.float64)
    return np.stack([np.interp(positions, knots, column) for column in rows.T], axis=-1)


def points_at(line: AnyArray, distances: ArrayLike) -> NDArray[np.float64]:
    """Compute the points (..., K) of a line at distances (...) from its first one."""
    return interpolate(distances, arc_lengths(line), line)


def resample(line: AnyArray, step: float, least: int = 2) -> NDArray[np.float64]:
    """Resample a line at even distances of about `step`, to at least `least` points."""
    lengths = arc_lengths(line)
    n = max(least, math.ceil(lengths[-1] / step) + 1) if lengths[-1] > 0.0 else least
    return interpolate(np.linspace(0.0, lengths[-1], n), lengths, line)


def resample_to(line: AnyArray, n: int) -> NDArray[np.float64]:
    """Resample a line to n points at even distances."""
    lengths = arc_lengths(line)
    return interpolate(np.linspace(0.0, lengths[-1], n), lengths, line)


def headings_of(vectors: AnyArray) -> NDArray[np.float64]:
    """Compute the directions (N,) of vectors (N, 2), rad, without jumps of a turn."""
    return np.unwrap(np.arctan2(vectors[:, 1], vectors[:, 0]))


def unit_vectors(angles: AnyArray) -> NDArray[np.float64]:
    """Compute the unit vectors (N, 2) in directions (N,), rad."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def cross_2d(u: AnyArray, v: AnyArray) -> AnyArray:
    """Compute the cross products (...) of vectors (..., 2): positive where v is left of u."""
    product: AnyArray = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return product


def signed_area(ring: AnyArray) -> float:
    """Compute the area of a closed ring without a repeated point; negative if clockwise."""
    x, y = ring.T
    return 0.5 * float(np.sum(np.roll(x, 1) * y - x * np.roll(y, 1)))


def bezier_points(controls: AnyArray, flatness: float) -> NDArray[np.float64]:
    """Flatten a Bezier curve to points (N, 2) after its start, with chords within `flatness`.

    Parameters
    ----------
    controls : (2..4, 2) float64
        Its control points, the start first: a line, or a quadratic or cubic curve.
    flatness : float
        In their unit.
    """
    hull: list[AnyArray] = list(np.asarray(controls, np.float64))
    degree = len(hull) - 1
    if degree < 2:
        return np.array(hull[1:])
    bend = np.linalg.norm(np.diff(np.array(hull), n=2, axis=0), axis=1).max()
    n = int(min(max(1.0, np.ceil(np.sqrt(degree * (degree - 1) * bend / (8.0 * flatness)))), 500))
    t = np.linspace(0.0, 1.0, n + 1)[1:, None]
    while len(hull) > 1:
        hull = [(1.0 - t) * a + t * b for a, b in pairwise(hull)]
    result: NDArray[np.float64] = hull[0]
    return result

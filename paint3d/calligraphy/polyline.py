"""Polylines and rings of points (N, 2): arc length, even samples, area, Bezier curves."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

__all__ = [
    "arc_lengths",
    "bezier_points",
    "line_length",
    "points_at",
    "resample",
    "resample_to",
    "signed_area",
]


def arc_lengths(line: AnyArray) -> NDArray[np.float64]:
    """Distance (N,) of each point of a line from its first one, along the line."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def line_length(line: AnyArray) -> float:
    """Length of a line."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def points_at(line: AnyArray, distances: AnyArray) -> NDArray[np.float64]:
    """Points (K, 2) of a line at distances (K,) from its first one."""
    return _interpolate(line, arc_lengths(line), distances)


def resample(line: AnyArray, step: float, least: int = 2) -> NDArray[np.float64]:
    """A line at even distances of about `step`, at `least` so many points."""
    way = arc_lengths(line)
    n = max(least, math.ceil(way[-1] / step) + 1) if way[-1] > 0.0 else least
    return _interpolate(line, way, np.linspace(0.0, way[-1], n))


def resample_to(line: AnyArray, n: int) -> NDArray[np.float64]:
    """A line as n points at even distances."""
    way = arc_lengths(line)
    return _interpolate(line, way, np.linspace(0.0, way[-1], n))


def _interpolate(line: AnyArray, way: AnyArray, distances: AnyArray) -> NDArray[np.float64]:
    return np.stack([np.interp(distances, way, line[:, k]) for k in range(2)], axis=1)


def signed_area(ring: AnyArray) -> float:
    """Area of a closed ring, whose last point is not the first again; negative if clockwise."""
    x, y = ring.T
    return 0.5 * float(np.sum(np.roll(x, 1) * y - x * np.roll(y, 1)))


def bezier_points(controls: AnyArray, flatness: float) -> NDArray[np.float64]:
    """Points (N, 2) of a Bezier curve after its start, no farther from it than `flatness`.

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

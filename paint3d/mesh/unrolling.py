"""From points of a surface back to the flat sheet that was laid on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import as_array
from paint3d.core.types import AnyArray
from paint3d.mesh.chart import SurfaceChart

__all__ = ["unroll"]

_NODES = 65  # to a side of the grid that a first guess is taken from
_ROUNDS = 4
_DIFFERENCE = 1e-3  # of the chart's half width


def unroll(chart: SurfaceChart, points: ArrayLike) -> NDArray[np.float64]:
    """Chart coordinates (N, 2), mm, of points (N, 3) on the surface; NaN outside the chart.

    Newton's method from the nearest of 65 by 65 nodes; what a point lies off the surface along its
    normal does not matter.

    Raises
    ------
    InputError
        If `points` is not an array of points.
    """
    from scipy.spatial import KDTree

    given = as_array(points, "points", (None, 3))
    reach = np.array([chart.half_width, chart.half_height])
    x, y = np.meshgrid(*(np.linspace(-r, r, _NODES) for r in reach), indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel()], axis=1)
    there = chart.points(nodes)
    step = 2.0 * reach.max() / (_NODES - 1)
    stretch = np.linalg.norm(np.diff(there.reshape(_NODES, _NODES, 3), axis=0), axis=2).max()
    apart, nearest = KDTree(there).query(given, distance_upper_bound=2.0 * max(step, stretch))
    near = np.flatnonzero(np.isfinite(apart))
    flat = np.full((len(given), 2), np.nan)
    at = nodes[nearest[near]]
    beyond = np.zeros(len(near), np.bool_)
    for _ in range(_ROUNDS):
        moved = at + _newton_step(chart, at, given[near])
        at = np.clip(moved, -reach, reach)
        beyond = (np.abs(moved - at) > 0.01 * step).any(axis=1)
    at[beyond] = np.nan
    flat[near] = at
    return flat


def _newton_step(chart: SurfaceChart, at: AnyArray, wanted: AnyArray) -> NDArray[np.float64]:
    """Least-squares step (N, 2) in the chart towards points (N, 3)."""
    reach = np.array([chart.half_width, chart.half_height])
    away = wanted - chart.points(at)
    columns = []
    for axis in range(2):
        offset = np.zeros(2)
        offset[axis] = _DIFFERENCE * reach[axis]
        high, low = np.minimum(at + offset, reach), np.maximum(at - offset, -reach)
        span = (high - low)[:, axis, None]
        columns.append((chart.points(high) - chart.points(low)) / span)
    along_x, along_y = columns
    xx, xy = np.sum(along_x * along_x, axis=1), np.sum(along_x * along_y, axis=1)
    yy = np.sum(along_y * along_y, axis=1)
    bx, by = np.sum(along_x * away, axis=1), np.sum(along_y * away, axis=1)
    determinant = xx * yy - xy * xy
    result: NDArray[np.float64] = (
        np.stack([yy * bx - xy * by, xx * by - xy * bx], axis=1) / determinant[:, None]
    )
    return result

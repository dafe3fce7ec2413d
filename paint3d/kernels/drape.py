"""Dropping points onto a surface: where shadows fall, and where an outline lies."""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels.contact import closest_point

__all__ = ["drape_points"]

_STEPS = 16
_CLOSE = 0.03  # mm: near enough to have landed
_NEAR = 0.8  # mm: near enough where the steps have run out, as they do at a grazing fall


@njit(cache=True, nogil=True)
def drape_points(tree, points, direction, reach, out, landed):
    """Let points fall along a direction until they meet the surface (sphere tracing, Hart 1996).

    Parameters
    ----------
    tree : ContactTree
    points : (N, 3) float64
        mm.
    direction : (3,) float64
        Unit; only what faces against it is met.
    reach : float
        Farthest fall, mm.
    out : (N, 6) float64
        Filled with the place and the unit normal there.
    landed : (N,) uint8
        1 where there is one.
    """
    dx, dy, dz = direction[0], direction[1], direction[2]
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        fallen = 0.0
        landed[i] = 0
        for step in range(_STEPS):
            if closest_point(tree, x, y, z, -dx, -dy, -dz, reach, out[i]) < 0:
                break
            ax, ay, az = out[i, 0] - x, out[i, 1] - y, out[i, 2] - z
            away = np.sqrt(ax * ax + ay * ay + az * az)
            if away < _CLOSE or (step == _STEPS - 1 and away < _NEAR):
                landed[i] = 1
                break
            if step == 0 and ax * out[i, 3] + ay * out[i, 4] + az * out[i, 5] > 0.0:
                landed[i] = 1  # it begins below the surface: up to where that is nearest
                break
            fallen += away
            if fallen > reach:
                break
            x += away * dx
            y += away * dy
            z += away * dz

"""Normals of a tube that is drawn as rings of points."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["ring_normals"]


@kernel(error_model="numpy")
def ring_normals(points, normals):
    """Find unit normals of a tube, outward.

    A normal is the cross product of the differences around the ring and along the tube; a ring
    whose normals look inward as a whole is turned round.

    Parameters
    ----------
    points : (R, N, 3) float64
        Rings, each of which closes; at least two.
    normals : (R, N, 3) float32
        Written; (0, 0, 1), or its opposite, where a ring is a point.
    """
    rings, around = points.shape[0], points.shape[1]
    found = np.empty((around, 3))
    for r in range(rings):
        before, after = max(r - 1, 0), min(r + 1, rings - 1)
        middle = np.zeros(3)
        for k in range(around):
            for c in range(3):
                middle[c] += points[r, k, c]
        middle /= around
        outward = 0.0
        for k in range(around):
            last, following = (k - 1) % around, (k + 1) % around
            ux = points[r, following, 0] - points[r, last, 0]
            uy = points[r, following, 1] - points[r, last, 1]
            uz = points[r, following, 2] - points[r, last, 2]
            step = after - before
            vx = (points[after, k, 0] - points[before, k, 0]) / step
            vy = (points[after, k, 1] - points[before, k, 1]) / step
            vz = (points[after, k, 2] - points[before, k, 2]) / step
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            length = np.sqrt(nx * nx + ny * ny + nz * nz)
            if length > 1e-12:
                nx, ny, nz = nx / length, ny / length, nz / length
            else:
                nx, ny, nz = 0.0, 0.0, 1.0
            found[k, 0], found[k, 1], found[k, 2] = nx, ny, nz
            outward += nx * (points[r, k, 0] - middle[0])
            outward += ny * (points[r, k, 1] - middle[1])
            outward += nz * (points[r, k, 2] - middle[2])
        sign = -1.0 if outward < 0.0 else 1.0
        for k in range(around):
            for c in range(3):
                normals[r, k, c] = sign * found[k, c]

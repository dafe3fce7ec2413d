"""Which ways the triangles of a patch look."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["cone_of"]


@kernel
def cone_of(points, faces, cone):
    """Find a cone around the normals of some triangles.

    Parameters
    ----------
    points : (K, 3) float32
        mm.
    faces : (L, 3) int32
    cone : (4,) float64
        Written: its unit axis, and the cosine of the angle between it and the normal that is
        furthest from it. NaN where no triangle has an area, or the normals' sum is nothing.
    """
    normal, axis = np.empty(3), np.zeros(3)
    for i in range(faces.shape[0]):
        _cross(points, faces, i, normal)
        axis += normal
    size = np.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    cone[:] = np.nan
    if not size > 0.0:
        return
    cone[:3], cone[3] = axis / size, 1.0
    for i in range(faces.shape[0]):
        _cross(points, faces, i, normal)
        length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        if length > 0.0:
            along = normal[0] * cone[0] + normal[1] * cone[1] + normal[2] * cone[2]
            cone[3] = min(cone[3], along / length)


@kernel(inline="always")
def _cross(points, faces, i, normal):
    a, b, c = faces[i, 0], faces[i, 1], faces[i, 2]
    ax, ay, az = np.float64(points[a, 0]), np.float64(points[a, 1]), np.float64(points[a, 2])
    ux, uy, uz = points[b, 0] - ax, points[b, 1] - ay, points[b, 2] - az
    vx, vy, vz = points[c, 0] - ax, points[c, 1] - ay, points[c, 2] - az
    normal[0] = uy * vz - uz * vy
    normal[1] = uz * vx - ux * vz
    normal[2] = ux * vy - uy * vx

"""Which triangles meet which cells of the lattice."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["INFLATION", "fill_pairs"]

INFLATION = 1e-3  # of the cell's size: cells are met a little early, so rounding cannot lose one


@kernel
def _minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def _parts(axis, a, b, c, half):
    """Whether an axis (3,) separates a triangle, relative to the cube's centre, from the cube."""
    x, y, z = axis
    at_a = a[0] * x + a[1] * y + a[2] * z
    at_b = b[0] * x + b[1] * y + b[2] * z
    at_c = c[0] * x + c[1] * y + c[2] * z
    r = half * (abs(x) + abs(y) + abs(z))
    return min(at_a, min(at_b, at_c)) > r or max(at_a, max(at_b, at_c)) < -r


@kernel
def _triangle_meets_box(tri, x, y, z, half):
    """Separating axes of a triangle (3, 3) and a cube (Akenine-Moller 2001)."""
    a = (tri[0, 0] - x, tri[0, 1] - y, tri[0, 2] - z)
    b = (tri[1, 0] - x, tri[1, 1] - y, tri[1, 2] - z)
    c = (tri[2, 0] - x, tri[2, 1] - y, tri[2, 2] - z)
    for axis in range(3):
        least = min(a[axis], min(b[axis], c[axis]))
        most = max(a[axis], max(b[axis], c[axis]))
        if least > half or most < -half:
            return False
    ab, bc, ca = _minus(b, a), _minus(c, b), _minus(a, c)
    if _parts(_cross(ab, bc), a, b, c, half):
        return False
    for x, y, z in (ab, bc, ca):
        if (
            _parts((0.0, -z, y), a, b, c, half)
            or _parts((z, 0.0, -x), a, b, c, half)
            or _parts((-y, x, 0.0), a, b, c, half)
        ):
            return False
    return True


@kernel
def fill_pairs(points, triangles, origin, size, places, roots):
    """List the (lattice place, triangle) pairs that meet, as many as there is room for.

    Returns how many there are.
    """
    n = 0
    capacity = roots.shape[0]
    tri = np.empty((3, 3))
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    half = size * (0.5 + INFLATION)
    for t in range(triangles.shape[0]):
        for axis in range(3):
            least = np.inf
            most = -np.inf
            for corner in range(3):
                p = np.float64(points[triangles[t, corner], axis])
                tri[corner, axis] = p
                least = min(least, p)
                most = max(most, p)
            low[axis] = int(np.floor((least - origin[axis]) / size - INFLATION))
            high[axis] = int(np.floor((most - origin[axis]) / size + INFLATION))
        single = low[0] == high[0] and low[1] == high[1] and low[2] == high[2]
        for i in range(low[0], high[0] + 1):
            x = origin[0] + (i + 0.5) * size
            for j in range(low[1], high[1] + 1):
                y = origin[1] + (j + 0.5) * size
                for k in range(low[2], high[2] + 1):
                    z = origin[2] + (k + 0.5) * size
                    if not single and not _triangle_meets_box(tri, x, y, z, half):
                        continue
                    if n < capacity:
                        places[n, 0] = i
                        places[n, 1] = j
                        places[n, 2] = k
                        roots[n] = t
                    n += 1
    return n

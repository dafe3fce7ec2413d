"""Which triangles meet which cells of the lattice."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel

__all__ = ["INFLATION", "fill_pairs"]

INFLATION = 1e-3  # of the cell's size: cells are met a little early, so rounding cannot lose one


@kernel
def _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, ux, uy, uz, half):
    """Whether the axis u separates the triangle (relative to the box's centre) from the box."""
    a = ax * ux + ay * uy + az * uz
    b = bx * ux + by * uy + bz * uz
    c = cx * ux + cy * uy + cz * uz
    r = half * (abs(ux) + abs(uy) + abs(uz))
    return min(a, min(b, c)) > r or max(a, max(b, c)) < -r


@kernel
def _triangle_meets_box(tri, x, y, z, half):
    """Separating axes of a triangle (3, 3) and a cube (Akenine-Moller 2001)."""
    ax, ay, az = tri[0, 0] - x, tri[0, 1] - y, tri[0, 2] - z
    bx, by, bz = tri[1, 0] - x, tri[1, 1] - y, tri[1, 2] - z
    cx, cy, cz = tri[2, 0] - x, tri[2, 1] - y, tri[2, 2] - z
    if min(ax, min(bx, cx)) > half or max(ax, max(bx, cx)) < -half:
        return False
    if min(ay, min(by, cy)) > half or max(ay, max(by, cy)) < -half:
        return False
    if min(az, min(bz, cz)) > half or max(az, max(bz, cz)) < -half:
        return False
    ex, ey, ez = bx - ax, by - ay, bz - az
    fx, fy, fz = cx - bx, cy - by, cz - bz
    nx, ny, nz = ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx
    if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, nx, ny, nz, half):
        return False
    for edge in range(3):
        if edge == 0:
            dx, dy, dz = ex, ey, ez
        elif edge == 1:
            dx, dy, dz = fx, fy, fz
        else:
            dx, dy, dz = ax - cx, ay - cy, az - cz
        if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, 0.0, -dz, dy, half):
            return False
        if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, dz, 0.0, -dx, half):
            return False
        if _axis_parts(ax, ay, az, bx, by, bz, cx, cy, cz, -dy, dx, 0.0, half):
            return False
    return True


@kernel
def fill_pairs(points, triangles, origin, size, places, roots):
    """List the (lattice place, triangle) pairs that meet, as many as there is room for.

    Returns how many there are.
    """
    n = 0
    room = roots.shape[0]
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
                    if n < room:
                        places[n, 0] = i
                        places[n, 1] = j
                        places[n, 2] = k
                        roots[n] = t
                    n += 1
    return n

"""Dropping points onto a surface: where shadows fall, and where an outline lies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.bvh import LEAF_SIZE

__all__ = ["drape_points", "ring_normals"]

_STACK = 64
_BELOW = 3.0  # mm: a point so far below the surface, or less, lies on it
_SLACK = 1e-5  # of a distance, for rounding


class _Ray(NamedTuple):
    """A half-line: where it begins, mm, and its unit direction."""

    x: float
    y: float
    z: float
    dx: float
    dy: float
    dz: float


@kernel(error_model="numpy")
def _enters(boxes, node, ray, near, far):
    """Distance at which a ray enters a box, between two; inf where it misses it."""
    for low, high, way in (
        (boxes[node, 0] - ray.x, boxes[node, 3] - ray.x, ray.dx),
        (boxes[node, 1] - ray.y, boxes[node, 4] - ray.y, ray.dy),
        (boxes[node, 2] - ray.z, boxes[node, 5] - ray.z, ray.dz),
    ):
        if low > high:  # of an empty node
            return np.inf
        if way == 0.0:
            if low > 0.0 or high < 0.0:
                return np.inf
            continue
        first = min(low / way, high / way)
        last = max(low / way, high / way)
        near = max(near, first - _SLACK * abs(first))
        far = min(far, last + _SLACK * abs(last))
    return near if near <= far else np.inf


@kernel(error_model="numpy")
def _meets(points, a, b, c, ray):
    """Distance at which a ray meets the front of triangle abc, and the weights there; inf: none."""
    x, y, z, dx, dy, dz = ray
    ax, ay, az = points[a, 0] - x, points[a, 1] - y, points[a, 2] - z
    bx, by, bz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
    cx, cy, cz = points[c, 0] - x, points[c, 1] - y, points[c, 2] - z
    u = dx * (by * cz - bz * cy) + dy * (bz * cx - bx * cz) + dz * (bx * cy - by * cx)
    v = dx * (cy * az - cz * ay) + dy * (cz * ax - cx * az) + dz * (cx * ay - cy * ax)
    w = dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)
    total = u + v + w  # twice the area seen along the ray, below 0 from the front
    if u > 0.0 or v > 0.0 or w > 0.0 or not total < 0.0:
        return np.inf, 0.0, 0.0, 0.0
    u, v, w = u / total, v / total, w / total
    t = (u * ax + v * bx + w * cx) * dx + (u * ay + v * by + w * cy) * dy
    return t + (u * az + v * bz + w * cz) * dz, u, v, w


@kernel(error_model="numpy")
def _first_met(tree, ray, reach, stack):
    """The triangle that a point meets on its way, -1 for none; how far along, and its weights."""
    n_leaves = tree.boxes.shape[0] // 2
    best, found, at = reach, -1, 0.0
    wa, wb, wc = 0.0, 0.0, 0.0
    depth = 0
    stack[0] = 1
    while depth >= 0:
        node = stack[depth]
        depth -= 1
        near, far = max(0.0, _BELOW - best), _BELOW + best
        if _enters(tree.boxes, node, ray, near, far) == np.inf:
            continue
        if node < n_leaves:
            left = _enters(tree.boxes, 2 * node, ray, near, far)
            right = _enters(tree.boxes, 2 * node + 1, ray, near, far)
            first = 2 * node + (right < left)
            if max(left, right) < np.inf:
                depth += 1
                stack[depth] = 4 * node + 1 - first
            if min(left, right) < np.inf:
                depth += 1
                stack[depth] = first
            continue
        begin = (node - n_leaves) * LEAF_SIZE
        for k in range(begin, min(begin + LEAF_SIZE, tree.triangles.shape[0])):
            a, b, c = tree.triangles[k, 0], tree.triangles[k, 1], tree.triangles[k, 2]
            t, u, v, w = _meets(tree.points, a, b, c, ray)
            if t >= 0.0 and abs(t - _BELOW) < best:
                best, found, at = abs(t - _BELOW), k, t
                wa, wb, wc = u, v, w
    return found, at, wa, wb, wc


@kernel(error_model="numpy")
def drape_points(tree, points, direction, reach, out, landed):
    """Drop points along a direction until they meet the surface.

    A point that begins up to 3 mm below it lies where it would have met it.

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
    stack = np.empty(_STACK, np.int64)
    for i in range(points.shape[0]):
        x = points[i, 0] - _BELOW * dx
        y = points[i, 1] - _BELOW * dy
        z = points[i, 2] - _BELOW * dz
        found, at, wa, wb, wc = _first_met(tree, _Ray(x, y, z, dx, dy, dz), reach, stack)
        landed[i] = found >= 0
        if found < 0:
            continue
        a, b, c = tree.triangles[found, 0], tree.triangles[found, 1], tree.triangles[found, 2]
        length = 0.0
        for k in range(3):
            out[i, k] = points[i, k] + (at - _BELOW) * direction[k]
            normal = wa * tree.normals[a, k] + wb * tree.normals[b, k] + wc * tree.normals[c, k]
            out[i, 3 + k] = normal
            length += normal * normal
        for k in range(3):
            out[i, 3 + k] /= max(np.sqrt(length), 1e-12)


# ---- Rings ---------------------------------------------------------------------------------------
# Normals of a tube that is drawn as rings of points.


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

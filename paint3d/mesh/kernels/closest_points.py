"""Closest points and first hits of rays on the triangles of a mesh, front and back alike.

The tree is that of `mesh.kernels.bvh` in the order of `mesh.kernels.median_split`, with fewer
triangles to a leaf. A tie is won by the triangle that comes first in the mesh: an answer depends on
the mesh and the question alone.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.bvh import box_distance2, closest_weights

__all__ = ["FACES_PER_LEAF", "closest_on", "find_closest", "find_hits"]

FACES_PER_LEAF = 2
_STACK = 64
_AWRY = 1e-12  # of a normal's length: corner normals that cancel out
_CLOSE = 1.0 + 1e-12  # what rounding may add to a box's squared distance
_SLACK = 1e-12  # of a distance along a ray: what rounding may take from a box


@kernel(error_model="numpy")
def closest_on(points, a, b, c, x, y, z):
    """Weights v, w of the corners b, c at the point of triangle abc nearest to (x, y, z).

    Returns v, w and the squared distance; see `bvh.closest_weights`.
    """
    _, v, w = closest_weights(points, a, b, c, (x, y, z))
    ax = np.float64(points[a, 0])
    ay = np.float64(points[a, 1])
    az = np.float64(points[a, 2])
    dx = x - ax - v * (points[b, 0] - ax) - w * (points[c, 0] - ax)
    dy = y - ay - v * (points[b, 1] - ay) - w * (points[c, 1] - ay)
    dz = z - az - v * (points[b, 2] - az) - w * (points[c, 2] - az)
    return v, w, dx * dx + dy * dy + dz * dz


@kernel(error_model="numpy")
def _search(tree, x, y, z, nodes, away):
    """The leaf place of the triangle nearest to (x, y, z), and the weights of its b and c.

    `nodes` and `away` (64,) are room for the nodes yet to be seen and how far off they are.
    """
    boxes = tree.boxes
    n_leaves = boxes.shape[0] // 2
    depth = 0
    nodes[0] = 1
    away[0] = 0.0
    best = np.inf
    found = -1
    v = 0.0
    w = 0.0
    while depth >= 0:
        node = nodes[depth]
        if away[depth] > best * _CLOSE:
            depth -= 1
            continue
        depth -= 1
        while node < n_leaves:  # down to the nearest leaf
            near = 2 * node
            far = near + 1
            d2 = box_distance2(boxes, near, x, y, z)
            other = box_distance2(boxes, far, x, y, z)
            if other < d2:
                near, far = far, near
                d2, other = other, d2
            if other <= best * _CLOSE:
                depth += 1
                nodes[depth] = far
                away[depth] = other
            if d2 > best * _CLOSE:
                break
            node = near
        if node < n_leaves:
            continue
        first = (node - n_leaves) * FACES_PER_LEAF
        for k in range(first, min(first + FACES_PER_LEAF, tree.triangles.shape[0])):
            a = tree.triangles[k, 0]
            b = tree.triangles[k, 1]
            c = tree.triangles[k, 2]
            tv, tw, d2 = closest_on(tree.points, a, b, c, x, y, z)
            if d2 < best or found < 0 or (d2 == best and tree.order[k] < tree.order[found]):
                best = d2
                found = k
                v = tv
                w = tw
    return found, v, w


@kernel(error_model="numpy")
def find_closest(tree, queries, points, faces, weights, normals):
    """Find the nearest point of the surface to each of N points.

    Parameters
    ----------
    tree : ContactTree
    queries : (N, 3) float64
        mm.
    points : (N, 3) float64
        Filled with the nearest points, mm.
    faces : (N,) int64
        Filled with the triangles they lie on.
    weights : (N, 3) float64
        Filled with the weights of the triangles' corners there.
    normals : (N, 3) float64
        Filled with the interpolated unit normals; zero where the corner normals cancel out.

    Returns
    -------
    int
        How many normals are zero.
    """
    nodes, away = np.empty(_STACK, np.int64), np.empty(_STACK)
    cancelled = 0
    for i in range(queries.shape[0]):
        k, v, w = _search(tree, queries[i, 0], queries[i, 1], queries[i, 2], nodes, away)
        u = 1.0 - v - w
        faces[i] = tree.order[k]
        weights[i, 0] = u
        weights[i, 1] = v
        weights[i, 2] = w
        a = tree.triangles[k, 0]
        b = tree.triangles[k, 1]
        c = tree.triangles[k, 2]
        n = 0.0
        for axis in range(3):
            x = np.float64(tree.points[a, axis])
            points[i, axis] = x + v * (tree.points[b, axis] - x) + w * (tree.points[c, axis] - x)
            normals[i, axis] = (
                u * tree.normals[a, axis] + v * tree.normals[b, axis] + w * tree.normals[c, axis]
            )
            n += normals[i, axis] * normals[i, axis]
        n = np.sqrt(n)
        for axis in range(3):
            normals[i, axis] = normals[i, axis] / n if n >= _AWRY else 0.0
        cancelled += n < _AWRY
    return cancelled


@kernel(error_model="numpy")
def _enters(boxes, node, ray, best):
    """Whether a ray meets a box before `best`, in lengths of its direction."""
    near = 0.0
    far = best
    for axis in range(3):
        low = boxes[node, axis] - ray[axis]
        high = boxes[node, 3 + axis] - ray[axis]
        if low > high:  # of an empty node
            return False
        way = ray[3 + axis]
        if way == 0.0:
            if low > 0.0 or high < 0.0:
                return False
            continue
        first = min(low / way, high / way)
        last = max(low / way, high / way)
        near = max(near, first - _SLACK * abs(first))
        far = min(far, last + _SLACK * abs(last))
    return near <= far


@kernel(error_model="numpy")
def _crosses(points, a, b, c, ray):
    """Where a ray meets triangle abc, in lengths of its direction; inf where it does not.

    The sides' volumes are those of the Plücker coordinates of ray and edge: two triangles see the
    edge between them with opposite signs, so no ray slips through. (One of 20,000 that are aimed
    right at a corner does: the volumes of all edges there are rounding.)
    """
    ax = points[a, 0] - ray[0]
    ay = points[a, 1] - ray[1]
    az = points[a, 2] - ray[2]
    bx = points[b, 0] - ray[0]
    by = points[b, 1] - ray[1]
    bz = points[b, 2] - ray[2]
    cx = points[c, 0] - ray[0]
    cy = points[c, 1] - ray[1]
    cz = points[c, 2] - ray[2]
    dx = ray[3]
    dy = ray[4]
    dz = ray[5]
    u = dx * (by * cz - bz * cy) + dy * (bz * cx - bx * cz) + dz * (bx * cy - by * cx)
    v = dx * (cy * az - cz * ay) + dy * (cz * ax - cx * az) + dz * (cx * ay - cy * ax)
    w = dx * (ay * bz - az * by) + dy * (az * bx - ax * bz) + dz * (ax * by - ay * bx)
    if not ((u >= 0.0 and v >= 0.0 and w >= 0.0) or (u <= 0.0 and v <= 0.0 and w <= 0.0)):
        return np.inf
    total = u + v + w  # 0 where the ray runs within the plane: t is NaN then
    x = (u * ax + v * bx + w * cx) / total
    y = (u * ay + v * by + w * cy) / total
    z = (u * az + v * bz + w * cz) / total
    t = (x * dx + y * dy + z * dz) / (dx * dx + dy * dy + dz * dz)
    return t if t >= 0.0 else np.inf


@kernel(error_model="numpy")
def find_hits(tree, rays, distances, faces):
    """Find where each of N rays first meets the surface, from whichever side.

    Parameters
    ----------
    tree : ContactTree
    rays : (N, 6) float64
        Origins, mm, and directions of any length.
    distances : (N,) float64
        Filled with the distances in lengths of the direction; inf where nothing is hit.
    faces : (N,) int64
        Filled with the triangles; -1 where nothing is hit.
    """
    n_leaves = tree.boxes.shape[0] // 2
    stack = np.empty(_STACK, np.int64)
    for i in range(rays.shape[0]):
        ray = rays[i]
        best = np.inf
        found = -1
        depth = 0
        stack[0] = 1
        while depth >= 0:
            node = stack[depth]
            depth -= 1
            if not _enters(tree.boxes, node, ray, best):
                continue
            if node < n_leaves:
                stack[depth + 1] = 2 * node + 1
                stack[depth + 2] = 2 * node
                depth += 2
                continue
            first = (node - n_leaves) * FACES_PER_LEAF
            for k in range(first, min(first + FACES_PER_LEAF, tree.triangles.shape[0])):
                corners = tree.triangles[k]
                t = _crosses(tree.points, corners[0], corners[1], corners[2], ray)
                if t < best or (t == best and found >= 0 and tree.order[k] < tree.order[found]):
                    best = t
                    found = k
        distances[i] = best
        faces[i] = tree.order[found] if found >= 0 else -1

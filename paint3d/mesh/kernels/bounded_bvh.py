"""Contact for a servo: the nearest point, the foot and the mean normal within a bounded time.

A tree asked for the nearest of a million points that are all but equally far (the middle of a
bowl) looks at most of them; a servo with a millisecond cannot. Every search counts down one budget
of tree nodes, starts from the last foot, and gives the best found when the budget is spent.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.bvh import (
    LEAF_SIZE,
    _box_distance2,
    _closest_weights,
    _faces,
    _interpolate,
    _residual,
)

__all__ = ["find_foot_within", "mean_normal", "nearest_within"]

_STACK = 64
_TOLERANCE = 1e-4  # mm, tangential residual at which the foot counts as found
_ITERATIONS = 8
_WARM = 0.15  # of the reach: a root that has moved farther is looked for afresh
_POOR = 0.1  # of the distance: a residual above it is no foot


@kernel(error_model="numpy")
def nearest_within(tree, x, y, z, ux, uy, uz, reach, guess, work, out):
    """The point nearest to (x, y, z) on triangles facing (ux, uy, uz), within reach and budget.

    Parameters
    ----------
    tree : ContactTree
    x, y, z, ux, uy, uz : float
    reach : float
        mm.
    guess : int
        A triangle, in the tree's order, to start from; -1 for none.
    work : (1,) int64
        Tree nodes that may still be looked at; counted down.
    out : (6,) float64
        Gets the point and its interpolated unit normal.

    Returns
    -------
    int
        The triangle in the tree's order, or -1.
    """
    boxes = tree.boxes
    n_leaves = boxes.shape[0] // 2
    stack = np.empty(_STACK, np.int64)
    best = reach * reach
    found = -1
    w0, w1, w2 = 0.0, 0.0, 0.0
    # From the guess's leaf upwards, the other side of every ancestor being looked at in turn: where
    # the guess is good, hardly more than one box a level.
    climbed = n_leaves + guess // LEAF_SIZE if guess >= 0 else 1
    depth = 0
    stack[0] = climbed
    while work[0] > 0:
        if depth < 0:
            if climbed <= 1:
                break
            depth = 0
            stack[0] = climbed ^ 1
            climbed >>= 1
        node = stack[depth]
        depth -= 1
        work[0] -= 1
        if _box_distance2(boxes, node, x, y, z) > best:
            continue
        if node < n_leaves:
            left = _box_distance2(boxes, 2 * node, x, y, z)
            right = _box_distance2(boxes, 2 * node + 1, x, y, z)
            near = 2 * node + (1 if right < left else 0)
            if max(left, right) <= best:
                depth += 1
                stack[depth] = 4 * node + 1 - near
            if min(left, right) <= best:
                depth += 1
                stack[depth] = near
            continue
        first = (node - n_leaves) * LEAF_SIZE
        for k in range(first, min(first + LEAF_SIZE, tree.triangles.shape[0])):
            a = tree.triangles[k, 0]
            b = tree.triangles[k, 1]
            c = tree.triangles[k, 2]
            if not _faces(tree.points, a, b, c, ux, uy, uz):
                continue
            va, vb, vc = _closest_weights(tree.points, a, b, c, x, y, z)
            d2 = 0.0
            for axis, q in ((0, x), (1, y), (2, z)):
                p = va * tree.points[a, axis] + vb * tree.points[b, axis]
                p += vc * tree.points[c, axis]
                d2 += (p - q) * (p - q)
            if d2 < best or (d2 == best and found < 0):
                best = d2
                found = k
                w0, w1, w2 = va, vb, vc
    if found >= 0:
        _interpolate(tree, found, w0, w1, w2, out)
    return found


@kernel(error_model="numpy")
def find_foot_within(tree, x, y, z, ux, uy, uz, reach, warm, work, out):
    """The foot whose interpolated normal passes through (x, y, z); see `contact.find_foot`.

    `warm` (5,) is 1 where there is a last foot, its triangle in the tree's order, and the root it
    was found for; `out` (6,) holds that foot. Returns the triangle in the tree's order, or -1.
    """
    triangle = -1
    if warm[0] > 0.0:
        moved = (x - warm[2]) ** 2 + (y - warm[3]) ** 2 + (z - warm[4]) ** 2
        if moved <= (_WARM * reach) ** 2:
            triangle = _settle(tree, x, y, z, ux, uy, uz, int(warm[1]), 1.0, work, out)
            _, _, _, residual = _residual(x, y, z, out)
            away = (x - out[0]) ** 2 + (y - out[1]) ** 2 + (z - out[2]) ** 2
            facing = out[3] * ux + out[4] * uy + out[5] * uz
            if away > reach * reach or facing <= 0.0 or residual > _POOR * _POOR * away:
                triangle = -1
    if triangle < 0:
        guess = int(warm[1]) if warm[0] > 0.0 else -1
        triangle = nearest_within(tree, x, y, z, ux, uy, uz, reach, guess, work, out)
        if triangle >= 0:
            triangle = _settle(tree, x, y, z, ux, uy, uz, triangle, 0.7, work, out)
    warm[0] = 1.0 if triangle >= 0 else 0.0
    warm[1] = triangle
    warm[2] = x
    warm[3] = y
    warm[4] = z
    return triangle


@kernel(error_model="numpy")
def _settle(tree, x, y, z, ux, uy, uz, triangle, gain, work, out):
    """Secant steps along the tangential residual, from the foot in `out`; returns its triangle."""
    trial = np.empty(6)
    rx, ry, rz, residual = _residual(x, y, z, out)
    for _ in range(_ITERATIONS):
        if residual <= _TOLERANCE * _TOLERANCE or work[0] <= 0:
            break
        bound = gain * np.sqrt(residual) + 1e-3
        hit = nearest_within(
            tree,
            out[0] + gain * rx,
            out[1] + gain * ry,
            out[2] + gain * rz,
            ux,
            uy,
            uz,
            bound,
            triangle,
            work,
            trial,
        )
        if hit < 0:
            break
        sx, sy, sz, rest = _residual(x, y, z, trial)
        slope = (residual - (sx * rx + sy * ry + sz * rz)) / (gain * residual)
        if rest >= residual:
            gain *= 0.5
            if gain < 0.05:
                break
            continue
        gain = min(1.0, max(0.1, 1.0 / slope)) if slope > 0.0 else 0.7
        triangle = hit
        out[:] = trial
        rx, ry, rz, residual = sx, sy, sz, rest
    return triangle


@kernel(error_model="numpy")
def mean_normal(tree, foot, ux, uy, uz, bx, by, bz, patch, guess, near, work, normal):
    """The mean normal of the surface around the foot, a disc of radius `patch`.

    Places where the surface has ended or bent away count less and less, so that the mean does not
    jump at a rim. (bx, by, bz) is any direction that turns with the pen. `near` (S,) keeps the
    triangles found, plus 1, from step to step: from there on, the next search is short.
    """
    for axis in range(3):
        normal[axis] = foot[3 + axis]
    along = bx * foot[3] + by * foot[4] + bz * foot[5]
    ex = bx - along * foot[3]
    ey = by - along * foot[4]
    ez = bz - along * foot[5]
    norm = np.sqrt(ex * ex + ey * ey + ez * ez)
    if norm < 1e-6:
        return
    ex /= norm
    ey /= norm
    ez /= norm
    fx = foot[4] * ez - foot[5] * ey
    fy = foot[5] * ex - foot[3] * ez
    fz = foot[3] * ey - foot[4] * ex
    there = np.empty(6)
    n_samples = near.shape[0]
    for i in range(n_samples):
        c = patch * np.cos(2.0 * np.pi * i / n_samples)
        s = patch * np.sin(2.0 * np.pi * i / n_samples)
        x = foot[0] + c * ex + s * fx
        y = foot[1] + c * ey + s * fy
        z = foot[2] + c * ez + s * fz
        begin = np.int64(near[i]) - 1 if near[i] > 0.0 else guess
        found = nearest_within(tree, x, y, z, ux, uy, uz, patch, begin, work, there)
        near[i] = found + 1
        if found < 0:
            continue
        d2 = (x - there[0]) ** 2 + (y - there[1]) ** 2 + (z - there[2]) ** 2
        weight = (1.0 - d2 / (patch * patch)) ** 2
        for axis in range(3):
            normal[axis] += weight * there[3 + axis]
    norm = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if norm > 1e-9:
        for axis in range(3):
            normal[axis] /= norm

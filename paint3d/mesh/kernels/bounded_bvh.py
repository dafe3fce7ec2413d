"""Contact for a servo: the nearest point, the foot and the mean normal within a bounded time.

A tree asked for the nearest of a million points that are all but equally far (the middle of a
bowl) looks at most of them; a servo with a millisecond cannot. Every search counts down one budget
of tree nodes, starts from the last foot, and gives the best found when the budget is spent.
"""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import kernel
from paint3d.mesh.kernels.bvh import (
    interpolate,
    is_near,
    note_foot,
    residual_of,
    search_nearest,
    settle_foot,
)

__all__ = ["find_foot_within", "mean_normal", "nearest_within"]

_POOR = 0.1  # of the distance: a residual above it is no foot


@kernel(error_model="numpy")
def nearest_within(tree, place, up, reach, guess, work, out):
    """The point nearest to a place on triangles facing `up`, within reach and budget.

    Parameters
    ----------
    tree, place, up, reach, guess : as for `mesh.kernels.bvh.search_nearest`
    work : (1,) int64
        Tree nodes that may still be looked at; counted down.
    out : (6,) float64
        Gets the point and its interpolated unit normal.

    Returns
    -------
    int
        The triangle in the tree's order, or -1.
    """
    found, weights, left = search_nearest(tree, place, up, reach, guess, work[0])
    work[0] = left
    if found >= 0:
        interpolate(tree, found, weights, out)
    return found


@kernel(error_model="numpy")
def find_foot_within(tree, root, up, reach, warm, work, out):
    """The foot whose interpolated normal passes through the root; see `bvh.find_foot`.

    `warm` (5,) is that of `bvh.note_foot`; `out` (6,) holds the last foot. Returns the triangle in
    the tree's order, or -1.
    """
    found = -1
    if is_near(warm, root, reach):
        found, work[0] = settle_foot(tree, root, up, int(warm[1]), 1.0, True, work[0], out)
        residual = residual_of(root, out)[3]
        away = (root[0] - out[0]) ** 2 + (root[1] - out[1]) ** 2 + (root[2] - out[2]) ** 2
        facing = out[3] * up[0] + out[4] * up[1] + out[5] * up[2]
        if away > reach * reach or facing <= 0.0 or residual > _POOR * _POOR * away:
            found = -1
    if found < 0:
        guess = int(warm[1]) if warm[0] > 0.0 else -1
        found = nearest_within(tree, root, up, reach, guess, work, out)
        if found >= 0:
            found, work[0] = settle_foot(tree, root, up, found, 0.7, True, work[0], out)
    note_foot(warm, found, root)
    return found


@kernel(error_model="numpy")
def mean_normal(tree, foot, up, ahead, patch, guess, near, work):
    """The mean unit normal (3,) of the surface around the foot, a disc of radius `patch`.

    Places where the surface has ended or bent away count less and less, so that the mean does not
    jump at a rim. `ahead` (3,) is any direction that turns with the pen. `near` (S,) keeps the
    triangles found, plus 1, from step to step: from there on, the next search is short; the first
    time from `guess`, as for `nearest_within`.
    """
    nx, ny, nz = foot[3], foot[4], foot[5]
    along = ahead[0] * nx + ahead[1] * ny + ahead[2] * nz
    ex = ahead[0] - along * nx
    ey = ahead[1] - along * ny
    ez = ahead[2] - along * nz
    norm = np.sqrt(ex * ex + ey * ey + ez * ez)
    if norm < 1e-6:
        return nx, ny, nz
    ex /= norm
    ey /= norm
    ez /= norm
    fx = ny * ez - nz * ey
    fy = nz * ex - nx * ez
    fz = nx * ey - ny * ex
    there = np.empty(6)
    n_samples = near.shape[0]
    for i in range(n_samples):
        c = patch * np.cos(2.0 * np.pi * i / n_samples)
        s = patch * np.sin(2.0 * np.pi * i / n_samples)
        x = foot[0] + c * ex + s * fx
        y = foot[1] + c * ey + s * fy
        z = foot[2] + c * ez + s * fz
        begin = np.int64(near[i]) - 1 if near[i] > 0.0 else guess
        found = nearest_within(tree, (x, y, z), up, patch, begin, work, there)
        near[i] = found + 1
        if found < 0:
            continue
        d2 = (x - there[0]) ** 2 + (y - there[1]) ** 2 + (z - there[2]) ** 2
        weight = (1.0 - d2 / (patch * patch)) ** 2
        nx += weight * there[3]
        ny += weight * there[4]
        nz += weight * there[5]
    norm = np.sqrt(nx**2 + ny**2 + nz**2)
    return (nx / norm, ny / norm, nz / norm) if norm > 1e-9 else (nx, ny, nz)

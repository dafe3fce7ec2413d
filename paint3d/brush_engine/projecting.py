"""Carry vertices to the plane of a stamp along their own normals (Guo 2017, section 4.2.1)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import uncounted

__all__ = ["AWAY", "LEAST_FACING", "Vertices", "project_run", "take_run", "vertices_of"]

LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
AWAY = 1e9  # plane coordinate of a vertex that cannot be painted


class Vertices(NamedTuple):
    """Where N vertices are, and which way they face: float32 arrays (N,)."""

    px: NDArray  # mm
    py: NDArray
    pz: NDArray
    nx: NDArray  # of the unit normal
    ny: NDArray
    nz: NDArray


@uncounted
def vertices_of(field):
    """The vertices of a `SurfaceField`."""
    return Vertices(field.px, field.py, field.pz, field.nx, field.ny, field.nz)


@uncounted
def _single(vector):
    """The numbers of a vector (3,) in single precision."""
    return np.float32(vector[0]), np.float32(vector[1]), np.float32(vector[2])


@uncounted(error_model="numpy")
def project_run(vertices, first, n, sweep, rows, at):
    """Carry a run of vertices to the plane along their own normals (Guo 2017, 4.2.1).

    docs/model.md, equations (5) and (6), in straight-line float32 code over consecutive memory, for
    vector instructions. A vertex that faces away, or lands outside the enclosing sphere, is sent
    far off; where it lands and not where it is, for a convex surface falls away from under the tip.
    So is one that would be carried farther than the sweep says, as from a ridge beside the brush,
    or lies outside its ball.

    Parameters
    ----------
    vertices : Vertices
    first, n : int
        The run: where it begins, and how many they are.
    sweep : record of SWEEP
    rows : (3 or more, N) float32
        The first three are filled from column `at` on: plane x and y, mm, and stretch, the plane's
        area for one of the surface there, as on a cylinder: 1 / cosine^2.
    at : int
    """
    ox, oy, oz = _single(sweep.origin)
    ux, uy, uz = _single(sweep.normal)
    bx, by, bz = _single(sweep.bend)
    cx, cy, cz = _single(sweep.cross)
    sx, sy, sz = _single(sweep.sphere_centre)
    r2 = np.float32(sweep.radius2)
    farthest2 = np.float32(sweep.carry2)
    mx, my, mz = _single(sweep.ball)
    ball2 = np.float32(sweep.ball2)
    least = np.float32(LEAST_FACING)
    away = np.float32(AWAY)
    one = np.float32(1.0)
    # slices: indices that cannot be negative are what lets the loop be vectorised
    last = first + n
    px, py, pz = vertices.px[first:last], vertices.py[first:last], vertices.pz[first:last]
    nx, ny, nz = vertices.nx[first:last], vertices.ny[first:last], vertices.nz[first:last]
    xs, ys, stretch = rows[0][at : at + n], rows[1][at : at + n], rows[2][at : at + n]
    for k in range(n):
        dx, dy, dz = px[k] - ox, py[k] - oy, pz[k] - oz
        cosine = nx[k] * ux + ny[k] * uy + nz[k] * uz
        safe = max(cosine, least)
        height = dx * ux + dy * uy + dz * uz
        inverse = one / safe
        t = height * inverse
        qx = dx - t * nx[k]
        qy = dy - t * ny[k]
        qz = dz - t * nz[k]
        ex = qx - sx
        ey = qy - sy
        ez = qz - sz
        reach = max(ex * ex + ey * ey + ez * ez, height * height)
        hx = dx - mx
        hy = dy - my
        hz = dz - mz
        beside = hx * hx + hy * hy + hz * hz > ball2
        x = qx * bx + qy * by + qz * bz
        refused = (cosine < least) | (reach > r2) | (t * t > farthest2) | beside
        xs[k] = away if refused else x
        ys[k] = qx * cx + qy * cy + qz * cz
        stretch[k] = inverse * inverse


@uncounted(error_model="numpy")
def take_run(vertices, first, last, sweep, found, at):
    """All vertices of a run that lands well inside the outline, but those facing away.

    First as if there were none of those, in vector instructions; if there are, once more.

    Parameters
    ----------
    vertices : Vertices
    first, last : int
        The run.
    sweep : record of SWEEP
    found : Found
        Filled from `at` on; returned is how many there are then.
    at : int
    """
    ox, oy, oz = _single(sweep.origin)
    ux, uy, uz = _single(sweep.normal)
    r2 = np.float32(sweep.radius2)
    farthest2 = np.float32(sweep.carry2)
    mx, my, mz = _single(sweep.ball)
    ball2 = np.float32(sweep.ball2)
    least = np.float32(LEAST_FACING)
    one = np.float32(1.0)
    n = last - first
    px, py, pz = vertices.px[first:last], vertices.py[first:last], vertices.pz[first:last]
    nx, ny, nz = vertices.nx[first:last], vertices.ny[first:last], vertices.nz[first:last]
    ids = found.ids[at : at + n]
    share = found.share[at : at + n]
    cover = found.cover[at : at + n]
    refused = np.int32(0)
    for k in range(n):
        cosine = nx[k] * ux + ny[k] * uy + nz[k] * uz
        dx = px[k] - ox
        dy = py[k] - oy
        dz = pz[k] - oz
        height = dx * ux + dy * uy + dz * uz
        inverse = one / cosine
        t = height * inverse
        hx = dx - mx
        hy = dy - my
        hz = dz - mz
        beside = hx * hx + hy * hy + hz * hz > ball2
        bad = (cosine < least) | (height * height > r2) | (t * t > farthest2) | beside
        refused += np.int32(bad)
        ids[k] = first + k
        share[k] = inverse * inverse
        cover[k] = -one if bad else one
    if refused == 0:
        return at + n
    kept = 0
    for k in range(n):
        if cover[k] > 0.0:
            ids[kept] = ids[k]
            share[kept] = share[k]
            cover[kept] = one
            kept += 1
    return at + kept

"""Carry vertices to the plane of a stamp along their own normals (Guo 2017, section 4.2.1)."""

from __future__ import annotations

import numpy as np

from paint3d.core.kernel import uncounted

__all__ = ["AWAY", "LEAST_FACING", "project_run", "take_run"]

LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
AWAY = 1e9  # plane coordinate of a vertex that cannot be painted


@uncounted
def _single(vector):
    """The numbers of a vector (3,) in single precision."""
    return np.float32(vector[0]), np.float32(vector[1]), np.float32(vector[2])


@uncounted(error_model="numpy")
def project_run(px, py, pz, nx, ny, nz, first, n, sweep, xs, ys, stretch, at):
    """Carry a run of vertices to the plane along their own normals (Guo 2017, 4.2.1).

    Straight-line float32 code over consecutive memory: the compiler turns it into vector
    instructions. A vertex that faces away, or lands outside the enclosing sphere, is sent far off;
    where it lands and not where it is, for a convex surface falls away from under the tip.
    So is one that would be carried farther than the sweep says, as from a ridge beside the brush,
    or lies outside its ball.
    `stretch` gets the plane's area for one of the surface there, as on a cylinder: 1 / cosine^2.
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
    px, py, pz = px[first : first + n], py[first : first + n], pz[first : first + n]
    nx, ny, nz = nx[first : first + n], ny[first : first + n], nz[first : first + n]
    xs, ys, stretch = xs[at : at + n], ys[at : at + n], stretch[at : at + n]
    for k in range(n):
        dx = px[k] - ox
        dy = py[k] - oy
        dz = pz[k] - oz
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
def take_run(first, last, px, py, pz, nx, ny, nz, sweep, out_ids, out_share, out_cover, found):
    """All vertices of a run that lands well inside the outline, but those facing away.

    First as if there were none of those, in vector instructions; if there are, once more.
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
    px, py, pz = px[first:last], py[first:last], pz[first:last]
    nx, ny, nz = nx[first:last], ny[first:last], nz[first:last]
    ids = out_ids[found : found + n]
    share = out_share[found : found + n]
    cover = out_cover[found : found + n]
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
        return found + n
    kept = 0
    for k in range(n):
        if cover[k] > 0.0:
            ids[kept] = ids[k]
            share[kept] = share[k]
            cover[kept] = one
            kept += 1
    return found + kept

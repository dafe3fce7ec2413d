"""Vertices ask the map of hairs what lies over them, block by block in vector instructions."""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels.bristle_imprint import LANES, STATIONS
from paint3d.kernels.bristle_outline import CELLS, PER_CELL, TIP
from paint3d.kernels.projecting import LEAST_FACING

__all__ = ["ask_imprint"]

_LANE = np.int32(LANES - 1)  # of a place: LANES is a power of 2
_FAINTEST = np.float32(2e-3)  # share covered below which a vertex is left alone
_LAST_CELL = np.float32(CELLS - 1e-3)
_LAST_LANE = np.float32(LANES - 1.001)
_ZERO, _HALF, _ONE = np.float32([0.0, 0.5, 1.0])
_elementwise = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})


@njit(cache=True, nogil=True, error_model="numpy")
def _fetch(found, n, px, py, pz, nx, ny, nz, rows):
    """Places and normals of vertices, side by side."""
    x, y, z, u, v, w = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    for k in range(n):
        i = found[k]
        x[k] = px[i]
        y[k] = py[i]
        z[k] = pz[i]
        u[k] = nx[i]
        v[k] = ny[i]
        w[k] = nz[i]


@_elementwise
def _project(n, frame, rows, xs, ys):
    """Carry vertices to the plane along their normals: as `projecting.project_run`."""
    ox, oy, oz = np.float32(frame[0]), np.float32(frame[1]), np.float32(frame[2])
    ux, uy, uz = np.float32(frame[3]), np.float32(frame[4]), np.float32(frame[5])
    bx, by, bz = np.float32(frame[6]), np.float32(frame[7]), np.float32(frame[8])
    cx, cy, cz = np.float32(frame[9]), np.float32(frame[10]), np.float32(frame[11])
    least = np.float32(LEAST_FACING)
    for k in range(n):
        dx, dy, dz = rows[0, k] - ox, rows[1, k] - oy, rows[2, k] - oz
        nx, ny, nz = rows[3, k], rows[4, k], rows[5, k]
        cosine = nx * ux + ny * uy + nz * uz
        t = (dx * ux + dy * uy + dz * uz) / (cosine if cosine > least else least)
        qx, qy, qz = dx - t * nx, dy - t * ny, dz - t * nz
        xs[k] = qx * bx + qy * by + qz * bz
        ys[k] = qx * cx + qy * cy + qz * cz


@_elementwise
def _find_stations(n, tip, per_cell, cells, widths, xs, places, parts):
    """Which station vertices lie behind, how far towards the next, and half the map's width."""
    for k in range(n):
        at = (tip - xs[k]) * per_cell
        at = at if at > _ZERO else _ZERO
        at = at if at < _LAST_CELL else _LAST_CELL
        cell = np.int32(at)
        station = cells[cell, 0] + (at - np.float32(cell)) * cells[cell, 1]
        s = np.int32(station)
        s = s if s < STATIONS - 2 else np.int32(STATIONS - 2)
        t = station - np.float32(s)
        places[k] = s * np.int32(LANES)
        parts[0, k] = t
        parts[2, k] = widths[s, 0] + t * widths[s, 1]


@_elementwise
def _find_lanes(n, ys, places, parts):
    """The lane that vertices lie beside, how far towards the next, and whether within the map."""
    middle = np.float32(0.5 * LANES)
    for k in range(n):
        beside = ys[k] * middle / parts[2, k]
        lane = beside + (middle - _HALF)
        lane = lane if lane > _ZERO else _ZERO
        lane = lane if lane < _LAST_LANE else _LAST_LANE
        v = np.int32(lane)
        places[k] += v
        parts[1, k] = lane - np.float32(v)
        parts[2, k] = _ONE if abs(beside) < middle else _ZERO


@_elementwise
def _read_map(n, map_, places, parts, inks, covers):
    """Ink and share covered between the four cells around each vertex."""
    for k in range(n):
        i = places[k]
        t, u = parts[0, k], parts[1, k]
        a, b = map_[2 * i], map_[2 * i + 2]
        c, d = map_[2 * (i + LANES)], map_[2 * (i + LANES) + 2]
        one, other = a + u * (b - a), c + u * (d - c)
        inks[k] = one + t * (other - one)
        a, b = map_[2 * i + 1], map_[2 * i + 3]
        c, d = map_[2 * (i + LANES) + 1], map_[2 * (i + LANES) + 3]
        one, other = a + u * (b - a), c + u * (d - c)
        covers[k] = parts[2, k] * (one + t * (other - one))


@njit(cache=True, nogil=True, error_model="numpy")
def _keep(n, places, inks, covers, ids, share, cover, out_ids, out_share, out_cover, out_lanes):
    """Weigh vertices by what they found, and close up over those that found nothing."""
    kept = np.uint32(0)
    for k in range(n):
        covered = covers[k]
        out_ids[kept] = ids[k]
        out_share[kept] = share[k] * inks[k]
        out_cover[kept] = cover[k] * covered
        out_lanes[kept] = places[k] & _LANE
        kept += np.uint32(covered > _FAINTEST)
    return np.int64(kept)


@njit(cache=True, nogil=True, error_model="numpy")
def ask_imprint(imprint, found, share, cover, n, field, room, lanes):
    """Weigh vertices by the imprint where the way ends; return how many the hairs reached.

    The way is no longer than the vertices lie apart: what the hairs left behind on it, the imprint
    before has drawn.

    Parameters
    ----------
    imprint : Imprint
    found, share, cover : (cap + 1,) int32, float32, float32
        From `kernels.gathering.gather`, with their plane in `room.frame`; weighed in place.
    n : int
        Of these.
    field : SurfaceField
    room : Room
    lanes : (cap + 1,) int16
        Filled: each one's lane of the map.
    """
    size = room.ids.shape[0]
    map_ = imprint.map.reshape(imprint.map.size)
    tip, per_cell = np.float32(imprint.numbers[TIP]), np.float32(imprint.numbers[PER_CELL])
    xs, ys, inks, covers = room.packed[0], room.packed[1], room.packed[2], room.packed[3]
    places, parts = room.near[0], room.work[:3]
    kept = 0
    for first in range(0, n, size):
        m = min(size, n - first)
        _fetch(
            found[first : first + m], m, field.px, field.py, field.pz, field.nx, field.ny,
            field.nz, room.rows,
        )  # fmt: skip
        _project(m, room.frame, room.rows, xs, ys)
        _find_stations(m, tip, per_cell, imprint.cells, imprint.widths, xs, places, parts)
        _find_lanes(m, ys, places, parts)
        _read_map(m, map_, places, parts, inks, covers)
        kept += _keep(
            m, places, inks, covers, found[first:], share[first:], cover[first:], found[kept:],
            share[kept:], cover[kept:], lanes[kept:],
        )  # fmt: skip
    return kept

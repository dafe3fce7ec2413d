"""Vertices ask the map of hairs what lies over them, block by block in vector instructions."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.imprint import LANES, STATIONS
from paint3d.brush_engine.bristles.outline import CELLS, PER_CELL, TIP
from paint3d.brush_engine.coverage import weigh_standing
from paint3d.brush_engine.ink_transfer import weighed_area
from paint3d.brush_engine.scratch import Found
from paint3d.brush_engine.sweep import Sweep
from paint3d.brush_engine.vertex_query import VISITED, find_candidates, next_block
from paint3d.core.kernel import kernel, uncounted

__all__ = ["gather_under_hairs"]

_LANE = np.int32(LANES - 1)  # of a place: LANES is a power of 2
_FAINTEST = np.float32(2e-3)  # share covered below which a vertex is left alone
_LAST_CELL = np.float32(CELLS - 1e-3)
_LAST_LANE = np.float32(LANES - 1.001)
_ZERO, _HALF, _ONE = np.float32([0.0, 0.5, 1.0])
_elementwise = kernel(error_model="numpy", fastmath={"contract"})


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


@uncounted(error_model="numpy")
def _keep(n, places, block, found, lanes):
    """Weigh vertices by what they found, and close up over those that found nothing."""
    ids, share, cover = block.packed_ids, block.packed[2], block.packed[3]
    inks, covers = block.packed[4], block.packed[5]
    out_ids, out_share, out_cover = found.ids, found.share, found.cover
    kept = np.uint32(0)
    for k in range(n):
        covered = covers[k]
        out_ids[kept] = ids[k]
        out_share[kept] = share[k] * inks[k]
        out_cover[kept] = cover[k] * covered
        lanes[kept] = places[k] & _LANE
        kept += np.uint32(covered > _FAINTEST)
    return np.int64(kept)


@uncounted(error_model="numpy")
def gather_under_hairs(imprint, stamp, field, scratch, lanes):
    """Find the vertices that hairs lie over, and weigh them by what lies there.

    The way from the stamp before is no longer than the vertices lie apart: what the hairs left
    behind on it, the imprint before has drawn. So vertices are looked up where the way ends.

    Parameters
    ----------
    imprint : Imprint
    stamp : Stamp
        It touches.
    field : SurfaceField
    scratch : Scratch
        `found` is filled.
    lanes : (cap + 1,) int16
        Filled: each one's lane of the map.

    Returns
    -------
    found : int
        Vertices that hairs reached; -1 where the mesh needs room to grow.
    within : int
        Vertices that the outline covers.
    weighed : float
        Area that those stand for, weighed, mm2.
    """
    sweep, block = Sweep(scratch.sweep, scratch.between, stamp, stamp), scratch.block
    n_runs, n_cells = find_candidates(sweep, True, field, scratch)
    if n_cells < 0:
        return -1, 0, 0.0
    map_ = imprint.map.reshape(imprint.map.size)
    tip, per_cell = np.float32(imprint.numbers[TIP]), np.float32(imprint.numbers[PER_CELL])
    packed, places, parts = block.packed, block.near[1], block.work[:3]
    found, within, weighed = 0, 0, 0.0
    while True:
        n = next_block(n_runs, n_cells, False, scratch.sweep[0], field, scratch)
        if n == 0:
            return found, within, weighed
        scratch.counters[VISITED] += n
        m = weigh_standing(n, sweep, block)
        within += m
        weighed += weighed_area(field, block.packed_ids, packed[2], m)
        _find_stations(m, tip, per_cell, imprint.cells, imprint.widths, packed[0], places, parts)
        _find_lanes(m, packed[1], places, parts)
        _read_map(m, map_, places, parts, packed[4], packed[5])
        all_ = scratch.found
        rest = Found(all_.ids[found:], all_.share[found:], all_.cover[found:])
        found += _keep(m, places, block, rest, lanes[found:])

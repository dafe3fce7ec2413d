"""One sweep of a tuft of hairs: the vertices under its way get what the hairs over them leave."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.ink import give_to_hairs, level_hairs, sum_hairs, take_from_hairs
from paint3d.brush_engine.bristles.lookup import gather_under_hairs
from paint3d.brush_engine.bristles.state import UNLEVELLED
from paint3d.brush_engine.ink_transfer import (
    CAPACITY,
    PICKUP,
    contact_level,
    take_up_ink,
    thin_contact,
)
from paint3d.brush_engine.stamp import outline_motion
from paint3d.brush_engine.transfer import landing_share, weighed_area
from paint3d.core.kernel import kernel

__all__ = ["PAINTED", "sweep_hairs"]

PAINTED = 3  # counter: vertices that ink was left on
_LEVELS_EVERY = 2.0  # mm of way
_AREA_STEPS = 2.0**36  # whole numbers to a mm2 in sums of areas


@kernel(error_model="numpy")
def _leave(imprint, landing, found, share, cover, n, area_units, unit, lanes, weights, ink):
    """Leave `landing` (P,) on the vertices, by their shares and by what is in their lanes."""
    n_pigments = landing.shape[0]
    for p in range(n_pigments):
        weights[p] = 0.0
        if landing[p] <= 0.0:
            continue
        total = np.int64(0)  # in whole numbers: the order of the vertices changes nothing
        for k in range(n):
            part = share[k] * imprint.mix[lanes[k], p]
            total += np.int64(part * area_units[found[k]] * unit * _AREA_STEPS)
        if total > 0:
            weights[p] = landing[p] / (total / _AREA_STEPS)
            landing[p] = 0.0
    for p in range(n_pigments):
        if weights[p] > 0.0:
            for k in range(n):
                part = share[k] * imprint.mix[lanes[k], p]
                ink.amounts[found[k], p] += np.float32(weights[p] * part)
    count = ink.n_dirty[0]
    for k in range(n):
        v = found[k]
        if cover[k] > ink.coverage[v]:
            ink.coverage[v] = cover[k]
        if ink.dirty[v] == 0:
            ink.dirty[v] = 1
            ink.dirty_ids[count] = v
            count += 1
    ink.n_dirty[0] = count


@kernel(error_model="numpy")
def sweep_hairs(before, after, ready, bristles, hairs, field, ink, counters, room):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Parameters
    ----------
    before, after : Stamp
        `after` touches.
    ready : float
        What the hairs are ready to give on the way, coats x mm2: what `settle_gifts` found.
    bristles, hairs, field, ink, counters, room : as for `brush_engine.bristles.stroke_loop`

    Conserves: what leaves the hairs is on vertices or counted in `ink.off_surface`.
    """
    width = field.soft_edge
    unit = field.area_unit
    found, within, weighed = gather_under_hairs(
        hairs.imprint, after, field, width, 1.0 / width, counters, room, hairs.lanes
    )
    if found < 0:
        return False
    area = after.values[0].area
    scale = 0.0 if area < width * width and within == 0 else 1.0
    lands = landing_share(area, width, weighed, within)
    level = contact_level(before, after, ink)
    if level < 1.0 and found > 0:  # hairs that run dry give less, and only to the heights
        whole = weighed_area(field.area_units, unit, room.found, room.share, found)
        found = _thin(level, room.found, room.share, room.cover, hairs.lanes, found, field)
        rest = weighed_area(field.area_units, unit, room.found, room.share, found)
        scale *= rest / whole if whole > 0.0 else 0.0
    room.taken[:] = 0.0
    if ink.habit[PICKUP] > 0.0:
        take_up_ink(
            before, after, ready * scale, room.found, room.share, found, field.area_units, unit,
            ink, room.taken,
        )  # fmt: skip
    take_from_hairs(hairs.load, hairs.findings, scale, hairs.whole_sums, hairs.released)
    for p in range(hairs.left.shape[0]):
        hairs.left[p] = hairs.released[p] * lands
        ink.off_surface[p] += hairs.released[p] - hairs.left[p]
    _leave(
        hairs.imprint, hairs.left, room.found, room.share, room.cover, found, field.area_units,
        unit, hairs.lanes, room.part, ink,
    )  # fmt: skip
    ink.off_surface[:] += hairs.left  # what found no vertex
    if ink.habit[PICKUP] > 0.0:
        give_to_hairs(hairs.load, hairs.findings, room.taken)
    each = ink.habit[CAPACITY] / hairs.load.shape[0]
    hairs.memory[UNLEVELLED] += outline_motion(before, after)
    if hairs.memory[UNLEVELLED] >= _LEVELS_EVERY:
        way = hairs.memory[UNLEVELLED]
        level_hairs(bristles, hairs.turned, hairs.load, each, way, hairs.bins)
        hairs.memory[UNLEVELLED] = 0.0
    sum_hairs(hairs.load, ink.load)
    counters[PAINTED] += found
    return True


@kernel(error_model="numpy")
def _thin(level, found, share, cover, lanes, n, field):
    """`thin_contact`, with the lanes of the vertices that stay."""
    kept = 0
    for k in range(n):
        lane = lanes[k]
        found[kept], share[kept], cover[kept] = found[k], share[k], cover[k]
        if thin_contact(level, found[kept:], share[kept:], cover[kept:], 1, field) == 1:
            lanes[kept] = lane
            kept += 1
    return kept

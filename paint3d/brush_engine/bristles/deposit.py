"""One sweep of a tuft of hairs: the vertices under its way get what the hairs over them leave."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.bristles.ink import give_to_hairs, level_hairs, sum_hairs, take_from_hairs
from paint3d.brush_engine.bristles.lookup import gather_under_hairs
from paint3d.brush_engine.ink_transfer import (
    AREA_STEPS,
    contact_level,
    landing_share,
    note_covered,
    take_up_ink,
    touched_share,
    weighed_area,
)
from paint3d.brush_engine.stamp import outline_motion
from paint3d.core.kernel import uncounted

__all__ = ["PAINTED", "sweep_hairs"]

PAINTED = 3  # counter: vertices that ink was left on
_LEVELS_EVERY = 2.0  # mm of way


@uncounted(error_model="numpy")
def _leave(mix, landing, found, n, lanes, field, weights, ink):
    """Leave `landing` (P,) on the vertices, by their shares and by what is in their lanes."""
    n_pigments = landing.shape[0]
    ids, share, areas, unit = found.ids, found.share, field.area_units, field.area_unit
    for p in range(n_pigments):
        weights[p] = 0.0
        if landing[p] <= 0.0:
            continue
        total = np.int64(0)  # in whole numbers: the order of the vertices changes nothing
        for k in range(n):
            part = share[k] * mix[lanes[k], p]
            total += np.int64(part * areas[ids[k]] * unit * AREA_STEPS)
        if total > 0:
            weights[p] = landing[p] / (total / AREA_STEPS)
            landing[p] = 0.0
    amounts = ink.amounts
    for p in range(n_pigments):
        if weights[p] > 0.0:
            for k in range(n):
                part = share[k] * mix[lanes[k], p]
                amounts[ids[k], p] += np.float32(weights[p] * part)
    note_covered(found, n, ink)


@uncounted(error_model="numpy")
def sweep_hairs(before, after, ready, hairs, field, ink, scratch):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Parameters
    ----------
    before, after : Stamp
        `after` touches.
    ready : float
        What the hairs are ready to give on the way, coats x mm2: what `settle_deposits` found.
    hairs, field, ink, scratch : as for `brush_engine.bristles.stroke_loop`

    Conserves: what leaves the hairs is on vertices or counted in `ink.off_surface`
    (docs/model.md, equation (9)).
    """
    width, found = field.soft_edge, scratch.found
    n, within, weighed = gather_under_hairs(hairs.imprint, after, field, scratch, hairs.lanes)
    if n < 0:
        return False
    area = after.values[0].area
    scale = 0.0 if area < width * width and within == 0 else 1.0
    lands = landing_share(area, width, weighed, within)
    level = contact_level(before, after, ink)
    if level < 1.0 and n > 0:  # hairs that run dry give less, and only to the heights
        whole = weighed_area(field, found.ids, found.share, n)
        n = _thin(level, found, hairs.lanes, n, field)
        rest = weighed_area(field, found.ids, found.share, n)
        scale *= rest / whole if whole > 0.0 else 0.0
    scratch.taken[:] = 0.0
    if ink.transfer[0].pickup > 0.0:
        take_up_ink(before, after, ready * scale, found, n, field, ink, scratch.taken)
    take_from_hairs(hairs.load, hairs.hair_contacts, scale, hairs.whole_sums, hairs.released)
    for p in range(hairs.left.shape[0]):
        hairs.left[p] = hairs.released[p] * lands
        ink.off_surface[p] += hairs.released[p] - hairs.left[p]
    _leave(hairs.imprint.mix, hairs.left, found, n, hairs.lanes, field, scratch.part, ink)
    for p in range(hairs.left.shape[0]):  # what found no vertex
        ink.off_surface[p] += hairs.left[p]
    if ink.transfer[0].pickup > 0.0:
        give_to_hairs(hairs.load, hairs.hair_contacts, scratch.taken)
    _level(hairs, ink.transfer[0].capacity, outline_motion(before, after))
    sum_hairs(hairs.load, ink.load)
    scratch.counters[PAINTED] += n
    return True


@uncounted(error_model="numpy")
def _level(hairs, capacity, way):
    """Let hairs share their ink, where the tuft has gone so far (mm) that it is time."""
    memory = hairs.memory[0]
    memory.unlevelled += way
    if memory.unlevelled >= _LEVELS_EVERY:
        each = capacity / hairs.load.shape[0]
        level_hairs(hairs.bristles, hairs.turned, hairs.load, each, memory.unlevelled, hairs.bins)
        memory.unlevelled = 0.0


@uncounted(error_model="numpy")
def _thin(level, found, lanes, n, field):
    """`thin_contact`, with the lanes of the vertices that stay."""
    ids, share, cover = found.ids, found.share, found.cover
    kept = 0
    for k in range(n):
        touched = touched_share(level, field, ids[k])
        if touched > 0.0:
            ids[kept], lanes[kept] = ids[k], lanes[k]
            share[kept] = share[k] * touched
            cover[kept] = cover[k] * touched
            kept += 1
    return kept

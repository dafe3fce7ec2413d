"""What passes between the brush and the vertices that a footprint swept (Guo 2017, Eqs. 12-13)."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.grain import grain_at
from paint3d.brush_engine.stamp import ink_way, outline_motion
from paint3d.core.kernel import uncounted

__all__ = [
    "AREA_STEPS",
    "contact_level",
    "ink_released",
    "landing_share",
    "leave_ink",
    "mean_pressure",
    "note_covered",
    "take_up_ink",
    "thin_contact",
    "touched_share",
    "weighed_area",
]

AREA_STEPS = 2.0**36  # whole numbers to a mm2 in sums of areas
_GRAIN_MM = 0.7  # bumps that a dry brush rides on
_SOFT = 0.2  # of the grain's height, over which contact comes about
_DRY_AT = 0.8  # share of a full load below which a light brush on grain 1 begins to skip
_DRY_PRESSED = 0.4  # less of it at full pressure


@uncounted(error_model="numpy")
def mean_pressure(before, after):
    """Mean pressure on the way between two stamps, 0 to 1."""
    pressure = 0.0
    for values in (before.values[0], after.values[0]):
        if values.touches > 0.0:
            pressure += 0.5 * values.pressure
    return pressure


@uncounted(error_model="numpy")
def contact_level(before, after, ink):
    """How deep into the grain the wet tuft reaches: 1 everywhere, 0 nowhere.

    A full brush floods the grain; one that runs dry touches only what stands out (feibai).
    """
    transfer = ink.transfer[0]
    if transfer.grain <= 0.0 or transfer.capacity <= 0.0:
        return 1.0
    total = 0.0
    for p in range(ink.load.shape[0]):
        total += ink.load[p]
    begins = transfer.grain * (_DRY_AT - _DRY_PRESSED * mean_pressure(before, after))
    return min(1.0, total / (transfer.capacity * begins))


@uncounted(error_model="numpy")
def touched_share(level, field, v):
    """Share of a vertex's area that a tuft touches at a contact level; 0 in the grain's hollows.

    The grain is a function of the place alone (`brush_engine.grain`), whatever the vertices.
    """
    height = grain_at(
        np.float64(field.px[v]), np.float64(field.py[v]), np.float64(field.pz[v]), _GRAIN_MM
    )
    return min(1.0, (height + _SOFT - (1.0 - level) * (1.0 + _SOFT)) / _SOFT)


@uncounted(error_model="numpy")
def thin_contact(level, found, n, field):
    """Take vertices in the hollows of the grain out of contact, smoothly; return how many stay."""
    kept = 0
    for k in range(n):
        v = found.ids[k]
        touched = touched_share(level, field, v)
        if touched > 0.0:
            found.ids[kept] = v
            found.share[kept] = found.share[k] * touched
            found.cover[kept] = found.cover[k] * touched
            kept += 1
    return kept


@uncounted(error_model="numpy")
def take_up_ink(before, after, released, found, n, field, ink, taken):
    """Let the brush take wet ink from the vertices that it passes; fill `taken` (P,), coats x mm2.

    A share 1 - exp(-rate pe ds) of what is there, ds the way over the vertex (mm): any cutting of
    the way takes the same. Never more than there is, nor than the brush has room for after it has
    given `released`.
    """
    ids, share, areas, unit = found.ids, found.share, field.area_units, field.area_unit
    rate = ink.transfer[0].pickup * mean_pressure(before, after) * outline_motion(before, after)
    n_pigments = ink.load.shape[0]
    held = 0.0
    for p in range(n_pigments):
        held += ink.load[p]
        taken[p] = 0.0
    within = 0.0
    for k in range(n):
        v = ids[k]
        part = 1.0 - np.exp(-rate * min(1.0, np.float64(share[k])))
        here = 0.0
        for p in range(n_pigments):
            here += ink.amounts[v, p]
        within += part * here * areas[v] * unit
    if within <= 0.0:
        return
    capacity_left = max(0.0, ink.transfer[0].capacity - held + released)
    scale = min(1.0, capacity_left / within)
    for k in range(n):
        v = ids[k]
        part = scale * (1.0 - np.exp(-rate * min(1.0, np.float64(share[k]))))
        for p in range(n_pigments):
            old = ink.amounts[v, p]
            new = np.float32(old * (1.0 - part))
            ink.amounts[v, p] = new
            taken[p] += (np.float64(old) - np.float64(new)) * areas[v] * unit


@uncounted(error_model="numpy")
def ink_released(before, after, tuft, ink):
    """Ink that leaves the brush on the way between two stamps: R (1 - exp(-eta' pe ds)).

    docs/model.md, equation (8), the continuous form of Guo 2017, Eqs. 12-13, which one step of unit
    length gives back; `ds` is the way that ink is given for (`stamp.ink_way`, mm).
    """
    pressure = 0.0
    n = 0
    for values in (before.values[0], after.values[0]):
        if values.touches > 0.0:
            pressure += values.pressure
        n += 1
    way = ink_way(before, after)
    total = 0.0
    for p in range(ink.load.shape[0]):
        total += ink.load[p]
    return total, total * (1.0 - np.exp(-tuft.transfer_per_mm * pressure / n * way))


@uncounted(error_model="numpy")
def landing_share(area, width, weighed_area, found):
    """Share of the released ink that meets surface; the rest runs off its edge.

    The vertices stand for the area only to within a seam of half their spacing; a shortfall no
    larger than that is not a gap.
    """
    if found == 0:
        return 0.0
    slack = 0.1 + width / np.sqrt(area)
    if slack >= 0.9:
        return 1.0
    return min(1.0, weighed_area / area / (1.0 - slack))


@uncounted(error_model="numpy")
def weighed_area(field, ids, share, n):
    """Area that the found vertices stand for, weighed, mm2.

    Summed in whole numbers, so that the order in which vertices are found, which depends on what
    was refined before, cannot change a bit of it.
    """
    areas, unit = field.area_units, field.area_unit
    total = np.int64(0)
    for k in range(n):
        total += np.int64(share[k] * areas[ids[k]] * unit * AREA_STEPS)
    return total / AREA_STEPS


@uncounted(error_model="numpy")
def leave_ink(found, n, part, ink):
    """Add every vertex's share of each pigment, `part` (P,) of it, and note what is covered."""
    ids, share, amounts = found.ids, found.share, ink.amounts
    for p in range(part.shape[0]):
        column = np.float32(part[p])
        if column != 0.0:
            for k in range(n):
                amounts[ids[k], p] += column * share[k]
    note_covered(found, n, ink)


@uncounted(error_model="numpy")
def note_covered(found, n, ink):
    """Note how much of each vertex's area is covered, and whose colour is out of date."""
    ids, cover, coverage = found.ids, found.cover, ink.coverage
    dirty, dirty_ids, count = ink.dirty, ink.dirty_ids, ink.n_dirty[0]
    for k in range(n):
        v = ids[k]
        if cover[k] > coverage[v]:
            coverage[v] = cover[k]
        if dirty[v] == 0:
            dirty[v] = 1
            dirty_ids[count] = v
            count += 1
    ink.n_dirty[0] = count

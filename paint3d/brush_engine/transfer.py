"""Ink from the brush to the vertices that a footprint swept (Guo 2017, Eqs. 12-13)."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.stamp import ink_way
from paint3d.core.kernel import uncounted

__all__ = ["AREA_STEPS", "ink_released", "landing_share", "leave_ink", "note_covered",
           "weighed_area"]  # fmt: skip

AREA_STEPS = 2.0**36  # whole numbers to a mm2 in sums of areas


@uncounted(error_model="numpy")
def ink_released(before, after, tuft, ink):
    """Ink that leaves the brush on the way between two stamps: R (1 - exp(-eta' pe ds)).

    The continuous form of Guo 2017, Eqs. 12-13, which one step of unit length gives back; `ds` is
    the way that ink is given for (`stamp.ink_way`, mm).
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

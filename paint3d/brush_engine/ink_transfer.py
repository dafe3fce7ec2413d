"""What passes between the brush and wet paint, besides what it leaves: contact and pick-up."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.grain import grain_at
from paint3d.brush_engine.stamp import outline_motion
from paint3d.core.kernel import uncounted

__all__ = ["CAPACITY", "GRAIN", "PICKUP", "REACH", "contact_level", "mean_pressure", "take_up_ink",
           "thin_contact", "touched_share"]  # fmt: skip

# Places in InkField.habit.
PICKUP = 0  # share of the wet ink under the brush that it takes up per mm at full pressure
GRAIN = 1  # of the surface's material, 0 to 1
CAPACITY = 2  # ink in a full brush, coats x mm2
REACH = 3  # length of the tuft that one station of its load stands for, mm

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
    if ink.habit[GRAIN] <= 0.0 or ink.habit[CAPACITY] <= 0.0:
        return 1.0
    total = 0.0
    for p in range(ink.load.shape[0]):
        total += ink.load[p]
    begins = ink.habit[GRAIN] * (_DRY_AT - _DRY_PRESSED * mean_pressure(before, after))
    return min(1.0, total / (ink.habit[CAPACITY] * begins))


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
    rate = ink.habit[PICKUP] * mean_pressure(before, after) * outline_motion(before, after)
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
    capacity_left = max(0.0, ink.habit[CAPACITY] - held + released)
    scale = min(1.0, capacity_left / within)
    for k in range(n):
        v = ids[k]
        part = scale * (1.0 - np.exp(-rate * min(1.0, np.float64(share[k]))))
        for p in range(n_pigments):
            old = ink.amounts[v, p]
            new = np.float32(old * (1.0 - part))
            ink.amounts[v, p] = new
            taken[p] += (np.float64(old) - np.float64(new)) * areas[v] * unit

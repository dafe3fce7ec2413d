"""One sweep of the brush: gather the vertices under its way, and leave ink on them."""

from __future__ import annotations

from paint3d.brush_engine.brush_load import leave_from_stations
from paint3d.brush_engine.gathering import gather
from paint3d.brush_engine.ink_transfer import PICKUP, contact_level, take_up_ink, thin_contact
from paint3d.brush_engine.transfer import ink_released, landing_share, leave_ink, weighed_area
from paint3d.core.kernel import uncounted

__all__ = ["PAINTED", "sweep_deposit"]

PAINTED = 3  # counter: vertices that ink was left on


@uncounted(error_model="numpy")
def sweep_deposit(before, after, tuft, field, ink, counters, room):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Conserves: what leaves `ink.load` is on vertices or counted in `ink.off_surface`.
    """
    width = field.soft_edge
    found = gather(before, after, field, width, 1.0 / width, counters, room)
    if found < 0:
        return False
    weighed = weighed_area(field.area_units, field.area_unit, room.found, room.share, found)
    a = before.values[0]
    b = after.values[0]
    area = 0.5 * (a.area + b.area)
    if a.touches <= 0.0 or b.touches <= 0.0:
        area = max(a.area * a.touches, b.area * b.touches)
    total, released = ink_released(before, after, tuft, ink)
    if area < width * width and found == 0:
        released = 0.0  # a touch finer than the vertices leaves nothing yet
    landing = released * landing_share(area, width, weighed, found)
    level = contact_level(before, after, ink)
    if level < 1.0 and weighed > 0.0:  # a brush that runs dry gives less, and only to the heights
        found = thin_contact(level, room.found, room.share, room.cover, found, field)
        whole = weighed
        weighed = weighed_area(field.area_units, field.area_unit, room.found, room.share, found)
        released *= weighed / whole
        landing *= weighed / whole
    if weighed <= 0.0:
        landing = 0.0
    room.part[:] = 0.0
    room.taken[:] = 0.0
    if ink.habit[PICKUP] > 0.0:
        take_up_ink(
            before, after, released, room.found, room.share, found, field.area_units,
            field.area_unit, ink, room.taken,
        )  # fmt: skip
    if ink.stations.shape[0] > 1:
        leave_from_stations(
            before, after, released, landing, weighed, room.found, room.share, found,
            field.area_units, field.area_unit, field, ink, room.taken,
        )  # fmt: skip
    elif total > 0.0:
        for p in range(ink.load.shape[0]):
            part = ink.load[p] / total
            ink.off_surface[p] += part * (released - landing)
            room.part[p] = part * landing / weighed if weighed > 0.0 else 0.0
            ink.load[p] -= part * released
    if ink.habit[PICKUP] > 0.0 and ink.stations.shape[0] <= 1:
        for p in range(ink.load.shape[0]):
            ink.load[p] += room.taken[p]
    leave_ink(
        room.found, room.share, room.cover, found, room.part,
        ink.amounts, ink.coverage, ink.dirty, ink.dirty_ids, ink.n_dirty,
    )  # fmt: skip
    counters[PAINTED] += found
    return True

"""One sweep of the brush: gather the vertices under its way, and leave ink on them."""

from __future__ import annotations

from paint3d.brush_engine.brush_load import Gift, leave_from_stations
from paint3d.brush_engine.gathering import gather
from paint3d.brush_engine.ink_transfer import PICKUP, contact_level, take_up_ink, thin_contact
from paint3d.brush_engine.transfer import ink_released, landing_share, leave_ink, weighed_area
from paint3d.core.kernel import uncounted

__all__ = ["PAINTED", "sweep_deposit"]

PAINTED = 3  # counter: vertices that ink was left on


@uncounted(error_model="numpy")
def sweep_deposit(before, after, tuft, field, ink, scratch):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Conserves: what leaves `ink.load` is on vertices or counted in `ink.off_surface`.
    """
    width, found = field.soft_edge, scratch.found
    n = gather(before, after, field, scratch)
    if n < 0:
        return False
    weighed = weighed_area(field, found.ids, found.share, n)
    a = before.values[0]
    b = after.values[0]
    area = 0.5 * (a.area + b.area)
    if a.touches <= 0.0 or b.touches <= 0.0:
        area = max(a.area * a.touches, b.area * b.touches)
    total, released = ink_released(before, after, tuft, ink)
    if area < width * width and n == 0:
        released = 0.0  # a touch finer than the vertices leaves nothing yet
    landing = released * landing_share(area, width, weighed, n)
    level = contact_level(before, after, ink)
    if level < 1.0 and weighed > 0.0:  # a brush that runs dry gives less, and only to the heights
        n = thin_contact(level, found, n, field)
        whole = weighed
        weighed = weighed_area(field, found.ids, found.share, n)
        released *= weighed / whole
        landing *= weighed / whole
    if weighed <= 0.0:
        landing = 0.0
    scratch.part[:] = 0.0
    scratch.taken[:] = 0.0
    if ink.habit[PICKUP] > 0.0:
        take_up_ink(before, after, released, found, n, field, ink, scratch.taken)
    if ink.stations.shape[0] > 1:
        gift = Gift(released, landing, weighed)
        leave_from_stations(before, after, gift, found, n, field, ink, scratch.taken)
    elif total > 0.0:
        for p in range(ink.load.shape[0]):
            part = ink.load[p] / total
            ink.off_surface[p] += part * (released - landing)
            scratch.part[p] = part * landing / weighed if weighed > 0.0 else 0.0
            ink.load[p] -= part * released
    if ink.habit[PICKUP] > 0.0 and ink.stations.shape[0] <= 1:
        for p in range(ink.load.shape[0]):
            ink.load[p] += scratch.taken[p]
    leave_ink(found, n, scratch.part, ink)
    scratch.counters[PAINTED] += n
    return True

"""One sweep of the brush: gather the vertices under its way, and leave ink on them."""

from __future__ import annotations

from numba import njit

from paint3d.kernels import stamp as st
from paint3d.kernels.gathering import VISITED, gather
from paint3d.kernels.transfer import ink_released, landing_share, leave_ink, weighed_area

__all__ = ["PAINTED", "VISITED", "sweep_deposit"]

PAINTED = 3  # counter: vertices that ink was left on


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_deposit(before, after, tuft, field, ink, counters, room):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Conserves: what leaves `ink.load` is on vertices or counted in `ink.off_surface`.
    """
    width = field.numbers[2]
    found = gather(before, after, field, width, 1.0 / width, counters, room)
    if found < 0:
        return False
    weighed = weighed_area(field.area_units, field.numbers[3], room.found, room.share, found)
    a = before.values
    b = after.values
    area = 0.5 * (a[st.AREA] + b[st.AREA])
    if a[st.TOUCHES] <= 0.0 or b[st.TOUCHES] <= 0.0:
        area = max(a[st.AREA] * a[st.TOUCHES], b[st.AREA] * b[st.TOUCHES])
    total, released = ink_released(before, after, tuft, ink)
    if area < width * width and found == 0:
        released = 0.0  # a touch finer than the vertices leaves nothing yet
    landing = released * landing_share(area, width, weighed, found)
    if weighed <= 0.0:
        landing = 0.0
    if total > 0.0:
        for p in range(ink.load.shape[0]):
            part = ink.load[p] / total
            ink.off_surface[p] += part * (released - landing)
            room.part[p] = part * landing / weighed if weighed > 0.0 else 0.0
            ink.load[p] -= part * released
    leave_ink(
        room.found, room.share, room.cover, found, room.part,
        ink.amounts, ink.coverage, ink.dirty, ink.dirty_ids, ink.n_dirty,
    )  # fmt: skip
    counters[PAINTED] += found
    return True

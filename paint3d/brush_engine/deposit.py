"""One sweep of the brush: gather the vertices that it covers, and leave ink on them."""

from __future__ import annotations

from paint3d.brush_engine.brush_load import Deposit, leave_from_reservoirs
from paint3d.brush_engine.coverage import weigh_block
from paint3d.brush_engine.distance import INSIDE
from paint3d.brush_engine.ink_transfer import (
    contact_level,
    ink_released,
    landing_share,
    leave_ink,
    take_up_ink,
    thin_contact,
    weighed_area,
)
from paint3d.brush_engine.projecting import take_run, vertices_of
from paint3d.brush_engine.sweep import Sweep
from paint3d.brush_engine.vertex_query import VISITED, find_candidates, next_block
from paint3d.core.kernel import uncounted

__all__ = ["PAINTED", "sweep_deposit"]

PAINTED = 3  # counter: vertices that ink was left on


@uncounted(error_model="numpy", forceinline=True)
def _gather(before, after, field, scratch):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    sweep = Sweep(scratch.sweep, scratch.between, before, after)
    n_runs, n_cells = find_candidates(sweep, False, field, scratch)
    if n_cells < 0:
        return -1
    found = 0
    runs, values, counters = scratch.query.runs, scratch.sweep[0], scratch.counters
    for r in range(n_runs):
        first, last = runs[r, 0], runs[r, 1]
        if runs[r, 2] == INSIDE:
            counters[VISITED] += last - first
            found = take_run(vertices_of(field), first, last, values, scratch.found, found)
    while True:
        n = next_block(n_runs, n_cells, True, values, field, scratch)
        if n == 0:
            return found
        counters[VISITED] += n
        found = weigh_block(n, sweep, scratch.block, scratch.found, found)


@uncounted(error_model="numpy")
def sweep_deposit(before, after, tuft, field, ink, scratch):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Conserves: what leaves `ink.load` is on vertices or counted in `ink.off_surface`
    (docs/model.md, equation (9)).
    """
    width, found = field.soft_edge, scratch.found
    n = _gather(before, after, field, scratch)
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
    if ink.transfer[0].pickup > 0.0:
        take_up_ink(before, after, released, found, n, field, ink, scratch.taken)
    if ink.reservoirs.shape[0] > 1:
        deposit = Deposit(released, landing, weighed)
        leave_from_reservoirs(before, after, deposit, found, n, field, ink, scratch.taken)
    elif total > 0.0:
        for p in range(ink.load.shape[0]):
            part = ink.load[p] / total
            ink.off_surface[p] += part * (released - landing)
            scratch.part[p] = part * landing / weighed if weighed > 0.0 else 0.0
            ink.load[p] -= part * released
    if ink.transfer[0].pickup > 0.0 and ink.reservoirs.shape[0] <= 1:
        for p in range(ink.load.shape[0]):
            ink.load[p] += scratch.taken[p]
    leave_ink(found, n, scratch.part, ink)
    scratch.counters[PAINTED] += n
    return True

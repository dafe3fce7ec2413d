"""Gather the vertices that a sweep covers, and weigh them."""

from __future__ import annotations

from paint3d.brush_engine.coverage import weigh_block
from paint3d.brush_engine.distance import INSIDE
from paint3d.brush_engine.projecting import take_run
from paint3d.brush_engine.vertex_query import VISITED, find_candidates, next_block
from paint3d.core.kernel import uncounted

__all__ = ["gather"]


@uncounted(error_model="numpy")
def gather(before, after, field, margin, scale, counters, room):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    n_runs, n_cells = find_candidates(before, after, False, field, margin, scale, room)
    if n_cells < 0:
        return -1
    found = 0
    runs = room.runs
    for r in range(n_runs):
        if runs[r, 2] == INSIDE:
            counters[VISITED] += runs[r, 1] - runs[r, 0]
            found = take_run(
                runs[r, 0], runs[r, 1], field.px, field.py, field.pz, field.nx, field.ny, field.nz,
                room.sweep[0], room.found, room.share, room.cover, found,
            )  # fmt: skip
    while True:
        n = next_block(
            n_runs, n_cells, True, runs, room.cells, field.head, field.next_in_cell,
            field.cell_sheets, field.vertex_sheet, field.px, field.py, field.pz, field.nx,
            field.ny, field.nz, room.stamps, room.tick[0], room.sweep[0], room.cursor, room.ids,
            room.packed, room.rows,
        )  # fmt: skip
        if n == 0:
            return found
        counters[VISITED] += n
        found = weigh_block(
            n, room.ids, room.rows, room.sweep[0], after.lines, before.lines, room.between,
            room.packed_ids, room.packed, room.work, room.near, room.kinds, room.eights,
            room.found, room.share, room.cover, found,
        )  # fmt: skip

"""Gather the vertices that a sweep covers, and weigh them."""

from __future__ import annotations

from numba import njit

from paint3d.kernels import stamp as st
from paint3d.kernels.cells import flood_patch
from paint3d.kernels.placement import start_sheet
from paint3d.kernels.projecting import AWAY, project_ids, project_run, take_run
from paint3d.kernels.reach import INSIDE, MIXED, find_cells, find_runs
from paint3d.kernels.refine import activate_cell
from paint3d.kernels.sweep import fill_between, fill_frame, sweep_bounds
from paint3d.kernels.weighing import weigh_block

__all__ = ["VISITED", "gather"]

VISITED = 2  # counter: vertices looked at


@njit(cache=True, nogil=True, error_model="numpy")
def _find_cells(before, after, plane, field, room):
    """Cells of the connected patch that the sweep may reach, refined; -1 for want of room."""
    values = plane.values
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    n_sheets = room.patch[0]
    if plane.values[st.TOUCHES] <= 0.0 or after.values[st.TOUCHES] <= 0.0:
        # the brush has just left: the patch that was flooded last is not that of this plane
        room.tick[0] += 1
        n_sheets = flood_patch(
            field, sheet, values[st.SPHERE_X], values[st.SPHERE_X + 1], values[st.SPHERE_X + 2],
            values[st.RADIUS] + field.numbers[1], room.stamps, room.tick[0], room.sheets,
        )  # fmt: skip
    room.tick[1] += 1
    cells = find_cells(
        field.sheet_place, field.sheet_pack, field.origin, field.numbers[1], room.frame,
        before.values, before.half_widths, after.values, after.half_widths, room.sheets, n_sheets,
        room.cell_ticks, room.tick[1], room.discs, room.where, room.cells, room.slopes,
    )  # fmt: skip
    for k in range(cells):
        if field.done[room.cells[k]] == 0 and activate_cell(field, room.cells[k]) < 0:
            return -1
    return cells


@njit(cache=True, nogil=True, error_model="numpy")
def gather(before, after, field, margin, scale, counters, room):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    plane = after if after.values[st.TOUCHES] > 0.0 else before
    sweep_bounds(before, after, plane, margin, room.bounds)
    fill_frame(before, after, plane.values, scale, room.bounds, room.frame)
    fill_between(before, after, room.frame, room.between)
    cells = _find_cells(before, after, plane, field, room)
    if cells < 0:
        return -1
    n_runs = find_runs(
        room.cells, room.slopes, cells, field.base_start, field.cell_blocks, field.block_balls,
        field.cell_sheets, room.frame, before.values, before.half_widths, after.values,
        after.half_widths, room.discs, room.where, room.blocks, room.runs,
    )  # fmt: skip
    return _weigh_runs(
        room.runs, n_runs, room.cells, cells, field.head, field.next_in_cell, field.cell_sheets,
        field.vertex_sheet, field.px, field.py, field.pz, field.nx, field.ny, field.nz,
        room.stamps, room.tick[0], room.frame, after.lines, before.lines, room.between,
        room.packed_ids, room.packed, room.work, room.near, room.kinds, room.eights, room.ids,
        room.rows,
        room.found, room.share, room.cover, counters,
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh_runs(
    runs, n_runs, cells, n_cells, head, next_in_cell, cell_sheets, vertex_sheet,
    px, py, pz, nx, ny, nz, stamps, tick, frame, lines, lines_before, between,
    packed_ids, packed, work, near, kinds, eights, ids, rows, found_ids, share, cover, counters,
):  # fmt: skip
    """Project and weigh the vertices of runs and cells; return how many are painted.

    A block goes on over runs until it is full: base vertices come run by run, added ones along
    their links.
    """
    found = 0
    visited = 0
    size = ids.shape[0]
    filled = 0
    xs, ys, stretch = rows[0], rows[1], rows[2]
    for r in range(n_runs):
        first, last, where = runs[r, 0], runs[r, 1], runs[r, 2]
        visited += last - first
        if where == INSIDE:
            found = take_run(
                first, last, px, py, pz, nx, ny, nz, frame, found_ids, share, cover, found
            )
            continue
        while first < last:
            if filled == size:
                found = weigh_block(
                    filled, ids, rows, frame, lines, lines_before, between, packed_ids, packed,
                    work, near, kinds, eights, found_ids, share, cover, found,
                )  # fmt: skip
                filled = 0
            n = min(last - first, size - filled)
            project_run(px, py, pz, nx, ny, nz, first, n, frame, xs, ys, stretch, filled)
            for k in range(n):
                ids[filled + k] = first + k
            if where == MIXED:
                for k in range(n):
                    if stamps[vertex_sheet[first + k]] != tick:
                        xs[filled + k] = AWAY
            first += n
            filled += n
    for c in range(n_cells):
        v = head[cells[c]]
        one_sheet = cell_sheets[cells[c] + 1] - cell_sheets[cells[c]] == 1
        while v >= 0:
            if filled == size:
                found = weigh_block(
                    filled, ids, rows, frame, lines, lines_before, between, packed_ids, packed,
                    work, near, kinds, eights, found_ids, share, cover, found,
                )  # fmt: skip
                filled = 0
            start = filled
            while v >= 0 and filled < size:
                if one_sheet or stamps[vertex_sheet[v]] == tick:
                    ids[filled] = v
                    filled += 1
                v = next_in_cell[v]
            visited += filled - start
            project_ids(px, py, pz, nx, ny, nz, ids, start, filled, frame, xs, ys, stretch)
    found = weigh_block(
        filled, ids, rows, frame, lines, lines_before, between, packed_ids, packed,
        work, near, kinds, eights, found_ids, share, cover, found,
    )  # fmt: skip
    counters[VISITED] += visited
    return found

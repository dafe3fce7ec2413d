"""The vertices that a sweep may cover, projected onto its plane block by block."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.distance import INSIDE, MIXED, find_cells, find_runs
from paint3d.brush_engine.placement import start_sheet
from paint3d.brush_engine.projecting import AWAY, project_run
from paint3d.brush_engine.sweep import fill_between, fill_sweep, sweep_bounds
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.grid import flood_patch
from paint3d.mesh.kernels.refine import activate_cell

__all__ = ["CURSOR_SIZE", "VISITED", "find_candidates", "next_block"]

VISITED = 2  # counter: vertices looked at

# Places in Room.cursor: where the next block begins.
_RUN, _IN_RUN, _CELL, _IN_CELL = range(4)
CURSOR_SIZE = 4


@uncounted(error_model="numpy")
def _find_cells(before, after, plane, field, room):
    """Cells of the connected patch that the sweep may reach, refined; -1 for want of room."""
    values = plane.values[0]
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    n_sheets = room.patch[0]
    if plane.values[0].touches <= 0.0 or after.values[0].touches <= 0.0:
        # the brush has just left: the patch that was flooded last is not that of this plane
        room.tick[0] += 1
        n_sheets = flood_patch(
            field, sheet, values.sphere_centre, values.radius + field.cell_size, room.stamps,
            room.tick[0], room.sheets,
        )  # fmt: skip
    room.tick[1] += 1
    cells = find_cells(
        field.sheet_place, field.sheet_pack, field.origin, field.cell_size, room.sweep[0],
        before.values[0], before.half_widths, after.values[0], after.half_widths,
        room.sheets, n_sheets,
        room.cell_ticks, room.tick[1], room.discs, room.where, room.cells, room.slopes,
    )  # fmt: skip
    for k in range(cells):
        if field.done[room.cells[k]] == 0 and activate_cell(field, room.cells[k]) < 0:
            return -1
    return cells


@uncounted(error_model="numpy")
def find_candidates(before, after, alone, field, margin, scale, room):
    """Fill the sweep's sweep, and find runs of base vertices and cells that it may reach.

    Parameters
    ----------
    before, after : Stamp
    alone : bool
        Both are the same: what lies under the one stamp is looked for.
    field : SurfaceField
    margin, scale : float
        Width of the soft edge, mm, and boxes of a vertex to the mm.
    room : Room
        `sweep`, `between`, `cells`, `runs` are filled, and `cursor` stands at the beginning.

    Returns
    -------
    runs, cells : int
        How many; cells is -1 where the mesh needs room to grow.
    """
    plane = after if after.values[0].touches > 0.0 else before
    sweep_bounds(before, after, plane, margin, room.bounds)
    fill_sweep(before, after, plane.values[0], scale, room.bounds, room.sweep[0])
    fill_between(before, after, room.sweep[0], room.between)
    if alone:
        room.sweep[0].before_touches = 0.0
    cells = _find_cells(before, after, plane, field, room)
    if cells < 0:
        return 0, cells
    n_runs = find_runs(
        room.cells, room.slopes, cells, field.base_start, field.cell_blocks, field.block_balls,
        field.cell_sheets, room.sweep[0], before.values[0], before.half_widths, after.values[0],
        after.half_widths, room.discs, room.where, room.blocks, room.runs,
    )  # fmt: skip
    cursor = room.cursor
    cursor[_RUN], cursor[_IN_RUN] = 0, room.runs[0, 0]
    cursor[_CELL], cursor[_IN_CELL] = 0, field.head[room.cells[0]]
    return n_runs, cells


@uncounted(error_model="numpy")
def next_block(
    n_runs, n_cells, without_inside, runs, cells, head, next_in_cell, cell_sheets, vertex_sheet,
    px, py, pz, nx, ny, nz, stamps, tick, sweep, cursor, ids, packed, rows,
):  # fmt: skip
    """Project the next vertices that the sweep may reach; return how many (0: there are no more).

    A block goes on over runs and cells until it is full: base vertices come run by run, added ones
    along their links.

    Parameters
    ----------
    n_runs, n_cells : int
        From `find_candidates`.
    without_inside : bool
        Pass over runs that lie within the outline: they were taken whole.
    runs, cells, stamps, sweep, cursor, ids, packed : arrays of `Room`
    tick : int
        Of the patch.
    head, next_in_cell, cell_sheets, vertex_sheet, px, py, pz, nx, ny, nz : arrays of `SurfaceField`
    rows : (7, N) float32
        The first three are filled: plane x, y and stretch; and `ids`.
    """
    xs, ys, stretch = rows[0], rows[1], rows[2]
    size, start = ids.shape[0], 0
    r, first = cursor[_RUN], cursor[_IN_RUN]
    while r < n_runs and start < size:
        last, where = runs[r, 1], runs[r, 2]
        if without_inside and where == INSIDE:
            first = last
        n = min(last - first, size - start)
        project_run(px, py, pz, nx, ny, nz, first, n, sweep, xs, ys, stretch, start)
        for k in range(n):
            ids[start + k] = first + k
        if where == MIXED:
            for k in range(n):
                if stamps[vertex_sheet[first + k]] != tick:
                    xs[start + k] = AWAY
        first += n
        start += n
        if first >= last:
            r += 1
            first = runs[r, 0] if r < n_runs else 0
    cursor[_RUN], cursor[_IN_RUN] = r, first
    end = _list_from_cells(
        n_cells,
        start,
        cells,
        head,
        next_in_cell,
        cell_sheets,
        vertex_sheet,
        stamps,
        tick,
        cursor,
        ids,
    )
    n = end - start
    x, y, z, u, v, w = packed[0], packed[1], packed[2], packed[3], packed[4], packed[5]
    _fetch(n, ids[start:end], px, py, pz, nx, ny, nz, x, y, z, u, v, w)
    project_run(x, y, z, u, v, w, 0, n, sweep, xs, ys, stretch, start)
    return end


@uncounted(error_model="numpy")
def _list_from_cells(
    n_cells, filled, cells, head, next_in_cell, cell_sheets, vertex_sheet, stamps, tick, cursor, ids
):
    """Append the added vertices of cells from where the cursor stands; return how many there are.

    Cells with sheets outside the connected patch give only the vertices of those within.
    """
    size = ids.shape[0]
    c, v = cursor[_CELL], cursor[_IN_CELL]
    while c < n_cells and filled < size:
        if cell_sheets[cells[c] + 1] - cell_sheets[cells[c]] == 1:
            while v >= 0 and filled < size:
                ids[filled] = v
                filled += 1
                v = next_in_cell[v]
        else:
            while v >= 0 and filled < size:
                ids[filled] = v
                filled += np.int64(stamps[vertex_sheet[v]] == tick)
                v = next_in_cell[v]
        if v < 0:
            c += 1
            v = head[cells[c]] if c < n_cells else -1
    cursor[_CELL], cursor[_IN_CELL] = c, v
    return filled


@uncounted(error_model="numpy")
def _fetch(n, ids, px, py, pz, nx, ny, nz, x, y, z, u, v, w):
    """Places and normals of scattered vertices, side by side."""
    for k in range(n):
        i = np.uint32(ids[k])
        x[k] = px[i]
        y[k] = py[i]
        z[k] = pz[i]
        u[k] = nx[i]
        v[k] = ny[i]
        w[k] = nz[i]

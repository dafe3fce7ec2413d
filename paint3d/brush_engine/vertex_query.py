"""The vertices that a sweep may cover, projected onto its plane block by block."""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.distance import INSIDE, MIXED, find_cells, find_runs
from paint3d.brush_engine.placement import start_sheet
from paint3d.brush_engine.projecting import AWAY, Vertices, project_run, vertices_of
from paint3d.brush_engine.sweep import fill_between, fill_sweep, sweep_bounds
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.grid import flood_patch
from paint3d.mesh.kernels.refine import activate_cell

__all__ = ["CURSOR_SIZE", "VISITED", "find_candidates", "next_block"]

VISITED = 2  # counter: vertices looked at

# Places in Query.cursor: where the next block begins.
_RUN, _IN_RUN, _CELL, _IN_CELL = range(4)
CURSOR_SIZE = 4


@uncounted(error_model="numpy", forceinline=True)
def _find_cells(sweep, plane, field, scratch):
    """Cells of the connected patch that the sweep may reach, refined; -1 for want of room."""
    values = plane.values[0]
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    if values.touches <= 0.0 or sweep.after.values[0].touches <= 0.0:
        # the brush has just left: the patch that was flooded last is not that of this plane
        radius = values.radius + field.cell_size
        flood_patch(field, sheet, values.sphere_centre, radius, scratch.patch)
    cells = find_cells(sweep, field, scratch.patch, scratch.query)
    for k in range(cells):
        cell = scratch.query.cells[k]
        if field.done[cell] == 0 and activate_cell(field, cell) < 0:
            return -1
    return cells


@uncounted(error_model="numpy", forceinline=True)
def find_candidates(sweep, alone, field, scratch):
    """Fill a sweep, and find runs of base vertices and cells that it may reach.

    Parameters
    ----------
    sweep : Sweep
        All but its stamps is filled.
    alone : bool
        Both stamps are the same: what lies under the one is looked for.
    field : SurfaceField
    scratch : Scratch
        Of `query`, `cells` and `runs` are filled, and `cursor` stands at the beginning.

    Returns
    -------
    runs, cells : int
        How many; cells is -1 where the mesh needs room to grow.
    """
    before, after, values = sweep.before, sweep.after, sweep.values[0]
    margin, scale = field.soft_edge, 1.0 / field.soft_edge
    plane = after if after.values[0].touches > 0.0 else before
    sweep_bounds(before, after, plane, margin, scratch.bounds)
    fill_sweep(before, after, plane.values[0], scale, scratch.bounds, values)
    fill_between(before, after, values, sweep.between)
    if alone:
        values.before_touches = 0.0
    cells = _find_cells(sweep, plane, field, scratch)
    if cells < 0:
        return 0, cells
    query = scratch.query
    n_runs = find_runs(sweep, field, cells, query)
    query.cursor[_RUN], query.cursor[_IN_RUN] = 0, query.runs[0, 0]
    query.cursor[_CELL], query.cursor[_IN_CELL] = 0, field.head[query.cells[0]]
    return n_runs, cells


@uncounted(error_model="numpy", forceinline=True)
def next_block(n_runs, n_cells, without_inside, sweep, field, scratch):
    """Project the next vertices that the sweep may reach; return how many (0: there are no more).

    A block goes on over runs and cells until it is full: base vertices come run by run, added ones
    along their links.

    Parameters
    ----------
    n_runs, n_cells : int
        From `find_candidates`.
    without_inside : bool
        Pass over runs that lie within the outline: they were taken whole.
    sweep : record of SWEEP
    field : SurfaceField
    scratch : Scratch
        Of `block`, `ids` and the first three of `rows` are filled: plane x, y and stretch.
    """
    block, vertices = scratch.block, vertices_of(field)
    start = _project_runs(n_runs, without_inside, vertices, sweep, field.vertex_sheet, scratch)
    end = _list_from_cells(n_cells, start, field, scratch)
    n = end - start
    packed = block.packed
    scattered = Vertices(packed[0], packed[1], packed[2], packed[3], packed[4], packed[5])
    _fetch(n, block.ids[start:end], vertices, scattered)
    project_run(scattered, 0, n, sweep, block.rows, start)
    return end


@uncounted(error_model="numpy", forceinline=True)
def _project_runs(n_runs, without_inside, vertices, sweep, vertex_sheet, scratch):
    """Project base vertices from where the cursor stands; return how many there are."""
    runs, cursor, ticks, tick = (
        scratch.query.runs, scratch.query.cursor, scratch.patch.ticks, scratch.patch.tick[0]
    )  # fmt: skip
    ids, rows = scratch.block.ids, scratch.block.rows
    size, start = ids.shape[0], 0
    r, first = cursor[_RUN], cursor[_IN_RUN]
    while r < n_runs and start < size:
        last, where = runs[r, 1], runs[r, 2]
        if without_inside and where == INSIDE:
            first = last
        n = min(last - first, size - start)
        project_run(vertices, first, n, sweep, rows, start)
        for k in range(n):
            ids[start + k] = first + k
        if where == MIXED:
            for k in range(n):
                if ticks[vertex_sheet[first + k]] != tick:
                    rows[0, start + k] = AWAY
        first += n
        start += n
        if first >= last:
            r += 1
            first = runs[r, 0] if r < n_runs else 0
    cursor[_RUN], cursor[_IN_RUN] = r, first
    return start


@uncounted(error_model="numpy", forceinline=True)
def _list_from_cells(n_cells, filled, field, scratch):
    """Append the added vertices of cells from where the cursor stands; return how many there are.

    Cells with sheets outside the connected patch give only the vertices of those within.
    """
    head, next_in_cell, cell_sheets = field.head, field.next_in_cell, field.cell_sheets
    cells, cursor, ids = scratch.query.cells, scratch.query.cursor, scratch.block.ids
    ticks, tick = scratch.patch.ticks, scratch.patch.tick[0]
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
                filled += np.int64(ticks[field.vertex_sheet[v]] == tick)
                v = next_in_cell[v]
        if v < 0:
            c += 1
            v = head[cells[c]] if c < n_cells else -1
    cursor[_CELL], cursor[_IN_CELL] = c, v
    return filled


@uncounted(error_model="numpy")
def _fetch(n, ids, vertices, out):
    """Places and normals of scattered vertices, side by side."""
    px, py, pz, nx, ny, nz = vertices
    x, y, z, u, v, w = out
    for k in range(n):
        i = np.uint32(ids[k])
        x[k] = px[i]
        y[k] = py[i]
        z[k] = pz[i]
        u[k] = nx[i]
        v[k] = ny[i]
        w[k] = nz[i]

"""Which vertices a sweep may cover, and where they land in its plane.

What of the surface it can reach: cells, and blocks of vertices in them, are laid into the plane as
discs that hold whatever of them lands there, and share their fate: outside both footprints, well
inside both, or on an edge. Discs are judged many at a time, loop by loop, as vertices are. What is
left is carried to the plane along the vertices' own normals (Guo 2017, section 4.2.1), block by
block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.footprint import (
    LAST_PLACE,
    PROFILE_CELLS,
    fill_between,
    fill_sweep,
    profile_cell,
    sweep_bounds,
)
from paint3d.brush_engine.placement import start_sheet
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.mesh_arrays import BLOCK_VERTICES, as_index, flood_patch
from paint3d.mesh.kernels.paper import MOST_ASIDE_MM
from paint3d.mesh.kernels.refine import activate_cell

__all__ = [
    "CURSOR_SIZE",
    "DISC_ROWS",
    "INSIDE",
    "VISITED",
    "find_candidates",
    "next_block",
    "single",
    "take_run",
    "vertices_of",
]

OUTSIDE, _EDGE, INSIDE = 0, 1, 2  # where a disc lies to the footprints of a sweep
_MIXED = 3  # a run in a cell with several sheets, some of which may not belong to the patch
DISC_ROWS = 7  # float32 rows that discs are judged in: x, y, radius, and four to work in
_STEEPEST = 4.0  # tangent of the angle at which a vertex faces away
_COHERENT = 0.7  # of its area: a sheet whose normal is longer looks one way
_LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
_AWAY = 1e9  # plane coordinate of a vertex that cannot be painted
VISITED = 2  # counter: vertices looked at

# Places in Query.cursor: where the next block begins.
_RUN, _IN_RUN, _CELL, _IN_CELL = range(4)
CURSOR_SIZE = 4


@uncounted(error_model="numpy", apart=True)
def _judge_discs(n, discs, turn, stamp, rises, fates):
    """Where each disc lies to one stamp: OUTSIDE, on its EDGE, or INSIDE.

    The half width rises to its greatest value and falls again, so over an interval it is least
    at one of the ends, and greatest there or at its greatest value.

    Parameters
    ----------
    n : int
    discs : (DISC_ROWS, N) float32
        Plane x, y and radius (mm) in the first three rows.
    turn : (4,) float64
        From the plane to the stamp's own coordinates.
    stamp : Stamp
    rises : (5,) float64
        How far beyond a stamp's edge the edge gets on its way, mm: anywhere, and near its ends;
        half the soft edge; and how near to the heel and to the tip that is. A disc must be farther
        away by the first two to lie outside.
    fates : (N,) uint8
        Filled.
    """
    xs, ys, radii = discs[0], discs[1], discs[2]
    along, low, high, blunt = discs[3], discs[4], discs[5], discs[6]
    ox, oy = np.float32(turn[0]), np.float32(turn[1])
    c, s = np.float32(turn[2]), np.float32(turn[3])
    values, starts, slopes, bluntest = (
        stamp.values[0], stamp.lines[0], stamp.lines[1], stamp.lines[3]
    )  # fmt: skip
    heel, length = np.float32(values.heel), np.float32(values.tip - values.heel)
    widest = np.float32(values.widest)
    middle = np.float32(values.widest_at - values.heel)
    per_step = np.float32(PROFILE_CELLS / (values.tip - values.heel))
    nothing, top = np.float32(0.0), np.float32(LAST_PLACE)
    rise, rise_at_end = np.float32(rises[0]), np.float32(rises[1])
    begin, end = np.float32(rises[3]), length - np.float32(rises[4])
    half_edge = np.float32(rises[2])
    for k in range(n):
        along[k] = c * (xs[k] - ox) + s * (ys[k] - oy) - heel
        low[k] = min(max((along[k] - radii[k]) * per_step, nothing), top)
        high[k] = min(max((along[k] + radii[k]) * per_step, nothing), top)
    for k in range(n):
        i, j = profile_cell(low[k]), profile_cell(high[k])
        blunt[k] = max(bluntest[i], bluntest[j])
        low[k] = starts[i] + low[k] * slopes[i]
        high[k] = starts[j] + high[k] * slopes[j]
    for k in range(n):
        side = abs(c * (ys[k] - oy) - s * (xs[k] - ox))
        r = radii[k]
        most = widest if abs(along[k] - middle) <= r else max(low[k], high[k])
        within = (along[k] - r >= nothing) & (along[k] + r <= length)
        inside = within & (min(low[k], high[k]) >= side + r)
        near_end = (along[k] + r > end) | (along[k] - r < begin)
        out = r + (rise_at_end if near_end else rise)
        # beside a blunt end, the distance to the line of a step is less than the way there
        aside = out + blunt[k] * (out - r + half_edge)
        outside = (along[k] + out < nothing) | (along[k] - out > length) | (side - aside > most)
        fates[k] = np.uint8(0) if outside else (np.uint8(2) if inside else np.uint8(1))


@uncounted(error_model="numpy")
def _judge_sweep(n, discs, sweep, where):
    """Where each disc lies to a sweep: INSIDE both outlines, OUTSIDE both, or on an EDGE.

    `where` (2, N) uint8: the answer comes in the first row. Under a stamp that stands alone, of a
    brush that comes or goes, nothing is inside: it is covered for a part of the time.
    """
    now, then = where[0], where[1]
    values = sweep.values[0]
    if values.after_touches > 0.0:
        _judge_discs(n, discs, values.to_after, sweep.after, values.rises, now)
    else:
        now[:n] = 0
    if values.before_touches > 0.0:
        _judge_discs(n, discs, values.to_before, sweep.before, values.rises, then)
    else:
        then[:n] = 0
    for k in range(n):
        least, most = min(now[k], then[k]), max(now[k], then[k])
        now[k] = max(least, min(most, np.uint8(1)))


@uncounted(error_model="numpy", forceinline=True)
def _lay_cells(values, field, patch, query):
    """Lay the cells of a patch's sheets into a sweep's plane, as discs; how many there are.

    A vertex in a cell lands in the plane within a radius of where the cell's middle lands: half
    the cell's diagonal, and the shift that its own normal gives it at its height.
    """
    cells, slopes = query.cells, query.slopes
    xs, ys, radii = query.discs[0], query.discs[1], query.discs[2]
    sheet_place, pack, origin, size = (
        field.sheet_place, field.sheet_pack, field.origin, field.cell_size
    )  # fmt: skip
    half_diagonal = 0.5 * np.sqrt(3.0) * size + MOST_ASIDE_MM * field.paper
    margin = 0.5 / values.scale
    fx, fy, fz = values.normal[0], values.normal[1], values.normal[2]
    n = 0
    for k in range(patch.count[0]):
        sheet = patch.sheets[k]
        dx = origin[0] + (sheet_place[sheet, 0] + 0.5) * size - values.origin[0]
        dy = origin[1] + (sheet_place[sheet, 1] + 0.5) * size - values.origin[1]
        dz = origin[2] + (sheet_place[sheet, 2] + 0.5) * size - values.origin[2]
        nx, ny, nz, area = pack[sheet, 0], pack[sheet, 1], pack[sheet, 2], pack[sheet, 3]
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        facing = nx * fx + ny * fy + nz * fz
        facing = min(1.0, facing / length) if length > 0.0 else 0.0
        height = abs(dx * fx + dy * fy + dz * fz)
        slope = -1.0
        reach = _STEEPEST
        if length > _COHERENT * area:
            if facing < 0.0:
                continue
            # normals in a sheet differ by about what their mean lacks of unit length
            spread = np.sqrt(max(0.0, 1.0 - length / area))
            slope = np.sqrt(1.0 - facing * facing) / max(facing, _LEAST_FACING) + 2.0 * spread
            slope = min(slope, _STEEPEST)
            reach = slope
        cells[n] = sheet_place[sheet, 3]
        slopes[n] = slope
        xs[n] = dx * values.bend[0] + dy * values.bend[1] + dz * values.bend[2]
        ys[n] = dx * values.cross[0] + dy * values.cross[1] + dz * values.cross[2]
        radii[n] = half_diagonal + reach * (height + half_diagonal) + margin
        n += 1
    return n


@uncounted(error_model="numpy", forceinline=True)
def _find_cells(sweep, field, patch, query):
    """The cells of a patch's sheets that the sweep can reach, each once.

    Parameters
    ----------
    sweep : Sweep
    field : SurfaceField
    patch : Patch
    query : Query
        `cells`, `slopes` and `where` are filled.

    Returns
    -------
    int
        How many there are.
    """
    query.tick[0] += 1
    tick, cell_ticks, cells, slopes = query.tick[0], query.cell_ticks, query.cells, query.slopes
    fates = query.where[0]
    n = _lay_cells(sweep.values[0], field, patch, query)
    _judge_sweep(n, query.discs, sweep, query.where)
    found = 0
    for k in range(n):
        cell = cells[k]
        if fates[k] == OUTSIDE or cell_ticks[cell] == tick:
            continue
        cell_ticks[cell] = tick
        cells[found] = cell
        slopes[found] = slopes[k]
        fates[found] = fates[k]
        found += 1
    return found


@uncounted(error_model="numpy", forceinline=True)
def _find_runs(sweep, field, n_cells, query):
    """Runs (first, end, where) of the base vertices that the sweep can reach; how many there are.

    Cells well inside go as a whole (`where` comes from `_find_cells`), others block by block.

    Parameters
    ----------
    sweep : Sweep
    field : SurfaceField
    n_cells : int
        From `_find_cells`.
    query : Query
        `runs` is filled.
    """
    cells, slopes, blocks, runs = query.cells, query.slopes, query.blocks, query.runs
    xs, ys, radii, fates = query.discs[0], query.discs[1], query.discs[2], query.where[0]
    base_start, cell_blocks, balls, cell_sheets = (
        field.base_start, field.cell_blocks, field.block_balls, field.cell_sheets
    )  # fmt: skip
    values = sweep.values[0]
    margin = 0.5 / values.scale
    ox, oy, oz = values.origin[0], values.origin[1], values.origin[2]
    fx, fy, fz = values.normal[0], values.normal[1], values.normal[2]
    bx, by, bz = values.bend[0], values.bend[1], values.bend[2]
    cx, cy, cz = values.cross[0], values.cross[1], values.cross[2]
    n = 0
    n_runs = 0
    for c in range(n_cells):
        cell = cells[c]
        one_sheet = cell_sheets[cell + 1] - cell_sheets[cell] == 1
        coherent = one_sheet and slopes[c] >= 0.0
        if coherent and fates[c] == INSIDE:
            n_runs = _add_run(runs, n_runs, base_start[cell], base_start[cell + 1], INSIDE)
            continue
        most = INSIDE if coherent else (_EDGE if one_sheet else _MIXED)
        slope = slopes[c] if slopes[c] >= 0.0 else _STEEPEST
        last = base_start[cell + 1]
        first = base_start[cell]
        for block in range(cell_blocks[cell], cell_blocks[cell + 1]):
            dx = balls[block, 0] - ox
            dy = balls[block, 1] - oy
            dz = balls[block, 2] - oz
            xs[n] = dx * bx + dy * by + dz * bz
            ys[n] = dx * cx + dy * cy + dz * cz
            height = abs(dx * fx + dy * fy + dz * fz)
            radii[n] = balls[block, 3] + slope * (height + balls[block, 3]) + margin
            blocks[n, 0] = first
            blocks[n, 1] = min(last, first + BLOCK_VERTICES)
            blocks[n, 2] = most
            first += BLOCK_VERTICES
            n += 1
    _judge_sweep(n, query.discs, sweep, query.where)
    for k in range(n):
        if fates[k] != OUTSIDE:
            fate = min(np.int32(fates[k]), blocks[k, 2]) if blocks[k, 2] != _MIXED else _MIXED
            n_runs = _add_run(runs, n_runs, blocks[k, 0], blocks[k, 1], fate)
    return n_runs


@uncounted(error_model="numpy")
def _add_run(runs, n, first, end, fate):
    """Append a run, or lengthen the last by it; return how many there are."""
    if n > 0 and runs[n - 1, 1] == first and runs[n - 1, 2] == fate:
        runs[n - 1, 1] = end
        return n
    runs[n, 0] = first
    runs[n, 1] = end
    runs[n, 2] = fate
    return n + 1


class _Vertices(NamedTuple):
    """Where outlines meet N vertices, which way they face, what they take: float32 arrays (N,)."""

    px: NDArray  # mm
    py: NDArray
    pz: NDArray
    nx: NDArray  # of the unit normal
    ny: NDArray
    nz: NDArray
    take: NDArray  # times its share of the ink that it takes


@uncounted
def vertices_of(field):
    """The vertices of a `SurfaceField`."""
    return _Vertices(field.mx, field.my, field.mz, field.nx, field.ny, field.nz, field.take)


@uncounted
def single(vector):
    """The numbers of a vector (3,) in single precision."""
    return np.float32(vector[0]), np.float32(vector[1]), np.float32(vector[2])


@uncounted(error_model="numpy", apart=True)
def _project_run(vertices, first, n, sweep, rows, at):
    """Carry a run of vertices to the plane along their own normals (Guo 2017, 4.2.1).

    docs/model.md, equations (7) and (8), in straight-line float32 code over consecutive memory, for
    vector instructions. A vertex that faces away, or lands outside the enclosing sphere, is sent
    far off; where it lands and not where it is, for a convex surface falls away from under the tip.
    So is one that would be carried farther than the sweep says, as from a ridge beside the brush,
    or lies outside its ball.

    Parameters
    ----------
    vertices : Vertices
    first, n : int
        The run: where it begins, and how many they are.
    sweep : record of SWEEP
    rows : (3 or more, N) float32
        The first three are filled from column `at` on: plane x and y, mm, and stretch, the plane's
        area for one of the surface there, as on a cylinder: 1 / cosine^2.
    at : int
    """
    ox, oy, oz = single(sweep.origin)
    ux, uy, uz = single(sweep.normal)
    bx, by, bz = single(sweep.bend)
    cx, cy, cz = single(sweep.cross)
    sx, sy, sz = single(sweep.sphere_centre)
    r2 = np.float32(sweep.radius2)
    farthest2 = np.float32(sweep.carry2)
    mx, my, mz = single(sweep.ball)
    ball2 = np.float32(sweep.ball2)
    least = np.float32(_LEAST_FACING)
    away = np.float32(_AWAY)
    one = np.float32(1.0)
    # slices: indices that cannot be negative are what lets the loop be vectorised
    last = first + n
    px, py, pz = vertices.px[first:last], vertices.py[first:last], vertices.pz[first:last]
    nx, ny, nz = vertices.nx[first:last], vertices.ny[first:last], vertices.nz[first:last]
    take = vertices.take[first:last]
    xs, ys, stretch = rows[0][at : at + n], rows[1][at : at + n], rows[2][at : at + n]
    for k in range(n):
        dx, dy, dz = px[k] - ox, py[k] - oy, pz[k] - oz
        cosine = nx[k] * ux + ny[k] * uy + nz[k] * uz
        safe = max(cosine, least)
        height = dx * ux + dy * uy + dz * uz
        inverse = one / safe
        t = height * inverse
        qx = dx - t * nx[k]
        qy = dy - t * ny[k]
        qz = dz - t * nz[k]
        ex = qx - sx
        ey = qy - sy
        ez = qz - sz
        reach = max(ex * ex + ey * ey + ez * ez, height * height)
        hx = dx - mx
        hy = dy - my
        hz = dz - mz
        beside = hx * hx + hy * hy + hz * hz > ball2
        x = qx * bx + qy * by + qz * bz
        refused = (cosine < least) | (reach > r2) | (t * t > farthest2) | beside
        xs[k] = away if refused else x
        ys[k] = qx * cx + qy * cy + qz * cz
        stretch[k] = inverse * inverse * take[k]


@uncounted(error_model="numpy", apart=True)
def take_run(vertices, first, last, sweep, found, at):
    """All vertices of a run that lands well inside the outline, but those facing away.

    First as if there were none of those, in vector instructions; if there are, once more.

    Parameters
    ----------
    vertices : Vertices
    first, last : int
        The run.
    sweep : record of SWEEP
    found : Found
        Filled from `at` on; returned is how many there are then.
    at : int
    """
    ox, oy, oz = single(sweep.origin)
    ux, uy, uz = single(sweep.normal)
    r2 = np.float32(sweep.radius2)
    farthest2 = np.float32(sweep.carry2)
    mx, my, mz = single(sweep.ball)
    ball2 = np.float32(sweep.ball2)
    least = np.float32(_LEAST_FACING)
    one = np.float32(1.0)
    n = last - first
    px, py, pz = vertices.px[first:last], vertices.py[first:last], vertices.pz[first:last]
    nx, ny, nz = vertices.nx[first:last], vertices.ny[first:last], vertices.nz[first:last]
    take = vertices.take[first:last]
    ids = found.ids[at : at + n]
    share = found.share[at : at + n]
    cover = found.cover[at : at + n]
    refused = np.int32(0)
    for k in range(n):
        cosine = nx[k] * ux + ny[k] * uy + nz[k] * uz
        dx = px[k] - ox
        dy = py[k] - oy
        dz = pz[k] - oz
        height = dx * ux + dy * uy + dz * uz
        inverse = one / cosine
        t = height * inverse
        hx = dx - mx
        hy = dy - my
        hz = dz - mz
        beside = hx * hx + hy * hy + hz * hz > ball2
        bad = (cosine < least) | (height * height > r2) | (t * t > farthest2) | beside
        refused = max(refused, np.int32(bad))  # a sum would be of int64, and halve the lanes
        share[k] = inverse * inverse * take[k]
        cover[k] = -one if bad else one
    for k in range(n):
        ids[k] = first + k
    if refused == 0:
        return at + n
    kept = 0
    for k in range(n):
        if cover[k] > 0.0:
            ids[kept] = ids[k]
            share[kept] = share[k]
            cover[kept] = one
            kept += 1
    return at + kept


@uncounted(error_model="numpy", forceinline=True)
def _refine_cells(sweep, plane, field, scratch):
    """Cells of the connected patch that the sweep may reach, refined; -1 for want of room."""
    values = plane.values[0]
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    if values.touches <= 0.0 or sweep.after.values[0].touches <= 0.0:
        # the brush has just left: the patch that was flooded last is not that of this plane
        radius = values.radius + field.cell_size
        flood_patch(field, sheet, values.sphere_centre, radius, scratch.patch)
    cells = _find_cells(sweep, field, scratch.patch, scratch.query)
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
    cells = _refine_cells(sweep, plane, field, scratch)
    if cells < 0:
        return 0, cells
    query = scratch.query
    n_runs = _find_runs(sweep, field, cells, query)
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
    scattered = _Vertices(
        packed[0], packed[1], packed[2], packed[3], packed[4], packed[5], packed[6]
    )
    _fetch(n, block.ids[start:end], vertices, scattered)
    _project_run(scattered, 0, n, sweep, block.rows, start)
    if field.paper > 0.0:
        _steady(end, block.ids, vertices, field.px, field.py, field.pz, sweep, block.rows)
    return end


@uncounted(error_model="numpy", apart=True)
def _steady(n, ids, vertices, px, py, pz, sweep, rows):
    """Take back the part of paper's shifts that a footprint does not follow.

    docs/model.md, equation (20a).
    """
    bx, by, bz = single(sweep.bend)
    cx, cy, cz = single(sweep.cross)
    begin, rise = np.float32(sweep.steady[0]), np.float32(sweep.steady[1])
    zero, one = np.float32(0.0), np.float32(1.0)
    mx, my, mz, xs, ys = vertices.px, vertices.py, vertices.pz, rows[0], rows[1]
    for k in range(n):
        v = as_index(ids[k])
        dx, dy, dz = px[v] - mx[v], py[v] - my[v], pz[v] - mz[v]
        part = min(max(begin - rise * xs[k], zero), one)
        xs[k] += part * (dx * bx + dy * by + dz * bz)
        ys[k] += part * (dx * cx + dy * cy + dz * cz)


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
        _project_run(vertices, first, n, sweep, rows, start)
        for k in range(n):
            ids[start + k] = first + k
        if where == _MIXED:
            for k in range(n):
                if ticks[vertex_sheet[first + k]] != tick:
                    rows[0, start + k] = _AWAY
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


@uncounted(error_model="numpy", apart=True)
def _fetch(n, ids, vertices, out):
    """Copy scattered vertices side by side."""
    px, py, pz, nx, ny, nz, take = vertices
    x, y, z, u, v, w, t = out
    for k in range(n):
        i = as_index(ids[k])
        x[k] = px[i]
        y[k] = py[i]
        z[k] = pz[i]
        u[k] = nx[i]
        v[k] = ny[i]
        w[k] = nz[i]
        t[k] = take[i]

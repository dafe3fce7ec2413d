"""Which vertices a sweep may cover, and where they land in its plane.

What of the surface it can reach: cells, and blocks of vertices in them, are laid into the plane as
discs that hold whatever of them lands there, and share their fate: never under the footprint, all
the way under it, or on an edge. Discs are judged many at a time by bands of lines along the way.
What is left is carried to the plane along the vertices' own normals (Guo 2017, section 4.2.1),
block by block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.coverage import BANDS, fill_chords, weigh
from paint3d.brush_engine.footprint import fill_sweep
from paint3d.brush_engine.placement import start_sheet
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.mesh_arrays import BLOCK_VERTICES, as_index, flood_patch
from paint3d.mesh.kernels.paper import MOST_ASIDE_MM
from paint3d.mesh.kernels.refine import activate_cell

__all__ = [
    "CURSOR_SIZE",
    "DISC_ROWS",
    "VISITED",
    "find_vertices",
    "single",
]

_OUTSIDE, _EDGE, _INSIDE = 0, 1, 2  # where a disc lies to a sweep
_MIXED = 3  # a run in a cell with several sheets, some of which may not belong to the patch
DISC_ROWS = 3  # float32 rows that discs are judged in: x, y, radius
_STEEPEST = 4.0  # tangent of the angle at which a vertex faces away
_COHERENT = 0.7  # of its area: a sheet whose normal is longer looks one way
_LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
_AWAY = 1e9  # plane coordinate of a vertex that cannot be painted
VISITED = 2  # counter: vertices looked at

# Places in Query.cursor: where the next block begins.
_RUN, _IN_RUN, _CELL, _IN_CELL = range(4)
CURSOR_SIZE = 4


@uncounted(error_model="numpy", apart=True)
def _judge_discs(n, discs, sweep, bands, fates):
    """Classify discs by a sweep: under the footprint all the way, never, or on an EDGE.

    Parameters
    ----------
    n : int
    discs : (DISC_ROWS, N) float32
        x and y along the way and across, and radius, mm.
    sweep : record of SWEEP
    bands : (4, LEVELS BANDS) float32
        Of `fill_chords`.
    fates : (N,) uint8
        Filled.
    """
    xs, ys, radii = discs[0], discs[1], discs[2]
    begins, ends, whole_from, whole_to = bands[0], bands[1], bands[2], bands[3]
    first, per_mm = np.float32(sweep.first), np.float32(sweep.per_mm)
    zero, end = np.float32(0.0), np.float32(BANDS)
    last, one = np.int32(BANDS - 1), np.int32(1)
    for k in range(n):
        x, r = xs[k], radii[k]
        low, high = (ys[k] - r - first) * per_mm, (ys[k] + r - first) * per_mm
        i = min(np.int32(min(max(low, zero), end)), last)
        j = min(np.int32(min(max(high, zero), end)), last)
        level = (np.float32(j - i + one).view(np.int32) >> np.int32(23)) - np.int32(127)
        a = np.uint32(level * np.int32(BANDS) + i) & np.uint32(511)
        b = np.uint32(level * np.int32(BANDS) + j + one - np.int32(one << level)) & np.uint32(511)
        begin, finish = min(begins[a], begins[b]), max(ends[a], ends[b])
        inner, outer = max(whole_from[a], whole_from[b]), min(whole_to[a], whole_to[b])
        outside = (high < zero) | (low > end) | (x + r < begin) | (x - r > finish)
        inside = (low >= zero) & (high <= end) & (x - r >= inner) & (x + r <= outer)
        fates[k] = np.uint8(0) if outside else (np.uint8(2) if inside else np.uint8(1))


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
        xs[n] = dx * values.ahead[0] + dy * values.ahead[1] + dz * values.ahead[2]
        ys[n] = dx * values.aside[0] + dy * values.aside[1] + dz * values.aside[2]
        radii[n] = half_diagonal + reach * (height + half_diagonal)
        n += 1
    return n


@uncounted(error_model="numpy", forceinline=True)
def _find_cells(sweep, bands, field, patch, query):
    """The cells of a patch's sheets that the sweep can reach, each once; how many there are.

    Of `query`, `cells`, `slopes` and `fates` are filled.
    """
    query.tick[0] += 1
    tick, cell_ticks, cells, slopes = query.tick[0], query.cell_ticks, query.cells, query.slopes
    fates = query.fates
    n = _lay_cells(sweep, field, patch, query)
    _judge_discs(n, query.discs, sweep, bands, fates)
    found = 0
    for k in range(n):
        cell = cells[k]
        if fates[k] == _OUTSIDE or cell_ticks[cell] == tick:
            continue
        cell_ticks[cell] = tick
        cells[found] = cell
        slopes[found] = slopes[k]
        fates[found] = fates[k]
        found += 1
    return found


@uncounted(error_model="numpy", forceinline=True)
def _find_runs(sweep, bands, field, n_cells, query):
    """Runs (first, end, where) of the base vertices that the sweep can reach; how many there are.

    Cells well inside go as a whole (`fates` comes from `_find_cells`), and before the others, which
    go block by block. Of `query`, `runs` is filled.
    """
    cells, slopes, runs, fates = query.cells, query.slopes, query.runs, query.fates
    xs, ys, radii, block_fates = query.discs[0], query.discs[1], query.discs[2], query.block_fates
    base_start, cell_blocks, cell_sheets = field.base_start, field.cell_blocks, field.cell_sheets
    balls, n_runs, n = field.block_balls, 0, 0
    bx, by, bz, br = balls[0], balls[1], balls[2], balls[3]
    for c in range(n_cells):
        cell = cells[c]
        if fates[c] == _INSIDE and _is_coherent(cell_sheets, cell, slopes[c]):
            n_runs = _add_run(runs, n_runs, base_start[cell], base_start[cell + 1], _INSIDE)
            continue
        slope = slopes[c] if slopes[c] >= 0.0 else _STEEPEST
        first, last = cell_blocks[cell], cell_blocks[cell + 1]
        end = n + last - first
        _lay_blocks(
            last - first, bx[first:last], by[first:last], bz[first:last], br[first:last], sweep,
            slope, xs[n:end], ys[n:end], radii[n:end],
        )  # fmt: skip
        n = end
    _judge_discs(n, query.discs, sweep, bands, block_fates)
    k = 0
    for c in range(n_cells):
        cell = cells[c]
        is_coherent = _is_coherent(cell_sheets, cell, slopes[c])
        if fates[c] == _INSIDE and is_coherent:
            continue
        one_sheet = cell_sheets[cell + 1] - cell_sheets[cell] == 1
        first, last = base_start[cell], base_start[cell + 1]
        while first < last:
            end, fate = min(last, first + BLOCK_VERTICES), np.int32(block_fates[k])
            if fate != _OUTSIDE:
                if not is_coherent:
                    fate = np.int32(_EDGE if one_sheet else _MIXED)
                n_runs = _add_run(runs, n_runs, first, end, fate)
            first = end
            k += 1
    return n_runs


@uncounted(error_model="numpy", forceinline=True)
def _is_coherent(cell_sheets, cell, slope):
    """Whether a cell holds one sheet of surface, which looks one way."""
    return cell_sheets[cell + 1] - cell_sheets[cell] == 1 and slope >= 0.0


@uncounted(error_model="numpy", apart=True)
def _lay_blocks(n, px, py, pz, reach, sweep, slope, xs, ys, radii):
    """Lay blocks into a sweep's plane, as `_lay_cells` does cells, by the balls that hold them."""
    ox, oy, oz = sweep.origin[0], sweep.origin[1], sweep.origin[2]
    fx, fy, fz = sweep.normal[0], sweep.normal[1], sweep.normal[2]
    bx, by, bz = sweep.ahead[0], sweep.ahead[1], sweep.ahead[2]
    cx, cy, cz = sweep.aside[0], sweep.aside[1], sweep.aside[2]
    for k in range(n):
        dx, dy, dz = px[k] - ox, py[k] - oy, pz[k] - oz
        xs[k] = dx * bx + dy * by + dz * bz
        ys[k] = dx * cx + dy * cy + dz * cz
        height = abs(dx * fx + dy * fy + dz * fz)
        radii[k] = reach[k] + slope * (height + reach[k])


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
    """Positions, unit normals and uptake of N vertices: float32 arrays (N,)."""

    px: NDArray  # mm
    py: NDArray
    pz: NDArray
    nx: NDArray  # of the unit normal
    ny: NDArray
    nz: NDArray
    take: NDArray  # times its fraction of the ink that it takes


@uncounted
def single(vector):
    """The numbers of a vector (3,) in single precision."""
    return np.float32(vector[0]), np.float32(vector[1]), np.float32(vector[2])


@uncounted(error_model="numpy", apart=True)
def _project_run(vertices, first, n, sweep, xs, ys, stretch):
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
    xs, ys, stretch : (n or more,) float32
        Filled: x and y along the way and across, mm, and the plane's area for one of the surface
        there, as on a cylinder, 1 / cosine^2.
    """
    ox, oy, oz = single(sweep.origin)
    ux, uy, uz = single(sweep.normal)
    bx, by, bz = single(sweep.ahead)
    cx, cy, cz = single(sweep.aside)
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
def _cover_whole(n, xs, fraction, cover):
    """Cover vertices that lie well inside the outline all the way, but those that were sent off.

    `fraction` holds their stretch.
    """
    zero, one, far = np.float32(0.0), np.float32(1.0), np.float32(0.5 * _AWAY)
    for k in range(n):
        here = one if xs[k] < far else zero
        fraction[k] *= here
        cover[k] = here


@uncounted(error_model="numpy", forceinline=True)
def _refine_cells(sweep, bands, plane, whole, field, scratch):
    """Cells of the connected patch that the sweep may reach, refined; -1 for want of room.

    `whole`: both stamps touch. Else the brush comes or goes, and the patch that was flooded last
    may not be that of this plane.
    """
    values = plane.values[0]
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    if not whole:
        radius = values.radius + field.cell_size
        flood_patch(field, sheet, values.sphere_centre, radius, scratch.patch)
    cells = _find_cells(sweep, bands, field, scratch.patch, scratch.query)
    for k in range(cells):
        cell = scratch.query.cells[k]
        if field.done[cell] == 0 and activate_cell(field, cell) < 0:
            return -1
    return cells


@uncounted(error_model="numpy", forceinline=True)
def _find_candidates(before, after, field, scratch):
    """Fill a sweep, and find runs of base vertices and cells that it may reach.

    Of `query`, `cells` and `runs` are filled, and `cursor` stands at the beginning. Returns how
    many there are; cells is -1 where the mesh needs room to grow.
    """
    first, last, sweep = before, after, scratch.sweep[0]
    plane = after if after.values[0].touches > 0.0 else before
    whole = before.values[0].touches > 0.0 and after.values[0].touches > 0.0
    if not whole:  # one comes or goes: it stands there all the way
        first, last = plane, plane
    fill_sweep(first, last, plane.values[0], 1.0 / field.soft_edge, sweep)
    fill_chords(first, last, sweep, scratch.chords)
    bands = scratch.chords.bands
    cells = _refine_cells(sweep, bands, plane, whole, field, scratch)
    if cells < 0:
        return 0, cells
    query = scratch.query
    n_runs = _find_runs(sweep, bands, field, cells, query)
    query.cursor[_RUN], query.cursor[_IN_RUN] = 0, query.runs[0, 0]
    query.cursor[_CELL], query.cursor[_IN_CELL] = 0, field.head[query.cells[0]]
    return n_runs, cells


@uncounted(error_model="numpy")
def find_vertices(before, after, field, scratch):
    """Find and weigh every vertex that a sweep may cover.

    Parameters
    ----------
    before, after : Stamp
        One of them touches.
    field : SurfaceField
    scratch : Scratch
        `sweep`, `chords` and `found` are filled.

    Returns
    -------
    int
        How many were found, some of which have no fraction; -1 where the mesh needs room to grow.
    """
    n_runs, n_cells = _find_candidates(before, after, field, scratch)
    if n_cells < 0:
        return -1
    runs, sweep, found, block = scratch.query.runs, scratch.sweep[0], scratch.found, scratch.block
    chords = scratch.chords
    vertices = _Vertices(field.mx, field.my, field.mz, field.nx, field.ny, field.nz, field.take)
    at = 0
    found.count[0] = 0
    for r in range(n_runs):
        first, n = runs[r, 0], runs[r, 1] - runs[r, 0]
        if runs[r, 2] == _INSIDE:
            xs, fraction = found.ahead[at : at + n], found.fraction[at : at + n]
            _project_run(vertices, first, n, sweep, xs, found.aside[at : at + n], fraction)
            _cover_whole(n, xs, fraction, found.cover[at : at + n])
            at = _note_run(first, n, found, at)
    while True:
        n = _next_block(n_runs, n_cells, at, vertices, field, scratch)
        if n == 0:
            scratch.counters[VISITED] += at
            return at
        xs, ys = found.ahead[at : at + n], found.aside[at : at + n]
        fraction, cover = found.fraction[at : at + n], found.cover[at : at + n]
        weigh(
            n, sweep.scale, chords.flanks, chords.grids, chords.lines[0], chords.lines[1], xs, ys,
            block.stretch, fraction, cover,
        )  # fmt: skip
        at += n


@uncounted(error_model="numpy")
def _note_run(first, n, found, at):
    """Note that a run of vertices has been found, after `at` others; how many these are then."""
    ids, r = found.ids[at : at + n], found.count[0]
    found.runs[r, 0], found.runs[r, 1] = first, n
    found.count[0] = r + 1
    for k in range(n):
        ids[k] = first + k
    return at + n


@uncounted(error_model="numpy", forceinline=True)
def _next_block(n_runs, n_cells, at, vertices, field, scratch):
    """Project the next vertices that may be on an edge; return how many (0: there are no more).

    A block goes on over runs and cells until it is full: base vertices come run by run, added ones
    along their links. They are found after `at` others, and their stretch is the block's.
    """
    stretch, work = scratch.block.stretch, scratch.block.work
    sweep, found, size = scratch.sweep[0], scratch.found, stretch.shape[0]
    xs, ys, ids = (
        found.ahead[at : at + size], found.aside[at : at + size], found.ids[at : at + size]
    )  # fmt: skip
    start = _project_runs(n_runs, at, vertices, field.vertex_sheet, xs, ys, scratch)
    end = _list_from_cells(n_cells, start, ids, field, scratch)
    n = end - start
    scattered = _Vertices(work[0], work[1], work[2], work[3], work[4], work[5], work[6])
    _fetch(n, ids[start:end], vertices, scattered)
    _project_run(scattered, 0, n, sweep, xs[start:end], ys[start:end], stretch[start:end])
    if field.paper > 0.0:
        _steady(end, ids, vertices, field.px, field.py, field.pz, sweep, xs, ys)
    return end


@uncounted(error_model="numpy", apart=True)
def _steady(n, ids, vertices, px, py, pz, sweep, xs, ys):
    """Take back the part of paper's shifts that a footprint does not follow.

    docs/model.md, equation (20a).
    """
    bx, by, bz = single(sweep.ahead)
    cx, cy, cz = single(sweep.aside)
    begin, rise, rise_aside = single(sweep.steady)
    zero, one = np.float32(0.0), np.float32(1.0)
    mx, my, mz = vertices.px, vertices.py, vertices.pz
    for k in range(n):
        v = as_index(ids[k])
        dx, dy, dz = px[v] - mx[v], py[v] - my[v], pz[v] - mz[v]
        part = min(max(begin - rise * xs[k] - rise_aside * ys[k], zero), one)
        xs[k] += part * (dx * bx + dy * by + dz * bz)
        ys[k] += part * (dx * cx + dy * cy + dz * cz)


@uncounted(error_model="numpy", forceinline=True)
def _project_runs(n_runs, at, vertices, vertex_sheet, xs, ys, scratch):
    """Project base vertices from where the cursor stands; return how many there are."""
    runs, cursor, ticks, tick = (
        scratch.query.runs, scratch.query.cursor, scratch.patch.ticks, scratch.patch.tick[0]
    )  # fmt: skip
    sweep, stretch, start = scratch.sweep[0], scratch.block.stretch, 0
    size = stretch.shape[0]
    r, first = cursor[_RUN], cursor[_IN_RUN]
    while r < n_runs and start < size:
        last, where = runs[r, 1], runs[r, 2]
        if where == _INSIDE:  # has been taken whole
            first = last
        n = min(last - first, size - start)
        if n > 0:
            end = start + n
            own_xs, own_ys, own_stretch = xs[start:end], ys[start:end], stretch[start:end]
            _project_run(vertices, first, n, sweep, own_xs, own_ys, own_stretch)
            _note_run(first, n, scratch.found, at + start)
        if where == _MIXED:
            for k in range(n):
                if ticks[vertex_sheet[first + k]] != tick:
                    xs[start + k] = _AWAY
        first += n
        start += n
        if first >= last:
            r += 1
            first = runs[r, 0] if r < n_runs else 0
    cursor[_RUN], cursor[_IN_RUN] = r, first
    return start


@uncounted(error_model="numpy", forceinline=True)
def _list_from_cells(n_cells, filled, ids, field, scratch):
    """Append the added vertices of cells from where the cursor stands; return how many there are.

    Cells with sheets outside the connected patch give only the vertices of those within.
    """
    head, next_in_cell, cell_sheets = field.head, field.next_in_cell, field.cell_sheets
    cells, cursor = scratch.query.cells, scratch.query.cursor
    ticks, tick = scratch.patch.ticks, scratch.patch.tick[0]
    size = scratch.block.stretch.shape[0]
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

"""What of the surface a sweep can reach: cells, and blocks of vertices in them.

Each is laid into the plane as a disc that holds whatever of it lands there, and shares its fate:
outside both footprints, well inside both, or on an edge. Discs are judged many at a time, loop by
loop, as vertices are.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine import stamp as st
from paint3d.brush_engine.projecting import LEAST_FACING
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.mesh_arrays import BLOCK_VERTICES

__all__ = ["DISC_ROWS", "EDGE", "INSIDE", "MIXED", "find_cells", "find_runs"]

OUTSIDE, EDGE, INSIDE = 0, 1, 2  # where a disc lies to the footprints of a sweep
MIXED = 3  # a run in a cell with several sheets, some of which may not belong to the patch
DISC_ROWS = 6  # float32 rows that discs are judged in: x, y, radius, and three to work in
_STEEPEST = 4.0  # tangent of the angle at which a vertex faces away
_END_ZONE = 0.0625  # of its length: how far an outline's end reaches
_COHERENT = 0.7  # of its area: a sheet whose normal is longer looks one way


@uncounted(error_model="numpy")
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
    rises : (4,) float64
        How far beyond a stamp's edge the edge gets on its way, mm: anywhere, and near the tip;
        and how near that is; and half the soft edge. A disc must be farther away by the first
        two to lie outside.
    fates : (N,) uint8
        Filled.
    """
    xs, ys, radii, along, low, high = discs[0], discs[1], discs[2], discs[3], discs[4], discs[5]
    ox, oy = np.float32(turn[0]), np.float32(turn[1])
    c, s = np.float32(turn[2]), np.float32(turn[3])
    values, widths = stamp.values[0], stamp.half_widths
    heel, length = np.float32(values.heel), np.float32(values.tip - values.heel)
    widest = np.float32(values.widest)
    middle = np.float32(values.widest_at - values.heel)
    per_step = np.float32(st.PROFILE_CELLS / (values.tip - values.heel))
    nothing, top = np.float32(0.0), np.float32(st.PROFILE_CELLS)
    rise, rise_at_end = np.float32(rises[0]), np.float32(rises[1])
    end = length - np.float32(rises[2])
    # beside a blunt end, the distance to the line of its last step is less than the way there
    least = np.float32(rises[3] + rises[0])
    steepest = max(widths[1], widths[st.PROFILE_CELLS - 1]) * st.PROFILE_CELLS
    slope = steepest / (values.tip - values.heel)
    blunt = np.float32(np.sqrt(1.0 + slope * slope) - 1.0) * least
    zone = length * np.float32(_END_ZONE)
    for k in range(n):
        along[k] = c * (xs[k] - ox) + s * (ys[k] - oy) - heel
        low[k] = min(max((along[k] - radii[k]) * per_step, nothing), top)
        high[k] = min(max((along[k] + radii[k]) * per_step, nothing), top)
    for k in range(n):
        i = np.int32(low[k])
        j = np.int32(high[k])
        low[k] = widths[i] + (low[k] - np.float32(i)) * (widths[i + 1] - widths[i])
        high[k] = widths[j] + (high[k] - np.float32(j)) * (widths[j + 1] - widths[j])
    for k in range(n):
        side = abs(c * (ys[k] - oy) - s * (xs[k] - ox))
        r = radii[k]
        most = widest if abs(along[k] - middle) <= r else max(low[k], high[k])
        within = (along[k] - r >= nothing) & (along[k] + r <= length)
        inside = within & (min(low[k], high[k]) >= side + r)
        out = r + (rise_at_end if along[k] + r > end else rise)
        at_end = (along[k] - r < zone) | (along[k] + r > length - zone)
        aside = out + (blunt if at_end else nothing)
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
    half_diagonal = 0.5 * np.sqrt(3.0) * size
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
            slope = np.sqrt(1.0 - facing * facing) / max(facing, LEAST_FACING) + 2.0 * spread
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
def find_cells(sweep, field, patch, query):
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
def find_runs(sweep, field, n_cells, query):
    """Runs (first, end, where) of the base vertices that the sweep can reach; how many there are.

    Cells well inside go as a whole (`where` comes from `find_cells`), others block by block.

    Parameters
    ----------
    sweep : Sweep
    field : SurfaceField
    n_cells : int
        From `find_cells`.
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
        most = INSIDE if coherent else (EDGE if one_sheet else MIXED)
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
            fate = min(np.int32(fates[k]), blocks[k, 2]) if blocks[k, 2] != MIXED else MIXED
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

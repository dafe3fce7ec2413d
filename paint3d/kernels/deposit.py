"""Sweep a footprint from one stamp to the next and leave ink on what it passes.

Guo 2017 carries each effective vertex to the plane along its own normal and asks whether it lies
inside the outline. Here it is asked for how long: the vertex's distance to the moving outline is
interpolated between the two stamps, and its share of the ink is the mean share of the vertex's own
small box that the footprint covered meanwhile. That closes the gaps between samples (Guo 2015,
section 3.2), does not darken with the sampling rate, and draws edges finer than the vertices.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels import stamp as st
from paint3d.kernels.cells import flood_patch
from paint3d.kernels.placement import start_sheet
from paint3d.kernels.refine import activate_cell

__all__ = ["FRAME_SIZE", "PAINTED", "VISITED", "sweep_deposit"]

VISITED, PAINTED = 2, 3  # counters
_LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
_STEEPEST = 4.0  # tangent of the angle at which a vertex faces away
_COHERENT = 0.7  # of its area: a sheet whose normal is longer looks one way
_WORTH_A_RUN = 16  # base vertices in a cell that are read where they stand
_AWAY = 1e9  # plane coordinate of a vertex that cannot be painted


@njit(cache=True, nogil=True)
def _covered(edge):
    """Share of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(1.0, max(0.0, 0.5 + edge))


@njit(cache=True, nogil=True)
def _covered_sum(edge):
    """Antiderivative of `_covered`."""
    t = 0.5 + edge
    if t <= 0.0:
        return 0.0
    if t >= 1.0:
        return t - 0.5
    return 0.5 * t * t


@njit(cache=True, nogil=True)
def _mean_covered(a, b):
    """Mean of `_covered` while the edge distance goes evenly from a to b."""
    d = b - a
    if abs(d) < 1e-6:
        return _covered(0.5 * (a + b))
    return (_covered_sum(b) - _covered_sum(a)) / d


@njit(cache=True, nogil=True)
def _sweep_bounds(before, after, plane, margin, bounds):
    """Rectangle (x0, x1, y0, y1) in the plane of the stamp `plane` that holds both outlines.

    Also fills bounds[4:8] with the turn that carries its coordinates to those of `before`: x' = c (x - ox) + s (y - oy), y' = -s (x - ox) + c (y - oy).
    """
    a = before.values
    b = plane.values
    ox = 0.0
    oy = 0.0
    c = 0.0
    s = 0.0
    for k in range(3):
        d = a[st.ORIGIN_X + k] - b[st.ORIGIN_X + k]
        ox += d * b[st.BEND_X + k]
        oy += d * b[st.CROSS_X + k]
        c += a[st.BEND_X + k] * b[st.BEND_X + k]
        s += a[st.BEND_X + k] * b[st.CROSS_X + k]
    norm = np.sqrt(c * c + s * s)
    if norm > 1e-9:
        c /= norm
        s /= norm
    else:
        c, s = 1.0, 0.0
    bounds[4] = ox
    bounds[5] = oy
    bounds[6] = c
    bounds[7] = s
    x0, x1, y0, y1 = 1e30, -1e30, 1e30, -1e30
    if after.values[st.TOUCHES] > 0.0:
        x0, x1, y0, y1 = b[st.HEEL], b[st.TIP], -b[st.WIDEST], b[st.WIDEST]
    if a[st.TOUCHES] > 0.0:
        for u in (a[st.HEEL], a[st.TIP]):
            for v in (-a[st.WIDEST], a[st.WIDEST]):
                x = ox + c * u - s * v
                y = oy + s * u + c * v
                x0 = min(x0, x)
                x1 = max(x1, x)
                y0 = min(y0, y)
                y1 = max(y1, y)
    bounds[0] = x0 - margin
    bounds[1] = x1 + margin
    bounds[2] = y0 - margin
    bounds[3] = y1 + margin


@njit(cache=True, nogil=True)
def _may_hold(values, area, normal, cell_x, cell_y, cell_z, half_diagonal, bounds):
    """Whether a sheet in the cell around a point can reach the rectangle, carried to the plane."""
    dx = cell_x - values[st.ORIGIN_X]
    dy = cell_y - values[st.ORIGIN_X + 1]
    dz = cell_z - values[st.ORIGIN_X + 2]
    nx = values[st.NORMAL_X]
    ny = values[st.NORMAL_X + 1]
    nz = values[st.NORMAL_X + 2]
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    facing = normal[0] * nx + normal[1] * ny + normal[2] * nz
    facing = min(1.0, facing / length) if length > 0.0 else 0.0
    slope = _STEEPEST
    if length > _COHERENT * area:
        if facing < 0.0:
            return False
        # normals within the sheet differ by about as much as their mean falls short of unit length
        spread = np.sqrt(max(0.0, 1.0 - length / area))
        slope = np.sqrt(1.0 - facing * facing) / max(facing, _LEAST_FACING) + 2.0 * spread
    height = abs(dx * nx + dy * ny + dz * nz)
    slack = half_diagonal + min(slope, _STEEPEST) * (height + half_diagonal)
    x = dx * values[st.BEND_X] + dy * values[st.BEND_Y] + dz * values[st.BEND_Z]
    y = dx * values[st.CROSS_X] + dy * values[st.CROSS_X + 1] + dz * values[st.CROSS_X + 2]
    return (
        bounds[0] - slack <= x <= bounds[1] + slack and bounds[2] - slack <= y <= bounds[3] + slack
    )


# Places in the frame of a sweep: everything that the loop over vertices needs, as one array.
_ORIGIN, _NORMAL, _BEND, _CROSS, _SPHERE = 0, 3, 6, 9, 12
_RADIUS2, _BOX, _BOX_BEFORE, _SCALE, _AFTER, _BEFORE = 15, 16, 20, 24, 25, 29
FRAME_SIZE = 33  # numbers in the frame


@njit(cache=True, nogil=True)
def _fill_frame(before, after, plane, scale, bounds, frame):
    """Gather the numbers of a sweep from its stamps; `plane` holds the plane's values."""
    for k in range(3):
        frame[_ORIGIN + k] = plane[st.ORIGIN_X + k]
        frame[_NORMAL + k] = plane[st.NORMAL_X + k]
        frame[_BEND + k] = plane[st.BEND_X + k]
        frame[_CROSS + k] = plane[st.CROSS_X + k]
        frame[_SPHERE + k] = plane[st.SPHERE_X + k] - plane[st.ORIGIN_X + k]
    frame[_RADIUS2] = plane[st.RADIUS] * plane[st.RADIUS]
    for k in range(8):
        frame[_BOX + k] = bounds[k]
    frame[_SCALE] = scale
    for at, values in ((_AFTER, after.values), (_BEFORE, before.values)):
        length = values[st.TIP] - values[st.HEEL]
        frame[at] = values[st.TOUCHES]
        frame[at + 1] = values[st.HEEL]
        frame[at + 2] = values[st.TIP]
        frame[at + 3] = st.PROFILE_CELLS / length if length > 0.0 else 0.0


@njit(cache=True, nogil=True)
def _project_block(px, py, pz, nx, ny, nz, frame, xs, ys, facing):
    """Carry a block of vertices to the plane along their own normals (Guo 2017, 4.2.1).

    Straight-line float32 code over consecutive memory: the compiler turns it into vector
    instructions. A vertex outside the enclosing sphere, or facing away, is sent far off.
    """
    ox, oy, oz = np.float32(frame[0]), np.float32(frame[1]), np.float32(frame[2])
    ux, uy, uz = np.float32(frame[3]), np.float32(frame[4]), np.float32(frame[5])
    bx, by, bz = np.float32(frame[6]), np.float32(frame[7]), np.float32(frame[8])
    cx, cy, cz = np.float32(frame[9]), np.float32(frame[10]), np.float32(frame[11])
    sx, sy, sz = np.float32(frame[12]), np.float32(frame[13]), np.float32(frame[14])
    r2 = np.float32(frame[_RADIUS2])
    least = np.float32(_LEAST_FACING)
    away = np.float32(_AWAY)
    for k in range(px.shape[0]):
        dx = px[k] - ox
        dy = py[k] - oy
        dz = pz[k] - oz
        cosine = nx[k] * ux + ny[k] * uy + nz[k] * uz
        safe = max(cosine, least)
        t = -(dx * ux + dy * uy + dz * uz) / safe
        qx = dx + t * nx[k]
        qy = dy + t * ny[k]
        qz = dz + t * nz[k]
        ex = dx - sx
        ey = dy - sy
        ez = dz - sz
        x = qx * bx + qy * by + qz * bz
        outside = (cosine < least) | (ex * ex + ey * ey + ez * ez > r2)
        xs[k] = away if outside else x
        ys[k] = qx * cx + qy * cy + qz * cz
        facing[k] = safe


@njit(cache=True, nogil=True)
def _edges(widths, steepness, touches, heel, tip, per_step, x, side):
    """Signed distances (mm) from a point to the outline's near and far side; inside is positive.

    Together they give the share of a small box around the point that lies within the outline,
    right also where the footprint is thinner than the box.
    """
    if x < heel:
        return x - heel - side, x - heel + side
    if x > tip:
        return tip - x - side, tip - x + side
    at = (x - heel) * per_step
    i = int(at)
    t = at - i
    width = (1.0 - t) * widths[i] + t * widths[i + 1]
    return (width - side) * steepness[i], (width + side) * steepness[i]


@njit(cache=True, nogil=True)
def _weigh_block(
    n, first, ids, xs, ys, facing, frame, widths, steepness, widths_before, steepness_before,
    out_ids, out_share, out_cover, found,
):  # fmt: skip
    """Time-mean share for the ink, and greatest share covered, of the vertices of a block.

    `ids` may be empty: the block is then the run of vertices that starts at `first`. Vertices
    with a share are appended to the outputs; returns their new number.
    """
    x0, x1, y0, y1 = frame[_BOX], frame[_BOX + 1], frame[_BOX + 2], frame[_BOX + 3]
    ox, oy, c, s = frame[20], frame[21], frame[22], frame[23]
    scale = frame[_SCALE]
    now, heel, tip, per_step = frame[25], frame[26], frame[27], frame[28]
    then, heel_a, tip_a, per_step_a = frame[29], frame[30], frame[31], frame[32]
    run = ids.shape[0] == 0
    for k in range(n):
        x = float(xs[k])
        y = float(ys[k])
        if not (x0 <= x <= x1 and y0 <= y <= y1):
            continue
        inner_a = 0.0
        inner_b = 0.0
        cover = 0.0
        if now > 0.0:
            near, far = _edges(widths, steepness, now, heel, tip, per_step, x, abs(y))
            inner_b = near * scale
            cover = _covered(inner_b) + _covered(far * scale) - 1.0
        if then > 0.0:
            u = x - ox
            v = y - oy
            near, far = _edges(
                widths_before, steepness_before, then, heel_a, tip_a, per_step_a,
                c * u + s * v, abs(c * v - s * u),
            )  # fmt: skip
            inner_a = near * scale
            cover = max(cover, _covered(inner_a) + _covered(far * scale) - 1.0)
            if now <= 0.0:
                inner_b = inner_a
        else:
            inner_a = inner_b
        if cover <= 0.0:
            continue
        share = _mean_covered(inner_a, inner_b)
        if share <= 0.0:
            continue
        out_ids[found] = first + k if run else ids[k]
        out_share[found] = share / (facing[k] * facing[k])
        out_cover[found] = cover
        found += 1
    return found


@njit(cache=True, nogil=True)
def _find_cells(values, field, counters, room):
    """Cells of the connected patch that the sweep may reach, refined; -1 for want of room."""
    bounds = room.bounds
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    size = field.numbers[1]
    half_x = 0.5 * (bounds[1] - bounds[0])
    half_y = 0.5 * (bounds[3] - bounds[2])
    mid_x = 0.5 * (bounds[0] + bounds[1])
    mid_y = 0.5 * (bounds[2] + bounds[3])
    reach = 1.1 * np.sqrt(half_x * half_x + half_y * half_y) + size
    reach = max(reach, np.sqrt(mid_x * mid_x + mid_y * mid_y) + size)
    for k in range(3):
        room.vector[k] = (
            values[st.ORIGIN_X + k]
            + mid_x * values[st.BEND_X + k]
            + mid_y * values[st.CROSS_X + k]
        )
    room.tick[0] += 1
    tick = room.tick[0]
    n_sheets = flood_patch(
        field, sheet, room.vector[0], room.vector[1], room.vector[2], reach,
        room.stamps, tick, room.sheets,
    )  # fmt: skip
    cells = _cells_in_reach(
        values, field.sheet_cell, field.sheet_area, field.sheet_normal, field.cell_place,
        field.origin, size, bounds, room.sheets, n_sheets, room.cell_ticks, tick, room.cells,
    )  # fmt: skip
    for k in range(cells):
        if field.done[room.cells[k]] == 0 and activate_cell(field, room.cells[k]) < 0:
            return -1
    return cells


@njit(cache=True, nogil=True)
def _cells_in_reach(
    values, sheet_cell, sheet_area, sheet_normal, cell_place, origin, size, bounds,
    sheets, n_sheets, cell_ticks, tick, cells,
):  # fmt: skip
    """The cells of those sheets that can reach the sweep's rectangle, each once."""
    n = 0
    half_diagonal = 0.5 * np.sqrt(3.0) * size
    for k in range(n_sheets):
        s = sheets[k]
        cell = sheet_cell[s]
        if cell_ticks[cell] != tick and _may_hold(
            values,
            sheet_area[s],
            sheet_normal[s],
            origin[0] + (cell_place[cell, 0] + 0.5) * size,
            origin[1] + (cell_place[cell, 1] + 0.5) * size,
            origin[2] + (cell_place[cell, 2] + 0.5) * size,
            half_diagonal,
            bounds,
        ):
            cell_ticks[cell] = tick
            cells[n] = cell
            n += 1
    return n


@njit(cache=True, nogil=True)
def _gather(before, after, field, margin, scale, counters, room):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    target = after if after.values[st.TOUCHES] > 0.0 else before
    values = target.values
    _sweep_bounds(before, after, target, margin, room.bounds)
    cells = _find_cells(values, field, counters, room)
    if cells < 0:
        return -1
    _fill_frame(before, after, values, scale, room.bounds, room.frame)
    return _gather_cells(
        room.cells, cells, field.base_start, field.head, field.next_in_cell, field.cell_sheets,
        field.vertex_sheet, field.px, field.py, field.pz, field.nx, field.ny, field.nz,
        room.stamps, room.tick[0], room.frame, after.half_widths, after.steepness,
        before.half_widths, before.steepness, room.block, room.ids, room.nothing,
        room.xs, room.ys, room.facing, room.found, room.share, room.cover, counters,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _gather_cells(
    cells, n_cells, base_start, head, next_in_cell, cell_sheets, vertex_sheet,
    px, py, pz, nx, ny, nz, stamps, tick, frame, widths, steepness, widths_before,
    steepness_before, block, ids, nothing, xs, ys, facing, found_ids, share, cover, counters,
):  # fmt: skip
    """Project and weigh the vertices of the cells, block by block; return how many are painted.

    Runs of base vertices are read where they stand. Added vertices, and those of a cell with
    several sheets, are first copied into one block that goes on over cells until it is full.
    """
    found = 0
    visited = 0
    size = xs.shape[0]
    filled = 0
    for c in range(n_cells):
        cell = cells[c]
        first = base_start[cell]
        last = base_start[cell + 1]
        alone = cell_sheets[cell + 1] - cell_sheets[cell] == 1
        if alone and last - first >= _WORTH_A_RUN:
            while first < last:
                stop = min(last, first + size)
                n = stop - first
                _project_block(
                    px[first:stop], py[first:stop], pz[first:stop],
                    nx[first:stop], ny[first:stop], nz[first:stop], frame, xs, ys, facing,
                )  # fmt: skip
                found = _weigh_block(
                    n, first, nothing, xs, ys, facing, frame, widths, steepness, widths_before,
                    steepness_before, found_ids, share, cover, found,
                )  # fmt: skip
                visited += n
                first = stop
        v = first if first < last else head[cell]
        while v >= 0:
            if alone or stamps[vertex_sheet[v]] == tick:
                ids[filled] = v
                block[0, filled] = px[v]
                block[1, filled] = py[v]
                block[2, filled] = pz[v]
                block[3, filled] = nx[v]
                block[4, filled] = ny[v]
                block[5, filled] = nz[v]
                filled += 1
            if v < last:
                v = v + 1 if v + 1 < last else head[cell]
            else:
                v = next_in_cell[v]
            if filled == size or (v < 0 and c == n_cells - 1 and filled > 0):
                found = _flush(
                    block, filled, ids, xs, ys, facing, frame, widths, steepness, widths_before,
                    steepness_before, found_ids, share, cover, found,
                )  # fmt: skip
                visited += filled
                filled = 0
    if filled > 0:
        found = _flush(
            block, filled, ids, xs, ys, facing, frame, widths, steepness, widths_before,
            steepness_before, found_ids, share, cover, found,
        )  # fmt: skip
        visited += filled
    counters[VISITED] += visited
    return found


@njit(cache=True, nogil=True)
def _flush(
    block, n, ids, xs, ys, facing, frame, widths, steepness, widths_before, steepness_before,
    found_ids, share, cover, found,
):  # fmt: skip
    """Project and weigh the copied block."""
    _project_block(
        block[0, :n], block[1, :n], block[2, :n], block[3, :n], block[4, :n], block[5, :n],
        frame, xs, ys, facing,
    )  # fmt: skip
    return _weigh_block(
        n, 0, ids, xs, ys, facing, frame, widths, steepness, widths_before, steepness_before,
        found_ids, share, cover, found,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _ink_released(before, after, tuft, ink):
    """Ink that leaves the brush on the way between two stamps: R (1 - exp(-eta' pe ds)).

    The continuous form of Guo 2017, Eqs. 12-13, which one step of unit length gives back; `ds` is
    the way of the outline's fastest point (mm).
    """
    pressure = 0.0
    n = 0
    for values in (before.values, after.values):
        if values[st.TOUCHES] > 0.0:
            pressure += values[st.PRESSURE]
        n += 1
    way = st.outline_motion(before, after)
    total = 0.0
    for p in range(ink.load.shape[0]):
        total += ink.load[p]
    return total, total * (1.0 - np.exp(-tuft.transfer_per_mm * ink.gain[0] * pressure / n * way))


@njit(cache=True, nogil=True)
def _landing_share(area, width, weighed_area, found):
    """Share of the released ink that meets surface; the rest runs off its edge.

    The vertices stand for the area only to within a seam of half their spacing; a shortfall no
    larger than that is not a gap.
    """
    if found == 0:
        return 0.0
    slack = 0.1 + width / np.sqrt(area)
    if slack >= 0.9:
        return 1.0
    return min(1.0, weighed_area / area / (1.0 - slack))


@njit(cache=True, nogil=True)
def sweep_deposit(before, after, tuft, field, ink, counters, room):
    """Deposit the ink of one sweep; False (and nothing changed) where the mesh has no room.

    Conserves: what leaves `ink.load` is on vertices or counted in `ink.off_surface`.
    """
    width = field.numbers[2]
    found = _gather(before, after, field, width, 1.0 / width, counters, room)
    if found < 0:
        return False
    weighed = _weighed_area(field.area_units, field.numbers[3], room.found, room.share, found)
    a = before.values
    b = after.values
    area = 0.5 * (a[st.AREA] + b[st.AREA])
    if a[st.TOUCHES] <= 0.0 or b[st.TOUCHES] <= 0.0:
        area = max(a[st.AREA] * a[st.TOUCHES], b[st.AREA] * b[st.TOUCHES])
    total, released = _ink_released(before, after, tuft, ink)
    if area < width * width and found == 0:
        released = 0.0  # a touch finer than the vertices leaves nothing yet
    landing = released * _landing_share(area, width, weighed, found)
    if weighed <= 0.0:
        landing = 0.0
    if total > 0.0:
        for p in range(ink.load.shape[0]):
            part = ink.load[p] / total
            ink.off_surface[p] += part * (released - landing)
            room.part[p] = part * landing / weighed if weighed > 0.0 else 0.0
            ink.load[p] -= part * released
    _leave(
        room.found, room.share, room.cover, found, room.part,
        ink.amounts, ink.coverage, ink.dirty, ink.dirty_ids, ink.n_dirty,
    )  # fmt: skip
    counters[PAINTED] += found
    return True


@njit(cache=True, nogil=True)
def _weighed_area(area_units, unit, ids, share, n):
    total = 0.0
    for k in range(n):
        total += share[k] * area_units[ids[k]]
    return total * unit


@njit(cache=True, nogil=True)
def _leave(ids, share, cover, n, part, amounts, coverage, dirty, dirty_ids, n_dirty):
    """Add every vertex's share of each pigment, and note whose colour is out of date."""
    count = n_dirty[0]
    for k in range(n):
        v = ids[k]
        for p in range(part.shape[0]):
            amounts[v, p] += np.float32(part[p] * share[k])
        if cover[k] > coverage[v]:
            coverage[v] = cover[k]
        if dirty[v] == 0:
            dirty[v] = 1
            dirty_ids[count] = v
            count += 1
    n_dirty[0] = count

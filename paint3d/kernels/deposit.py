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

__all__ = ["PAINTED", "VISITED", "sweep_deposit"]

VISITED, PAINTED = 2, 3  # counters
_LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
_AWAY = np.float32(1e9)  # plane coordinate of a vertex that cannot be painted


@njit(cache=True, nogil=True, inline="always")
def _covered(edge):
    """Share of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(1.0, max(0.0, 0.5 + edge))


@njit(cache=True, nogil=True, inline="always")
def _covered_sum(edge):
    """Antiderivative of `_covered`."""
    t = 0.5 + edge
    if t <= 0.0:
        return 0.0
    if t >= 1.0:
        return t - 0.5
    return 0.5 * t * t


@njit(cache=True, nogil=True, inline="always")
def _mean_covered(a, b):
    """Mean of `_covered` while the edge distance goes evenly from a to b."""
    d = b - a
    if abs(d) < 1e-6:
        return _covered(0.5 * (a + b))
    return (_covered_sum(b) - _covered_sum(a)) / d


@njit(cache=True, nogil=True)
def _sweep_bounds(before, after, margin, bounds):
    """Rectangle (x0, x1, y0, y1) in the plane of `after` that holds both outlines.

    Also fills bounds[4:8] with the similarity that carries plane coordinates of `after` to those
    of `before`: x' = c (x - ox) + s (y - oy), y' = -s (x - ox) + c (y - oy).
    """
    a = before.values
    b = after.values
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
    if b[st.TOUCHES] > 0.0:
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
def _may_hold(values, field, sheet, half_diagonal, bounds):
    """Whether a sheet of surface can reach the rectangle once it is carried to the plane."""
    dx = field.sheet_centre[sheet, 0] - values[st.ORIGIN_X]
    dy = field.sheet_centre[sheet, 1] - values[st.ORIGIN_X + 1]
    dz = field.sheet_centre[sheet, 2] - values[st.ORIGIN_X + 2]
    nx = values[st.NORMAL_X]
    ny = values[st.NORMAL_X + 1]
    nz = values[st.NORMAL_X + 2]
    sx = field.sheet_normal[sheet, 0]
    sy = field.sheet_normal[sheet, 1]
    sz = field.sheet_normal[sheet, 2]
    length = np.sqrt(sx * sx + sy * sy + sz * sz)
    facing = (sx * nx + sy * ny + sz * nz) / length if length > 0.0 else 0.0
    coherent = length > 0.7 * field.sheet_area[sheet]
    if coherent and facing < 0.0:
        return False
    height = abs(dx * nx + dy * ny + dz * nz)
    slope = np.sqrt(1.0 - facing * facing) / max(facing, _LEAST_FACING) if coherent else 4.0
    slack = 2.0 * half_diagonal + min(slope, 4.0) * (height + half_diagonal)
    x = dx * values[st.BEND_X] + dy * values[st.BEND_Y] + dz * values[st.BEND_Z]
    y = dx * values[st.CROSS_X] + dy * values[st.CROSS_X + 1] + dz * values[st.CROSS_X + 2]
    return (
        bounds[0] - slack <= x <= bounds[1] + slack and bounds[2] - slack <= y <= bounds[3] + slack
    )


@njit(cache=True, nogil=True)
def _project_run(field, first, last, values, radius2, xs, ys, facing):
    """Carry a run of vertices to the plane along their own normals (Guo 2017, 4.2.1).

    Straight-line float32 code over consecutive memory: the compiler turns it into vector
    instructions. A vertex outside the enclosing sphere, or facing away, is sent far off.
    """
    ox = np.float32(values[st.ORIGIN_X])
    oy = np.float32(values[st.ORIGIN_X + 1])
    oz = np.float32(values[st.ORIGIN_X + 2])
    nx = np.float32(values[st.NORMAL_X])
    ny = np.float32(values[st.NORMAL_X + 1])
    nz = np.float32(values[st.NORMAL_X + 2])
    bx = np.float32(values[st.BEND_X])
    by = np.float32(values[st.BEND_Y])
    bz = np.float32(values[st.BEND_Z])
    cx = np.float32(values[st.CROSS_X])
    cy = np.float32(values[st.CROSS_X + 1])
    cz = np.float32(values[st.CROSS_X + 2])
    sx = np.float32(values[st.SPHERE_X] - values[st.ORIGIN_X])
    sy = np.float32(values[st.SPHERE_X + 1] - values[st.ORIGIN_X + 1])
    sz = np.float32(values[st.SPHERE_X + 2] - values[st.ORIGIN_X + 2])
    r2 = np.float32(radius2)
    least = np.float32(_LEAST_FACING)
    px = field.px[first:last]
    py = field.py[first:last]
    pz = field.pz[first:last]
    mx = field.nx[first:last]
    my = field.ny[first:last]
    mz = field.nz[first:last]
    for k in range(last - first):
        dx = px[k] - ox
        dy = py[k] - oy
        dz = pz[k] - oz
        cosine = mx[k] * nx + my[k] * ny + mz[k] * nz
        safe = max(cosine, least)
        t = -(dx * nx + dy * ny + dz * nz) / safe
        qx = dx + t * mx[k]
        qy = dy + t * my[k]
        qz = dz + t * mz[k]
        ex = dx - sx
        ey = dy - sy
        ez = dz - sz
        ok = (cosine >= least) & (ex * ex + ey * ey + ez * ez <= r2)
        x = qx * bx + qy * by + qz * bz
        xs[k] = x if ok else _AWAY
        ys[k] = qx * cx + qy * cy + qz * cz
        facing[k] = safe


@njit(cache=True, nogil=True)
def _weigh(before, after, x, y, scale, bounds):
    """Time-mean share for the ink, and the greatest share covered, of a vertex at plane (x, y)."""
    a = before.values
    b = after.values
    inner_b = -1e3
    cover_b = 0.0
    if b[st.TOUCHES] > 0.0:
        near, far = st.edge_distances(
            after, b[st.HEEL], b[st.TIP], st.PROFILE_CELLS / (b[st.TIP] - b[st.HEEL]), x, y
        )
        inner_b = near * scale
        cover_b = max(0.0, _covered(inner_b) + _covered(far * scale) - 1.0)
    inner_a = inner_b
    cover_a = cover_b
    if a[st.TOUCHES] > 0.0:
        u = x - bounds[4]
        v = y - bounds[5]
        near, far = st.edge_distances(
            before,
            a[st.HEEL],
            a[st.TIP],
            st.PROFILE_CELLS / (a[st.TIP] - a[st.HEEL]),
            bounds[6] * u + bounds[7] * v,
            bounds[6] * v - bounds[7] * u,
        )
        inner_a = near * scale
        cover_a = max(0.0, _covered(inner_a) + _covered(far * scale) - 1.0)
        if b[st.TOUCHES] <= 0.0:
            inner_b = inner_a
    cover = max(cover_a, cover_b)
    if cover <= 0.0:
        return 0.0, 0.0
    return _mean_covered(inner_a, inner_b), cover


@njit(cache=True, nogil=True)
def _select(before, after, field, first, n, ids, sheet_known, tick, scale, bounds, room, found):
    """Weigh the vertices projected into room.xs/ys; append those painted to the room's lists.

    `ids` is None-like (length 0) for a consecutive run that starts at `first`. Returns the new
    number found.
    """
    x0, x1, y0, y1 = bounds[0], bounds[1], bounds[2], bounds[3]
    for k in range(n):
        x = room.xs[k]
        if not (x0 <= x <= x1):
            continue
        y = room.ys[k]
        if not (y0 <= y <= y1):
            continue
        v = first + k if ids.shape[0] == 0 else ids[k]
        if not sheet_known and room.stamps[field.vertex_sheet[v]] != tick:
            continue
        share, cover = _weigh(before, after, x, y, scale, bounds)
        if share <= 0.0 or cover <= 0.0:
            continue
        stretch = room.facing[k] * room.facing[k]
        room.found[found] = v
        room.share[found] = share / stretch
        room.cover[found] = cover
        found += 1
    return found


@njit(cache=True, nogil=True)
def _gather(before, after, field, margin, scale, counters, room):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    values = after.values if after.values[st.TOUCHES] > 0.0 else before.values
    target = after if after.values[st.TOUCHES] > 0.0 else before
    bounds = room.bounds
    _sweep_bounds(before, target, margin, bounds)
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    half_x = 0.5 * (bounds[1] - bounds[0])
    half_y = 0.5 * (bounds[3] - bounds[2])
    mid_x = 0.5 * (bounds[0] + bounds[1])
    mid_y = 0.5 * (bounds[2] + bounds[3])
    reach = 1.1 * np.sqrt(half_x * half_x + half_y * half_y) + field.numbers[1]
    reach = max(reach, np.sqrt(mid_x * mid_x + mid_y * mid_y) + field.numbers[1])
    for k in range(3):
        room.vector[k] = (
            values[st.ORIGIN_X + k] + mid_x * values[st.BEND_X + k] + mid_y * values[st.CROSS_X + k]
        )
    room.tick[0] += 1
    tick = room.tick[0]
    n_sheets = flood_patch(
        field, sheet, room.vector[0], room.vector[1], room.vector[2], reach,
        room.stamps, tick, room.sheets,
    )  # fmt: skip
    half_diagonal = 0.5 * np.sqrt(3.0) * field.numbers[1]
    cells = 0
    for k in range(n_sheets):
        s = room.sheets[k]
        cell = field.sheet_cell[s]
        if room.cell_ticks[cell] == tick:
            continue
        if not _may_hold(values, field, s, half_diagonal, bounds):
            continue
        room.cell_ticks[cell] = tick
        room.cells[cells] = cell
        cells += 1
    for k in range(cells):
        if field.done[room.cells[k]] == 0 and activate_cell(field, room.cells[k]) < 0:
            return -1
    radius2 = values[st.RADIUS] * values[st.RADIUS]
    found = 0
    for k in range(cells):
        cell = room.cells[k]
        alone = field.cell_sheets[cell + 1] - field.cell_sheets[cell] == 1
        first = field.base_start[cell]
        last = field.base_start[cell + 1]
        while first < last:
            stop = min(last, first + room.xs.shape[0])
            _project_run(field, first, stop, values, radius2, room.xs, room.ys, room.facing)
            found = _select(
                before, target, field, first, stop - first, room.nothing, alone, tick, scale,
                bounds, room, found,
            )  # fmt: skip
            counters[VISITED] += stop - first
            first = stop
        found = _gather_added(
            before, target, field, cell, alone, tick, values, radius2, scale, counters, room, found
        )
    return found


@njit(cache=True, nogil=True)
def _gather_added(
    before, after, field, cell, alone, tick, values, radius2, scale, counters, room, found
):
    """The same for the vertices that refinement added to a cell; they are linked, not in a run."""
    v = field.head[cell]
    while v >= 0:
        n = 0
        while v >= 0 and n < room.ids.shape[0]:
            room.ids[n] = v
            n += 1
            v = field.next_in_cell[v]
        _project_ids(field, room.ids, n, values, radius2, room.xs, room.ys, room.facing)
        found = _select(
            before, after, field, 0, n, room.ids, alone, tick, scale, room.bounds, room, found
        )
        counters[VISITED] += n
    return found


@njit(cache=True, nogil=True)
def _project_ids(field, ids, n, values, radius2, xs, ys, facing):
    """`_project_run` for scattered vertices: gather them into one block, then project that."""
    for k in range(n):
        v = ids[k]
        dx = field.px[v] - values[st.ORIGIN_X]
        dy = field.py[v] - values[st.ORIGIN_X + 1]
        dz = field.pz[v] - values[st.ORIGIN_X + 2]
        cosine = (
            field.nx[v] * values[st.NORMAL_X]
            + field.ny[v] * values[st.NORMAL_X + 1]
            + field.nz[v] * values[st.NORMAL_X + 2]
        )
        xs[k] = _AWAY
        if cosine < _LEAST_FACING:
            continue
        ex = field.px[v] - values[st.SPHERE_X]
        ey = field.py[v] - values[st.SPHERE_X + 1]
        ez = field.pz[v] - values[st.SPHERE_X + 2]
        if ex * ex + ey * ey + ez * ez > radius2:
            continue
        t = (
            -(
                dx * values[st.NORMAL_X]
                + dy * values[st.NORMAL_X + 1]
                + dz * values[st.NORMAL_X + 2]
            )
            / cosine
        )
        dx += t * field.nx[v]
        dy += t * field.ny[v]
        dz += t * field.nz[v]
        xs[k] = dx * values[st.BEND_X] + dy * values[st.BEND_Y] + dz * values[st.BEND_Z]
        ys[k] = dx * values[st.CROSS_X] + dy * values[st.CROSS_X + 1] + dz * values[st.CROSS_X + 2]
        facing[k] = cosine


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
    weighed = 0.0
    for k in range(found):
        weighed += room.share[k] * (field.area_units[room.found[k]] * field.numbers[3])
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
    for k in range(found):
        v = room.found[k]
        for p in range(ink.load.shape[0]):
            ink.amounts[v, p] += np.float32(room.part[p] * room.share[k])
        if room.cover[k] > ink.coverage[v]:
            ink.coverage[v] = room.cover[k]
        if ink.dirty[v] == 0:
            ink.dirty[v] = 1
            ink.dirty_ids[ink.n_dirty[0]] = v
            ink.n_dirty[0] += 1
    counters[PAINTED] += found
    return True

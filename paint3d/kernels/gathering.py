"""Find the vertices that a sweep can reach, and weigh them."""

from __future__ import annotations

import numpy as np
from numba import njit

from paint3d.kernels import stamp as st
from paint3d.kernels import sweep as sw
from paint3d.kernels.cells import flood_patch
from paint3d.kernels.placement import start_sheet
from paint3d.kernels.projecting import AWAY, LEAST_FACING, project_ids, project_run, take_run
from paint3d.kernels.refine import activate_cell
from paint3d.kernels.sweep import fill_between, fill_frame, sweep_bounds
from paint3d.kernels.weighing import weigh_block

__all__ = ["VISITED", "gather"]

VISITED = 2  # counter: vertices looked at
_STEEPEST = 4.0  # tangent of the angle at which a vertex faces away
_COHERENT = 0.7  # of its area: a sheet whose normal is longer looks one way


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
    cells = _cells_in_reach(
        field.sheet_place, field.sheet_pack, field.origin,
        field.numbers[1], room.frame, before.values, before.half_widths, after.values,
        after.half_widths, room.sheets, n_sheets, room.cell_ticks, room.tick[1], room.cells,
        room.inside,
    )  # fmt: skip
    for k in range(cells):
        if field.done[room.cells[k]] == 0 and activate_cell(field, room.cells[k]) < 0:
            return -1
    return cells


@njit(cache=True, nogil=True, error_model="numpy")
def _cells_in_reach(
    sheet_place, pack, origin, size, frame, before, widths_before,
    after, widths, sheets, n_sheets, cell_ticks, tick, cells, inside,
):  # fmt: skip
    """The cells of those sheets that the sweep can reach, each once, and which lie well inside.

    A vertex in a cell lands in the plane within `slack` of where the cell's middle lands: half
    the cell's diagonal, and the shift that its own normal gives it at its height.
    """
    n = 0
    half_diagonal = 0.5 * np.sqrt(3.0) * size
    margin = (0.5 + frame[sw.END_RISE]) / frame[sw.SCALE]
    for k in range(n_sheets):
        sheet = sheets[k]
        cell = sheet_place[sheet, 3]
        if cell_ticks[cell] == tick:
            continue
        dx = origin[0] + (sheet_place[sheet, 0] + 0.5) * size - frame[0]
        dy = origin[1] + (sheet_place[sheet, 1] + 0.5) * size - frame[1]
        dz = origin[2] + (sheet_place[sheet, 2] + 0.5) * size - frame[2]
        x = dx * frame[6] + dy * frame[7] + dz * frame[8]
        y = dx * frame[9] + dy * frame[10] + dz * frame[11]
        height = abs(dx * frame[3] + dy * frame[4] + dz * frame[5])
        slack = half_diagonal + _STEEPEST * (height + half_diagonal) + margin
        if (
            x < frame[sw.BOX] - slack
            or x > frame[sw.BOX + 1] + slack
            or y < frame[sw.BOX + 2] - slack
            or y > frame[sw.BOX + 3] + slack
        ):
            continue
        nx, ny, nz, area = pack[sheet, 0], pack[sheet, 1], pack[sheet, 2], pack[sheet, 3]
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        facing = nx * frame[3] + ny * frame[4] + nz * frame[5]
        facing = min(1.0, facing / length) if length > 0.0 else 0.0
        coherent = length > _COHERENT * area
        if coherent:
            if facing < 0.0:
                continue
            # normals in a sheet differ by about what their mean lacks of unit length
            spread = np.sqrt(max(0.0, 1.0 - length / area))
            slope = np.sqrt(1.0 - facing * facing) / max(facing, LEAST_FACING) + 2.0 * spread
            slack = half_diagonal + min(slope, _STEEPEST) * (height + half_diagonal) + margin
        u = x - frame[20]
        v = y - frame[21]
        now = _disc_place(after, widths, x, y, slack)
        then = _disc_place(
            before,
            widths_before,
            frame[22] * u + frame[23] * v,
            frame[22] * v - frame[23] * u,
            slack,
        )
        if now < 0 and then < 0:
            continue
        cell_ticks[cell] = tick
        cells[n] = cell
        inside[n] = 1 if coherent and now > 0 and then > 0 else 0
        n += 1
    return n


@njit(cache=True, nogil=True, error_model="numpy")
def _disc_place(values, widths, x, y, radius):
    """1 where a disc in the plane lies within a stamp's outline, -1 outside, 0 on its edge.

    The half width rises to its greatest value and falls again, so over an interval it is least
    at one of the ends.
    """
    if values[st.TOUCHES] <= 0.0:
        return -1
    side = abs(y)
    low = x - radius
    high = x + radius
    if high < values[st.HEEL] or low > values[st.TIP] or side - radius > values[st.WIDEST]:
        return -1
    a = _width_at(values, widths, low)
    b = _width_at(values, widths, high)
    if min(a, b) >= side + radius:
        return 1
    if not low <= values[st.REACH_OF_WIDEST] <= high and max(a, b) < side - radius:
        return -1
    return 0


@njit(cache=True, nogil=True, error_model="numpy")
def _width_at(values, widths, x):
    """Half width (mm) of a stamp at a reach, 0 beyond its ends."""
    heel = values[st.HEEL]
    tip = values[st.TIP]
    if x <= heel or x >= tip:
        return 0.0
    at = (x - heel) * st.PROFILE_CELLS / (tip - heel)
    i = int(at)
    return widths[i] + (at - i) * (widths[i + 1] - widths[i])


@njit(cache=True, nogil=True, error_model="numpy")
def gather(before, after, field, margin, scale, counters, room):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    target = after if after.values[st.TOUCHES] > 0.0 else before
    values = target.values
    sweep_bounds(before, after, target, margin, room.bounds)
    fill_frame(before, after, values, scale, room.bounds, room.frame)
    fill_between(before, after, room.frame, room.between)
    cells = _find_cells(before, after, target, field, room)
    if cells < 0:
        return -1
    return _gather_cells(
        room.cells, room.inside, cells, field.base_start, field.head, field.next_in_cell,
        field.cell_sheets, field.vertex_sheet, field.px, field.py, field.pz, field.nx, field.ny,
        field.nz, room.stamps, room.tick[0], room.frame, after.lines, before.lines,
        room.between, room.work, room.near, room.ids, room.xs, room.ys, room.stretch, room.found,
        room.share, room.cover, counters,
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _gather_cells(
    cells, inside, n_cells, base_start, head, next_in_cell, cell_sheets, vertex_sheet,
    px, py, pz, nx, ny, nz, stamps, tick, frame, lines, lines_before, between, work,
    near, ids, xs, ys, stretch, found_ids, share, cover, counters,
):  # fmt: skip
    """Project and weigh the vertices of the cells, block by block; return how many are painted.

    A block goes on over cells until it is full: base vertices come run by run, added ones along
    their links. Runs well inside the outline need no weighing.
    """
    found = 0
    visited = 0
    size = xs.shape[0]
    filled = 0
    for c in range(n_cells):
        cell = cells[c]
        first = base_start[cell]
        last = base_start[cell + 1]
        visited += last - first
        alone = cell_sheets[cell + 1] - cell_sheets[cell] == 1
        if alone and inside[c]:
            found = take_run(
                first, last, px, py, pz, nx, ny, nz, frame, found_ids, share, cover, found
            )
            first = last
        while first < last:
            if filled == size:
                found = weigh_block(
                    filled, ids, xs, ys, stretch, frame, lines, lines_before, between, work,
                    near, found_ids, share, cover, found,
                )  # fmt: skip
                filled = 0
            n = min(last - first, size - filled)
            project_run(px, py, pz, nx, ny, nz, first, n, frame, xs, ys, stretch, filled)
            for k in range(n):
                ids[filled + k] = first + k
                if not alone and stamps[vertex_sheet[first + k]] != tick:
                    xs[filled + k] = AWAY
            first += n
            filled += n
        v = head[cell]
        while v >= 0:
            if filled == size:
                found = weigh_block(
                    filled, ids, xs, ys, stretch, frame, lines, lines_before, between, work,
                    near, found_ids, share, cover, found,
                )  # fmt: skip
                filled = 0
            start = filled
            while v >= 0 and filled < size:
                if alone or stamps[vertex_sheet[v]] == tick:
                    ids[filled] = v
                    filled += 1
                v = next_in_cell[v]
            visited += filled - start
            project_ids(px, py, pz, nx, ny, nz, ids, start, filled, frame, xs, ys, stretch)
    found = weigh_block(
        filled, ids, xs, ys, stretch, frame, lines, lines_before, between, work, near,
        found_ids, share, cover, found,
    )  # fmt: skip
    counters[VISITED] += visited
    return found

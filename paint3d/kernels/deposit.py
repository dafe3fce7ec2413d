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

__all__ = ["BETWEEN_SHAPE", "FRAME_SIZE", "PAINTED", "VISITED", "sweep_deposit"]

VISITED, PAINTED = 2, 3  # counters
_LEAST_FACING = 0.25  # cosine between vertex and plane normal below which a vertex faces away
_STEEPEST = 4.0  # tangent of the angle at which a vertex faces away
_LAST_PLACE = st.PROFILE_CELLS - 1e-4  # on the profile, in cells: within the last
_AREA_STEPS = 2.0**36  # whole numbers to a mm2 in sums of areas
_COHERENT = 0.7  # of its area: a sheet whose normal is longer looks one way
_AWAY = 1e9  # plane coordinate of a vertex that cannot be painted


@njit(cache=True, nogil=True, error_model="numpy")
def _covered(edge):
    """Share of the unit box on the inner side of an edge at a signed distance (box widths)."""
    return min(1.0, max(0.0, 0.5 + edge))


@njit(cache=True, nogil=True, error_model="numpy")
def _covered_sum(edge):
    """Antiderivative of `_covered`."""
    t = 0.5 + edge
    if t <= 0.0:
        return 0.0
    if t >= 1.0:
        return t - 0.5
    return 0.5 * t * t


@njit(cache=True, nogil=True, error_model="numpy")
def _mean_covered(a, b):
    """Mean of `_covered` while the edge distance goes evenly from a to b."""
    d = b - a
    if abs(d) < 1e-4:
        return _covered(0.5 * (a + b))
    return (_covered_sum(b) - _covered_sum(a)) / d


@njit(cache=True, nogil=True, error_model="numpy")
def _sweep_bounds(before, after, plane, margin, bounds):
    """Rectangle (x0, x1, y0, y1) in the plane of the stamp `plane` that holds both outlines.

    Also fills bounds[4:8] with the turn (ox, oy, c, s) that carries its coordinates to those of
    `before`: x' = c (x - ox) + s (y - oy), y' = -s (x - ox) + c (y - oy).
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


# Places in the frame of a sweep: everything that the loop over vertices needs, as one array.
_ORIGIN, _NORMAL, _BEND, _CROSS, _SPHERE = 0, 3, 6, 9, 12
_RADIUS2, _BOX, _BOX_BEFORE, _SCALE, _AFTER, _BEFORE = 15, 16, 20, 24, 25, 28
_TURN_AFTER, _PARTS, _RISE, _END_RISE, _END = 31, 35, 36, 37, 38
FRAME_SIZE = 39  # numbers in the frame
_MOST_PARTS = 8  # that the way between two stamps is cut into for vertices near the edge
_PART_SHARE = 0.05  # of the footprint's smaller extent, the longest part
_PART_WIDTH = 0.25  # of the soft edge, the shortest
_SLOW = 4.0  # box widths: an edge that passes faster passes as good as straight
BETWEEN_SHAPE = (_MOST_PARTS, 6)


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_frame(before, after, plane, scale, bounds, frame):
    """Gather the numbers of a sweep from its stamps; `plane` holds the plane's values."""
    for k in range(3):
        frame[_ORIGIN + k] = plane[st.ORIGIN_X + k]
        frame[_NORMAL + k] = plane[st.NORMAL_X + k]
        frame[_BEND + k] = plane[st.BEND_X + k]
        frame[_CROSS + k] = plane[st.CROSS_X + k]
        frame[_SPHERE + k] = plane[st.SPHERE_X + k] - plane[st.ORIGIN_X + k]
    # the sphere is that of one stamp: the other's outline sticks out by what it moved
    frame[_RADIUS2] = (plane[st.RADIUS] + 0.5 / scale + st.outline_motion(before, after)) ** 2
    for k in range(8):
        frame[_BOX + k] = bounds[k]
    frame[_SCALE] = scale
    for at, values in ((_AFTER, after.values), (_BEFORE, before.values)):
        frame[at] = values[st.TOUCHES]
        frame[at + 1] = values[st.HEEL]
        frame[at + 2] = values[st.TIP]
    frame[_TURN_AFTER : _TURN_AFTER + 4] = (0.0, 0.0, 1.0, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_between(before, after, frame, between):
    """Where the outline stands between two stamps that touch: rows of turn (4), heel and tip.

    An outline passes a vertex near its edge on a curve, not straight from its distance at one
    stamp to that at the other. Cutting the way for these vertices alone costs less than more
    stamps would.
    """
    frame[_PARTS] = 1.0
    frame[_RISE] = 0.0
    frame[_END_RISE] = 0.0
    frame[_END] = 0.0
    a = before.values
    b = after.values
    if a[st.TOUCHES] <= 0.0 or b[st.TOUCHES] <= 0.0:
        return
    extent = min(a[st.TIP] - a[st.HEEL], b[st.TIP] - b[st.HEEL])
    extent = min(extent, 2.0 * min(a[st.WIDEST], b[st.WIDEST]))
    motion = st.outline_motion(before, after)
    part = max(_PART_SHARE * extent, _PART_WIDTH / frame[_SCALE])
    parts = min(_MOST_PARTS, int(np.ceil(motion / part)))
    if parts < 2:
        return
    frame[_PARTS] = parts
    # how far beyond both stamps' edges the edge gets on its way: a flank that is carried along
    # bulges by the height of an arc, the pointed tip stands out by half its way to the side
    widest = min(a[st.WIDEST], b[st.WIDEST])
    frame[_RISE] = min(0.5 * motion, motion * motion / (4.0 * widest)) * frame[_SCALE]
    aside = abs(frame[_BOX_BEFORE + 1] + frame[_BOX_BEFORE + 3] * a[st.TIP])
    frame[_END_RISE] = max(frame[_RISE], 0.5 * aside * frame[_SCALE])
    frame[_END] = st.PROFILE_CELLS * min(0.5, motion / (a[st.TIP] - a[st.HEEL]))
    turn = np.arctan2(frame[_BOX_BEFORE + 3], frame[_BOX_BEFORE + 2])
    for k in range(parts):  # row 0: half the way
        back = 1.0 - k / parts if k > 0 else 0.5
        between[k, 0] = back * frame[_BOX_BEFORE]
        between[k, 1] = back * frame[_BOX_BEFORE + 1]
        between[k, 2] = np.cos(back * turn)
        between[k, 3] = np.sin(back * turn)
        between[k, 4] = back * a[st.HEEL] + (1.0 - back) * b[st.HEEL]
        between[k, 5] = back * a[st.TIP] + (1.0 - back) * b[st.TIP]


@njit(cache=True, nogil=True, error_model="numpy")
def _edges_between(x, y, lines_before, lines, back, place):
    """Distances (mm) to the near and the far side of an outline between two stamps."""
    u = x - place[0]
    v = y - place[1]
    along = place[2] * u + place[3] * v
    side = abs(place[2] * v - place[3] * u)
    heel = place[4]
    tip = place[5]
    at = min(max((along - heel) * st.PROFILE_CELLS / (tip - heel), 0.0), _LAST_PLACE)
    i = int(at)
    width = (1.0 - back) * (lines[i, 0] + at * lines[i, 1])
    width += back * (lines_before[i, 0] + at * lines_before[i, 1])
    steepness = (1.0 - back) * lines[i, 2] + back * lines_before[i, 2]
    width -= max(0.0, max(heel - along, along - tip))
    return (width - side) * steepness, (width + side) * steepness


@njit(cache=True, nogil=True, error_model="numpy")
def _pass_edge(x, y, a, b, lines_before, lines, between, parts, scale):
    """Mean share covered, and the greatest, while the outline goes from one stamp to the other.

    `a` and `b` are the distances (box widths) at the two stamps.
    """
    share = 0.0
    cover = 0.0
    last = a
    for k in range(1, parts):
        near, far = _edges_between(x, y, lines_before, lines, 1.0 - k / parts, between[k])
        inner = near * scale
        share += _mean_covered(last, inner)
        cover = max(cover, _covered(inner) + _covered(far * scale) - 1.0)
        last = inner
    return (share + _mean_covered(last, b)) / parts, cover


@njit(cache=True, nogil=True, error_model="numpy")
def _project_run(px, py, pz, nx, ny, nz, first, n, frame, xs, ys, stretch, at):
    """Carry a run of vertices to the plane along their own normals (Guo 2017, 4.2.1).

    Straight-line float32 code over consecutive memory: the compiler turns it into vector
    instructions. A vertex that faces away, or lands outside the enclosing sphere, is sent far off;
    where it lands and not where it is, for a convex surface falls away from under the tip.
    `stretch` gets the plane's area for one of the surface there, as on a cylinder: 1 / cosine^2.
    """
    ox, oy, oz = np.float32(frame[0]), np.float32(frame[1]), np.float32(frame[2])
    ux, uy, uz = np.float32(frame[3]), np.float32(frame[4]), np.float32(frame[5])
    bx, by, bz = np.float32(frame[6]), np.float32(frame[7]), np.float32(frame[8])
    cx, cy, cz = np.float32(frame[9]), np.float32(frame[10]), np.float32(frame[11])
    sx, sy, sz = np.float32(frame[12]), np.float32(frame[13]), np.float32(frame[14])
    r2 = np.float32(frame[_RADIUS2])
    least = np.float32(_LEAST_FACING)
    away = np.float32(_AWAY)
    one = np.float32(1.0)
    # slices: indices that cannot be negative are what lets the loop be vectorised
    px, py, pz = px[first : first + n], py[first : first + n], pz[first : first + n]
    nx, ny, nz = nx[first : first + n], ny[first : first + n], nz[first : first + n]
    xs, ys, stretch = xs[at : at + n], ys[at : at + n], stretch[at : at + n]
    for k in range(n):
        dx = px[k] - ox
        dy = py[k] - oy
        dz = pz[k] - oz
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
        x = qx * bx + qy * by + qz * bz
        xs[k] = away if (cosine < least) | (reach > r2) else x
        ys[k] = qx * cx + qy * cy + qz * cz
        stretch[k] = inverse * inverse


@njit(cache=True, nogil=True, error_model="numpy")
def _project_ids(px, py, pz, nx, ny, nz, ids, first, last, frame, xs, ys, stretch):
    """`_project_run` for the scattered vertices ids[first:last]."""
    least = np.float32(_LEAST_FACING)
    for k in range(first, last):
        v = ids[k]
        dx = px[v] - frame[0]
        dy = py[v] - frame[1]
        dz = pz[v] - frame[2]
        cosine = nx[v] * frame[3] + ny[v] * frame[4] + nz[v] * frame[5]
        safe = max(cosine, least)
        height = dx * frame[3] + dy * frame[4] + dz * frame[5]
        t = height / safe
        dx -= t * nx[v]
        dy -= t * ny[v]
        dz -= t * nz[v]
        ex = dx - frame[12]
        ey = dy - frame[13]
        ez = dz - frame[14]
        reach = max(ex * ex + ey * ey + ez * ez, height * height)
        x = dx * frame[6] + dy * frame[7] + dz * frame[8]
        xs[k] = _AWAY if (cosine < least) | (reach > frame[_RADIUS2]) else x
        ys[k] = dx * frame[9] + dy * frame[10] + dz * frame[11]
        stretch[k] = 1.0 / (safe * safe)


@njit(cache=True, nogil=True, error_model="numpy")
def _inner_edges(n, xs, ys, lines, heel, tip, turn, scale, places, sides, inner):
    """Signed distances (box widths) of a block's vertices to one outline; inside is positive.

    `turn` (4,) carries plane coordinates to the stamp's own: (x - ox, y - oy) turned by (c, s).
    Two loops without branches, the first of them in vector instructions: the profile is read at
    its nearer end beyond its ends, less the way beyond.
    """
    ox, oy = np.float32(turn[0]), np.float32(turn[1])
    c, s = np.float32(turn[2]), np.float32(turn[3])
    first, last = np.float32(heel), np.float32(tip)
    per_step = np.float32(st.PROFILE_CELLS / (tip - heel))
    top = np.float32(_LAST_PLACE)
    nothing = np.float32(0.0)
    factor = np.float32(scale)
    for k in range(n):
        u = xs[k] - ox
        v = ys[k] - oy
        x = c * u + s * v
        places[k] = min(max((x - first) * per_step, nothing), top)
        sides[k] = abs(c * v - s * u) + max(nothing, max(first - x, x - last))
    for k in range(n):
        at = places[k]
        i = np.int32(at)
        inner[k] = (lines[i, 0] + at * lines[i, 1] - sides[k]) * lines[i, 2] * factor


@njit(cache=True, nogil=True, error_model="numpy")
def _far_edge(x, y, lines, heel, tip, turn):
    """The distance (mm) to the outline's other side, at plane (x, y); see `_covered_share`."""
    u = x - turn[0]
    v = y - turn[1]
    along = turn[2] * u + turn[3] * v
    side = abs(turn[2] * v - turn[3] * u)
    at = min(max((along - heel) * st.PROFILE_CELLS / (tip - heel), 0.0), _LAST_PLACE)
    i = int(at)
    beyond = max(0.0, max(heel - along, along - tip))
    return (lines[i, 0] + at * lines[i, 1] - beyond + side) * lines[i, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh_block(
    n, ids, xs, ys, stretch, frame, lines, lines_before, between, work, near,
    out_ids, out_share, out_cover, found,
):  # fmt: skip
    """Time-mean share for the ink, and greatest share covered, of the vertices of a block.

    Vertices with a share are appended to the outputs; returns their new number.
    """
    places, sides, inner_a, inner_b = work[0], work[1], work[2], work[3]
    scale = frame[_SCALE]
    now, heel, tip = frame[_AFTER], frame[_AFTER + 1], frame[_AFTER + 2]
    then, heel_a, tip_a = frame[_BEFORE], frame[_BEFORE + 1], frame[_BEFORE + 2]
    turn_b = frame[_TURN_AFTER : _TURN_AFTER + 4]
    turn_a = frame[_BOX_BEFORE : _BOX_BEFORE + 4]
    if now > 0.0:
        _inner_edges(n, xs, ys, lines, heel, tip, turn_b, scale, places, sides, inner_b)
    if then > 0.0:  # after the other: `places` are then those on the stamp the brush comes from
        _inner_edges(n, xs, ys, lines_before, heel_a, tip_a, turn_a, scale, places, sides, inner_a)
    if now <= 0.0:
        inner_b = inner_a
    elif then <= 0.0:
        inner_a = inner_b
    parts = int(frame[_PARTS])
    least = np.float32(-0.5 - frame[_RISE])
    least_at_end = np.float32(-0.5 - frame[_END_RISE])
    end = np.float32(st.PROFILE_CELLS - frame[_END])
    half_rise = 0.5 * frame[_END_RISE]
    candidates = 0
    for k in range(n):  # no branch: half of them lie outside, in no order that can be foretold
        near[candidates] = k
        inner = max(inner_a[k], inner_b[k])
        at_end = (places[k] > end) & (inner > least_at_end)
        candidates += np.int64((inner > least) | at_end)
    for i in range(candidates):
        k = near[i]
        a = np.float64(inner_a[k])
        b = np.float64(inner_b[k])
        share = 1.0
        cover = 1.0
        if min(a, b) < 0.5:
            most = 0.0
            if parts > 1 and (max(a, b) < 0.5 or abs(b - a) < _SLOW):
                x, y = np.float64(xs[k]), np.float64(ys[k])
                middle, _ = _edges_between(x, y, lines_before, lines, 0.5, between[0])
                if max(max(a, b), middle * scale + half_rise) <= -0.5:
                    continue  # too far from the outline at half the way to be passed at all
                share, most = _pass_edge(x, y, a, b, lines_before, lines, between, parts, scale)
            else:
                share = _mean_covered(a, b)
            if max(a, b) < 0.5:  # on the edge itself: never wholly covered
                cover = most
                if now > 0.0 and b > -0.5:
                    far = _far_edge(xs[k], ys[k], lines, heel, tip, turn_b) * scale
                    cover = max(cover, _covered(b) + _covered(far) - 1.0)
                if then > 0.0 and a > -0.5:
                    far = _far_edge(xs[k], ys[k], lines_before, heel_a, tip_a, turn_a) * scale
                    cover = max(cover, _covered(a) + _covered(far) - 1.0)
                if cover <= 0.0:
                    continue
        out_ids[found] = ids[k]
        out_share[found] = share * stretch[k]
        out_cover[found] = cover
        found += 1
    return found


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
    margin = (0.5 + frame[_END_RISE]) / frame[_SCALE]
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
            x < frame[_BOX] - slack
            or x > frame[_BOX + 1] + slack
            or y < frame[_BOX + 2] - slack
            or y > frame[_BOX + 3] + slack
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
            slope = np.sqrt(1.0 - facing * facing) / max(facing, _LEAST_FACING) + 2.0 * spread
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
def _gather(before, after, field, margin, scale, counters, room):
    """Find and weigh every vertex that the sweep covers; -1 where the mesh needs room to grow."""
    target = after if after.values[st.TOUCHES] > 0.0 else before
    values = target.values
    _sweep_bounds(before, after, target, margin, room.bounds)
    _fill_frame(before, after, values, scale, room.bounds, room.frame)
    _fill_between(before, after, room.frame, room.between)
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
            found = _take_run(
                first, last, px, py, pz, nx, ny, nz, frame, found_ids, share, cover, found
            )
            first = last
        while first < last:
            if filled == size:
                found = _weigh_block(
                    filled, ids, xs, ys, stretch, frame, lines, lines_before, between, work,
                    near, found_ids, share, cover, found,
                )  # fmt: skip
                filled = 0
            n = min(last - first, size - filled)
            _project_run(px, py, pz, nx, ny, nz, first, n, frame, xs, ys, stretch, filled)
            for k in range(n):
                ids[filled + k] = first + k
                if not alone and stamps[vertex_sheet[first + k]] != tick:
                    xs[filled + k] = _AWAY
            first += n
            filled += n
        v = head[cell]
        while v >= 0:
            if filled == size:
                found = _weigh_block(
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
            _project_ids(px, py, pz, nx, ny, nz, ids, start, filled, frame, xs, ys, stretch)
    found = _weigh_block(
        filled, ids, xs, ys, stretch, frame, lines, lines_before, between, work, near,
        found_ids, share, cover, found,
    )  # fmt: skip
    counters[VISITED] += visited
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _take_run(first, last, px, py, pz, nx, ny, nz, frame, out_ids, out_share, out_cover, found):
    """All vertices of a run that lands well inside the outline, but those facing away.

    First as if there were none of those, in vector instructions; if there are, once more.
    """
    ox, oy, oz = np.float32(frame[0]), np.float32(frame[1]), np.float32(frame[2])
    ux, uy, uz = np.float32(frame[3]), np.float32(frame[4]), np.float32(frame[5])
    r2 = np.float32(frame[_RADIUS2])
    least = np.float32(_LEAST_FACING)
    one = np.float32(1.0)
    n = last - first
    px, py, pz = px[first:last], py[first:last], pz[first:last]
    nx, ny, nz = nx[first:last], ny[first:last], nz[first:last]
    ids = out_ids[found : found + n]
    share = out_share[found : found + n]
    cover = out_cover[found : found + n]
    refused = np.int32(0)
    for k in range(n):
        cosine = nx[k] * ux + ny[k] * uy + nz[k] * uz
        height = (px[k] - ox) * ux + (py[k] - oy) * uy + (pz[k] - oz) * uz
        bad = (cosine < least) | (height * height > r2)
        refused += np.int32(bad)
        inverse = one / cosine
        ids[k] = first + k
        share[k] = inverse * inverse
        cover[k] = -one if bad else one
    if refused == 0:
        return found + n
    kept = 0
    for k in range(n):
        if cover[k] > 0.0:
            ids[kept] = ids[k]
            share[kept] = share[k]
            cover[kept] = one
            kept += 1
    return found + kept


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
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


@njit(cache=True, nogil=True, error_model="numpy")
def _weighed_area(area_units, unit, ids, share, n):
    """Area that the found vertices stand for, weighed, mm2.

    Summed in whole numbers, so that the order in which vertices are found, which depends on what
    was refined before, cannot change a bit of it.
    """
    total = np.int64(0)
    for k in range(n):
        total += np.int64(share[k] * area_units[ids[k]] * unit * _AREA_STEPS)
    return total / _AREA_STEPS


@njit(cache=True, nogil=True, error_model="numpy")
def _leave(ids, share, cover, n, part, amounts, coverage, dirty, dirty_ids, n_dirty):
    """Add every vertex's share of each pigment, and note whose colour is out of date."""
    count = n_dirty[0]
    for p in range(part.shape[0]):
        column = np.float32(part[p])
        if column != 0.0:
            for k in range(n):
                amounts[ids[k], p] += column * share[k]
    for k in range(n):
        v = ids[k]
        if cover[k] > coverage[v]:
            coverage[v] = cover[k]
        if dirty[v] == 0:
            dirty[v] = 1
            dirty_ids[count] = v
            count += 1
    n_dirty[0] = count

"""From a brush pose to a stamp on the surface: contact, bending, enclosing sphere, plane.

The order is the paper's (Guo 2017, section 4.2.1): foot point of the root node, bent brush, its
enclosing sphere, the patch of surface inside the sphere, the mean normal of the patch, the plane
through the foot point, and the outline in that plane. The mean runs over the *surface* in the
patch, weighted by area, and not over its vertices, so that refining the mesh changes nothing.

A hand that paints under a pen or pointer means a place on the surface and not one of the root.
Then that place stands for the foot point, wherever the handle leans, and the middle of the outline
lies there: half-way between its ends along the bend and, where the brush moves, half-way between
the sides of the mark that it draws, so that a brush turned against its way paints no further to one
side than to the other.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.drag import (
    bent_by_twist,
    drag_length,
    drag_step,
    drag_way,
    lie_held,
    release,
    smooth_step,
    trail_step,
    twist_step,
)
from paint3d.brush_engine.footprint import (
    PROFILE_CELLS,
    fill_profile,
    hold_point,
    keep_profile,
)
from paint3d.brush_engine.outline import gather_outline, round_tip, trace_outline
from paint3d.brush_engine.tuft import enclose_tuft, greatest_descent
from paint3d.core.kernel import uncounted
from paint3d.core.quaternion import compiled_x_axis, compiled_y_axis, compiled_z_axis
from paint3d.mesh.kernels.bvh import find_foot, find_meant
from paint3d.mesh.kernels.mesh_arrays import find_cell, flood_patch, sheet_of

__all__ = [
    "LEANING_OVER",
    "OVERPRESSED",
    "REACH",
    "TILT_LIMITED",
    "lean_plane",
    "place_stamp",
    "start_sheet",
]

TILT_LIMITED = 4  # counter: stamps whose tilt was below the table's range
OVERPRESSED = 5  # counter: stamps pressed deeper than the tuft can be bent
LEANING_OVER = 6  # counter: stamps whose handle leans over the bend; they are an upright one's
REACH = 1.05  # of the tuft's length: farther than this the root cannot touch the surface
_UPRIGHT = 0.0175  # sine of a degree: no more than that counts as leaning over
_OVER = 0.1  # of a far root's distance: farther beside its foot's normal it is not over the surface
_LEAST_FADE = 0.25  # of a cell: over which a sheet of surface comes to count
_OTHER_SIDE = -0.5  # cosine to the foot's normal: what faces farther away is a wall's other side
_FIRST_DRAG = 0.35  # of the slack: how far a tuft that comes down is dragged towards its bend
# Where along the noise of the bundles a tuft comes down: mm of it, and waves to the mm of place.
_PARTS_MM = 150.0
_PARTS = ((0.31, 0.17, 0.23), (-0.13, 0.29, 0.19), (0.21, -0.24, 0.27))
_TRAIL = 0.5  # of the footprint's half width: a way so long tells whither a brush goes


@uncounted
def place_stamp(pose, dragged, before, after, tuft, tree, field, scratch):
    """Fill `after` with the footprint of a pose.

    The pose (9,) is a position, a quaternion wxyz, the pressure or NaN, and 1 where the position is
    the place on the surface that the hand means; else 0, and it is the root's. `before` is the
    stamp the brush comes from; it carries the dragged point. It may be `after`.
    """
    last, values = before.values[0], after.values[0]
    up = compiled_z_axis((pose[3], pose[4], pose[5], pose[6]))  # up the handle
    was_touching = last.touches > 0.0
    for axis in range(3):
        scratch.vector[axis] = last.foot[axis]
        scratch.drag[axis] = last.drag[axis]
        scratch.held[axis] = last.held[axis]
    descent, aside, short = last.descent, last.aside, last.short
    twist = last.twist if was_touching else 0.0
    last_bend = (last.bend[0], last.bend[1], last.bend[2])
    centred = pose[8] > 0.0
    trail = _TRAIL * last.widest if was_touching and centred else 0.0
    values.touches = 0.0
    values.centred = pose[8]
    values.way = last.way if was_touching else 0.0
    if not _find_place(pose, up, tuft, tree, values, scratch):
        return
    values.parted = last.parted if was_touching else _part_hairs(values.foot)
    if centred and not dragged:
        _follow_way(values, trail, scratch)
    _bend_along_pose(values, pose)
    _press(pose, up, values, tuft)
    if values.descent <= 0.0:
        _flatten(values, _straight_reach(values, tuft))
        for axis in range(3):
            values.drag[axis] = scratch.drag[axis]
        return
    if dragged:
        _bend_along_drag(values, descent if was_touching else -1.0, tuft, scratch)
    _lean_plane(values, tuft, field, scratch)
    if dragged:
        _set_bend(values, values.drag[0], values.drag[1], values.drag[2])
    else:
        _bend_along_pose(values, pose)
    _press(pose, up, values, tuft)
    if not centred:
        _settle(values, up, tuft)
    _count_limits(up, values, tuft, scratch.counters)
    if dragged:
        values.bent = _bent_by_drag(values, tuft)
    else:
        values.twist = _twist(values, last_bend, twist, was_touching, tuft, scratch)
        values.bent = bent_by_twist(values.twist)
    _lay_outline(after, dragged, trail, tuft, scratch)
    if values.touches > 0.0:
        if dragged and not centred:
            _hold_tip(after, scratch.held, aside, short, descent, scratch.vector, was_touching)
        _hold_outline(values)


@uncounted
def _part_hairs(foot):
    """Position on the bundles' noise at which a tuft comes down, mm: a press parts hairs anew.

    By folds of the position, which have the same bits on every machine.
    """
    total = 0.0
    for x, y, z in _PARTS:
        waves = x * foot[0] + y * foot[1] + z * foot[2]
        total += abs(waves - np.floor(waves) - 0.5)
    return _PARTS_MM * total


@uncounted(forceinline=True)
def _find_place(pose, up, tuft, tree, values, scratch):
    """Stand a stamp on the root's foot point, or the point that the hand means; False: nowhere."""
    foot, reach, place = scratch.foot, REACH * tuft.length, (pose[0], pose[1], pose[2])
    if values.centred > 0.0:
        triangle = find_meant(tree, place, up, reach, foot)
    else:
        triangle = find_foot(tree, place, up, reach, foot, scratch.warm)
        if triangle < 0 and pose[7] >= 0.0:
            triangle = _find_far(tree, place, up, foot, scratch.warm)
    values.triangle = triangle
    if triangle < 0:
        for axis in range(3):
            values.origin[axis] = pose[axis]
            values.foot[axis] = pose[axis]
        _flatten(values, 0.0)
        return False
    for axis in range(3):
        values.origin[axis] = foot[axis]
        values.foot[axis] = foot[axis]
        values.normal[axis] = foot[3 + axis]
        values.foot_normal[axis] = foot[3 + axis]
    return True


@uncounted(forceinline=True)
def _lean_plane(values, tuft, field, scratch):
    """Enclose the bent tuft, and lean the stamp's plane to the surface that it stands on."""
    along, up, radius = enclose_tuft(tuft, values.descent, values.tilt, values.pressure)
    extent = 0.0
    if values.centred > 0.0:
        middle, extent = _trace_extent(values, tuft, scratch)
        along -= middle
    for axis in range(3):
        values.sphere_centre[axis] = (
            scratch.foot[axis] + along * values.bend[axis] + up * values.normal[axis]
        )
    values.radius = radius
    if values.centred > 0.0:
        _lean_plane_under(values, extent, field, scratch)
    else:
        lean_plane(values, field, scratch)


@uncounted(forceinline=True)
def _lay_outline(stamp, dragged, trail, tuft, scratch):
    """Trace a placed stamp's outline, around the place that the hand means where it means one."""
    values = stamp.values[0]
    n = _trace(values, tuft, scratch)
    if n < 2:
        _flatten(values, _straight_reach(values, tuft))
        return
    straight = tuft.length * np.cos(values.tilt)
    round_tip(scratch.reach, scratch.half_width, n)
    gather_outline(values.bent, straight, scratch.reach, scratch.half_width, n)
    if values.centred > 0.0:
        middle = 0.5 * (scratch.reach[0] + scratch.reach[n - 1])
        for axis in range(3):
            values.origin[axis] = scratch.foot[axis] - middle * values.bend[axis]
    fill_profile(stamp, scratch.reach, scratch.half_width, n)
    if values.centred > 0.0 and not dragged:
        _centre_mark(values, stamp.half_widths, trail)
    if values.area > 0.0:
        values.touches = 1.0


@uncounted
def _hold_tip(stamp, tip, aside, short, descent, foot, was_touching):
    """Lay a dragged footprint so that its tip is where the paper holds it.

    Parameters
    ----------
    stamp : Stamp
        As the tuft lies in its bend; it is turned about its heel and shortened, and where its tip
        is held is set.
    tip : (3,) float64
        Where the tip was held at the stamp before, mm.
    aside, short, descent : float
        Of the stamp before; rad, mm, mm.
    foot : (3,) float64
        And its foot, mm.
    was_touching : bool
        Whether it touched; a tuft that comes down lies in its bend.
    """
    values = stamp.values[0]
    length = values.tip - values.heel
    values.aside, values.short = 0.0, 0.0
    if was_touching:
        along, across, way2 = 0.0, 0.0, 0.0
        for axis in range(3):
            d = tip[axis] - values.origin[axis] - values.heel * values.bend[axis]
            along += d * values.bend[axis]
            across += d * values.cross[axis]
            way2 += (values.foot[axis] - foot[axis]) ** 2
        pressed = values.descent - descent
        values.aside, values.short = trail_step(
            along, across, aside, short, length, np.sqrt(way2), pressed, values.bent
        )
    distance = length - values.short
    x, y = np.cos(values.aside), np.sin(values.aside)
    for axis in range(3):
        values.held[axis] = (
            values.origin[axis]
            + (values.heel + distance * x) * values.bend[axis]
            + distance * y * values.cross[axis]
        )
    if values.aside != 0.0 or values.short != 0.0:
        x, y, shorter = lie_held(values.aside, values.short, length, values.bent)
        _turn_about_heel(values, x, y)
        keep_profile(stamp, values.heel, values.tip - shorter)


@uncounted
def _turn_about_heel(values, x, y):
    """Turn a footprint about its heel, so that its bend is (x, y) along what it was."""
    for axis in range(3):
        bend, cross = values.bend[axis], values.cross[axis]
        values.bend[axis] = x * bend + y * cross
        values.cross[axis] = x * cross - y * bend
        values.origin[axis] += values.heel * (bend - values.bend[axis])


@uncounted
def _bent_by_drag(values, tuft):
    """Degree to which a dragged tuft lies in its bend: as far as the paper has pulled its tip."""
    slack = drag_length(values.descent, tuft.length, tuft.drag_fraction)
    dragged2 = 0.0
    for axis in range(3):
        dragged2 += values.drag[axis] ** 2
    return smooth_step(np.sqrt(dragged2) / max(slack, 1e-9))


@uncounted
def _twist(values, last_bend, twist, was_touching, tuft, scratch):
    """The twist (rad) of a commanded tuft that came from a foot and a bend."""
    if not was_touching:
        return 0.0
    cosine, sine, way2 = 0.0, 0.0, 0.0
    for axis in range(3):
        cosine += last_bend[axis] * values.bend[axis]
        sine -= last_bend[axis] * values.cross[axis]
        way2 += (values.foot[axis] - scratch.vector[axis]) ** 2
    slack = drag_length(values.descent, tuft.length, tuft.drag_fraction)
    return twist_step(twist, np.arctan2(sine, cosine), np.sqrt(way2), slack)


@uncounted
def _straight_reach(values, tuft):
    """Reach of the straight tip along the bend from where the stamp stands, mm."""
    return 0.0 if values.centred > 0.0 else tuft.length * np.cos(values.tilt)


@uncounted
def _find_far(tree, root, up, foot, warm):
    """The foot of a root that stands over the surface at any height; -1 beside the surface.

    A hand that says how hard it presses does press, wherever its root is said to be.
    """
    triangle = find_foot(tree, root, up, np.inf, foot, warm)
    if triangle < 0:
        return -1
    height, away = 0.0, 0.0
    for axis in range(3):
        height += (root[axis] - foot[axis]) * foot[3 + axis]
        away += (root[axis] - foot[axis]) ** 2
    return triangle if away - height * height <= _OVER * _OVER * away else -1


@uncounted
def _trace(values, tuft, scratch):
    """The outline as the tuft is bent now, into the scratch; returns how many points it has."""
    return trace_outline(
        tuft,
        values.descent,
        values.tilt,
        values.pressure,
        scratch.tuft,
        scratch.reach,
        scratch.half_width,
    )


@uncounted
def _trace_extent(values, tuft, scratch):
    """Reach of the outline's middle from P'_m along the bend, and half its longer side, mm.

    Both are 0 where nothing touches.
    """
    n = _trace(values, tuft, scratch)
    if n == 0:
        return 0.0, 0.0
    half = 0.5 * (scratch.reach[0] - scratch.reach[n - 1])
    for k in range(n):
        half = max(half, scratch.half_width[k])
    return 0.5 * (scratch.reach[0] + scratch.reach[n - 1]), half


@uncounted
def _flatten(values, reach):
    """No footprint: the outline is one point, where the straight tip would be."""
    values.heel = reach
    values.tip = reach
    values.widest_at = reach
    values.widest = 0.0
    values.area = 0.0


@uncounted
def _set_bend(values, bx, by, bz):
    """Make (bx, by, bz), laid into the plane, the bend's direction; False if it stands upright."""
    nx = values.normal[0]
    ny = values.normal[1]
    nz = values.normal[2]
    along = bx * nx + by * ny + bz * nz
    bx -= along * nx
    by -= along * ny
    bz -= along * nz
    norm = np.sqrt(bx * bx + by * by + bz * bz)
    if norm < 1e-9:
        return False
    bx /= norm
    by /= norm
    bz /= norm
    values.bend[0] = bx
    values.bend[1] = by
    values.bend[2] = bz
    values.cross[0] = ny * bz - nz * by
    values.cross[1] = nz * bx - nx * bz
    values.cross[2] = nx * by - ny * bx
    return True


@uncounted
def _bend_along_pose(values, pose):
    """Commanded azimuth: the pen's x axis laid into the plane (its y axis where x stands up)."""
    orientation = (pose[3], pose[4], pose[5], pose[6])
    bx, by, bz = compiled_x_axis(orientation)
    if not _set_bend(values, bx, by, bz):
        bx, by, bz = compiled_y_axis(orientation)
        _set_bend(values, bx, by, bz)


@uncounted
def _bend_along_drag(values, descent, tuft, scratch):
    """Dragged azimuth: the paper pulls the tip along (a tractrix with slack).

    `descent` is that of the stamp before; less than 0 if this one comes down.
    """
    slack = drag_length(values.descent, tuft.length, tuft.drag_fraction)
    rx, ry, rz = scratch.drag[0], scratch.drag[1], scratch.drag[2]
    if rx * rx + ry * ry + rz * rz == 0.0:
        rx = _FIRST_DRAG * slack * values.bend[0]
        ry = _FIRST_DRAG * slack * values.bend[1]
        rz = _FIRST_DRAG * slack * values.bend[2]
    elif descent < 0.0:
        rx, ry, rz = release(rx, ry, rz, tuft.plasticity)
    else:
        rx, ry, rz = drag_way(
            rx,
            ry,
            rz,
            values.foot[0] - scratch.vector[0],
            values.foot[1] - scratch.vector[1],
            values.foot[2] - scratch.vector[2],
            drag_length(descent, tuft.length, tuft.drag_fraction),
            slack,
        )
    _set_bend(values, rx, ry, rz)
    values.drag[0] = rx
    values.drag[1] = ry
    values.drag[2] = rz


@uncounted
def _follow_way(values, trail, scratch):
    """Pull the dragged point behind the place that the hand means, at most `trail` (mm) away.

    With `trail` 0 the brush comes down: it has no way yet. Nothing is bent by this point.
    """
    rx, ry, rz = 0.0, 0.0, 0.0
    if trail > 0.0:
        rx, ry, rz = drag_step(
            scratch.drag[0],
            scratch.drag[1],
            scratch.drag[2],
            values.foot[0] - scratch.vector[0],
            values.foot[1] - scratch.vector[1],
            values.foot[2] - scratch.vector[2],
            trail,
        )
    values.drag[0] = rx
    values.drag[1] = ry
    values.drag[2] = rz


@uncounted
def _centre_mark(values, half_widths, trail):
    """Move the outline across its way, so that it reaches as far to both sides of the place."""
    along, across = 0.0, 0.0  # the way's direction in the plane
    for axis in range(3):
        along -= values.drag[axis] * values.bend[axis]
        across -= values.drag[axis] * values.cross[axis]
    length = np.sqrt(along * along + across * across)
    if length <= 1e-9 or trail <= 0.0:
        return
    side_x, side_y = -across / length, along / length
    half = 0.5 * (values.tip - values.heel)
    left, right = 0.0, 0.0
    for i in range(PROFILE_CELLS + 1):
        x = (2.0 * i / PROFILE_CELLS - 1.0) * half * side_x
        y = half_widths[i] * abs(side_y)
        left = max(left, x + y)
        right = max(right, y - x)
    aside = 0.5 * (left - right) * min(1.0, length / trail)
    for axis in range(3):
        values.origin[axis] -= aside * (side_x * values.bend[axis] + side_y * values.cross[axis])


@uncounted
def _press(pose, up, values, tuft):
    """Tilt, descent D_s and pe: by Eq. 4 from the pressure, else from the root's height.

    Where the hand means a place, there is a pressure, and the tilt is the handle's lean along the
    bend alone.
    """
    if values.centred > 0.0:
        _limit_tilt(values, up, tuft)
        _set_descent(values, pose[7] * tuft.full_press, tuft)
        return
    sine = _sine_of_tilt(values, up)
    sine = min(1.0, max(np.sin(tuft.lowest_tilt), sine))
    values.tilt = np.arcsin(sine)
    if np.isnan(pose[7]):
        height = 0.0
        for axis in range(3):
            height += (pose[axis] - values.foot[axis]) * values.normal[axis]
        descent = tuft.length * sine - height
    else:
        descent = pose[7] * tuft.full_press
    _set_descent(values, descent, tuft)


@uncounted
def _set_descent(values, descent, tuft):
    descent = min(descent, greatest_descent(tuft, values.tilt))
    values.descent = descent
    values.pressure = min(1.0, max(0.0, descent / tuft.full_press))


@uncounted
def _settle(values, up, tuft):
    """Set the outline so that a tuft pressed ever less ends where its straight tip touches.

    The papers' outline is counted from the root's foot in the plane, and its bend plane holds the
    handle. Where the plane leans, the root's foot moves from P'_m; and where the handle leans to a
    side of the bend or over it, only its lean along the bend is the model's tilt, and the rest
    moves the outline.
    """
    length = tuft.length
    nx, ny, nz = values.normal[0], values.normal[1], values.normal[2]
    fx, fy, fz = (
        values.foot_normal[0],
        values.foot_normal[1],
        values.foot_normal[2],
    )
    height = length * (up[0] * fx + up[1] * fy + up[2] * fz) - values.descent
    # from P'_m to the straight tip, in the plane
    tx = height * fx - length * up[0]
    ty = height * fy - length * up[1]
    tz = height * fz - length * up[2]
    lean = _limit_tilt(values, up, tuft)
    tilt = values.tilt
    back = length * np.cos(tilt) + length * max(0.0, lean - np.cos(tilt))
    tx -= back * values.bend[0]
    ty -= back * values.bend[1]
    tz -= back * values.bend[2]
    along = tx * nx + ty * ny + tz * nz
    values.origin[0] = values.foot[0] + tx - along * nx
    values.origin[1] = values.foot[1] + ty - along * ny
    values.origin[2] = values.foot[2] + tz - along * nz
    values.descent = min(values.descent, greatest_descent(tuft, tilt))


@uncounted
def _limit_tilt(values, up, tuft):
    """Make the handle's lean along the bend the model's tilt; returns the sine of that lean."""
    lean = _lean(values, up)
    values.tilt = max(np.arccos(min(1.0, max(0.0, lean))), tuft.lowest_tilt)
    return lean


@uncounted
def _lean(values, up):
    return -(up[0] * values.bend[0] + up[1] * values.bend[1] + up[2] * values.bend[2])


@uncounted
def _hold_outline(values):
    """Enlarge the enclosing sphere, made before the plane leaned, to hold the outline."""
    for along, across in (
        (values.tip, 0.0),
        (values.heel, 0.0),
        (values.widest_at, values.widest),
        (values.widest_at, -values.widest),
    ):
        hold_point(values, along, across)


@uncounted
def _sine_of_tilt(values, up):
    return up[0] * values.normal[0] + up[1] * values.normal[1] + up[2] * values.normal[2]


@uncounted
def _count_limits(up, values, tuft, counters):
    """Keep count of what the model could not follow, so that a report can say so.

    A handle over a place that the hand means may lean to the side of the bend as far as it likes.
    """
    if values.centred > 0.0:
        upright = np.sin(np.arccos(min(1.0, max(0.0, _lean(values, up)))))
    else:
        upright = _sine_of_tilt(values, up)
    if upright < np.sin(tuft.lowest_tilt) - 1e-9:
        counters[TILT_LIMITED] += 1
    if values.descent >= greatest_descent(tuft, values.tilt):
        counters[OVERPRESSED] += 1
    if _lean(values, up) < -_UPRIGHT:
        counters[LEANING_OVER] += 1


@uncounted
def start_sheet(values, field):
    """The sheet of surface under the foot point, or -1."""
    cell = find_cell(field, values.foot[0], values.foot[1], values.foot[2])
    if cell < 0:
        return -1
    return sheet_of(field, cell, int(values.triangle))


@uncounted
def lean_plane(values, field, scratch):
    """Replace the plane's normal by the mean over the effective patch (Guo 2017, Fig. 7).

    Sheets of surface that face away from the brush are left out (the far side of a thin wall), and
    those at the sphere's border fade in, so that the plane does not jump as the brush moves.
    """
    if _flood(values, field, scratch.patch) > 0:
        pack, centre = field.sheet_pack, values.sphere_centre
        total = _sum_normals(
            pack, scratch.patch, values, centre, values.radius, field.cell_size, 0.0
        )
        _set_normal(values, total)


@uncounted
def _flood(values, field, patch):
    """Find the sheets of the patch in the enclosing sphere; how many, 0 where no surface is."""
    sheet = start_sheet(values, field)
    if sheet < 0:
        return 0
    radius = values.radius + field.cell_size
    return flood_patch(field, sheet, values.sphere_centre, radius, patch)


@uncounted
def _lean_plane_under(values, extent, field, scratch):
    """Lean the plane to the surface under a footprint around the point that is meant.

    The enclosing sphere is that of the whole tuft, many times as wide. What it holds of a wall or
    of the far side of a crease, which the footprint does not touch, would lean the plane so far
    that what lies under the footprint faces away from it. `extent` is half the outline's longer
    side, mm.
    """
    if _flood(values, field, scratch.patch) == 0:
        return
    cell = field.cell_size
    fade = max(_LEAST_FADE * cell, min(cell, extent))
    total = _sum_normals(
        field.sheet_pack, scratch.patch, values, values.foot, extent, fade, _OTHER_SIDE
    )
    _set_normal(values, total)


@uncounted
def _set_normal(values, vector):
    """Make a vector's direction the plane's normal; it stays as it is where there is none."""
    sum_x, sum_y, sum_z = vector[0], vector[1], vector[2]
    norm = np.sqrt(sum_x * sum_x + sum_y * sum_y + sum_z * sum_z)
    if norm > 0.0:
        values.normal[0] = sum_x / norm
        values.normal[1] = sum_y / norm
        values.normal[2] = sum_z / norm


@uncounted(error_model="numpy")
def _sum_normals(pack, patch, values, centre, radius, fade, least):
    """Sum the area-weighted normals of the sheets in a ball that face as the foot's surface does.

    The N of docs/model.md, equation (6), before it is normalised. At the ball's border they fade in
    over the way `fade`, mm. `least` is the cosine to the foot's normal, times the sheet's area,
    that a sheet must exceed. `pack` is that of a `SurfaceField`.
    """
    cx, cy, cz = centre[0], centre[1], centre[2]
    fx = values.foot_normal[0]
    fy = values.foot_normal[1]
    fz = values.foot_normal[2]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(patch.count[0]):
        s = patch.sheets[k]
        nx, ny, nz = pack[s, 0], pack[s, 1], pack[s, 2]
        if nx * fx + ny * fy + nz * fz <= least * pack[s, 3]:
            continue
        dx = pack[s, 4] - cx
        dy = pack[s, 5] - cy
        dz = pack[s, 6] - cz
        weight = (radius - np.sqrt(dx * dx + dy * dy + dz * dz)) / fade + 0.5
        if weight <= 0.0:
            continue
        weight = min(1.0, weight)
        x += weight * nx
        y += weight * ny
        z += weight * nz
    return x, y, z

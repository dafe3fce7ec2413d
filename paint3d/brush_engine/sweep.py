"""The way of a footprint from one stamp to the next, in the plane of one of them.

A sweep's *frame* is everything that the loops over vertices need, as one array of numbers: the
plane, the rectangle around both outlines, how one stamp's coordinates turn into the other's, and
how finely the way between them is followed for vertices near the edge.
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine import stamp as st
from paint3d.core.kernel import uncounted

__all__ = [
    "AFTER", "BALL", "BALL2", "BEFORE", "BEND", "BETWEEN_SHAPE", "BOX", "BOX_BEFORE", "CARRY2",
    "CROSS", "END", "END_RISE", "FRAME_SIZE", "NORMAL", "ORIGIN", "PARTS", "RADIUS2", "RISE",
    "RISES", "SCALE", "SPHERE", "TURN_AFTER", "fill_between", "fill_frame", "sweep_bounds",
]  # fmt: skip

_MOST_PARTS = 8  # that the way between two stamps is cut into for vertices near the edge
_PART_SHARE = 0.05  # of the footprint's smaller extent, the longest part
_PART_WIDTH = 0.25  # of the soft edge, the shortest

# Places in the frame.
ORIGIN, NORMAL, BEND, CROSS, SPHERE = 0, 3, 6, 9, 12
RADIUS2, BOX, BOX_BEFORE, SCALE, AFTER, BEFORE = 15, 16, 20, 24, 25, 28
TURN_AFTER, PARTS, RISE, END_RISE, END, RISES = 31, 35, 36, 37, 38, 39
CARRY2, BALL, BALL2 = 43, 44, 47
FRAME_SIZE = 48  # numbers in it
BETWEEN_SHAPE = (_MOST_PARTS, 6)


@uncounted(error_model="numpy")
def sweep_bounds(before, after, plane, margin, bounds):
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


@uncounted(error_model="numpy")
def fill_frame(before, after, plane, scale, bounds, frame):
    """Gather the numbers of a sweep from its stamps; `plane` holds the plane's values."""
    for k in range(3):
        frame[ORIGIN + k] = plane[st.ORIGIN_X + k]
        frame[NORMAL + k] = plane[st.NORMAL_X + k]
        frame[BEND + k] = plane[st.BEND_X + k]
        frame[CROSS + k] = plane[st.CROSS_X + k]
        frame[SPHERE + k] = plane[st.SPHERE_X + k] - plane[st.ORIGIN_X + k]
    # the sphere is that of one stamp: the other's outline sticks out by what it moved
    sticks_out = 0.5 / scale + st.outline_motion(before, after)
    frame[RADIUS2] = (plane[st.RADIUS] + sticks_out) ** 2
    frame[CARRY2] = np.inf
    if plane[st.CENTRED] > 0.0:
        half = max(_half_extent(before.values), _half_extent(after.values))
        frame[CARRY2] = (half + sticks_out) ** 2
    _fill_ball(before, after, plane, scale, frame)
    for k in range(8):
        frame[BOX + k] = bounds[k]
    frame[SCALE] = scale
    for at, values in ((AFTER, after.values), (BEFORE, before.values)):
        frame[at] = values[st.TOUCHES]
        frame[at + 1] = values[st.HEEL]
        frame[at + 2] = values[st.TIP]
    frame[TURN_AFTER : TURN_AFTER + 4] = 0.0
    frame[TURN_AFTER + 2] = 1.0


@uncounted(error_model="numpy")
def _fill_ball(before, after, plane, scale, frame):
    """The ball that what is painted lies in, around places that the hand means.

    Surface that bends away unfolds into the plane, which carries it farther from the place. What is
    carried nearer looks another way than it should from there: the far side of a groove, a fillet
    beyond a crease. `BALL` is counted from the plane's origin.
    """
    frame[BALL : BALL + 3] = 0.0
    frame[BALL2] = np.inf
    if plane[st.CENTRED] <= 0.0:
        return
    a, b = before.values, after.values
    both = a[st.TOUCHES] > 0.0 and b[st.TOUCHES] > 0.0
    apart2 = 0.0
    for k in range(3):
        middle = plane[st.FOOT_X + k]
        if both:
            middle = 0.5 * (a[st.FOOT_X + k] + b[st.FOOT_X + k])
            apart2 += (a[st.FOOT_X + k] - b[st.FOOT_X + k]) ** 2
        frame[BALL + k] = middle - plane[st.ORIGIN_X + k]
    reach = max(_reach_from_foot(before), _reach_from_foot(after))
    frame[BALL2] = (reach + 0.5 * np.sqrt(apart2) + 0.5 / scale) ** 2


@uncounted(error_model="numpy")
def _reach_from_foot(stamp):
    """How far an outline's farthest point lies from the place that the hand means, mm."""
    values = stamp.values
    if values[st.TOUCHES] <= 0.0:
        return 0.0
    x, y = 0.0, 0.0  # where the outline is counted from
    for k in range(3):
        d = values[st.ORIGIN_X + k] - values[st.FOOT_X + k]
        x += d * values[st.BEND_X + k]
        y += d * values[st.CROSS_X + k]
    x, y = x + values[st.HEEL], abs(y)
    step = (values[st.TIP] - values[st.HEEL]) / st.PROFILE_CELLS
    farthest2 = 0.0
    for i in range(st.PROFILE_CELLS + 1):
        side = y + stamp.half_widths[i]
        farthest2 = max(farthest2, (x + i * step) ** 2 + side * side)
    return np.sqrt(farthest2)


@uncounted(error_model="numpy")
def _half_extent(values):
    """Half the longer side of a footprint, mm; 0 where there is none."""
    if values[st.TOUCHES] <= 0.0:
        return 0.0
    return max(0.5 * (values[st.TIP] - values[st.HEEL]), values[st.WIDEST])


@uncounted(error_model="numpy")
def fill_between(before, after, frame, between):
    """Where the outline stands between two stamps that touch: rows of turn (4), heel and tip.

    An outline passes a vertex near its edge on a curve, not straight from its distance at one
    stamp to that at the other. Cutting the way for these vertices alone costs less than more
    stamps would.
    """
    frame[PARTS] = 1.0
    frame[RISE] = 0.0
    frame[END_RISE] = 0.0
    frame[END] = 0.0
    frame[RISES : RISES + 3] = 0.0
    frame[RISES + 3] = 0.5 / frame[SCALE]
    a = before.values
    b = after.values
    if a[st.TOUCHES] <= 0.0 or b[st.TOUCHES] <= 0.0:
        return
    extent = min(a[st.TIP] - a[st.HEEL], b[st.TIP] - b[st.HEEL])
    extent = min(extent, 2.0 * min(a[st.WIDEST], b[st.WIDEST]))
    motion = st.outline_motion(before, after)
    part = max(_PART_SHARE * extent, _PART_WIDTH / frame[SCALE])
    parts = min(_MOST_PARTS, int(np.ceil(motion / part)))
    if parts < 2:
        return
    frame[PARTS] = parts
    # how far beyond both stamps' edges the edge gets on its way: a flank that is carried along
    # bulges by the height of an arc, the pointed tip stands out by half its way to the side
    widest = min(a[st.WIDEST], b[st.WIDEST])
    frame[RISE] = min(0.5 * motion, motion * motion / (4.0 * widest)) * frame[SCALE]
    aside = abs(frame[BOX_BEFORE + 1] + frame[BOX_BEFORE + 3] * a[st.TIP])
    frame[END_RISE] = max(frame[RISE], 0.5 * aside * frame[SCALE])
    frame[END] = st.PROFILE_CELLS * min(0.5, motion / (a[st.TIP] - a[st.HEEL]))
    frame[RISES] = frame[RISE] / frame[SCALE]
    frame[RISES + 1] = frame[END_RISE] / frame[SCALE]
    frame[RISES + 2] = motion
    turn = np.arctan2(frame[BOX_BEFORE + 3], frame[BOX_BEFORE + 2])
    for k in range(parts):  # row 0: half the way
        back = 1.0 - k / parts if k > 0 else 0.5
        between[k, 0] = back * frame[BOX_BEFORE]
        between[k, 1] = back * frame[BOX_BEFORE + 1]
        between[k, 2] = np.cos(back * turn)
        between[k, 3] = np.sin(back * turn)
        between[k, 4] = back * a[st.HEEL] + (1.0 - back) * b[st.HEEL]
        between[k, 5] = back * a[st.TIP] + (1.0 - back) * b[st.TIP]

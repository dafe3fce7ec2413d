"""The way of a footprint from one stamp to the next, in the plane of one of them.

A sweep holds everything that the loops over vertices need: the plane, the rectangle around both
outlines, how one stamp's coordinates turn into the other's, and how finely the way between them is
followed for vertices near the edge.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine import stamp as st
from paint3d.core.kernel import uncounted

__all__ = ["BETWEEN_SHAPE", "SWEEP", "Sweep", "fill_between", "fill_sweep", "sweep_bounds"]

_MOST_PARTS = 8  # that the way between two stamps is cut into for vertices near the edge
_PART_SHARE = 0.05  # of the footprint's smaller extent, the longest part
_PART_WIDTH = 0.25  # of the soft edge, the shortest

SWEEP = np.dtype(
    [
        ("origin", "f8", 3),  # of the plane, that of one of the stamps, mm
        ("normal", "f8", 3),
        ("bend", "f8", 3),  # its x axis
        ("cross", "f8", 3),  # its y axis
        ("sphere_centre", "f8", 3),  # of the sphere that encloses the brush, from the origin, mm
        ("radius2", "f8"),  # square of its radius, with what the outline moves
        ("box", "f8", 4),  # rectangle around both outlines: x0, x1, y0, y1, mm
        ("to_before", "f8", 4),  # turn to the coordinates of the stamp before: x, y, cosine, sine
        ("to_after", "f8", 4),  # and to those of the stamp after
        ("scale", "f8"),  # widths of the soft edge to the mm
        ("after_touches", "f8"),  # as in a stamp's geometry
        ("after_heel", "f8"),
        ("after_tip", "f8"),
        ("before_touches", "f8"),
        ("before_heel", "f8"),
        ("before_tip", "f8"),
        ("parts", "f8"),  # that the way between is cut into for vertices near the edge
        ("rise", "f8"),  # how far between its ends an outline may stick out, soft edges
        ("end_rise", "f8"),  # and near the tip
        ("end", "f8"),  # how much of the profile is near the tip, cells
        ("rises", "f8", 4),  # the same for whole discs: along, at the end, on the way, margin, mm
        ("carry2", "f8"),  # square of how far a vertex may be carried into the plane, mm2
        ("ball", "f8", 3),  # middle of the ball in which vertices are carried, from the origin, mm
        ("ball2", "f8"),  # square of its radius
    ],
    align=True,
)
"""Everything that the loops over vertices need of a sweep."""

BETWEEN_SHAPE = (_MOST_PARTS, 6)


class Sweep(NamedTuple):
    """The way of a footprint: its numbers, and the stamps that it begins and ends with."""

    values: NDArray  # (1,) of SWEEP
    between: NDArray  # BETWEEN_SHAPE, where the outline stands on the way; see `fill_between`
    before: st.Stamp
    after: st.Stamp


@uncounted(error_model="numpy")
def sweep_bounds(before, after, plane, margin, bounds):
    """Rectangle (x0, x1, y0, y1) in the plane of the stamp `plane` that holds both outlines.

    Also fills bounds[4:8] with the turn (ox, oy, c, s) that carries its coordinates to those of
    `before`: x' = c (x - ox) + s (y - oy), y' = -s (x - ox) + c (y - oy).
    """
    a = before.values[0]
    b = plane.values[0]
    ox = 0.0
    oy = 0.0
    c = 0.0
    s = 0.0
    for k in range(3):
        d = a.origin[k] - b.origin[k]
        ox += d * b.bend[k]
        oy += d * b.cross[k]
        c += a.bend[k] * b.bend[k]
        s += a.bend[k] * b.cross[k]
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
    if after.values[0].touches > 0.0:
        x0, x1, y0, y1 = b.heel, b.tip, -b.widest, b.widest
    if a.touches > 0.0:
        for u in (a.heel, a.tip):
            for v in (-a.widest, a.widest):
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
def fill_sweep(before, after, plane, scale, bounds, sweep):
    """Gather the numbers of a sweep from its stamps; `plane` holds the plane's values."""
    for k in range(3):
        sweep.origin[k] = plane.origin[k]
        sweep.normal[k] = plane.normal[k]
        sweep.bend[k] = plane.bend[k]
        sweep.cross[k] = plane.cross[k]
        sweep.sphere_centre[k] = plane.sphere_centre[k] - plane.origin[k]
    # the sphere is that of one stamp: the other's outline sticks out by what it moved
    sticks_out = 0.5 / scale + st.outline_motion(before, after)
    sweep.radius2 = (plane.radius + sticks_out) ** 2
    sweep.carry2 = np.inf
    if plane.centred > 0.0:
        half = max(_half_extent(before.values[0]), _half_extent(after.values[0]))
        sweep.carry2 = (half + sticks_out) ** 2
    _fill_ball(before, after, plane, scale, sweep)
    for k in range(4):
        sweep.box[k] = bounds[k]
        sweep.to_before[k] = bounds[4 + k]
    sweep.scale = scale
    last, first = after.values[0], before.values[0]
    sweep.after_touches, sweep.after_heel, sweep.after_tip = last.touches, last.heel, last.tip
    sweep.before_touches, sweep.before_heel, sweep.before_tip = first.touches, first.heel, first.tip
    for k in range(4):
        sweep.to_after[k] = 1.0 if k == 2 else 0.0


@uncounted(error_model="numpy")
def _fill_ball(before, after, plane, scale, sweep):
    """The ball that what is painted lies in, around places that the hand means.

    Surface that bends away unfolds into the plane, which carries it farther from the place. What is
    carried nearer looks another way than it should from there: the far side of a groove, a fillet
    beyond a crease. `BALL` is counted from the plane's origin.
    """
    for k in range(3):
        sweep.ball[k] = 0.0
    sweep.ball2 = np.inf
    if plane.centred <= 0.0:
        return
    a, b = before.values[0], after.values[0]
    both = a.touches > 0.0 and b.touches > 0.0
    apart2 = 0.0
    for k in range(3):
        middle = plane.foot[k]
        if both:
            middle = 0.5 * (a.foot[k] + b.foot[k])
            apart2 += (a.foot[k] - b.foot[k]) ** 2
        sweep.ball[k] = middle - plane.origin[k]
    reach = max(_reach_from_foot(before), _reach_from_foot(after))
    sweep.ball2 = (reach + 0.5 * np.sqrt(apart2) + 0.5 / scale) ** 2


@uncounted(error_model="numpy")
def _reach_from_foot(stamp):
    """How far an outline's farthest point lies from the place that the hand means, mm."""
    values = stamp.values[0]
    if values.touches <= 0.0:
        return 0.0
    x, y = 0.0, 0.0  # where the outline is counted from
    for k in range(3):
        d = values.origin[k] - values.foot[k]
        x += d * values.bend[k]
        y += d * values.cross[k]
    x, y = x + values.heel, abs(y)
    step = (values.tip - values.heel) / st.PROFILE_CELLS
    farthest2 = 0.0
    for i in range(st.PROFILE_CELLS + 1):
        side = y + stamp.half_widths[i]
        farthest2 = max(farthest2, (x + i * step) ** 2 + side * side)
    return np.sqrt(farthest2)


@uncounted(error_model="numpy")
def _half_extent(values):
    """Half the longer side of a footprint, mm; 0 where there is none."""
    if values.touches <= 0.0:
        return 0.0
    return max(0.5 * (values.tip - values.heel), values.widest)


@uncounted(error_model="numpy")
def fill_between(before, after, sweep, between):
    """Where the outline stands between two stamps that touch: rows of turn (4), heel and tip.

    An outline passes a vertex near its edge on a curve, not straight from its distance at one
    stamp to that at the other. Cutting the way for these vertices alone costs less than more
    stamps would.
    """
    sweep.parts = 1.0
    sweep.rise = 0.0
    sweep.end_rise = 0.0
    sweep.end = 0.0
    for k in range(3):
        sweep.rises[k] = 0.0
    sweep.rises[3] = 0.5 / sweep.scale
    a = before.values[0]
    b = after.values[0]
    if a.touches <= 0.0 or b.touches <= 0.0:
        return
    extent = min(a.tip - a.heel, b.tip - b.heel)
    extent = min(extent, 2.0 * min(a.widest, b.widest))
    motion = st.outline_motion(before, after)
    part = max(_PART_SHARE * extent, _PART_WIDTH / sweep.scale)
    parts = min(_MOST_PARTS, int(np.ceil(motion / part)))
    if parts < 2:
        return
    sweep.parts = parts
    # how far beyond both stamps' edges the edge gets on its way: a flank that is carried along
    # bulges by the height of an arc, the pointed tip stands out by half its way to the side
    widest = min(a.widest, b.widest)
    sweep.rise = min(0.5 * motion, motion * motion / (4.0 * widest)) * sweep.scale
    aside = abs(sweep.to_before[1] + sweep.to_before[3] * a.tip)
    sweep.end_rise = max(sweep.rise, 0.5 * aside * sweep.scale)
    sweep.end = st.PROFILE_CELLS * min(0.5, motion / (a.tip - a.heel))
    sweep.rises[0] = sweep.rise / sweep.scale
    sweep.rises[1] = sweep.end_rise / sweep.scale
    sweep.rises[2] = motion
    turn = np.arctan2(sweep.to_before[3], sweep.to_before[2])
    for k in range(parts):  # row 0: half the way
        back = 1.0 - k / parts if k > 0 else 0.5
        between[k, 0] = back * sweep.to_before[0]
        between[k, 1] = back * sweep.to_before[1]
        between[k, 2] = np.cos(back * turn)
        between[k, 3] = np.sin(back * turn)
        between[k, 4] = back * a.heel + (1.0 - back) * b.heel
        between[k, 5] = back * a.tip + (1.0 - back) * b.tip

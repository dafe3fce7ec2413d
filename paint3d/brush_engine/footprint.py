"""Footprints: one standing on the surface, the stamp, and its way to the next, the sweep.

A stamp is a plane (through the foot point P'_m, with the mean normal of the effective patch), the
direction of the bend in it, and the footprint's half width tabulated over its length, so that
"is this point under the brush" costs one table look-up. Guo 2017, Eqs. 4, 6-11 and Fig. 7.

A sweep holds everything that the loops over vertices need: the plane, where the way leads in it,
and how its coordinates turn into those of the two stamps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.outline import outline_area
from paint3d.core.kernel import uncounted

__all__ = [
    "GEOMETRY",
    "LAST_PLACE",
    "PROFILE_CELLS",
    "SWEEP",
    "Stamp",
    "fill_profile",
    "fill_sweep",
    "find_way",
    "hold_point",
    "ink_way",
    "keep_profile",
    "make_stamp",
    "outline_motion",
    "profile_cell",
]

PROFILE_CELLS = 64
LAST_PLACE = PROFILE_CELLS - 1e-4  # on the profile, in cells: within the last
_LEAST_WAY = 1e-9  # mm
_IN_PLACE = 0.35  # of the motion of a footprint that turns or grows where it stands: gives ink
# How much of what paper moves an edge by a footprint follows: docs/model.md, equation (20a)
_ROUGH_MM = 3.5  # all of it from this width on
_CALM = 0.52  # of a slow, wet brush
_HASTY, _HASTY_MM_S = 0.45, 180.0  # more up to this speed
_DRY, _WET_FROM, _DRY_TO = 0.5, 1.6, 0.6  # and more between these loads over that of skipping
_BELLY, _POINT = 1.25, 0.45  # times that at the heel of the footprint and at its tip
_FIRM = 0.4  # pressure from which a footprint that grows gives ink for all of its growth

_VECTOR = ("f8", (3,))

GEOMETRY = np.dtype(
    [
        # origin of the outline: P'_m, moved as the plane leans or it turns, mm
        ("origin", *_VECTOR),
        ("normal", *_VECTOR),  # of the plane: mean over the effective patch
        ("bend", *_VECTOR),  # direction of P'_m P_0 in the plane (azimuth alpha)
        ("cross", *_VECTOR),  # normal x bend
        ("heel", "f8"),  # signed reach of M_d along the bend, mm
        ("tip", "f8"),  # and of P_0
        ("widest", "f8"),  # largest half width, mm
        ("widest_at", "f8"),  # and its reach
        ("area", "f8"),  # mm2
        ("pressure", "f8"),  # pe of Eq. 2, 0 to 1
        ("descent", "f8"),  # D_s, mm
        ("tilt", "f8"),  # theta, rad
        ("sphere_centre", *_VECTOR),  # of the enclosing sphere, mm
        ("radius", "f8"),  # and its radius
        ("triangle", "f8"),  # base triangle under P'_m, -1 for none
        ("foot_normal", *_VECTOR),  # interpolated surface normal at P'_m
        ("touches", "f8"),  # 1 when the tuft leaves a footprint, else 0
        ("drag", *_VECTOR),  # dragged point relative to P'_m, mm; zero until the first contact
        ("foot", *_VECTOR),  # foot point P'_m, or the place that the hand means, mm
        ("way", "f8"),  # that the outline has gone since it came down, mm
        ("parted", "f8"),  # and where along the noise of the bundles it came down, mm
        ("twist", "f8"),  # angle by which a commanded tuft lags behind its azimuth, rad
        ("bent", "f8"),  # how far the tuft lies in its bend, from 0, in a heap under its root, to 1
        ("held", *_VECTOR),  # where the paper holds a dragged tuft's tip, mm
        ("aside", "f8"),  # angle at M_d from the bend to there, rad
        ("short", "f8"),  # and how much nearer to M_d than the footprint is long that is, mm
        ("heading", *_VECTOR),  # where the way leads, 0 until it does
        ("curve", "f8"),  # of the way to the left, over some mm, 1/mm
        ("time", "f8"),  # s, as its samples count it
        ("speed", "f8"),  # of the hand, mm/s
        ("haste", "f8"),  # lag of the ink behind it: see `dry_contact.note_way`
        ("centred", "f8"),  # 1 where the middle of the outline lies at that place, else 0
    ],
    align=True,
)
"""Where a stamp stands, and how large it is."""

SWEEP = np.dtype(
    [
        ("origin", "f8", 3),  # of the plane, that of one of the stamps, mm
        ("normal", "f8", 3),
        ("ahead", "f8", 3),  # its x axis, along the way
        ("aside", "f8", 3),  # its y axis
        ("sphere_centre", "f8", 3),  # of the sphere that encloses the brush, from the origin, mm
        ("radius2", "f8"),  # square of its radius, with what the outline moves
        ("to_before", "f8", 4),  # turn to the coordinates of the stamp before: x, y, cosine, sine
        ("to_after", "f8", 4),  # and to those of the stamp after
        ("scale", "f8"),  # widths of the soft edge to the mm
        ("first", "f8"),  # y of where the first band of lines along the way begins, mm
        ("per_mm", "f8"),  # bands to the mm
        ("carry2", "f8"),  # square of how far a vertex may be carried into the plane, mm2
        ("ball", "f8", 3),  # middle of the ball in which vertices are carried, from the origin, mm
        ("ball2", "f8"),  # square of its radius
        ("wet", "f8"),  # load over that below which the tuft begins to skip: `wetness`
        ("steady", "f8", 3),  # fraction of paper's shifts that outlines do not follow:
        # at the plane's origin, and how much less to the mm along its axes
    ],
    align=True,
)
"""Everything that the loops over vertices need of a sweep."""


class Stamp(NamedTuple):
    """A footprint on the surface, as arrays that kernels fill in place."""

    values: NDArray  # (1,) of GEOMETRY
    half_widths: NDArray  # (PROFILE_CELLS + 2,) float64, mm, even steps from heel to tip
    lines: NDArray  # (2, PROFILE_CELLS) float32: in each step half width = first + second x place
    # (place in steps from the heel)


def make_stamp() -> Stamp:
    """An empty stamp that touches nothing."""
    lines = np.zeros((2, PROFILE_CELLS), np.float32)
    return Stamp(np.zeros(1, GEOMETRY), np.zeros(PROFILE_CELLS + 2), lines)


@uncounted(forceinline=True)
def profile_cell(place):
    """The cell of a profile in which a place of it (up to LAST_PLACE, cells) lies.

    As an index of so few bits that compilers know it for none from an array's end, and look eight
    up at once.
    """
    return np.uint32(np.int32(place)) & np.uint32(PROFILE_CELLS - 1)


@uncounted
def fill_profile(stamp, reach, half_width, n):
    """Tabulate an outline (tip first, `n` points) over even steps from the heel to the tip."""
    values = stamp.values[0]
    heel = reach[n - 1]
    tip = reach[0]
    step = (tip - heel) / PROFILE_CELLS
    k = n - 1
    for i in range(PROFILE_CELLS + 1):
        x = heel + i * step
        while k > 1 and reach[k - 1] < x:
            k -= 1
        span = reach[k - 1] - reach[k]
        t = (x - reach[k]) / span if span > 0.0 else 0.0
        t = min(1.0, max(0.0, t))
        stamp.half_widths[i] = (1.0 - t) * half_width[k] + t * half_width[k - 1]
    stamp.half_widths[PROFILE_CELLS + 1] = 0.0
    keep_profile(stamp, heel, tip)
    widest = 0.0
    for i in range(n):
        if half_width[i] > widest:
            widest = half_width[i]
            values.widest_at = reach[i]
    values.widest = widest
    values.area = outline_area(reach, half_width, n)


@uncounted
def keep_profile(stamp, heel, tip):
    """Make the half widths that stand in a stamp its outline, from the heel to the tip (mm)."""
    values, widths = stamp.values[0], stamp.half_widths
    step = (tip - heel) / PROFILE_CELLS
    widths[0] = 0.0
    widths[PROFILE_CELLS] = 0.0
    values.heel, values.tip = heel, tip
    values.widest, values.area = 0.0, 0.0
    for i in range(PROFILE_CELLS):
        rise = widths[i + 1] - widths[i]
        stamp.lines[0, i] = widths[i] - i * rise
        stamp.lines[1, i] = rise
        values.area += (widths[i] + widths[i + 1]) * step
        if widths[i] > values.widest:
            values.widest, values.widest_at = widths[i], heel + i * step


@uncounted
def hold_point(values, along, across):
    """Enlarge a stamp's enclosing sphere to hold a point of its plane, by bend and cross, mm."""
    d2 = 0.0
    for axis in range(3):
        d = values.origin[axis] - values.sphere_centre[axis]
        d += along * values.bend[axis] + across * values.cross[axis]
        d2 += d * d
    values.radius = max(values.radius, np.sqrt(d2))


@uncounted
def outline_motion(a, b):
    """Distance that the fastest of the outline's points moved between two stamps (mm)."""
    fastest = 0.0
    for point in range(4):
        d2 = 0.0
        for axis in range(3):
            d = _outline_point(b, point, axis) - _outline_point(a, point, axis)
            d2 += d * d
        fastest = max(fastest, d2)
    return np.sqrt(fastest)


@uncounted(error_model="numpy")
def find_way(before, after):
    """Fraction of a footprint's motion that is its way, and whither it leads, by bend and cross.

    0 for one that turns, grows or comes down in its place, 1 for one that is only carried on.
    """
    a, b = before.values[0], after.values[0]
    if a.touches <= 0.0:
        return 0.0, 0.0, 0.0
    along = across = 0.0
    for axis in range(3):
        d = _middle(b, axis) - _middle(a, axis)
        along += d * b.bend[axis]
        across += d * b.cross[axis]
    carried = np.sqrt(along * along + across * across)
    if carried < _LEAST_WAY:
        return 0.0, 0.0, 0.0
    return min(1.0, carried / outline_motion(before, after)), along / carried, across / carried


@uncounted(error_model="numpy")
def _middle(values, axis):
    """Coordinate of the middle of an outline's length."""
    return values.origin[axis] + 0.5 * (values.heel + values.tip) * values.bend[axis]


@uncounted
def ink_way(a, b):
    """Way that ink is given for between two stamps (mm): `outline_motion` of what is carried on.

    One that grows or turns in its place lies on what is wet already, and gives less.
    Of a footprint that stands on a place that the hand means, what leaves the surface gives no ink:
    a tuft that is lifted where it stands draws no dot. Nor does one that comes down: growth counts
    the less, the lighter the touch, for it all begins in one point. Elsewhere the way is that of
    the outline.
    """
    if b.values[0].centred <= 0.0:
        return outline_motion(a, b) * (_IN_PLACE + (1.0 - _IN_PLACE) * find_way(a, b)[0])
    counts = min(1.0, b.values[0].pressure / _FIRM)
    half_b = 0.5 * (b.values[0].tip - b.values[0].heel)
    width_b = b.values[0].widest
    half_a = half_b - counts * max(0.0, half_b - 0.5 * (a.values[0].tip - a.values[0].heel))
    width_a = width_b - counts * max(0.0, width_b - a.values[0].widest)
    tip = heel = left = right = 0.0  # squares of the ways of the outline's four farthest points
    for axis in range(3):
        middle = b.values[0].foot[axis] - a.values[0].foot[axis]
        ends = half_b * b.values[0].bend[axis] - half_a * a.values[0].bend[axis]
        sides = width_b * b.values[0].cross[axis] - width_a * a.values[0].cross[axis]
        tip += (middle + ends) ** 2
        heel += (middle - ends) ** 2
        left += (middle + sides) ** 2
        right += (middle - sides) ** 2
    return np.sqrt(max(max(tip, heel), max(left, right)))


@uncounted
def _outline_point(stamp, point, axis):
    """Coordinate of the tip, the heel, or the middle's furthest extent to either side.

    Where the outline is widest is no use here: that jumps from one of its points to another.
    """
    values = stamp.values[0]
    if point == 0:
        along, across = values.tip, 0.0
    elif point == 1:
        along, across = values.heel, 0.0
    elif point == 2:
        along, across = 0.5 * (values.heel + values.tip), values.widest
    else:
        along, across = 0.5 * (values.heel + values.tip), -values.widest
    origin = values.origin[axis]
    return origin + along * values.bend[axis] + across * values.cross[axis]


@uncounted(error_model="numpy")
def fill_sweep(before, after, plane, scale, sweep):
    """Gather the numbers of a sweep from its stamps, but for its lines.

    Parameters
    ----------
    before, after : Stamp
        Where the way begins and ends, one of them perhaps without touching.
    plane : record of GEOMETRY
        That of the stamp in whose plane it lies.
    scale : float
        Widths of the soft edge to the mm.
    sweep : record of SWEEP
        Filled.
    """
    carried, along, across = 0.0, 1.0, 0.0
    if after.values[0].touches > 0.0:
        carried, along, across = find_way(before, after)
    if carried <= 0.0:
        along, across = 1.0, 0.0
    for k in range(3):
        sweep.origin[k] = plane.origin[k]
        sweep.normal[k] = plane.normal[k]
        sweep.ahead[k] = along * plane.bend[k] + across * plane.cross[k]
        sweep.aside[k] = along * plane.cross[k] - across * plane.bend[k]
        sweep.sphere_centre[k] = plane.sphere_centre[k] - plane.origin[k]
    # the sphere is that of one stamp: the other's outline sticks out by what it moved
    sticks_out = 0.5 / scale + outline_motion(before, after)
    sweep.radius2 = (plane.radius + sticks_out) ** 2
    sweep.carry2 = np.inf
    if plane.centred > 0.0:
        half = max(_half_extent(before.values[0]), _half_extent(after.values[0]))
        sweep.carry2 = (half + sticks_out) ** 2
    _fill_ball(before, after, plane, scale, sweep)
    sweep.scale = scale
    last, first = after.values[0], before.values[0]
    _fill_turn(first, sweep, sweep.to_before)
    _fill_turn(last, sweep, sweep.to_after)
    _fill_steady(last if last.touches > 0.0 else first, along, across, sweep)


@uncounted(error_model="numpy")
def _fill_turn(values, sweep, turn):
    """The turn (x, y, c, s) from the plane's coordinates to those of a stamp, which may lean.

    x' = c (x - ox) + s (y - oy), y' = -s (x - ox) + c (y - oy).
    """
    ox = oy = c = s = 0.0
    for k in range(3):
        d = values.origin[k] - sweep.origin[k]
        ox += d * sweep.ahead[k]
        oy += d * sweep.aside[k]
        c += values.bend[k] * sweep.ahead[k]
        s += values.bend[k] * sweep.aside[k]
    norm = np.sqrt(c * c + s * s)
    turn[0], turn[1] = ox, oy
    turn[2], turn[3] = (c / norm, s / norm) if norm > 1e-9 else (1.0, 0.0)


@uncounted(error_model="numpy")
def _fill_steady(values, along, across, sweep):
    """Fill the part of paper's unevenness that the edge of a footprint does not follow.

    A thin line brings little ink for fibres to draw on, and ink that has time and is plenty runs
    together to a smooth edge. The point of the tuft draws a cleaner one than its belly.
    """
    broad = min(1.0, 2.0 * values.widest / _ROUGH_MM)
    follows = _CALM + _HASTY * min(1.0, values.speed / _HASTY_MM_S)
    wet = (sweep.wet - _DRY_TO) / (_WET_FROM - _DRY_TO)
    follows += _DRY * (1.0 - min(1.0, max(0.0, wet)))
    follows = min(1.0, follows) * broad * np.sqrt(broad)
    rise = (_POINT - _BELLY) * follows / max(values.tip - values.heel, 1e-6)
    sweep.steady[0] = 1.0 - (_BELLY * follows - rise * values.heel)
    sweep.steady[1] = rise * along
    sweep.steady[2] = -rise * across


@uncounted(error_model="numpy")
def _fill_ball(before, after, plane, scale, sweep):
    """The ball that what is painted lies in, around places that the hand means.

    Surface that bends away unfolds into the plane, which carries it farther from the place. What is
    carried nearer looks another way than it should from there: the far side of a groove, a fillet
    beyond a crease. Its middle, `ball`, is counted from the plane's origin.
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
    """Distance of an outline's farthest point from the point that the hand means, mm."""
    values = stamp.values[0]
    if values.touches <= 0.0:
        return 0.0
    x, y = 0.0, 0.0  # where the outline is counted from
    for k in range(3):
        d = values.origin[k] - values.foot[k]
        x += d * values.bend[k]
        y += d * values.cross[k]
    x, y = x + values.heel, abs(y)
    step = (values.tip - values.heel) / PROFILE_CELLS
    farthest2 = 0.0
    for i in range(PROFILE_CELLS + 1):
        side = y + stamp.half_widths[i]
        farthest2 = max(farthest2, (x + i * step) ** 2 + side * side)
    return np.sqrt(farthest2)


@uncounted(error_model="numpy")
def _half_extent(values):
    """Half the longer side of a footprint, mm; 0 where there is none."""
    if values.touches <= 0.0:
        return 0.0
    return max(0.5 * (values.tip - values.heel), values.widest)

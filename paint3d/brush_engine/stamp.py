"""One footprint standing on the surface: the stamp that a stroke sweeps along.

A stamp is a plane (through the foot point P'_m, with the mean normal of the effective patch), the
direction of the bend in it, and the footprint's half width tabulated over its length, so that
"is this point under the brush" costs one table look-up. Guo 2017, Eqs. 4, 6-11 and Fig. 7.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.kernel import uncounted

__all__ = [
    "GEOMETRY",
    "PROFILE_CELLS",
    "Stamp",
    "fill_profile",
    "hold_point",
    "ink_way",
    "make_stamp",
    "outline_motion",
]

PROFILE_CELLS = 64
_FIRM = 0.4  # pressure from which a footprint that grows gives ink for all of its growth

_VECTOR = ("f8", (3,))

GEOMETRY = np.dtype(
    [
        (
            "origin",
            *_VECTOR,
        ),  # where the outline is counted from: P'_m, moved as the plane leans, mm
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
        ("centred", "f8"),  # 1 where the middle of the outline lies at that place, else 0
    ],
    align=True,
)
"""Where a stamp stands, and how large it is."""


class Stamp(NamedTuple):
    """A footprint on the surface, as arrays that kernels fill in place."""

    values: NDArray  # (1,) of GEOMETRY
    half_widths: NDArray  # (PROFILE_CELLS + 2,) float64, mm, even steps from heel to tip
    lines: NDArray  # (PROFILE_CELLS, 4) float32: in each step half width = first + second x place
    # (place in steps from the heel), and third = 1/sqrt(1 + slope^2), for distances to the edge;
    # the fourth only keeps rows from lying across two lines of the cache


def make_stamp() -> Stamp:
    """An empty stamp that touches nothing."""
    lines = np.zeros((PROFILE_CELLS, 4), np.float32)
    return Stamp(np.zeros(1, GEOMETRY), np.zeros(PROFILE_CELLS + 2), lines)


@uncounted
def fill_profile(stamp, reach, half_width, n):
    """Tabulate an outline (tip first, `n` points) over even steps from the heel to the tip."""
    values = stamp.values[0]
    heel = reach[n - 1]
    tip = reach[0]
    step = (tip - heel) / PROFILE_CELLS
    widest = 0.0
    k = n - 1
    area = 0.0
    for i in range(PROFILE_CELLS + 1):
        x = heel + i * step
        while k > 1 and reach[k - 1] < x:
            k -= 1
        span = reach[k - 1] - reach[k]
        t = (x - reach[k]) / span if span > 0.0 else 0.0
        t = min(1.0, max(0.0, t))
        stamp.half_widths[i] = (1.0 - t) * half_width[k] + t * half_width[k - 1]
    stamp.half_widths[0] = 0.0
    stamp.half_widths[PROFILE_CELLS] = 0.0
    stamp.half_widths[PROFILE_CELLS + 1] = 0.0
    for i in range(PROFILE_CELLS):
        rise = stamp.half_widths[i + 1] - stamp.half_widths[i]
        slope = rise / step if step > 0.0 else 0.0
        stamp.lines[i, 0] = stamp.half_widths[i] - i * rise
        stamp.lines[i, 1] = rise
        stamp.lines[i, 2] = 1.0 / np.sqrt(1.0 + slope * slope)
    for i in range(n):
        if half_width[i] > widest:
            widest = half_width[i]
            values.widest_at = reach[i]
    for i in range(n - 1):
        area += (half_width[i] + half_width[i + 1]) * (reach[i] - reach[i + 1])
    values.heel = heel
    values.tip = tip
    values.widest = widest
    values.area = area


@uncounted
def hold_point(values, along, across):
    """Let the stamp's enclosing sphere hold a point of its plane, `along` and `across` the bend."""
    d2 = 0.0
    for axis in range(3):
        d = values.origin[axis] - values.sphere_centre[axis]
        d += along * values.bend[axis] + across * values.cross[axis]
        d2 += d * d
    values.radius = max(values.radius, np.sqrt(d2))


@uncounted
def outline_motion(a, b):
    """How far the fastest of the outline's points moved between two stamps (mm)."""
    fastest = 0.0
    for point in range(4):
        d2 = 0.0
        for axis in range(3):
            d = _outline_point(b, point, axis) - _outline_point(a, point, axis)
            d2 += d * d
        fastest = max(fastest, d2)
    return np.sqrt(fastest)


@uncounted
def ink_way(a, b):
    """The way that ink is given for between two stamps (mm): `outline_motion` where it advances.

    Of a footprint that stands on a place that the hand means, what leaves the surface gives no ink:
    a tuft that is lifted where it stands draws no dot. Nor does one that comes down: growth counts
    the less, the lighter the touch, for it all begins in one point. Elsewhere the way is that of
    the outline.
    """
    if b.values[0].centred <= 0.0:
        return outline_motion(a, b)
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

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
    "AREA",
    "BEND_X",
    "BEND_Y",
    "BEND_Z",
    "CENTRED",
    "CROSS_X",
    "DESCENT",
    "DRAG_X",
    "FOOT_NORMAL_X",
    "FOOT_X",
    "HEEL",
    "NORMAL_X",
    "N_VALUES",
    "ORIGIN_X",
    "PRESSURE",
    "PROFILE_CELLS",
    "RADIUS",
    "REACH_OF_WIDEST",
    "SPHERE_X",
    "TILT",
    "TIP",
    "TOUCHES",
    "TRIANGLE",
    "WIDEST",
    "Stamp",
    "fill_profile",
    "hold_point",
    "ink_way",
    "make_stamp",
    "outline_motion",
]

PROFILE_CELLS = 64
_FIRM = 0.4  # pressure from which a footprint that grows gives ink for all of its growth

# Where each value lies in Stamp.values.
ORIGIN_X = 0  # 0-2 where the outline is counted from: P'_m, moved as the plane leans, mm
NORMAL_X = 3  # 3-5 normal of the plane: mean over the effective patch
BEND_X, BEND_Y, BEND_Z = 6, 7, 8  # direction of P'_m P_0 in the plane (azimuth alpha)
CROSS_X = 9  # 9-11 normal x bend
HEEL, TIP = 12, 13  # signed reach of M_d and P_0 along the bend, mm
WIDEST, REACH_OF_WIDEST = 14, 15  # largest half width and where, mm
AREA = 16  # mm2
PRESSURE = 17  # pe of Eq. 2, 0 to 1
DESCENT, TILT = 18, 19  # D_s mm, theta rad
SPHERE_X = 20  # 20-22 centre of the enclosing sphere, mm
RADIUS = 23  # of the enclosing sphere, mm
TRIANGLE = 24  # base triangle under P'_m
FOOT_NORMAL_X = 25  # 25-27 interpolated surface normal at P'_m
TOUCHES = 28  # 1.0 when the tuft leaves a footprint
DRAG_X = 29  # 29-31 dragged point relative to P'_m, mm; zero until the first contact
FOOT_X = 32  # 32-34 foot point P'_m, or the place that the hand means, mm
CENTRED = 35  # 1.0 where the middle of the outline lies at that place
N_VALUES = 36


class Stamp(NamedTuple):
    """A footprint on the surface, as arrays that kernels fill in place."""

    values: NDArray  # (N_VALUES,) float64
    half_widths: NDArray  # (PROFILE_CELLS + 2,) float64, mm, even steps from heel to tip
    lines: NDArray  # (PROFILE_CELLS, 4) float32: in each step half width = first + second x place
    # (place in steps from the heel), and third = 1/sqrt(1 + slope^2), for distances to the edge;
    # the fourth only keeps rows from lying across two lines of the cache


def make_stamp() -> Stamp:
    """An empty stamp that touches nothing."""
    lines = np.zeros((PROFILE_CELLS, 4), np.float32)
    return Stamp(np.zeros(N_VALUES), np.zeros(PROFILE_CELLS + 2), lines)


@uncounted
def fill_profile(stamp, reach, half_width, n):
    """Tabulate an outline (tip first, `n` points) over even steps from the heel to the tip."""
    values = stamp.values
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
            values[REACH_OF_WIDEST] = reach[i]
    for i in range(n - 1):
        area += (half_width[i] + half_width[i + 1]) * (reach[i] - reach[i + 1])
    values[HEEL] = heel
    values[TIP] = tip
    values[WIDEST] = widest
    values[AREA] = area


@uncounted
def hold_point(values, along, across):
    """Let the stamp's enclosing sphere hold a point of its plane, `along` and `across` the bend."""
    d2 = 0.0
    for axis in range(3):
        d = values[ORIGIN_X + axis] - values[SPHERE_X + axis]
        d += along * values[BEND_X + axis] + across * values[CROSS_X + axis]
        d2 += d * d
    values[RADIUS] = max(values[RADIUS], np.sqrt(d2))


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
    if b.values[CENTRED] <= 0.0:
        return outline_motion(a, b)
    counts = min(1.0, b.values[PRESSURE] / _FIRM)
    half_b = 0.5 * (b.values[TIP] - b.values[HEEL])
    width_b = b.values[WIDEST]
    half_a = half_b - counts * max(0.0, half_b - 0.5 * (a.values[TIP] - a.values[HEEL]))
    width_a = width_b - counts * max(0.0, width_b - a.values[WIDEST])
    tip = heel = left = right = 0.0  # squares of the ways of the outline's four farthest points
    for axis in range(3):
        middle = b.values[FOOT_X + axis] - a.values[FOOT_X + axis]
        ends = half_b * b.values[BEND_X + axis] - half_a * a.values[BEND_X + axis]
        sides = width_b * b.values[CROSS_X + axis] - width_a * a.values[CROSS_X + axis]
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
    values = stamp.values
    if point == 0:
        along, across = values[TIP], 0.0
    elif point == 1:
        along, across = values[HEEL], 0.0
    elif point == 2:
        along, across = 0.5 * (values[HEEL] + values[TIP]), values[WIDEST]
    else:
        along, across = 0.5 * (values[HEEL] + values[TIP]), -values[WIDEST]
    origin = values[ORIGIN_X + axis]
    return origin + along * values[BEND_X + axis] + across * values[CROSS_X + axis]

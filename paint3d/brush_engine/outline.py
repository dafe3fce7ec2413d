"""The outline of a tuft's footprint: traced, its tip rounded by the ink, gathered into a heap.

It lies in the plane and the frame of `brush_engine.tuft`: half widths |W_j M_j| against the reach,
the signed distance from P'_m along the bend, from the tip P_0 down to M_d, the heel, where the
tuft leaves the plane. It has as many points for every press, at fixed fractions of the arc between
tip and heel: so each of them is a smooth function of the press, and a lift-off draws no steps
(Guo 2017, Eqs. 2, 3, 6-9).

`trace_outline` gives what the bent tuft covers. `placement` makes of it what is painted, by
`round_tip` and `gather_outline`, and `footprint.fill_profile` tabulates that in a stamp.
"""

from __future__ import annotations

import math

import numpy as np

from paint3d.brush_engine.tuft import (
    STATIONS,
    blend_rows,
    cubic_weights,
    greatest_descent,
    interpolate,
    locate,
)
from paint3d.core.kernel import uncounted

__all__ = [
    "OUTLINE_CAPACITY",
    "SCRATCH_SIZE",
    "gather_outline",
    "outline_area",
    "round_tip",
    "trace_outline",
]

OUTLINE_CAPACITY = 64  # what out_reach and out_half_width must hold: any outline's points
SCRATCH_SIZE = 2 * STATIONS  # float64 numbers: openness and reach at the stations
_POINTS = 40  # of a solid tuft's outline
_FALLING = 1e-9  # of the length, least step between two of them
_HEEL_STEPS = 12
_MENISCUS = 0.4  # of the greatest half width: radius to which ink rounds the tip, by eye
_FIRST_COLUMN = 6  # of the tables, that has arcs enough under the lightest touch

# Where the outline's points lie between tip and heel, in stations; crowded towards the heel, where
# the width falls like a root.
_EVEN = np.linspace(0.0, 1.0, _POINTS)
_FRACTIONS = 0.35 * _EVEN + 0.65 * np.sin(0.5 * np.pi * _EVEN)
_FRACTIONS.setflags(write=False)


@uncounted
def trace_outline(tuft, descent, tilt, pe, scratch, out_reach, out_half_width):
    """Outline of the footprint: its half width against the distance from P'_m (Eqs. 2, 3, 6-9).

    With S = 1 + (d + h mu) pe, a section is C_j1 = S C_j wide and C_j2 = C_j / S thick (Eqs. 2, 3),
    so that Eq. 8 reads |W_j M_j| = S C_j / 2 sqrt(1 - (S g)^2).

    Parameters
    ----------
    tuft : Tuft
    descent, tilt : float
        D_s (mm) and theta (rad) of the holder.
    pe : float
        Force over the greatest force, which spreads the hairs (Eq. 2).
    scratch : (SCRATCH_SIZE,) float64
        Overwritten.
    out_reach : (OUTLINE_CAPACITY,) float64
        Signed distance from P'_m along the bend direction, mm, from the tip P_0 strictly down to
        M_d, where the tuft leaves the plane.
    out_half_width : (OUTLINE_CAPACITY,) float64
        |W_j M_j|, mm; zero at both ends.

    Returns
    -------
    n : int
        How many points were written; 0 where nothing touches.
    """
    if descent <= 0.0:
        return 0
    touch = _FIRST_COLUMN / (tuft.reach.shape[1] - 1.0)
    touch = touch * touch * greatest_descent(tuft, tilt)
    at = locate(tuft, max(descent, touch), tilt)
    n = _trace_at(tuft, at, 1.0 + tuft.spread * pe, scratch, out_reach, out_half_width)
    if descent < touch:  # the same, smaller
        scale, straight = descent / touch, tuft.length * math.cos(tilt)
        for k in range(n):
            out_reach[k] = straight + scale * (out_reach[k] - straight)
            out_half_width[k] *= scale
    return n


@uncounted
def _trace_at(tuft, at, spread, scratch, out_reach, out_half_width):
    """`trace_outline` at a place of the tables."""
    openness, reach = scratch[:STATIONS], scratch[STATIONS : 2 * STATIONS]
    blend_rows(tuft.openness, at, STATIONS, openness)
    heel = _find_heel(openness, 1.0 / (1.0 + spread))
    if heel <= 0.0:
        return 0
    blend_rows(tuft.reach, at, min(int(heel) + 3, STATIONS), reach)
    n = 0
    least = _FALLING * tuft.length
    for k in range(_POINTS):
        place = heel * _FRACTIONS[k]
        j = min(int(place), STATIONS - 2)
        weights = cubic_weights(place - j)
        x = tuft.length * interpolate(reach, j - 1, weights)
        if n > 0 and x > out_reach[n - 1] - least:
            continue
        fraction = max(interpolate(openness, j - 1, weights), 0.0)
        height = spread * fraction / (1.0 - fraction)
        half = 0.5 * spread * max(interpolate(tuft.diameters, j - 1, weights), 0.0)
        out_reach[n] = x
        out_half_width[n] = half * math.sqrt(max(1.0 - height * height, 0.0))
        n += 1
    if n < 3:
        return 0
    out_half_width[0] = 0.0
    out_half_width[n - 1] = 0.0
    return n


@uncounted
def _find_heel(openness, level):
    """Find, in stations, the first root of openness - level; 0 where it begins above it."""
    n = openness.shape[0]
    k = 0
    while k < n and openness[k] < level:
        k += 1
    if k == 0 or k == n:
        return float(max(k - 1, 0))
    low, high = 0.0, 1.0
    f_low, f_high = openness[k - 1] - level, openness[k] - level
    side, t = 0, 0.0
    for _ in range(_HEEL_STEPS):  # the Illinois variant of regula falsi
        t = low + (high - low) * f_low / (f_low - f_high)
        f = interpolate(openness, k - 2, cubic_weights(t)) - level
        if abs(f) < 1e-13:
            break
        if f < 0.0:
            low, f_low = t, f
            f_high *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            high, f_high = t, f
            f_low *= 0.5 if side < 0 else 1.0
            side = -1
    return k - 1 + t


@uncounted
def round_tip(reach, half_width, n):
    """Round an outline's tip as the ink's meniscus does: docs/model.md, equation (2a).

    A disc that ends where the tip does, and what lies between it and the flanks, belong to it.

    Parameters
    ----------
    reach, half_width : arrays as for `trace_outline`
        Changed; the first `n` of them.
    n : int
    """
    widest = 0
    for k in range(n):
        if half_width[k] > half_width[widest]:
            widest = k
    radius = _MENISCUS * half_width[widest]
    centre = reach[0] - radius
    angle, last = 0.5 * math.pi, 0  # where a line from the flank's point `last` touches the disc
    for k in range(1, widest + 1):
        x, y = reach[k] - centre, half_width[k]
        distance = math.hypot(x, y)
        if distance > radius:
            touches = math.atan2(y, x) - math.acos(radius / distance)
            if touches < angle:
                angle, last = touches, k
    for k in range(1, last):
        part = angle * k / (last - 1)
        reach[k] = centre + radius * math.cos(part)
        half_width[k] = radius * math.sin(part)


@uncounted
def gather_outline(bent, straight, reach, half_width, n):
    """Gather the outline of a tuft that is not bent in a heap: docs/model.md, equation (4).

    Where the dragged point is the root's foot there is no direction to lie in: the outline is a
    disc of the same area, and grows into the bent one as the paper pulls the tip away.

    Parameters
    ----------
    bent : float
        How far the tuft lies in its bend, 0 to 1.
    straight : float
        Where the straight tip would be, along the bend, mm.
    reach, half_width : arrays as for `trace_outline`
        Changed.
    n : int
        Points of the outline.
    """
    tip, heel = reach[0], reach[n - 1]
    area = outline_area(reach, half_width, n)
    if bent >= 1.0 or area <= 0.0:
        return
    disc = math.sqrt(area / math.pi)
    middle, half = 0.5 * (tip + heel), 0.5 * (tip - heel)
    centre = bent * middle + (1.0 - bent) * straight
    for i in range(n):
        fraction = min(1.0, max(-1.0, (reach[i] - middle) / half))
        reach[i] = (bent * half + (1.0 - bent) * disc) * fraction
        round_ = disc * math.sqrt(1.0 - fraction * fraction)
        half_width[i] = bent * half_width[i] + (1.0 - bent) * round_
    half_width[0], half_width[n - 1] = 0.0, 0.0
    scale = math.sqrt(area / outline_area(reach, half_width, n))
    for i in range(n):
        reach[i] = centre + scale * reach[i]
        half_width[i] *= scale


@uncounted
def outline_area(reach, half_width, n):
    """Area (mm2) of an outline of n points, the tip first."""
    area = 0.0
    for i in range(n - 1):
        area += (half_width[i] + half_width[i + 1]) * (reach[i] - reach[i + 1])
    return area

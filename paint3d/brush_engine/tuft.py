"""The bent tuft: its outline on the plane, its spine, the sphere around it, and its drag.

All of it lies in the bend plane. Its origin is P'_m, the root's foot on the paper; `along` points
from there to the tip, `up` is the paper's normal, `side` is normal to both. The third angle, the
azimuth of `along` on the paper, is the pose's, or the paper turns the brush as it drags the tuft.

A shape is read from tables over tilt and descent at `STATIONS` places along the spine, by cubics
over the descent and linearly over the tilt. The outline has as many points for every press, at
fixed shares of the arc between the tip and the heel, where the tuft leaves the plane: so each of
them is a smooth function of the press, and a lift-off draws no steps (Guo 2017, Eqs. 2, 3, 6-9).

The dragged tuft is a tractrix with slack: with H the handle's foot P'_m and Q the dragged contact,
r = Q - H. While |r| is below the slack l(D_s) the contact sticks; beyond, it follows at the
distance l. The bend direction is that of r. The law knows no time, only the path (closed form of
the discrete rule published with Wang et al., "Robot Calligraphy using Pseudospectral Optimal
Control in Conjunction with a Novel Dynamic Brush Model", IROS 2020, whose measured brush gives l).

A press lengthens a footprint, about as fast as a hand goes on meanwhile. Counted from H alone, the
tip would slide back and aside over the paper on which it lies. But hairs are trailed and not
pushed: the tip of a dragged tuft stays where it is until the heel, where the tuft leaves the paper,
pulls it on. While it slides, the tuft's spring brings it back into its bend.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.footprint import outline_area
from paint3d.core.kernel import uncounted

__all__ = [
    "CURVATURE",
    "INK_LEFT",
    "LOAD",
    "MOST_POINTS",
    "N_INPUTS",
    "N_SETTINGS",
    "OUTLINE_CAPACITY",
    "PRESSURE",
    "RING_STATIONS",
    "SCRATCH_SIZE",
    "SPEED",
    "SPHERE_SPREADS",
    "SPHERE_STEPS",
    "SPREAD",
    "STATIONS",
    "STIFFNESS",
    "TILT",
    "WETNESS",
    "Curves",
    "Tuft",
    "bent_by_twist",
    "drag_along",
    "drag_length",
    "drag_step",
    "drag_way",
    "enclose_tuft",
    "gather_outline",
    "greatest_descent",
    "hold_along",
    "lie_held",
    "no_curves",
    "release",
    "round_diameter",
    "round_tip",
    "smooth_step",
    "trace_outline",
    "trace_spine",
    "trail_step",
    "twist_step",
]

STATIONS = 57  # places along the spine at which shapes are kept, crowded towards the tip
RING_STATIONS = (0, 15, 21, 28, 33, 38, 43, 47, 51, 56)  # those that the sphere is put around
SPHERE_STEPS = 8  # every so many descents have their spheres, and every second tilt
_SPREAD_STEP = 0.25
_SPHERE_MARGIN = 1.003  # times the radius: a tuft between its table's shapes is not their mean
SPHERE_SPREADS = tuple(1.0 + _SPREAD_STEP * k for k in range(11))  # of sections, with their spheres
OUTLINE_CAPACITY = 64  # what out_reach and out_half_width must hold: any outline's points
_POINTS = 40  # of a solid tuft's outline
_FALLING = 1e-9  # of the length, least step between two of them
_HEEL_STEPS = 12
_MENISCUS = 0.4  # of the greatest half width: radius to which ink rounds the tip, by eye
_FIRST_COLUMN = 6  # of the tables, that has arcs enough under the lightest touch
SCRATCH_SIZE = 2 * STATIONS  # float64 numbers: openness and reach at the stations

# Where the outline's points lie between tip and heel, in stations; crowded towards the heel, where
# the width falls like a root.
_EVEN = np.linspace(0.0, 1.0, _POINTS)
_SHARES = 0.35 * _EVEN + 0.65 * np.sin(0.5 * np.pi * _EVEN)
_SHARES.setflags(write=False)
MOST_POINTS = 8  # of a curve
# Rows of the table: settings, and inputs of each; their names are in `brush.spec`.
STIFFNESS, SPREAD, LOAD, WETNESS = 0, 1, 2, 3
N_SETTINGS = 4
PRESSURE, TILT, SPEED, INK_LEFT, CURVATURE = 0, 1, 2, 3, 4
N_INPUTS = 5
MEASURED_LENGTH = 30.0  # mm, the tuft on which `drag_length` was measured
_UNTWISTS = 0.12  # of the slack: over this way a tuft comes round to its azimuth
_TWISTED = (0.4, 1.4)  # rad that it lags behind: from lying in its bend to lying in a heap
_SAME_SLACK = 0.05  # of a slack: a step on which it changes by more is cut
_MOST_SLACKS = 20
_HOLDS = 3.0  # mm of way to the mm of press, up to which the paper holds the tip fast
_SLACK = 0.2  # of the footprint's length: as slack a tip that was held stays where it is
_PULLS = 2.0  # to the mm of way that a heel goes away from a slack tip, from which on this stays
_SPRINGS = 0.5  # of the footprint's length: over this way a sliding tip comes back into its bend
_TOLD = 0.5  # of the length: a tip nearer to its heel tells less of how a footprint lies
_NOWHERE = 1e-9  # mm: a tip under its heel lies in no direction


class Tuft(NamedTuple):
    """A brush made ready for kernels: plain numbers and arrays (N = `STATIONS`).

    Built by `paint3d.brush.bending.build_tuft`; one argument of every kernel here. Tables lie over
    tilt (even in the angle, the last row is pi / 2) and descent (even in its square root).
    """

    arcs: NDArray  # (N,) float64, of the stations from the tip, mm
    diameters: NDArray  # (N,) float64, round, there, mm
    spine: NDArray  # (tilts, descents, 3, N) float32: along and up over the length, angle (rad)
    reach: NDArray  # (tilts, descents, N) float32: along - up tan(angle), over the length (Eq. 7)
    openness: NDArray  # (tilts, descents, N) float32: g / (1 + g), where g = 2 z / (cos beta C) is
    # how high a section is over its round diameter, so that Eq. 8 ends the footprint at g = 1 / S
    spheres: NDArray  # (tilts, descents, spreads, 3) float64: centre and radius over the length
    taper: float  # exponent of the diameter over the arc length
    point: float  # mm, length of the pointed tip
    lowest_tilt: float  # rad, first row of the tables; the last row is pi / 2
    greatest_fraction: float  # last column of the tables: descent / (length sin tilt)
    length: float  # LE, mm
    full_press: float  # descent at pe = 1, mm
    spring: float  # lambda_c S, N/mm (Eq. 4)
    max_force: float  # force at pe = 1, N
    spread: float  # d + h mu: relative growth of the major diameter at pe = 1 (Eq. 2)
    load: float  # ink held when full, coat mm2
    transfer_per_mm: float  # eta' of the continuous Eq. 13, 1/mm
    drag_fraction: float  # c of the dragged mode
    plasticity: float  # rho: share of the bend kept when the pen lifts


class Curves(NamedTuple):
    """Curves of a brush as plain arrays."""

    any: NDArray  # (1,) int64: how many there are
    counts: NDArray  # (N_SETTINGS, N_INPUTS) int64: points of each, 0 for none
    points: NDArray  # (N_SETTINGS, N_INPUTS, MOST_POINTS, 2) float64: input and factor
    inputs: NDArray  # (N_INPUTS,) float64 scratch


def no_curves() -> Curves:
    """Curves of a brush that is always the same."""
    return Curves(
        np.zeros(1, np.int64),
        np.zeros((N_SETTINGS, N_INPUTS), np.int64),
        np.zeros((N_SETTINGS, N_INPUTS, MOST_POINTS, 2)),
        np.zeros(N_INPUTS),
    )


@uncounted
def greatest_descent(tuft, tilt):
    """Descent (mm) at which the table ends: lower, and the ferrule itself would touch."""
    return tuft.greatest_fraction * tuft.length * math.sin(tilt)


@uncounted
def round_diameter(tuft, arc):
    """Diameter (mm) of the round tuft so far from its tip (mm): docs/model.md, equation (1)."""
    diameter = tuft.diameters[-1] * (arc / tuft.length) ** tuft.taper
    if tuft.point > 0.0 and arc > 0.0:
        diameter *= (-math.expm1(-arc / tuft.point)) ** (1.0 - tuft.taper)
    return diameter


@uncounted
def _cubic(t):
    """Weights of four even points for a place between the middle two (Catmull-Rom)."""
    return (
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    )


class _Place(NamedTuple):
    """Where in the tables a pressed tuft is read: two rows, four columns of each, their weights."""

    row: int
    column: int  # first of the four
    share: float  # of the second row
    a: float
    b: float
    c: float
    d: float


@uncounted
def _find_place(tuft, descent, tilt):
    """The place of a descent (mm) and a tilt (rad); outside the tables their ends hold."""
    n_tilts, n_columns, _ = tuft.reach.shape
    row = (tilt - tuft.lowest_tilt) * (n_tilts - 1) / (0.5 * math.pi - tuft.lowest_tilt)
    row = min(max(row, 0.0), n_tilts - 1.0)
    i = min(int(row), n_tilts - 2)
    column = math.sqrt(max(descent, 0.0) / greatest_descent(tuft, tilt))
    column = min(column, 1.0) * (n_columns - 1)
    k = min(int(column), n_columns - 2)
    before, here, after, beyond = _cubic(column - k)
    if k == 0:  # shapes are even functions of the root of the descent
        return _Place(i, 0, row - i, here, before + after, beyond, 0.0)
    if k == n_columns - 2:  # and go on straight where the table ends
        return _Place(i, k - 2, row - i, 0.0, before, here - beyond, after + 2.0 * beyond)
    return _Place(i, k - 1, row - i, before, here, after, beyond)


@uncounted
def _blend(table, at, n, out):
    """The first n numbers of a table's (tilts, descents, N) rows at a place."""
    low, high = 1.0 - at.share, at.share
    below, above = table[at.row], table[at.row + 1]
    k = at.column
    a0, b0, c0, d0 = below[k], below[k + 1], below[k + 2], below[k + 3]
    a1, b1, c1, d1 = above[k], above[k + 1], above[k + 2], above[k + 3]
    for j in range(n):
        lower = at.a * a0[j] + at.b * b0[j] + at.c * c0[j] + at.d * d0[j]
        upper = at.a * a1[j] + at.b * b1[j] + at.c * c1[j] + at.d * d1[j]
        out[j] = low * lower + high * upper


@uncounted
def _between(values, first, weights):
    """The cubic through four values."""
    a, b, c, d = weights
    high = values.shape[0] - 1
    return (
        a * values[max(first, 0)]
        + b * values[first + 1]
        + c * values[first + 2]
        + d * values[min(first + 3, high)]
    )


@uncounted
def _find_heel(openness, level):
    """Where, in stations, the openness first comes up to a level; 0 where it begins above it."""
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
        f = _between(openness, k - 2, _cubic(t)) - level
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
    at = _find_place(tuft, max(descent, touch), tilt)
    n = _trace_at(tuft, at, 1.0 + tuft.spread * pe, scratch, out_reach, out_half_width)
    if descent < touch:  # the same, smaller
        scale, straight = descent / touch, tuft.length * math.cos(tilt)
        for k in range(n):
            out_reach[k] = straight + scale * (out_reach[k] - straight)
            out_half_width[k] *= scale
    return n


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
def _trace_at(tuft, at, spread, scratch, out_reach, out_half_width):
    """`trace_outline` at a place of the tables."""
    openness, reach = scratch[:STATIONS], scratch[STATIONS : 2 * STATIONS]
    _blend(tuft.openness, at, STATIONS, openness)
    heel = _find_heel(openness, 1.0 / (1.0 + spread))
    if heel <= 0.0:
        return 0
    _blend(tuft.reach, at, min(int(heel) + 3, STATIONS), reach)
    n = 0
    least = _FALLING * tuft.length
    for k in range(_POINTS):
        place = heel * _SHARES[k]
        j = min(int(place), STATIONS - 2)
        weights = _cubic(place - j)
        x = tuft.length * _between(reach, j - 1, weights)
        if n > 0 and x > out_reach[n - 1] - least:
            continue
        share = max(_between(openness, j - 1, weights), 0.0)
        height = spread * share / (1.0 - share)
        half = 0.5 * spread * max(_between(tuft.diameters, j - 1, weights), 0.0)
        out_reach[n] = x
        out_half_width[n] = half * math.sqrt(max(1.0 - height * height, 0.0))
        n += 1
    if n < 3:
        return 0
    out_half_width[0] = 0.0
    out_half_width[n - 1] = 0.0
    return n


@uncounted
def trace_spine(tuft, descent, tilt, out):
    """The bent spine at the stations: along (mm, from P'_m), up (mm) and the section's angle (rad).

    Parameters
    ----------
    tuft : Tuft
    descent, tilt : float
        D_s (mm) and theta (rad) of the holder.
    out : (3, STATIONS) float64
    """
    at = _find_place(tuft, descent, tilt)
    for part in range(3):
        _blend(tuft.spine[:, :, part], at, STATIONS, out[part])
    for j in range(STATIONS):
        out[0, j] *= tuft.length
        out[1, j] = max(tuft.length * out[1, j], 0.0)


@uncounted
def enclose_tuft(tuft, descent, tilt, pe):
    """Smallest enclosing sphere of the bent tuft (Eqs. 10, 11), from its table.

    A ball between two balls, centre and radius alike, holds all that is between what these hold;
    a margin holds how far the bent tuft is from being that.

    Parameters
    ----------
    tuft : Tuft
    descent, tilt, pe : float
        As for `trace_outline`.

    Returns
    -------
    centre_along, centre_up, radius : float
        mm, from P'_m.
    """
    table = tuft.spheres
    n_tilts, n_columns, n_spreads, _ = table.shape
    row = (tilt - tuft.lowest_tilt) * (n_tilts - 1) / (0.5 * math.pi - tuft.lowest_tilt)
    row = min(max(row, 0.0), n_tilts - 1.0)
    column = math.sqrt(max(descent, 0.0) / greatest_descent(tuft, tilt))
    column = min(column, 1.0) * (n_columns - 1)
    layer = tuft.spread * pe / _SPREAD_STEP
    i, k = min(int(row), n_tilts - 2), min(int(column), n_columns - 2)
    j = min(int(layer), n_spreads - 2)
    u, v, w = row - i, column - k, layer - j
    x, y, radius = 0.0, 0.0, 0.0
    for a in range(2):
        for b in range(2):
            for c in range(2):
                weight = (u if a else 1.0 - u) * (v if b else 1.0 - v) * (w if c else 1.0 - w)
                ball = table[i + a, k + b, j + c]
                x += weight * ball[0]
                y += weight * ball[1]
                radius += weight * ball[2]
    return tuft.length * x, tuft.length * y, _SPHERE_MARGIN * tuft.length * radius


@uncounted
def drag_step(rx, ry, rz, dx, dy, dz, slack):
    """r after the handle moved straight on by d: the contact sticks, or follows along a tractrix.

    It sticks until it lies `slack` behind; from there on docs/model.md, equation (3), holds.

    Parameters
    ----------
    rx, ry, rz : float
        Q - H before the step, mm; what is longer than `slack` is drawn in first.
    dx, dy, dz : float
        Movement of H, mm.
    slack : float
        l, mm.

    Returns
    -------
    rx, ry, rz : float
        Q - H after it, never longer than `slack`.
    """
    square = rx * rx + ry * ry + rz * rz
    if square > slack * slack:
        scale = slack / math.sqrt(square)
        rx, ry, rz = rx * scale, ry * scale, rz * scale
        square = slack * slack
    way = math.sqrt(dx * dx + dy * dy + dz * dz)
    if way <= 0.0 or slack <= 0.0:
        return rx, ry, rz
    ux, uy, uz = dx / way, dy / way, dz / way
    ahead = rx * ux + ry * uy + rz * uz
    beside = math.sqrt(max(0.0, square - ahead * ahead))
    sine = min(1.0, beside / slack)
    cosine = math.sqrt(1.0 - sine * sine)
    free = ahead + slack * cosine  # the way until Q lies l behind
    if way <= free:
        return rx - dx, ry - dy, rz - dz
    half = sine / (1.0 + cosine) * math.exp(-(way - free) / slack)  # tan(delta / 2)
    back = slack * (1.0 - half * half) / (1.0 + half * half)
    aside = slack * 2.0 * half / (1.0 + half * half) / beside if beside > 0.0 else 0.0
    return (
        aside * (rx - ahead * ux) - back * ux,
        aside * (ry - ahead * uy) - back * uy,
        aside * (rz - ahead * uz) - back * uz,
    )


@uncounted
def drag_way(rx, ry, rz, dx, dy, dz, before, slack):
    """`drag_step` where the slack goes evenly from `before` to `slack`, mm, on the way."""
    change = abs(slack - before)
    n = 1
    if change > 0.0:
        n = min(_MOST_SLACKS, math.ceil(change / (_SAME_SLACK * max(slack, before))))
    for k in range(1, n + 1):
        now = before + (slack - before) * k / n
        rx, ry, rz = drag_step(rx, ry, rz, dx / n, dy / n, dz / n, now)
    return rx, ry, rz


@uncounted
def smooth_step(x):
    """From 0 at 0 to 1 at 1, level at both."""
    x = min(1.0, max(0.0, x))
    return x * x * (3.0 - 2.0 * x)


@uncounted
def twist_step(twist, turned, way, slack):
    """The angle by which the paper holds a commanded tuft back behind its azimuth.

    What the handle turns by on the spot stays; over a way the tuft comes round. See
    docs/model.md, section 2.

    Parameters
    ----------
    twist : float
        Before the step, rad.
    turned : float
        How far the azimuth turns, rad, with its sign.
    way : float
        Of H, mm.
    slack : float
        l, mm.

    Returns
    -------
    twist : float
        After it, rad; no more than what makes a heap of the tuft.
    """
    twist = (twist + turned) * math.exp(-way / max(_UNTWISTS * slack, 1e-9))
    return min(_TWISTED[1], max(-_TWISTED[1], twist))


@uncounted
def bent_by_twist(twist):
    """How far a tuft with such a twist (rad) lies in its bend, 0 to 1."""
    return 1.0 - smooth_step((abs(twist) - _TWISTED[0]) / (_TWISTED[1] - _TWISTED[0]))


@uncounted
def gather_outline(bent, straight, reach, half_width, n):
    """Let a tuft that is not bent lie in a heap under its root: docs/model.md, equation (4).

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
        share = min(1.0, max(-1.0, (reach[i] - middle) / half))
        reach[i] = (bent * half + (1.0 - bent) * disc) * share
        round_ = disc * math.sqrt(1.0 - share * share)
        half_width[i] = bent * half_width[i] + (1.0 - bent) * round_
    half_width[0], half_width[n - 1] = 0.0, 0.0
    scale = math.sqrt(area / outline_area(reach, half_width, n))
    for i in range(n):
        reach[i] = centre + scale * reach[i]
        half_width[i] *= scale


@uncounted
def release(rx, ry, rz, plasticity):
    """r after the pen is lifted: the direction stays, the length is scaled by rho."""
    return rx * plasticity, ry * plasticity, rz * plasticity


@uncounted
def drag_length(descent, length_mm, fraction):
    """Slack l (mm) between the handle and its dragged contact.

    Measured on a tuft of 30 mm as a power of the depth for three fractions c of the drag, with
    linear interpolation between them; other tufts are taken as similar in shape.

    Parameters
    ----------
    descent : float
        D_s, mm, not negative.
    length_mm : float
        LE, mm.
    fraction : float
        c, 0 to 1/2.
    """
    scale = length_mm / MEASURED_LENGTH
    depth = descent / scale
    middle = 0.92 * depth**0.84
    if fraction < 1.0 / 3.0:
        share = 3.0 * fraction
        return scale * (0.61 * depth**0.78 * (1.0 - share) + middle * share)
    share = 6.0 * (fraction - 1.0 / 3.0)
    return scale * (middle * (1.0 - share) + 1.19 * depth**0.81 * share)


@uncounted
def drag_along(handle, slack, rx, ry, out):
    """Contact Q (N, 2) under a plane track of the handle (N, 2), by the law of straight ways.

    Parameters
    ----------
    handle : (N, 2) float64
        H, mm.
    slack : (N,) float64
        l, mm, more than 0, linear between samples.
    rx, ry : float
        Q - H at the first sample.
    out : (N, 2) float64
        Q, mm.
    """
    out[0, 0], out[0, 1] = handle[0, 0] + rx, handle[0, 1] + ry
    for i in range(1, handle.shape[0]):
        dx = handle[i, 0] - handle[i - 1, 0]
        dy = handle[i, 1] - handle[i - 1, 1]
        rx, ry, _ = drag_way(rx, ry, 0.0, dx, dy, 0.0, slack[i - 1], slack[i])
        out[i, 0], out[i, 1] = handle[i, 0] + rx, handle[i, 1] + ry


@uncounted
def trail_step(along, across, aside, short, length, way, pressed, bent):
    """How the tip lies behind its heel after that has moved: docs/model.md, equation (4a).

    Parameters
    ----------
    along, across : float
        From the heel, where it is now, to where the tip lay, along the bend and across it, mm.
    aside, short : float
        Before the step: the angle by which the tip lay aside of the bend, rad, and how much nearer
        to the heel it lay than the footprint is long, mm.
    length : float
        Of the footprint now, mm, more than 0.
    way : float
        Of the root's foot since, mm.
    pressed : float
        How much deeper the tuft came meanwhile, mm; less than 0 as it is lifted.
    bent : float
        How far it lies in its bend, 0 to 1; the edge of a heap is not held but spreads.

    Returns
    -------
    aside, short : float
        After it.
    """
    distance = math.hypot(along, across)
    slack = max(0.0, length - distance)
    held = min(1.0, max(0.0, short - way) / (_SLACK * length))
    if way > 0.0:
        held *= min(1.0, max(0.0, _PULLS * (short - slack) / way))
    if pressed > 0.0:
        held = max(held, min(1.0, _HOLDS * pressed / way) if way > 0.0 else 1.0)
    held *= bent
    short = max(0.0, short - way)
    if held > 0.0:
        if distance > _NOWHERE:
            aside += held * _turn(math.atan2(across, along) - aside)
        short += held * (slack - short)
    aside *= math.exp(-(1.0 - held) * way / (_SPRINGS * length))
    return _turn(aside), min(short, length)


@uncounted
def _turn(angle):
    """An angle of at most two turns, within half a turn."""
    if angle > math.pi:
        return angle - 2.0 * math.pi
    if angle < -math.pi:
        return angle + 2.0 * math.pi
    return angle


@uncounted
def lie_held(aside, short, length, bent):
    """How a footprint is laid whose tip lies so far aside and so much nearer to its heel.

    A tuft in a heap has no tip to be held by, and one whose tip is under its heel no direction: as
    it comes there it lies in its bend. See docs/model.md, section 2.

    Parameters
    ----------
    aside, short : float
        Of `trail_step`; rad, mm.
    length : float
        Of the footprint in its bend, mm, more than 0.
    bent : float
        How far the tuft lies in its bend, 0 to 1.

    Returns
    -------
    cosine, sine : float
        Of the angle by which it is turned about its heel.
    shorter : float
        mm.
    """
    told = bent * smooth_step((length - short) / (_TOLD * length))
    x, y = 1.0 + told * (math.cos(aside) - 1.0), told * math.sin(aside)
    norm = math.hypot(x, y)
    if norm <= _NOWHERE:
        return 1.0, 0.0, told * short
    return x / norm, y / norm, told * short


@uncounted
def hold_along(handle, azimuth, descent, heel, length, out):
    """How footprints are laid whose tips the paper holds, under a plane track of the handle.

    Parameters
    ----------
    handle : (N, 2) float64
        H, mm.
    azimuth : (N,) float64
        Of the bend, rad; the tuft lies in it.
    descent, heel, length : (N,) float64
        D_s, how far the heel lies from H along the bend, and of the footprint, mm.
    out : (N, 2) float64
        By which angle each is turned about its heel, rad, and how much shorter it is, mm.
    """
    tip_x, tip_y, aside, short = 0.0, 0.0, 0.0, 0.0
    for k in range(handle.shape[0]):
        x, y = math.cos(azimuth[k]), math.sin(azimuth[k])
        heel_x, heel_y = handle[k, 0] + heel[k] * x, handle[k, 1] + heel[k] * y
        if k > 0:
            dx, dy = tip_x - heel_x, tip_y - heel_y
            way = math.hypot(handle[k, 0] - handle[k - 1, 0], handle[k, 1] - handle[k - 1, 1])
            pressed = descent[k] - descent[k - 1]
            along, across = dx * x + dy * y, dy * x - dx * y
            aside, short = trail_step(along, across, aside, short, length[k], way, pressed, 1.0)
        lies = azimuth[k] + aside
        tip_x = heel_x + (length[k] - short) * math.cos(lies)
        tip_y = heel_y + (length[k] - short) * math.sin(lies)
        cosine, sine, shorter = lie_held(aside, short, length[k], 1.0)
        out[k, 0], out[k, 1] = math.atan2(sine, cosine), shorter

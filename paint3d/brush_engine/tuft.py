"""The bent tuft: table lookup, outline on the plane, enclosing sphere (Guo 2017, Eqs. 2-11), drag.

All of it lies in the bend plane. Its origin is P'_m, the root's foot on the paper; `along` points
from there to the tip, `up` is the paper's normal, `side` is normal to both. The third angle, the
azimuth of `along` on the paper, is the pose's, or the paper turns the brush as it drags the tuft.

The spine is evaluated at `REFINEMENT` points on every straight segment, with the section's angle
interpolated between joints: at the joints that is the papers' Eqs. 6-9, between them the outline
grows without steps as the brush is pressed.

The dragged tuft is a tractrix with slack: with H the handle's foot P'_m and Q the dragged contact,
r = Q - H. While |r| is below the slack l(D_s) the contact sticks; beyond, it follows at the
distance l. The bend direction is that of r. The law knows no time, only the path (closed form of
the discrete rule published with Wang et al., "Robot Calligraphy using Pseudospectral Optimal
Control in Conjunction with a Novel Dynamic Brush Model", IROS 2020, whose measured brush gives l).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    "REFINEMENT",
    "SCRATCH_SIZE",
    "SHARES",
    "SPEED",
    "SPREAD",
    "STIFFNESS",
    "TILT",
    "WETNESS",
    "Curves",
    "Tuft",
    "bend_angles",
    "drag_along",
    "drag_length",
    "drag_step",
    "enclose_tuft",
    "greatest_descent",
    "no_curves",
    "release",
    "trace_outline",
]

_MAX_SEGMENTS = 13  # the papers' largest m
REFINEMENT = 12  # points on each straight segment of the spine
_RETRACED = 1  # steps before that of M_d that are traced anew
_CLOSING_POINTS = 6  # on these steps
_CROSSING_STEPS = 7
OUTLINE_CAPACITY = (
    _MAX_SEGMENTS * REFINEMENT + _CLOSING_POINTS + 2
)  # what out_reach and out_half_width must hold
HALF_RING = 5  # surface points on one half of each joint's section, for the enclosing sphere
SCRATCH_SIZE = 512  # float64 numbers: angles, then x, y, z and square of every surface point
_POINTS = _MAX_SEGMENTS * HALF_RING + 1
_X, _Y, _Z, _SQUARE = 32, 32 + _POINTS, 32 + 2 * _POINTS, 32 + 3 * _POINTS
_TOLERANCE = 3e-3  # an outlier nearer than this (relative) ends the sphere's passes
_PASSES = 40

# Where the refined spine is evaluated on a segment: crowded at the joints, where the tuft kinks.
SHARES = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, REFINEMENT + 1))
SHARES.setflags(write=False)
_COS = np.cos(np.linspace(0.0, np.pi, HALF_RING))
_SIN = np.sin(np.linspace(0.0, np.pi, HALF_RING))
MOST_POINTS = 8  # of a curve
# Rows of the table: settings, and inputs of each; their names are in `brush.dynamics`.
STIFFNESS, SPREAD, LOAD, WETNESS = 0, 1, 2, 3
N_SETTINGS = 4
PRESSURE, TILT, SPEED, INK_LEFT, CURVATURE = 0, 1, 2, 3, 4
N_INPUTS = 5
MEASURED_LENGTH = 30.0  # mm, the tuft on which `drag_length` was measured
_STEPS_PER_SLACK = 40  # the longest step that a chord may follow is l / 40


class Tuft(NamedTuple):
    """A brush made ready for kernels: plain numbers and float64 arrays (M segments).

    Built by `paint3d.brush.bending.build_tuft`; one argument of every kernel here.
    """

    segment_lengths: NDArray  # (M,) le_j from the tip to the root, mm (Eq. 1)
    diameters: (
        NDArray  # (M * REFINEMENT + 1,) round diameter along the refined spine, tip first, mm
    )
    taper: float  # exponent of the diameter over the arc length
    angles: NDArray  # (tilts, descents, M) beta_j over tilt and sqrt(descent), rad
    lowest_tilt: float  # rad, first row of `angles`; the last row is pi / 2
    greatest_fraction: float  # last column of `angles`: descent / (length sin tilt)
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
def bend_angles(tuft, descent, tilt, out_angles):
    """Angles of the segments to the plane, by bilinear lookup.

    Parameters
    ----------
    tuft : Tuft
    descent : float
        D_s, mm. Beyond `greatest_descent` the ferrule rests on the plane: the last shape holds.
    tilt : float
        theta, rad; outside the table's range the nearest row holds.
    out_angles : (M + 1,) float64
        beta_1 to beta_m, then beta_{m+1} = theta, the clamp in the holder.
    """
    n_tilts, n_descents, m = tuft.angles.shape
    row = (tilt - tuft.lowest_tilt) * (n_tilts - 1) / (0.5 * math.pi - tuft.lowest_tilt)
    row = min(max(row, 0.0), n_tilts - 1.0)
    i = min(int(row), n_tilts - 2)
    v = row - i
    fraction = max(descent, 0.0) / (tuft.greatest_fraction * tuft.length * math.sin(tilt))
    column = min(math.sqrt(fraction), 1.0) * (n_descents - 1)
    k = min(int(column), n_descents - 2)
    u = column - k
    a00, a01 = (1.0 - v) * (1.0 - u), (1.0 - v) * u
    a10, a11 = v * (1.0 - u), v * u
    for j in range(m):
        low = a00 * tuft.angles[i, k, j] + a01 * tuft.angles[i, k + 1, j]
        out_angles[j] = low + a10 * tuft.angles[i + 1, k, j] + a11 * tuft.angles[i + 1, k + 1, j]
    out_angles[m] = tilt


@uncounted(inline="always")
def _section(along, up, angle, diameter, spread):
    """Reach of one section's line on the plane, and its half width squared, with sign (Eqs. 7, 8).

    C_j1 = C_j spread and C_j2 = C_j / spread (Eqs. 2, 3), so that Eq. 8 reads
    |W_j M_j| = spread^2 / 2 sqrt(C_j2^2 - (2 z / cos)^2).
    """
    cosine = math.cos(angle)
    minor = diameter / spread
    chord = 2.0 * up / cosine
    widening = spread * spread
    square = 0.25 * widening * widening * (minor * minor - chord * chord)
    return along - up * math.sin(angle) / cosine, square


class _Joint(NamedTuple):
    """The lower end of a segment of the bent spine."""

    segment: int
    arc: float  # from the tip, mm
    along: float  # where it is, mm
    up: float


@uncounted
def _section_at(tuft, angles, pe, joint, t):
    """`_section` at the share t of the segment above a joint."""
    j = joint.segment
    below = angles[j - 1] if j > 0 else angles[0]
    near = 0.5 * (below + angles[j])
    far = 0.5 * (angles[j] + angles[j + 1])
    # The root circle keeps its diameter: the spread fades over the last segment.
    fade = 1.0 if j < tuft.segment_lengths.shape[0] - 1 else 1.0 - t
    run = t * tuft.segment_lengths[j]
    diameter = tuft.diameters[-1] * ((joint.arc + run) / tuft.length) ** tuft.taper
    return _section(
        joint.along - run * math.cos(angles[j]),
        joint.up + run * math.sin(angles[j]),
        near + t * (far - near),
        diameter,
        1.0 + tuft.spread * pe * fade,
    )


@uncounted
def _close(tuft, angles, pe, joint, i, out_reach, out_half_width, n):
    """Find M_d, where the tuft leaves the plane in step i above a joint, and end the outline there.

    The half width falls like a square root there, so the last two steps are traced anew,
    with points that crowd towards M_d.
    """
    low, high = SHARES[i - 1], SHARES[i]
    _, f_low = _section_at(tuft, angles, pe, joint, low)
    _, f_high = _section_at(tuft, angles, pe, joint, high)
    side = 0
    t = low
    for _ in range(_CROSSING_STEPS):  # the Illinois variant of regula falsi
        t = low + (high - low) * f_low / (f_low - f_high)
        _, square = _section_at(tuft, angles, pe, joint, t)
        if square > 0.0:
            low, f_low = t, square
            f_high *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            high, f_high = t, square
            f_low *= 0.5 if side < 0 else 1.0
            side = -1
    again = min(i - 1, _RETRACED)
    first = SHARES[i - 1 - again]
    n = max(n - again, 1)
    for k in range(1, _CLOSING_POINTS + 1):
        rest = 1.0 - k / (_CLOSING_POINTS + 1.0)
        inner = first + (1.0 - rest * rest) * (t - first)
        reach, square = _section_at(tuft, angles, pe, joint, inner)
        if square > 0.0 and reach < out_reach[n - 1]:
            out_reach[n], out_half_width[n] = reach, math.sqrt(square)
            n += 1
    reach, _ = _section_at(tuft, angles, pe, joint, t)
    if reach < out_reach[n - 1]:
        out_reach[n] = reach
        n += 1
    out_half_width[n - 1] = 0.0
    return n


@uncounted
def _tip_reach(tuft, angles):
    """Where the tip of the bent spine lies, mm from P'_m."""
    along = 0.0
    for j in range(tuft.segment_lengths.shape[0]):
        along += tuft.segment_lengths[j] * math.cos(angles[j])
    return along


@uncounted
def trace_outline(tuft, descent, tilt, pe, scratch, out_reach, out_half_width):
    """Outline of the footprint: its half width against the distance from P'_m (Eqs. 2, 3, 6-9).

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
    m = tuft.segment_lengths.shape[0]
    bend_angles(tuft, descent, tilt, scratch)
    along = _tip_reach(tuft, scratch)
    up, arc = 0.0, 0.0
    out_reach[0], out_half_width[0] = along, 0.0
    n = 1
    spread = 1.0 + tuft.spread * pe
    near = scratch[0]
    for j in range(m):
        far = 0.5 * (scratch[j] + scratch[j + 1])
        run = tuft.segment_lengths[j] * math.cos(scratch[j])
        rise = tuft.segment_lengths[j] * math.sin(scratch[j])
        for i in range(1, REFINEMENT + 1):
            t = SHARES[i]
            reach, square = _section(
                along - t * run,
                up + t * rise,
                near + t * (far - near),
                tuft.diameters[j * REFINEMENT + i],
                spread if j < m - 1 else spread - t * (spread - 1.0),
            )
            if square <= 0.0:
                if n == 1:
                    return 0
                joint = _Joint(j, arc, along, up)
                return _close(tuft, scratch, pe, joint, i, out_reach, out_half_width, n)
            if reach < out_reach[n - 1]:
                out_reach[n], out_half_width[n] = reach, math.sqrt(square)
                n += 1
        arc += tuft.segment_lengths[j]
        along -= run
        up += rise
        near = far
    out_half_width[n - 1] = 0.0
    return n


@uncounted
def _surface_points(tuft, descent, tilt, pe, scratch):
    """Put the tip and half a ring of points at every joint into scratch; return their number."""
    m = tuft.segment_lengths.shape[0]
    bend_angles(tuft, descent, tilt, scratch)
    along = _tip_reach(tuft, scratch)
    up = 0.0
    spread = 1.0 + tuft.spread * pe
    scratch[_X], scratch[_Y], scratch[_Z] = along, up, 0.0
    n = 1
    for j in range(m):
        along -= tuft.segment_lengths[j] * math.cos(scratch[j])
        up += tuft.segment_lengths[j] * math.sin(scratch[j])
        angle = 0.5 * (scratch[j] + scratch[j + 1])
        widening = spread if j < m - 1 else 1.0
        radius = 0.5 * tuft.diameters[(j + 1) * REFINEMENT]
        major, minor = radius * widening, radius / widening
        minor_along, minor_up = minor * math.sin(angle), minor * math.cos(angle)
        for i in range(HALF_RING):
            scratch[_X + n] = along + minor_along * _COS[i]
            scratch[_Y + n] = up + minor_up * _COS[i]
            scratch[_Z + n] = major * _SIN[i]
            n += 1
    return n


@uncounted
def _farthest(scratch, n, x, y, z):
    """Which surface point lies farthest from (x, y, z), and the square of how far."""
    xs, ys, zs = scratch[_X : _X + n], scratch[_Y : _Y + n], scratch[_Z : _Z + n]
    squares = scratch[_SQUARE : _SQUARE + n]
    for i in range(n):
        squares[i] = (xs[i] - x) ** 2 + (ys[i] - y) ** 2 + (zs[i] - z) ** 2
    index, greatest = 0, -1.0
    for i in range(n):
        if squares[i] > greatest:
            index, greatest = i, squares[i]
    return index, greatest


@uncounted
def enclose_tuft(tuft, descent, tilt, pe, scratch):
    """Smallest enclosing sphere of the bent tuft's surface by growing a ball (Eqs. 10, 11).

    The ball starts on the farthest pair and grows towards the farthest outlier. A grown ball need
    not hold the old one, so passes repeat until no outlier lies more than 0.3 % outside; then the
    radius takes in what is left. With c the smallest ball's centre and R its radius, Eqs. 10 and 11
    keep |D - c|^2 + r^2 <= R^2, so the ball never outgrows the smallest one. The tuft is symmetric,
    c lies in the bend plane, and D moved there by z may have r^2 grow by z^2: this counts an
    outlier and its mirror image in one step, and half of the surface is enough.

    Parameters
    ----------
    tuft : Tuft
    descent, tilt, pe : float
        As for `trace_outline`.
    scratch : (SCRATCH_SIZE,) float64
        Overwritten.

    Returns
    -------
    centre_along, centre_up, radius : float
        mm, from P'_m.
    """
    n = _surface_points(tuft, descent, tilt, pe, scratch)
    b, _ = _farthest(scratch, n, scratch[_X], scratch[_Y], scratch[_Z])
    c, square = _farthest(scratch, n, scratch[_X + b], scratch[_Y + b], -scratch[_Z + b])
    x = 0.5 * (scratch[_X + b] + scratch[_X + c])
    y = 0.5 * (scratch[_Y + b] + scratch[_Y + c])
    z = 0.5 * (scratch[_Z + b] - scratch[_Z + c])
    radius = math.sqrt(0.25 * square + z * z)
    for _ in range(_PASSES):
        e, square = _farthest(scratch, n, x, y, 0.0)
        distance = math.sqrt(square)
        if distance <= radius * (1.0 + _TOLERANCE):
            break
        grown = (radius * radius + square) / (2.0 * distance)  # Eq. 10
        step = math.sqrt(max(grown * grown - radius * radius, 0.0)) / distance  # Eq. 11
        x += step * (scratch[_X + e] - x)
        y += step * (scratch[_Y + e] - y)
        z = step * scratch[_Z + e]
        radius = math.sqrt(grown * grown + z * z)
    _, square = _farthest(scratch, n, x, y, 0.0)
    return x, y, math.sqrt(square)


@uncounted
def drag_step(rx, ry, rz, dx, dy, dz, slack):
    """r after the handle moved by d: the contact sticks, or follows at the distance `slack`.

    Repeated along a straight way it gives docs/model.md, equation (2).

    Parameters
    ----------
    rx, ry, rz : float
        Q - H before the step, mm.
    dx, dy, dz : float
        Movement of H, mm; at most a fortieth of `slack`, for it is followed as a chord.
    slack : float
        l, mm.

    Returns
    -------
    rx, ry, rz : float
        Q - H after it, never longer than `slack`.
    """
    rx, ry, rz = rx - dx, ry - dy, rz - dz
    square = rx * rx + ry * ry + rz * rz
    if square > slack * slack:
        scale = slack / math.sqrt(square)
        return rx * scale, ry * scale, rz * scale
    return rx, ry, rz


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
    """Contact Q (N, 2) under a plane track of the handle (N, 2), by steps of at most l / 40.

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
        shortest = min(slack[i - 1], slack[i])
        n = max(1, math.ceil(_STEPS_PER_SLACK * math.hypot(dx, dy) / shortest))
        for k in range(1, n + 1):
            length = slack[i - 1] + (slack[i] - slack[i - 1]) * k / n
            rx, ry, _ = drag_step(rx, ry, 0.0, dx / n, dy / n, 0.0, length)
        out[i, 0], out[i, 1] = handle[i, 0] + rx, handle[i, 1] + ry

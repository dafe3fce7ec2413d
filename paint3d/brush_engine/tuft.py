"""The bent tuft: its tables of shapes, its spine, and the sphere around it.

All of it lies in the bend plane. Its origin is P'_m, the root's foot on the paper; `along` points
from there to the tip, `up` is the paper's normal, `side` is normal to both. The third angle, the
azimuth of `along` on the paper, is the pose's, or the paper turns the brush as it drags the tuft
(`brush_engine.drag`).

A shape is read from tables over tilt and descent at `STATIONS` places along the spine, by cubics
over the descent and linearly over the tilt.
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
    "PRESSURE",
    "RING_STATIONS",
    "SPEED",
    "SPHERE_SPREADS",
    "SPHERE_STEPS",
    "SPREAD",
    "STATIONS",
    "STIFFNESS",
    "TILT",
    "WETNESS",
    "Curves",
    "TablePosition",
    "Tuft",
    "blend_rows",
    "cubic_weights",
    "enclose_tuft",
    "greatest_descent",
    "interpolate",
    "locate",
    "no_curves",
    "round_diameter",
    "trace_spine",
]

STATIONS = 57  # places along the spine at which shapes are kept, crowded towards the tip
RING_STATIONS = (0, 15, 21, 28, 33, 38, 43, 47, 51, 56)  # those that the sphere is put around
SPHERE_STEPS = 8  # every so many descents have their spheres, and every second tilt
_SPREAD_STEP = 0.25
_SPHERE_MARGIN = 1.003  # times the radius: a tuft between its table's shapes is not their mean
SPHERE_SPREADS = tuple(1.0 + _SPREAD_STEP * k for k in range(11))  # of sections, with their spheres

MOST_POINTS = 8  # of a curve
# Rows of the table: settings, and inputs of each; their names are in `brush.spec`.
STIFFNESS, SPREAD, LOAD, WETNESS = 0, 1, 2, 3
N_SETTINGS = 4
PRESSURE, TILT, SPEED, INK_LEFT, CURVATURE = 0, 1, 2, 3, 4
N_INPUTS = 5


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
    plasticity: float  # rho: fraction of the bend kept when the pen lifts


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
def cubic_weights(t):
    """Weights of four even points for a place between the middle two (Catmull-Rom)."""
    return (
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    )


class TablePosition(NamedTuple):
    """Position in the tables of shapes: two rows, four columns of each, and their weights."""

    row: int
    column: int  # first of the four
    fraction: float  # of the second row
    a: float
    b: float
    c: float
    d: float


@uncounted
def locate(tuft, descent, tilt):
    """The place of a descent (mm) and a tilt (rad); outside the tables their ends hold."""
    n_tilts, n_columns, _ = tuft.reach.shape
    row = (tilt - tuft.lowest_tilt) * (n_tilts - 1) / (0.5 * math.pi - tuft.lowest_tilt)
    row = min(max(row, 0.0), n_tilts - 1.0)
    i = min(int(row), n_tilts - 2)
    column = math.sqrt(max(descent, 0.0) / greatest_descent(tuft, tilt))
    column = min(column, 1.0) * (n_columns - 1)
    k = min(int(column), n_columns - 2)
    before, here, after, beyond = cubic_weights(column - k)
    if k == 0:  # shapes are even functions of the root of the descent
        return TablePosition(i, 0, row - i, here, before + after, beyond, 0.0)
    if k == n_columns - 2:  # and go on straight where the table ends
        return TablePosition(i, k - 2, row - i, 0.0, before, here - beyond, after + 2.0 * beyond)
    return TablePosition(i, k - 1, row - i, before, here, after, beyond)


@uncounted
def blend_rows(table, at, n, out):
    """The first n numbers of a table's (tilts, descents, N) rows at a place."""
    low, high = 1.0 - at.fraction, at.fraction
    below, above = table[at.row], table[at.row + 1]
    k = at.column
    a0, b0, c0, d0 = below[k], below[k + 1], below[k + 2], below[k + 3]
    a1, b1, c1, d1 = above[k], above[k + 1], above[k + 2], above[k + 3]
    for j in range(n):
        lower = at.a * a0[j] + at.b * b0[j] + at.c * c0[j] + at.d * d0[j]
        upper = at.a * a1[j] + at.b * b1[j] + at.c * c1[j] + at.d * d1[j]
        out[j] = low * lower + high * upper


@uncounted
def interpolate(values, first, weights):
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
def trace_spine(tuft, descent, tilt, out):
    """The bent spine at the stations: along (mm, from P'_m), up (mm) and the section's angle (rad).

    Parameters
    ----------
    tuft : Tuft
    descent, tilt : float
        D_s (mm) and theta (rad) of the holder.
    out : (3, STATIONS) float64
    """
    at = locate(tuft, descent, tilt)
    for part in range(3):
        blend_rows(tuft.spine[:, :, part], at, STATIONS, out[part])
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

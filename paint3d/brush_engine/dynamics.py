"""What the hand does drives what the brush is: curves from inputs to settings, at every pose.

As painters know it from MyPaint: any input may drive any setting through a curve of straight
pieces. Here each curve gives a factor, and a setting is its own value times the factors of all
inputs that drive it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.tuft import Tuft
from paint3d.core.kernel import kernel, uncounted

__all__ = ["MOST_POINTS", "N_INPUTS", "N_SETTINGS", "Curves", "curve_at", "drive", "no_curves",
           "read_inputs"]  # fmt: skip

MOST_POINTS = 8  # of a curve
# Rows of the table: settings, and inputs of each; their names are in `brush.dynamics`.
STIFFNESS, SPREAD, LOAD, WETNESS = 0, 1, 2, 3
N_SETTINGS = 4
PRESSURE, TILT, SPEED, INK_LEFT, CURVATURE = 0, 1, 2, 3, 4
N_INPUTS = 5


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
def curve_at(points, count, x):
    """Height of a curve (count points, x rising) at x; beyond its ends these hold."""
    if x <= points[0, 0]:
        return points[0, 1]
    for k in range(1, count):
        if x <= points[k, 0]:
            t = (x - points[k - 1, 0]) / (points[k, 0] - points[k - 1, 0])
            return (1.0 - t) * points[k - 1, 1] + t * points[k, 1]
    return points[count - 1, 1]


@uncounted
def _velocity(t, mean, first, last):
    """Slope of the cubic between two samples at the share t of the way."""
    return (
        6.0 * (t - t * t) * mean
        + (1.0 - 4.0 * t + 3.0 * t * t) * first
        + ((3.0 * t * t - 2.0 * t) * last)
    )


@uncounted
def read_inputs(samples, i, t, pose, before, tuft, ink, inputs):
    """Fill the inputs (N_INPUTS,) at the share t of the way from sample i to the next.

    Pressure 0 to 1 (the last stamp's where the device has none), tilt to the surface at the last
    stamp (degrees), speed along the surface (mm/s), ink left of a full load, and how sharply the
    path turns on it (1/mm).
    """
    inputs[PRESSURE] = before.values[0].pressure if np.isnan(pose[7]) else pose[7]
    tilt = before.values[0].tilt
    inputs[TILT] = np.degrees(tilt) if tilt > 0.0 else 90.0
    h = samples.time[i + 1] - samples.time[i]
    normal = before.values[0].foot_normal
    lift = lift_a = lift_b = lift_step = 0.0  # only what is along the surface counts
    for axis in range(3):
        step = samples.position[i + 1, axis] - samples.position[i, axis]
        a, b = samples.velocity[i, axis], samples.velocity[i + 1, axis]
        lift += normal[axis] * _velocity(t, step / h, a, b)
        lift_a += normal[axis] * a
        lift_b += normal[axis] * b
        lift_step += normal[axis] * step
    speed2 = a2 = b2 = dot = chord2 = 0.0
    for axis in range(3):
        step = samples.position[i + 1, axis] - samples.position[i, axis]
        a, b = samples.velocity[i, axis], samples.velocity[i + 1, axis]
        speed2 += (_velocity(t, step / h, a, b) - lift * normal[axis]) ** 2
        chord2 += (step - lift_step * normal[axis]) ** 2
        a -= lift_a * normal[axis]
        b -= lift_b * normal[axis]
        a2 += a * a
        b2 += b * b
        dot += a * b
    inputs[SPEED] = np.sqrt(speed2)
    turn = np.arctan2(np.sqrt(max(a2 * b2 - dot * dot, 0.0)), dot) if a2 * b2 > 0.0 else 0.0
    inputs[CURVATURE] = turn / np.sqrt(chord2) if chord2 > 1e-12 and turn > 1e-6 else 0.0
    held = 0.0
    for p in range(ink.load.shape[0]):
        held += ink.load[p]
    inputs[INK_LEFT] = held / tuft.load


@uncounted
def _factor(curves, setting):
    factor = 1.0
    for n in range(N_INPUTS):
        count = curves.counts[setting, n]
        if count > 0:
            factor *= curve_at(curves.points[setting, n], count, curves.inputs[n])
    return factor


@kernel
def drive(samples, i, t, pose, before, tuft, ink, curves):
    """The tuft as the hand drives it at this pose; `ink` learns how much ink makes it wet.

    A stiffer tuft is pressed less deep by the same force; one with more load gives more ink to the
    mm; a wetter one closes its stroke with less ink in it.
    """
    if curves.any[0] == 0:
        return tuft
    read_inputs(samples, i, t, pose, before, tuft, ink, curves.inputs)
    stiffness = _factor(curves, STIFFNESS)
    ink.transfer[0].capacity = tuft.load / _factor(curves, WETNESS)
    return Tuft(
        tuft.segment_lengths,
        tuft.diameters,
        tuft.taper,
        tuft.angles,
        tuft.lowest_tilt,
        tuft.greatest_fraction,
        tuft.length,
        min(tuft.full_press / stiffness, tuft.greatest_fraction * tuft.length),
        tuft.spring * stiffness,
        tuft.max_force,
        tuft.spread * _factor(curves, SPREAD),
        tuft.load,
        tuft.transfer_per_mm * _factor(curves, LOAD),
        tuft.drag_fraction,
        tuft.plasticity,
    )

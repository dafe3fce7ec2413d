"""A stroke's samples, interval by interval: which are painted, and the pose between two of them.

Between two samples the pose is a cubic in time. Samples that lie closer than the shortest sweep are
passed by: a device that is read a thousand times a second costs no more than the way that it goes,
and its noise at rest gives no ink.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine import stamp as st
from paint3d.brush_engine.dynamics import Curves
from paint3d.brush_engine.ink_field import InkField
from paint3d.brush_engine.stamp import Stamp
from paint3d.brush_engine.tuft import Tuft
from paint3d.core.kernel import uncounted
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.mesh.kernels.mesh_arrays import SurfaceField

__all__ = [
    "FINEST_STEP",
    "FINISHED",
    "FOOTPRINTS",
    "NEEDS_ROOM",
    "SAMPLES",
    "Canvas",
    "HeldBrush",
    "Progress",
    "Samples",
    "copy_stamp",
    "end_interval",
    "interpolate",
    "make_progress",
    "next_interval",
]

SAMPLES, FOOTPRINTS = 0, 1  # counters

FINISHED = 0
NEEDS_ROOM = 1

FINEST_STEP = 0.35  # of the paint's resolution: the shortest sweep, and how near samples count


class Samples(NamedTuple):
    """N poses in the object's frame, ready to be interpolated."""

    time: NDArray  # (N,) s
    position: NDArray  # (N, 3) the place on the surface that the hand means, else root node P_m, mm
    velocity: NDArray  # (N, 3) mm/s, tangents of the cubic
    orientation: NDArray  # (N, 4) unit quaternions wxyz, neighbours in one hemisphere
    pressure: NDArray  # (N,) pe in [0, 1]; NaN: the depth follows from the position
    joined: NDArray  # (N,) bool: the pen moved on from the previous sample to this one
    on_surface: NDArray  # (N,) bool: the position is a place on the surface


class HeldBrush(NamedTuple):
    """The brush as the hand holds it."""

    tuft: Tuft  # as it is; the curves drive it
    curves: Curves
    dragged: bool  # whether the surface pulls the tip, or the pose's roll commands the azimuth


class Canvas(NamedTuple):
    """What is painted on."""

    tree: ContactTree
    field: SurfaceField
    ink: InkField


class Progress(NamedTuple):
    """Where the stroke stands; filled in place, so that painting can be taken up again."""

    at: NDArray  # (3,) int64: interval, next sweep in it, sweeps in it
    before: Stamp
    after: Stamp
    noted: NDArray  # (8,) position mm, quaternion and pressure of the sample where `before` stands


def make_progress() -> Progress:
    """Nothing painted yet."""
    return Progress(np.zeros(3, np.int64), st.make_stamp(), st.make_stamp(), np.zeros(8))


@uncounted(forceinline=True)
def next_interval(samples, last, tuft, resolution, progress, counters):
    """The interval that is painted next, by its first sample; -1 where sample `last` is reached.

    One that was begun goes on. Others in which the pen is off the surface, or moves so little that
    the stroke need not stop at the next sample, are passed by.
    """
    at, before = progress.at, progress.before.values[0]
    while at[0] < last:
        i = at[0]
        if not samples.joined[i + 1]:
            before.touches = 0.0
        elif at[2] > 0:
            return i
        elif samples.pressure[i] <= 0.0 and samples.pressure[i + 1] <= 0.0:
            before.touches = 0.0
        else:
            counters[SAMPLES] += 1
            if before.touches <= 0.0 or not _may_pass(
                samples, i + 1, progress.noted, tuft, resolution
            ):
                return i
        at[0] += 1
        at[1] = 0
        at[2] = 0
    return -1


@uncounted(forceinline=True)
def end_interval(samples, progress):
    """Go on to the next interval; `progress.before` stands at its first sample."""
    at = progress.at
    _note_pose(samples, at[0] + 1, progress.noted)
    at[0] += 1
    at[1] = 0
    at[2] = 0


@uncounted
def _note_pose(samples, i, noted):
    """Remember sample i as the one where the last stamp stands."""
    for axis in range(3):
        noted[axis] = samples.position[i, axis]
    for k in range(4):
        noted[3 + k] = samples.orientation[i, k]
    noted[7] = samples.pressure[i]


@uncounted
def _may_pass(samples, i, noted, tuft, resolution):
    """Whether the stroke need not stop at sample i, so near lies it to the one that was noted.

    How far a footprint moves between two poses is counted as the sum of what its place, its turn
    about the tuft's length and its press make of it. A stroke's last sample is never passed.
    """
    if i + 1 >= samples.time.shape[0] or not samples.joined[i + 1]:
        return False
    if samples.pressure[i] <= 0.0 or samples.pressure[i + 1] <= 0.0:
        return False
    d2, dot = 0.0, 0.0
    for axis in range(3):
        d2 += (samples.position[i, axis] - noted[axis]) ** 2
    for k in range(4):
        dot += samples.orientation[i, k] * noted[3 + k]
    way = np.sqrt(d2) + tuft.length * 2.0 * np.sqrt(max(0.0, 1.0 - dot * dot))
    if not np.isnan(noted[7]):
        way += tuft.full_press * abs(samples.pressure[i] - noted[7])
    return way < FINEST_STEP * resolution


@uncounted
def interpolate(samples, i, fraction, pose):
    """Pose (9,) of `place_stamp` between samples i and i + 1."""
    h = samples.time[i + 1] - samples.time[i]
    t = fraction
    t2 = t * t
    t3 = t2 * t
    a = 2.0 * t3 - 3.0 * t2 + 1.0
    b = t3 - 2.0 * t2 + t
    c = t3 - t2
    for axis in range(3):
        pose[axis] = (
            a * samples.position[i, axis]
            + b * h * samples.velocity[i, axis]
            + (1.0 - a) * samples.position[i + 1, axis]
            + c * h * samples.velocity[i + 1, axis]
        )
    norm = 0.0
    for k in range(4):
        q = (1.0 - t) * samples.orientation[i, k] + t * samples.orientation[i + 1, k]
        pose[3 + k] = q
        norm += q * q
    norm = np.sqrt(norm)
    for k in range(4):
        pose[3 + k] /= norm
    pose[7] = _pressure(samples, i, t)
    pose[8] = 1.0 if samples.on_surface[i] else 0.0


@uncounted
def _pressure(samples, i, t):
    """Pressure between two samples; landing and leaving keep the slope of the touching side.

    A device says only that the tip was off at one sample and down at the next. Where the pressure
    rises on, its slope tells when the tip touched; without that, slow devices draw tails.
    """
    p = samples.pressure[i]
    q = samples.pressure[i + 1]
    h = samples.time[i + 1] - samples.time[i]
    if p <= 0.0 and q > 0.0 and i + 2 < samples.time.shape[0] and samples.joined[i + 2]:
        slope = (samples.pressure[i + 2] - q) / (samples.time[i + 2] - samples.time[i + 1]) * h
        if slope > q:
            return max(0.0, q + (t - 1.0) * slope)
    if q <= 0.0 and p > 0.0 and i > 0 and samples.joined[i]:
        slope = (samples.pressure[i - 1] - p) / (samples.time[i] - samples.time[i - 1]) * h
        if slope > p:
            return max(0.0, p - t * slope)
    return (1.0 - t) * p + t * q


@uncounted
def copy_stamp(source, target):
    """Let a stamp be as another is."""
    target.values[0] = source.values[0]
    for k in range(st.PROFILE_CELLS + 2):
        target.half_widths[k] = source.half_widths[k]
    for k in range(st.PROFILE_CELLS):
        for part in range(4):
            target.lines[k, part] = source.lines[k, part]

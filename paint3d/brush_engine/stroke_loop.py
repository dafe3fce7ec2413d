"""A whole stroke, sample by sample: interpolate the pose, place a stamp, sweep, deposit.

Between two samples the pose is a cubic in time, and the sweep is cut where the outline's fastest
point has gone far enough, so that neither the rate at which the device was read nor turning on the
spot leaves gaps or changes the ink (Guo 2015, section 3.2, by other means). Samples that lie closer
than the shortest sweep are passed by: a device that is read a thousand times a second costs no more
than the way that it goes, and its noise at rest gives no ink.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine import stamp as st
from paint3d.brush_engine.deposit import sweep_deposit
from paint3d.brush_engine.drag import drag_length
from paint3d.brush_engine.dynamics import drive
from paint3d.brush_engine.placement import place_stamp
from paint3d.brush_engine.stamp import Stamp, outline_motion
from paint3d.core.kernel import uncounted

__all__ = [
    "FINISHED",
    "FOOTPRINTS",
    "NEEDS_ROOM",
    "SAMPLES",
    "Progress",
    "Samples",
    "make_progress",
    "may_pass",
    "note_pose",
    "paint_samples",
]

SAMPLES, FOOTPRINTS = 0, 1  # counters

FINISHED = 0
NEEDS_ROOM = 1

_FINEST_STEP = 0.35  # of the paint's resolution: the shortest sweep, and how near samples count
_STEP_SHARE = 0.25  # of the footprint's smaller extent: the longest sweep
_BOW = 0.025  # of the paint's resolution: how far a sweep's chord may leave the path
_MOST_STEPS = 4096  # sweeps between two samples
_DRAG_STEPS = 40.0  # per length of slack


class Samples(NamedTuple):
    """N poses in the object's frame, ready to be interpolated."""

    time: NDArray  # (N,) s
    position: NDArray  # (N, 3) the place on the surface that the hand means, else root node P_m, mm
    velocity: NDArray  # (N, 3) mm/s, tangents of the cubic
    orientation: NDArray  # (N, 4) unit quaternions wxyz, neighbours in one hemisphere
    pressure: NDArray  # (N,) pe in [0, 1]; NaN: the depth follows from the position
    joined: NDArray  # (N,) bool: the pen moved on from the previous sample to this one
    on_surface: NDArray  # (N,) bool: the position is a place on the surface


class Progress(NamedTuple):
    """Where the stroke stands; filled in place, so that painting can be taken up again."""

    at: NDArray  # (3,) int64: interval, next sweep in it, sweeps in it
    before: Stamp
    after: Stamp
    noted: NDArray  # (8,) position mm, quaternion and pressure of the sample where `before` stands


def make_progress() -> Progress:
    """Nothing painted yet."""
    return Progress(np.zeros(3, np.int64), st.make_stamp(), st.make_stamp(), np.zeros(8))


@uncounted
def note_pose(samples, i, noted):
    """Remember sample i as the one where the last stamp stands."""
    for axis in range(3):
        noted[axis] = samples.position[i, axis]
    for k in range(4):
        noted[3 + k] = samples.orientation[i, k]
    noted[7] = samples.pressure[i]


@uncounted
def may_pass(samples, i, noted, tuft, resolution):
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
    return way < _FINEST_STEP * resolution


@uncounted
def _interpolate(samples, i, fraction, pose):
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
def _bow(samples, i, pose):
    """How far the path leaves its chord half-way between samples i and i + 1 (mm)."""
    _interpolate(samples, i, 0.5, pose)
    d2 = 0.0
    for axis in range(3):
        chord = 0.5 * (samples.position[i, axis] + samples.position[i + 1, axis])
        d2 += (pose[axis] - chord) ** 2
    return np.sqrt(d2)


@uncounted
def _sweeps(before, after, bow, dragged, tuft, resolution):
    """How many sweeps the way between two stamps is cut into."""
    a = before.values[0]
    b = after.values[0]
    extent = 1e30
    for values in (a, b):
        if values.touches > 0.0:
            extent = min(extent, values.tip - values.heel, 2.0 * values.widest)
        else:
            extent = 0.0
    step = max(_FINEST_STEP * resolution, _STEP_SHARE * extent)
    n = max(outline_motion(before, after) / step, np.sqrt(bow / (_BOW * resolution)))
    if dragged:
        slack = drag_length(b.descent, tuft.length, tuft.drag_fraction)
        n = max(n, _foot_motion(a, b) * _DRAG_STEPS / max(slack, resolution))
    return min(_MOST_STEPS, max(1, int(np.ceil(n))))


@uncounted
def _foot_motion(a, b):
    d2 = 0.0
    for axis in range(3):
        d2 += (b.foot[axis] - a.foot[axis]) ** 2
    return np.sqrt(d2)


@uncounted
def _copy(source, target):
    target.values[0] = source.values[0]
    for k in range(st.PROFILE_CELLS + 2):
        target.half_widths[k] = source.half_widths[k]
    for k in range(st.PROFILE_CELLS):
        for part in range(4):
            target.lines[k, part] = source.lines[k, part]


@uncounted
def paint_samples(
    samples, last, dragged, brush, curves, tree, field, ink, progress, counters, pose, room
):
    """Paint from where `progress` stands up to sample `last`.

    Parameters
    ----------
    samples : Samples
    last : int
        Stop when this sample is reached.
    dragged : bool
        Whether the surface pulls the tip or the pose's roll commands the azimuth.
    brush : Tuft
        As it is; `curves` drive it.
    curves : Curves
    tree, field, ink : NamedTuples of the contact tree, the refined mesh, the ink
    progress : Progress
    counters : (8,) int64
    pose : (9,) float64 scratch
    room : NamedTuple of scratch arrays

    Returns
    -------
    int
        FINISHED, or NEEDS_ROOM: call again after the mesh's arrays have grown.
    """
    at = progress.at
    before = progress.before
    after = progress.after
    while at[0] < last:
        i = at[0]
        if not samples.joined[i + 1]:
            before.values[0].touches = 0.0
            at[0] += 1
            at[1] = 0
            at[2] = 0
            continue
        if at[2] == 0:
            if samples.pressure[i] <= 0.0 and samples.pressure[i + 1] <= 0.0:
                before.values[0].touches = 0.0
                at[0] += 1
                continue
            counters[SAMPLES] += 1
            if before.values[0].touches > 0.0:
                if may_pass(samples, i + 1, progress.noted, brush, field.resolution):
                    at[0] += 1
                    continue
            else:
                _interpolate(samples, i, 0.0, pose)
                tuft = drive(samples, i, 0.0, pose, before, brush, ink, curves)
                place_stamp(pose, dragged, before, before, tuft, tree, field, counters, room)
                if samples.joined[i]:
                    before.values[0].touches = 0.0
                # else the stroke begins pressed: the footprint stands there from the start
            _interpolate(samples, i, 1.0, pose)
            tuft = drive(samples, i, 1.0, pose, before, brush, ink, curves)
            place_stamp(pose, dragged, before, after, tuft, tree, field, counters, room)
            at[1] = 1
            bow = _bow(samples, i, pose)
            at[2] = _sweeps(before, after, bow, dragged, tuft, field.resolution)
        tuft = drive(samples, i, 1.0, pose, before, brush, ink, curves)
        while at[1] <= at[2]:
            if at[2] > 1:  # a single sweep ends where the sample is: placed above
                _interpolate(samples, i, at[1] / at[2], pose)
                tuft = drive(samples, i, at[1] / at[2], pose, before, brush, ink, curves)
                place_stamp(pose, dragged, before, after, tuft, tree, field, counters, room)
            if after.values[0].touches > 0.0 or before.values[0].touches > 0.0:
                if not sweep_deposit(before, after, tuft, field, ink, counters, room):
                    return NEEDS_ROOM
                counters[FOOTPRINTS] += 1
            _copy(after, before)
            at[1] += 1
        note_pose(samples, i + 1, progress.noted)
        at[0] += 1
        at[1] = 0
        at[2] = 0
    return FINISHED

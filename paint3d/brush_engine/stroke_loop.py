"""A whole stroke, sample by sample: interpolate the pose, drive, place a stamp, sweep, deposit.

Between two samples the pose is a cubic in time. Samples that lie closer than the shortest sweep are
passed by: a device that is read a thousand times a second costs no more than the way that it goes,
and its noise at rest gives no ink.

What the hand does there drives what the brush is, as painters know it from MyPaint: any input may
drive any setting through a curve of straight pieces. Here each curve gives a factor, and a setting
is its own value times the factors of all inputs that drive it.

The sweep between two samples is cut where the outline's fastest point has gone far enough, so that
neither the rate at which the device was read nor turning on the spot leaves gaps or changes the ink
(Guo 2015, section 3.2, by other means).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.drag import drag_length
from paint3d.brush_engine.footprint import PROFILE_CELLS, Stamp, make_stamp, outline_motion
from paint3d.brush_engine.ink_transfer import InkField, sweep_deposit
from paint3d.brush_engine.placement import place_stamp
from paint3d.brush_engine.tuft import (
    CURVATURE,
    INK_LEFT,
    LOAD,
    N_INPUTS,
    PRESSURE,
    SPEED,
    SPREAD,
    STIFFNESS,
    TILT,
    WETNESS,
    Curves,
    Tuft,
)
from paint3d.core.kernel import kernel, uncounted
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.mesh.kernels.mesh_arrays import SurfaceField
from paint3d.pose.kernels.hand_path import fill_tangents, join_samples

__all__ = [
    "FINISHED",
    "FOOTPRINTS",
    "NEEDS_ROOM",
    "SAMPLES",
    "Canvas",
    "HeldBrush",
    "Progress",
    "Samples",
    "copy_stamp",
    "drive_factor",
    "end_interval",
    "foot_motion",
    "make_progress",
    "next_interval",
    "paint_samples",
    "place_at",
    "prepare_samples",
]

SAMPLES, FOOTPRINTS = 0, 1  # counters

FINISHED = 0
NEEDS_ROOM = 1

_FINEST_STEP = 0.35  # of the paint's resolution: the shortest sweep, and how near samples count
_STEP_FRACTION = 0.25  # of the footprint's smaller extent: the longest sweep
_BOW = 0.025  # of the paint's resolution: how far a sweep's chord may leave the path
_BENT = 1.5  # of it: how far an outline may turn and grow in a sweep
_MOST_STEPS = 4096  # sweeps between two samples
_DRAG_STEPS = 20.0  # per length of slack


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
    """Surface that is painted on, as kernels see it."""

    tree: ContactTree
    field: SurfaceField
    ink: InkField


class Progress(NamedTuple):
    """Progress of the stroke, filled in place, so that painting can be taken up again."""

    at: NDArray  # (3,) int64: interval, next sweep in it, sweeps in it
    before: Stamp
    after: Stamp
    noted: NDArray  # (8,) position mm, quaternion and pressure of the sample where `before` stands


@uncounted(error_model="numpy")
def prepare_samples(time_ns, origin_ns, orientation, way, samples, origins):
    """Fill what of samples follows from a path, once `pressure` and `on_surface` are there.

    Parameters
    ----------
    time_ns : (N,) int64
    origin_ns : int
        Time of the latest touch-down before the first sample, from which its time counts.
    orientation : (N, 4) float64
        Unit quaternions; their signs may differ from neighbour to neighbour.
    way : (N, 3) float64
    samples : Samples
    origins : (N,) int64
        Filled with the time of the latest touch-down before each sample.
    """
    join_samples(samples.pressure, samples.on_surface, samples.joined)
    latest, sign = origin_ns, 1.0
    for i in range(time_ns.shape[0]):
        if i > 0 and not samples.joined[i]:
            latest = time_ns[i]
        origins[i] = latest
        samples.time[i] = (time_ns[i] - latest) * 1e-9
        for axis in range(3):
            samples.position[i, axis] = way[i, axis]
        if i > 0:
            dot = 0.0
            for k in range(4):
                dot += orientation[i, k] * orientation[i - 1, k]
            sign = -sign if dot < 0.0 else sign
        for k in range(4):
            samples.orientation[i, k] = sign * orientation[i, k]
    fill_tangents(samples.time, samples.position, samples.joined, samples.velocity)


def make_progress() -> Progress:
    """Nothing painted yet."""
    return Progress(np.zeros(3, np.int64), make_stamp(), make_stamp(), np.zeros(8))


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
    end, noted = at[0] + 1, progress.noted  # the sample where the last stamp stands
    for axis in range(3):
        noted[axis] = samples.position[end, axis]
    for k in range(4):
        noted[3 + k] = samples.orientation[end, k]
    noted[7] = samples.pressure[end]
    at[0] += 1
    at[1] = 0
    at[2] = 0


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
    """Slope of the cubic between two samples at the fraction t of the way."""
    return (
        6.0 * (t - t * t) * mean
        + (1.0 - 4.0 * t + 3.0 * t * t) * first
        + ((3.0 * t * t - 2.0 * t) * last)
    )


@uncounted
def read_inputs(samples, i, t, pose, before, tuft, ink, inputs):
    """Fill the inputs (N_INPUTS,) at the fraction t of the way from sample i to the next.

    Pressure 0 to 1 (the last stamp's where the device has none), tilt to the surface at the last
    stamp (degrees), speed along the surface (mm/s), ink left of a full load, and how sharply the
    path turns on it (1/mm).
    """
    inputs[PRESSURE] = before.values[0].pressure if np.isnan(pose[7]) else pose[7]
    tilt = before.values[0].tilt
    inputs[TILT] = np.degrees(tilt) if tilt > 0.0 else 90.0
    h = samples.time[i + 1] - samples.time[i]
    normal = before.values[0].foot_normal
    normal_speed = normal_a = normal_b = normal_step = 0.0  # only what is along the surface counts
    for axis in range(3):
        step = samples.position[i + 1, axis] - samples.position[i, axis]
        a, b = samples.velocity[i, axis], samples.velocity[i + 1, axis]
        normal_speed += normal[axis] * _velocity(t, step / h, a, b)
        normal_a += normal[axis] * a
        normal_b += normal[axis] * b
        normal_step += normal[axis] * step
    speed2 = a2 = b2 = dot = chord2 = 0.0
    for axis in range(3):
        step = samples.position[i + 1, axis] - samples.position[i, axis]
        a, b = samples.velocity[i, axis], samples.velocity[i + 1, axis]
        speed2 += (_velocity(t, step / h, a, b) - normal_speed * normal[axis]) ** 2
        chord2 += (step - normal_step * normal[axis]) ** 2
        a -= normal_a * normal[axis]
        b -= normal_b * normal[axis]
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
def drive_factor(curves, setting):
    """By how much the inputs of the curves, as they are, drive a setting."""
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
    stiffness = drive_factor(curves, STIFFNESS)
    ink.transfer[0].capacity = tuft.load / drive_factor(curves, WETNESS)
    return Tuft(
        tuft.arcs,
        tuft.diameters,
        tuft.spine,
        tuft.reach,
        tuft.openness,
        tuft.spheres,
        tuft.taper,
        tuft.point,
        tuft.lowest_tilt,
        tuft.greatest_fraction,
        tuft.length,
        min(tuft.full_press / stiffness, tuft.greatest_fraction * tuft.length),
        tuft.spring * stiffness,
        tuft.max_force,
        tuft.spread * drive_factor(curves, SPREAD),
        tuft.load,
        tuft.transfer_per_mm * drive_factor(curves, LOAD),
        tuft.drag_fraction,
        tuft.plasticity,
    )


@uncounted
def copy_stamp(source, target):
    """Copy a stamp into another."""
    target.values[0] = source.values[0]
    for k in range(PROFILE_CELLS + 2):
        target.half_widths[k] = source.half_widths[k]
    for part in range(2):
        for k in range(PROFILE_CELLS):
            target.lines[part, k] = source.lines[part, k]


@uncounted
def place_at(samples, i, fraction, brush, canvas, before, after, scratch):
    """Place a footprint at a fraction of the way from sample i to the next; return the driven tuft.

    `before` is the stamp that the brush comes from, and may be `after`, which is filled.
    """
    pose = scratch.pose
    _interpolate(samples, i, fraction, pose)
    tuft = drive(samples, i, fraction, pose, before, brush.tuft, canvas.ink, brush.curves)
    place_stamp(pose, brush.dragged, before, after, tuft, canvas.tree, canvas.field, scratch)
    speed2 = 0.0
    for axis in range(3):
        a, b = samples.velocity[i, axis], samples.velocity[i + 1, axis]
        speed2 += (a + fraction * (b - a)) ** 2
    after.values[0].speed = np.sqrt(speed2)
    after.values[0].time = samples.time[i] + fraction * (samples.time[i + 1] - samples.time[i])
    return tuft


@uncounted
def _bow(samples, i, pose):
    """Distance of the path from its chord half-way between samples i and i + 1 (mm)."""
    _interpolate(samples, i, 0.5, pose)
    d2 = 0.0
    for axis in range(3):
        chord = 0.5 * (samples.position[i, axis] + samples.position[i + 1, axis])
        d2 += (pose[axis] - chord) ** 2
    return np.sqrt(d2)


@uncounted
def _sweeps(before, after, bow, dragged, tuft, resolution):
    """Number of sweeps into which the way between two stamps is cut."""
    a = before.values[0]
    b = after.values[0]
    extent = 1e30
    for values in (a, b):
        if values.touches > 0.0:
            extent = min(extent, values.tip - values.heel, 2.0 * values.widest)
        else:
            extent = 0.0
    step = max(_FINEST_STEP * resolution, _STEP_FRACTION * extent)
    n = max(outline_motion(before, after) / step, np.sqrt(bow / (_BOW * resolution)))
    if a.touches > 0.0 and b.touches > 0.0:
        n = max(n, _bent(a, b) / (_BENT * resolution))
    if dragged:
        slack = drag_length(b.descent, tuft.length, tuft.drag_fraction)
        n = max(n, foot_motion(a, b) * _DRAG_STEPS / max(slack, resolution))
    return min(_MOST_STEPS, max(1, int(np.ceil(n))))


@uncounted
def _bent(a, b):
    """Motion of an outline's ends by its turn and its growth between two stamps' geometries, mm.

    The turn moves one end about the other by an arc of the longer outline; the growth is that of
    the length or of the breadth, whichever is more.
    """
    sine = cosine = 0.0
    for axis in range(3):
        sine += b.bend[axis] * a.cross[axis]
        cosine += b.bend[axis] * a.bend[axis]
    length, length_then = a.tip - a.heel, b.tip - b.heel
    grown = max(abs(length_then - length), 2.0 * abs(b.widest - a.widest))
    return abs(np.arctan2(sine, cosine)) * max(length, length_then) + grown


@uncounted
def foot_motion(a, b):
    """Distance that the foot point moved between the geometries of two stamps, mm."""
    d2 = 0.0
    for axis in range(3):
        d2 += (b.foot[axis] - a.foot[axis]) ** 2
    return np.sqrt(d2)


@uncounted(forceinline=True)
def _begin(samples, i, brush, canvas, progress, scratch):
    """Place the footprints at both ends of an interval, and cut the way between them."""
    at, before, after = progress.at, progress.before, progress.after
    if before.values[0].touches <= 0.0:
        place_at(samples, i, 0.0, brush, canvas, before, before, scratch)
        if samples.joined[i]:
            before.values[0].touches = 0.0
        # else the stroke begins pressed: the footprint stands there from the start
    tuft = place_at(samples, i, 1.0, brush, canvas, before, after, scratch)
    at[1] = 1
    bow = _bow(samples, i, scratch.pose)
    at[2] = _sweeps(before, after, bow, brush.dragged, tuft, canvas.field.resolution)


@uncounted
def paint_samples(samples, last, brush, canvas, progress, scratch):
    """Paint from where `progress` stands up to sample `last`.

    Parameters
    ----------
    samples : Samples
    last : int
        Stop when this sample is reached.
    brush : HeldBrush
    canvas : Canvas
    progress : Progress
    scratch : Scratch

    Returns
    -------
    int
        FINISHED, or NEEDS_ROOM: call again after the mesh's arrays have grown.
    """
    at, before, after, pose = progress.at, progress.before, progress.after, scratch.pose
    field, ink = canvas.field, canvas.ink
    while True:
        i = next_interval(samples, last, brush.tuft, field.resolution, progress, scratch.counters)
        if i < 0:
            return FINISHED
        if at[2] == 0:
            _begin(samples, i, brush, canvas, progress, scratch)
        tuft = drive(samples, i, 1.0, pose, before, brush.tuft, ink, brush.curves)
        while at[1] <= at[2]:
            if at[2] > 1:  # a single sweep ends where the sample is: placed above
                fraction = at[1] / at[2]
                tuft = place_at(samples, i, fraction, brush, canvas, before, after, scratch)
            if after.values[0].touches > 0.0 or before.values[0].touches > 0.0:
                if not sweep_deposit(before, after, tuft, field, ink, scratch):
                    return NEEDS_ROOM
                scratch.counters[FOOTPRINTS] += 1
            copy_stamp(after, before)
            at[1] += 1
        end_interval(samples, progress)

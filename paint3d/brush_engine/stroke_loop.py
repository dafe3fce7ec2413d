"""A whole stroke, sample by sample: interpolate the pose, place a stamp, sweep, deposit.

The sweep between two samples is cut where the outline's fastest point has gone far enough, so that
neither the rate at which the device was read nor turning on the spot leaves gaps or changes the ink
(Guo 2015, section 3.2, by other means).
"""

from __future__ import annotations

import numpy as np

from paint3d.brush_engine.deposit import sweep_deposit
from paint3d.brush_engine.drag import drag_length
from paint3d.brush_engine.dynamics import drive
from paint3d.brush_engine.intervals import (
    FINEST_STEP,
    FINISHED,
    FOOTPRINTS,
    NEEDS_ROOM,
    copy_stamp,
    end_interval,
    interpolate,
    next_interval,
)
from paint3d.brush_engine.placement import place_stamp
from paint3d.brush_engine.stamp import outline_motion
from paint3d.core.kernel import uncounted

__all__ = ["paint_samples"]

_STEP_SHARE = 0.25  # of the footprint's smaller extent: the longest sweep
_BOW = 0.025  # of the paint's resolution: how far a sweep's chord may leave the path
_MOST_STEPS = 4096  # sweeps between two samples
_DRAG_STEPS = 40.0  # per length of slack


@uncounted
def _bow(samples, i, pose):
    """How far the path leaves its chord half-way between samples i and i + 1 (mm)."""
    interpolate(samples, i, 0.5, pose)
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
    step = max(FINEST_STEP * resolution, _STEP_SHARE * extent)
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


@uncounted(forceinline=True)
def _begin(samples, i, brush, canvas, progress, scratch):
    """Place the footprints at both ends of an interval, and cut the way between them."""
    at, before, after, pose = progress.at, progress.before, progress.after, scratch.pose
    tree, field, ink = canvas.tree, canvas.field, canvas.ink
    if before.values[0].touches <= 0.0:
        interpolate(samples, i, 0.0, pose)
        tuft = drive(samples, i, 0.0, pose, before, brush.tuft, ink, brush.curves)
        place_stamp(pose, brush.dragged, before, before, tuft, tree, field, scratch)
        if samples.joined[i]:
            before.values[0].touches = 0.0
        # else the stroke begins pressed: the footprint stands there from the start
    interpolate(samples, i, 1.0, pose)
    tuft = drive(samples, i, 1.0, pose, before, brush.tuft, ink, brush.curves)
    place_stamp(pose, brush.dragged, before, after, tuft, tree, field, scratch)
    at[1] = 1
    bow = _bow(samples, i, pose)
    at[2] = _sweeps(before, after, bow, brush.dragged, tuft, field.resolution)


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
    tree, field, ink = canvas.tree, canvas.field, canvas.ink
    while True:
        i = next_interval(samples, last, brush.tuft, field.resolution, progress, scratch.counters)
        if i < 0:
            return FINISHED
        if at[2] == 0:
            _begin(samples, i, brush, canvas, progress, scratch)
        tuft = drive(samples, i, 1.0, pose, before, brush.tuft, ink, brush.curves)
        while at[1] <= at[2]:
            if at[2] > 1:  # a single sweep ends where the sample is: placed above
                share = at[1] / at[2]
                interpolate(samples, i, share, pose)
                tuft = drive(samples, i, share, pose, before, brush.tuft, ink, brush.curves)
                place_stamp(pose, brush.dragged, before, after, tuft, tree, field, scratch)
            if after.values[0].touches > 0.0 or before.values[0].touches > 0.0:
                if not sweep_deposit(before, after, tuft, field, ink, scratch):
                    return NEEDS_ROOM
                scratch.counters[FOOTPRINTS] += 1
            copy_stamp(after, before)
            at[1] += 1
        end_interval(samples, progress)

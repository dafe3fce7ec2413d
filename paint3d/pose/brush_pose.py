"""Poses of the brush in the object's frame, and their interpolation between samples.

object_from_pen = inverse(world_from_object) world_from_pen, for every sample. Painting depends on
this product alone, so moving both hands together changes nothing.

Positions follow cubic Hermite curves in time, with tangents from the parabola through three
samples, limited so that no interval overshoots; orientations turn along the shorter arc, and
pressures change linearly. Gaps are not embellished: a lone interval longer than 100 ms is straight,
and an interval with the pen up at both ends is not joined.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, lengths_of
from paint3d.core.quaternion import multiply_quaternions, rotate
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.errors import RecordingError

__all__ = [
    "BrushPath",
    "brush_poses",
    "contacts_of",
    "joined_samples",
    "object_poses",
    "velocities",
]

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])
_MAX_CURVED_GAP_S = 0.1
"""Longer intervals than this are bridged by a straight line (two periods of a 20 Hz device)."""
_STEEPEST = 3.0
"""Tangents of at most three chord speeds cannot overshoot (Fritsch and Carlson 1980)."""


@dataclass(frozen=True, eq=False)
class BrushPath:
    """N poses of the brush in the object's frame.

    Attributes
    ----------
    time_s : (N,) float64
        Strictly increasing, s, from the first sample.
    position : (N, 3) float64
        The tuft's root, mm.
    orientation : (N, 4) float64
        object_from_pen, unit quaternions, w first.
    pressure : (N,) float64 in [0, 1], or None
    buttons : (N,) int32
    contact : (N, 3) float64, or None
        Intended contact points on the surface, mm; rows of NaN for samples without one.
    """

    time_s: NDArray[np.float64]
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: NDArray[np.float64] | None
    buttons: NDArray[np.int32]
    contact: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def has_contact(self) -> NDArray[np.bool_]:
        """(N,) bool: which samples have an intended contact point."""
        if self.contact is None:
            return np.zeros(len(self), bool)
        return ~np.isnan(self.contact[:, 0])

    @property
    def way(self) -> AnyArray:
        """(N, 3) path of the stroke, mm: the intended contact points, else the tuft's root."""
        if self.contact is None:
            return self.position
        return np.where(self.has_contact[:, None], self.contact, self.position)


def brush_poses(recording: Recording) -> BrushPath:
    """Compute the poses of a recording's brush in the object's frame.

    Raises
    ------
    RecordingError
        If the recording is a pad's, which must be mapped onto a surface first.
    """
    if recording.is_pad:
        raise RecordingError(
            "the recording's space is 'pad'; expected 'world' (lay it on a surface first)"
        )
    return _path(
        recording.time_ns,
        recording.position,
        recording.orientation,
        recording.pressure,
        recording.buttons,
        recording.object_position,
        recording.object_orientation,
        recording.contact,
    )


def object_poses(samples: Sequence[DeviceSample]) -> BrushPath:
    """Compute the poses of live samples; time counts from the first.

    Raises
    ------
    RecordingError
        If there are none, time does not increase, or only some have a pressure.
    """
    if not samples:
        raise RecordingError("there are no samples; expected at least one")
    times = np.array([sample.time_ns for sample in samples], dtype=np.int64)
    late = times[1:] <= times[:-1]
    if late.any():
        i = int(np.flatnonzero(late)[0]) + 1
        raise RecordingError(
            "sample {i}: time_ns is {times}; expected over {i_times}",
            i=i,
            times=times[i],
            i_times=times[i - 1],
        )
    pressures = [sample.pressure for sample in samples]
    n_given = sum(pressure is not None for pressure in pressures)
    if n_given not in (0, len(samples)):
        raise RecordingError(
            "{n_given} of {n} samples have a pressure; expected all or none",
            n_given=n_given,
            n=len(samples),
        )
    return _path(
        times,
        np.array([sample.position for sample in samples], dtype=np.float64),
        np.array([sample.orientation for sample in samples], dtype=np.float64),
        np.array(pressures, dtype=np.float64) if n_given else None,
        np.array([sample.buttons for sample in samples], dtype=np.int32),
        np.array([sample.object_position for sample in samples], dtype=np.float64),
        np.array([sample.object_orientation for sample in samples], dtype=np.float64),
        contacts_of(samples),
    )


def contacts_of(samples: Sequence[DeviceSample]) -> AnyArray | None:
    """Intended contact points (N, 3) of samples, NaN for none; None if no sample has one."""
    if all(sample.contact is None for sample in samples):
        return None
    none = np.full(3, np.nan)
    return np.array([none if s.contact is None else s.contact for s in samples], np.float64)


def _path(
    time_ns: AnyArray,
    position: AnyArray,
    orientation: AnyArray,
    pressure: AnyArray | None,
    buttons: AnyArray,
    object_position: AnyArray,
    object_orientation: AnyArray,
    contact: AnyArray | None,
) -> BrushPath:
    object_from_world = object_orientation * _CONJUGATE
    turned = multiply_quaternions(object_from_world, orientation)
    return BrushPath(
        (time_ns - time_ns[0]) * 1e-9,
        rotate(object_from_world, position - object_position),
        turned / lengths_of(turned)[:, None],
        pressure,
        buttons,
        None if contact is None else rotate(object_from_world, contact - object_position),
    )


def joined_samples(path: BrushPath) -> AnyArray:
    """Find which samples (N,) bool are joined by a stroke to the one before.

    Not joined are the first sample, an interval with pressure 0 at both ends, and one with an
    intended contact point at only one end.
    """
    joined = np.ones(len(path), dtype=bool)
    joined[0] = False
    if path.pressure is not None:
        joined[1:] = (path.pressure[1:] > 0.0) | (path.pressure[:-1] > 0.0)
    has_contact = path.has_contact
    joined[1:] &= has_contact[1:] == has_contact[:-1]
    return joined


def velocities(path: BrushPath, joined: NDArray[np.bool_]) -> AnyArray:
    """Tangents of the cubics along `BrushPath.way` in mm/s, (N, 3).

    The derivative of the parabola through a sample and its two neighbours; at the ends of a
    stroke, of that through the last three samples; with two samples, the chord. A sample at
    the end of an interval longer than 100 ms takes that chord's velocity (between two such, 0).
    No tangent is longer than three times the slower of its two chords. A tangent depends only on
    samples up to two away, so a path can be painted as it comes in.

    Parameters
    ----------
    path : BrushPath
    joined : (N,) bool
        From `joined_samples`.
    """
    n = len(path)
    velocity = np.zeros((n, 3))
    if n < 2:
        return velocity
    time, way = path.time_s, path.way
    steps = np.where(joined[1:], time[1:] - time[:-1], 1.0)  # the others are not used
    chords = (way[1:] - way[:-1]) / steps[:, None]
    curved = joined[1:] & (steps <= _MAX_CURVED_GAP_S)
    left, right = np.zeros(n, bool), np.zeros(n, bool)
    left[1:] = right[:-1] = curved
    i = np.flatnonzero(left & right)
    # Each chord is weighted by the other's duration:
    total = (steps[i] + steps[i - 1])[:, None]
    velocity[i] = (steps[i][:, None] * chords[i - 1] + steps[i - 1][:, None] * chords[i]) / total
    _set_ends(velocity, chords, steps, curved, np.flatnonzero(right & ~left), 1)
    _set_ends(velocity, chords, steps, curved, np.flatnonzero(left & ~right), -1)
    straight = joined[1:] & ~curved
    before, after = np.zeros(n, bool), np.zeros(n, bool)
    before[1:] = after[:-1] = straight
    one = np.flatnonzero(after & ~before)
    velocity[one] = chords[one]
    one = np.flatnonzero(before & ~after)
    velocity[one] = chords[one - 1]
    velocity[before & after] = 0.0
    return velocity * _limit(velocity, chords, joined)[:, None]


def _set_ends(
    velocity: AnyArray,
    chords: AnyArray,
    steps: AnyArray,
    curved: AnyArray,
    ends: AnyArray,
    side: int,
) -> None:
    """Fill the tangents at `ends` of curved runs that lie after (`side` 1) or before them (-1)."""
    near = ends if side == 1 else ends - 1
    far = np.minimum(np.maximum(near + side, 0), len(chords) - 1)
    has_far = (far == near + side) & curved[far]
    weight = np.where(has_far, steps[near] / (steps[near] + steps[far]), 0.0)
    velocity[ends] = chords[near] + (chords[near] - chords[far]) * weight[:, None]


def _limit(velocity: AnyArray, chords: AnyArray, joined: AnyArray) -> AnyArray:
    """Factors (N,) in [0, 1] that keep the tangents from overshooting."""
    speed = lengths_of(chords)
    speed[~joined[1:]] = np.inf
    slowest = np.full(len(velocity), np.inf)
    slowest[1:] = speed
    slowest[:-1] = np.minimum(slowest[:-1], speed)
    length = lengths_of(velocity)
    over = length > _STEEPEST * slowest
    return np.where(over, _STEEPEST * slowest, 1.0) / np.where(over, length, 1.0)

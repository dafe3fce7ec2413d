"""Two hands, one pose: the brush in the object's frame, and what it did between two samples.

object_from_pen = inverse(world_from_object) world_from_pen, for every sample. Painting only
ever sees this product, so moving both hands together changes nothing.

Positions follow cubic Hermite curves in time, with tangents from the parabola through three
samples, cut back so that no interval overshoots; orientations turn along the shorter arc, and
pressures change linearly. Nothing is made up where nothing is known: a lone interval longer
than 100 ms is straight, and while the pen is up at both of its ends an interval is not joined.
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
        Places on the surface that the hand meant, mm; rows of NaN where it said none.
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
        """(N,) bool: whether the hand said which place on the surface it meant."""
        if self.contact is None:
            return np.zeros(len(self), bool)
        return ~np.isnan(self.contact[:, 0])

    @property
    def way(self) -> AnyArray:
        """(N, 3) what moves along the stroke, mm: the place on the surface, else the root."""
        if self.contact is None:
            return self.position
        return np.where(self.has_contact[:, None], self.contact, self.position)


def brush_poses(recording: Recording) -> BrushPath:
    """The poses of a recording's brush in the frame of its object.

    Raises
    ------
    RecordingError
        If the recording lies on a pad: it must be laid on a surface first.
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
    """The poses of live samples; time counts from the first of them.

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
        raise RecordingError(f"sample {i}: time_ns is {times[i]}; expected over {times[i - 1]}")
    pressures = [sample.pressure for sample in samples]
    n_given = sum(pressure is not None for pressure in pressures)
    if n_given not in (0, len(samples)):
        raise RecordingError(
            f"{n_given} of {len(samples)} samples have a pressure; expected all or none"
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
    """(N, 3) the places on the surface that samples mean, rows of NaN for none; None if all are."""
    if all(sample.contact is None for sample in samples):
        return None
    nowhere = np.full(3, np.nan)
    return np.array([nowhere if s.contact is None else s.contact for s in samples], np.float64)


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
    """Whether the pen came to each sample from the one before it: (N,) bool.

    False for the first sample, where the pressure is 0 at both ends of the interval, and where only
    one of them says which place on the surface is meant.
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
    stroke that through the three last samples; the chord's where there are two. A sample at
    the end of an interval longer than 100 ms takes that chord's velocity (between two such, 0).
    No tangent is longer than three times the slower of its two chords. Only samples up to two
    away matter, so a path may be painted as it comes in.

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
    steps = np.where(joined[1:], time[1:] - time[:-1], 1.0)  # others are not asked for
    chords = (way[1:] - way[:-1]) / steps[:, None]
    curved = joined[1:] & (steps <= _MAX_CURVED_GAP_S)
    left, right = np.zeros(n, bool), np.zeros(n, bool)
    left[1:] = right[:-1] = curved
    i = np.flatnonzero(left & right)
    velocity[i] = _weighted(chords[i - 1], chords[i], steps[i], steps[i - 1])
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
    return velocity * _cut(velocity, chords, joined)[:, None]


def _weighted(a: AnyArray, b: AnyArray, weight_a: AnyArray, weight_b: AnyArray) -> AnyArray:
    total = (weight_a + weight_b)[:, None]
    result: AnyArray = (weight_a[:, None] * a + weight_b[:, None] * b) / total
    return result


def _set_ends(
    velocity: AnyArray,
    chords: AnyArray,
    steps: AnyArray,
    curved: AnyArray,
    ends: AnyArray,
    way: int,
) -> None:
    """Fill the tangents of samples that end a curved run; `way` is 1 where it goes on after."""
    near = ends if way == 1 else ends - 1
    far = np.minimum(np.maximum(near + way, 0), len(chords) - 1)
    known = (far == near + way) & curved[far]
    share = np.where(known, steps[near] / (steps[near] + steps[far]), 0.0)
    velocity[ends] = chords[near] + (chords[near] - chords[far]) * share[:, None]


def _cut(velocity: AnyArray, chords: AnyArray, joined: AnyArray) -> AnyArray:
    """Factors (N,) in [0, 1] that keep the tangents from overshooting."""
    speed = lengths_of(chords)
    speed[~joined[1:]] = np.inf
    slowest = np.full(len(velocity), np.inf)
    slowest[1:] = speed
    slowest[:-1] = np.minimum(slowest[:-1], speed)
    length = lengths_of(velocity)
    over = length > _STEEPEST * slowest
    return np.where(over, _STEEPEST * slowest, 1.0) / np.where(over, length, 1.0)

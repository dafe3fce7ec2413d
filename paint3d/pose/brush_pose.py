"""Poses of the brush in the object's frame, and their interpolation between samples.

object_from_pen = inverse(world_from_object) world_from_pen, for every sample. Painting depends on
this product alone, so moving both hands together changes nothing.

Positions follow cubic Hermite curves in time, with tangents from the parabola through three
samples, limited so that no interval overshoots; orientations turn along the shorter arc, and
pressures change linearly. Gaps are not embellished: a lone interval longer than 100 ms is straight,
and an interval with the pen up at both ends is not joined.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.errors import RecordingError
from paint3d.pose.kernels.hand_path import (
    carry_points,
    carry_to_object,
    fill_tangents,
    join_samples,
)

__all__ = [
    "BrushPath",
    "brush_poses",
    "contacts_of",
    "joined_samples",
    "object_poses",
    "velocities",
]


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
    def pressures(self) -> NDArray[np.float64]:
        """(N,) float64, NaN where the device has none."""
        if self.pressure is None:
            return np.full(len(self), np.nan)
        return _rows(self.pressure)

    @property
    def has_contact(self) -> NDArray[np.bool_]:
        """(N,) bool: which samples have an intended contact point."""
        if self.contact is None:
            return np.zeros(len(self), bool)
        return ~np.isnan(self.contact[:, 0])

    @property
    def points(self) -> AnyArray:
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
    times = [sample.time_ns for sample in samples]
    i = next((k for k in range(1, len(times)) if times[k] <= times[k - 1]), 0)
    if i:
        raise RecordingError(
            "sample {i}: time_ns is {times}; expected over {i_times}",
            i=i,
            times=times[i],
            i_times=times[i - 1],
        )
    pressures = [sample.pressure for sample in samples]
    n_given = len(pressures) - pressures.count(None)
    if n_given not in (0, len(samples)):
        raise RecordingError(
            "{n_given} of {n} samples have a pressure; expected all or none",
            n_given=n_given,
            n=len(samples),
        )
    parts = [  # joined by one call: for a few samples calls take longer than numbers
        part for s in samples
        for part in (s.position, s.orientation, s.object_position, s.object_orientation)
    ]  # fmt: skip
    rows = np.concatenate(parts, dtype=np.float64).reshape(len(samples), 14)
    return _path(
        np.array(times, dtype=np.int64),
        rows[:, :3],
        rows[:, 3:7],
        np.array(pressures, dtype=np.float64) if n_given else None,
        np.array([sample.buttons for sample in samples], dtype=np.int32),
        rows[:, 7:10],
        rows[:, 10:],
        contacts_of(samples),
    )


def contacts_of(samples: Sequence[DeviceSample]) -> AnyArray | None:
    """Collect the intended contact points (N, 3), NaN for none; None if no sample has one."""
    if all(sample.contact is None for sample in samples):
        return None
    none = (math.nan, math.nan, math.nan)
    contacts = [none if s.contact is None else s.contact for s in samples]
    return np.concatenate(contacts, dtype=np.float64).reshape(len(samples), 3)


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
    """Transform samples from the world into the object's frame; arrays as in `Recording`."""
    origin, frame = _rows(object_position), _rows(object_orientation)
    turned = np.empty((len(time_ns), 4))
    carry_to_object(_rows(orientation), frame, turned)
    return BrushPath(
        (time_ns - time_ns[0]) * 1e-9,
        _carried(position, origin, frame),
        turned,
        pressure,
        buttons,
        None if contact is None else _carried(contact, origin, frame),
    )


def _rows(array: AnyArray) -> NDArray[np.float64]:
    return np.ascontiguousarray(array, np.float64)


def _carried(points: AnyArray, origin: AnyArray, frame: AnyArray) -> NDArray[np.float64]:
    out = np.empty((len(points), 3))
    carry_points(_rows(points), origin, frame, out)
    return out


def joined_samples(path: BrushPath) -> AnyArray:
    """Find which samples (N,) bool are joined by a stroke to the one before.

    Not joined are the first sample, an interval with pressure 0 at both ends, and one with an
    intended contact point at only one end.
    """
    joined = np.empty(len(path), bool)
    join_samples(path.pressures, path.has_contact, joined)
    return joined


def velocities(path: BrushPath, joined: NDArray[np.bool_]) -> AnyArray:
    """Compute the tangents of the cubics along `BrushPath.points` in mm/s, (N, 3).

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
    velocity = np.empty((len(path), 3))
    fill_tangents(path.time_s, _rows(path.points), joined, velocity)
    return velocity

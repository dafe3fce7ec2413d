"""Two hands, one pose: the brush in the object's frame.

object_from_pen = inverse(world_from_object) world_from_pen, for every sample. Painting only
ever sees this product, so moving both hands together changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.frames import multiply_quaternions, rotate
from paint3d.core.types import AnyArray
from paint3d.device.recorded import Recording
from paint3d.device.sample import DeviceSample
from paint3d.errors import RecordingError

__all__ = ["BrushPath", "brush_poses", "contacts_of", "object_poses"]

_CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


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
    if (np.diff(times) <= 0).any():
        i = int(np.flatnonzero(np.diff(times) <= 0)[0]) + 1
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
        turned / np.linalg.norm(turned, axis=1, keepdims=True),
        pressure,
        buttons,
        None if contact is None else rotate(object_from_world, contact - object_position),
    )

"""Readings of devices at one instant: a stylus in its own frame, and both hands in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["BARREL", "DIP", "ERASER", "DeviceSample", "StylusReading"]

BARREL, DIP, ERASER = 1, 2, 4
"""Bits of `buttons`: the first button, the one that dips the brush, and the eraser end."""


@dataclass(frozen=True, eq=False, slots=True)
class StylusReading:
    """One reading of the right hand's device.

    Attributes
    ----------
    time_ns : int
        Monotonic clock of this machine when the report was read.
    position : (3,) float64
        mm in the device's frame: the tuft's root for a device with six degrees of freedom, the
        point on the pad (z its hover height) for a tablet.
    orientation : (4,) float64
        device_from_pen, unit quaternion, w first: pen z runs up the handle, x is the direction in
        which the tip bends.
    pressure : float or None
        0 to 1; None if the device only measures its pose.
    buttons : int
        Bit field; see `BARREL`, `DIP`, `ERASER`.
    in_range : bool
        False when the pen has left the pad; the pose is then meaningless.
    """

    time_ns: int
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    buttons: int = 0
    in_range: bool = True


@dataclass(frozen=True, eq=False)
class DeviceSample:
    """One reading of the two hands.

    Attributes
    ----------
    time_ns : int
        Time in ns from an arbitrary origin.
    position : (3,) float64
        The tuft's root in the world, mm.
    orientation : (4,) float64
        world_from_pen, unit quaternion, w first: the pen's z axis runs from tip to root (up the
        handle), its x axis is the direction in which the tip bends.
    pressure : float or None
        Force over the greatest device force (7.9 N), 0 to 1; None where the device has none.
    buttons : int
        Bit field of the buttons held down.
    object_position : (3,) float64
        Origin of the object's frame in the world, mm.
    object_orientation : (4,) float64
        world_from_object, unit quaternion, w first.
    contact : (3,) float64 or None
        The intended contact point on the surface, in the world, mm: the footprint is centred there.
        None if the device only measures its pose.
    """

    time_ns: int
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    buttons: int
    object_position: NDArray[np.float64]
    object_orientation: NDArray[np.float64]
    contact: NDArray[np.float64] | None = None

"""What both hands do at one instant, whatever devices they hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["DeviceSample"]


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
        The place on the surface that the hand means, in the world, mm: the middle of the footprint
        comes to lie there. None where a device only says where its pen is.
    """

    time_ns: int
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    buttons: int
    object_position: NDArray[np.float64]
    object_orientation: NDArray[np.float64]
    contact: NDArray[np.float64] | None = None

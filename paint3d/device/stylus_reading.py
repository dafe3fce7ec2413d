"""What a stylus says at one instant, in its own frame, whatever kind of stylus it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["BARREL", "DIP", "ERASER", "StylusReading"]

BARREL, DIP, ERASER = 1, 2, 4
"""Bits of `buttons`: the first button, the one that dips the brush, and the turned-round end."""


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
        device_from_pen, unit quaternion, w first: pen z runs up the handle, x is where the tip
        bends.
    pressure : float or None
        0 to 1; None where the device only says where it is.
    buttons : int
        Bit field; see `BARREL`, `DIP`, `ERASER`.
    in_range : bool
        False when the pen has left the pad: the reading's pose then means nothing.
    """

    time_ns: int
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    buttons: int = 0
    in_range: bool = True

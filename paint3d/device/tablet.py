"""Pen tablets as the window system gives them (Qt's QTabletEvent), to readings.

Pure: the numbers of the event go in. Reading tablets this way works with every driver; raw HID
(`paint3d.device.digitizer`) is for those that speak the standard page.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from paint3d.device.pen_angles import orientation_from_tilt
from paint3d.device.stylus_reading import BARREL, DIP, ERASER, StylusReading
from paint3d.errors import DeviceError

__all__ = ["TabletEvent", "tablet_reading"]


@dataclass(frozen=True, slots=True)
class TabletEvent:
    """One QTabletEvent.

    Attributes
    ----------
    time_ns : int
    x, y : float
        Place in pixels, y downwards.
    pressure : float
        0 to 1.
    x_tilt, y_tilt : float
        Degrees: positive leans to the right, and towards the user.
    rotation : float
        Degrees clockwise about the pen's own axis.
    eraser : bool
        The pen is turned round.
    barrel, second : bool
        The pen's buttons.
    """

    time_ns: int
    x: float
    y: float
    pressure: float = 0.0
    x_tilt: float = 0.0
    y_tilt: float = 0.0
    rotation: float = 0.0
    eraser: bool = False
    barrel: bool = False
    second: bool = False


def tablet_reading(event: TabletEvent, mm_per_pixel: float, height_px: float) -> StylusReading:
    """The reading in mm, y upwards from the lower edge of an area of this height.

    Raises
    ------
    DeviceError
        If a number is not finite or the pressure is not 0 to 1.
    """
    numbers = (event.x, event.y, event.pressure, event.x_tilt, event.y_tilt, event.rotation)
    if not all(map(math.isfinite, (*numbers, mm_per_pixel, height_px))):
        raise DeviceError(f"a tablet event with {numbers}; expected finite numbers")
    if not 0.0 <= event.pressure <= 1.0:
        raise DeviceError(f"a tablet event's pressure is {event.pressure:g}; expected 0 to 1")
    return StylusReading(
        event.time_ns,
        np.array([event.x * mm_per_pixel, (height_px - event.y) * mm_per_pixel, 0.0]),
        orientation_from_tilt(
            math.radians(event.x_tilt),
            -math.radians(event.y_tilt),
            -math.radians(event.rotation),
        ),
        event.pressure,
        (BARREL if event.barrel else 0)
        | (DIP if event.second else 0)
        | (ERASER if event.eraser else 0),
    )

"""Mouse and tablet events as one kind of reading, whatever they came from."""

from __future__ import annotations

import math
from dataclasses import dataclass

from PySide6 import QtCore, QtGui

__all__ = ["Touch", "pressure_of_contact", "touch_of_mouse", "touch_of_tablet"]

_ERASER = QtGui.QPointingDevice.PointerType.Eraser
_LEAST_MM, _LIGHT_MM, _FIRM_MM = 2.0, 4.0, 16.0  # across the contact of a fingertip
_CAN = QtGui.QInputDevice.Capability
_LEFT = QtCore.Qt.MouseButton.LeftButton


@dataclass(frozen=True)
class Touch:
    """Where a mouse or pen is, and how it is held.

    Attributes
    ----------
    time_ns : int
        When it happened, by `EventClock`.
    x, y : float
        In the canvas, its pixels as the window system counts them, y down.
    pressure : float or None
        0 to 1; None from a mouse, and from a finger on a screen that does not say.
    tilt_x, tilt_y : float
        How far the pen leans to the right and toward the user, rad; 0 upright.
    twist : float
        About its axis, rad.
    down : bool
        Whether it touches: the left button, or the tip.
    eraser : bool
        The other end of the pen.
    bends : bool
        Whether Shift is held with a mouse: its motion turns the tuft's bend in place.
    """

    time_ns: int
    x: float
    y: float
    pressure: float | None = None
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    twist: float = 0.0
    down: bool = False
    eraser: bool = False
    bends: bool = False


def touch_of_mouse(event: QtGui.QMouseEvent, time_ns: int) -> Touch:
    """What a mouse says."""
    place = event.position()
    down = bool(event.buttons() & _LEFT)
    bends = bool(event.modifiers() & QtCore.Qt.KeyboardModifier.ShiftModifier)
    return Touch(time_ns, place.x(), place.y(), down=down, bends=bends)


def pressure_of_contact(
    point: QtGui.QEventPoint, can: QtGui.QInputDevice.Capability, px_per_mm: float
) -> float | None:
    """How hard a finger presses, 0 to 1, by how large its contact is.

    Parameters
    ----------
    point : QEventPoint
    can : QInputDevice.Capability
        What the screen says of fingers.
    px_per_mm : float
        Of the picture's pixels.

    Returns
    -------
    float or None
        4 mm across is 0, 16 mm is 1. By the screen's own pressure where it has no size; None where
        it has neither, or says what no fingertip is.
    """
    size = point.ellipseDiameters()
    across = math.sqrt(max(0.0, size.width() * size.height())) / max(px_per_mm, 1e-6)
    if can & _CAN.Area and across >= _LEAST_MM:
        return min(1.0, max(0.02, (across - _LIGHT_MM) / (_FIRM_MM - _LIGHT_MM)))
    if can & _CAN.Pressure and 0.0 < point.pressure() < 1.0:
        return float(point.pressure())
    return None


def touch_of_tablet(event: QtGui.QTabletEvent, time_ns: int) -> Touch:
    """What a pen says; a pressure outside 0 to 1 is clipped."""
    place = event.position()
    pressure = min(max(0.0, event.pressure()), 1.0)  # in this order NaN becomes 0
    is_release = event.type() == QtCore.QEvent.Type.TabletRelease  # of any button, and maybe stale
    return Touch(
        time_ns,
        place.x(),
        place.y(),
        pressure,
        math.radians(event.xTilt()),
        math.radians(event.yTilt()),
        math.radians(event.rotation()),
        bool(event.buttons() & _LEFT) or (pressure > 0.0 and not is_release),
        event.pointerType() == _ERASER,
    )

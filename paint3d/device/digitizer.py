"""Generic HID digitizers: pens on usage page 0x0D, and on Wacom's mirror of it, page 0xFF0D.

Positions are in mm if the digitizer declares a unit of length (cm or inch, with a power of ten);
tilts follow their declared unit, by default degrees. The tilts along x and y give the pen's
orientation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.device.descriptor import Field, ReportDescriptor, extract, scaled, split_report
from paint3d.device.sample import BARREL, DIP, ERASER, StylusReading
from paint3d.errors import DeviceError

__all__ = ["DigitizerLayout", "find_digitizer_layout", "orientation_from_tilt"]

_DESKTOP, _PAGES = 0x01, (0x0D, 0xFF0D)
_X, _Y, _WACOM_X, _WACOM_Y = 0x30, 0x31, 0x130, 0x131
_PRESSURE, _IN_RANGE, _DISTANCE = 0x30, 0x32, 0x3F
_WACOM_DISTANCE = 0x132
_INVERT, _TILT_X, _TILT_Y, _TWIST = 0x3C, 0x3D, 0x3E, 0x41
_TIP, _BARREL, _ERASER, _SECOND = 0x42, 0x44, 0x45, 0x5A
_PENS = tuple(page << 16 | usage for page in _PAGES for usage in (0x01, 0x02, 0x20))
_CM, _INCH, _RADIANS = 0x11, 0x13, 0x12
_MM_OF = {_CM: 10.0, _INCH: 25.4}
_STEEPEST = math.radians(89.0)


@dataclass(frozen=True)
class DigitizerLayout:
    """Fields of a descriptor that describe a pen.

    Attributes
    ----------
    descriptor : ReportDescriptor
    parts : dict of str to Field
        x, y, pressure, tip, in_range, tilt_x, tilt_y, twist, barrel, second, eraser, invert,
        distance: those that the device has, always x and y.
    """

    descriptor: ReportDescriptor
    parts: dict[str, Field]

    def decode(self, data: bytes, time_ns: int = 0) -> StylusReading | None:
        """Decode the reading in a report; None if it is not the pen's report.

        y grows upwards (away from the user), as on paper; z is the hover height.

        Raises
        ------
        DeviceError
            If the report is not one of the device's, or too short.
        """
        report_id, body = split_report(self.descriptor, data)
        if self.parts["x"].report_id != report_id:
            return None
        raw = {
            name: extract(field, body)
            for name, field in self.parts.items()
            if field.report_id == report_id
        }
        in_range = bool(raw.get("in_range", 1))
        x, y = self._length("x", raw), self._length("y", raw)
        height = self.parts["y"]
        y = _millimetres(height, height.high) - y
        tip = bool(raw.get("tip", raw.get("pressure", 0) > 0) or raw.get("eraser", 0))
        pressure = scaled(self.parts["pressure"], raw["pressure"]) if "pressure" in raw else None
        if pressure is None:
            pressure = 0.5 if tip else 0.0  # a pen that only senses contact
        pressure = pressure if tip and in_range else 0.0
        orientation = orientation_from_tilt(
            self._angle("tilt_x", raw), -self._angle("tilt_y", raw), self._angle("twist", raw)
        )
        position = np.array([x, y, self._length("distance", raw)])
        buttons = (
            (BARREL if raw.get("barrel") else 0)
            | (DIP if raw.get("second") else 0)
            | (ERASER if raw.get("eraser") or raw.get("invert") else 0)
        )
        return StylusReading(time_ns, position, orientation, pressure, buttons, in_range)

    def _length(self, name: str, raw: dict[str, int]) -> float:
        return _millimetres(self.parts[name], raw[name]) if name in raw else 0.0

    def _angle(self, name: str, raw: dict[str, int]) -> float:
        if name not in raw:
            return 0.0
        field, value = self.parts[name], raw[name]
        if scaled(field, value) is None:
            return 0.0
        physical = _physical(field, value)
        if field.unit == _RADIANS:
            return physical * 10.0**field.exponent
        return math.radians(physical * (10.0**field.exponent if field.unit else 1.0))


def find_digitizer_layout(descriptor: ReportDescriptor) -> DigitizerLayout:
    """Find a pen in a descriptor.

    Raises
    ------
    DeviceError
        If there is no pen collection with a position.
    """
    fields = [f for f in descriptor.inputs_in(_PENS) if not f.constant and f.variable]
    wanted = {
        "x": [(_DESKTOP, _X), (0xFF0D, _WACOM_X)],
        "y": [(_DESKTOP, _Y), (0xFF0D, _WACOM_Y)],
        "distance": [(page, _DISTANCE) for page in _PAGES] + [(0xFF0D, _WACOM_DISTANCE)],
    }
    for name, usage in (
        ("pressure", _PRESSURE),
        ("in_range", _IN_RANGE),
        ("tip", _TIP),
        ("tilt_x", _TILT_X),
        ("tilt_y", _TILT_Y),
        ("twist", _TWIST),
        ("barrel", _BARREL),
        ("second", _SECOND),
        ("eraser", _ERASER),
        ("invert", _INVERT),
    ):
        wanted[name] = [(page, usage) for page in _PAGES]
    parts = {}
    for name, usages in wanted.items():
        matches = (f for f in fields if (f.page, f.usage) in usages and 0 < f.size <= 32)
        if (field := next(matches, None)) is not None:
            parts[name] = field
    if not {"x", "y"} <= parts.keys() or parts["x"].report_id != parts["y"].report_id:
        raise DeviceError("not a digitizer: its descriptor has no pen with a position")
    return DigitizerLayout(descriptor, parts)


def _physical(field: Field, value: int) -> float:
    span = field.high - field.low
    if span <= 0:
        return float(value)
    fraction = (value - field.low) / span
    return field.physical_low + fraction * (field.physical_high - field.physical_low)


def _millimetres(field: Field, value: int) -> float:
    """Convert a length to mm; without a known unit, counts are 0.01 mm (usually 2540 an inch)."""
    value = min(max(value, field.low), field.high) if field.high > field.low else value
    if field.unit in _MM_OF:
        return _physical(field, value) * 10.0**field.exponent * _MM_OF[field.unit]
    return (value - field.low) * 0.01


def orientation_from_tilt(tilt_x: float, tilt_y: float, twist: float = 0.0) -> NDArray[np.float64]:
    """Compute the quaternion pad_from_pen (4,) of a pen with these tilts.

    The handle leans towards +x by `tilt_x` and towards +y by `tilt_y` (rad, seen along the other
    axis), so its direction is (tan tilt_x, tan tilt_y, 1), as in W3C Pointer Events. The tip
    bends away from the lean; an upright pen's bends along -x. `twist` turns the pen about its
    own axis, anticlockwise seen from above, and the bend with it.
    """
    lean_x = math.tan(min(max(tilt_x, -_STEEPEST), _STEEPEST))
    lean_y = math.tan(min(max(tilt_y, -_STEEPEST), _STEEPEST))
    azimuth = math.atan2(lean_y, lean_x) if (lean_x, lean_y) != (0.0, 0.0) else 0.0
    half_lean = 0.5 * math.atan(math.hypot(lean_x, lean_y))
    # Rz(azimuth) Ry(lean) Rz(pi + twist), in half angles
    turn, sway = azimuth + math.pi + twist, azimuth - math.pi - twist
    return np.array(
        [
            math.cos(half_lean) * math.cos(0.5 * turn),
            -math.sin(half_lean) * math.sin(0.5 * sway),
            math.sin(half_lean) * math.cos(0.5 * sway),
            math.cos(half_lean) * math.sin(0.5 * turn),
        ]
    )

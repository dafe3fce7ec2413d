"""6-DOF mice: decoding of input reports to axes and buttons by the device's own descriptor.

Usage page 1 (generic desktop) holds X, Y, Z, Rx, Ry, Rz (0x30 to 0x35), page 9 the buttons, page 8
the light. Older devices send translation and rotation as two reports, newer ones all six axes in
one; the descriptor says which. A report gives the cap's current deflection, not a motion; at rest
the device sends nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from paint3d.device.descriptor import (
    Field,
    Kind,
    ReportDescriptor,
    extract,
    pack_report,
    pressed,
    split_report,
)
from paint3d.errors import DeviceError

__all__ = ["AXES", "MouseLayout", "MouseReading", "find_mouse_layout", "is_multi_axis"]

AXES = ("x", "y", "z", "rx", "ry", "rz")
_DESKTOP, _LEDS, _BUTTONS = 0x01, 0x08, 0x09
_FIRST_AXIS = 0x30
_MULTI_AXIS = 0x0001_0008
_JOYSTICKS = (0x0001_0004, 0x0001_0005)
_BATTERY_REPORT = 0x17  # of wireless SpaceMice: percentage, charging; not in every descriptor


@dataclass(frozen=True, slots=True)
class MouseReading:
    """Last known state of a 6-DOF mouse.

    Attributes
    ----------
    axes : tuple of 6 int
        x, y, z, rx, ry, rz as sent: +x right, +y towards the user, +z down.
    buttons : int
        Bit 0 is the first button.
    battery : int or None
        Percentage, if the device reports it.
    """

    axes: tuple[int, ...] = (0, 0, 0, 0, 0, 0)
    buttons: int = 0
    battery: int | None = None


@dataclass(frozen=True)
class MouseLayout:
    """Fields of a descriptor for axes, buttons and the light.

    Attributes
    ----------
    descriptor : ReportDescriptor
    axes : tuple of 6 (Field or None)
        One for each of `AXES`.
    buttons : tuple of Field
    light : Field or None
    """

    descriptor: ReportDescriptor
    axes: tuple[Field | None, ...]
    buttons: tuple[Field, ...]
    light: Field | None

    def decode(self, data: bytes, before: MouseReading) -> MouseReading:
        """Update a reading by one report; what the report lacks keeps its value.

        Parameters
        ----------
        data : bytes
            As read from the device, id first where reports are numbered; may be padded.
        before : MouseReading

        Raises
        ------
        DeviceError
            If the report is not one of the device's, or too short.
        """
        if (
            data[:1] == bytes([_BATTERY_REPORT])
            and self.descriptor.numbered
            and not self.descriptor.size(Kind.INPUT, _BATTERY_REPORT)  # undeclared
        ):
            return replace(before, battery=min(data[1], 100)) if len(data) > 1 else before
        report_id, body = split_report(self.descriptor, data)
        axes = tuple(
            extract(field, body) if field is not None and field.report_id == report_id else old
            for field, old in zip(self.axes, before.axes, strict=True)
        )
        fields = [field for field in self.buttons if field.report_id == report_id]
        buttons = pressed(fields, body) if fields else before.buttons
        return MouseReading(axes, buttons, before.battery)

    def encode_light(self, on: bool) -> bytes | None:
        """Encode the output report that turns the light on or off; None if there is no light."""
        if self.light is None:
            return None
        values = {self.light: int(on)}
        return pack_report(self.descriptor, Kind.OUTPUT, self.light.report_id, values)


def find_mouse_layout(descriptor: ReportDescriptor) -> MouseLayout:
    """Find the six axes of a 6-DOF mouse.

    Raises
    ------
    DeviceError
        If the descriptor has no multi-axis controller with all of X, Y, Z, Rx, Ry and Rz.
    """
    fields = [f for f in descriptor.fields if f.application not in _JOYSTICKS and not f.constant]
    inputs = [f for f in fields if f.kind is Kind.INPUT]
    axes = tuple(
        next(
            (f for f in inputs if (f.page, f.usage) == (_DESKTOP, _FIRST_AXIS + i) and f.variable),
            None,
        )
        for i in range(6)
    )
    if None in axes:
        missing = " ".join(name for name, f in zip(AXES, axes, strict=True) if f is None)
        raise DeviceError(
            "not a 6-DOF mouse: its descriptor has no axis {missing}",
            missing=missing,
        )
    buttons = tuple(f for f in inputs if f.page == _BUTTONS)
    light = next((f for f in fields if f.kind is Kind.OUTPUT and f.page == _LEDS), None)
    return MouseLayout(descriptor, axes, buttons, light)


def is_multi_axis(descriptor: ReportDescriptor) -> bool:
    """Return whether a top-level collection is a multi-axis controller (page 1, usage 8)."""
    return _MULTI_AXIS in descriptor.applications

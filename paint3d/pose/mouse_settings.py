"""User settings of a 6-DOF mouse and its buttons, as in the panel, the command and the file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from paint3d.core.array_state import known_fields
from paint3d.core.arrays import as_number
from paint3d.device.six_dof import AXES
from paint3d.device.space_mouse import DeflectionSettings
from paint3d.errors import DeviceError, UnknownNameError
from paint3d.pose.steering import SteeringOptions

__all__ = [
    "ACTIONS",
    "DEFAULT_ACTIONS",
    "MODES",
    "MouseSettings",
    "checked_actions",
    "find_actions",
    "parse_axes",
]

MODES = ("object", "camera")
_ZOOMS = ("y", "z")


def parse_axes(text: str) -> tuple[str, ...]:
    """Parse six comma-separated axes, such as "x,-z,y,rx,ry,-rz".

    Raises
    ------
    DeviceError
        If one is missing, unknown or repeated.
    """
    axes = tuple(part.strip().lower() for part in text.split(","))
    if sorted(axis.removeprefix("-") for axis in axes) != sorted(AXES):
        raise DeviceError(
            "axes are {text!r:.60}; expected x, y, z, rx, ry and rz once each, in the order of the "
            'motions that they give, "-" before those to be turned round',
            text=text,
        )
    return axes


@dataclass(frozen=True, slots=True)
class MouseSettings:
    """A user's choices for a 6-DOF mouse.

    Parameters
    ----------
    mode : {"object", "camera"}
        Whether the cap moves the object, or the viewer.
    speed_mm_s, turn_deg_s : float
        At full deflection; 0 to 5000 and 0 to 2800.
    dead_zone : float
        Fraction of the deflection that counts as rest, 0 to 0.9.
    curve : float
        Exponent of the response, 1 to 4.
    axes : tuple of 6 str
        The cap's axis for each motion; see `parse_axes`.
    moving, turning : bool
        False locks them.
    dominant_axis : bool
        Follow only the axis that is deflected farthest.
    zoom_axis : {"y", "z"}
        The cap's axis that brings the object nearer.

    Raises
    ------
    DeviceError
        Naming what is out of range.
    """

    mode: str = "object"
    speed_mm_s: float = 150.0
    turn_deg_s: float = math.degrees(1.5)
    dead_zone: float = 0.05
    curve: float = 1.6
    axes: tuple[str, ...] = AXES
    moving: bool = True
    turning: bool = True
    dominant_axis: bool = False
    zoom_axis: str = "y"

    def __post_init__(self) -> None:
        for name, known in (("mode", MODES), ("zoom_axis", _ZOOMS)):
            if getattr(self, name) not in known:
                got = getattr(self, name)
                raise DeviceError(
                    "{name} is {got!r:.40}; expected {known}",
                    name=name,
                    got=got,
                    known=" or ".join(known),
                )
        for name, low, high in (
            ("speed_mm_s", 0.0, 5000.0),
            ("turn_deg_s", 0.0, 2800.0),
            ("dead_zone", 0.0, 0.9),
            ("curve", 1.0, 4.0),
        ):
            as_number(getattr(self, name), name, low, high, DeviceError)
        for name in ("moving", "turning", "dominant_axis"):
            if not isinstance(getattr(self, name), bool):
                got = getattr(self, name)
                raise DeviceError(
                    "{name} is {got!r:.40}; expected true or false",
                    name=name,
                    got=got,
                )
        object.__setattr__(self, "axes", parse_axes(",".join(map(str, self.axes))))

    @classmethod
    def from_dict(cls, stored: Mapping[str, Any]) -> MouseSettings:
        """Read the settings from a file's entries; unknown ones are ignored.

        Raises
        ------
        DeviceError
            See the class.
        """
        return cls(**known_fields(cls, stored))

    def as_dict(self) -> dict[str, Any]:
        """Return all settings, ready for a file."""
        return {**dataclasses.asdict(self), "axes": list(self.axes)}

    def steering(self) -> SteeringOptions:
        """Return the options for turning deflections into motion."""
        return SteeringOptions(
            mode=self.mode,
            speed_mm_s=self.speed_mm_s,
            turn_rad_s=math.radians(self.turn_deg_s),
            order=tuple(AXES.index(axis.removeprefix("-")) for axis in self.axes),
            inverted=tuple(axis.startswith("-") for axis in self.axes),
            moving=self.moving,
            turning=self.turning,
            dominant_axis=self.dominant_axis,
            zoom_axis=self.zoom_axis,
        )

    def deflection(self, before: DeflectionSettings | None = None) -> DeflectionSettings:
        """Return the settings for reading the cap, with the rest position of `before`."""
        before = before or DeflectionSettings()
        return dataclasses.replace(before, dead_zone=self.dead_zone, curve=self.curve)


# ---- Buttons -------------------------------------------------------------------------------------

ACTIONS = (
    "recentre",
    "dip",
    "undo",
    "redo",
    "toggle_turning",
    "toggle_moving",
    "toggle_dominant_axis",
    "toggle_camera",
    "calibrate_rest",
)
"""Everything a button can do."""

DEFAULT_ACTIONS: Mapping[int, str] = MappingProxyType(
    {0: "recentre", 1: "dip", 2: "undo", 3: "redo", 4: "toggle_turning", 5: "toggle_moving"}
)
"""Button number: action. Every 6-DOF mouse has the first two."""
_MOST_BUTTONS = 31  # of a bit field


def checked_actions(actions: Mapping[int, str]) -> dict[int, str]:
    """Check and copy a user's mapping.

    Raises
    ------
    DeviceError
        If a button's number is not 0 to 30.
    UnknownNameError
        For an unknown action.
    """
    for button, action in actions.items():
        if (
            isinstance(button, bool)
            or not isinstance(button, int)
            or not 0 <= button < _MOST_BUTTONS
        ):
            raise DeviceError(
                "button {button!r}; expected 0 to {most}",
                button=button,
                most=_MOST_BUTTONS - 1,
            )
        if action not in ACTIONS:
            raise UnknownNameError("action", str(action), ACTIONS)
    return dict(actions)


def find_actions(
    before: int, after: int, actions: Mapping[int, str] = DEFAULT_ACTIONS
) -> list[str]:
    """List the actions of buttons pressed between two bit fields, lowest button first."""
    pressed = after & ~before
    return [actions[button] for button in sorted(actions) if pressed >> button & 1]

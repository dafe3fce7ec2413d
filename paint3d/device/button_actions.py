"""Mapping of device buttons to actions, which the user may change."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from paint3d.errors import DeviceError, UnknownNameError

__all__ = ["ACTIONS", "DEFAULT_ACTIONS", "checked_actions", "find_actions"]

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
_MOST_BUTTONS = 31


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
        if isinstance(button, bool) or not isinstance(button, int) or not 0 <= button < 31:
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

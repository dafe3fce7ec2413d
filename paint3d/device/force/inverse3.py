"""Haply Inverse3 with VerseGrip: JSON messages of the vendor's service, both ways.

NOT TRIED ON HARDWARE: written from the service's public interface (version 3, JSON over a
WebSocket at ws://localhost:10001) and tested against a server that stands in for it.

The service sends a state; every force that is sent is answered by the next state, and without a
force (zero will do) no state comes. Positions are in metres, forces in newtons, quaternions have
x, y, z, w by name. Only the first message of a connection carries the configuration.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from paint3d.device.sample import BARREL, DIP, ERASER, StylusReading
from paint3d.errors import DeviceError

__all__ = ["MAX_FORCE_N", "URI", "Inverse3State", "decode_state", "encode_force"]

URI = "ws://localhost:10001"
MAX_FORCE_N = 8.0  # peak, from the maker's data sheet; the user's limit lowers it
_GRIPS = ("wireless_verse_grip", "verse_grip", "custom_verse_grip")
_BUTTONS = {"a": BARREL, "b": DIP, "c": ERASER}
_MAX_BYTES = 1 << 20
_MAX_MM = 2000.0
_MM = 1000.0


@dataclass(frozen=True, eq=False, slots=True)
class Inverse3State:
    """One message of the service.

    Attributes
    ----------
    device_id : str
        Of the Inverse3: forces name it.
    reading : StylusReading
        Position in mm and, where a grip is there, orientation and buttons.
    has_grip : bool
    """

    device_id: str
    reading: StylusReading
    has_grip: bool


def decode_state(data: bytes | str, time_ns: int = 0) -> Inverse3State:
    """Read a message of the service.

    Raises
    ------
    DeviceError
        If it is not JSON, names no Inverse3, or a number in it is missing, no number, not finite
        or out of reach.
    """
    if len(data) > _MAX_BYTES:
        raise DeviceError(f"a message of {len(data)} bytes; expected at most {_MAX_BYTES}")
    try:
        message = json.loads(data)
    except (ValueError, RecursionError) as cause:
        raise DeviceError(f"the Inverse3 service sent what is not JSON ({cause})") from None
    device = _first(message, "inverse3")
    if device is None:
        raise DeviceError("the Inverse3 service knows no Inverse3; is it plugged in and awake?")
    device_id = device.get("device_id")
    if not isinstance(device_id, str) or not device_id:
        raise DeviceError(f"the Inverse3's device_id is {device_id!r:.40}; expected a name")
    place = _numbers(device, "cursor_position", "xyz")
    if max(map(abs, place)) * _MM > _MAX_MM:
        raise DeviceError(f"the cursor is at {place} m; expected within {_MAX_MM / _MM:g}")
    grip = next((g for name in _GRIPS if (g := _first(message, name)) is not None), None)
    orientation, buttons = [1.0, 0.0, 0.0, 0.0], 0
    if grip is not None:
        orientation, buttons = _orientation(grip), _held(grip)
    reading = StylusReading(time_ns, np.array(place) * _MM, np.array(orientation), None, buttons)
    return Inverse3State(device_id, reading, grip is not None)


def encode_force(device_id: str, force: ArrayLike) -> str:
    """The message that sets the force (3,), N, and asks for the next state.

    Raises
    ------
    DeviceError
        If the force is not finite or above the device's limit: it must be made safe before.
    """
    x, y, z = np.asarray(force, np.float64).tolist()
    if not math.hypot(x, y, z) <= MAX_FORCE_N + 1e-6:
        raise DeviceError(f"force is ({x:g}, {y:g}, {z:g}) N; expected at most {MAX_FORCE_N} N")
    values = {"x": x, "y": y, "z": z}
    command = {"device_id": device_id, "commands": {"set_cursor_force": {"values": values}}}
    return json.dumps({"inverse3": [command]}, allow_nan=False)


def _first(message: object, name: str) -> dict[str, Any] | None:
    """The first entry of a list of devices."""
    devices = message.get(name) if isinstance(message, dict) else None
    found = devices[0] if isinstance(devices, list) and devices else None
    return found if isinstance(found, dict) else None


def _numbers(device: dict[str, Any], name: str, keys: str) -> list[float]:
    state = device.get("state")
    parts = state.get(name) if isinstance(state, dict) else None
    if not isinstance(parts, dict):
        raise DeviceError(f"the Inverse3 service sent no {name}")
    found = []
    for key in keys:
        number = parts.get(key)
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise DeviceError(f"{name}.{key} is {number!r:.40}; expected a number")
        try:
            found.append(float(number))
        except OverflowError:
            found.append(math.inf)
        if not math.isfinite(found[-1]):
            raise DeviceError(f"{name}.{key} is {found[-1]}; expected a finite number")
    return found


def _orientation(grip: dict[str, Any]) -> list[float]:
    parts = _numbers(grip, "orientation", "wxyz")
    length = math.hypot(*parts)
    if not 0.9 <= length <= 1.1:
        raise DeviceError(f"the grip's quaternion has length {length:.3g}; expected 1")
    return [part / length for part in parts]


def _held(grip: dict[str, Any]) -> int:
    state = grip.get("state")
    held = state.get("buttons") if isinstance(state, dict) else None
    if not isinstance(held, dict):
        return 0
    return sum(bit for name, bit in _BUTTONS.items() if held.get(name) is True)

"""Haply Inverse3 with VerseGrip: JSON messages of the vendor's service, both ways.

NOT TRIED ON HARDWARE: written from the service's public interface (version 3, JSON over a
WebSocket at ws://localhost:10001) and tested against a mock server.

The service sends a first state, and answers every force (zero will do) with the next; so our forces
set its pace. Positions are in metres, forces in newtons, quaternions have x, y, z, w by name. Only
the first message of a connection carries the configuration. Needs the package websockets
(``pip install 'paint3d[haply]'``).
"""

from __future__ import annotations

import json
import math
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import ArrayLike

from paint3d.device.force.force_port import ForceLoop
from paint3d.device.force.haptic_stylus import PoseNumbers, checked_force
from paint3d.device.sample import BARREL, DIP, ERASER, StylusReading
from paint3d.errors import DeviceError

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

__all__ = ["MAX_FORCE_N", "URI", "Inverse3Port", "Inverse3State", "decode_state", "encode_force"]

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
        Of the Inverse3, to address forces to.
    reading : StylusReading
        Position in mm and, if there is a grip, orientation and buttons.
    has_grip : bool
    """

    device_id: str
    reading: StylusReading
    has_grip: bool


def decode_state(data: bytes | str, time_ns: int = 0) -> Inverse3State:
    """Decode a message of the service.

    Raises
    ------
    DeviceError
        If it is not JSON, lists no Inverse3, or one of its numbers is missing, not a number, not
        finite or out of range.
    """
    if len(data) > _MAX_BYTES:
        raise DeviceError(
            "a message of {n} bytes; expected at most {most}",
            n=len(data),
            most=_MAX_BYTES,
        )
    try:
        message = json.loads(data)
    except (ValueError, RecursionError) as cause:
        raise DeviceError(
            "the Inverse3 service sent what is not JSON ({cause})", cause=cause
        ) from None
    device = _first(message, "inverse3")
    if device is None:
        raise DeviceError("the Inverse3 service lists no Inverse3; is it plugged in and awake?")
    device_id = device.get("device_id")
    if not isinstance(device_id, str) or not device_id:
        raise DeviceError(
            "the Inverse3's device_id is {device_id!r:.40}; expected a name",
            device_id=device_id,
        )
    cursor = _numbers(device, "cursor_position", "xyz")
    if max(map(abs, cursor)) * _MM > _MAX_MM:
        raise DeviceError(
            "the cursor is at {cursor} m; expected within {most:g}",
            cursor=cursor,
            most=_MAX_MM / _MM,
        )
    grip = next((g for name in _GRIPS if (g := _first(message, name)) is not None), None)
    orientation, buttons = [1.0, 0.0, 0.0, 0.0], 0
    if grip is not None:
        orientation, buttons = _orientation(grip), _buttons(grip)
    reading = StylusReading(time_ns, np.array(cursor) * _MM, np.array(orientation), None, buttons)
    return Inverse3State(device_id, reading, grip is not None)


def encode_force(device_id: str, force: ArrayLike) -> str:
    """Encode the message that sets the force (3,), N, and requests the next state.

    Raises
    ------
    DeviceError
        If the force is not finite or above the device's limit; the caller must limit it.
    """
    x, y, z = checked_force(force, MAX_FORCE_N)
    values = {"x": x, "y": y, "z": z}
    command = {"device_id": device_id, "commands": {"set_cursor_force": {"values": values}}}
    return json.dumps({"inverse3": [command]}, allow_nan=False)


def _first(message: object, name: str) -> dict[str, Any] | None:
    """Return the first entry of a list of devices, or None."""
    devices = message.get(name) if isinstance(message, dict) else None
    device = devices[0] if isinstance(devices, list) and devices else None
    return device if isinstance(device, dict) else None


def _numbers(device: dict[str, Any], name: str, keys: str) -> list[float]:
    """Return the finite numbers of one entry of a device's state, by their one-letter keys."""
    state = device.get("state")
    parts = state.get(name) if isinstance(state, dict) else None
    if not isinstance(parts, dict):
        raise DeviceError("the Inverse3 service sent no {name}", name=name)
    numbers = []
    for key in keys:
        number = parts.get(key)
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise DeviceError(
                "{name}.{key} is {number!r:.40}; expected a number",
                name=name,
                key=key,
                number=number,
            )
        try:
            numbers.append(float(number))
        except OverflowError:
            numbers.append(math.inf)
        if not math.isfinite(numbers[-1]):
            raise DeviceError(
                "{name}.{key} is {last}; expected a finite number",
                name=name,
                key=key,
                last=numbers[-1],
            )
    return numbers


def _orientation(grip: dict[str, Any]) -> list[float]:
    parts = _numbers(grip, "orientation", "wxyz")
    length = math.hypot(*parts)
    if not 0.9 <= length <= 1.1:
        raise DeviceError(
            "the grip's quaternion has length {length:.3g}; expected 1",
            length=length,
        )
    return [part / length for part in parts]


def _buttons(grip: dict[str, Any]) -> int:
    state = grip.get("state")
    buttons = state.get("buttons") if isinstance(state, dict) else None
    if not isinstance(buttons, dict):
        return 0
    return sum(bit for name, bit in _BUTTONS.items() if buttons.get(name) is True)


# ---- The port ------------------------------------------------------------------------------------

_FIRST_S = 5.0
_PROBE_S = 0.25
_NOTHING = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Inverse3Port:
    """A force port of the Inverse3 service.

    Parameters
    ----------
    uri : str
    silence_s : float
        Time without a state after which the loop's force for a silence is sent.
    """

    uri: str = URI
    silence_s: float = 0.002

    def is_served(self) -> bool:
        """Return whether something listens at the service's address."""
        url = urlsplit(self.uri)
        try:
            address = (url.hostname or "localhost", url.port or 80)
            socket.create_connection(address, _PROBE_S).close()
        except (OSError, ValueError):
            return False
        return True

    def read_name(self) -> str:
        """Read the device id of the service's first Inverse3.

        Raises
        ------
        DeviceError
            As by `run`.
        """
        with self._connected() as service:
            return decode_state(service.recv(timeout=_FIRST_S)).device_id

    def run(self, loop: ForceLoop) -> None:
        """See `paint3d.device.force.force_port.ForcePort`.

        Raises
        ------
        DeviceError
            If the service does not run, lists no Inverse3, or closes the connection.
        """
        with self._connected() as service:
            state = decode_state(service.recv(timeout=_FIRST_S), time.monotonic_ns())
            device_id = state.device_id
            try:
                force = loop.step(_pose_numbers(state), time.monotonic_ns())
                while not loop.stopped():
                    service.send(encode_force(device_id, force))
                    loop.sent()
                    force = self._next(service, loop)
            finally:
                with suppress(Exception):  # the connection may be closed already
                    service.send(encode_force(device_id, _NOTHING))

    @contextmanager
    def _connected(self) -> Iterator[ClientConnection]:
        try:
            from websockets.exceptions import WebSocketException
            from websockets.sync.client import connect
        except ImportError:
            raise DeviceError(
                "a Haply Inverse3 needs websockets, which is not installed",
                hint="pip install 'paint3d[haply]'",
            ) from None
        try:
            with connect(self.uri, open_timeout=_FIRST_S, close_timeout=1.0) as service:
                yield service
        except (OSError, WebSocketException, TimeoutError, ValueError) as cause:
            raise DeviceError(
                "the Inverse3 service at {uri} has gone or does not run ({cause}); it comes with "
                "Haply's software: start it",
                hint="or say where it is: --stylus inverse3=ws://HOST:PORT",
                uri=self.uri,
                cause=cause,
            ) from None

    def _next(self, service: ClientConnection, loop: ForceLoop) -> tuple[float, float, float]:
        """Compute the force after the newest state, or after a silence.

        A silence is answered too, by the loop's force for it. The service's reply to that comes in
        addition to the late state, so all queued states are taken: else the delay would add up.
        """
        force, timeout = None, self.silence_s
        while True:
            try:
                message = service.recv(timeout=timeout)
            except TimeoutError:
                break
            timeout = 0.0
            try:
                pose = _pose_numbers(decode_state(message, time.monotonic_ns()))
            except DeviceError:
                loop.refused()
                continue
            if force is not None:
                loop.sent()
            force = loop.step(pose, time.monotonic_ns())
        return loop.step(None, time.monotonic_ns()) if force is None else force


def _pose_numbers(state: Inverse3State) -> PoseNumbers:
    reading = state.reading
    return PoseNumbers(
        reading.time_ns,
        tuple(reading.position.tolist()),
        tuple(reading.orientation.tolist()),
        reading.buttons,
        0,
    )

"""Haply Inverse3 as a force port: one force out, one state back, over the vendor's service.

NOT TRIED ON HARDWARE; see `paint3d.device.force.inverse3`. The service answers every force with the
next state, so its pace is ours. Needs the package websockets (``pip install 'paint3d[haply]'``).
"""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from paint3d.device.force.force_port import ForceLoop
from paint3d.device.force.haptic_stylus import PoseNumbers
from paint3d.device.force.inverse3 import URI, Inverse3State, decode_state, encode_force
from paint3d.errors import DeviceError

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

__all__ = ["Inverse3Port"]

_FIRST_S, _SILENCE_S = 5.0, 0.002
_LISTENS_S = 0.25
_NOTHING = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Inverse3Port:
    """A force port of the Inverse3 service at `uri`."""

    uri: str = URI

    def is_served(self) -> bool:
        """Whether something listens where the service would be."""
        place = urlsplit(self.uri)
        try:
            there = (place.hostname or "localhost", place.port or 80)
            socket.create_connection(there, _LISTENS_S).close()
        except (OSError, ValueError):
            return False
        return True

    def read_name(self) -> str:
        """The name of the Inverse3 that the service knows.

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
            If the service does not run, knows no Inverse3, or hangs up.
        """
        with self._connected() as service:
            self._serve(service, loop)

    @contextmanager
    def _connected(self) -> Iterator[ClientConnection]:
        try:
            from websockets.exceptions import WebSocketException
            from websockets.sync.client import connect
        except ImportError:
            raise DeviceError(
                "a Haply Inverse3 needs the package websockets: pip install 'paint3d[haply]'"
            ) from None
        try:
            with connect(self.uri, open_timeout=_FIRST_S, close_timeout=1.0) as service:
                yield service
        except (OSError, WebSocketException, TimeoutError, ValueError) as cause:
            raise DeviceError(
                f"the Inverse3 service at {self.uri} has gone or does not run ({cause}); it comes "
                "with Haply's software: start it, or say where it is: --stylus inverse3=ws://HOST:PORT"
            ) from None

    def _serve(self, service: ClientConnection, loop: ForceLoop) -> None:
        state = decode_state(service.recv(timeout=_FIRST_S), time.monotonic_ns())
        device_id = state.device_id
        try:
            force = loop.step(_numbers(state), time.monotonic_ns())
            while not loop.stopped():
                service.send(encode_force(device_id, force))
                loop.sent()
                force = self._next(service, loop)
        finally:
            with suppress(Exception):  # it may be gone; there is nothing more to be done
                service.send(encode_force(device_id, _NOTHING))

    def _next(self, service: ClientConnection, loop: ForceLoop) -> tuple[float, float, float]:
        """The force after the newest state, or after a silence.

        A silence is answered too, with what is then no force; its own answer comes on top of the
        late one, so all that wait are taken, or the hand would be felt ever later.
        """
        force, timeout = None, _SILENCE_S
        while True:
            try:
                message = service.recv(timeout=timeout)
            except TimeoutError:
                break
            timeout = 0.0
            try:
                pose = _numbers(decode_state(message, time.monotonic_ns()))
            except DeviceError:
                loop.refused()
                continue
            if force is not None:
                loop.sent()
            force = loop.step(pose, time.monotonic_ns())
        return loop.step(None, time.monotonic_ns()) if force is None else force


def _numbers(state: Inverse3State) -> PoseNumbers:
    reading = state.reading
    return PoseNumbers(
        reading.time_ns,
        tuple(reading.position.tolist()),
        tuple(reading.orientation.tolist()),
        reading.buttons,
        0,
    )

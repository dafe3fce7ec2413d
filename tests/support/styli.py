"""Styli that push back and are programs: held where a test says, telling what they are told.

Places and forces are the world's: x to the right, y away, z up.
"""

from __future__ import annotations

import functools
import json
import shutil
import subprocess
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

__all__ = ["Inverse3StandIn", "OpenHapticsStandIn", "compile_library"]

_PERIOD_S = 0.002  # of the service: a program beside it must get its turn
SOURCE = Path(__file__).with_name("openhaptics_stand_in.c")


@functools.cache
def _compiled() -> bytes:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler for the library that stands in")
    with tempfile.NamedTemporaryFile(suffix=".so") as out:
        subprocess.run(
            [compiler, "-shared", "-fPIC", "-O1", "-o", out.name, SOURCE, "-lpthread"], check=True
        )
        return Path(out.name).read_bytes()


def compile_library(folder: Path) -> Path:
    """The C library that stands in for OpenHaptics'."""
    out = folder / "libHD.so"
    out.write_bytes(_compiled())
    return out


class OpenHapticsStandIn:
    """A stylus behind the library; whoever loads it needs `environment`."""

    limits = (3.3, 0.4)

    def __init__(self, folder: Path) -> None:
        self.library, file = compile_library(folder), folder / "held"
        file.write_bytes(bytes(64))
        self.environment = {"OPENHAPTICS_STAND_IN": str(file)}
        self.choice = f"openhaptics={self.library}"
        self._held = np.memmap(file, np.float64, "r+", shape=(8,))
        self.hold(0.0, 0.0, 150.0)

    def hold(self, x: float, y: float, z: float, buttons: int = 0) -> None:
        """Hold it there, upright; mm."""
        self._held[:4] = x, z, -y, buttons

    def force(self) -> np.ndarray:
        """The force that it was told last, N."""
        x, y, z = self._held[4:7]
        return np.array([x, -z, y])

    def n_said(self) -> int:
        """How often it has said where it is, and was told a force for that."""
        return int(self._held[7])

    def close(self) -> None:
        """There is nothing to stop: the library goes with its process."""


class Inverse3StandIn:
    """A stylus behind a service that listens on a port of its own."""

    limits = (8.0, 0.5)

    def __init__(self, folder: Path) -> None:
        assert folder.is_dir()
        self._state, self._told = (0.0, 0.0, 0.15, 0), (0.0, 0.0, 0.0)
        self._n_said = 0
        self._server = serve(self._talk, "127.0.0.1", 0)
        self.environment: dict[str, str] = {}
        self.choice = f"inverse3=ws://127.0.0.1:{self._server.socket.getsockname()[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    def hold(self, x: float, y: float, z: float, buttons: int = 0) -> None:
        """Hold it there, upright; mm."""
        self._state = (1e-3 * x, 1e-3 * y, 1e-3 * z, buttons)

    def force(self) -> np.ndarray:
        """The force that it was told last, N."""
        return np.array(self._told)

    def n_said(self) -> int:
        """How often it has said where it is, and was told a force for that."""
        return self._n_said

    def close(self) -> None:
        """Stop the service; it bids its connections farewell for some seconds, for itself."""
        threading.Thread(target=self._server.shutdown, daemon=True).start()

    def _talk(self, socket) -> None:
        with suppress(ConnectionClosed):
            socket.send(self._said())
            for message in socket:
                asked = json.loads(message)["inverse3"][0]["commands"]
                values = asked["set_cursor_force"]["values"]
                self._told = values["x"], values["y"], values["z"]
                self._n_said += 1
                time.sleep(_PERIOD_S)
                socket.send(self._said())

    def _said(self) -> str:
        x, y, z, buttons = self._state
        turn = {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}
        grip = {"orientation": turn, "buttons": {"a": bool(buttons)}}
        place = {"cursor_position": {"x": x, "y": y, "z": z}}
        return json.dumps(
            {
                "inverse3": [{"device_id": "0A", "state": place}],
                "wireless_verse_grip": [{"device_id": "1B", "state": grip}],
            }
        )

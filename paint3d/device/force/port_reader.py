"""Reads a force-feedback stylus without force: its port runs in a thread and is sent zeros."""

from __future__ import annotations

import threading
from collections import deque

import numpy as np

from paint3d.device.force.force_port import ForcePort
from paint3d.device.force.haptic_stylus import PoseNumbers
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError

__all__ = ["PortReader"]

_NOTHING = (0.0, 0.0, 0.0)
_CAPACITY = 100_000  # readings to be taken; the oldest are dropped


class PortReader:
    """Reads a force port without pushing.

    Parameters
    ----------
    port : ForcePort
    name : str
        For messages.
    timeout_s : float
        How long to wait for the first pose; failures until then are raised.

    Attributes
    ----------
    name : str
    n_refused : int
        Reports that could not be read.

    Raises
    ------
    DeviceError
        If the port cannot be opened, or stays silent.
    """

    def __init__(self, port: ForcePort, name: str, timeout_s: float = 10.0) -> None:
        self.name, self.n_refused = name, 0
        self._port = port
        self._readings: deque[StylusReading] = deque(maxlen=_CAPACITY)
        self._started, self._stopping = threading.Event(), threading.Event()
        self._failure: DeviceError | None = None
        self._thread = threading.Thread(target=self._run, name="stylus", daemon=True)
        self._thread.start()
        has_started = self._started.wait(timeout_s)
        if self._failure is not None or not has_started:
            self.stop()
            raise self._failure or DeviceError(
                "{name} sent nothing within {timeout_s:g} s; expected it to be awake",
                name=name,
                timeout_s=timeout_s,
            )

    @property
    def gone(self) -> str | None:
        """Why reading has ended; None while it goes on."""
        return None if self._failure is None else str(self._failure)

    def take(self) -> list[StylusReading]:
        """Return all readings since the last call, oldest first."""
        return [self._readings.popleft() for _ in range(len(self._readings))]

    def stop(self) -> None:
        """Stop reading; idempotent."""
        self._stopping.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        try:
            self._port.run(self)
        except DeviceError as failure:
            self._failure = failure
        except Exception as cause:  # it would be lost with the thread
            self._failure = DeviceError("{name} failed: {cause}", name=self.name, cause=repr(cause))
        finally:
            self._started.set()

    # -- ForceLoop, called by the port -------------------------------------------------------

    def step(self, pose: PoseNumbers | None, now_ns: int) -> tuple[float, float, float]:
        """Store a pose; the force is zero."""
        if pose is not None:
            position, orientation = np.array(pose.position), np.array(pose.orientation)
            time_ns = pose.time_ns or now_ns
            self._readings.append(StylusReading(time_ns, position, orientation, None, pose.buttons))
            self._started.set()
        return _NOTHING

    def sent(self) -> None:
        """Do nothing; see `ForceLoop`."""

    def refused(self) -> None:
        """Count a report that could not be read."""
        self.n_refused += 1

    def stopped(self) -> bool:
        """Return whether the port must end."""
        return self._stopping.is_set()

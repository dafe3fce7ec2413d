"""Force-feedback devices as ports that each run their own loop.

Some devices call us back and others are polled, so the backend owns the loop. A port calls `step`
of a `ForceLoop` with every pose (None after a silence), sends the force that it returns, and runs
until it is stopped or the device is gone. However it ends, the last force it sends is zero.
"""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from paint3d.device.force.haptic_stylus import PoseNumbers, decode_numbers, encode_force
from paint3d.device.hid_link import DeviceGoneError, open_node
from paint3d.device.hid_nodes import HidNode
from paint3d.errors import DeviceError

__all__ = ["ForceLoop", "ForcePort", "HidForcePort", "SocketForcePort"]

_WAIT_MS = 2
_NOTHING = (0.0, 0.0, 0.0)
_LAST_FORCE_S = 1.0  # timeout of the last force, for a reader that is slow


class ForceLoop(Protocol):
    """Interface of the servo to a port."""

    def step(self, pose: PoseNumbers | None, now_ns: int) -> tuple[float, float, float]:
        """Return the force in the device's frame, N, after a pose or a silence."""

    def sent(self) -> None:
        """Do the bookkeeping of a step whose force has been sent."""

    def refused(self) -> None:
        """Count a report that cannot be decoded."""

    def stopped(self) -> bool:
        """Return whether the loop must end."""


class ForcePort(Protocol):
    """A force device that is opened by `run`, in the servo's process."""

    def run(self, loop: ForceLoop) -> None:
        """Open the device and run until it is gone or the loop is stopped."""


def answer(
    reports: list[tuple[int, bytes]], send: Callable[[bytes], None], loop: ForceLoop
) -> None:
    """Answer a batch of reports, or a silence, with one force.

    The loop steps for every valid report, so that none is missing from the painting; only the last
    force is sent.
    """
    sequence, force = 0, None
    for time_ns, report in reports:
        try:
            pose = decode_numbers(report, time_ns)
        except DeviceError:
            loop.refused()
            continue
        if force is not None:
            loop.sent()
        sequence, force = pose.sequence, loop.step(pose, time.monotonic_ns())
    if force is None:
        force = loop.step(None, time.monotonic_ns())
    send(encode_force(force, sequence))
    loop.sent()


@dataclass(frozen=True)
class HidForcePort:
    """paint3d's HID haptic stylus, by hidapi."""

    node: HidNode

    def run(self, loop: ForceLoop) -> None:
        """See `ForcePort`.

        Raises
        ------
        DeviceError
            If it cannot be opened, or disconnects.
        """
        link = open_node(self.node)
        try:
            while not loop.stopped():
                answer(link.read(_WAIT_MS), link.write, loop)
        finally:
            with suppress(DeviceGoneError):
                link.write(encode_force(_NOTHING))
            link.close()


@dataclass(frozen=True)
class SocketForcePort:
    """A stylus that is a program: the same reports over a socket that preserves messages."""

    socket: socket.socket

    def run(self, loop: ForceLoop) -> None:
        """See `ForcePort`.

        Raises
        ------
        DeviceError
            If the other side closes it.
        """
        self.socket.setblocking(False)
        try:
            while not loop.stopped():
                answer(self._read(), self._write, loop)
        finally:
            self.socket.settimeout(_LAST_FORCE_S)
            with suppress(OSError, DeviceError):
                self._write(encode_force(_NOTHING))
            self.socket.close()

    def _read(self) -> list[tuple[int, bytes]]:
        select.select([self.socket], [], [], _WAIT_MS * 1e-3)
        reports = []
        try:
            while report := self.socket.recv(64):
                reports.append((time.monotonic_ns(), report))
        except BlockingIOError:
            return reports
        except OSError as cause:
            raise DeviceGoneError("the virtual stylus has gone ({cause})", cause=cause) from None
        raise DeviceGoneError("the virtual stylus has gone")

    def _write(self, report: bytes) -> None:
        try:
            self.socket.send(report)
        except BlockingIOError:
            return  # the reader lags; the next force is newer anyway
        except OSError as cause:
            raise DeviceGoneError("the virtual stylus has gone ({cause})", cause=cause) from None

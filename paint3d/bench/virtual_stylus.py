"""Haptic stylus that is a program: sends a path at its own rate and records the forces it receives.

It exchanges the stylus' own reports over a socket that preserves messages, from a process of its
own, as a device on a cable would. Its measurements come back in shared memory.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import select
import socket
import time
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory
from multiprocessing.synchronize import Event
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_array
from paint3d.device.force.haptic_stylus import decode_force, encode_pose
from paint3d.errors import DeviceError
from paint3d.haptics.shared_state import make_shared_memory

__all__ = ["Felt", "VirtualStylus"]

_COLUMNS = 6  # round trip ns, force (3) N, how late it was sent ns, sent at ns
_SPIN_S = 60e-6
_PATIENCE_S = 60.0


@dataclass(frozen=True, eq=False)
class Felt:
    """Measurements on the device's side.

    Attributes
    ----------
    round_trip_us : (N,) float64
        From sending a pose to receiving the force that answers it; NaN where none came.
    force : (N, 3) float64
        N; NaN where none came.
    sent_late_us : (N,) float64
        How late the device itself was with its report: its own fault, not the servo's.
    sent_ns : (N,) int64
        When the pose went out, monotonic clock; 0 where it did not.
    """

    round_trip_us: NDArray[np.float64]
    force: NDArray[np.float64]
    sent_late_us: NDArray[np.float64]
    sent_ns: NDArray[np.int64]


class VirtualStylus:
    """A device in a process of its own; `plug` is the other end of its cable.

    Parameters
    ----------
    poses : (N, 7) array_like
        Root in mm and unit quaternion, one a report.
    priority : int
        SCHED_FIFO priority of its process where that is permitted; 0 asks for none.
    """

    def __init__(self, poses: ArrayLike, priority: int = 0) -> None:
        path = as_array(poses, "poses", (None, 7), error=DeviceError)
        self._n = len(path)
        ours, self.plug = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._memory = make_shared_memory(8 * _COLUMNS * self._n)
        self._table: NDArray[np.float64] | None
        self._table = np.ndarray((self._n, _COLUMNS), np.float64, self._memory.buf)
        self._table[:] = np.nan
        reports = [encode_pose(p[:3], p[3:], 0, i & 0xFFFF) for i, p in enumerate(path)]
        context = multiprocessing.get_context("spawn")
        self._go = context.Event()
        self._process = context.Process(
            target=_play,
            args=(ours, self._memory.name, reports, priority, self._go),
            name="virtual stylus",
            daemon=True,
        )
        self._process.start()
        ours.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def start(self) -> None:
        """Begin to send."""
        self.plug.close()  # the other process has its own by now
        self._go.set()

    def is_playing(self) -> bool:
        """Return whether the path is still being sent."""
        return self._process.is_alive()

    def felt(self) -> Felt:
        """Return the measurements so far."""
        assert self._table is not None, "unplugged"
        table = self._table.copy()
        sent = np.nan_to_num(table[:, 5:6]).copy().astype(np.int64)[:, 0]
        return Felt(table[:, 0] * 1e-3, table[:, 1:4], table[:, 4] * 1e-3, sent)

    def unplug(self) -> None:
        """Disconnect the device without notice."""
        if self._process.is_alive():
            self._process.kill()
        self._process.join()
        if self._table is not None:
            self._table = None
            self._memory.close()
            self._memory.unlink()


def _play(cable: socket.socket, name: str, reports: list[bytes], priority: int, go: Event) -> None:
    memory = SharedMemory(name=name)
    table = np.ndarray((len(reports), _COLUMNS), np.float64, memory.buf)
    if priority:
        gc.disable()
        if hasattr(os, "sched_setscheduler"):
            with suppress(OSError):
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    cable.setblocking(False)
    if go.wait(_PATIENCE_S):
        with suppress(BrokenPipeError, ConnectionResetError):  # the servo has hung up
            _send_all(cable, table, reports)
    del table
    memory.close()


def _send_all(cable: socket.socket, table: AnyArray, reports: list[bytes]) -> None:
    period = 1e-3  # s, as of a device
    start = time.monotonic() + 0.05
    for i, report in enumerate(reports):
        due = start + i * period
        _listen(cable, table, i, due - _SPIN_S)
        while time.monotonic() < due:
            pass
        now = time.monotonic_ns()
        with suppress(BlockingIOError):  # nobody reads: lost, as on a real cable
            cable.send(report)
            table[i, 4], table[i, 5] = now - due * 1e9, now
    _listen(cable, table, len(reports), start + (len(reports) + 20) * period)


def _listen(cable: socket.socket, table: AnyArray, n_sent: int, until: float) -> None:
    """Receive forces until a time; the answer to pose i carries its number."""
    while (left := until - time.monotonic()) > 0.0:
        if not select.select([cable], [], [], left)[0]:
            return
        data = cable.recv(64)
        now = time.monotonic_ns()
        if not data:
            raise BrokenPipeError
        force, number = decode_force(data)
        at = n_sent - 1 - ((n_sent - 1 - number) & 0xFFFF)
        if 0 <= at < n_sent and np.isnan(table[at, 0]):
            table[at, 0] = now - table[at, 5]
            table[at, 1:4] = force

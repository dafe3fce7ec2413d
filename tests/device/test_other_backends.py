"""Backends that call us and backends that are asked, against stand-ins."""

from __future__ import annotations

import ctypes
import json
import math
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.server import serve

from paint3d.core.quaternion import rotate
from paint3d.device.force.force_port import SocketForcePort
from paint3d.device.force.haptic_stylus import decode_force, encode_pose
from paint3d.device.force.inverse3 import MAX_FORCE_N as INVERSE3_LIMIT
from paint3d.device.force.inverse3 import Inverse3Port
from paint3d.device.force.openhaptics import WORLD_FROM_OPENHAPTICS, OpenHapticsPort
from paint3d.device.sample import BARREL, DIP
from paint3d.errors import DeviceError
from tests.support.styli import compile_library

MS = 1_000_000


class Loop:
    """Takes poses, gives a force, and stops after so many."""

    def __init__(self, last: int, force=(0.1, 0.2, 0.3), fault: Exception | None = None) -> None:
        self.last, self.force, self.fault = last, force, fault
        self.poses: list = []
        self.silences = self.n_sent = self.n_refused = 0

    def step(self, pose, now_ns):
        if pose is None:
            self.silences += 1
            return (0.0, 0.0, 0.0)
        self.poses.append(pose)
        if self.fault is not None and len(self.poses) == self.last:
            raise self.fault
        return self.force

    def sent(self) -> None:
        self.n_sent += 1

    def refused(self) -> None:
        self.n_refused += 1

    def stopped(self) -> bool:
        return self.fault is None and len(self.poses) >= self.last


# -- OpenHaptics ------------------------------------------------------------------------------


@pytest.fixture
def library(tmp_path) -> Path:
    return compile_library(tmp_path)


def told(library: Path) -> tuple[ctypes.CDLL, np.ndarray]:
    lib = ctypes.CDLL(str(library))
    n = ctypes.c_int.in_dll(lib, "calls").value
    table = ((ctypes.c_double * 3) * 100000).in_dll(lib, "forces")
    return lib, np.array([list(table[i]) for i in range(n)])


def number(lib: ctypes.CDLL, name: str) -> int:
    return ctypes.c_int.in_dll(lib, name).value


def test_openhaptics_calls_and_is_answered(library) -> None:
    loop = Loop(100)
    OpenHapticsPort(library=str(library)).run(loop)
    lib, forces = told(library)
    assert len(loop.poses) == 100
    assert loop.n_sent == 100
    assert np.allclose(forces[:100], [0.1, 0.2, 0.3])
    assert not forces[-1].any()  # the last thing that it is told
    pose = loop.poses[60]
    assert np.allclose(pose.position, [5.0, 6.0, -3.0])
    assert pose.buttons == BARREL
    turned = rotate(np.array(pose.orientation), np.eye(3))
    assert np.allclose(turned, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-12)
    assert (number(lib, "force_enabled"), number(lib, "disabled")) == (0, 1)
    assert number(lib, "frames_without_begin") == 0


def test_openhaptics_axes_become_ours() -> None:
    turned = rotate(np.array(WORLD_FROM_OPENHAPTICS), np.eye(3))
    assert np.allclose(turned, [[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # up is z, towards us is -y


def test_openhaptics_never_pushes_beyond_the_device(library) -> None:
    OpenHapticsPort(library=str(library)).run(Loop(5, (3.0, 3.0, 3.0)))
    _, forces = told(library)
    assert np.linalg.norm(forces, axis=1).max() == pytest.approx(3.3)


@pytest.mark.parametrize("fault", [ValueError("broken"), DeviceError("broken")])
def test_a_fault_in_the_servo_ends_openhaptics_in_no_force(library, fault) -> None:
    with pytest.raises(DeviceError, match="broken"):
        OpenHapticsPort(library=str(library)).run(Loop(20, fault=fault))
    lib, forces = told(library)
    assert len(forces) == 20
    assert not forces[-1].any()
    assert number(lib, "force_enabled") == 0


def test_a_force_that_is_not_finite_is_never_handed_over(library) -> None:
    with pytest.raises(DeviceError, match="not finite"):
        OpenHapticsPort(library=str(library)).run(Loop(20, (math.nan, 0.0, 0.0)))
    assert np.isfinite(told(library)[1]).all()


def test_an_error_of_the_library_is_told(library) -> None:
    ctypes.c_int.in_dll(ctypes.CDLL(str(library)), "fail_at").value = 30
    with pytest.raises(DeviceError, match="0x302"):
        OpenHapticsPort(library=str(library)).run(Loop(1000))


def test_a_device_that_was_asleep_is_opened_when_it_is_asked_for_again(library) -> None:
    port, refuse = OpenHapticsPort(library=str(library)), ctypes.CDLL(str(library))
    ctypes.c_int.in_dll(refuse, "refuse").value = 1
    with pytest.raises(DeviceError, match="cannot open the device; expected one that"):
        port.read_limits()
    ctypes.c_int.in_dll(refuse, "refuse").value = 0
    assert port.read_limits() == (3.3, 0.4)


def test_no_openhaptics_device_and_no_library(library) -> None:
    ctypes.c_int.in_dll(ctypes.CDLL(str(library)), "refuse").value = 1
    with pytest.raises(DeviceError, match="cannot open"):
        OpenHapticsPort(library=str(library)).run(Loop(1))
    with pytest.raises(DeviceError, match="comes with the maker's driver"):
        OpenHapticsPort(library="libNoSuchHD.so").run(Loop(1))


# -- reports over a cable --------------------------------------------------------------------


class Restless(Loop):
    """Pushes in silences too, so that only the port itself can end in no force."""

    def step(self, pose, now_ns):
        super().step(pose, now_ns)
        return self.force


def test_a_fault_in_the_servo_ends_in_no_force() -> None:
    cable, plug = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    felt = []

    def be_felt_and_move() -> None:
        felt.append(decode_force(cable.recv(64))[0])
        cable.send(encode_pose([0, 0, 0], [1, 0, 0, 0]))

    hand = threading.Thread(target=be_felt_and_move)
    hand.start()
    loop = Restless(1, fault=ValueError("broken"))
    with pytest.raises(ValueError, match="broken"):
        SocketForcePort(plug).run(loop)
    hand.join()
    while report := cable.recv(64):
        felt.append(decode_force(report)[0])
    cable.close()
    assert felt[0] == (0.1, 0.2, 0.3)
    assert felt[-1] == (0.0, 0.0, 0.0)


# -- Haply Inverse3 ---------------------------------------------------------------------------


class Service:
    """Stands in for the Inverse3 service: a state, and one more for every force."""

    def __init__(self, broken_at: int = -1, silent_at: int = -1, closes_at: int = -1) -> None:
        self.broken_at, self.silent_at, self.closes_at = broken_at, silent_at, closes_at
        self.messages: list[dict] = []
        self.n_late: int | None = None
        self.server = serve(self.talk, "127.0.0.1", 0)
        self.uri = f"ws://127.0.0.1:{self.server.socket.getsockname()[1]}"
        self.thread = threading.Thread(target=self.server.serve_forever, daemon=True)
        self.thread.start()

    def talk(self, socket) -> None:
        with suppress(ConnectionClosed):
            self.answer(socket)

    def answer(self, socket) -> None:
        socket.send(self.state(0))
        for message in socket:
            self.messages.append(json.loads(message))
            n = len(self.messages)
            if n == self.closes_at:
                return
            if n == self.silent_at:
                self.wait_for_no_force(socket)
            with suppress(ConnectionClosed):  # what was sent before it was closed is still read
                socket.send("{" if n == self.broken_at else self.state(n))

    def wait_for_no_force(self, socket) -> None:
        """Say nothing until three messages in a row let go; more than these are on their way."""
        since = len(self.messages)
        while len(self.messages) < since + 3 or self.forces()[-3:].any():
            self.messages.append(json.loads(socket.recv(timeout=300.0)))
        self.n_late = int(self.forces()[since:].any(axis=1).sum())

    def state(self, n: int) -> str:
        place = {"x": 0.001 * n, "y": 0.02, "z": 0.1}
        grip = {"orientation": {"w": 1.0, "x": 0, "y": 0, "z": 0}, "buttons": {"b": n > 10}}
        return json.dumps(
            {
                "inverse3": [{"device_id": "0A", "state": {"cursor_position": place}}],
                "wireless_verse_grip": [{"device_id": "1B", "state": grip}],
            }
        )

    def forces(self) -> np.ndarray:
        sent = [m["inverse3"][0] for m in self.messages]
        assert {s["device_id"] for s in sent} == {"0A"}
        values = [s["commands"]["set_cursor_force"]["values"] for s in sent]
        return np.array([[v["x"], v["y"], v["z"]] for v in values])

    def close(self) -> None:
        self.server.shutdown()
        self.thread.join()


def run_inverse3(loop: Loop, silence_s: float = 0.002, **more) -> Service:
    service = Service(**more)
    try:
        Inverse3Port(service.uri, silence_s).run(loop)
        until = time.monotonic() + 300.0
        while not service.messages or service.forces()[-1].any():
            assert time.monotonic() < until, service.messages[-1:]
            time.sleep(0.01)
        time.sleep(0.05)
    finally:
        service.close()
    return service


def test_the_inverse3_is_asked_and_answered() -> None:
    loop = Loop(40)
    service = run_inverse3(loop, silence_s=120.0)  # a machine that is late is not silent
    *pushing, last = service.forces()
    assert np.allclose(pushing, [0.1, 0.2, 0.3])
    assert len(pushing) == 39
    assert not last.any()
    assert np.allclose(loop.poses[20].position, [20.0, 20.0, 100.0])
    assert (loop.poses[5].buttons, loop.poses[20].buttons) == (0, DIP)


def test_an_inverse3_that_pauses_or_stammers() -> None:
    loop = Loop(60)  # as above, but a silence has to be noticed
    service = run_inverse3(loop, silence_s=0.25, broken_at=10, silent_at=20)
    assert loop.n_refused == 1
    assert loop.silences > 1
    assert service.n_late is not None  # while it was silent it was let go,
    assert service.n_late <= 2  # but for what was on its way
    assert service.forces()[-10:].any()  # and then held again
    place = np.array([pose.position[0] for pose in loop.poses])
    assert (np.diff(place) > 0).all()  # nothing twice, nothing out of order


def test_an_inverse3_service_that_goes_or_was_never_there() -> None:
    with pytest.raises(DeviceError, match="has gone or does not run"):
        run_inverse3(Loop(1000), closes_at=15)
    with pytest.raises(DeviceError, match="does not run"):
        Inverse3Port("ws://127.0.0.1:9").run(Loop(1))


def test_a_force_beyond_the_inverse3_is_never_sent() -> None:
    with pytest.raises(DeviceError, match="at most"):
        run_inverse3(Loop(5, (INVERSE3_LIMIT + 0.1, 0.0, 0.0)))

"""The servo as a process: it answers, its samples arrive, and any fault ends in no force."""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from paint3d.bench.registry import run_benchmark
from paint3d.brush.presets import load_brush
from paint3d.device.force_port import SocketForcePort
from paint3d.device.haptic_stylus import decode_force, encode_pose
from paint3d.device.virtual_stylus import VirtualStylus
from paint3d.haptics.realtime import SCHEDULES
from paint3d.haptics.servo import ForceFeedback
from paint3d.haptics.settings import HapticSettings
from paint3d.haptics.shared_state import RING_COLUMNS, ServoBoard, TreeBlock, percentile_us
from paint3d.mesh.solids import make_plane
from paint3d.pose.calibration import DeviceCalibration
from paint3d.surface.painted_surface import PaintedSurface

ROOT = Path(__file__).parents[2]
BRUSH = load_brush("full")
SETTINGS = HapticSettings.for_brush(BRUSH, rise_s=0.1)
SPRING = BRUSH.spring
LIFTED, PRESSED = [0, 0, 60.0], [0, 0, 29.0]
UPRIGHT = [1, 0, 0, 0]


@pytest.fixture(scope="module")
def tree():
    return PaintedSurface(make_plane(), resolution=None).contact_tree


class Device:
    """The device's end of the cable, in this process."""

    def __init__(self) -> None:
        self.cable, self.plug = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.number = 0

    def send(self, position, orientation=UPRIGHT) -> None:
        self.number += 1
        self.cable.send(encode_pose(position, orientation, 0, self.number))

    def force(self, patience: float = 1.0):
        """The next force, or None when the servo has hung up."""
        if not select.select([self.cable], [], [], patience)[0]:
            raise AssertionError("no force came")
        try:
            data = self.cable.recv(64)
        except ConnectionResetError:  # told once; what was sent before is still to be read
            data = self.cable.recv(64)
        return np.array(decode_force(data)[0]) if data else None

    def press(self, milliseconds: int, position=PRESSED, orientation=UPRIGHT):
        """Hold the pen at a place; the strongest force that came (a slow machine leaves gaps)."""
        strongest = np.zeros(3)
        for _ in range(milliseconds):
            self.send(position, orientation)
            force = self.force()
            if np.linalg.norm(force) >= np.linalg.norm(strongest):
                strongest = force
            time.sleep(0.0005)
        return strongest

    def until_quiet(self, seconds: float = 2.0, keep_sending: bool = False) -> float:
        """Seconds until only zeros came (or the servo hung up, its last force being none)."""
        started, last, n_zeros, since = time.monotonic(), None, 0, 0.0
        while time.monotonic() - started < seconds:
            if keep_sending:
                try:
                    self.send(PRESSED)
                except OSError:
                    keep_sending = False
            now = self.force()
            if now is None:
                assert last is not None
                assert not last.any()
                return time.monotonic() - started
            if now.any() or n_zeros == 0:
                n_zeros, since = 0, time.monotonic() - started
            last, n_zeros = now, n_zeros + (not now.any())
            if n_zeros == 20:
                return since
        raise AssertionError(f"still {last} N after {seconds} s")


@pytest.fixture
def device():
    device = Device()
    yield device
    device.plug.close()
    device.cable.close()


def spring_now(feedback: ForceFeedback) -> float:
    """N/mm: softer than the brush where this machine is late too often."""
    return SPRING * feedback.status().softening


def keep_alive(feedback: ForceFeedback, device: Device, milliseconds: int, position=PRESSED):
    forces = [np.zeros(3)]
    for _ in range(milliseconds):
        feedback.publish()
        forces.append(device.press(1, position))
    return max(forces, key=np.linalg.norm)


def test_it_answers_and_its_samples_arrive(tree, device) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        device.plug.close()
        keep_alive(feedback, device, 20, LIFTED)
        force = keep_alive(feedback, device, 250)
        assert np.allclose(force, [0, 0, 6.0 * spring_now(feedback)], rtol=0.05)
        readings = feedback.take()
        status = feedback.status()
    assert len(readings) == device.number == status.steps
    assert np.allclose(readings[-1].position, PRESSED)
    assert (np.diff([r.time_ns for r in readings]) > 0).all()
    assert status.state == "running"
    assert status.schedule in SCHEDULES
    assert (status.lost, status.refused, status.fault) == (0, 0, "")
    assert status.step_p99_us < status.worst_step_us + 10.0
    assert device.until_quiet() < 1.0


def test_the_device_may_stand_anywhere(tree, device) -> None:
    turned = DeviceCalibration([0.5, 0.5, 0.5, 0.5], [10.0, 20.0, 30.0], 2.0)  # z is 2 y + 30
    pen = np.array([0.5, -0.5, -0.5, -0.5])  # upright in the world
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS, turned) as feedback:
        forces = []
        for position in [[0, 30.0, 0]] * 20 + [[0, -0.5, 0]] * 300:
            feedback.publish()
            forces.append(device.press(1, position, pen))
        strongest = max(forces, key=np.linalg.norm)
        assert np.allclose(strongest, [0, 6.0 * spring_now(feedback), 0], rtol=0.05)
        assert np.allclose(feedback.take()[-1].position, [10.0, 20.0, 29.0])


def test_the_force_follows_the_object(tree, device) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        keep_alive(feedback, device, 20, LIFTED)
        forces = []
        for i in range(450):
            feedback.publish([0, 0, min(i * 0.1, 31.0), 1, 0, 0, 0])  # the left hand lifts it
            before = spring_now(feedback)  # it softens and hardens with how busy the machine is
            forces.append((*device.press(1, LIFTED), before, spring_now(feedback)))
        forces = np.array(forces)
        strongest = forces[forces[:, 2].argmax()]
        softest, hardest = sorted(strongest[3:])
        assert np.allclose(strongest[:2], 0.0)
        assert 0.95 * 6.0 * softest <= strongest[2] <= 1.05 * 6.0 * hardest


def test_a_silent_device_gets_no_force(tree, device) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        keep_alive(feedback, device, 20, LIFTED)
        assert keep_alive(feedback, device, 200)[2] > 0.7
        assert device.until_quiet() < 0.1  # 5 ms, and what the machine adds


def test_a_program_that_hangs_gets_no_force(tree, device) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        keep_alive(feedback, device, 20, LIFTED)
        assert keep_alive(feedback, device, 200)[2] > 0.7
        waited = device.until_quiet(keep_sending=True)  # and nobody publishes
        assert 0.1 < waited < 0.8


def test_garbage_is_counted_and_does_not_stop_it(tree, device) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        keep_alive(feedback, device, 20, LIFTED)
        for report in (b"\xff" * 25, b"\x01", encode_pose([0, 0, 5000.0], UPRIGHT)):
            device.cable.send(report)
            assert not device.force().any()
        assert keep_alive(feedback, device, 250)[2] > 0.7
        assert feedback.status().refused == 3
        assert feedback.status().state == "running"


def test_a_device_that_goes_is_reported(tree, device) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        keep_alive(feedback, device, 20)
        device.plug.close()
        device.cable.close()
        end = time.monotonic() + 5.0
        while feedback.is_running() and time.monotonic() < end:
            time.sleep(0.01)
        status = feedback.status()
    assert status.state == "failed"
    assert "has gone" in status.fault


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_in_no_force(tree, device, number) -> None:
    with ForceFeedback(SocketForcePort(device.plug), tree, SETTINGS) as feedback:
        device.plug.close()
        keep_alive(feedback, device, 20, LIFTED)
        assert keep_alive(feedback, device, 200)[2] > 0.7
        os.kill(feedback._process.pid, number)
        device.until_quiet(keep_sending=True)


PARENT = """
import signal, socket, sys, time
from paint3d.device.force_port import SocketForcePort
from paint3d.haptics.servo import ForceFeedback
from tests.devices.test_servo import SETTINGS, make_plane
from paint3d.surface.painted_surface import PaintedSurface
if __name__ == "__main__":
    plug = socket.socket(fileno=int(sys.argv[1]))
    tree = PaintedSurface(make_plane(), resolution=None).contact_tree
    feedback = ForceFeedback(SocketForcePort(plug), tree, SETTINGS)
    plug.close()
    print(feedback._process.pid, flush=True)
    while True:
        feedback.publish()
        time.sleep(0.01)
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
def test_the_program_is_killed_and_the_force_is_zero(device, tmp_path, number) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    parent = subprocess.Popen(
        [sys.executable, str(script), str(device.plug.fileno())],
        pass_fds=[device.plug.fileno()],
        stdout=subprocess.PIPE,
        env=dict(os.environ, PYTHONPATH=str(ROOT)),
        text=True,
    )
    servo = 0
    try:
        servo = int(parent.stdout.readline())
        device.plug.close()
        device.press(20, LIFTED)
        assert device.press(300)[2] > 0.7
        parent.send_signal(number)
        device.until_quiet(keep_sending=True)
        if number == signal.SIGKILL:
            assert not is_alive(servo)  # it went with its parent, not because of an old snapshot
        else:
            assert is_alive(servo, patience=0.1)
    finally:
        parent.kill()
        parent.wait()
        parent.stdout.close()
    assert not is_alive(servo)


def is_alive(pid: int, patience: float = 2.0) -> bool:
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            os.kill(pid, 0)
            if Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z":
                return False
        except (ProcessLookupError, FileNotFoundError):
            return False
        time.sleep(0.01)
    return True


def test_an_unplugged_virtual_stylus(tree) -> None:
    poses = np.tile([*PRESSED, *UPRIGHT], (5000, 1))
    poses[:50, 2] = 60.0
    with (
        VirtualStylus(poses) as stylus,
        ForceFeedback(SocketForcePort(stylus.plug), tree, SETTINGS) as feedback,
    ):
        stylus.start()
        for _ in range(60):
            feedback.publish()
            time.sleep(0.01)
        felt = stylus.felt()
        stylus.unplug()
        end = time.monotonic() + 5.0
        while feedback.is_running() and time.monotonic() < end:
            time.sleep(0.01)
        assert "has gone" in feedback.status().fault
        readings = feedback.take()
    answered = np.isfinite(felt.round_trip_us)
    assert answered.sum() > 200
    assert 0.25 * 6.0 * SPRING < np.nanmax(felt.force[:, 2]) <= 6.0 * SPRING + 1e-3
    assert (np.linalg.norm(felt.force[answered], axis=1) <= 7.9).all()
    sent = int(np.count_nonzero(felt.sent_ns))
    assert sent <= len(readings) <= sent + 60  # what was on its way at the last look


# -- shared memory ----------------------------------------------------------------------------


def _write_snapshots(name: str, stop) -> None:
    board = ServoBoard(name)
    i = 0
    while not stop.is_set():
        board.publish(i, np.full(7, i), np.full(16, i))
        i += 1
    board.close()


def test_a_snapshot_is_never_torn() -> None:
    board = ServoBoard()
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    writer = context.Process(target=_write_snapshots, args=(board.name, stop))
    row, seen = np.zeros(32), set()
    assert not board.read_snapshot(row)
    writer.start()
    end = time.monotonic() + 30.0
    while len(seen) < 100 and time.monotonic() < end:
        if board.read_snapshot(row):
            assert (row[1:24] == row[1]).all()
            assert row[:1].view(np.int64)[0] == row[1]
            seen.add(row[1])
    stop.set()
    writer.join()
    board.close()
    assert len(seen) == 100


def test_the_ring_says_what_it_lost() -> None:
    board, row = ServoBoard(), np.zeros(RING_COLUMNS)
    for i in range(20_000):
        row[1] = i
        board.push(row)
    rows, lost = board.take()
    assert len(rows) + lost == 20_000
    assert rows[-1, 1] == 19_999
    assert (np.diff(rows[:, 1]) == 1).all()
    assert board.take()[0].shape == (0, RING_COLUMNS)
    board.close()


def test_a_tree_is_handed_over_whole(tree) -> None:
    block, memory = TreeBlock.share(tree)
    copy, attached = block.attach()
    for mine, theirs in zip(tree, copy, strict=True):
        assert mine.dtype == theirs.dtype
        assert np.array_equal(mine, theirs)
    del copy, mine, theirs
    attached.close()
    memory.close()
    memory.unlink()


def test_percentiles_of_a_histogram() -> None:
    bins = np.zeros(1000, np.int64)
    bins[[10, 50]] = 98, 2
    assert percentile_us(bins, 50.0) == 110.0
    assert percentile_us(bins, 99.0) == 510.0
    assert np.isnan(percentile_us(bins * 0, 99.0))


# -- the benchmark ----------------------------------------------------------------------------


def test_the_benchmark_measures() -> None:
    result = run_benchmark("haptics", share=0.03)
    found = {check.name: check.value for check in result.checks}
    assert found["samples lost"] == 0.0
    assert 0.5 < found["strongest force"] <= 7.9
    assert found["pose to force and back, p99"] > 0.0
    assert result.rows[1][1] == pytest.approx(1000.0, rel=0.2)  # its period is a millisecond

"""The servo's process: reads the pose, computes the force and sends it, a thousand times a second.

Neither this process nor the program ever waits for the other. However the loop ends (a stop, a
signal, the device gone, an error, the parent killed), the last force that the port sends is zero.
"""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.machine import ENDING, end_with_parent
from paint3d.core.quaternion import multiply, turn
from paint3d.device.force.force_port import ForcePort
from paint3d.device.force.haptic_stylus import PoseNumbers
from paint3d.errors import DeviceError, Message
from paint3d.haptics import shared_state
from paint3d.haptics.kernels import state as hs
from paint3d.haptics.kernels.step import servo_step
from paint3d.haptics.realtime import SCHEDULES, ask_for_speed, keep_in_memory
from paint3d.haptics.shared_state import RING_COLUMNS, SNAPSHOT_COLUMNS, ServoBoard, TreeBlock
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.pose.calibration import DeviceCalibration

__all__ = ["ServoTask", "new_state", "run_servo"]

_LATE_NS = 2_000_000
_LONGEST_DT_S, _SHORTEST_DT_S = 0.005, 0.0001
_STEADY = 256  # steps over which the fraction of late ones is measured
_HARMLESS, _GRAVE = 0.02, 0.20  # fraction of late steps at which softening begins and is greatest
_SOFTEST = 0.3
_LONG_AGO_S = 1e9


@dataclass(frozen=True)
class ServoTask:
    """Arguments of the process; all can be pickled."""

    port: ForcePort
    tree: TreeBlock
    board: str
    calibration: DeviceCalibration
    parent: int


class _Servo:
    """The `ForceLoop` of the process; whatever a step needs is allocated before the loop."""

    def __init__(self, task: ServoTask, tree: ContactTree, board: ServoBoard) -> None:
        self.tree, self.board, self.parent = tree, board, task.parent
        calibration = task.calibration
        w, x, y, z = calibration.rotation.tolist()
        self._rotation = (w, x, y, z)
        self._back = (w, -x, -y, -z)
        self._scale, self._shift = calibration.scale, calibration.shift.tolist()
        self._state = new_state()
        self._snapshot = np.zeros(SNAPSHOT_COLUMNS)
        self._snapshot_ns = self._snapshot[:1].view(np.int64)
        self._target = self._snapshot[1:8]
        self._settings = self._snapshot[8 : 8 + hs.N_SETTINGS].view(hs.SETTINGS)
        self._has_snapshot = False
        self._row = np.zeros(RING_COLUMNS)
        self._row_ns = self._row[:1].view(np.int64)
        self._pose = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        self._out = np.zeros(3)
        self._pose_ns = self._last_ns = self._last_pose_ns = self._began_ns = self._worst_ns = 0
        self._answered: PoseNumbers | None = None
        self._flags = 0
        self._recent_late = 0
        self.stopping = False

    def warm_up(self) -> None:
        """Compile and load every kernel before the device is opened."""
        settings, moment = (
            np.ones(hs.N_SETTINGS).view(hs.SETTINGS),
            hs.Moment(0.001, 0.0, 0.0, True),
        )
        servo_step(self.tree, settings, new_state(), self._pose, self._pose, moment, self._out)

    def stopped(self) -> bool:
        """Return whether the loop must end."""
        is_orphan = os.getppid() != self.parent
        return self.stopping or is_orphan or self.board.counters[shared_state.STOP] != 0

    def refused(self) -> None:
        """Count a report that could not be read."""
        self.board.counters[shared_state.REFUSED] += 1

    def step(self, pose: PoseNumbers | None, now_ns: int) -> tuple[float, float, float]:
        """Return the force, N, in the device's frame."""
        if pose is not None:  # into the world's frame
            x, y, z = turn(self._rotation, pose.position)
            scale, (dx, dy, dz), world = self._scale, self._shift, self._pose
            world[0], world[1], world[2] = scale * x + dx, scale * y + dy, scale * z + dz
            world[3:] = multiply(self._rotation, pose.orientation)
            self._pose_ns = pose.time_ns
        dt = (now_ns - self._last_ns) * 1e-9 if self._last_ns else 0.001
        self._last_ns = now_ns
        if self.board.read_snapshot(self._snapshot):
            self._has_snapshot = True
        moment = hs.Moment(
            min(max(dt, _SHORTEST_DT_S), _LONGEST_DT_S),
            (now_ns - self._pose_ns) * 1e-9 if self._pose_ns else _LONG_AGO_S,
            (now_ns - int(self._snapshot_ns[0])) * 1e-9 if self._has_snapshot else _LONG_AGO_S,
            self.stopped(),
        )
        self._flags = servo_step(
            self.tree, self._settings, self._state, self._target, self._pose, moment, self._out
        )
        self._answered, self._began_ns = pose, now_ns
        x, y, z = self._out.tolist()
        return turn(self._back, (x, y, z))

    def sent(self) -> None:
        """Record the last step's times and its sample."""
        pose = self._answered
        if pose is None:
            self._last_pose_ns = 0
            return
        spent = time.monotonic_ns() - self._began_ns
        board = self.board
        board.count(board.durations, spent)
        if spent > self._worst_ns:
            self._worst_ns = spent
            board.counters[shared_state.WORST_STEP_NS] = spent
        self._note_period(self._began_ns)
        row = self._row
        self._row_ns[0] = pose.time_ns
        row[1:8] = self._pose
        row[8] = pose.buttons
        row[9:12] = self._out
        row[12] = self._state[0]["descent"]
        row[13] = self._flags
        board.push(row)

    def _note_period(self, now_ns: int) -> None:
        """Record the time since the last pose; after a silence of the device there is none."""
        counters = self.board.counters
        if self._last_pose_ns:
            period = now_ns - self._last_pose_ns
            late = period > _LATE_NS
            self.board.count(self.board.periods, period)
            counters[shared_state.LATE] += late
            counters[shared_state.LONGEST_NS] = max(counters[shared_state.LONGEST_NS], period)
            self._recent_late += late
        counters[shared_state.STEPS] += 1
        counters[shared_state.BEAT_NS] = now_ns
        self._last_pose_ns = now_ns
        if counters[shared_state.STEPS] % _STEADY == 0:
            self._soften(self._recent_late / _STEADY)
            self._recent_late = 0

    def _soften(self, late: float) -> None:
        """Soften the spring by the fraction of late steps, at once; it recovers slowly.

        A loop that is often late is unstable with a stiff spring.
        """
        excess = min(1.0, max(0.0, (late - _HARMLESS) / (_GRAVE - _HARMLESS)))
        target = 1.0 - (1.0 - _SOFTEST) * excess
        current = float(self._state[0]["softening"])
        softening = min(target, current + 0.02) if target > current else target
        self._state["softening"] = softening
        self.board.counters[shared_state.SOFTENING_PPM] = int(1e6 * softening)


def new_state() -> NDArray[np.void]:
    """Return the servo's state before its first step, (1,) STATE."""
    state = np.zeros(1, hs.STATE)
    state["softening"] = 1.0
    state["object_turn"][:, 0] = 1.0
    return state


def run_servo(task: ServoTask) -> None:
    """Run the servo: main function of its process."""
    end_with_parent(lambda _: signal.raise_signal(signal.SIGTERM))
    board = ServoBoard(task.board)
    counters = board.counters
    counters[shared_state.PID] = os.getpid()
    tree, memory = task.tree.attach()
    servo = _Servo(task, tree, board)

    def stop(*_: object) -> None:
        servo.stopping = True

    for number in ENDING:
        signal.signal(number, stop)
    servo.warm_up()
    keep_in_memory()
    counters[shared_state.SCHEDULE] = SCHEDULES.index(ask_for_speed())
    counters[shared_state.STATE] = shared_state.RUNNING
    try:
        task.port.run(servo)
        counters[shared_state.STATE] = shared_state.STOPPED
    except Exception as fault:  # of any kind: the program must learn of it
        board.store_fault(fault.message if isinstance(fault, DeviceError) else Message(repr(fault)))
        counters[shared_state.STATE] = shared_state.FAILED
    finally:
        del servo.tree, tree
        memory.close()

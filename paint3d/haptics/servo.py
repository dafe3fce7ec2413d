"""Force feedback for a program: starts the servo, publishes the object's pose, takes samples."""

from __future__ import annotations

import multiprocessing
import os
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from paint3d.core.arrays import as_array
from paint3d.device.force.force_port import ForcePort, HidForcePort
from paint3d.device.force.haptic_stylus import encode_force
from paint3d.device.hid_link import open_node
from paint3d.device.sample import StylusReading
from paint3d.errors import DeviceError, Message
from paint3d.haptics import shared_state
from paint3d.haptics.realtime import SCHEDULES
from paint3d.haptics.servo_process import ServoTask, run_servo
from paint3d.haptics.settings import HapticSettings
from paint3d.haptics.shared_state import ServoBoard, TreeBlock, percentile_us
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.pose.calibration import DeviceCalibration

__all__ = ["ForceFeedback", "ServoStatus"]

_START_S = 120.0  # the first start may compile the kernels
_STOP_S = 2.0
_STATES = ("starting", "running", "stopped", "failed")


@dataclass(frozen=True, slots=True)
class ServoStatus:
    """State and timing of the servo.

    Attributes
    ----------
    state : {"starting", "running", "stopped", "failed"}
    schedule : {"fifo", "slice", "plain"}
    steps, late : int
        Steps, and how many came more than 2 ms after the one before.
    period_p50_us, period_p99_us, longest_us : float
    step_p99_us, worst_step_us : float
        From the pose's arrival in the servo to the force, without the device's own delay.
    refused : int
        Reports that could not be read.
    lost : int
        Samples that were not taken in time.
    softening : float
        Fraction of the stiffness in use; below 1 if the servo is late too often.
    fault : Message or None
        Why it failed; None if it did not.
    """

    state: str
    schedule: str
    steps: int
    late: int
    period_p50_us: float
    period_p99_us: float
    longest_us: float
    step_p99_us: float
    worst_step_us: float
    refused: int
    lost: int
    softening: float
    fault: Message | None = None


class ForceFeedback:
    """A servo process for one device and one surface; use it in a ``with`` block.

    `publish` must be called at least five times a second (a window does so with every frame): a
    program that hangs lets the force fall to zero after 200 ms.

    Parameters
    ----------
    port : ForcePort
    tree : ContactTree
        Of the surface (`PaintedSurface.contact_tree`); shared once, since the shape never changes.
    settings : HapticSettings
    calibration : DeviceCalibration, optional
        world_from_device.

    Attributes
    ----------
    last_force : (3,) float64
        Force of the last step that `take` returned, N.

    Raises
    ------
    DeviceError
        If the process does not start, or the shared memory cannot be allocated.
    """

    def __init__(
        self,
        port: ForcePort,
        tree: ContactTree,
        settings: HapticSettings,
        calibration: DeviceCalibration | None = None,
    ) -> None:
        self.settings = settings
        self._port = port
        self._board = ServoBoard()
        self._board.counters[shared_state.SOFTENING_PPM] = 1_000_000
        try:
            block, self._tree_memory = TreeBlock.allocate(tree)
        except BaseException:
            self._board.close()
            raise
        self._object_pose = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        self._lost = self._clicks = 0
        self._closed = False
        self.last_force = np.zeros(3)
        self.publish()
        task = ServoTask(
            port, block, self._board.name, calibration or DeviceCalibration(), os.getpid()
        )
        context = multiprocessing.get_context("spawn")
        self._process = context.Process(target=run_servo, args=(task,), name="servo", daemon=True)
        self._process.start()
        try:
            end = time.monotonic() + _START_S
            while self._board.counters[shared_state.STATE] == shared_state.STARTING:
                if not self._process.is_alive() or time.monotonic() > end:
                    why = self._board.fault() or Message(
                        "exit status {status}", status=self._process.exitcode
                    )
                    raise DeviceError("the servo did not start: {why}", why=why)
                time.sleep(0.01)
        except BaseException:
            self.stop()
            raise

    def __enter__(self) -> ForceFeedback:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def publish(self, object_pose: ArrayLike | None = None) -> None:
        """Publish the object's pose and the settings to the servo; also serves as a heartbeat.

        Parameters
        ----------
        object_pose : (7,) array_like, optional
            world_from_object, position in mm and unit quaternion; None: unchanged.

        Raises
        ------
        DeviceError
            If the numbers are not finite.
        """
        if object_pose is not None:
            self._object_pose = as_array(object_pose, "object_pose", (7,), error=DeviceError)
        record = self.settings.as_record()
        record["clicks"] = self._clicks
        self._board.publish(time.monotonic_ns(), self._object_pose, record.view(np.float64))

    def click(self) -> None:
        """Play a click, as at the edge of an ink stone; see `HapticSettings.click_n`."""
        self._clicks += 1
        self.publish()

    def take(self) -> list[StylusReading]:
        """Return the stylus' readings since the last call, in the world's frame (calibrated)."""
        rows, lost = self._board.take()
        self._lost += lost
        if len(rows):
            self.last_force = rows[-1, 9:12].copy()
        times = rows[:, :1].copy().view(np.int64)[:, 0]
        return [
            StylusReading(int(t), row[1:4].copy(), row[4:8].copy(), None, int(row[8]))
            for t, row in zip(times, rows, strict=True)
        ]

    def status(self) -> ServoStatus:
        """Return the servo's state and timing."""
        board, counters = self._board, self._board.counters
        state = _STATES[int(counters[shared_state.STATE])]
        if state in ("starting", "running") and not self._process.is_alive():
            state = "failed"
        return ServoStatus(
            state,
            SCHEDULES[int(counters[shared_state.SCHEDULE])],
            int(counters[shared_state.STEPS]),
            int(counters[shared_state.LATE]),
            percentile_us(board.periods, 50.0),
            percentile_us(board.periods, 99.0),
            counters[shared_state.LONGEST_NS] * 1e-3,
            percentile_us(board.durations, 99.0),
            counters[shared_state.WORST_STEP_NS] * 1e-3,
            int(counters[shared_state.REFUSED]),
            self._lost,
            counters[shared_state.SOFTENING_PPM] * 1e-6,
            board.fault(),
        )

    @property
    def process_id(self) -> int | None:
        """Id of the servo's process."""
        return self._process.pid

    def is_running(self) -> bool:
        """Return whether the servo runs; if it was killed, set the device's force to zero."""
        if self._process.is_alive():
            return True
        self._zero_force()
        return False

    def stop(self) -> None:
        """Stop the servo, which sets the force to zero; idempotent."""
        if self._closed:
            return
        self._closed = True
        self._board.counters[shared_state.STOP] = 1
        self._process.join(_STOP_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        self._zero_force()
        self._tree_memory.close()
        self._tree_memory.unlink()
        self._board.close()

    def _zero_force(self) -> None:
        """Set the force to zero for a servo that was killed and could not."""
        if self._process.exitcode in (0, None) or not isinstance(self._port, HidForcePort):
            return
        try:
            link = open_node(self._port.node)
        except DeviceError:
            return
        link.write(encode_force((0.0, 0.0, 0.0)))
        link.close()

"""Two streams of time-stamped readings to one stream of samples.

The right hand sets the beat: every stylus reading gives one sample, none is lost and none is made
up. The left hand's deflection is integrated up to that very instant. Readings are taken in the
order of their times, whichever device they came from, up to a moment that both devices must have
reached; what is younger waits for the next call.
"""

from __future__ import annotations

import dataclasses
import heapq
import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from paint3d.device.sample import DeviceSample
from paint3d.device.stylus_reading import StylusReading
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.smoothing import SmoothedPose, SmoothingSettings, smooth_pose
from paint3d.pose.steering import ObjectPose, SteeringOptions, SteeringState, advance, report

__all__ = ["TwoHands"]


class TwoHands:
    """Merges the stylus and the 6-DOF mouse; no clock inside, so a replay repeats to the bit.

    Parameters
    ----------
    calibration : DeviceCalibration
        world_from_device of the stylus.
    steering : SteeringOptions
    smoothing : SmoothingSettings or None
        None passes readings as they are.
    time_ns : int
        When it begins.
    """

    def __init__(
        self,
        calibration: DeviceCalibration | None = None,
        steering: SteeringOptions | None = None,
        smoothing: SmoothingSettings | None = None,
        time_ns: int = 0,
    ) -> None:
        self.calibration = calibration or DeviceCalibration()
        self.steering = steering or SteeringOptions()
        self._smoothing = smoothing
        self._state = SteeringState(time_ns, ObjectPose())
        self._smoothed: SmoothedPose | None = None
        self._waiting: list[tuple[int, int, StylusReading | ArrayLike]] = []
        self._count = itertools.count()
        self._last_ns = time_ns - 1
        self.late = 0

    @property
    def object_pose(self) -> ObjectPose:
        """The object at the last time that was asked for."""
        return self._state.pose

    def add_stylus(self, readings: Iterable[StylusReading]) -> None:
        """Readings of the right hand."""
        for reading in readings:
            self._put(reading.time_ns, reading)

    def add_deflection(self, time_ns: int, deflection: ArrayLike) -> None:
        """What the left hand's cap said: (6,), see `paint3d.device.deflection`."""
        self._put(time_ns, np.array(deflection, dtype=np.float64))

    def set_object_pose(self, pose: ObjectPose) -> None:
        """Put the object elsewhere at once (recentred, or a session opened)."""
        self._state = dataclasses.replace(self._state, pose=pose)

    def take(self, until_ns: int) -> list[DeviceSample]:
        """Samples of everything up to `until_ns`, in the order of time.

        A reading that is older than what was already taken (`late` counts them) is put right after
        it: its pose is true, only its time is bent.
        """
        samples = []
        while self._waiting and self._waiting[0][0] <= until_ns:
            time_ns, _, what = heapq.heappop(self._waiting)
            if isinstance(what, StylusReading):
                samples += self._sample(time_ns, what)
            else:
                self._state = report(self.steering, self._state, time_ns, what)
        self._state = advance(self.steering, self._state, until_ns)
        return samples

    def _put(self, time_ns: int, what: StylusReading | ArrayLike) -> None:
        heapq.heappush(self._waiting, (time_ns, next(self._count), what))

    def _sample(self, time_ns: int, reading: StylusReading) -> list[DeviceSample]:
        if not reading.in_range:
            self._smoothed = None
            return []
        if time_ns <= self._last_ns:
            self.late += 1
            time_ns = self._last_ns + 1
        self._last_ns = time_ns
        self._state = advance(self.steering, self._state, time_ns)
        position, orientation = self.calibration.place(reading.position, reading.orientation)
        pressure = reading.pressure
        if self._smoothing is not None:
            self._smoothed = smooth_pose(
                self._smoothing, self._smoothed, time_ns, position, orientation, pressure
            )
            position, orientation = self._smoothed.position, self._smoothed.orientation
            pressure = self._smoothed.pressure
        thing = self._state.pose
        return [
            DeviceSample(
                time_ns,
                position,
                orientation,
                pressure,
                reading.buttons,
                thing.position,
                thing.orientation,
            )
        ]

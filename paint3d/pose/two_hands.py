"""Merging the time-stamped readings of both hands into one smoothed stream of samples.

The right hand sets the pace: every stylus reading gives exactly one sample, with the left hand's
deflection integrated up to its time. Readings are processed in the order of their times, whichever
device they came from, up to a time that both devices must have reached; later ones wait for the
next call.

Positions, orientations and pressures pass a 1-Euro filter: Casiez, Roussel and Vogel, *1 Euro
filter: a simple speed-based low-pass filter for noisy input in interactive systems*, CHI 2012. Slow
motion is smoothed much and fast motion little, since noise shows in slow motion and lag in fast. It
uses the samples' own time steps, so the result does not depend on a fixed rate. Unlike in the
paper, one cutoff for the whole pose follows its speed: smoothing the axes separately would bend
straight strokes.
"""

from __future__ import annotations

import dataclasses
import heapq
import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from paint3d.core.arrays import AnyArray, as_number
from paint3d.core.quaternion import slerp_one
from paint3d.device.sample import DeviceSample, StylusReading
from paint3d.errors import DeviceError
from paint3d.pose.calibration import DeviceCalibration
from paint3d.pose.steering import ObjectPose, SteeringOptions, SteeringState, advance, report

__all__ = ["SmoothingSettings", "TwoHands", "lag_s", "smooth_pose"]


@dataclass(frozen=True, slots=True)
class SmoothingSettings:
    """Parameters of the 1-Euro filter.

    Parameters
    ----------
    rest_hz : float
        Cutoff of a hand at rest.
    hz_per_mm_s : float
        Increase of the cutoff with the speed.
    speed_hz : float
        Cutoff of the speed's own low-pass filter.

    Raises
    ------
    DeviceError
        If one is out of range.
    """

    rest_hz: float = 8.0
    hz_per_mm_s: float = 0.6
    speed_hz: float = 10.0

    def __post_init__(self) -> None:
        as_number(self.rest_hz, "rest_hz", 0.1, 1000.0, DeviceError)
        as_number(self.hz_per_mm_s, "hz_per_mm_s", 0.0, 100.0, DeviceError)
        as_number(self.speed_hz, "speed_hz", 0.1, 1000.0, DeviceError)


@dataclass(frozen=True, eq=False, slots=True)
class _SmoothedPose:
    """State and output of the filter: position (3,) mm, orientation (4,), pressure or None."""

    time_ns: int
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    raw_position: NDArray[np.float64]
    velocity: NDArray[np.float64]


def smooth_pose(
    settings: SmoothingSettings,
    before: _SmoothedPose | None,
    time_ns: int,
    position: AnyArray,
    orientation: AnyArray,
    pressure: float | None,
) -> _SmoothedPose:
    """Filter one sample; without `before` it passes unchanged.

    A pressure of 0 passes unchanged and at once: a pen that lifts must not extend its stroke.
    """
    if before is None or time_ns <= before.time_ns:
        return _SmoothedPose(time_ns, position, orientation, pressure, position, np.zeros(3))
    dt = (time_ns - before.time_ns) * 1e-9
    rate = _gain(settings.speed_hz, dt)
    velocity = before.velocity + rate * ((position - before.raw_position) / dt - before.velocity)
    speed = math.sqrt(velocity @ velocity)
    gain = _gain(settings.rest_hz + settings.hz_per_mm_s * speed, dt)
    if pressure and before.pressure:
        pressure = before.pressure + gain * (pressure - before.pressure)
    return _SmoothedPose(
        time_ns,
        before.position + gain * (position - before.position),
        np.array(slerp_one(before.orientation.tolist(), orientation.tolist(), gain)),
        pressure,
        position,
        velocity,
    )


def lag_s(settings: SmoothingSettings, speed_mm_s: float) -> float:
    """Lag of the filter behind a hand of constant speed, s: 1 / (2 pi cutoff)."""
    return 1.0 / (2.0 * math.pi * (settings.rest_hz + settings.hz_per_mm_s * speed_mm_s))


def _gain(cutoff_hz: float, dt: float) -> float:
    """Weight of the new value: the exact step response of a first-order low-pass over dt."""
    return -math.expm1(-2.0 * math.pi * cutoff_hz * dt)


class TwoHands:
    """Merges the stylus and the 6-DOF mouse; it reads no clock, so a replay is exact to the bit.

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
        self._smoothed: _SmoothedPose | None = None
        self._waiting: list[tuple[int, int, StylusReading | ArrayLike]] = []
        self._count = itertools.count()
        self._last_ns = time_ns - 1
        self.late = 0

    @property
    def object_pose(self) -> ObjectPose:
        """The object's pose at the time of the last `take`."""
        return self._state.pose

    def add_stylus(self, readings: Iterable[StylusReading]) -> None:
        """Queue readings of the right hand."""
        for reading in readings:
            self._put(reading.time_ns, reading)

    def add_deflection(self, time_ns: int, deflection: ArrayLike) -> None:
        """Queue a deflection (6,) of the left hand's cap, see `paint3d.device.space_mouse`."""
        self._put(time_ns, np.array(deflection, dtype=np.float64))

    def set_object_pose(self, pose: ObjectPose) -> None:
        """Move the object at once (recentred, or a session opened)."""
        self._state = dataclasses.replace(self._state, pose=pose)

    def take(self, until_ns: int) -> list[DeviceSample]:
        """Return the samples of all readings up to `until_ns`, by time.

        A reading older than a sample already taken (`late` counts these) is put right after it: its
        pose is kept, its time shifted.
        """
        samples = []
        while self._waiting and self._waiting[0][0] <= until_ns:
            time_ns, _, entry = heapq.heappop(self._waiting)
            if not isinstance(entry, StylusReading):
                self._state = report(self.steering, self._state, time_ns, entry)
            elif entry.in_range:
                samples.append(self._sample(time_ns, entry))
            else:
                self._smoothed = None
        self._state = advance(self.steering, self._state, until_ns)
        return samples

    def _put(self, time_ns: int, entry: StylusReading | ArrayLike) -> None:
        heapq.heappush(self._waiting, (time_ns, next(self._count), entry))  # ties: as they came

    def _sample(self, time_ns: int, reading: StylusReading) -> DeviceSample:
        """Turn a reading into a sample."""
        if time_ns <= self._last_ns:
            self.late += 1
            time_ns = self._last_ns + 1
        self._last_ns = time_ns
        self._state = advance(self.steering, self._state, time_ns)
        position, orientation = self.calibration.pose_to_world(
            reading.position, reading.orientation
        )
        pressure = reading.pressure
        if self._smoothing is not None:
            self._smoothed = smooth_pose(
                self._smoothing, self._smoothed, time_ns, position, orientation, pressure
            )
            position, orientation = self._smoothed.position, self._smoothed.orientation
            pressure = self._smoothed.pressure
        object_pose = self._state.pose
        return DeviceSample(
            time_ns,
            position,
            orientation,
            pressure,
            reading.buttons,
            object_pose.position,
            object_pose.orientation,
        )

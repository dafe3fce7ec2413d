"""Two streams of time-stamped readings to one stream of samples, smoothed as the hand moves.

The right hand sets the beat: every stylus reading gives one sample, none is lost and none is made
up. The left hand's deflection is integrated up to that very instant. Readings are taken in the
order of their times, whichever device they came from, up to a moment that both devices must have
reached; what is younger waits for the next call.

A steady hand comes of the 1-Euro filter on positions, orientations and pressures: Casiez, Roussel
and Vogel, *1 Euro filter: a simple speed-based low-pass filter for noisy input in interactive
systems*, CHI 2012. Slow hands are smoothed much, fast ones little, since noise is seen when the
hand is slow and lag when it is fast. Time steps are those of the samples, so the result does not
hang on a fixed rate. Here the cutoff follows one speed of the whole pose: smoothing axes apart
would bend straight strokes.
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
    """How much to smooth.

    Parameters
    ----------
    rest_hz : float
        Cutoff of a hand at rest.
    hz_per_mm_s : float
        By how much the cutoff rises with the speed.
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
    """The filter's memory, and its output: position (3,) mm, orientation (4,), pressure or None."""

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
    """One step of the filter; without `before` the sample passes unchanged.

    A pressure of 0 passes unchanged and at once: a pen that lifts must not drag its stroke on.
    """
    if before is None or time_ns <= before.time_ns:
        return _SmoothedPose(time_ns, position, orientation, pressure, position, np.zeros(3))
    dt = (time_ns - before.time_ns) * 1e-9
    rate = _share(settings.speed_hz, dt)
    velocity = before.velocity + rate * ((position - before.raw_position) / dt - before.velocity)
    speed = math.sqrt(velocity @ velocity)
    share = _share(settings.rest_hz + settings.hz_per_mm_s * speed, dt)
    return _SmoothedPose(
        time_ns,
        before.position + share * (position - before.position),
        np.array(slerp_one(before.orientation.tolist(), orientation.tolist(), share)),
        _smooth_pressure(before.pressure, pressure, share),
        position,
        velocity,
    )


def lag_s(settings: SmoothingSettings, speed_mm_s: float) -> float:
    """Delay of the filter behind a hand of steady speed, s (1 / 2 pi cutoff)."""
    return 1.0 / (2.0 * math.pi * (settings.rest_hz + settings.hz_per_mm_s * speed_mm_s))


def _share(cutoff_hz: float, dt: float) -> float:
    """Of the new value: the exact step response of a first-order low-pass over dt."""
    return -math.expm1(-2.0 * math.pi * cutoff_hz * dt)


def _smooth_pressure(before: float | None, now: float | None, share: float) -> float | None:
    if now is None or before is None or now == 0.0 or before == 0.0:
        return now
    return before + share * (now - before)


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
        self._smoothed: _SmoothedPose | None = None
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
        """What the left hand's cap said: (6,), see `paint3d.device.space_mouse`."""
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

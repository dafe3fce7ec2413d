"""A steady hand: the 1-Euro filter on positions, orientations and pressures.

Casiez, Roussel and Vogel, *1 Euro filter: a simple speed-based low-pass filter for noisy input in
interactive systems*, CHI 2012. Slow hands are smoothed much, fast ones little, since noise is seen
when the hand is slow and lag when it is fast. Time steps are those of the samples, so the result
does not hang on a fixed rate. Here the cutoff follows one speed of the whole pose: smoothing axes
apart would bend straight strokes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import as_number
from paint3d.core.types import AnyArray
from paint3d.errors import DeviceError
from paint3d.pose.single_turns import slerp_one

__all__ = ["SmoothedPose", "SmoothingSettings", "lag_s", "smooth_pose"]


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
class SmoothedPose:
    """The filter's memory, and its output: position (3,) mm, orientation (4,), pressure or None."""

    time_ns: int
    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: float | None
    raw_position: NDArray[np.float64]
    velocity: NDArray[np.float64]


def smooth_pose(
    settings: SmoothingSettings,
    before: SmoothedPose | None,
    time_ns: int,
    position: AnyArray,
    orientation: AnyArray,
    pressure: float | None,
) -> SmoothedPose:
    """One step of the filter; without `before` the sample passes unchanged.

    A pressure of 0 passes unchanged and at once: a pen that lifts must not drag its stroke on.
    """
    if before is None or time_ns <= before.time_ns:
        return SmoothedPose(time_ns, position, orientation, pressure, position, np.zeros(3))
    dt = (time_ns - before.time_ns) * 1e-9
    rate = _share(settings.speed_hz, dt)
    velocity = before.velocity + rate * ((position - before.raw_position) / dt - before.velocity)
    speed = math.sqrt(velocity @ velocity)
    share = _share(settings.rest_hz + settings.hz_per_mm_s * speed, dt)
    return SmoothedPose(
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

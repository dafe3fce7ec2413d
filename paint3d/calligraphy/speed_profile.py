"""How fast a hand goes along a path: as its bends ask for, and within limits up to the jerk.

A first guess takes speed from curvature (v ~ curvature^-0.29) and from what the limits leave for
each bend; then the motion is sampled as a device would sample it, and time is stretched around
every sample that breaks a limit, until none does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d

from paint3d.calligraphy.centre_line import smoothed
from paint3d.core.arrays import AnyArray

__all__ = ["Limits", "stretched", "travel"]

_TURN_RADIUS = 3.0  # mm of way that a turn of the holder by one radian counts for
_CURVATURE_POWER = -0.29
_FINEST_CURVE = 0.003  # of the em: finer curves are rounded
_REFERENCE_RADIUS = 0.25  # of the em: curves this wide are travelled at cruising speed
_BROADEST = 1.4  # of cruising speed: what wide curves allow
_CARE = 0.5  # power of what a sample lacks that time is stretched by in one round
_AIM = 1.1  # by which time is stretched too much, to be done sooner
_ROUNDS = 12  # of stretching
_EASE_S = 0.02  # s to both sides over which speed is evened out
_AROUND_S = 0.012  # s to both sides that are stretched with a sample
_HEADROOM = 0.92  # of each limit is made use of
_PHASES = 2  # by which samples may fall earlier or later
_REST = 6  # samples of rest looked at before and after


@dataclass(frozen=True)
class Limits:
    """What a hand can do.

    Attributes
    ----------
    speed, acceleration, jerk : float
        Of the tuft's root, mm/s, mm/s2, mm/s3.
    turn_rate : float
        Of the holder about its axis, rad/s.
    rate_hz : float
        Samples a second, by whose differences a motion is judged.
    """

    speed: float
    acceleration: float
    jerk: float
    turn_rate: float
    rate_hz: float


def travel(
    poses: NDArray[np.float64], em_mm: float, cruise: float, limits: Limits
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (M,) from 0, and poses (M, 4), along a path from rest to rest.

    Parameters
    ----------
    poses : (N, 4) float64
        x, y, height in mm and azimuth in rad.
    em_mm : float
        Side of the em square, mm: the scale of curves.
    cruise : float
        Speed in curves of a quarter of the em, ems a second.
    limits : Limits
    """
    path, way = _even_path(poses, em_mm)
    step = way / (len(path) - 1)
    speed = _bounded_by_bends(path, step, em_mm, cruise, limits)
    speed = _eased(_bounded_by_neighbours(speed, step, limits), step)
    return stretched(_spans(speed, step), path, limits)


def stretched(
    spans: AnyArray, poses: AnyArray, limits: Limits
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stretch the time between poses (M, 4), given as M - 1 spans, until the limits are kept.

    Returns the times (M,) from 0, and the poses.
    """
    for _ in range(_ROUNDS):
        time = np.r_[0.0, np.cumsum(spans)]
        at, excess = _excess(time, poses, limits)
        if excess.max() <= 1.0:
            return time, poses
        around = max(1, round(_AROUND_S * limits.rate_hz * _PHASES))
        lacking = np.maximum(_AIM * excess, 1.0) ** _CARE
        wide = maximum_filter1d(lacking, 2 * around + 1, mode="nearest")
        wide = gaussian_filter1d(wide, around, mode="nearest")
        spans = spans * np.interp(0.5 * (time[1:] + time[:-1]), at, wide)
    time = np.r_[0.0, np.cumsum(spans)]
    return time * _excess(time, poses, limits)[1].max(), poses


def _excess(time: AnyArray, poses: AnyArray, limits: Limits) -> tuple[AnyArray, AnyArray]:
    """By how much time must be stretched to keep the limits, at the times of samples."""
    step = 1.0 / limits.rate_hz
    fine = step / _PHASES
    at = fine * np.arange(-_REST * _PHASES, math.ceil(time[-1] / fine) + _REST * _PHASES + 1)
    curve = CubicSpline(time, poses, bc_type="clamped")
    sampled = curve(np.clip(at, 0.0, time[-1]))
    excess = np.zeros(len(at))
    values = sampled[:, :3]
    for order, most in enumerate((limits.speed, limits.acceleration, limits.jerk), start=1):
        values = (values[_PHASES:] - values[:-_PHASES]) / step
        share = np.linalg.norm(values, axis=1) / (_HEADROOM * most)
        _raise(excess, share ** (1.0 / order))
    turning = np.abs(sampled[_PHASES:, 3] - sampled[:-_PHASES, 3]) / step
    _raise(excess, turning / (_HEADROOM * limits.turn_rate))
    return at, excess


def _raise(excess: AnyArray, shares: AnyArray) -> None:
    """Lift every sample to the greatest share of the differences that it takes part in."""
    n = len(shares)
    for first in range(len(excess) - n + 1):
        np.maximum(excess[first : first + n], shares, out=excess[first : first + n])


def _even_path(poses: AnyArray, em_mm: float) -> tuple[NDArray[np.float64], float]:
    """The path at even steps, its finest curves rounded, and its length (mm)."""
    metric = poses * np.array([1.0, 1.0, 1.0, _TURN_RADIUS])
    steps = np.linalg.norm(np.diff(metric, axis=0), axis=1)
    kept = np.r_[True, steps > 1e-9]
    way = np.r_[0.0, np.cumsum(steps[steps > 1e-9])]
    n = max(24, len(way))
    even = np.linspace(0.0, way[-1], n)
    path = np.stack([np.interp(even, way, column) for column in poses[kept].T], axis=1)
    return smoothed(path, _FINEST_CURVE * em_mm * (n - 1) / way[-1]), float(way[-1])


def _bounded_by_bends(
    path: AnyArray, step: float, em_mm: float, cruise: float, limits: Limits
) -> NDArray[np.float64]:
    """Speed (mm/s of the way) that the path's first three derivatives allow."""
    metric = path * np.array([1.0, 1.0, 1.0, _TURN_RADIUS])
    tangent = np.gradient(metric, step, axis=0)
    bend = np.gradient(tangent, step, axis=0)
    twist = np.linalg.norm(np.gradient(bend, step, axis=0), axis=1) + 1e-9
    curvature = np.linalg.norm(bend, axis=1) + 1e-9
    natural = (curvature * _REFERENCE_RADIUS * em_mm) ** _CURVATURE_POWER
    speed = cruise * em_mm * np.minimum(natural, _BROADEST)
    speed = np.minimum(speed, np.sqrt(0.7 * limits.acceleration / curvature))
    speed = np.minimum(speed, np.cbrt(0.7 * limits.jerk / twist))
    moving = np.linalg.norm(tangent[:, :3], axis=1) + 1e-9
    turning = np.abs(tangent[:, 3]) / _TURN_RADIUS + 1e-9
    speed = np.minimum(speed, limits.speed / moving)
    speed = np.minimum(speed, limits.turn_rate / turning)
    sigma = max(1.0, _FINEST_CURVE * em_mm / step)
    result: NDArray[np.float64] = np.exp(gaussian_filter1d(np.log(speed), sigma, mode="nearest"))
    return result


def _eased(speed: AnyArray, step: float) -> NDArray[np.float64]:
    """Let speed change gently in time; never above what it was."""
    time = np.r_[0.0, np.cumsum(_spans(speed, step))]
    even = np.linspace(0.0, time[-1], len(speed))
    window = max(1, round(_EASE_S * (len(speed) - 1) / time[-1]))
    low = minimum_filter1d(np.interp(even, time, speed), 2 * window + 1, mode="nearest")
    calm = gaussian_filter1d(low, 0.5 * window, truncate=2.0, mode="nearest")
    result: NDArray[np.float64] = np.minimum(
        speed, np.maximum(np.interp(time, even, calm), 0.05 * speed)
    )
    return result


def _spans(speed: AnyArray, step: float) -> NDArray[np.float64]:
    """Times (s) from point to point."""
    spans = 2.0 * step / (speed[1:] + speed[:-1])
    spans[[0, -1]] *= 1.5  # from rest the speed grows with the square of the time
    return spans


def _bounded_by_neighbours(speed: AnyArray, step: float, limits: Limits) -> NDArray[np.float64]:
    """Speed that can be reached from rest at both ends and from point to point."""
    way = step * np.arange(len(speed))
    from_end = np.minimum(way, way[-1] - way)
    speed = np.minimum(speed, np.cbrt(4.5 * limits.jerk * from_end**2))
    most = 0.7 * limits.acceleration
    each = speed.tolist()  # Python's own numbers take a third of the time of an array's
    for i in range(1, len(each)):
        each[i] = min(each[i], math.sqrt(each[i - 1] ** 2 + 2.0 * most * step) + 1e-9)
    for i in range(len(each) - 2, -1, -1):
        each[i] = min(each[i], math.sqrt(each[i + 1] ** 2 + 2.0 * most * step) + 1e-9)
    each[0] = each[-1] = 0.0
    return np.array(each)

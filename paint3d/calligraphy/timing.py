"""Timing: paths of strokes become one motion of the hand, sampled evenly.

Within a stroke the hand follows v ~ curvature^-0.29, in one swell from bend to bend whatever small
sways its course has, slows down to turn the holder, and starts and ends at rest; between strokes it
lifts and moves over with least jerk; between characters it rises, dips the brush, and comes back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d

from paint3d.calligraphy.centre_line import smooth_along
from paint3d.calligraphy.path_fit import StrokePath
from paint3d.core.arrays import AnyArray, as_number
from paint3d.core.polyline import interpolate
from paint3d.device.sample import DIP
from paint3d.errors import InputError

__all__ = [
    "Limits",
    "Motion",
    "Tempo",
    "ease_between",
    "minimum_jerk",
    "stretch_time",
    "time_path",
    "time_paths",
]

# ---- Speed along a path --------------------------------------------------------------------------
# How fast a hand goes along a path: as its bends ask for, and within limits up to the jerk.
#
# A first guess takes speed from curvature (v ~ curvature^-0.29) and from what the limits leave for
# each bend; then the motion is sampled as a device would sample it, and time is stretched around
# every sample that breaks a limit, until none does.


_TURN_RADIUS = 3.0  # mm of way that a turn of the holder by one radian counts for
_CURVATURE_POWER = -0.29
_FINEST_CURVE = 0.003  # of the em: finer curves are rounded
_SWAY, _SWAY_TOLERANCE = 0.06, 0.0006  # of the em: shorter sways are smoothed, by so much at most
_SWAY_ROUNDS = 6  # of weighing anew what was changed by more
_TOUCHING_MM = 1e-6  # how deep a brush that touches stays at least
_REFERENCE_RADIUS = 0.25  # of the em: curves this wide are travelled at cruising speed
_BROADEST = 1.4  # of cruising speed: what wide curves allow
_CARE = 0.5  # power of what a sample lacks that time is stretched by in one round
_AIM = 1.1  # by which time is stretched too much, to be done sooner
_ROUNDS = 12  # of stretching
_EASE_S = 0.07  # s to both sides over which speed is evened out
_AROUND_S = 0.012  # s to both sides that are stretched with a sample
_HEADROOM = 0.92  # of each limit is made use of
_PHASES = 2  # by which samples may fall earlier or later
_REST = 6  # samples of rest looked at before and after


@dataclass(frozen=True)
class Limits:
    """Limits of a hand.

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


def time_path(
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
    speed = _limit_by_bends(path, step, em_mm, cruise, limits)
    speed = _smooth_speed(_limit_by_neighbours(speed, step, limits), step)
    return stretch_time(_durations(speed, step), path, limits)


def stretch_time(
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
    path, per_em = interpolate(even, way, poses[kept]), em_mm * (n - 1) / way[-1]
    path = smooth_along(path, _FINEST_CURVE * per_em)
    down = path[:, 2] < 0.0
    for k, unit in enumerate((1.0, 1.0, 1.0, _TURN_RADIUS)):
        tolerance = _SWAY_TOLERANCE * em_mm / unit
        path[:, k] = _smooth_sway(path[:, k], _SWAY * per_em, tolerance)
    path[down, 2] = np.minimum(path[down, 2], -_TOUCHING_MM)
    return path, float(way[-1])


def _smooth_sway(values: AnyArray, longest: float, tolerance: float) -> NDArray[np.float64]:
    """Smooth what in values (N,) sways over fewer than `longest` steps, by about a tolerance.

    A course is planned between knots, at each of which a hand would have to slow down. This is
    Whittaker's smoothing (1923) by third differences, with more weight in each round on what it
    changed by more than the tolerance; both ends stay.
    """
    n, order = len(values), 3
    differences = np.array([-1.0, 3.0, -3.0, 1.0])
    bands = np.zeros((order + 1, n))
    for i, a in enumerate(differences):
        for j, b in enumerate(differences[: i + 1]):
            bands[order - (i - j), i : n - order + i] += a * b
    bands *= (longest / (2.0 * np.pi)) ** (2 * order)
    weights = np.ones(n)
    weights[[0, -1]] = 1e6
    for _ in range(_SWAY_ROUNDS):
        system = bands.copy()
        system[order] += weights
        smooth: NDArray[np.float64] = solveh_banded(system, weights * values)
        weights[1:-1] *= np.maximum(1.0, ((smooth - values) / tolerance) ** 2)[1:-1]
    smooth[[0, -1]] = values[[0, -1]]
    return smooth


def _limit_by_bends(
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


def _smooth_speed(speed: AnyArray, step: float) -> NDArray[np.float64]:
    """Smooth speed in time; never above what it was."""
    time = np.r_[0.0, np.cumsum(_durations(speed, step))]
    even = np.linspace(0.0, time[-1], len(speed))
    window = max(1, round(_EASE_S * (len(speed) - 1) / time[-1]))
    low = minimum_filter1d(np.interp(even, time, speed), 2 * window + 1, mode="nearest")
    calm = gaussian_filter1d(low, 0.5 * window, truncate=2.0, mode="nearest")
    result: NDArray[np.float64] = np.minimum(
        speed, np.maximum(np.interp(time, even, calm), 0.05 * speed)
    )
    return result


def _durations(speed: AnyArray, step: float) -> NDArray[np.float64]:
    """Times (s) from point to point."""
    spans = 2.0 * step / (speed[1:] + speed[:-1])
    spans[[0, -1]] *= 1.5  # from rest the speed grows with the square of the time
    return spans


def _limit_by_neighbours(speed: AnyArray, step: float, limits: Limits) -> NDArray[np.float64]:
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


# ---- Times along paths -------------------------------------------------------------------------


_LIFT_POSES = 301
_NO_HAND = {
    "rate_hz": 1e4,
    "most_speed": 1e3,
    "most_acceleration": 2e4,
    "most_jerk": 6e5,
    "most_turn_rate": 30.0,
    "cruise": 100.0,
}
_RESTING_MM = 1e-9  # from the surface: rounding, where the tip only touches
_PAUSE = 3.0  # samples of rest between two parts, whose jerks would add up


@dataclass(frozen=True)
class Tempo:
    """Speed of a hand that writes.

    Attributes
    ----------
    rate_hz : float
        Samples a second.
    cruise : float
        Speed in wide curves, ems a second.
    most_speed, most_acceleration, most_jerk : float
        mm/s, mm/s2 and mm/s3 of the tuft's root, by differences of the samples.
    most_turn_rate : float
        rad/s of the holder about its axis.
    lift_s, lift_mm : float
        Shortest time and height of the way between two strokes.
    dip_s, dip_mm : float
        How long the brush stays in the ink, and how high it rises on its way.

    Raises
    ------
    InputError
        For limits that no hand reaches: over 1 m/s, 20 m/s2, 600 m/s3, or a rate over 10 kHz.
    """

    rate_hz: float = 250.0
    cruise: float = 1.1
    most_speed: float = 120.0
    most_acceleration: float = 1000.0
    most_jerk: float = 10000.0
    most_turn_rate: float = 5.5
    lift_s: float = 0.24
    lift_mm: float = 2.5
    dip_s: float = 0.8
    dip_mm: float = 20.0

    def __post_init__(self) -> None:
        for name, most in _NO_HAND.items():
            as_number(getattr(self, name), name, 1e-3, most)

    def slower(self, factor: float) -> Tempo:
        """The tempo whose limits of the root leave room for ways longer by a factor, 1 or more.

        Over a bulge the root goes a longer way than the foot, for which a motion is planned.

        Raises
        ------
        InputError
            If the factor is less than 1.
        """
        room = as_number(factor, "factor", 1.0)
        return replace(
            self,
            most_speed=self.most_speed / room,
            most_acceleration=self.most_acceleration / room,
            most_jerk=self.most_jerk / room,
        )


@dataclass(frozen=True, eq=False)
class Motion:
    """N even samples of an upright brush over a plane.

    Attributes
    ----------
    time_s : (N,) float64
    handle : (N, 2) float64
        P'_m, mm.
    azimuth : (N,) float64
        Bend direction, rad, without jumps.
    height : (N,) float64
        Of the straight tip over the plane, mm; negative is the descent D_s.
    buttons : (N,) int32
        2 while the brush is dipped.
    group : (N,) int64
        Which character the hand writes or goes to.
    stroke : (N,) int64
        Which stroke of it the hand writes; -1 on its ways between them.
    """

    time_s: NDArray[np.float64]
    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    height: NDArray[np.float64]
    buttons: NDArray[np.int32]
    group: NDArray[np.int64]
    stroke: NDArray[np.int64]


def time_paths(
    characters: Sequence[Sequence[StrokePath]], em_mm: float, tempo: Tempo | None = None
) -> Motion:
    """Give the strokes of several characters their times.

    Parameters
    ----------
    characters : sequence of sequences of StrokePath
        In writing order, all on one plane.
    em_mm : float
        Side of the em square, mm.
    tempo : Tempo, optional

    Raises
    ------
    InputError
        If there is no stroke to write.
    """
    tempo = tempo or Tempo()
    limits = Limits(
        tempo.most_speed,
        tempo.most_acceleration,
        tempo.most_jerk,
        tempo.most_turn_rate,
        tempo.rate_hz,
    )
    parts: list[_Part] = []
    pose = None
    for k, paths in enumerate(characters):
        for j, path in enumerate(paths):
            poses = np.column_stack([path.handle, -path.descent, path.azimuth])
            if pose is None:
                pose = poses[0] + np.array([0.0, 0.0, tempo.dip_mm, 0.0])
            else:
                poses[:, 3] += 2.0 * np.pi * round((pose[3] - poses[0, 3]) / (2.0 * np.pi))
            if j == 0:
                parts.extend(_dip(pose, poses[0], tempo, k))
            else:
                parts.append(_Part(*_lift(pose, poses[0], tempo), False, k))
            parts.append(_Part(*time_path(poses, em_mm, tempo.cruise, limits), False, k, j))
            pose = poses[-1]
    if pose is None:
        raise InputError("there is no stroke to write; expected at least one")
    away = pose + np.array([0.0, 0.0, tempo.dip_mm, 0.0])
    parts.append(_Part(*_lift(pose, away, tempo), False, len(characters) - 1))
    return _join(parts, tempo)


@dataclass(frozen=True, eq=False)
class _Part:
    """A piece of the motion: poses (N, 4) of x, y, height, azimuth at times (N,) from 0."""

    time: AnyArray
    poses: AnyArray
    dips: bool
    group: int
    stroke: int = -1


def minimum_jerk(t: AnyArray) -> AnyArray:
    """Fraction of a minimum-jerk movement from rest to rest at times t, both 0 to 1."""
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)


def ease_between(start: AnyArray, end: AnyArray, t: AnyArray) -> AnyArray:
    """Values (N, K) of a minimum-jerk movement from some (K,) to others at times (N,), 0 to 1."""
    values: AnyArray = start + minimum_jerk(t)[:, None] * (end - start)
    return values


def _lift(start: AnyArray, end: AnyArray, tempo: Tempo) -> tuple[AnyArray, AnyArray]:
    """Move over from rest to rest on an arc, as fast as the limits allow but not in a hurry."""
    span = float(np.linalg.norm(end[:3] - start[:3]))
    arc = tempo.lift_mm + 0.1 * span
    if end[2] > 0.0 or start[2] > 0.0:
        arc = 0.0
    t = np.linspace(0.0, 1.0, _LIFT_POSES)
    poses = ease_between(start, end, t)
    poses[:, 2] += arc * 64.0 * (t * (1.0 - t)) ** 3
    return _time_poses(poses, tempo.lift_s, tempo)


def _time_poses(poses: AnyArray, least_s: float, tempo: Tempo) -> tuple[AnyArray, AnyArray]:
    """Times of poses at even times, in the least time that the limits allow but `least_s`."""
    step, values, seconds = 1.0 / (len(poses) - 1), poses, least_s
    for order, most in enumerate(
        (tempo.most_speed, tempo.most_acceleration, tempo.most_jerk), start=1
    ):
        values = np.diff(values, axis=0) / step
        fastest = float(np.linalg.norm(values[:, :3], axis=1).max())
        seconds = max(seconds, (1.06 * fastest / most) ** (1.0 / order))
        if order == 1:
            turning = float(np.abs(values[:, 3]).max())
            seconds = max(seconds, 1.06 * turning / tempo.most_turn_rate)
    return np.linspace(0.0, seconds, len(poses)), poses


def _dip(start: AnyArray, end: AnyArray, tempo: Tempo, group: int) -> list[_Part]:
    """Rise, move over while the brush is in the ink, and come down at the next character."""
    up, over = start.copy(), end.copy()
    up[2] = over[2] = tempo.dip_mm
    parts = []
    if start[2] <= 0.0:
        parts.append(_Part(*_lift(start, up, tempo), False, group - 1))
    there = ease_between(up, over, np.linspace(0.0, 1.0, _LIFT_POSES))
    parts.append(_Part(*_time_poses(there, tempo.dip_s, tempo), True, group))
    parts.append(_Part(*_lift(over, end, tempo), False, group))
    return parts


def _join(parts: list[_Part], tempo: Tempo) -> Motion:
    """Put the parts one after the other and sample them evenly."""
    pause = _PAUSE / tempo.rate_hz
    starts = np.cumsum([0.0] + [float(part.time[-1]) + pause for part in parts])
    n = math.ceil(starts[-1] * tempo.rate_hz) + 1
    time = np.arange(n) / tempo.rate_hz
    which = np.minimum(np.searchsorted(starts, time, side="right") - 1, len(parts) - 1)
    poses = np.empty((n, 4))
    for k, part in enumerate(parts):
        inside = which == k
        curve = CubicSpline(part.time, part.poses, bc_type="clamped")
        poses[inside] = curve(np.minimum(time[inside] - starts[k], part.time[-1]))
        if (part.poses[:, 2] >= 0.0).all():  # what is lifted never touches
            poses[inside, 2] = np.maximum(poses[inside, 2], 0.0)
    poses[np.abs(poses[:, 2]) < _RESTING_MM, 2] = 0.0
    dips = np.array([part.dips for part in parts])[which] & (poses[:, 2] > 0.5 * tempo.dip_mm)
    groups = np.array([part.group for part in parts])[which]
    buttons = np.where(dips, DIP, 0).astype(np.int32)
    strokes = np.array([part.stroke for part in parts])[which]
    return Motion(time, poses[:, :2], poses[:, 3], poses[:, 2], buttons, groups, strokes)

"""When the brush is where: courses of strokes become one motion of the hand, sampled evenly.

Within a stroke the hand follows v ~ curvature^-0.29, slows down to turn the holder, and starts and
ends at rest; between strokes it lifts and moves over with least jerk; between characters it rises,
dips the brush, and comes back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from paint3d.errors import InputError
from paint3d.stroke.laying import DIP
from paint3d.stroke.planning import StrokeCourse

__all__ = ["Motion", "Tempo", "time_courses"]

_TURN_RADIUS = 3.0  # mm of way that a turn of the holder by one radian counts for
_CURVATURE_POWER = -0.29
_FINEST_CURVE = 0.004  # of the em: finer curves are not slowed down for
_REFERENCE_RADIUS = 0.25  # of the em: curves this wide are travelled at cruising speed


@dataclass(frozen=True)
class Tempo:
    """How fast a hand writes.

    Attributes
    ----------
    rate_hz : float
        Samples a second.
    cruise : float
        Speed in wide curves, ems a second.
    most_speed, most_acceleration : float
        mm/s and mm/s2 of the tuft's root.
    most_turn_rate : float
        rad/s of the holder about its axis.
    lift_s, lift_mm : float
        Shortest time and height of the way between two strokes.
    dip_s, dip_mm : float
        How long the brush stays in the ink, and how high it rises on its way.
    smoothing_s : float
        Standard deviation of the last smoothing in time, which keeps the jerk low.
    """

    rate_hz: float = 250.0
    cruise: float = 1.1
    most_speed: float = 120.0
    most_acceleration: float = 500.0
    most_turn_rate: float = 5.5
    lift_s: float = 0.24
    lift_mm: float = 2.5
    dip_s: float = 0.8
    dip_mm: float = 20.0
    smoothing_s: float = 0.008


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
    """

    time_s: NDArray[np.float64]
    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    height: NDArray[np.float64]
    buttons: NDArray[np.int32]
    group: NDArray[np.int64]


def time_courses(
    characters: Sequence[Sequence[StrokeCourse]], em_mm: float, tempo: Tempo | None = None
) -> Motion:
    """Give the strokes of several characters their times.

    Parameters
    ----------
    characters : sequence of sequences of StrokeCourse
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
    parts: list[_Part] = []
    pose = None
    for k, courses in enumerate(characters):
        for j, course in enumerate(courses):
            poses = _poses(course)
            if pose is None:
                pose = poses[0] + np.array([0.0, 0.0, tempo.dip_mm, 0.0])
            else:
                poses[:, 3] += 2.0 * np.pi * round((pose[3] - poses[0, 3]) / (2.0 * np.pi))
            if j == 0:
                parts.extend(_dip(pose, poses[0], tempo, k))
            else:
                parts.append(_Part(*_lift(pose, poses[0], tempo), False, k))
            parts.append(_Part(*_stroke(poses, em_mm, tempo), False, k))
            pose = poses[-1]
    if pose is None:
        raise InputError("there is no stroke to write; expected at least one")
    away = pose + np.array([0.0, 0.0, tempo.dip_mm, 0.0])
    parts.append(_Part(*_lift(pose, away, tempo), False, len(characters) - 1))
    return _join(parts, tempo)


@dataclass(frozen=True, eq=False)
class _Part:
    """A piece of the motion: poses (N, 4) of x, y, height, azimuth at times (N,) from 0."""

    time: NDArray
    poses: NDArray
    dips: bool
    group: int


def _poses(course: StrokeCourse) -> NDArray[np.float64]:
    return np.column_stack([course.handle, -course.descent, course.azimuth])


def _stroke(poses: NDArray, em_mm: float, tempo: Tempo) -> tuple[NDArray, NDArray]:
    """Times of the poses of one stroke, from rest to rest."""
    metric = poses * np.array([1.0, 1.0, 1.0, _TURN_RADIUS])
    steps = np.linalg.norm(np.diff(metric, axis=0), axis=1)
    kept = np.r_[True, steps > 1e-9]
    poses, metric, steps = poses[kept], metric[kept], steps[steps > 1e-9]
    way = np.r_[0.0, np.cumsum(steps)]
    speed = _allowed_speed(poses, metric, way, em_mm, tempo)
    speed[[0, -1]] = 0.0
    most = tempo.most_acceleration / math.sqrt(2.0)
    for i in range(1, len(speed)):
        speed[i] = min(speed[i], math.sqrt(speed[i - 1] ** 2 + 2.0 * most * steps[i - 1]))
    for i in range(len(speed) - 2, -1, -1):
        speed[i] = min(speed[i], math.sqrt(speed[i + 1] ** 2 + 2.0 * most * steps[i]))
    return np.r_[0.0, np.cumsum(2.0 * steps / (speed[1:] + speed[:-1]))], poses


def _allowed_speed(
    poses: NDArray, metric: NDArray, way: NDArray, em_mm: float, tempo: Tempo
) -> NDArray[np.float64]:
    """Speed (mm/s of the metric's way) that curves, the holder's turn and the hand allow."""
    even = np.linspace(0.0, way[-1], len(way))
    sigma = max(1.0, _FINEST_CURVE * em_mm * len(way) / way[-1])
    path = np.stack([np.interp(even, way, metric[:, k]) for k in range(4)], axis=1)
    path = gaussian_filter1d(path, sigma, axis=0, mode="nearest")
    tangent = np.gradient(path, even, axis=0, edge_order=1)
    bend = np.linalg.norm(np.gradient(tangent, even, axis=0), axis=1) + 1e-9
    natural = (bend * _REFERENCE_RADIUS * em_mm) ** _CURVATURE_POWER
    speed = tempo.cruise * em_mm * np.minimum(natural, 1.4)
    speed = np.minimum(speed, np.sqrt(tempo.most_acceleration / math.sqrt(2.0) / bend))
    moving = np.linalg.norm(tangent[:, :3], axis=1) + 1e-9
    turning = np.abs(tangent[:, 3]) / _TURN_RADIUS + 1e-9
    speed = np.minimum(speed, np.minimum(tempo.most_speed / moving, tempo.most_turn_rate / turning))
    return np.interp(way, even, gaussian_filter1d(speed, sigma, mode="nearest"))


def _least_jerk(t: NDArray) -> NDArray:
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)


def _lift(
    start: NDArray, end: NDArray, tempo: Tempo, height: float | None = None
) -> tuple[NDArray, NDArray]:
    """Move over from rest to rest on an arc, as fast as the limits allow but not in a hurry."""
    span = float(np.linalg.norm(end[:3] - start[:3]))
    arc = tempo.lift_mm + 0.1 * span if height is None else height
    if end[2] > 0.0 or start[2] > 0.0:
        arc = 0.0
    most = 0.6 * tempo.most_acceleration
    seconds = max(
        tempo.lift_s,
        math.sqrt((24.0 * arc + 5.8 * span) / most),
        1.9 * span / tempo.most_speed,
        1.9 * abs(float(end[3] - start[3])) / tempo.most_turn_rate,
    )
    t = np.linspace(0.0, 1.0, max(3, math.ceil(seconds * 1000)))
    poses = start + _least_jerk(t)[:, None] * (end - start)
    poses[:, 2] += arc * 64.0 * (t * (1.0 - t)) ** 3
    return seconds * t, poses


def _dip(start: NDArray, end: NDArray, tempo: Tempo, group: int) -> list[_Part]:
    """Rise, move over while the brush is in the ink, and come down at the next character."""
    up, over = start.copy(), end.copy()
    up[2] = over[2] = tempo.dip_mm
    parts = []
    if start[2] <= 0.0:
        parts.append(_Part(*_lift(start, up, tempo), False, group - 1))
    seconds = max(tempo.dip_s, float(_lift(up, over, tempo)[0][-1]))
    t = np.linspace(0.0, 1.0, math.ceil(seconds * 1000))
    parts.append(_Part(seconds * t, up + _least_jerk(t)[:, None] * (over - up), True, group))
    parts.append(_Part(*_lift(over, end, tempo), False, group))
    return parts


def _join(parts: list[_Part], tempo: Tempo) -> Motion:
    """Put the parts one after the other and sample them evenly."""
    starts = np.cumsum([0.0] + [float(part.time[-1]) for part in parts])
    n = math.ceil(starts[-1] * tempo.rate_hz) + 1
    time = np.arange(n) / tempo.rate_hz
    which = np.minimum(np.searchsorted(starts, time, side="right") - 1, len(parts) - 1)
    poses = np.empty((n, 4))
    for k, part in enumerate(parts):
        inside = which == k
        for c in range(4):
            poses[inside, c] = np.interp(time[inside] - starts[k], part.time, part.poses[:, c])
    poses = gaussian_filter1d(poses, tempo.smoothing_s * tempo.rate_hz, axis=0, mode="nearest")
    dips = np.array([part.dips for part in parts])[which] & (poses[:, 2] > 0.5 * tempo.dip_mm)
    groups = np.array([part.group for part in parts])[which]
    buttons = np.where(dips, DIP, 0).astype(np.int32)
    return Motion(time, poses[:, :2], poses[:, 3], poses[:, 2], buttons, groups)

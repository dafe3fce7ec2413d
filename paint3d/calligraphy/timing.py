"""When the brush is where: courses of strokes become one motion of the hand, sampled evenly.

Within a stroke the hand follows v ~ curvature^-0.29, slows down to turn the holder, and starts and
ends at rest; between strokes it lifts and moves over with least jerk; between characters it rises,
dips the brush, and comes back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from paint3d.calligraphy.planning import StrokePath
from paint3d.calligraphy.speed_profile import Limits, travel
from paint3d.core.arrays import AnyArray, as_number
from paint3d.device.sample import DIP
from paint3d.errors import InputError

__all__ = ["Motion", "Tempo", "least_jerk", "time_courses"]

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
    """How fast a hand writes.

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


def time_courses(
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
            parts.append(_Part(*travel(poses, em_mm, tempo.cruise, limits), False, k, j))
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


def _poses(course: StrokePath) -> NDArray[np.float64]:
    return np.column_stack([course.handle, -course.descent, course.azimuth])


def least_jerk(t: AnyArray) -> AnyArray:
    """How far a movement from rest to rest of the least jerk has come at times t, both 0 to 1."""
    return t**3 * (10.0 - 15.0 * t + 6.0 * t**2)


def _lift(start: AnyArray, end: AnyArray, tempo: Tempo) -> tuple[AnyArray, AnyArray]:
    """Move over from rest to rest on an arc, as fast as the limits allow but not in a hurry."""
    span = float(np.linalg.norm(end[:3] - start[:3]))
    arc = tempo.lift_mm + 0.1 * span
    if end[2] > 0.0 or start[2] > 0.0:
        arc = 0.0
    t = np.linspace(0.0, 1.0, _LIFT_POSES)
    poses = start + least_jerk(t)[:, None] * (end - start)
    poses[:, 2] += arc * 64.0 * (t * (1.0 - t)) ** 3
    return _unhurried(poses, tempo.lift_s, tempo)


def _unhurried(poses: AnyArray, least_s: float, tempo: Tempo) -> tuple[AnyArray, AnyArray]:
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
    t = np.linspace(0.0, 1.0, _LIFT_POSES)
    there = up + least_jerk(t)[:, None] * (over - up)
    parts.append(_Part(*_unhurried(there, tempo.dip_s, tempo), True, group))
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

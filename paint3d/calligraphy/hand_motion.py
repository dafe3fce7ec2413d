"""The hand over an object: planned motions laid on charts, and the paths between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.brush_engine.tuft import Tuft
from paint3d.calligraphy.timing import Motion, Tempo, ease_between, minimum_jerk
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import unit_vectors
from paint3d.core.quaternion import quaternions_from_matrices, rotate, slerp
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SurfaceChart

__all__ = ["HandMotion", "join_motions", "move_between", "root_stretch", "to_hand_motion"]

_PEAK = 1.875  # of a least-jerk move's speed over its mean
_PEAK_ACCELERATION = 5.78  # of a least-jerk move: times length over time squared
_PEAK_JERK, _PEAK_JERK_RISE = 60.0, 384.0  # of the move, and of its rise: length over time cubed
_MOST_RAISES = 12


@dataclass(frozen=True, eq=False)
class HandMotion:
    """N even samples of the brush over an object at rest.

    Attributes
    ----------
    position : (N, 3) float64
        Of the tuft's root, mm.
    orientation : (N, 4) float64
        object_from_pen, unit quaternions, w first.
    pressure : (N,) float64
        0 to 1.
    buttons : (N,) int32
        2 while the brush is dipped.
    """

    position: NDArray[np.float64]
    orientation: NDArray[np.float64]
    pressure: NDArray[np.float64]
    buttons: NDArray[np.int32]


def to_hand_motion(
    motion: Motion,
    chart: SurfaceChart,
    em_mm: float,
    tuft: Tuft,
    middle: AnyArray | None = None,
) -> HandMotion:
    """Carry a motion over an em square or a box onto the chart around its middle.

    The holder stands on the surface's normal at P'_m wherever it is, so the foot follows the wall.

    Parameters
    ----------
    motion : Motion
        Over a plane; (0, 0) is the em square's lower left corner.
    chart : SurfaceChart
    em_mm : float
    tuft : Tuft
    middle : (2,) float64, optional
        Where in the motion's plane the chart's middle lies, mm; by default the square's.

    Raises
    ------
    InputError
        If the handle leaves the chart.
    """
    xy = motion.handle - (0.5 * em_mm if middle is None else middle)
    frames = chart.tangents(xy)
    x = np.einsum("nij,nj->ni", frames[:, :, :2], unit_vectors(motion.azimuth))
    z = frames[:, :, 2]
    root = tuft.length + motion.height
    return HandMotion(
        chart.points(xy) + root[:, None] * z,
        quaternions_from_matrices(np.stack([x, np.cross(z, x), z], axis=-1)),
        np.maximum(0.0, -motion.height) / tuft.full_press,
        motion.buttons,
    )


def root_stretch(points: NDArray[np.float64], normals: NDArray[np.float64], tuft: Tuft) -> float:
    """Greatest ratio of the root's path length to the foot's, over a grid of a surface.

    Parameters
    ----------
    points, normals : (K, K, 3) float64
        Places on the surface, and its outward unit normals there.
    tuft : Tuft

    Returns
    -------
    float
        1 or more: over a hollow the root's path is the shorter one.
    """
    roots = points + tuft.length * normals
    most = 1.0
    for axis in range(2):
        lengths = np.linalg.norm(np.diff(points, axis=axis), axis=2)
        root_ways = np.linalg.norm(np.diff(roots, axis=axis), axis=2)
        most = max(most, float((root_ways / lengths).max()))
    return most


def move_between(
    start: HandMotion, end: HandMotion, surface: ClosestPoints, tuft: Tuft, tempo: Tempo
) -> HandMotion:
    """Move from the last pose of one motion to the first of the next, clear of the object.

    It is a least-jerk move that is raised until the tip keeps off the surface.
    """
    first, last = start.position[-1], end.position[0]
    up = rotate(np.stack([start.orientation[-1], end.orientation[0]]), np.array([0.0, 0.0, 1.0]))
    outward = up.sum(axis=0)
    outward /= max(float(np.linalg.norm(outward)), 1e-9)
    span = float(np.linalg.norm(last - first))
    arc = 0.15 * span
    t = np.linspace(0.0, 1.0, 33)
    for _ in range(_MOST_RAISES):
        path = _arc(first, last, arc * outward, t)
        turns = slerp(*_repeat_ends(start, end, len(t)), minimum_jerk(t))
        z = rotate(turns, np.array((0.0, 0.0, 1.0)))  # the handle's axis
        if _is_clear(surface, path - tuft.length * z, path, 0.4 * tempo.dip_mm):
            break
        arc = 1.5 * arc + 2.0
    n = max(3, math.ceil(_move_seconds(span, arc, start, end, tempo) * tempo.rate_hz))
    t = np.arange(1, n) / n
    return HandMotion(
        _arc(first, last, arc * outward, t),
        slerp(*_repeat_ends(start, end, n - 1), minimum_jerk(t)),
        np.zeros(n - 1),
        np.zeros(n - 1, np.int32),
    )


def _move_seconds(
    span: float, arc: float, start: HandMotion, end: HandMotion, tempo: Tempo
) -> float:
    """Time that a path takes: as fast as the limits allow but not in a hurry."""
    cosine = abs(float(start.orientation[-1] @ end.orientation[0]))
    turn = 2.0 * math.acos(min(1.0, cosine))
    length = span + 4.0 * arc
    result: float = max(
        tempo.lift_s,
        _PEAK * length / tempo.most_speed,
        math.sqrt(_PEAK_ACCELERATION * length / (0.6 * tempo.most_acceleration)),
        ((_PEAK_JERK * span + _PEAK_JERK_RISE * arc) / (0.9 * tempo.most_jerk)) ** (1.0 / 3.0),
        _PEAK * turn / tempo.most_turn_rate,
    )
    return result


def _arc(first: AnyArray, last: AnyArray, rise: AnyArray, t: AnyArray) -> AnyArray:
    bump = 64.0 * (t * (1.0 - t)) ** 3
    result: AnyArray = ease_between(first, last, t) + bump[:, None] * rise
    return result


def _repeat_ends(start: HandMotion, end: HandMotion, n: int) -> tuple[AnyArray, AnyArray]:
    return np.tile(start.orientation[-1], (n, 1)), np.tile(end.orientation[0], (n, 1))


def _is_clear(surface: ClosestPoints, tips: AnyArray, roots: AnyArray, least: float) -> bool:
    """Return whether a tuft on its path stays outside of the object and off it."""
    for points in (tips, 0.5 * (tips + roots), roots):
        nearest = surface.find(points)
        apart = points - nearest.points
        distance = np.linalg.norm(apart, axis=1)
        outside = np.sum(apart * nearest.normals, axis=1) > 0.0
        if (distance[1:-1] < least).any() or not outside[1:-1].all():
            return False
    return True


def join_motions(parts: Sequence[HandMotion]) -> HandMotion:
    """Concatenate motions."""
    return HandMotion(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.orientation for part in parts]),
        np.concatenate([part.pressure for part in parts]),
        np.concatenate([part.buttons for part in parts]),
    )

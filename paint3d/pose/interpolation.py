"""What the brush did between two samples.

Positions follow cubic Hermite curves in time, with tangents from the parabola through three
samples, cut back so that no interval overshoots; orientations turn along the shorter arc, and
pressures change linearly. Nothing is made up where nothing is known: a lone interval longer
than 100 ms is straight, and while the pen is up at both of its ends an interval is not joined.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.pose.brush_pose import BrushPath

__all__ = ["MAX_CURVED_GAP_S", "joined_samples", "velocities"]

MAX_CURVED_GAP_S = 0.1
"""Longer intervals than this are bridged by a straight line (two periods of a 20 Hz device)."""
_STEEPEST = 3.0
"""Tangents of at most three chord speeds cannot overshoot (Fritsch and Carlson 1980)."""


def joined_samples(path: BrushPath) -> AnyArray:
    """Whether the pen came to each sample from the one before it: (N,) bool.

    False for the first sample, where the pressure is 0 at both ends of the interval, and where only
    one of them says which place on the surface is meant.
    """
    joined = np.ones(len(path), dtype=bool)
    joined[0] = False
    if path.pressure is not None:
        joined[1:] = (path.pressure[1:] > 0.0) | (path.pressure[:-1] > 0.0)
    has_contact = path.has_contact
    joined[1:] &= has_contact[1:] == has_contact[:-1]
    return joined


def velocities(path: BrushPath, joined: NDArray[np.bool_]) -> AnyArray:
    """Tangents of the cubics along `BrushPath.way` in mm/s, (N, 3).

    The derivative of the parabola through a sample and its two neighbours; at the ends of a
    stroke that through the three last samples; the chord's where there are two. A sample at
    the end of an interval longer than 100 ms takes that chord's velocity (between two such, 0).
    No tangent is longer than three times the slower of its two chords. Only samples up to two
    away matter, so a path may be painted as it comes in.

    Parameters
    ----------
    path : BrushPath
    joined : (N,) bool
        From `joined_samples`.
    """
    n = len(path)
    velocity = np.zeros((n, 3))
    if n < 2:
        return velocity
    steps = np.where(joined[1:], np.diff(path.time_s), 1.0)  # others are not asked for
    chords = np.diff(path.way, axis=0) / steps[:, None]
    curved = joined[1:] & (steps <= MAX_CURVED_GAP_S)
    left, right = np.zeros(n, bool), np.zeros(n, bool)
    left[1:] = right[:-1] = curved
    i = np.flatnonzero(left & right)
    velocity[i] = _weighted(chords[i - 1], chords[i], steps[i], steps[i - 1])
    _set_ends(velocity, chords, steps, curved, np.flatnonzero(right & ~left), 1)
    _set_ends(velocity, chords, steps, curved, np.flatnonzero(left & ~right), -1)
    straight = joined[1:] & ~curved
    before, after = np.zeros(n, bool), np.zeros(n, bool)
    before[1:] = after[:-1] = straight
    one = np.flatnonzero(after & ~before)
    velocity[one] = chords[one]
    one = np.flatnonzero(before & ~after)
    velocity[one] = chords[one - 1]
    velocity[before & after] = 0.0
    return velocity * _cut(velocity, chords, joined)[:, None]


def _weighted(a: AnyArray, b: AnyArray, weight_a: AnyArray, weight_b: AnyArray) -> AnyArray:
    total = (weight_a + weight_b)[:, None]
    result: AnyArray = (weight_a[:, None] * a + weight_b[:, None] * b) / total
    return result


def _set_ends(
    velocity: AnyArray,
    chords: AnyArray,
    steps: AnyArray,
    curved: AnyArray,
    ends: AnyArray,
    way: int,
) -> None:
    """Fill the tangents of samples that end a curved run; `way` is 1 where it goes on after."""
    near = ends if way == 1 else ends - 1
    far = np.clip(near + way, 0, len(chords) - 1)
    known = (far == near + way) & curved[far]
    share = np.where(known, steps[near] / (steps[near] + steps[far]), 0.0)
    velocity[ends] = chords[near] + (chords[near] - chords[far]) * share[:, None]


def _cut(velocity: AnyArray, chords: AnyArray, joined: AnyArray) -> AnyArray:
    """Factors (N,) in [0, 1] that keep the tangents from overshooting."""
    speed = np.linalg.norm(chords, axis=1)
    speed[~joined[1:]] = np.inf
    slowest = np.full(len(velocity), np.inf)
    slowest[1:] = speed
    slowest[:-1] = np.minimum(slowest[:-1], speed)
    length = np.linalg.norm(velocity, axis=1)
    over = length > _STEEPEST * slowest
    return np.where(over, _STEEPEST * slowest, 1.0) / np.where(over, length, 1.0)

"""Laying the known lines of a character over the skeleton of another drawing of it.

Coherent point drift (Myronenko and Song, 2010): points of the lines move towards those of the
skeleton, smoothly together, while the distance over which they see each other shrinks. They see
each other only where their lines run alike, so that crossing strokes are not taken for each other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.continuation import resampled
from paint3d.calligraphy.shapes.skeleton import length_of
from paint3d.core.arrays import AnyArray

__all__ = ["STARTS", "register", "tangents_of"]

_SIDE = 900.0  # the larger side of what is laid over, in the units of the lengths below
_MOST_POINTS, _LEAST_STEP = 120, 14.0
_SIGHTS = (110.0, 80.0, 60.0, 45.0, 34.0, 26.0, 20.0, 15.0, 12.0)
_COARSE = 24.0  # sights above it move all strokes together, others each nearly for itself
_REACH, _OWN_REACH = 170.0, 90.0  # how far a point takes others along
_TOGETHER, _APART = 0.75, 0.15  # the share of that across strokes
_STIFF = 1.0  # at a sight of 60
_NOISE = 2e-4  # share of the points that belong to nothing
_UNALIKE = 0.03  # what remains of the sight across lines at right angles
_SURE, _UNSURE = 1.5, 0.02
_OUTER = (2.0, 98.0)  # percentiles of the boxes that are laid over each other first
_STRETCH = (0.4, 2.5)
_SWASH = 15.0  # percent of a capital's skeleton that may be an ornament on its left
STARTS = ("box", "slanted", "swash")
"""How lines are first laid over a skeleton, in the order in which it is tried."""


def tangents_of(line: AnyArray) -> NDArray[np.float64]:
    """Unit vectors along a line (N, 2)."""
    ahead = np.gradient(line, axis=0)
    result: NDArray[np.float64] = ahead / np.maximum(
        np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12
    )
    return result


def register(
    lines: Sequence[AnyArray], targets: AnyArray, tangents: AnyArray, *, start: str = "box"
) -> list[NDArray[np.float64]]:
    """Move lines over a skeleton.

    Parameters
    ----------
    lines : sequence of (N, 2) float64
        The strokes' lines, in any frame with y upwards.
    targets, tangents : (M, 2) float64
        Points of the skeleton, evenly spaced, and unit vectors along it.
    start : {"box", "slanted", "swash"}
        How the lines are laid over it first: so that their box is the skeleton's; so that their
        middle, extents and slant are, by second moments; or the same where the outermost part on
        the left is an ornament.

    Returns
    -------
    list of (N, 2) float64
        The lines, resampled, in the frame of the targets.
    """
    low, high = np.percentile(targets, _OUTER, axis=0)
    scale = _SIDE / max(float((high - low).max()), 1e-12)
    goals = (targets - low) * scale
    starts = _laid_over(lines, goals) if start == "box" else _slanted(lines, goals, start)
    total = sum(length_of(line) for line in starts)
    step = max(_LEAST_STEP, total / _MOST_POINTS)
    starts = [resampled(line, step, 4) for line in starts]
    moved = _drifted(starts, goals, tangents)
    return [low + line / scale for line in moved]


def _laid_over(lines: Sequence[AnyArray], goals: AnyArray) -> list[NDArray[np.float64]]:
    """Stretch lines so that their box is that of the goals."""
    points = np.concatenate([resampled(line, length_of(line) / 20.0, 20) for line in lines])
    mine, wanted = (np.percentile(values, _OUTER, axis=0) for values in (points, goals))
    size = np.maximum(mine[1] - mine[0], 0.07 * float((mine[1] - mine[0]).max()) + 1e-12)
    stretch = (wanted[1] - wanted[0]) / size
    usual = float(np.median(stretch)) or 1.0
    stretch = np.clip(stretch, _STRETCH[0] * usual, _STRETCH[1] * usual)
    return [(line - mine.mean(axis=0)) * stretch + wanted.mean(axis=0) for line in lines]


def _slanted(lines: Sequence[AnyArray], goals: AnyArray, start: str) -> list[NDArray[np.float64]]:
    """Stretch and slant lines so that their first and second moments are those of the goals."""
    points = np.concatenate([resampled(line, length_of(line) / 20.0, 20) for line in lines])
    if start == "swash":
        across = (np.linalg.inv(_lower_root(goals)) @ (goals - goals.mean(axis=0)).T)[0]
        goals = goals[across > np.percentile(across, _SWASH)]
    mine, wanted = (_lower_root(values) for values in (points, goals))
    turn = wanted @ np.linalg.inv(mine)
    return [(line - points.mean(axis=0)) @ turn.T + goals.mean(axis=0) for line in lines]


def _lower_root(points: AnyArray) -> NDArray[np.float64]:
    """A root R of the second moments of points, R R^T: level lines stay level by it."""
    spread = np.cov(points.T)
    spread += max(0.005 * np.trace(spread), 1e-12) * np.eye(2)
    root = np.linalg.cholesky(spread[::-1, ::-1])
    result: NDArray[np.float64] = root[::-1, ::-1]
    return result


def _drifted(
    lines: Sequence[AnyArray], goals: AnyArray, tangents: AnyArray
) -> list[NDArray[np.float64]]:
    start = np.concatenate(lines)
    of = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    cuts = np.cumsum([len(line) for line in lines])[:-1]
    same = of[:, None] == of[None]
    apart = np.sum((start[:, None] - start[None]) ** 2, axis=2)
    points = start
    for sight in _SIGHTS:
        coarse = sight > _COARSE
        reach, across = (_REACH, _TOGETHER) if coarse else (_OWN_REACH, _APART)
        kernel = np.exp(-apart / (2.0 * reach**2)) * np.where(same, 1.0, across)
        stiff = _STIFF * (sight / 60.0) ** 2
        for _ in range(2 if coarse else 3):
            along = np.concatenate([tangents_of(line) for line in np.split(points, cuts)])
            squares = np.sum(points**2, axis=1)[:, None] + np.sum(goals**2, axis=1)[None]
            squares -= 2.0 * points @ goals.T
            seen = np.exp(-squares / (2.0 * sight**2))
            seen *= _UNALIKE + (along @ tangents.T) ** 4
            seen /= seen.sum(axis=0) + _NOISE * len(points)
            weight = seen.sum(axis=1)
            aim = seen @ goals / np.maximum(weight, 1e-9)[:, None]
            aim = np.where(weight[:, None] > 1e-4, aim, points)
            sure = np.minimum(weight, _SURE) + _UNSURE
            system = sure[:, None] * kernel + stiff * np.eye(len(points))
            points = start + kernel @ np.linalg.solve(system, sure[:, None] * (aim - start))
    return np.split(points, cuts)

"""Following a centre line: the course of the brush that covers most of the outline along it.

Dynamic programming picks the bend directions, trading the width left bare against a trailing tip
and calm turns; the course is smoothed, balanced between both edges, and the pressure limited again
at every pose, so that nothing leaves the outline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.centre_line import CentreLine, OutlineField, smoothed
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.calligraphy.lag_compensation import pull
from paint3d.calligraphy.plan_settings import TECHNIQUES, PlanSettings
from paint3d.core.filters import gaussian_filter1d, minimum_filter1d
from paint3d.core.types import AnyArray

__all__ = ["PathFitter", "StrokePath"]

_CALM = 3  # samples to either side that levels are smoothed over
_SPAN = 0.12  # of the width: how far a course steps aside to lie in the middle


@dataclass(frozen=True, eq=False)
class StrokePath:
    """The way of the brush through one stroke: N poses with an upright holder, in order.

    Attributes
    ----------
    handle : (N, 2) float64
        P'_m on the paper, mm.
    azimuth : (N,) float64
        Bend direction, rad, without jumps of a turn.
    descent : (N,) float64
        D_s, mm; 0 at both ends.
    centre : (N, 2) float64
        Centroid of the footprint, mm.
    level : (N,) float64
        Row in the table of footprints, -1 where the brush is off.
    """

    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    descent: NDArray[np.float64]
    centre: NDArray[np.float64]
    level: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PathFitter:
    """What stays the same while one stroke's course is improved; see `plan_stroke`."""

    field: OutlineField
    footprints: FootprintTable
    settings: PlanSettings
    em_mm: float
    start: float | None

    @property
    def target(self) -> kernels.Target:
        """The outline and the footprints as the kernels take them."""
        margin = self.settings.margin * self.em_mm
        footprints, field = self.footprints, self.field
        return kernels.Target(
            footprints.points, footprints.support, field.distance, field.grid, margin
        )

    def follow(self, line: CentreLine) -> tuple[StrokePath | None, NDArray[np.bool_]]:
        """Return the course along a line (None: nothing fits), and what it leaves bare."""
        azimuth, shift = _balanced(line, self, *_choose_course(line, self))
        centre, azimuth = _smooth_course(line, azimuth, shift, self.settings.pose_step * self.em_mm)
        level = np.empty(len(centre))
        kernels.fit_levels(self.target, centre, azimuth, level)
        touching = np.flatnonzero(level >= 0.0)
        if len(touching) < 2:
            return None, self.field.inside
        kept = slice(touching[0], touching[-1] + 1)
        if self.settings.azimuth == "dragged":
            start = azimuth[kept][0] if self.start is None else self.start
            pulled = pull(centre[kept], self.footprints, self.target, start)
            course = _touched(*pulled, self.footprints)
        else:
            course = _course(centre[kept], azimuth[kept], _calm(level[kept]), self.footprints)
        painted = np.zeros(self.field.distance.shape, np.bool_)
        kernels.cover(
            self.footprints.points, course.level, course.centre, course.azimuth, *self.field.grid,
            painted,
        )  # fmt: skip
        return course, self.field.inside & ~painted


def _choose_course(line: CentreLine, plan: PathFitter) -> tuple[AnyArray, AnyArray]:
    """Return the azimuth (rad) and the side step (mm) for every sample of the line."""
    settings, footprints = plan.settings, plan.footprints
    n, shifts = settings.n_directions, np.array(settings.shifts)
    gap = np.empty((len(line.points), n, len(shifts)))
    sparse = np.ascontiguousarray(footprints.points[:, ::2])  # directions are only compared
    target = plan.target._replace(points=sparse)
    kernels.rate(target, line.points, line.headings, line.room, shifts, gap)
    directions = 2.0 * np.pi * np.arange(n) / n
    ahead = directions[None, :] - line.headings[:, None]
    cost = gap / line.width + _cost_of_bend(ahead, settings)[:, :, None]
    per_width = line.step / line.width
    turn = settings.turning * (2.0 * np.pi / n / per_width) ** 2
    aside = settings.shifting * ((shifts[1] - shifts[0]) / per_width) ** 2
    angle, side = np.empty(len(gap), np.int64), np.empty(len(gap), np.int64)
    kernels.best_course(cost, turn, aside, 3, angle, side)
    return np.unwrap(directions[angle]), shifts[side] * line.room.min(axis=1)


def _cost_of_bend(ahead: AnyArray, settings: PlanSettings) -> NDArray[np.float64]:
    """Cost of bends at angles from the heading (rad), in stroke widths left bare."""
    technique = "zhongfeng" if settings.azimuth == "dragged" else settings.technique
    if technique is None:
        return settings.trailing * (0.5 + 0.5 * np.cos(ahead))
    wanted = TECHNIQUES[technique]
    off = np.maximum(np.cos(ahead - wanted), np.cos(ahead + wanted))
    return settings.holding * (0.5 - 0.5 * off)


def _balanced(
    line: CentreLine, plan: PathFitter, azimuth: AnyArray, shift: AnyArray
) -> tuple[AnyArray, AnyArray]:
    """Smooth the chosen course, and step aside until both edges are reached alike."""
    sigma = 0.2 * line.width / line.step
    azimuth = smoothed(azimuth[:, None], sigma)[:, 0]
    shift = smoothed(shift[:, None], sigma)[:, 0]
    span = _SPAN * line.width
    kernels.balance(plan.target, line.points, line.headings, line.room, azimuth, span, shift)
    return azimuth, smoothed(shift[:, None], 0.5 * sigma)[:, 0]


def _smooth_course(
    line: CentreLine, azimuth: AnyArray, shift: AnyArray, step: float
) -> tuple[AnyArray, AnyArray]:
    """Interpolate the chosen course at the final step: centres (N, 2) and azimuths (N,)."""
    centre = line.points + shift[:, None] * line.normals
    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(centre, axis=0), axis=1))]
    at = np.linspace(0.0, way[-1], max(8, math.ceil(way[-1] / step)) + 1)
    dense = [np.interp(at, way, values) for values in (centre[:, 0], centre[:, 1], azimuth)]
    sigma = line.step / step
    smooth = smoothed(np.stack(dense, axis=1), sigma)
    return np.ascontiguousarray(smooth[:, :2]), np.ascontiguousarray(smooth[:, 2])


def _calm(level: AnyArray) -> NDArray[np.float64]:
    """Smooth the levels from below: never above what fits."""
    low = minimum_filter1d(level, 2 * _CALM + 1, mode="nearest")
    calm = gaussian_filter1d(low, 0.5 * _CALM, truncate=2.0, mode="nearest")
    result: NDArray[np.float64] = np.minimum(calm, level)
    return result


def _course(
    centre: AnyArray, azimuth: AnyArray, level: AnyArray, footprints: FootprintTable
) -> StrokePath:
    """Place the handle behind the footprints."""
    bend = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    handle = centre - footprints.centroid_at(level)[:, None] * bend
    return _touched(handle, azimuth, centre, level, footprints)


def _touched(
    handle: AnyArray,
    azimuth: AnyArray,
    centre: AnyArray,
    level: AnyArray,
    footprints: FootprintTable,
) -> StrokePath:
    """Add the touch before and the lift after."""
    pick = np.r_[0, np.arange(len(level)), len(level) - 1]
    level = level[pick]
    descent = footprints.descent_at(level)
    descent[[0, -1]] = 0.0
    level[[0, -1]] = -1.0
    return StrokePath(handle[pick], azimuth[pick], descent, centre[pick], level)

"""Planning strokes: from an outline to the course of the brush that fills it.

The method is that of contained footprints. Along the stroke's centre line every bend direction is
rated by how much of the width the largest footprint leaves bare that still lies within the outline;
dynamic programming picks the directions, trading coverage against a trailing tip and calm turns;
then the course is smoothed and the pressure limited again at every pose, so that nothing leaves
the outline. The handle stands at P'_m, the foot of the root node, not at the footprint's centre.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import (
    distance_transform_edt,
    gaussian_filter1d,
    label,
    maximum,
    minimum_filter1d,
)

from paint3d.errors import InputError
from paint3d.kernels import planning as kernels
from paint3d.stroke.centre_line import (
    CentreLine,
    OutlineField,
    bend_towards,
    centre_line,
    outline_field,
    smoothed,
)
from paint3d.stroke.dragging import pull
from paint3d.stroke.glyphs import DESCENDER, EM_UNITS, Glyph
from paint3d.stroke.ladder import FootprintLadder

__all__ = ["TECHNIQUES", "PlanSettings", "StrokeCourse", "on_paper", "plan_glyph", "plan_stroke"]

TECHNIQUES = {"zhongfeng": math.pi, "cefeng": 0.75 * math.pi, "pianfeng": 0.5 * math.pi}
"""Angle between bend and motion, rad (Guo 2017, section 5)."""


_SPAN = 0.12  # of the width: how far a course steps aside to lie in the middle


@dataclass(frozen=True)
class PlanSettings:
    """How a stroke is planned; lengths in shares of the em.

    Attributes
    ----------
    sample_step, pose_step : float
        Distance of the samples that directions are chosen for, and of the final poses.
    margin : float
        How far a footprint may stand out of the outline.
    n_directions : int
        Bend directions tried.
    shifts : tuple of float
        Side steps tried, in shares of the narrower half of the stroke.
    trailing : float
        Cost of a leading tip (0 for a trailing one), in stroke widths left bare.
    turning, shifting : float
        Cost of a turn of one radian, and of a side step of one half width, over one stroke width.
    detours : int
        How many bare corners the line is bent into, one after another.
    worth : float
        Share of the bare area that a detour must gain.
    technique : {"zhongfeng", "cefeng", "pianfeng"}, optional
        How the bend is held against the motion: the tip trails (180 degrees), lies half aside
        (135) or all aside (90), on either side. None: as covers the outline best.
    holding : float
        Cost of a bend the opposite way, in stroke widths left bare, where a technique is asked for.
    azimuth : {"commanded", "dragged"}
        Whether the holder turns the tuft, or the paper: then it trails wherever it is led.

    Raises
    ------
    InputError
        For a technique or azimuth that is not known, or a dragged tuft that shall not trail.
    """

    sample_step: float = 3.5 / 1024
    pose_step: float = 1.0 / 1024
    margin: float = 0.4 / 1024
    n_directions: int = 36
    shifts: tuple[float, ...] = (-0.4, 0.0, 0.4)
    trailing: float = 0.03
    turning: float = 0.01
    shifting: float = 0.03
    detours: int = 4
    worth: float = 0.05
    technique: str | None = None
    holding: float = 10.0
    azimuth: str = "commanded"

    def __post_init__(self) -> None:
        if self.technique is not None and self.technique not in TECHNIQUES:
            known = ", ".join(repr(name) for name in TECHNIQUES)
            raise InputError(f"technique is {self.technique!r}; expected one of {known}")
        if self.azimuth not in ("commanded", "dragged"):
            raise InputError(f"azimuth is {self.azimuth!r}; expected 'commanded' or 'dragged'")
        if self.azimuth == "dragged" and self.technique not in (None, "zhongfeng"):
            raise InputError(
                f"technique is {self.technique!r} with a dragged tuft, which trails; "
                "expected 'zhongfeng' or none"
            )


@dataclass(frozen=True, eq=False)
class StrokeCourse:
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
        Place on the ladder of footprints, -1 where the brush is off.
    """

    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    descent: NDArray[np.float64]
    centre: NDArray[np.float64]
    level: NDArray[np.float64]


def on_paper(points: NDArray, em_mm: float) -> NDArray[np.float64]:
    """Carry glyph units (N, 2) to millimetres from the em square's lower left corner."""
    return em_mm / EM_UNITS * (np.asarray(points, np.float64) + np.array([0.0, DESCENDER]))


def plan_glyph(
    glyph: Glyph, em_mm: float, ladder: FootprintLadder, settings: PlanSettings | None = None
) -> list[StrokeCourse]:
    """Plan all strokes of a glyph, in writing order.

    Parameters
    ----------
    glyph : Glyph
    em_mm : float
        Side of the em square, mm.
    ladder : FootprintLadder
        Footprints of the brush.
    settings : PlanSettings, optional

    Raises
    ------
    InputError
        If a stroke is too fine for the brush.
    """
    courses: list[StrokeCourse] = []
    for k, stroke in enumerate(glyph.strokes):
        outline, median = on_paper(stroke.outline, em_mm), on_paper(stroke.median, em_mm)
        name = f"stroke {k + 1} of {glyph.text}"
        start = float(courses[-1].azimuth[-1]) if courses else None
        courses.append(plan_stroke(outline, median, em_mm, ladder, settings, name, start))
    return courses


def plan_stroke(
    outline: NDArray,
    median: NDArray,
    em_mm: float,
    ladder: FootprintLadder,
    settings: PlanSettings | None = None,
    name: str = "stroke",
    start: float | None = None,
) -> StrokeCourse:
    """Plan one stroke.

    Parameters
    ----------
    outline : (N, 2) float64
        Closed polygon, mm.
    median : (M, 2) float64
        Centre line in writing order, mm.
    em_mm : float
        Side of the em square, mm: the scale of `settings`.
    ladder : FootprintLadder
    settings : PlanSettings, optional
    name : str
        What to call the stroke in messages.
    start : float, optional
        Where a dragged tuft points when it lands, rad; by default where it will be needed.

    Raises
    ------
    InputError
        If no footprint of the brush fits anywhere.
    """
    settings = settings or PlanSettings()
    field = outline_field(outline, em_mm / 512)
    step = field.grid[2]
    if not field.inside.any():
        raise InputError(f"{name} is finer than {step:g} mm; expected an outline to fill")
    line = centre_line(median, field, settings.sample_step * em_mm)
    plan = _Plan(field, ladder, settings, em_mm, start)
    best, bare = plan.follow(line)
    tried = np.zeros_like(bare)
    for _ in range(settings.detours):
        corner, tried = _largest_corner(bare & ~tried, tried, line.width / step)
        if corner is None:
            break
        detour = bend_towards(line, field.grid[:2] + step * corner, field)
        course, left = plan.follow(detour)
        if left.sum() < bare.sum() * (1.0 - settings.worth):
            line, best, bare = detour, course, left
    if best is None:
        raise InputError(f"{name} is too fine for this brush at an em of {em_mm:g} mm")
    return best


@dataclass(frozen=True, eq=False)
class _Plan:
    """What stays the same while one stroke's course is improved."""

    field: OutlineField
    ladder: FootprintLadder
    settings: PlanSettings
    em_mm: float
    start: float | None

    def follow(self, line: CentreLine) -> tuple[StrokeCourse | None, NDArray[np.bool_]]:
        """Return the course along a line (None: nothing fits), and what it leaves bare."""
        azimuth, shift = _balanced(line, self, *_choose_course(line, self))
        centre, azimuth = _smooth_course(line, azimuth, shift, self.settings.pose_step * self.em_mm)
        level = np.empty(len(centre))
        margin = self.settings.margin * self.em_mm
        kernels.fit_levels(
            self.ladder.points, self.field.distance, self.field.grid, centre, azimuth, margin, level
        )
        touching = np.flatnonzero(level >= 0.0)
        if len(touching) < 2:
            return None, self.field.inside
        kept = slice(touching[0], touching[-1] + 1)
        if self.settings.azimuth == "dragged":
            start = azimuth[kept][0] if self.start is None else self.start
            pulled = pull(centre[kept], self.ladder, self.field, margin, start)
            course = _touched(*pulled, self.ladder)
        else:
            course = _course(centre[kept], azimuth[kept], _calm(level[kept]), self.ladder)
        painted = np.zeros(self.field.distance.shape, np.bool_)
        kernels.cover(
            self.ladder.points, course.level, course.centre, course.azimuth, *self.field.grid,
            painted,
        )  # fmt: skip
        return course, self.field.inside & ~painted


def _largest_corner(
    bare: NDArray, tried: NDArray, width: float
) -> tuple[NDArray | None, NDArray[np.bool_]]:
    """Return the outermost pixel (x, y) of the largest bare patch, or None, and what was tried.

    A patch counts where a disc of an eighth of the stroke's width (in pixels) would fit in.
    """
    depth = distance_transform_edt(bare)
    labels, n = label(bare)
    if n == 0:
        return None, tried
    deepest = maximum(depth, labels, np.arange(1, n + 1))
    areas = np.bincount(labels.ravel())[1:] * (deepest > width / 16.0)
    k = int(np.argmax(areas))
    if areas[k] < (width / 6.0) ** 2:
        return None, tried
    patch = labels == k + 1
    row, column = np.unravel_index(np.argmax(depth * patch), depth.shape)
    return np.array([column, row], np.float64), tried | patch


def _choose_course(line: CentreLine, plan: _Plan) -> tuple[NDArray, NDArray]:
    """Return the azimuth (rad) and the side step (mm) for every sample of the line."""
    settings, ladder = plan.settings, plan.ladder
    n, shifts = settings.n_directions, np.array(settings.shifts)
    gap = np.empty((len(line.points), n, len(shifts)))
    sparse = np.ascontiguousarray(ladder.points[:, ::2])  # directions are only compared
    kernels.rate(
        sparse, ladder.support, plan.field.distance, plan.field.grid, line.points, line.headings,
        line.room, shifts, settings.margin * plan.em_mm, gap,
    )  # fmt: skip
    directions = 2.0 * np.pi * np.arange(n) / n
    ahead = directions[None, :] - line.headings[:, None]
    cost = gap / line.width + _cost_of_bend(ahead, settings)[:, :, None]
    per_width = line.step / line.width
    turn = settings.turning * (2.0 * np.pi / n / per_width) ** 2
    aside = settings.shifting * ((shifts[1] - shifts[0]) / per_width) ** 2
    angle, side = np.empty(len(gap), np.int64), np.empty(len(gap), np.int64)
    kernels.best_course(cost, turn, aside, 3, angle, side)
    return np.unwrap(directions[angle]), shifts[side] * line.room.min(axis=1)


def _cost_of_bend(ahead: NDArray, settings: PlanSettings) -> NDArray[np.float64]:
    """Cost of bends at angles from the heading (rad), in stroke widths left bare."""
    technique = "zhongfeng" if settings.azimuth == "dragged" else settings.technique
    if technique is None:
        return settings.trailing * (0.5 + 0.5 * np.cos(ahead))
    wanted = TECHNIQUES[technique]
    off = np.maximum(np.cos(ahead - wanted), np.cos(ahead + wanted))
    return settings.holding * (0.5 - 0.5 * off)


def _balanced(
    line: CentreLine, plan: _Plan, azimuth: NDArray, shift: NDArray
) -> tuple[NDArray, NDArray]:
    """Smooth the chosen course, and step aside until both edges are reached alike."""
    sigma = 0.2 * line.width / line.step
    azimuth = smoothed(azimuth[:, None], sigma)[:, 0]
    shift = smoothed(shift[:, None], sigma)[:, 0]
    kernels.balance(
        plan.ladder.points, plan.ladder.support, plan.field.distance, plan.field.grid, line.points,
        line.headings, line.room, azimuth, plan.settings.margin * plan.em_mm,
        _SPAN * line.width, shift,
    )  # fmt: skip
    return azimuth, smoothed(shift[:, None], 0.5 * sigma)[:, 0]


def _smooth_course(
    line: CentreLine, azimuth: NDArray, shift: NDArray, step: float
) -> tuple[NDArray, NDArray]:
    """Interpolate the chosen course at the final step: centres (N, 2) and azimuths (N,)."""
    centre = line.points + shift[:, None] * line.normals
    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(centre, axis=0), axis=1))]
    at = np.linspace(0.0, way[-1], max(8, math.ceil(way[-1] / step)) + 1)
    dense = [np.interp(at, way, values) for values in (centre[:, 0], centre[:, 1], azimuth)]
    sigma = line.step / step
    smooth = smoothed(np.stack(dense, axis=1), sigma)
    return np.ascontiguousarray(smooth[:, :2]), np.ascontiguousarray(smooth[:, 2])


def _calm(level: NDArray, half_window: int = 3) -> NDArray[np.float64]:
    """Smooth the levels from below: never above what fits."""
    low = minimum_filter1d(level, 2 * half_window + 1, mode="nearest")
    calm = gaussian_filter1d(low, 0.5 * half_window, truncate=2.0, mode="nearest")
    return np.minimum(calm, level)


def _course(
    centre: NDArray, azimuth: NDArray, level: NDArray, ladder: FootprintLadder
) -> StrokeCourse:
    """Place the handle behind the footprints."""
    bend = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    handle = centre - ladder.centroid_at(level)[:, None] * bend
    return _touched(handle, azimuth, centre, level, ladder)


def _touched(
    handle: NDArray, azimuth: NDArray, centre: NDArray, level: NDArray, ladder: FootprintLadder
) -> StrokeCourse:
    """Add the touch before and the lift after."""
    pick = np.r_[0, np.arange(len(level)), len(level) - 1]
    level = level[pick]
    descent = ladder.descent_at(level)
    descent[[0, -1]] = 0.0
    level[[0, -1]] = -1.0
    return StrokeCourse(handle[pick], azimuth[pick], descent, centre[pick], level)

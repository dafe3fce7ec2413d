"""Following a centre line: the course of the brush that covers most of the outline along it.

Dynamic programming picks the bend directions, trading the width left bare against a trailing tip
and calm turns; the course is smoothed, balanced between both edges, and the pressure limited again
at every pose, so that nothing leaves the outline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from paint3d.calligraphy.centre_line import CentreLine, OutlineField, smoothed
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.calligraphy.lag_compensation import TRIALS, Lead, Pulled, pull, pulled_on
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["TECHNIQUES", "Followed", "PathFitter", "PlanSettings", "StrokePath"]

# ---- Settings ------------------------------------------------------------------------------------
# How strokes are planned.


TECHNIQUES = {"zhongfeng": math.pi, "cefeng": 0.75 * math.pi, "pianfeng": 0.5 * math.pi}
"""Angle between bend and motion, rad (Guo 2017, section 5)."""


@dataclass(frozen=True)
class PlanSettings:
    """Options of planning a stroke; lengths in shares of the em.

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
        How many bare corners the line is led into, one after another.
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
    margin: float = 0.5 / 1024
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
            raise InputError(
                "technique is {technique!r}; expected one of {known}",
                technique=self.technique,
                known=known,
            )
        if self.azimuth not in ("commanded", "dragged"):
            raise InputError(
                "azimuth is {azimuth!r}; expected 'commanded' or 'dragged'",
                azimuth=self.azimuth,
            )
        if self.azimuth == "dragged" and self.technique not in (None, "zhongfeng"):
            raise InputError(
                "technique is {technique!r} with a dragged tuft, which trails; expected "
                "'zhongfeng' or none",
                technique=self.technique,
            )


# ---- Fitting -------------------------------------------------------------------------------------


_CALM = 3  # samples to either side that levels are smoothed over
_CALM_WIDTHS = 0.2  # that chosen courses are smoothed over
_ALIKE = 1e-9  # mm, or rad: samples no farther apart are the same
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
    share : (N,) float64
        Of the footprint's length, what is left of it where the paper holds a dragged tip.
    """

    handle: NDArray[np.float64]
    azimuth: NDArray[np.float64]
    descent: NDArray[np.float64]
    centre: NDArray[np.float64]
    level: NDArray[np.float64]
    share: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Followed:
    """A line and what comes of following it.

    Attributes
    ----------
    line : CentreLine
        Of S samples.
    gap : (S, A, O) float64
        Width left bare by every direction and side step, mm.
    chosen : (S, 2) float64
        Azimuth, rad, and side step, mm.
    shift : (S,) float64
        The side steps balanced between both edges, mm.
    course : StrokePath or None
        None: nothing fits.
    bare : (H, W) bool
        What it leaves bare, on the outline's grid.
    """

    line: CentreLine
    gap: NDArray[np.float64]
    chosen: NDArray[np.float64]
    shift: NDArray[np.float64]
    course: StrokePath | None
    bare: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PathFitter:
    """Constants while one stroke's course is improved; see `plan_stroke`."""

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

    def follow(self, line: CentreLine, known: Followed | None = None) -> Followed:
        """The course along a line; what is known of one that it shares samples with is kept."""
        gap = _rated(line, self, known)
        chosen = _chosen_course(line, gap, self)
        shift = _balanced(line, self, chosen, known)
        course, bare = self._fitted(line, chosen[:, 0], shift)
        return Followed(line, gap, chosen, shift, course, bare)

    def _fitted(
        self, line: CentreLine, azimuth: AnyArray, shift: AnyArray
    ) -> tuple[StrokePath | None, NDArray[np.bool_]]:
        """The course of the largest footprints that fit, and what it leaves bare."""
        led = self._led(line, azimuth, shift)
        if led is None:
            return None, self.field.inside
        centre, azimuth, level = led
        if self.settings.azimuth == "dragged":
            course = _touched(*pull(self._lead(centre, azimuth, _calm(level))), self.footprints)
        else:
            course = _course(centre, azimuth, _calm(level), self.footprints)
        return course, self.field.inside & ~self._painted(course)

    def _led(
        self, line: CentreLine, azimuth: AnyArray, shift: AnyArray
    ) -> tuple[AnyArray, AnyArray, AnyArray] | None:
        """Centres (N, 2), azimuths and levels (N,) of footprints that fit; None: there are none."""
        shift = smoothed(shift[:, None], 0.5 * _calm_over(line))[:, 0]
        centre, azimuth = _smooth_course(line, azimuth, shift, self.settings.pose_step * self.em_mm)
        level = np.empty(len(centre))
        kernels.fit_levels(self.target, centre, azimuth, np.ones(len(centre)), level)
        kept = np.flatnonzero(level >= 0.0)
        return None if len(kept) < 2 else (centre[kept], azimuth[kept], level[kept])

    def _lead(self, centre: AnyArray, azimuth: AnyArray, level: AnyArray) -> Lead:
        start = float(azimuth[0]) if self.start is None else self.start
        return Lead(centre, self.footprints, self.target, start, level)

    def _painted(self, course: StrokePath) -> NDArray[np.bool_]:
        """Mask of what a course covers (H, W), on the outline's grid."""
        painted = np.zeros(self.field.distance.shape, np.bool_)
        kernels.cover(
            self.footprints.points, course.level, course.centre, course.azimuth, course.share,
            self.field.grid, painted,
        )  # fmt: skip
        return painted

    def finished(self, best: Followed) -> Followed:
        """The same line, along which a dragged brush is led on while that betters the course."""
        led = self._led(best.line, best.chosen[:, 0], best.shift)
        if led is None or best.course is None or self.settings.azimuth != "dragged":
            return best
        lead, course, inside = self._lead(*led), best.course, self.field.inside
        values = (course.handle, course.azimuth, course.centre, course.level, course.share)
        found = Pulled(*(value[1:-1] for value in values))  # without its touch and its lift
        least = int((self._painted(course) ^ inside).sum())
        for trial in range(TRIALS):
            for one in pulled_on(lead, found, trial):
                tried = _touched(*one, self.footprints)
                wrong = int((self._painted(tried) ^ inside).sum())
                if wrong < least:
                    found, course, least = one, tried, wrong
        return replace(best, course=course, bare=inside & ~self._painted(course))


def _rated(line: CentreLine, plan: PathFitter, known: Followed | None) -> NDArray[np.float64]:
    """The width that every direction and side step leaves bare at every sample (S, A, O), mm."""
    shifts = np.array(plan.settings.shifts)
    gap = np.empty((len(line.points), plan.settings.n_directions, len(shifts)))
    new = slice(None)
    if known is not None:
        new = _taken_over(gap, known.gap, _samples(line), _samples(known.line))
    sparse = np.ascontiguousarray(plan.footprints.points[:, ::2])  # directions are only compared
    target = plan.target._replace(points=sparse)
    kernels.rate(target, line.points[new], line.headings[new], line.room[new], shifts, gap[new])
    return gap


def _samples(line: CentreLine) -> NDArray[np.float64]:
    """Values that a footprint's fit depends on at every sample of a line (S, 6)."""
    return np.concatenate([line.points, line.normals, line.room], axis=1)


def _taken_over(out: AnyArray, known: AnyArray, mine: AnyArray, theirs: AnyArray) -> slice:
    """Copy the first and the last rows whose keys agree; the rows between, which are left."""
    n = min(len(mine), len(theirs))
    first, last = (
        int(np.argmin([*(np.abs(a - b).max(axis=1) < _ALIKE), False]))
        for a, b in ((mine[:n], theirs[:n]), (mine[::-1][:n], theirs[::-1][:n]))
    )
    last = min(last, n - first)
    out[:first] = known[:first]
    out[len(out) - last :] = known[len(known) - last :]
    return slice(first, len(out) - last)


def _chosen_course(line: CentreLine, gap: AnyArray, plan: PathFitter) -> NDArray[np.float64]:
    """The azimuth (rad) and the side step (mm) chosen for every sample of the line (S, 2)."""
    settings = plan.settings
    n, shifts = settings.n_directions, np.array(settings.shifts)
    directions = 2.0 * np.pi * np.arange(n) / n
    ahead = directions[None, :] - line.headings[:, None]
    cost = gap / line.width + _cost_of_bend(ahead, settings)[:, :, None]
    per_width = line.step / line.width
    turn = settings.turning * (2.0 * np.pi / n / per_width) ** 2
    aside = settings.shifting * ((shifts[1] - shifts[0]) / per_width) ** 2
    angle, side = np.empty(len(gap), np.int64), np.empty(len(gap), np.int64)
    kernels.best_course(cost, turn, aside, 3, angle, side)
    steps = shifts[side] * line.room.min(axis=1)
    return smoothed(np.stack([np.unwrap(directions[angle]), steps], axis=1), _calm_over(line))


def _calm_over(line: CentreLine) -> float:
    """Over how many samples a chosen course is smoothed."""
    return _CALM_WIDTHS * line.width / line.step


def _cost_of_bend(ahead: AnyArray, settings: PlanSettings) -> NDArray[np.float64]:
    """Cost of bends at angles from the heading (rad), in stroke widths left bare."""
    technique = "zhongfeng" if settings.azimuth == "dragged" else settings.technique
    if technique is None:
        return settings.trailing * (0.5 + 0.5 * np.cos(ahead))
    wanted = TECHNIQUES[technique]
    off = np.maximum(np.cos(ahead - wanted), np.cos(ahead + wanted))
    return settings.holding * (0.5 - 0.5 * off)


def _balanced(
    line: CentreLine, plan: PathFitter, chosen: AnyArray, known: Followed | None
) -> NDArray[np.float64]:
    """Side steps (S,) near the chosen ones by which both edges are reached alike, mm."""
    azimuth, shift = chosen[:, 0].copy(), chosen[:, 1].copy()
    new = slice(None)
    if known is not None:
        mine, theirs = (
            np.concatenate([_samples(one), course], axis=1)
            for one, course in ((line, chosen), (known.line, known.chosen))
        )
        new = _taken_over(shift, known.shift, mine, theirs)
    kernels.balance(
        plan.target, line.points[new], line.headings[new], line.room[new], azimuth[new],
        _SPAN * line.width, shift[new],
    )  # fmt: skip
    return shift


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
    return _touched(handle, azimuth, centre, level, np.ones(len(level)), footprints)


def _touched(
    handle: AnyArray,
    azimuth: AnyArray,
    centre: AnyArray,
    level: AnyArray,
    share: AnyArray,
    footprints: FootprintTable,
) -> StrokePath:
    """Add the touch before and the lift after."""
    pick = np.r_[0, np.arange(len(level)), len(level) - 1]
    level = level[pick]
    descent = footprints.descent_at(level)
    descent[[0, -1]] = 0.0
    level[[0, -1]] = -1.0
    return StrokePath(handle[pick], azimuth[pick], descent, centre[pick], level, share[pick])

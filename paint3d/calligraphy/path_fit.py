"""Following a centre line: the path of the brush that covers most of the outline along it.

Dynamic programming picks the bend directions, trading the width left bare against a trailing tip
and calm turns; the path is smoothed, balanced between both edges, and the pressure limited again
at every pose, so that nothing leaves the outline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from paint3d.calligraphy.centre_line import CentreLine, OutlineField, smooth_along
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.kernels import planning as kernels
from paint3d.calligraphy.lag_compensation import TRIALS, DraggedPath, Lead, pull, refine_pull
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, interpolate, unit_vectors
from paint3d.errors import InputError

__all__ = ["TECHNIQUES", "FittedLine", "PathFitter", "PlanSettings", "StrokePath"]

# ---- Settings ------------------------------------------------------------------------------------
# How strokes are planned.


TECHNIQUES = {"zhongfeng": math.pi, "cefeng": 0.75 * math.pi, "pianfeng": 0.5 * math.pi}
"""Angle between bend and motion, rad (Guo 2017, section 5)."""


@dataclass(frozen=True)
class PlanSettings:
    """Options of planning a stroke; lengths in fractions of the em.

    Attributes
    ----------
    sample_step, pose_step : float
        Distance of the samples that directions are chosen for, and of the final poses.
    margin : float
        How far a footprint may stand out of the outline.
    n_directions : int
        Bend directions tried.
    shifts : tuple of float
        Side steps tried, in fractions of the narrower half of the stroke.
    trailing : float
        Cost of a leading tip (0 for a trailing one), in stroke widths left bare.
    turning, shifting : float
        Cost of a turn of one radian, and of a side step of one half width, over one stroke width.
    detours : int
        How many bare corners the line is led into, one after another.
    worth : float
        Fraction of the bare area that a detour must gain.
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
_CALM_WIDTHS = 0.2  # that chosen paths are smoothed over
_ALIKE = 1e-9  # mm, or rad: samples no farther apart are the same
_SPAN = 0.12  # of the width: how far a path steps aside to lie in the middle


@dataclass(frozen=True, eq=False)
class StrokePath:
    """The path of the brush through one stroke: N poses with an upright holder, in order.

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
class FittedLine:
    """A line, and the path and bare area that follow from it.

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
    path : StrokePath or None
        None: nothing fits.
    bare : (H, W) bool
        What it leaves bare, on the outline's grid.
    """

    line: CentreLine
    gap: NDArray[np.float64]
    chosen: NDArray[np.float64]
    shift: NDArray[np.float64]
    path: StrokePath | None
    bare: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class PathFitter:
    """State shared while one stroke's path is improved; see `plan_stroke`."""

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

    def follow(self, line: CentreLine, known: FittedLine | None = None) -> FittedLine:
        """The path along a line; what is known of one that it shares samples with is reused."""
        gap = _rate_directions(line, self, known)
        chosen = _choose_path(line, gap, self)
        shift = _balance_edges(line, self, chosen, known)
        path, bare = self._fit(line, chosen[:, 0], shift)
        return FittedLine(line, gap, chosen, shift, path, bare)

    def _fit(
        self, line: CentreLine, azimuth: AnyArray, shift: AnyArray
    ) -> tuple[StrokePath | None, NDArray[np.bool_]]:
        """The path of the largest footprints that fit, and what it leaves bare."""
        led = self._fit_footprints(line, azimuth, shift)
        if led is None:
            return None, self.field.inside
        centre, azimuth, level = led
        if self.settings.azimuth == "dragged":
            lead = self._make_lead(centre, azimuth, _smooth_levels(level))
            path = _add_touch_and_lift(*pull(lead), self.footprints)
        else:
            level = _smooth_levels(level)
            reach = self.footprints.centroid_at(level)
            handle = centre - reach[:, None] * unit_vectors(azimuth)
            whole = np.ones(len(level))
            path = _add_touch_and_lift(handle, azimuth, centre, level, whole, self.footprints)
        return path, self.field.inside & ~self._painted_mask(path)

    def _fit_footprints(
        self, line: CentreLine, azimuth: AnyArray, shift: AnyArray
    ) -> tuple[AnyArray, AnyArray, AnyArray] | None:
        """Centres (N, 2), azimuths and levels (N,) of footprints that fit; None: there are none."""
        shift = smooth_along(shift[:, None], 0.5 * _smoothing_samples(line))[:, 0]
        centre, azimuth = _smooth_path(line, azimuth, shift, self.settings.pose_step * self.em_mm)
        level = np.empty(len(centre))
        kernels.fit_levels(self.target, centre, azimuth, np.ones(len(centre)), level)
        fitting = np.flatnonzero(level >= 0.0)
        return None if len(fitting) < 2 else (centre[fitting], azimuth[fitting], level[fitting])

    def _make_lead(self, centre: AnyArray, azimuth: AnyArray, level: AnyArray) -> Lead:
        start = float(azimuth[0]) if self.start is None else self.start
        return Lead(centre, self.footprints, self.target, start, level)

    def _painted_mask(self, path: StrokePath) -> NDArray[np.bool_]:
        """Mask of what a path covers (H, W), on the outline's grid."""
        painted = np.zeros(self.field.distance.shape, np.bool_)
        kernels.cover(
            self.footprints.points, path.level, path.centre, path.azimuth, path.share,
            self.field.grid, painted,
        )  # fmt: skip
        return painted

    def refine_dragged(self, best: FittedLine) -> FittedLine:
        """The same line, along which a dragged brush is led on while that betters the path."""
        led = self._fit_footprints(best.line, best.chosen[:, 0], best.shift)
        if led is None or best.path is None or self.settings.azimuth != "dragged":
            return best
        lead, path, inside = self._make_lead(*led), best.path, self.field.inside
        values = (path.handle, path.azimuth, path.centre, path.level, path.share)
        dragged = DraggedPath(*(value[1:-1] for value in values))  # without its touch and its lift
        least = int((self._painted_mask(path) ^ inside).sum())
        for trial in range(TRIALS):
            for one in refine_pull(lead, dragged, trial):
                tried = _add_touch_and_lift(*one, self.footprints)
                wrong = int((self._painted_mask(tried) ^ inside).sum())
                if wrong < least:
                    dragged, path, least = one, tried, wrong
        return replace(best, path=path, bare=inside & ~self._painted_mask(path))


def _rate_directions(
    line: CentreLine, fitter: PathFitter, known: FittedLine | None
) -> NDArray[np.float64]:
    """The width that every direction and side step leaves bare at every sample (S, A, O), mm."""
    shifts = np.array(fitter.settings.shifts)
    gap = np.empty((len(line.points), fitter.settings.n_directions, len(shifts)))
    new = slice(None)
    if known is not None:
        new = _copy_known(gap, known.gap, _sample_values(line), _sample_values(known.line))
    sparse = np.ascontiguousarray(fitter.footprints.points[:, ::2])  # directions are only compared
    target = fitter.target._replace(points=sparse)
    kernels.rate(
        target, line.points[new], line.headings[new], line.clearance[new], shifts, gap[new]
    )
    return gap


def _sample_values(line: CentreLine) -> NDArray[np.float64]:
    """Values that a footprint's fit depends on at every sample of a line (S, 6)."""
    return np.concatenate([line.points, line.normals, line.clearance], axis=1)


def _copy_known(out: AnyArray, known: AnyArray, mine: AnyArray, theirs: AnyArray) -> slice:
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


def _choose_path(line: CentreLine, gap: AnyArray, fitter: PathFitter) -> NDArray[np.float64]:
    """The azimuth (rad) and the side step (mm) chosen for every sample of the line (S, 2)."""
    settings = fitter.settings
    n, shifts = settings.n_directions, np.array(settings.shifts)
    directions = 2.0 * np.pi * np.arange(n) / n
    ahead = directions[None, :] - line.headings[:, None]
    cost = gap / line.width + _cost_of_bend(ahead, settings)[:, :, None]
    per_width = line.step / line.width
    turn = settings.turning * (2.0 * np.pi / n / per_width) ** 2
    aside = settings.shifting * ((shifts[1] - shifts[0]) / per_width) ** 2
    angle, side = np.empty(len(gap), np.int64), np.empty(len(gap), np.int64)
    kernels.best_course(cost, turn, aside, 3, angle, side)
    steps = shifts[side] * line.clearance.min(axis=1)
    return smooth_along(
        np.stack([np.unwrap(directions[angle]), steps], axis=1), _smoothing_samples(line)
    )


def _smoothing_samples(line: CentreLine) -> float:
    """The number of samples over which a chosen path is smoothed."""
    return _CALM_WIDTHS * line.width / line.step


def _cost_of_bend(ahead: AnyArray, settings: PlanSettings) -> NDArray[np.float64]:
    """Cost of bends at angles from the heading (rad), in stroke widths left bare."""
    technique = "zhongfeng" if settings.azimuth == "dragged" else settings.technique
    if technique is None:
        return settings.trailing * (0.5 + 0.5 * np.cos(ahead))
    wanted = TECHNIQUES[technique]
    off = np.maximum(np.cos(ahead - wanted), np.cos(ahead + wanted))
    return settings.holding * (0.5 - 0.5 * off)


def _balance_edges(
    line: CentreLine, fitter: PathFitter, chosen: AnyArray, known: FittedLine | None
) -> NDArray[np.float64]:
    """Side steps (S,) near the chosen ones by which both edges are reached alike, mm."""
    azimuth, shift = chosen[:, 0].copy(), chosen[:, 1].copy()
    new = slice(None)
    if known is not None:
        mine, theirs = (
            np.concatenate([_sample_values(one), path], axis=1)
            for one, path in ((line, chosen), (known.line, known.chosen))
        )
        new = _copy_known(shift, known.shift, mine, theirs)
    kernels.balance(
        fitter.target, line.points[new], line.headings[new], line.clearance[new], azimuth[new],
        _SPAN * line.width, shift[new],
    )  # fmt: skip
    return shift


def _smooth_path(
    line: CentreLine, azimuth: AnyArray, shift: AnyArray, step: float
) -> tuple[AnyArray, AnyArray]:
    """Interpolate the chosen path at the final step: centres (N, 2) and azimuths (N,)."""
    centre = line.points + shift[:, None] * line.normals
    along = arc_lengths(centre)
    at = np.linspace(0.0, along[-1], max(8, math.ceil(along[-1] / step)) + 1)
    dense = interpolate(at, along, np.column_stack([centre, azimuth]))
    smooth = smooth_along(dense, line.step / step)
    return np.ascontiguousarray(smooth[:, :2]), np.ascontiguousarray(smooth[:, 2])


def _smooth_levels(level: AnyArray) -> NDArray[np.float64]:
    """Smooth the levels from below: never above what fits."""
    low = minimum_filter1d(level, 2 * _CALM + 1, mode="nearest")
    calm = gaussian_filter1d(low, 0.5 * _CALM, truncate=2.0, mode="nearest")
    result: NDArray[np.float64] = np.minimum(calm, level)
    return result


def _add_touch_and_lift(
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

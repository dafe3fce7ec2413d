"""Planning strokes: from an outline to the path of the brush that fills it.

The method is that of contained footprints. Along the stroke's centre line every bend direction is
rated by how much of the width the largest footprint leaves bare that still lies within the outline;
a path is chosen among them and followed (`path_fit`), and the line is then led into the largest
corners that are still bare (`_lead_into_corners`). The handle stands at P'_m, the foot of the root
node, not at the footprint's centre.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.centre_line import (
    CentreLine,
    OutlineField,
    centre_line,
    grid_step,
    measure_line,
    outline_field,
)
from paint3d.calligraphy.dabs import dabs_in
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.glyphs import DESCENDER, EM_UNITS, Glyph
from paint3d.calligraphy.kernels.raster import fill_depths, label_patches
from paint3d.calligraphy.path_fit import FittedLine, PathFitter, PlanSettings, StrokePath
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import resample
from paint3d.errors import InputError

__all__ = [
    "Corner",
    "corners_in",
    "detours_to",
    "on_paper",
    "plan_glyph",
    "plan_stroke",
]

# ---- Bare corners --------------------------------------------------------------------------------
# Bare corners of a stroke, and how its line goes there: by a bend, or out into the tip and back.
#
# A bend suits what lies beside a line that goes on. Where it ends, or is folded, the tuft is led
# from where a disc reaches nearest to the corner straight into its tip, as narrow as it gets, and
# back.


_LEAST_AREA = 1.8  # of the square of the disc that must fit into a patch
_OTHER_TIP = 0.25  # widths: two tips of a corner that are nearer to each other are one
_NEAR_END = 0.5  # widths: a bend nearer to an end than that would only move the end
_BEND = 0.3  # widths to either side that a bend takes
_BEND_REACH = 1.2  # widths: beyond, the line stays


@dataclass(frozen=True, eq=False)
class Corner:
    """A bare patch that is worth a detour.

    Attributes
    ----------
    middle : (2,) float64
        Its innermost point, mm.
    points : (N, 2) float64
        The grid points in it, mm.
    at : ((N,) int64, (N,) int64)
        Their rows and columns.
    """

    middle: NDArray[np.float64]
    points: NDArray[np.float64]
    at: tuple[NDArray[np.int64], NDArray[np.int64]]


def corners_in(
    bare: NDArray[np.bool_], line: CentreLine, field: OutlineField, finest: float
) -> list[Corner]:
    """The bare patches (H, W) that are worth a detour, the largest first.

    A patch counts where a disc of the fraction `finest` of the stroke's width would fit in.
    """
    step = float(field.grid[2])
    disc = finest * line.width / step
    depth, labels = np.empty(bare.shape), np.empty(bare.shape, np.int32)
    fill_depths(bare, depth)
    n = label_patches(bare, labels)
    deepest = np.zeros(n + 1)
    np.maximum.at(deepest, labels[bare], depth[bare])
    areas = np.bincount(labels.ravel(), minlength=n + 1) * (deepest > 0.5 * disc)
    large = [k for k in np.argsort(-areas, kind="stable") if areas[k] >= _LEAST_AREA * disc**2]
    corners = []
    for k in large:
        rows, columns = np.nonzero(labels == k)
        points = field.grid[:2] + step * np.stack([columns, rows], axis=1)
        middle = points[int(np.argmax(depth[rows, columns]))]
        corners.append(Corner(middle, points, (rows, columns)))
    return corners


def detours_to(
    corner: Corner, line: CentreLine, field: OutlineField, is_held: bool
) -> Iterator[CentreLine]:
    """The line with its detours to a corner: visits, and a bend where it goes on beyond.

    A second visit goes to what lies farthest towards the corner's middle, where that is not the
    farthest of it: a rim runs on from there that is too thin to be worth a path.

    Where the bend of the tuft `is_held` against the motion nothing turns back: a bend only.
    """
    if not is_held:
        yield _visiting(line, corner, field)
        k, tip = _find_departure(line, corner, field)
        ahead = (corner.points - line.points[k]) @ (corner.middle - line.points[k])
        other = corner.points[int(np.argmax(ahead))]
        if np.linalg.norm(other - tip) > _OTHER_TIP * line.width:
            yield _visit_point(other, k, line, field)
    nearest = int(np.argmin(np.linalg.norm(line.points - corner.middle, axis=1)))
    if is_held or min(nearest, len(line.points) - 1 - nearest) * line.step > _NEAR_END * line.width:
        yield _bend_to(line, corner, nearest, field)


def _bend_to(line: CentreLine, corner: Corner, nearest: int, field: OutlineField) -> CentreLine:
    """Bend a line out to a corner beside it and back, within about a width."""
    apart = np.linalg.norm(line.points - corner.middle, axis=1)
    along = (np.arange(len(apart)) - nearest) * line.step / line.width
    near = np.flatnonzero(np.abs(along) < _BEND_REACH)
    bump = np.exp(-0.5 * (along[near] / _BEND) ** 2)[:, None]
    bent = line.points[near] + bump * (corner.middle - line.points[nearest])
    before, after = line.points[: near[0]], line.points[near[-1] + 1 :]
    points = np.concatenate([before, resample(bent, line.step, 5), after])
    return measure_line(points, line.width, line.step, field)


def _visiting(line: CentreLine, corner: Corner, field: OutlineField) -> CentreLine:
    """Leave a line, where a disc on it reaches nearest to a corner, for its tip and come back."""
    k, tip = _find_departure(line, corner, field)
    return _visit_point(tip, k, line, field)


def _find_departure(
    line: CentreLine, corner: Corner, field: OutlineField
) -> tuple[int, NDArray[np.float64]]:
    """The sample from which a corner is visited, and its point that is farthest from there."""
    apart = np.linalg.norm(line.points - corner.middle, axis=1)
    k = int(np.argmin(apart / np.maximum(field.depths(line.points), 0.5 * field.grid[2])))
    far = np.linalg.norm(corner.points - line.points[k], axis=1)
    return k, corner.points[int(np.argmax(far))]


def _visit_point(
    tip: NDArray[np.float64], k: int, line: CentreLine, field: OutlineField
) -> CentreLine:
    """A line that goes from its k-th sample straight to a point, and back."""
    start = line.points[k]
    n = max(2, math.ceil(float(np.linalg.norm(tip - start)) / line.step))
    out = start + np.linspace(0.0, 1.0, n + 1)[:, None] * (tip - start)
    points = np.concatenate([line.points[:k], out, out[-2::-1], line.points[k + 1 :]])
    return measure_line(points, line.width, line.step, field)


# ---- Planning ------------------------------------------------------------------------------------


_FINEST = 1.0 / 9.0  # of the width: bare corners that are looked after
_FINEST_DRAGGED = 1.0 / 8.0  # the same where each try costs a pull, which is half of all planning


def on_paper(points: AnyArray, em_mm: float) -> NDArray[np.float64]:
    """Carry glyph units (N, 2) to millimetres from the em square's lower left corner."""
    result: NDArray[np.float64] = (
        em_mm / EM_UNITS * (np.asarray(points, np.float64) + np.array([0.0, DESCENDER]))
    )
    return result


def plan_glyph(
    glyph: Glyph,
    em_mm: float,
    footprints: FootprintTable,
    settings: PlanSettings | None = None,
    threads: int = 1,
) -> list[StrokePath]:
    """Plan all strokes of a glyph, in writing order, and the dabs of one that is solid after them.

    Parameters
    ----------
    glyph : Glyph
    em_mm : float
        Side of the em square, mm.
    footprints : FootprintTable
        Footprints of the brush.
    settings : PlanSettings, optional
    threads : int
        How many strokes to plan at once, where none depends on the one before; the result is the
        same.

    Raises
    ------
    InputError
        If a stroke is too fine for the brush.
    """

    def plan(k: int, start: float | None = None) -> StrokePath:
        stroke = glyph.strokes[k]
        outline, median = on_paper(stroke.outline, em_mm), on_paper(stroke.median, em_mm)
        holes = [on_paper(hole, em_mm) for hole in stroke.holes]
        name = f"stroke {k + 1} of {glyph.text}"
        return plan_stroke(outline, median, em_mm, footprints, settings, name, start, holes)

    numbers = range(len(glyph.strokes))
    paths: list[StrokePath] = []
    if settings is not None and settings.azimuth == "dragged":  # the tuft lies as it was left
        for k in numbers:
            paths.append(plan(k, float(paths[-1].azimuth[-1]) if paths else None))
    else:
        with ThreadPoolExecutor(max(1, min(threads, len(numbers)))) as side_by_side:
            paths += side_by_side.map(plan, numbers)
    evenly = not any(one.dryness or one.strength < 1.0 for one in glyph.strokes)
    if glyph.solid and evenly and paths:
        shapes = [
            (on_paper(one.outline, em_mm), [on_paper(hole, em_mm) for hole in one.holes])
            for one in glyph.strokes
        ]
        paths += dabs_in(shapes, paths, em_mm, footprints, settings or PlanSettings())
    return paths


def plan_stroke(
    outline: NDArray[np.float64],
    median: NDArray[np.float64],
    em_mm: float,
    footprints: FootprintTable,
    settings: PlanSettings | None = None,
    name: str = "stroke",
    start: float | None = None,
    holes: Sequence[AnyArray] = (),
) -> StrokePath:
    """Plan one stroke.

    Parameters
    ----------
    outline : (N, 2) float64
        Closed polygon, mm.
    median : (M, 2) float64
        Centre line in writing order, mm.
    em_mm : float
        Side of the em square, mm: the scale of `settings`, but for strokes so thin that they need
        a finer grid than a 512th of it: these are planned like those of a smaller em.
    footprints : FootprintTable
    settings : PlanSettings, optional
    name : str
        What to call the stroke in messages.
    start : float, optional
        Where a dragged tuft points when it lands, rad; by default where it will be needed. Others
        are not asked.
    holes : sequence of (K, 2) float64
        Closed polygons left out of the outline, mm.

    Raises
    ------
    InputError
        If no footprint of the brush fits anywhere.
    """
    settings = settings or PlanSettings()
    step = grid_step(outline, em_mm, holes)
    fineness = step / (em_mm / 512)
    field = outline_field(outline, step, holes, fineness < 1.0)
    if not field.inside.any():
        raise InputError(
            "{name} is finer than {step:g} mm; expected an outline to fill",
            name=name,
            step=step,
        )
    try:
        line = centre_line(median, field, settings.sample_step * em_mm * fineness)
    except InputError as cause:
        if field.distance.max() < step:  # the line may lie within what the grid does not show
            raise _too_fine(name, em_mm) from None
        raise InputError("{name}: {cause}", name=name, cause=cause) from None
    fitter = PathFitter(field, footprints, settings, em_mm * fineness, start)
    best = fitter.refine_dragged(_lead_into_corners(fitter.follow(line), fitter))
    if best.path is None:
        raise _too_fine(name, em_mm)
    return best.path


def _too_fine(name: str, em_mm: float) -> InputError:
    return InputError(
        "{name} is too fine for this brush at an em of {em_mm:g} mm", name=name, em_mm=em_mm
    )


def _lead_into_corners(best: FittedLine, fitter: PathFitter) -> FittedLine:
    """Lead a line into the bare corners, one after another, and into those that are left at once.

    A detour at one end may change the path at the other: two that fail alone may do together.
    """
    settings, field = fitter.settings, fitter.field
    is_held = settings.technique is not None
    finest = _FINEST_DRAGGED if settings.azimuth == "dragged" else _FINEST
    tried = np.zeros_like(best.bare)
    for _ in range(settings.detours):
        corners = corners_in(best.bare & ~tried, best.line, field, finest)
        if not corners:
            break
        tried[corners[0].at] = True
        best = _best_detour(best, detours_to(corners[0], best.line, field, is_held), fitter)
    left = corners_in(best.bare, best.line, field, finest) if tried.any() and not is_held else []
    if len(left) > 1:
        line = best.line
        for corner in left:
            line = _visiting(line, corner, field)
        best = _best_detour(best, [line], fitter)
    return best


def _best_detour(best: FittedLine, lines: Iterable[CentreLine], fitter: PathFitter) -> FittedLine:
    """The best of some detours; None where none is worth it."""
    least = float(best.bare.sum()) * (1.0 - fitter.settings.worth)
    chosen = best
    for line in lines:
        one = fitter.follow(line, best)
        if one.bare.sum() < least:
            chosen, least = one, float(one.bare.sum())
    return chosen

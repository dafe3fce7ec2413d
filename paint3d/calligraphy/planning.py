"""Planning strokes: from an outline to the course of the brush that fills it.

The method is that of contained footprints. Along the stroke's centre line every bend direction is
rated by how much of the width the largest footprint leaves bare that still lies within the outline;
a course is chosen among them and followed (`path_fit`), and the line is then led into the largest
corners that are still bare (`detours`). The handle stands at P'_m, the foot of the root node, not
at the footprint's centre.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.centre_line import CentreLine, centre_line, grid_step, outline_field
from paint3d.calligraphy.detours import corners_in, detours_to, visiting
from paint3d.calligraphy.footprint_table import FootprintTable
from paint3d.calligraphy.glyphs import DESCENDER, EM_UNITS, Glyph
from paint3d.calligraphy.path_fit import Followed, PathFitter, StrokePath
from paint3d.calligraphy.plan_settings import TECHNIQUES, PlanSettings
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["TECHNIQUES", "PlanSettings", "StrokePath", "on_paper", "plan_glyph", "plan_stroke"]

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
    """Plan all strokes of a glyph, in writing order.

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
    if settings is not None and settings.azimuth == "dragged":  # the tuft lies as it was left
        courses: list[StrokePath] = []
        for k in numbers:
            courses.append(plan(k, float(courses[-1].azimuth[-1]) if courses else None))
        return courses
    with ThreadPoolExecutor(max(1, min(threads, len(numbers)))) as side_by_side:
        return list(side_by_side.map(plan, numbers))


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
        raise InputError(f"{name} is finer than {step:g} mm; expected an outline to fill")
    try:
        line = centre_line(median, field, settings.sample_step * em_mm * fineness)
    except InputError as cause:
        if field.distance.max() < step:  # the line may lie within what the grid does not show
            raise InputError(_too_fine(name, em_mm)) from None
        raise InputError(f"{name}: {cause}") from None
    plan = PathFitter(field, footprints, settings, em_mm * fineness, start)
    best = plan.finished(_into_corners(plan.follow(line), plan))
    if best.course is None:
        raise InputError(_too_fine(name, em_mm))
    return best.course


def _too_fine(name: str, em_mm: float) -> str:
    return f"{name} is too fine for this brush at an em of {em_mm:g} mm"


def _into_corners(best: Followed, plan: PathFitter) -> Followed:
    """Lead a line into the bare corners, one after another, and into those that are left at once.

    A detour at one end may change the course at the other: two that fail alone may do together.
    """
    settings, field = plan.settings, plan.field
    held = settings.technique is not None
    finest = _FINEST_DRAGGED if settings.azimuth == "dragged" else _FINEST
    tried = np.zeros_like(best.bare)
    for _ in range(settings.detours):
        corners = corners_in(best.bare & ~tried, best.line, field, finest)
        if not corners:
            break
        tried[corners[0].at] = True
        best = _better(best, detours_to(corners[0], best.line, field, held), plan)
    left = corners_in(best.bare, best.line, field, finest) if tried.any() and not held else []
    if len(left) > 1:
        line = best.line
        for corner in left:
            line = visiting(line, corner, field)
        best = _better(best, [line], plan)
    return best


def _better(best: Followed, lines: Iterable[CentreLine], plan: PathFitter) -> Followed:
    """The best of some detours, or none where none is worth it."""
    least = float(best.bare.sum()) * (1.0 - plan.settings.worth)
    found = best
    for line in lines:
        one = plan.follow(line, best)
        if one.bare.sum() < least:
            found, least = one, float(one.bare.sum())
    return found

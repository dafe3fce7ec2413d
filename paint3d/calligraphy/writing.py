"""Writing a text on an object: glyphs, planned strokes, em squares on the surface, one recording.

Everything is told by the recording of the handle that comes out: replaying it paints the text.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.brush_engine.tuft import Tuft
from paint3d.calligraphy.footprint_table import FootprintTable, tabulate_footprints
from paint3d.calligraphy.glyph_sources import GlyphSource, load_glyphs
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.hand_motion import (
    HandMotion,
    join_motions,
    root_stretch,
    to_hand_motion,
    travel,
)
from paint3d.calligraphy.layout import Layout, PlacedCharacter, layout_text
from paint3d.calligraphy.planning import PlanSettings, plan_glyph
from paint3d.calligraphy.processes import in_processes
from paint3d.calligraphy.timing import Motion, Tempo, time_courses
from paint3d.core.arrays import as_number
from paint3d.core.types import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import InputError, MeshError
from paint3d.mesh.chart import make_chart
from paint3d.mesh.closest_points import ClosestPoints
from paint3d.mesh.em_square import SquareLimits
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["Pen", "Written", "write_text"]

LEAST_EM_MM, MOST_EM_MM = 2.0, 1000.0

_WIDEST = 0.2  # ems: the last footprint of the table
_NODES_PER_EM = 24.0
_STEPS_PER_EM = 64.0
_FINEST_MM = 0.25
_DECIMALS = {"position": 6, "orientation": 7, "pressure": 7}  # 1 nm: keeps the jerk unrounded
_MOST_STRETCH = 2.0
_FEW = 3  # characters that are not worth starting processes for


@dataclass(frozen=True)
class Pen:
    """What is written with, and how.

    Attributes
    ----------
    brush : BrushSpec
    em_mm : float
        Side of the em squares, mm.
    settings : PlanSettings
    tempo : Tempo
    """

    brush: BrushSpec
    em_mm: float
    settings: PlanSettings = field(default_factory=PlanSettings)
    tempo: Tempo = field(default_factory=Tempo)


@dataclass(frozen=True, eq=False)
class Written:
    """A text as the way of the hand, and where its characters are.

    Attributes
    ----------
    recording : Recording
        In world space, the world being the object's frame.
    characters : list of dict
        ``{"text", "frame": {"origin", "x_axis", "y_axis", "em_mm"}}`` in writing order: a glyph
        unit (x, y) lies at origin + em_mm/1024 (x x_axis + (y + 124) y_axis), bent onto the
        surface.
    """

    recording: Recording
    characters: list[dict[str, Any]]


def write_text(
    mesh: TriangleMesh,
    text: str,
    source: GlyphSource,
    pen: Pen,
    layout: Layout | None = None,
    *,
    header: Mapping[str, object] | None = None,
    processes: int = 1,
    progress: Callable[[str, float], None] | None = None,
) -> Written:
    """Plan a text on an object.

    Parameters
    ----------
    mesh : TriangleMesh
    text : str
        Line breaks start a new column or row; other white space is passed over.
    source : GlyphSource
    pen : Pen
    layout : Layout, optional
    header : mapping, optional
        More entries for the recording's header, such as the ink.
    processes : int
        How many to plan in at once; the result is the same to the bit. More than one needs a main
        module that can be imported, as `multiprocessing` does.
    progress : callable, optional
        Called with each character when it is planned, and the fraction done.

    Raises
    ------
    InputError
        If the text is empty, has unknown characters, does not fit, or a stroke cannot be written.
    MeshError
        If the surface has no place for a character.
    """
    as_number(pen.em_mm, "size", LEAST_EM_MM, MOST_EM_MM)
    glyphs = load_glyphs(source, "".join(text.split()))
    surface, limits = _surface_of(mesh), SquareLimits(room_mm=pen.brush.length_mm)
    placed = layout_text(surface, text, pen.em_mm, layout, limits)
    tuft = build_tuft(pen.brush)
    footprints = tabulate_footprints(tuft, _WIDEST * pen.em_mm)
    pen = replace(pen, tempo=pen.tempo.slower(_root_stretch(placed, tuft)))
    motions: dict[str, Motion] = {}
    with closing(_plan_all(glyphs, footprints, pen, processes)) as plans:
        for character, motion in zip(glyphs, plans, strict=True):
            motions[character] = motion
            if progress is not None:
                progress(character, len(motions) / len(glyphs))
    laid = [_laid(surface, character, motions[character.text], tuft, pen) for character in placed]
    told = [_described(character) for character in placed]
    entries = {
        "brush": pen.brush.name,
        "object": mesh.name,
        "licence": f"{source.licence}. Motion: paint3d.",
        "azimuth": pen.settings.azimuth,
        **(header or {}),
        "characters": told,
    }
    return Written(_recording(_joined(laid, surface, tuft, pen.tempo), pen, entries), told)


@lru_cache(maxsize=1)
def _surface_of(mesh: TriangleMesh) -> ClosestPoints:
    """The mesh's closest points; the last are kept, as texts on one object often follow."""
    return ClosestPoints(mesh)


# -- planning -----------------------------------------------------------------------------------


def _plan_all(
    glyphs: Mapping[str, Glyph], footprints: FootprintTable, pen: Pen, processes: int
) -> Generator[Motion]:
    """The motions of glyphs in their order; few are planned here, stroke beside stroke."""
    n = min(processes, len(glyphs))
    if n < 2 or len(glyphs) < _FEW:
        for glyph in glyphs.values():
            yield _planned(glyph, footprints, pen, processes)
        return
    yield from in_processes(
        partial(_planned, footprints=footprints, pen=pen), [*glyphs.values()], n
    )


def _planned(glyph: Glyph, footprints: FootprintTable, pen: Pen, threads: int = 1) -> Motion:
    courses = plan_glyph(glyph, pen.em_mm, footprints, pen.settings, threads)
    return time_courses([courses], pen.em_mm, pen.tempo)


# -- laying -------------------------------------------------------------------------------------


def _root_stretch(placed: list[PlacedCharacter], tuft: Tuft) -> float:
    """How much longer the root's ways are than those that are planned; rough spots count as 2."""
    squares = [character.square for character in placed]
    return min(_MOST_STRETCH, max(root_stretch(s.points, s.normals, tuft) for s in squares))


def _laid(
    surface: ClosestPoints, character: PlacedCharacter, motion: Motion, tuft: Tuft, pen: Pen
) -> HandMotion:
    """A character's motion on the surface; the chart reaches as far as the handle goes."""
    em = pen.em_mm
    reach = np.abs(motion.handle - 0.5 * em).max(axis=0)
    half_width, half_height = np.maximum(reach, 0.5 * em) + 0.01 * em
    step = max(_FINEST_MM, em / _STEPS_PER_EM)
    frame = character.square.chart.frame
    try:
        chart = make_chart(surface, frame, half_width, half_height, em / _NODES_PER_EM, step)
    except MeshError as cause:
        raise MeshError(
            f"{character.text!r}: its strokes reach beyond where one can write ({cause}); "
            "expected a smaller size or another place"
        ) from None
    return to_hand_motion(motion, chart, em, tuft)


def _described(character: PlacedCharacter) -> dict[str, Any]:
    """A character's entry in the report and in the recording's header."""
    square = character.square
    frame = square.chart.frame
    return {
        "text": character.text,
        "frame": {
            "origin": square.points[0, 0].round(4).tolist(),
            "x_axis": frame.x_axis.round(7).tolist(),
            "y_axis": frame.y_axis.round(7).tolist(),
            "em_mm": square.em_mm,
        },
    }


def _joined(laid: list[HandMotion], surface: ClosestPoints, tuft: Tuft, tempo: Tempo) -> HandMotion:
    parts = [laid[0]]
    for motion in laid[1:]:
        parts.extend([travel(parts[-1], motion, surface, tuft, tempo), motion])
    return join_motions(parts)


def _recording(hand: HandMotion, pen: Pen, header: Mapping[str, object]) -> Recording:
    step_ns = round(1e9 / pen.tempo.rate_hz)
    entries = {"devices": {"right": f"planned, {pen.tempo.rate_hz:g} Hz"}, **header}
    return Recording(
        step_ns * np.arange(len(hand.position), dtype=np.int64),
        _rounded(hand.position, "position"),
        _rounded(hand.orientation, "orientation"),
        np.minimum(_rounded(hand.pressure, "pressure"), 1.0),
        hand.buttons,
        header=entries,
    )


def _rounded(values: AnyArray, what: str) -> AnyArray:
    if not np.isfinite(values).all():
        raise InputError(f"the plan's {what} is not finite; expected numbers")
    return np.round(values, _DECIMALS[what])

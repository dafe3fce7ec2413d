"""Texts of the page's copybook: outlines of characters, layout, and planned handwriting.

Files for the page (`paint3d.page.bundle`). One is of outlines; words: ``{"licence", "characters":
{character: [..]}}``, of each the counts of points of its rings in `outlines`, (N, 2) int16 glyph
units from the middle of the em square. One is of each planned hand; words: ``{"steps",
"characters": {character: [..]}}``, of each the counts of samples of its strokes in `samples`, (9,
M) int16 in units of `steps` (9,): s since the stroke's first, the position of the brush's root over
flat paper, mm from the square's middle, its orientation, and its pressure. A hand is planned at one
size, for one brush; at another size within `SCALED` its paths are scaled, and its strokes keep
their width.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from paint3d.brush.presets import SMALLEST_PRESET_EM, brush_for, load_brush
from paint3d.calligraphy.composition import compose, sign_beside
from paint3d.calligraphy.fonts.fallback import with_fallback
from paint3d.calligraphy.glyph_sources import GlyphSource, open_glyphs
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.layout import Layout, layout_text
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.sheet_mesh import sheet_of
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.page.tables import Table

__all__ = [
    "EM_MM",
    "KNOWN",
    "SCALED",
    "SIGNED",
    "LaidOut",
    "PlannedHand",
    "glyphs_for",
    "hand_table",
    "hands_for",
    "lay_out",
    "outline_table",
]

KNOWN = (
    "永和九年歲在癸丑暮春之初會于山陰蘭亭修禊事也一二三四五六七八十甲乙丙丁戊己庚辛壬"
    "子寅卯辰巳午未申酉戌亥年書月日夏秋冬人天地水火木金石竹梅花心道"
)
"""Characters whose outlines are always included, but which are not planned."""
SIGNED = "甲乙丙丁戊己庚辛壬癸子丑寅卯辰巳午未申酉戌亥年書"
"""Characters that the years of the sexagenary cycle are signed with."""
EM_MM = 40.0
"""Size of texts on objects that are no sheets."""
SCALED = 1.27
"""Greatest factor by which planned handwriting is enlarged or reduced."""

_SIGNATURE = 4  # characters
_SIGNATURE_MM = 14.0  # size on objects that are no sheets
_EVERY = 4  # of a plan's 250 samples a second that are kept
_TOLERANCE = 1.5  # glyph units between an outline and its chords
_PAPER_EM = 1.5  # side of the paper that a plan is made on
_SECONDS, _EM_PARTS, _TURNS, _PRESSURES = 2.0**-10, 2.0**-13, 2.0**-14, 2.0**-14  # steps


class LaidOut(NamedTuple):
    """Layout of a text on an object and of the signature beside it, as `LaidText` stores them."""

    text: dict[str, Any]
    signature: dict[str, Any]
    seal_mm: float


class PlannedHand(NamedTuple):
    """A brush, the size at which it is planned, mm, and the characters that it writes."""

    brush: str
    em_mm: float
    characters: str


def glyphs_for(text: str) -> GlyphSource:
    """Open a source of glyphs that has all characters of a text.

    Raises
    ------
    GlyphError, InputError
        If a character has no glyph, nor one in the system's fonts.
    """
    return with_fallback(open_glyphs(None), "".join(text.split()))


def lay_out(mesh: TriangleMesh, text: str) -> LaidOut:
    """Lay a text out to fill a sheet, with its signature; on other objects at usual sizes."""
    sheet = sheet_of(mesh)
    try:
        composed = None if sheet is None else compose(sheet, text, signature=_SIGNATURE)
    except InputError:  # too long for it, which the page says
        composed = None
    if composed is None:
        return LaidOut({"text": text, "em_mm": EM_MM}, {"em_mm": _SIGNATURE_MM}, _SIGNATURE_MM)
    lines, em_mm = "\n".join(composed.lines), round(composed.em_mm, 1)
    gap, between = round(composed.gap, 3), round(composed.between, 3)
    at = composed.point
    point = None if at is None else (round(at[0], 1), round(at[1], 1), round(at[2], 1))
    layout = Layout(point=point, gap=gap, between=between)
    squares = [placed.square for placed in layout_text(ClosestPoints(mesh), lines, em_mm, layout)]
    signed = sign_beside(mesh, squares, _SIGNATURE)
    middle = np.mean([square.chart.frame.origin for square in squares], axis=0)
    return LaidOut(
        {"text": lines, "em_mm": em_mm, "point": list(point or middle.round(1).tolist())}
        | {"gap": gap, "between": between},
        {"em_mm": round(signed.em_mm, 1), "point": signed.point.round(1).tolist()},
        round(signed.seal_mm),
    )


def hands_for(
    wanted: Iterable[tuple[float, str]], brushes: Sequence[str]
) -> tuple[PlannedHand, ...]:
    """Choose the hands to plan for texts of some sizes, mm: one for all sizes within `SCALED`.

    Sizes below those that presets are made for get none. Each hand has the brush whose diameter is
    nearest to the one that suits its size.
    """
    groups: list[list[tuple[float, str]]] = []
    for em_mm, text in sorted(one for one in wanted if one[0] >= SMALLEST_PRESET_EM):
        if not groups or em_mm > SCALED * _middle(groups[-1][0][0], em_mm):
            groups.append([])
        groups[-1].append((em_mm, text))
    hands = []
    for group in groups:
        em_mm = _middle(group[0][0], group[-1][0])
        characters = "".join("".join(text for _, text in group).split())
        wanted_mm = brush_for(em_mm).root_diameter_mm
        brush = min(
            brushes, key=lambda name: abs(math.log(load_brush(name).root_diameter_mm / wanted_mm))
        )
        hands.append(PlannedHand(brush, em_mm, "".join(dict.fromkeys(characters))))
    return tuple(hands)


def _middle(low: float, high: float) -> float:
    """Compute the size, mm, to plan at for all between two, within `SCALED` of the smallest."""
    return math.floor(10.0 * min(math.sqrt(low * high), SCALED * low)) / 10.0


def outline_table(text: str, source: GlyphSource) -> Table:
    """Make the table of outlines of a text's characters and of those of `KNOWN`."""
    every = dict.fromkeys([*"".join(text.split()), *filter(source.has, KNOWN)])
    rings = {one: list(_rings(source.load(one))) for one in every}
    words = {
        "licence": source.licence,
        "characters": {one: list(map(len, rings[one])) for one in every},
    }
    outlines = [ring for one in every for ring in rings[one]]
    return words, {"outlines": np.concatenate([np.empty((0, 2), np.int16), *outlines])}


def _rings(glyph: Glyph) -> Iterable[AnyArray]:
    """Yield the rings of a glyph, (N, 2) int16 from the middle of the em square, simplified."""
    import shapely

    for stroke in glyph.strokes:
        for ring in (stroke.outline, *stroke.holes):
            line = shapely.LinearRing(ring - np.array(glyph.middle)).simplify(_TOLERANCE)
            yield np.rint(shapely.get_coordinates(line)[:-1]).astype(np.int16)


def hand_table(hand: PlannedHand, source: GlyphSource) -> Table:
    """Make the table of a hand's characters as it writes them.

    Raises
    ------
    InputError
        If a character is too fine for the brush.
    """
    steps = [_SECONDS, *[hand.em_mm * _EM_PARTS] * 3, *[_TURNS] * 4, _PRESSURES]
    plan = partial(_plan, source=source, brush=hand.brush, em_mm=hand.em_mm)
    plans: Mapping[str, list[AnyArray]] = {one: plan(one) for one in hand.characters}
    samples = [stroke for one in hand.characters for stroke in plans[one]]
    counted = np.rint(np.concatenate([np.empty((0, len(steps))), *samples]) / np.array(steps))
    words = {
        "steps": steps,
        "characters": {one: list(map(len, plans[one])) for one in hand.characters},
    }
    return words, {"samples": np.ascontiguousarray(counted.T.astype(np.int16))}


def _plan(text: str, source: GlyphSource, brush: str, em_mm: float) -> list[AnyArray]:
    """Plan a character's strokes on flat paper, (M, 9) each: see the module."""
    side = _PAPER_EM * em_mm
    paper = load_mesh(f"sheet:{side:g}x{side:g}")
    settings = WritingSettings(load_brush(brush), em_mm)
    written = write_text(paper, text, source, settings, Layout(point=(0.0, 0.0, 0.0))).recording
    assert written.pressure is not None, "a plan has pressures"
    down = np.concatenate([[False], written.pressure > 0.0, [False]])
    ends = np.flatnonzero(down[1:] != down[:-1]).reshape(-1, 2)
    strokes = []
    for first, last in ends:
        ids = np.unique([*range(first, last, _EVERY), last - 1])
        seconds = (written.time_ns[ids] - written.time_ns[first]) * 1e-9
        rows = [seconds, written.position[ids], written.orientation[ids], written.pressure[ids]]
        strokes.append(np.column_stack(rows))
    return strokes

"""Characters of the page's copybook: what they look like, and how a planned hand writes them.

A file for the page (`paint3d.page.bundle`). Words: ``{"brush", "em_mm", "licence", "characters":
{character: {"rings": [..], "plan": [..]}}}``; rings are counts of points of `outlines`, plans those
of rows of `samples`, stroke by stroke, both in the order of the characters. Outlines are (N, 2)
int16 glyph units from the middle of the em square; samples (M, 9) float32 are s since the stroke's
first, the place of the brush's root over flat paper, mm from the square's middle, its orientation,
and its pressure. What is planned holds for that brush and em alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyph_sources import GlyphSource, load_glyphs, open_glyphs
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.core.arrays import AnyArray
from paint3d.files.load import load_mesh
from paint3d.page.tables import Table

__all__ = ["KNOWN", "copybook_table"]

KNOWN = (
    "永和九年歲在癸丑暮春之初會于山陰蘭亭修禊事也一二三四五六七八十甲乙丙丁戊己庚辛壬"
    "子寅卯辰巳午未申酉戌亥月日夏秋冬人天地水火木金石竹梅花心書道"
)
"""Characters that are there without being asked for, but not planned."""

_EVERY = 4  # of a planned hand's 250 samples a second
_STRAY = 1.5  # glyph units that an outline's chord may
_AROUND = 1.5  # ems of paper that a plan is made on


def copybook_table(text: str, brush: str, em_mm: float) -> Table:
    """The characters of a text, planned, and those of `KNOWN`.

    Raises
    ------
    InputError
        If a character of the text is not known, or too fine for the brush.
    """
    source = open_glyphs(None)
    planned = list(dict.fromkeys("".join(text.split())))
    load_glyphs(source, "".join(planned))  # those that are not known are said before any is planned
    every = dict.fromkeys([*planned, *(one for one in KNOWN if source.has(one))])
    glyphs = load_glyphs(source, "".join(every))
    rings = {text: list(_rings(glyph)) for text, glyph in glyphs.items()}
    plans = {one: _plan(one, source, brush, em_mm) if one in planned else [] for one in every}
    words: dict[str, Any] = {
        "brush": brush,
        "em_mm": em_mm,
        "licence": source.licence,
        "characters": {
            one: {"rings": list(map(len, rings[one])), "plan": list(map(len, plans[one]))}
            for one in every
        },
    }
    outlines = [ring for one in every for ring in rings[one]]
    samples = [stroke for one in every for stroke in plans[one]]
    return words, {
        "outlines": np.concatenate([np.empty((0, 2), np.int16), *outlines]),
        "samples": np.concatenate([np.empty((0, 9), np.float32), *samples]),
    }


def _rings(glyph: Glyph) -> Iterable[AnyArray]:
    import shapely

    for stroke in glyph.strokes:
        for ring in (stroke.outline, *stroke.holes):
            line = shapely.LinearRing(ring - np.array(glyph.middle)).simplify(_STRAY)
            yield np.rint(shapely.get_coordinates(line)[:-1]).astype(np.int16)


def _plan(text: str, source: GlyphSource, brush: str, em_mm: float) -> list[AnyArray]:
    """A character's strokes on flat paper, (M, 9) each."""
    side = _AROUND * em_mm
    paper = load_mesh(f"sheet:{side:g}x{side:g}")
    settings = WritingSettings(load_brush(brush), em_mm)
    written = write_text(paper, text, source, settings, Layout(point=(0.0, 0.0, 0.0))).recording
    assert written.pressure is not None, "a plan says how firmly the brush is pressed"
    down = np.concatenate([[False], written.pressure > 0.0, [False]])
    ends = np.flatnonzero(down[1:] != down[:-1]).reshape(-1, 2)
    strokes = []
    for first, last in ends:
        kept = np.unique([*range(first, last, _EVERY), last - 1])
        seconds = (written.time_ns[kept] - written.time_ns[first]) * 1e-9
        rows = [seconds, written.position[kept], written.orientation[kept], written.pressure[kept]]
        strokes.append(np.column_stack(rows).astype(np.float32))
    return strokes

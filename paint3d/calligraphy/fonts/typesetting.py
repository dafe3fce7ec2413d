"""A text in a font, set as a page: lines with baseline and advances, or columns."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from paint3d.calligraphy.fonts.bodies import WHOLE, Body, bodies_of, text_of
from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.fonts.line_breaks import break_line
from paint3d.calligraphy.fonts.shaping import DIRECTIONS, Shaper, Style
from paint3d.calligraphy.glyph_sources import GlyphSource
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph, GlyphStroke
from paint3d.calligraphy.page.ink import as_multipolygon, polygons_of
from paint3d.calligraphy.page.page import Page, Piece, bounds_of
from paint3d.calligraphy.shapes.arabic_ductus import PlacedLetter, body_strokes, form_of
from paint3d.calligraphy.shapes.bare_ends import with_stubs
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.shapes.ductus import known_strokes
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import MultiPolygon

__all__ = ["FontText", "is_written_down", "set_text"]

_COLUMN_SCRIPTS = ("CJK UNIFIED", "CJK COMPATIBILITY", "HIRAGANA", "KATAKANA", "BOPOMOFO")
_COLUMN_PITCH, _LEAST_PITCH = 1.15, 1.0  # ems from column to column; of lines at least
_TAUGHT = WHOLE | {"Latn", "Grek", "Cyrl", "Zyyy"}  # scripts whose strokes may be known
_MIRROR = np.array([-1.0, 1.0])
_BOLD = 0.12 * EM_UNITS  # width of strokes whose corners a brush does not fill by the way
_ROUNDING = 3  # decimals of glyph units by which bodies are known again


def is_written_down(text: str) -> bool:
    """Whether a text is one that is written in columns: by its first letter."""
    for character in text:
        if unicodedata.category(character).startswith("L"):
            return unicodedata.name(character, "").startswith(_COLUMN_SCRIPTS)
    return False


@dataclass(frozen=True, eq=False)
class FontText:
    """A text that is set in a font, in the room there is.

    Parameters
    ----------
    text : str
        Line breaks start a new line or column.
    font : FontFile
    style : Style
    templates : GlyphSource, optional
        Characters whose strokes are known: order and direction are theirs, the shape the font's.

    Raises
    ------
    InputError
        If the text is empty, the font lacks characters, or the direction is not known.
    """

    text: str
    font: FontFile
    style: Style = field(default_factory=Style)
    templates: GlyphSource | None = None
    _glyphs: dict[object, Glyph] = field(default_factory=dict, init=False, repr=False)
    _pages: dict[tuple[str, ...], Page] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        if self.style.direction not in (None, *DIRECTIONS):
            known = ", ".join(DIRECTIONS)
            raise InputError(f"direction is {self.style.direction!r}; expected one of {known}")
        if not self.text.strip():
            raise InputError("the text is empty; expected at least one character")
        self.font.check_has(unicodedata.normalize("NFC", self.text))

    @property
    def runs_down(self) -> bool:
        """Whether its lines are columns."""
        return self.style.direction == "ttb"

    def compose(self, room: float) -> Page:
        """The page with lines no longer than `room`, glyph units, where they can be broken."""
        shaper = Shaper(self.font, self.style)
        lines = [line for part in self._paragraphs() for line in _broken(part, shaper, room)]
        key = tuple(lines)
        if key not in self._pages:
            self._pages[key] = self._set(lines, shaper)
        return self._pages[key]

    def _paragraphs(self) -> list[str]:
        text = unicodedata.normalize("NFC", self.text).replace("\t", " ")
        lines = [line.strip() for line in text.splitlines()]
        return "\n".join(lines).strip("\n").split("\n")

    def _set(self, lines: Sequence[str], shaper: Shaper) -> Page:
        """Lines below each other, or columns beside each other from the right."""
        ascender, descender, gap = self.font.extents
        pitch = max(ascender - descender + gap, _LEAST_PITCH * EM_UNITS)
        pieces: list[Piece] = []
        for k, line in enumerate(lines):
            if not line:
                continue
            shaped = shaper.shape(line)
            length = sum(one.advance for one in shaped)
            if shaper.is_vertical:
                at, middle = np.array([-_COLUMN_PITCH * EM_UNITS * k, 0.0]), 0.0
            else:
                start = -length if shaper.is_rtl(line) else 0.0
                at, middle = np.array([start, -pitch * k]), 0.5 * (ascender + descender)
            for body in bodies_of(shaped, self.font):
                pieces.append(self._piece(body, text_of(body.glyphs, shaped, line), at, middle))
        return Page(tuple(pieces), self.font.name, self._licence())

    def _licence(self) -> str:
        if self.templates is None:
            return self.font.licence
        return f"{self.font.licence}. Order of known strokes: {self.templates.name}"

    def _piece(self, body: Body, text: str, at: AnyArray, middle: float) -> Piece:
        """A body as a piece; the middle of its box lies on the middle of the line."""
        first = body.glyphs[0]
        origin = np.array([first.x, first.y])
        key = (text, first.is_rtl, middle, *_placement(body))
        if key not in self._glyphs:
            self._glyphs[key] = self._glyph(body, text, middle)
        glyph = self._glyphs[key]
        x, y = at + origin + np.array(glyph.middle)
        return Piece(glyph, (float(x), float(y)))

    def _glyph(self, body: Body, text: str, middle: float) -> Glyph:
        """The strokes of a body, and its box, from its first glyph's origin."""
        from shapely import transform

        first = body.glyphs[0]
        origin = np.array([first.x, first.y])
        parts = [transform(part, lambda points: points - origin) for part in body.parts]
        forms = self._forms(body, text)
        strokes: list[GlyphStroke] = []
        shapes = [_together(parts)] if forms else parts
        ways = [forms or self._way_through(body, text), *[()] * (len(shapes) - 1)]
        for shape, known in zip(shapes, ways, strict=True):
            strokes += with_stubs(_taken_apart(shape, known, first.is_rtl), _BOLD)
        left, lower, right, upper = bounds_of(part.bounds for part in parts)
        if self.runs_down:
            half = max(-(left + first.x - middle), right + first.x - middle)
            left, right = middle - first.x - half, middle - first.x + half
        else:
            half = max(upper + first.y - middle, middle - lower - first.y)
            lower, upper = middle - first.y - half, middle - first.y + half
        return Glyph(text, tuple(strokes), (left, lower, right, upper))

    def _forms(self, body: Body, text: str) -> tuple[Glyph, ...]:
        """The strokes of a character that is known; none of what is joined of several."""
        single = len(body.glyphs) == 1 and len(text) == 1
        if not single or self.templates is None or body.glyphs[0].script not in _TAUGHT:
            return ()
        return known_strokes(self.templates, text)

    def _way_through(self, body: Body, text: str) -> tuple[Glyph, ...]:
        """The way of the pen through a body of Arabic letters, from its first glyph's origin."""
        first = body.glyphs[0]
        if self.templates is None or first.script != "Arab":
            return ()
        starts = sorted({one.cluster for one in body.glyphs})
        letters = []
        for one in body.glyphs:
            ink = self.font.outline(one.glyph)
            if ink.is_empty or self.font.is_mark(one.glyph):
                continue
            largest = max(polygons_of(ink), key=lambda piece: piece.area)
            at = np.tile([one.x - first.x, one.y - first.y], 2)
            end = min((c for c in starts if c > one.cluster), default=len(text) + starts[0])
            letter = _joining(text, one.cluster - starts[0], end - starts[0])
            letters.append(PlacedLetter(*letter, np.array(largest.bounds) + at))
        way = body_strokes(letters)
        return () if way is None else (way,)


def _joining(text: str, start: int, end: int) -> tuple[str, str]:
    """The letters of a body's text that a glyph stands for, and their form."""
    bare = [
        "".join(c for c in part if not unicodedata.combining(c))
        for part in (text[:start], text[start:end], text[end:])
    ]
    before, letters, after = bare[0][-1:], bare[1], bare[2][:1]
    return letters, form_of(before, letters, after)


def _taken_apart(part: MultiPolygon, forms: Sequence[Glyph], is_rtl: bool) -> list[GlyphStroke]:
    """The strokes of ink; what is written from the right is taken apart as in a mirror."""
    from shapely import transform

    if not is_rtl:
        return decompose(part, template=forms)
    mirrored = transform(part, lambda points: points * _MIRROR)
    turned = [replace(form, strokes=_mirrored(form.strokes)) for form in forms]
    return list(_mirrored(decompose(mirrored, template=turned, runs_on=True)))


def _mirrored(strokes: Sequence[GlyphStroke]) -> tuple[GlyphStroke, ...]:
    return tuple(
        GlyphStroke(
            one.outline * _MIRROR, one.median * _MIRROR, tuple(hole * _MIRROR for hole in one.holes)
        )
        for one in strokes
    )


def _together(parts: Sequence[MultiPolygon]) -> MultiPolygon:
    """A body with its marks: the lines of a known character are those of both."""
    from shapely import unary_union

    return as_multipolygon(unary_union(parts))


def _broken(paragraph: str, shaper: Shaper, room: float) -> list[str]:
    if not paragraph or math.isinf(room):
        return [paragraph]
    return break_line(paragraph, shaper.advances(paragraph), room)


def _placement(body: Body) -> list[tuple[int, float, float]]:
    """The glyphs of a body, and where they stand from the first one."""
    first = body.glyphs[0]
    return [
        (one.glyph, round(one.x - first.x, _ROUNDING), round(one.y - first.y, _ROUNDING))
        for one in body.glyphs
    ]


def set_text(
    text: str, font: FontFile, style: Style, templates: GlyphSource | None, order: str | None
) -> FontText:
    """A text set as it is asked for: in rows or columns, or as its script is written.

    Parameters
    ----------
    text : str
    font : FontFile
    style : Style
    templates : GlyphSource or None
    order : {"columns", "row"} or None
        None: columns for Chinese and Japanese, rows for all others.

    Raises
    ------
    InputError
        If columns are asked for and another direction, too.
    """
    if order == "columns" and style.direction not in (None, "ttb"):
        raise InputError(f"columns do not run {style.direction}; expected a row, or ttb")
    down = order == "columns" or (
        order is None and style.direction is None and is_written_down(text)
    )
    return FontText(text, font, replace(style, direction="ttb") if down else style, templates)

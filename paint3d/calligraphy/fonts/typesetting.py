"""A text in a font, set as a page: lines with baseline and advances, or columns."""

from __future__ import annotations

import math
import unicodedata
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.fonts.shaping import DIRECTIONS, ShapedGlyph, Shaper, Style
from paint3d.calligraphy.glyph_sources import GlyphSource, is_square_letter
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph, GlyphStroke
from paint3d.calligraphy.page.page import Page, Piece, as_multipolygon, bounds_of, polygons_of
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.shapes.ductus import PlacedLetter, body_strokes, form_of, known_strokes
from paint3d.calligraphy.shapes.regions import with_stubs
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = [
    "WHOLE",
    "Body",
    "FontText",
    "bodies_of",
    "break_line",
    "has_words",
    "is_written_down",
    "set_text",
    "text_of",
]

# ---- Pieces of ink -------------------------------------------------------------------------------
# Glyphs of a line as pieces of ink: what hangs together is one body, with the marks it carries.
#
# A letter, a word of a joined script and a syllable are bodies; a dot, an accent or a vowel sign
# that touches none is written after the body it belongs to. Characters of Chinese, Japanese and
# Korean stay whole.


WHOLE = frozenset({"Hani", "Hira", "Kana", "Hang", "Bopo", "Yiii", "Tang", "Nshu"})
"""Scripts whose characters are squares of their own."""


@dataclass(frozen=True, eq=False)
class Body:
    """Connected ink, written in one go.

    Attributes
    ----------
    glyphs : tuple of ShapedGlyph
        That it is made of, as they are read.
    parts : tuple of MultiPolygon
        The body, then its marks; glyph units of the line.
    """

    glyphs: tuple[ShapedGlyph, ...]
    parts: tuple[MultiPolygon, ...]


class _Part(NamedTuple):
    shape: Polygon
    glyph: int  # index in the line
    is_main: bool  # the largest of a glyph that is no mark


def bodies_of(glyphs: Sequence[ShapedGlyph], font: FontFile) -> list[Body]:
    """The bodies of a line in writing order.

    Parameters
    ----------
    glyphs : sequence of ShapedGlyph
        As they are read.
    font : FontFile
    """
    bodies: list[tuple[int, Body]] = []
    parts: list[_Part] = []
    shapes = [_place_glyphs(one, font) for one in glyphs]
    bases = _bases(glyphs, [shape.area for shape in shapes])
    for k, (one, shape) in enumerate(zip(glyphs, shapes, strict=True)):
        if shape.is_empty:
            continue
        if one.script in WHOLE:
            bodies.append((k, Body((one,), (shape,))))
            continue
        pieces = polygons_of(shape)
        largest = max(pieces, key=lambda piece: piece.area)
        is_base = bases[k] == k and not font.is_mark(one.glyph)
        parts += [_Part(piece, k, piece is largest and is_base) for piece in pieces]
    bodies += _join_touching(parts, glyphs, bases)
    return [body for _, body in sorted(bodies, key=lambda one: one[0])]


def text_of(some: Sequence[ShapedGlyph], starts: Sequence[int], line: str) -> str:
    """The characters of a line that some of its glyphs stand for, from the first to the last.

    Parameters
    ----------
    some : sequence of ShapedGlyph
    starts : sequence of int
        Where the clusters of the line begin, rising.
    line : str
    """
    first, last = min(one.cluster for one in some), max(one.cluster for one in some)
    after = bisect_right(starts, last)
    return line[first : starts[after] if after < len(starts) else len(line)]


def _bases(glyphs: Sequence[ShapedGlyph], areas: Sequence[float]) -> list[int]:
    """The largest glyph among those of the same characters, for every glyph."""
    largest: dict[int, int] = {}
    for k, one in enumerate(glyphs):
        if areas[k] > areas[largest.setdefault(one.cluster, k)]:
            largest[one.cluster] = k
    return [largest[one.cluster] for one in glyphs]


def _place_glyphs(one: ShapedGlyph, font: FontFile) -> MultiPolygon:
    from shapely import transform

    at = np.array([one.x, one.y])
    return transform(font.outline(one.glyph), lambda points: points + at)


def _join_touching(
    parts: Sequence[_Part], glyphs: Sequence[ShapedGlyph], bases: Sequence[int]
) -> list[tuple[int, Body]]:
    """Parts that touch as bodies, with the others as their marks; each with its first glyph."""
    groups = _group_touching(parts, bases)
    homes = {part.glyph: group for group in groups for part in group if part.is_main}
    marks: dict[int, list[list[_Part]]] = {}
    bodies = []
    for group in groups:
        home = None if any(part.is_main for part in group) else _body_of_mark(group, homes, bases)
        if home is None:
            bodies.append(group)
        else:
            marks.setdefault(id(home), []).append(group)
    result = []
    for group in bodies:
        carried = _order_marks(marks.get(id(group), []), group, glyphs)
        members = sorted({part.glyph for one in (group, *carried) for part in one})
        shapes = tuple(_union(one) for one in (group, *carried))
        first = min(part.glyph for part in group)
        result.append((first, Body(tuple(glyphs[k] for k in members), shapes)))
    return result


def _order_marks(
    marks: Sequence[list[_Part]], body: Sequence[_Part], glyphs: Sequence[ShapedGlyph]
) -> list[list[_Part]]:
    """Marks letter by letter, of each those nearest to the body first, row by row as one reads."""
    if len(marks) < 2:
        return list(marks)
    middle = _union(body).centroid.y

    def turn(mark: list[_Part]) -> tuple[int, int, float]:
        left, lower, right, upper = bounds_of(part.shape.bounds for part in mark)
        row = round(abs(0.5 * (lower + upper) - middle) / max(upper - lower, 1.0))
        first = min(part.glyph for part in mark)
        return first, row, -right if glyphs[first].is_rtl else left

    return sorted(marks, key=turn)


def _body_of_mark(
    group: Sequence[_Part], homes: dict[int, list[_Part]], bases: Sequence[int]
) -> list[_Part] | None:
    """The body that a mark belongs to: that of its glyph, or of the letter before it."""
    here = bases[min(part.glyph for part in group)]
    return next((homes[k] for k in range(here, -1, -1) if k in homes), None)


def _group_touching(parts: Sequence[_Part], bases: Sequence[int]) -> list[list[_Part]]:
    """Groups of parts whose ink touches, but for marks with letters that they do not belong to.

    A tail may run through the dots of the letter after it, which stay that letter's.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from shapely import STRtree

    if not parts:
        return []
    shapes = [part.shape for part in parts]
    one, two = STRtree(shapes).query(shapes, predicate="intersects")
    is_main = np.array([part.is_main for part in parts])
    base = np.array([bases[part.glyph] for part in parts])
    together = (is_main[one] & is_main[two]) | (base[one] == base[two])
    pairs = coo_array(
        (np.ones(int(together.sum())), (one[together], two[together])), (len(parts),) * 2
    )
    _, numbers = connected_components(pairs, directed=False)
    groups: dict[int, list[_Part]] = {}
    for part, number in zip(parts, numbers.tolist(), strict=True):
        groups.setdefault(number, []).append(part)
    return list(groups.values())


def _union(parts: Sequence[_Part]) -> MultiPolygon:
    from shapely import unary_union

    shapes = [part.shape for part in parts]
    return as_multipolygon(shapes[0] if len(shapes) == 1 else unary_union(shapes))


# ---- Line breaks ---------------------------------------------------------------------------------
# Where a line of text may be broken: at spaces and hyphens, and between ideographs.
#
# Words are kept together. Closing punctuation does not begin a line and opening does not end one.
# Scripts that are written without spaces and need a dictionary, such as Thai, are not broken.


_NOT_FIRST = set(
    "、。，．・：；？！ー」』）］｝〉》〕】〗’”ゝゞ々〻ぁぃぅぇぉっゃゅょァィゥェォッャュョ…‥%‰℃,.:;?!)]}"
)
_NOT_LAST = set("「『（［｛〈《〔【〖‘“([{")
_HYPHENS = set("-‐–—")
_IDEOGRAPHIC_SPACE = "\u3000"


def _may_break_after(text: str, k: int) -> bool:
    """Return whether a line may end after character k of a text, which has more."""
    here, after = text[k], text[k + 1]
    if unicodedata.category(after).startswith("M") or after == "\u200d" or here == "\u2060":
        return False
    if here in (" ", "\t", _IDEOGRAPHIC_SPACE, "\u200b"):
        return after not in (" ", "\t", _IDEOGRAPHIC_SPACE)
    if here in _HYPHENS:
        return after.isalpha()
    if after in _NOT_FIRST or here in _NOT_LAST or after.isspace():
        return False
    return _is_wide(here) or _is_wide(after)


def _is_wide(character: str) -> bool:
    return unicodedata.east_asian_width(character) in ("W", "F")


def break_line(text: str, advances: Sequence[float], length: float) -> list[str]:
    """Break a text into lines no longer than a length, where it can be broken.

    Parameters
    ----------
    text : str
    advances : sequence of float
        Of every character; 0 for all but the first that are drawn as one.
    length : float
        In the unit of the advances.

    Returns
    -------
    list of str
        Without the spaces around the breaks.
    """
    lines, start, end, width, inked_before = [], 0, 0, 0.0, 0.0
    for k, advance in enumerate(advances):
        width += advance
        inked = width if not text[k].isspace() else inked_before
        if inked > length and end > start:
            lines.append(text[start:end].strip())
            start = end
            width = sum(advances[start : k + 1])
            inked = width
        inked_before = inked
        if k + 1 < len(text) and advances[k + 1] > 0.0 and _may_break_after(text, k):
            end = k + 1
    lines.append(text[start:].strip())
    return [line for line in lines if line]


# ---- Setting of text -----------------------------------------------------------------------------


_COLUMN_SCRIPTS = ("CJK UNIFIED", "CJK COMPATIBILITY", "HIRAGANA", "KATAKANA", "BOPOMOFO")
_COLUMN_PITCH, _LEAST_PITCH = 1.15, 1.0  # ems from column to column; of lines at least
_TAUGHT = WHOLE | {"Latn", "Grek", "Cyrl", "Zyyy"}  # scripts whose strokes may be known
_MIRROR = np.array([-1.0, 1.0])
_BOLD = 0.12 * EM_UNITS  # width of strokes whose corners a brush does not fill by the way
_ROUNDING = 3  # decimals of glyph units by which bodies are known again


def is_written_down(text: str) -> bool:
    """Return whether a text is written in columns, by its first letter."""
    for character in text:
        if unicodedata.category(character).startswith("L"):
            return unicodedata.name(character, "").startswith(_COLUMN_SCRIPTS)
    return False


def has_words(text: str) -> bool:
    """Return whether letters of a text are set together as words, as in alphabets."""
    letters = [unicodedata.category(one)[0] in "LM" and not is_square_letter(one) for one in text]
    return any(map(all, pairwise(letters)))


def _words_of(line: str) -> list[int]:
    """The word, from 0, of every character of a line; one that stands in a square is a word."""
    begins = (
        _is_wide(one) or _is_wide(after) or (one.isspace() and not after.isspace())
        for one, after in pairwise(line)
    )
    return list(accumulate(begins, initial=0))


@dataclass(frozen=True, eq=False)
class FontText:
    """A text set in a font, in lines of an available length.

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
            raise InputError(
                "direction is {direction!r}; expected one of {known}",
                direction=self.style.direction,
                known=known,
            )
        if not self.text.strip():
            raise InputError("the text is empty; expected at least one character")
        self.font.check_has(unicodedata.normalize("NFC", self.text))

    @property
    def runs_down(self) -> bool:
        """Return whether its lines are columns."""
        return self.style.direction == "ttb"

    def compose(self, length: float) -> Page:
        """The page with lines no longer than `length`, glyph units, where they can be broken."""
        key = tuple(self._lines(length))
        if key not in self._pages:
            self._pages[key] = self._set_lines(key, Shaper(self.font, self.style))
        return self._pages[key]

    def least_size(self, length: float) -> tuple[float, float]:
        """Least length and height of the page, by advances alone."""
        pitch = _COLUMN_PITCH * EM_UNITS if self.runs_down else self._pitch
        across = pitch * (len(self._lines(length)) - 1)
        return (max(map(sum, self._advances)) if math.isinf(length) else 0.0), across

    def _lines(self, length: float) -> list[str]:
        parts = self._paragraphs()
        if math.isinf(length):
            return parts
        return [
            line
            for part, advances in zip(parts, self._advances, strict=True)
            for line in (break_line(part, advances, length) if part else [part])
        ]

    @cached_property
    def _advances(self) -> list[list[float]]:
        """Of every character of every paragraph."""
        shaper = Shaper(self.font, self.style)
        return [shaper.advances(part) for part in self._paragraphs()]

    @property
    def _pitch(self) -> float:
        """From one line to the next."""
        ascender, descender, gap = self.font.extents
        return max(ascender - descender + gap, _LEAST_PITCH * EM_UNITS)

    def _paragraphs(self) -> list[str]:
        text = unicodedata.normalize("NFC", self.text).replace("\t", " ")
        lines = [line.strip() for line in text.splitlines()]
        return "\n".join(lines).strip("\n").split("\n")

    def _set_lines(self, lines: Sequence[str], shaper: Shaper) -> Page:
        """Lines below each other, or columns beside each other from the right."""
        ascender, descender, _ = self.font.extents
        pitch = self._pitch
        in_words = not shaper.is_vertical and has_words(self.text)
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
            starts, words = sorted({one.cluster for one in shaped}), _words_of(line)
            for body in bodies_of(shaped, self.font):
                piece = self._piece(body, text_of(body.glyphs, starts, line), at, middle)
                if in_words:
                    piece = replace(piece, word=(k, words[body.glyphs[0].cluster]))
                pieces.append(piece)
        licence = self.font.licence
        if self.templates is not None:
            licence = f"{licence}. Order of known strokes: {self.templates.name}"
        return Page(tuple(pieces), self.font.name, licence)

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
        from shapely import transform, unary_union

        first = body.glyphs[0]
        origin = np.array([first.x, first.y])
        parts = [transform(part, lambda points: points - origin) for part in body.parts]
        forms = self._known_strokes(body, text)
        strokes: list[GlyphStroke] = []
        shapes = [as_multipolygon(unary_union(parts))] if forms else parts  # known lines: of both
        paths = [forms or self._pen_path(body, text), *[()] * (len(shapes) - 1)]
        for shape, known in zip(shapes, paths, strict=True):
            strokes += with_stubs(_decompose(shape, known, first.is_rtl), _BOLD)
        left, lower, right, upper = bounds_of(part.bounds for part in parts)
        if self.runs_down:
            half = max(-(left + first.x - middle), right + first.x - middle)
            left, right = middle - first.x - half, middle - first.x + half
        else:
            half = max(upper + first.y - middle, middle - lower - first.y)
            lower, upper = middle - first.y - half, middle - first.y + half
        return Glyph(text, tuple(strokes), (left, lower, right, upper), joined=True)

    def _known_strokes(self, body: Body, text: str) -> tuple[Glyph, ...]:
        """The strokes of a character that is known; none of what is joined of several."""
        single = len(body.glyphs) == 1 and len(text) == 1
        if not single or self.templates is None or body.glyphs[0].script not in _TAUGHT:
            return ()
        return known_strokes(self.templates, text)

    def _pen_path(self, body: Body, text: str) -> tuple[Glyph, ...]:
        """The path of the pen through a body of Arabic letters, from its first glyph's origin."""
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
            letter = _letters_of(text, one.cluster - starts[0], end - starts[0])
            letters.append(PlacedLetter(*letter, np.array(largest.bounds) + at))
        path = body_strokes(letters)
        return () if path is None else (path,)


def _letters_of(text: str, start: int, end: int) -> tuple[str, str]:
    """The letters of a body's text that a glyph stands for, and their form."""
    bare = [
        "".join(c for c in part if not unicodedata.combining(c))
        for part in (text[:start], text[start:end], text[end:])
    ]
    before, letters, after = bare[0][-1:], bare[1], bare[2][:1]
    return letters, form_of(before, letters, after)


def _decompose(part: MultiPolygon, forms: Sequence[Glyph], is_rtl: bool) -> list[GlyphStroke]:
    """The strokes of ink; what is written from the right is taken apart as in a mirror."""
    from shapely import transform

    if not is_rtl:
        return decompose(part, template=forms)
    mirrored = transform(part, lambda points: points * _MIRROR)
    turned = [replace(form, strokes=_mirror(form.strokes)) for form in forms]
    return list(_mirror(decompose(mirrored, template=turned, runs_on=True)))


def _mirror(strokes: Sequence[GlyphStroke]) -> tuple[GlyphStroke, ...]:
    return tuple(one.mapped(lambda points: points * _MIRROR) for one in strokes)


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
    """Set a text in rows or columns as asked, or as its script is written.

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
        raise InputError(
            "columns do not run {direction}; expected a row, or ttb",
            direction=style.direction,
        )
    down = order == "columns" or (
        order is None and style.direction is None and is_written_down(text)
    )
    return FontText(text, font, replace(style, direction="ttb") if down else style, templates)

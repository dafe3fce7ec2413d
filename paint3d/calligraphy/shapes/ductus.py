"""Order and direction of the strokes of letters that no package of characters knows.

KanjiVG has Latin letters, digits and kana; a Greek or Cyrillic letter of the same shape is written
as the Latin one, and the others are listed here as lines from 0 to 1: stems first, then bows, then
bars.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyph_sources import GlyphSource
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.shapes.regions import InkStroke
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import arc_lengths, interpolate, signed_area

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = [
    "JoinedForm",
    "PlacedLetter",
    "body_strokes",
    "form_of",
    "in_writing_order",
    "known_strokes",
    "orient_line",
]

_ALIKE = dict(
    zip(
        "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧοκνυχρАВЕЗКМНОРСТУХІЈЅаеорсухкіјѕ",
        "ABEZHIKMNOPTYXokvuxpABE3KMHOPCTyXIJSaeopcyxkijs",
        strict=True,
    )
)

_LINES = {
    "ΓГг": "0,1 0,0; 0,1 1,1",
    "Δ": ".5,1 0,0; .5,1 1,0; 0,0 1,0",
    "Θθ": ".5,1 .15,.85 0,.5 .15,.15 .5,0 .85,.15 1,.5 .85,.85 .5,1; .2,.5 .8,.5",
    "ΛЛл": ".5,1 0,0; .5,1 1,0",
    "Ξ": "0,1 1,1; .15,.5 .85,.5; 0,0 1,0",
    "ΠПпπ": "0,1 0,0; 0,1 1,1; 1,1 1,0",
    "Σ": "1,1 0,1 .6,.5 0,0 1,0",
    "ΦФф": ".5,1 .5,0; .5,.8 .15,.7 0,.5 .15,.3 .5,.2; .5,.8 .85,.7 1,.5 .85,.3 .5,.2",
    "Ψψ": "0,1 .05,.55 .25,.38 .5,.33 .75,.38 .95,.55 1,1; .5,1 .5,0",
    "Ω": "0,0 .35,0 .35,.1 .1,.35 .05,.65 .2,.9 .5,1 .8,.9 .95,.65 .9,.35 .65,.1 .65,0 1,0",
    "γ": "0,1 .55,.3 .5,0 .4,.1 .5,.35 1,1",
    "λ": "0,1 .2,1 1,0; .5,.6 0,0",
    "τ": "0,1 1,1; .5,1 .5,.1 .75,0",
    "Б": "0,1 0,0; 0,1 .9,1; 0,.55 .7,.55 1,.3 .7,0 0,0",
    "Дд": ".35,1 .3,.5 .15,.2; .35,1 .85,1 .85,.2; 0,0 0,.2 1,.2 1,0",
    "Жж": "0,1 .5,.5; .5,.5 0,0; .5,1 .5,0; 1,1 .5,.5; .5,.5 1,0",
    "Ии": "0,1 0,0; 0,0 1,1; 1,1 1,0",
    "Йй": "0,.8 0,0; 0,0 1,.8; 1,.8 1,0; .3,1 .5,.92 .7,1",
    "б": "1,1 .4,.9 .1,.6 0,.3 .2,0 .7,0 1,.25 .8,.5 .3,.55 .05,.4",
    "в": "0,1 0,0; 0,1 .7,1 .9,.75 .7,.53 0,.53; .7,.53 1,.3 .7,0 0,0",
    "Цц": "0,1 0,.2; .8,1 .8,.2; 0,.2 1,.2 1,0",
    "Чч": "0,1 0,.6 .3,.4 1,.45; 1,1 1,0",
    "Шш": "0,1 0,0; .5,1 .5,0; 1,1 1,0; 0,0 1,0",
    "Щщ": "0,1 0,.2; .45,1 .45,.2; .9,1 .9,.2; 0,.2 1,.2 1,0",
    "Ъъ": "0,1 .3,1 .3,0; .3,.55 .75,.55 1,.3 .75,0 .3,0",
    "Ыы": "0,1 0,0; 0,.55 .4,.55 .6,.3 .4,0 0,0; 1,1 1,0",
    "Ьь": "0,1 0,0; 0,.55 .7,.55 1,.3 .7,0 0,0",
    "Ээ": "0,.85 .4,1 .85,.8 1,.5 .85,.2 .4,0 0,.15; .35,.5 1,.5",
    "Юю": "0,1 0,0; 0,.5 .35,.5; .68,1 .43,.8 .35,.5 .43,.2 .68,0 .92,.2 1,.5 .92,.8 .68,1",
    "Яя": "1,1 1,0; 1,1 .3,1 .05,.75 .3,.5 1,.5; .5,.5 0,0",
    "з": "0,.9 .5,1 .9,.75 .4,.53; .4,.53 1,.27 .5,0 0,.12",
    "н": "0,1 0,0; 1,1 1,0; 0,.5 1,.5",
    "м": "0,1 0,0; 0,1 .5,.2; 1,1 .5,.2; 1,1 1,0",
    "т": "0,1 1,1; .5,1 .5,0",
}  # fmt: skip
_OWN = {text: lines for letters, lines in _LINES.items() for text in letters}

_ALSO = (
    ("a", ".95,.75 .6,1 .25,.95 0,.6 .05,.2 .35,0 .7,.2 .9,.5; 1,1 .93,.4 1,0"),
    ("E", ".95,.85 .6,1 .25,.92 .15,.7 .45,.53 .65,.52 .35,.5 .05,.32 .1,.08 .45,0 1,.18"),
    ("g", ".9,.8 .6,1 .25,.95 0,.75 .1,.5 .45,.42 .8,.55 .95,.75; 1,1 .9,.5 .75,.15 .4,0 0,.1"),
    ("k", "0,1 0,0 .15,.35 .5,.62 .85,.65 .85,.5 .5,.38 .2,.35; .4,.36 .7,.05 1,0"),
)
"""The a and g with one storey, the round E, and the k of running hands, whose arm is a loop."""

_JOINED = (
    ("a", ".72,.75 .5,1 .2,.95 0,.5 .05,.15 .25,0 .5,.15 .7,.5; .78,.95 .72,.3 .75,.05 .82,0 "
     "1,.35"),
    ("b", ".2,.48 .5,.72 .75,.95 .65,1 .5,.85 .2,.4 .1,.1 .3,0 .55,.1 .65,.28 .48,.42 .4,.25 "
     ".6,.15 .8,.18 1,.32"),
    ("f", ".4,.62 .75,.82 1,1 .85,.98 .6,.8 .3,.4 .03,0 .2,.03 .45,.3 .4,.5 .5,.38 .7,.32 1,.45"),
    ("k", ".22,.5 .5,.75 .65,.95 .55,.98 .2,.45 .03,.05 .12,.2 .4,.42 .65,.42 .7,.3 .42,.2 .5,.05 "
     ".7,.03 1,.25"),
    ("r", "0,.3 .2,.7 .3,1 .27,.82 .45,.68 .5,.45 .37,.15 .52,0 .8,.12 1,.42"),
    ("v", ".1,.8 .08,.3 .15,.03 .35,.15 .6,.55 .7,1; .62,.6 .78,.28 1,.5"),
    ("w", ".15,.9 .03,.4 .08,.08 .25,.25 .45,.95; .45,.95 .38,.4 .42,.05 .6,.2 .75,.6 .8,1; "
     ".75,.62 .87,.35 1,.55"),
)  # fmt: skip
"""Letters of joined hands as they are taught: stems are loops, and all are led out to the right."""


class JoinedForm(Glyph):
    """A letter as joined hands write it: a path so long and loose that it can be bent to much.

    It counts where it lies nearer, by a quarter, than the letters that are set apart.
    """


def known_strokes(source: GlyphSource, text: str) -> tuple[Glyph, ...]:
    """The strokes of a character in each of its forms: a source's, or of a letter alike, or listed.

    Parameters
    ----------
    source : GlyphSource
    text : str
        A single character.

    Returns
    -------
    tuple of Glyph
        None where it is not known. Their lines count, in any frame; listed ones have no outlines.
    """
    forms: list[Glyph] = []
    for known in (text, _ALIKE.get(text, "")):
        if known and source.has(known):
            forms.append(source.load(known))
            break
    if not forms and text in _OWN:
        forms.append(Glyph(text, _parse_strokes(_OWN[text])))
    alike = _ALIKE.get(text, text)
    forms += [Glyph(text, _parse_strokes(lines)) for letter, lines in _ALSO if letter == alike]
    forms += [
        JoinedForm(text, _parse_strokes(lines)) for letter, lines in _JOINED if letter == alike
    ]
    return tuple(forms)


def _parse_strokes(lines: str) -> tuple[GlyphStroke, ...]:
    """The strokes of lines that are written as points "x,y x,y; x,y x,y"."""
    return tuple(_without_outline(_parse_line(line)) for line in lines.split(";"))


def _parse_line(line: str) -> NDArray[np.float64]:
    """The points (N, 2) that are written as "x,y x,y"."""
    return np.array([[float(x) for x in point.split(",")] for point in line.split()])


def _without_outline(line: NDArray[np.float64]) -> GlyphStroke:
    return GlyphStroke(np.empty((0, 2)), line)


# ---- Arabic letters ------------------------------------------------------------------------------
# How the letters of the Arabic script are written: the way of the pen through each of their forms.
#
# Letters run from right to left; heads of waw, feh and qaf, meem's and sad's loops go clockwise; a
# stem that is joined at its foot (the final alef) goes up, others go down; what is added to a body
# (tah's stem, kaf's bar) comes after it, dots come last. These are the ways of M. Sakkal, *Arabic
# alphabet chart in naskh style* (sakkal.com). Forms that hands write differently (the joined hah,
# meem, heh) are not listed: their way follows from the shape alone.
#
# Lines go from 0 to 1 in the box of the letter's body, without its dots: the way from its entry on
# the right to its exit on the left, then what is added.


_ALONE, _FIRST, _MIDDLE, _LAST = "alone", "first", "middle", "last"

_TOOTH = {_FIRST: "1,1 .9,.2 .5,0 0,0", _MIDDLE: "1,0 .6,.05 .5,1 .4,.05 0,0"}
_FORMS: dict[str, dict[str, str]] = {
    "اأإآٱ": {_ALONE: ".5,1 .5,0", _LAST: "1,0 .4,.05 .2,.2 .15,1"},
    "بتثپٹ": {
        **_TOOTH,
        _ALONE: "1,1 .97,.35 .8,.05 .4,0 .1,.2 0,.9",
        _LAST: "1,.1 .5,0 .1,.2 0,1",
    },
    "ن": {
        **_TOOTH,
        _ALONE: "1,1 .95,.4 .6,0 .2,.1 0,.6",
        _LAST: "1,.95 .85,.6 .6,0 .2,.1 0,.6",
    },
    "يىئی": {
        **_TOOTH,
        _ALONE: "1,.85 .85,1 .65,.8 .8,.55 1,.4 .8,.1 .4,0 .1,.15 0,.6",
        _LAST: "1,1 .75,.85 .8,.6 1,.4 .7,.02 .3,0 0,.5",
    },
    "جحخچ": {
        _ALONE: "0,.85 .3,1 1,.85 .3,.65 .05,.4 .1,.1 .5,0 1,.15",
        _FIRST: ".1,.85 .45,.95 1,.35 .5,.1 0,0",
    },
    "دذڈ": {
        _ALONE: ".3,1 .8,.7 1,.25 .6,0 0,.05",
        _LAST: "1,.2 .7,.35 .35,1 .75,.3 .5,0 0,.05",
    },
    "رزژ": {_ALONE: ".9,1 1,.5 .6,.1 0,0", _LAST: "1,.95 .85,.6 .5,.1 0,0"},
    "وؤ": {
        _ALONE: ".75,.55 .3,.55 .15,.8 .5,1 .9,.85 1,.5 .6,.1 0,0",
        _LAST: "1,.5 .3,.5 .15,.8 .5,1 .85,.85 .9,.5 .6,.1 0,0",
    },
    "ف": {
        _ALONE: ".95,.5 .75,.5 .7,.8 .85,1 1,.8 1,.3 .8,.05 .3,0 0,.35",
        _FIRST: ".9,.35 .3,.4 .2,.8 .6,1 .95,.8 .9,.2 .5,0 0,0",
        _MIDDLE: "1,0 .3,.1 .1,.6 .5,1 .9,.6 .7,.05 0,0",
        _LAST: "1,.2 .8,.25 .7,.6 .85,1 .97,.7 .9,.15 .3,0 0,.35",
    },
    "ق": {
        _ALONE: ".95,.6 .65,.6 .6,.9 .8,1 1,.85 .95,.3 .6,0 .2,.05 0,.5",
        _FIRST: ".9,.35 .3,.4 .2,.8 .6,1 .95,.8 .9,.2 .5,0 0,0",
        _MIDDLE: "1,0 .3,.1 .1,.6 .5,1 .9,.6 .7,.05 0,0",
        _LAST: "1,.6 .65,.6 .55,.85 .75,1 .92,.85 .85,.3 .5,0 .15,.05 0,.5",
    },
    "صض": {
        _ALONE: ".52,.5 .7,.9 .9,1 1,.8 .85,.5 .5,.45 .5,.6 .48,.3 .35,.02 .1,.05 0,.5",
        _FIRST: ".3,.1 .5,.8 .8,1 1,.6 .8,.05 .25,0 .2,.5 .2,.1 0,0",
        _MIDDLE: "1,0 .3,.05 .5,.8 .8,1 .95,.6 .75,.05 .25,0 .2,.5 .2,.1 0,0",
        _LAST: "1,.45 .52,.48 .65,.9 .85,1 .95,.8 .8,.5 .48,.45 .48,.6 .46,.3 .35,.02 .1,.05 0,.5",
    },
    "طظ": {
        _ALONE: ".2,.05 .45,.45 .8,.5 1,.3 .8,.05 .4,0 0,.02; .25,1 .25,.05",
        _FIRST: ".25,.05 .5,.45 .8,.5 1,.3 .8,.05 .4,0 0,0; .3,1 .3,.05",
        _MIDDLE: "1,0 .3,.05 .5,.45 .8,.5 .95,.3 .8,.05 .4,0 0,0; .3,1 .3,.05",
        _LAST: "1,0 .25,.05 .45,.45 .8,.5 .95,.3 .8,.05 .4,0 0,.02; .25,1 .25,.05",
    },
    "عغ": {
        _ALONE: ".85,.9 .55,1 .3,.85 .45,.68 .9,.65 .3,.5 0,.25 .3,0 1,.1",
        _FIRST: ".95,.85 .6,1 .25,.65 .5,.3 .95,.25 .5,.05 0,0",
        _MIDDLE: "1,0 .55,.3 .1,.9 .9,.9 .45,.3 0,0",
        _LAST: "1,.6 .6,.65 .2,.95 .8,1 .5,.65 .1,.35 .1,.1 .5,0 1,.05",
    },
    "كکگ": {
        _ALONE: ".95,1 1,.2 .8,.02 .3,0 0,.25",
        _FIRST: ".3,.65 .85,.2 .7,0 0,0; 1,1 .3,.65",
        _LAST: "1,.05 .9,.1 .85,1 .88,.1 .6,0 .2,.02 0,.25",
    },
    "ل": {
        _ALONE: ".95,1 .95,.4 .6,0 .2,.05 0,.35",
        _FIRST: ".8,1 .8,.15 .5,0 0,0",
        _MIDDLE: "1,0 .55,.02 .5,1 .45,.02 0,0",
        _LAST: "1,.3 .92,.35 .9,1 .88,.4 .6,0 .2,.05 0,.35",
    },
    "م": {
        _ALONE: ".35,.75 .5,.95 .8,1 1,.8 .8,.6 .35,.65 .1,.5 0,0",
        _FIRST: ".1,.3 .3,.9 .7,1 1,.6 .8,.15 .5,0 0,.1",
    },
    "سش": {
        _ALONE: "1,.9 .98,.6 .85,.55 .82,.8 .8,.6 .65,.55 .62,.8 .6,.5 .45,.05 .15,0 0,.5",
        _FIRST: "1,.9 .95,.1 .75,.05 .65,.8 .55,.05 .4,.1 .3,.9 .2,.05 0,0",
        _MIDDLE: "1,0 .9,.9 .8,.05 .65,.8 .55,.05 .4,.1 .3,.9 .2,.05 0,0",
        _LAST: "1,.5 .95,.85 .9,.5 .8,.5 .77,.8 .74,.5 .63,.5 .6,.8 .57,.4 .45,.05 .15,0 0,.5",
    },
}  # fmt: skip
_BY_LETTER = {letter: forms for letters, forms in _FORMS.items() for letter in letters}
_ENDS = frozenset("اأإآٱدذڈرزژوؤةىء")  # letters that never join the one that follows
_APART = "ء"  # nor does this the one before it


class PlacedLetter(NamedTuple):
    """A letter of a body.

    Attributes
    ----------
    character : str
        Several, where one glyph stands for them.
    form : str
        See `form_of`.
    box : (4,) float64
        Left, lower, right and upper side of its ink without dots.
    """

    character: str
    form: str
    box: NDArray[np.float64]


def form_of(before: str, character: str, after: str) -> str:
    """Position of a letter: "alone", or "first", in the "middle" or "last" of joined ones.

    Parameters
    ----------
    before, character, after : str
        A letter and its neighbours without marks; "" where there is none.
    """
    joined = bool(before) and before not in _ENDS and character != _APART
    goes_on = bool(after) and character[-1:] not in _ENDS and after != _APART
    if joined:
        return _MIDDLE if goes_on else _LAST
    return _FIRST if goes_on else _ALONE


def body_strokes(letters: Sequence[PlacedLetter]) -> Glyph | None:
    """The path of the pen through a body of joined letters, as they are read.

    Returns
    -------
    Glyph or None
        A stroke through all letters, then what is added to them, in the frame of their boxes;
        a letter that is not listed is gone through straight. None where none is listed.
    """
    path: list[NDArray[np.float64]] = []
    added: list[NDArray[np.float64]] = []
    is_listed = False
    for one in letters:
        listed = _BY_LETTER.get(one.character, {}).get(one.form)
        is_listed = is_listed or listed is not None
        low, size = one.box[:2], one.box[2:] - one.box[:2]
        lines = [low + _parse_line(p) * size for p in (listed or "1,.2 0,.2").split(";")]
        path.append(lines[0])
        added += lines[1:]
    if not is_listed:
        return None
    text = "".join(one.character for one in letters)
    lines = [np.concatenate(path), *added]
    return Glyph(text, tuple(map(_without_outline, lines)))


# ---- Unknown characters --------------------------------------------------------------------------
# Order and direction of strokes where nothing is known of the character.
#
# Strokes are drawn to the right and downwards, and out to their point, since a brush is set down
# and lifted off: that distinguishes a rising stroke from one that falls to the left. What stands
# apart is written from the left to the right where it stands side by side, else from the top
# downwards. A closed stroke begins at its top. Who writes from the right mirrors the shape before,
# and the strokes after; there letters run on along the line, joined, and what begins farther along
# it is written later, however high.


_EASY = math.radians(-55.0)  # the way that a brush is drawn most easily
_FIRST_PART = 0.6  # of a stroke: hooks come last
_PART_WEIGHTS = (0.6, 0.4)  # of how the first part and the whole count
_POINTED = 1.6  # how much a taper to a third counts beside that: what is easiest counts 2
_NEAR_ENDS = (0.1, 0.2, 0.3)  # of a stroke from either end: where its taper is looked at
_GAP = 0.25  # of a stroke's mean width that two parts may reach into each other
_LEVEL = 1.5  # times as wide as high: a level stroke
_SLOPE = 0.35  # how much farther to the left counts as higher
_RUNNING = 4.0  # the same where letters run on
_WHOLE = 0.05  # that, by all of the stroke
_FIRST_STROKE = 0.06  # of the height, that level strokes are written before others


def orient_line(line: AnyArray, region: Polygon | None = None) -> NDArray[np.float64]:
    """A line (N, 2) in the direction that it is written in, by its stroke's taper, too, if given.

    What is left over of a known letter is judged by its line alone: it has no taper of its own.
    """
    if np.array_equal(line[0], line[-1]):
        return line if signed_area(line[:-1]) > 0.0 else line[::-1]  # leftwards first
    easier = _ease(line) - _ease(line[::-1])
    if region is not None:
        easier += _POINTED * _taper(line, region)
    return line if easier >= 0.0 else line[::-1]


def _taper(line: AnyArray, region: Polygon) -> float:
    """Logarithm of how much wider a stroke's first part is than its last, -1 to 1."""
    import shapely

    along = arc_lengths(line)
    at = along[-1] * np.array([_NEAR_ENDS, np.subtract(1.0, _NEAR_ENDS)])
    points = interpolate(at.ravel(), along, line)
    away = shapely.distance(shapely.points(points), region.boundary)
    first, last = away.reshape(2, -1).sum(axis=1)
    if not (first > 0.0 and last > 0.0):  # a line outside of its region, which has none
        return 0.0
    return float(np.clip(math.log(first / last), -1.0, 1.0))


def _ease(line: AnyArray) -> float:
    """Ease with which a line is drawn."""
    at = round(_FIRST_PART * (len(line) - 1)) or 1
    total = 0.0
    for end, weight in zip((line[at], line[-1]), _PART_WEIGHTS, strict=True):
        step = end - line[0]
        if step.any():
            total += weight * math.cos(math.atan2(step[1], step[0]) - _EASY)
    return total


def in_writing_order(pieces: Sequence[InkStroke], *, runs_on: bool = False) -> list[InkStroke]:
    """Strokes in the order that they are written in, each in its direction.

    Parameters
    ----------
    pieces : sequence of Piece
    runs_on : bool
        Whether they are letters that are joined along a line, as in Arabic.
    """
    turned = [InkStroke(orient_line(piece.line, piece.region), piece.region) for piece in pieces]
    boxes = np.array([piece.region.bounds for piece in turned])
    areas = sum(piece.region.area for piece in turned)
    gap = _GAP * 2.0 * areas / sum(piece.region.length for piece in turned)
    height = float(boxes[:, 3].max() - boxes[:, 1].min())

    slope, first = (_RUNNING, 0.0) if runs_on else (_SLOPE, _FIRST_STROKE * height)

    def key(k: int) -> float:
        line = turned[k].line
        early = first if _is_level(line) else 0.0
        aside = slope * line[0, 0] + _WHOLE * line[:, 0].mean()
        return float(aside - line[0, 1]) - early

    order = _divide_by_gaps(list(range(len(turned))), boxes, gap, key)
    return [turned[k] for k in _order_crossings(order, turned)]


def _order_crossings(order: list[int], pieces: Sequence[InkStroke]) -> list[int]:
    """Put level strokes before the upright ones that they cross."""
    import shapely

    lines = [shapely.LineString(piece.line) for piece in pieces]
    done: list[int] = []
    for k in order:
        at = len(done)
        if _is_level(pieces[k].line):
            for j in range(len(done) - 1, -1, -1):
                if not _is_level(pieces[done[j]].line) and lines[k].crosses(lines[done[j]]):
                    at = j
        done.insert(at, k)
    return done


def _is_level(line: AnyArray) -> bool:
    wide, high = np.abs(line[-1] - line[0])
    return bool(wide > _LEVEL * high)


def _divide_by_gaps(
    here: list[int], boxes: AnyArray, gap: float, key: Callable[[int], float]
) -> list[int]:
    """Divide strokes by gaps between columns or rows, and order what has none by a key."""
    if len(here) == 1:
        return here
    columns = _group_by_extent(here, boxes[:, 0], boxes[:, 2], gap)
    rows = _group_by_extent(here, -boxes[:, 3], -boxes[:, 1], gap)
    best = columns if len(columns) >= len(rows) else rows
    if len(best) == 1:
        return sorted(here, key=key)
    return [k for group in best for k in _divide_by_gaps(group, boxes, gap, key)]


def _group_by_extent(here: list[int], low: AnyArray, high: AnyArray, gap: float) -> list[list[int]]:
    """Strokes whose extents hang together, from the lowest on."""
    ordered = sorted(here, key=lambda k: float(low[k]))
    groups, reach = [[ordered[0]]], float(high[ordered[0]])
    for k in ordered[1:]:
        if low[k] > reach - gap:
            groups.append([])
        groups[-1].append(k)
        reach = max(reach, float(high[k]))
    return groups

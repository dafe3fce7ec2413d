"""The face of a seal: what is cut into a stone, as rings in mm.

Up to four characters stand in columns from the right, each drawn out until it fills its cell, as
in seals. Where their strokes are known as lines, these are cut as lines of one width ("iron wire");
in a font they have its shapes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.fonts.shaping import Shaper, Style
from paint3d.calligraphy.fonts.typesetting import is_written_down
from paint3d.calligraphy.glyph_sources import GlyphSource, load_glyphs
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph
from paint3d.calligraphy.page.page import as_multipolygon
from paint3d.core.arrays import AnyArray, as_number
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import Geometry, MultiPolygon

__all__ = [
    "LARGEST_MM",
    "MOST_CHARACTERS",
    "SHAPES",
    "SMALLEST_MM",
    "STYLES",
    "Seal",
    "cut_drawing",
    "cut_known",
    "cut_seal",
]

STYLES = ("zhuwen", "baiwen")
"""Red lines in a frame, cut in relief; or white lines on red, cut into the stone."""
SHAPES = ("square", "upright", "level")
"""Of the stone: as high as wide; a column of square characters; a row of them, from the right."""
SMALLEST_MM, LARGEST_MM = 4.0, 300.0
MOST_CHARACTERS = 4
_COLUMNS = {1: (1,), 2: (1, 1), 3: (1, 2), 4: (2, 2)}  # characters of each column, from the right
_FRAME, _ROUNDING = 0.045, 0.05  # of the shorter side: width of the frame, its corners' radius
_MARGIN = {"zhuwen": 0.085, "baiwen": 0.075}  # of the shorter side, to what is written
_GAP = 0.085  # of the shorter side, from cell to cell
_LINE = {"zhuwen": 0.15, "baiwen": 0.165}  # of a cell's mean side, over the root of its strokes
_WIDEST, _FINEST = 0.105, 0.024  # of a cell's mean side: lines
_DRAWN_OUT = 2.6  # how much more a character may be drawn out one way than the other
_LEAST_EXTENT = 0.45  # ems: what is flatter or narrower is not drawn out further
_LONGEST = 4.0  # proportions of a stone
_SIMPLER = 5e-4  # of the shorter side, that a corner may be cut off by
_DECIMALS = 3


@dataclass(frozen=True, eq=False)
class Seal:
    """Face of a stone: what of it takes paste.

    Attributes
    ----------
    text : str
        What it says.
    style : {"zhuwen", "baiwen"}
    width_mm, height_mm : float
    rings : tuple of (N, 2) float64
        mm from the middle of the stone, y upwards; paste is where an odd number goes around.
    line_mm : float
        Width of its lines, roughly.
    licence : str
        Whose shapes they are.
    """

    text: str
    style: str
    width_mm: float
    height_mm: float
    rings: tuple[NDArray[np.float64], ...]
    line_mm: float
    licence: str


def cut_known(
    text: str, source: GlyphSource, style: str, size_mm: float, shape: str = "square"
) -> Seal:
    """A seal of characters whose strokes are known, cut as lines of one width.

    Parameters
    ----------
    text : str
        One to four characters; white space is passed over.
    source : GlyphSource
    style : {"zhuwen", "baiwen"}
    size_mm : float
        Longer side of the stone, 4 to 300 mm.
    shape : {"square", "upright", "level"}

    Raises
    ------
    InputError
        If there are no or too many characters, or the source lacks one.
    """
    _check_options(style, size_mm, shape)
    characters = _split_characters(text)
    glyphs = load_glyphs(source, "".join(characters))
    cells, sides = _lay_out_cells(len(characters), style, shape)
    shapes = [
        _draw_lines(glyphs[one], cell, style) for one, cell in zip(characters, cells, strict=True)
    ]
    return _cut_stone(text, style, size_mm, sides, shapes, source.licence)


def _cut_font(text: str, font: FontFile, style: str, size_mm: float, shape: str = "square") -> Seal:
    """A seal in the shapes of a font.

    Up to four characters of a script that runs in columns stand as in seals; any other text is one
    line, and the stone as long as that asks for.

    Parameters
    ----------
    text : str
    font : FontFile
    style, size_mm, shape
        As for `cut_known`; the shape is that of up to four characters.

    Raises
    ------
    InputError
        If the text is empty, too long, or has characters that the font lacks.
    """
    _check_options(style, size_mm, shape)
    font.check_has(text)
    words = "".join(text.split())
    if is_written_down(text) or len(words) == 1:
        characters = _split_characters(text)
        inks = [_set_line(one, font) for one in characters]
        cells, sides = _lay_out_cells(len(characters), style, shape)
        shapes = [_stretch_into(ink, cell) for ink, cell in zip(inks, cells, strict=True)]
        return _cut_stone(text, style, size_mm, sides, shapes, font.licence)
    return _cut_whole(text.strip(), _set_line(text.strip(), font), style, size_mm, font.licence)


def cut_drawing(name: str, shape: MultiPolygon, style: str, size_mm: float) -> Seal:
    """A seal of a drawing, on a stone of the drawing's proportions.

    Parameters
    ----------
    name : str
    shape : shapely.MultiPolygon
        What is ink, y upwards, in any unit.
    style, size_mm
        As for `cut_known`; the size is the stone's longer side.

    Raises
    ------
    InputError
        If the drawing is longer than a stone.
    """
    _check_options(style, size_mm)
    return _cut_whole(name, shape, style, size_mm, f"Drawing: {name}")


# -- what stands on it --------------------------------------------------------------------------


def _check_options(style: str, size_mm: float, shape: str = "square") -> None:
    if shape not in SHAPES:
        raise InputError(
            "shape is {shape!r}; expected one of {shapes}", shape=shape, shapes=", ".join(SHAPES)
        )
    if style not in STYLES:
        raise InputError(
            "style is {style!r}; expected one of {styles}",
            style=style,
            styles=", ".join(STYLES),
        )
    as_number(size_mm, "size (mm)", SMALLEST_MM, LARGEST_MM)


def _split_characters(text: str) -> list[str]:
    characters = [one for one in text if not one.isspace()]
    if not 1 <= len(characters) <= MOST_CHARACTERS:
        raise InputError(
            "a seal of {n} characters; expected 1 to {most}, or a drawing",
            n=len(characters),
            most=MOST_CHARACTERS,
        )
    return characters


def _lay_out_cells(n: int, style: str, shape: str) -> tuple[list[AnyArray], tuple[float, float]]:
    """Left, lower, right and upper side of every character's cell, and the stone's sides.

    The shorter side of the stone is 1.
    """
    columns = {"square": _COLUMNS[n], "upright": (n,), "level": (1,) * n}[shape]
    margin = _MARGIN[style]
    side = 1.0 - 2.0 * margin
    long = side if shape == "square" else n * side + (n - 1) * _GAP
    wide, high = (long, side) if shape == "level" else (side, long)
    width = (wide - _GAP * (len(columns) - 1)) / len(columns)
    cells = []
    for k, count in enumerate(columns):
        right = 0.5 * wide - k * (width + _GAP)
        height = (high - _GAP * (count - 1)) / count
        for row in range(count):
            top = 0.5 * high - row * (height + _GAP)
            cells.append(np.array([right - width, top - height, right, top]))
    return cells, (wide + 2.0 * margin, high + 2.0 * margin)


def _draw_lines(glyph: Glyph, cell: AnyArray, style: str) -> Geometry:
    """A character's lines drawn into a cell, all as wide as their number asks for."""
    from shapely import LineString, MultiLineString

    lines = [stroke.median for stroke in glyph.strokes]
    mean = math.sqrt((cell[2] - cell[0]) * (cell[3] - cell[1]))
    wide = float(np.clip(_LINE[style] * 2.0 / math.sqrt(3.0 + len(lines)), _FINEST, _WIDEST)) * mean
    inner = cell + 0.5 * wide * np.array([1.0, 1.0, -1.0, -1.0])
    points = np.concatenate(lines)
    scale, middle = _fit_box(points.min(axis=0), points.max(axis=0), inner, EM_UNITS)
    at = 0.5 * (inner[:2] + inner[2:])
    drawn = [LineString((line - middle) * scale + at) for line in lines]
    return MultiLineString(drawn).buffer(0.5 * wide, cap_style="round", join_style="round")


def _set_line(text: str, font: FontFile) -> MultiPolygon:
    """The ink of one line of text in a font, glyph units."""
    from shapely import transform, unary_union

    shaped = Shaper(font, Style()).shape(text)
    at = [np.array([one.x, one.y]) for one in shaped]
    parts = [
        transform(font.outline(one.glyph), lambda points, x=x: points + x)
        for one, x in zip(shaped, at, strict=True)
    ]
    ink = as_multipolygon(unary_union([part for part in parts if not part.is_empty]))
    if ink.is_empty:
        raise InputError("the text is empty; expected at least one character")
    return ink


def _stretch_into(ink: MultiPolygon, cell: AnyArray) -> Geometry:
    """A character's ink drawn out until it fills a cell."""
    from shapely import transform

    left, lower, right, upper = ink.bounds
    scale, middle = _fit_box(np.array([left, lower]), np.array([right, upper]), cell, EM_UNITS)
    at = 0.5 * (cell[:2] + cell[2:])
    return transform(ink, lambda points: (points - middle) * scale + at)


def _fit_box(low: AnyArray, high: AnyArray, cell: AnyArray, em: float) -> tuple[AnyArray, AnyArray]:
    """Per-axis scale and centre that fit a box to a cell, with limited distortion."""
    extent = np.maximum(high - low, _LEAST_EXTENT * em)
    scale = (cell[2:] - cell[:2]) / extent
    return np.minimum(scale, _DRAWN_OUT * scale.min()), 0.5 * (low + high)


# -- the stone ----------------------------------------------------------------------------------


def _cut_whole(name: str, ink: Geometry, style: str, size_mm: float, licence: str) -> Seal:
    """A stone of the proportions that one block of ink asks for."""
    from shapely import transform

    left, lower, right, upper = ink.bounds
    extent = np.array([right - left, upper - lower])
    if extent.max() > _LONGEST * extent.min():
        extent = np.maximum(extent, extent.max() / _LONGEST)
    margin = _MARGIN[style]
    scale = (1.0 - 2.0 * margin) / extent.min()  # the shorter side is 1
    sides = scale * extent + 2.0 * margin
    middle = 0.5 * np.array([left + right, lower + upper])
    shape = transform(ink, lambda points: scale * (points - middle))
    return _cut_stone(name, style, size_mm, (float(sides[0]), float(sides[1])), [shape], licence)


def _cut_stone(
    text: str,
    style: str,
    size_mm: float,
    sides: tuple[float, float],
    shapes: Sequence[Geometry],
    licence: str,
) -> Seal:
    """Frame and ground around what is written; the shorter side is 1 until here."""
    from shapely import box, transform, unary_union

    half = 0.5 * np.array(sides)
    stone = box(*(-half + _ROUNDING), *(half - _ROUNDING)).buffer(_ROUNDING)
    written = unary_union(list(shapes))
    if style == "baiwen":
        inked = stone.difference(written)
    else:
        inked = unary_union([stone.difference(stone.buffer(-_FRAME)), written])
    scale = size_mm / max(sides)
    face = transform(inked.simplify(_SIMPLER), lambda points: scale * points)
    rings = [
        np.array(ring.coords)[:-1]
        for part in as_multipolygon(face).geoms
        for ring in (part.exterior, *part.interiors)
    ]
    area, length = written.area, written.length
    return Seal(
        text=text,
        style=style,
        width_mm=scale * sides[0],
        height_mm=scale * sides[1],
        rings=tuple(np.round(ring, _DECIMALS) for ring in rings),
        line_mm=scale * 2.0 * area / max(length, 1e-9),
        licence=licence,
    )


# ---- As it is asked for --------------------------------------------------------------------------
# A seal as it is asked for: characters that are known, a text in a font, or a drawing.


def cut_seal(
    text: str | None = None,
    drawing: Path | str | None = None,
    style: str = "zhuwen",
    size_mm: float = 16.0,
    *,
    shape: str = "square",
    ids: Sequence[str] = (),
    font: Path | str | None = None,
    font_number: int = 0,
    glyphs: Path | str | None = None,
) -> Seal:
    """Cut a seal.

    Parameters
    ----------
    text : str, optional
        What it says; or:
    drawing : path, optional
        An SVG.
    style : {"zhuwen", "baiwen"}
        Red lines in a frame, or white lines on red.
    size_mm : float
        The stone's longer side.
    shape : {"square", "upright", "level"}
        Of the stone of 1 to 4 characters.
    ids : sequence of str
        Of a drawing, only elements and groups of these names.
    font : path or str, optional
        A font's file, or its name on this system; by default characters are cut as lines of one
        width.
    font_number : int
        Which face of a collection.
    glyphs : path, optional
        A folder of `hanzi-writer-data`, whose lines are taken; by default those of `kanjivg`.
        Characters that are lacking are taken from a font of the system.

    Raises
    ------
    InputError
        If neither or both of text and drawing are given, or it cannot be cut.
    """
    if (text is None) == (drawing is None):
        if text is None:
            raise InputError("neither text nor drawing is given; expected one of them")
        raise InputError("both a text and a drawing are given; expected one of them")
    if drawing is not None:
        from paint3d.calligraphy.page.svg_drawing import svg_shape

        return cut_drawing(Path(drawing).name, svg_shape(drawing, ids), style, size_mm)
    assert text is not None
    if font is not None:
        from paint3d.calligraphy.fonts.font_file import open_font

        return _cut_font(text, open_font(font, font_number), style, size_mm, shape)
    from paint3d.calligraphy.fonts.fallback import with_fallback
    from paint3d.calligraphy.glyph_sources import open_glyphs

    return cut_known(text, with_fallback(open_glyphs(glyphs), text), style, size_mm, shape)

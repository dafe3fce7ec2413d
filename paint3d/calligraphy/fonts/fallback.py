"""Characters that a source of glyphs lacks, in the forms of a font of the system.

A font's characters fill more of their em than those of the sources do, and are bolder or finer, so
they are made as large as those of the source that they stand beside, and as bold as those of them
that have as many strokes: the more there are, the finer they are.
"""

from __future__ import annotations

import logging
import math
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.fonts.font_file import (
    FontFile,
    SystemFont,
    draws,
    fonts_with,
    is_handwriting,
    open_font,
)
from paint3d.calligraphy.fonts.mixed import MixedText, squares_of
from paint3d.calligraphy.fonts.shaping import Style
from paint3d.calligraphy.fonts.typesetting import FontText, has_words, set_text
from paint3d.calligraphy.glyph_sources import (
    GlyphSource,
    has_letters,
    is_square_letter,
    missing_glyphs,
    names_of,
)
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph
from paint3d.calligraphy.optional_packages import import_optional
from paint3d.calligraphy.page.page import as_multipolygon
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.errors import GlyphError, InputError

if TYPE_CHECKING:
    from shapely import Geometry, MultiPolygon

__all__ = ["FallbackGlyphs", "FittedFont", "set_whole", "with_fallback"]

_LOG = logging.getLogger(__name__)
_KAI = re.compile(r"楷|kai(ti)?(?![a-z])", re.IGNORECASE)
_SONG = re.compile(r"宋|明|song|sung|sun(?![a-z])|ming|mincho|(?<!sans )serif", re.IGNORECASE)
_PLAIN = {"book", "medium", "normal", "regular", "roman"}
_SIMPLIFIED, _TRADITIONAL = {"cn", "sc"}, {"hk", "tc", "tw"}
_REFERENCE = "永中大天木水田西有年山生前明是思書高道無新筆頭龍"
_FEW = 8  # common characters that say nothing of how width falls with the strokes
_LEAST_GROWTH, _MOST_GROWTH = -0.25, 0.5  # of the width of a font's strokes, on both sides together


@dataclass(frozen=True, eq=False)
class FittedFont:
    """A font scaled and emboldened to match a source's characters.

    Attributes
    ----------
    font : FontFile
    scale : float
    shift : (2,) float64
        Added to what is scaled, glyph units.
    weight : (2,) float64 or None
        Width of strokes, glyph units, of a character whose ink's edge is x sizes long:
        `weight[0] * x + weight[1]`; None leaves them as the font has them.
    """

    font: FontFile
    scale: float
    shift: NDArray[np.float64]
    weight: NDArray[np.float64] | None

    @classmethod
    def beside(cls, source: GlyphSource, font: FontFile) -> FittedFont:
        """Fit a font to a source by characters that both have; unscaled if there are none."""
        pairs = [
            (_measure_ink(_ink_of(source.load(one))), _measure_ink(_ink(font, one)))
            for one in _REFERENCE
            if source.has(one) and ord(one) in font.face.unicodes and not font.is_empty(one)
        ]
        if not pairs:
            return cls(font, 1.0, np.zeros(2), None)
        wanted, own = (np.array(sizes) for sizes in zip(*pairs, strict=True))
        scale = float(np.median(wanted[:, 2] / own[:, 2]))
        shift = np.median(wanted[:, :2] - scale * own[:, :2], axis=0)
        if len(pairs) < _FEW:
            weight = np.array([0.0, np.median(wanted[:, 3])])
        else:
            weight = np.polyfit(own[:, 4], wanted[:, 3], 1)
        return cls(font, scale, shift, weight)

    def load(self, text: str) -> Glyph:
        """A character and the strokes that its shape is made of."""
        return _fit_font(self, text)


@lru_cache(maxsize=256)  # a text is laid anew each time that it is moved
def _fit_font(font: FittedFont, text: str) -> Glyph:
    from shapely import transform

    ink = _ink(font.font, text)
    growth = 0.0
    if font.weight is not None:
        *_, own, edge = _measure_ink(ink)
        width = font.scale * own
        more = float(np.polyval(font.weight, edge)) / width - 1.0
        growth = 0.5 * width * min(max(more, _LEAST_GROWTH), _MOST_GROWTH)
    ink = transform(ink, lambda points: font.scale * points + font.shift)
    grown = as_multipolygon(ink.buffer(growth))
    return Glyph(text, tuple(decompose(ink if grown.is_empty else grown)), joined=True)


@lru_cache(maxsize=32)
def _fit_by_common(source: GlyphSource, font: SystemFont) -> FittedFont:
    return FittedFont.beside(source, open_font(font.path, font.number))


@dataclass(frozen=True, eq=False)
class FallbackGlyphs:
    """A source of glyphs, with fonts for characters that it lacks.

    Attributes
    ----------
    source : GlyphSource
    fonts : dict of str to FittedFont
        By character.
    """

    source: GlyphSource
    fonts: dict[str, FittedFont]

    @property
    def characters(self) -> dict[str, str]:
        """Characters that each font is taken for, by the font's name."""
        taken: dict[str, str] = {}
        for one, fitted in self.fonts.items():
            taken[fitted.font.name] = taken.get(fitted.font.name, "") + one
        return taken

    @property
    def name(self) -> str:
        """The source, and the fonts with their characters."""
        return "; ".join(
            [self.source.name, *(f"{text} from {font}" for font, text in self.characters.items())]
        )

    @property
    def licence(self) -> str:
        """Whose shapes they are and under what licence."""
        fonts = dict.fromkeys(fitted.font.licence for fitted in self.fonts.values())
        return ". ".join([self.source.licence, *fonts])

    def has(self, text: str) -> bool:
        """Return whether a character is known."""
        return text in self.fonts or self.source.has(text)

    def load(self, text: str) -> Glyph:
        """The glyph of a character."""
        return self.fonts[text].load(text) if text in self.fonts else self.source.load(text)


def with_fallback(source: GlyphSource, text: str, *, marks: bool = False) -> GlyphSource:
    """Add fonts of the system to a source for the characters that it lacks.

    A font stands in for missing letters that stand in squares, such as Chinese characters, and with
    `marks` for all else, as it stands in rows: one font for all, or where none has all of them, for
    each the first that has it. Kai faces come first, then Song and Ming faces, then others. Which
    is taken is logged in one line.

    Raises
    ------
    GlyphError
        If the source lacks characters that no font of the system can stand in for.
    InputError
        If the package that reads fonts is not installed, or a font cannot be used.
    """
    missing = missing_glyphs(source, text)
    if not missing:
        return source
    try:
        import_optional("uharfbuzz")
    except InputError as cause:
        raise InputError(
            "{font} has no glyph for {names}, and {cause}",
            font=source.name,
            names=names_of(missing),
            cause=cause,
        ) from None
    fonts = _fonts_for([one for one in missing if marks or is_square_letter(one)])
    lacking = [one for one in missing if one not in fonts]
    if lacking and (whole := _best_font(text)) is not None:
        raise GlyphError(
            "{font} has no glyph for {names}, which fonts have, but set in lines, not in squares: "
            "choose one that has them all, such as {whole}",
            hint="--font FONT; paint3d fonts TEXT lists them",
            font=source.name,
            names=names_of(lacking),
            whole=whole.family,
            characters="".join(lacking),
        )
    if lacking:
        raise GlyphError(
            "{font} has no glyph for {names}, and no font that is installed has one: install one, "
            "such as Noto Serif CJK, or choose another font",
            hint="--font FONT, or the package fonts-noto-cjk",
            font=source.name,
            names=names_of(lacking),
            characters="".join(lacking),
        )
    fitted = {
        font: _fit_by_common(source, font)  # type: ignore[arg-type]  # sources are frozen
        for font in dict.fromkeys(fonts.values())
    }
    result = FallbackGlyphs(source, {one: fitted[font] for one, font in fonts.items()})
    taken = "; ".join(f"{text} is taken from {font}" for font, text in result.characters.items())
    _LOG.warning("%s lacks characters: %s", source.name, taken)
    return result


def set_whole(
    source: GlyphSource, text: str, order: str | None, *, around: bool = False
) -> FontText | MixedText | None:
    """A text that is to be set in a font of the system, and in which is logged in one line.

    It is one with letters of an alphabet, which stand in words, in rows; in columns only words that
    go around an object, and what the source lacks. Characters that stand in squares remain those of
    the source beside words of a row, and so does their punctuation.

    Parameters
    ----------
    source : GlyphSource
    text : str
    order : {"columns", "row"} or None
        See `set_text`.
    around : bool
        Whether it goes around an object.

    Returns
    -------
    FontText, MixedText or None
        None where it can be written in squares, no font has all of it, or fonts cannot be read.

    Raises
    ------
    InputError
        If the font cannot be used.
    """
    text = unicodedata.normalize("NFC", text)
    lacking = [one for one in missing_glyphs(source, text) if not is_square_letter(one)]
    in_rows = order != "columns" and has_letters(text)
    if not (lacking or in_rows or (around and has_words(text))):
        return None
    try:
        import_optional("uharfbuzz")
    except InputError:  # with_fallback says so, where it matters
        return None
    squares = squares_of(text)
    words = "".join(one for one in text if one not in squares)
    if in_rows and squares and (font := _best_font(words)) is not None:
        opened = open_font(font.path, font.number)
        _LOG.warning("%.40s is written in the font %s", " ".join(words.split()), font.family)
        return MixedText(text, with_fallback(source, squares, marks=True), opened)
    font = _best_font(text)
    if font is None:
        return None
    whole = set_text(text, open_font(font.path, font.number), Style(), source, order)
    _LOG.warning("%.40s is written in the font %s", " ".join(text.split()), font.family)
    return whole


def _fonts_for(characters: Sequence[str]) -> dict[str, SystemFont]:
    """Choose a font for all characters, or one for each that any font has."""
    if not characters:
        return {}
    whole = _best_font("".join(characters))
    best = {one: whole or _best_font(one) for one in characters}
    return {one: font for one, font in best.items() if font is not None}


def _best_font(text: str) -> SystemFont | None:
    """The preferred font among those that have ink for all characters of a text.

    Of a text of words that is one without Chinese characters, where there is one, and of a hand
    rather than of print.
    """
    regions = _SIMPLIFIED if _is_simplified(text) else _TRADITIONAL

    in_words = not any(map(is_square_letter, text))
    chinese = {font.path for font in fonts_with(_REFERENCE[0])} if in_words else set()

    def rank(font: SystemFont) -> tuple[object, ...]:
        family = font.family
        kind = 0 if _KAI.search(family) else 1 if _SONG.search(family) else 2
        is_plain = font.style.casefold() in _PLAIN
        is_ours = bool(regions & set(family.casefold().split()))
        is_print = in_words and not is_handwriting(font)
        first = font.path in chinese, is_print, kind, not is_plain, not is_ours
        return *first, family, font.style, str(font.path), font.number

    return next((font for font in sorted(fonts_with(text), key=rank) if draws(font, text)), None)


def _is_simplified(text: str) -> bool:
    try:
        text.encode("gb2312")
    except UnicodeEncodeError:
        return False
    return True


def _ink(font: FontFile, character: str) -> MultiPolygon:
    """The ink of a character, in the middle of the em."""
    from shapely.affinity import translate

    ink = font.outline(font.font.get_nominal_glyph(ord(character)))
    is_half = unicodedata.east_asian_width(character) == "H"  # it has the left half of the em
    return translate(ink, 0.25 * EM_UNITS) if is_half else ink


def _ink_of(glyph: Glyph) -> Geometry:
    from shapely import Polygon, unary_union

    return unary_union([Polygon(one.outline, one.holes).buffer(0.0) for one in glyph.strokes])


def _measure_ink(ink: Geometry) -> tuple[float, float, float, float, float]:
    """Middle (x, y) of ink, size between centre lines, mean stroke width, and perimeter.

    The perimeter is in sizes.
    """
    left, lower, right, upper = ink.bounds
    width = 2.0 * ink.area / ink.length
    size = math.sqrt((right - left) * (upper - lower)) - width
    return 0.5 * (left + right), 0.5 * (lower + upper), size, width, ink.length / size

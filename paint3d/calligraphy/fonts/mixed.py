"""A text of characters in squares and of words in a font, set as rows.

A word is one piece beside the characters, on the baseline that squares have.
"""

from __future__ import annotations

import math
import unicodedata
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import groupby

from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.fonts.shaping import (
    Shaper,
    Style,
    base_level,
    levels_of,
    visual_order,
)
from paint3d.calligraphy.fonts.typesetting import FontText, break_line
from paint3d.calligraphy.glyph_sources import GlyphSource, is_square_letter
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph
from paint3d.calligraphy.page.page import Page, Piece

__all__ = ["MixedText", "squares_of"]

_SPACE, _BESIDE = 0.3 * EM_UNITS, 0.12 * EM_UNITS  # between words; from a word to a square
_PITCH = 1.15 * EM_UNITS  # from line to line


def squares_of(text: str) -> str:
    """The characters of a row that stand in squares, with their punctuation, each once."""
    return "".join(one for one in dict.fromkeys(text) if _is_square(one))


def _is_square(run: str) -> bool:
    """Return whether it is a character that stands in a square of a row."""
    if len(run) != 1 or run.isspace():
        return False
    return is_square_letter(run) or unicodedata.east_asian_width(run) in "WF"


@dataclass(frozen=True, eq=False)
class MixedText:
    """A text whose characters are those of a source, and whose words are set in a font.

    Parameters
    ----------
    text : str
        In Unicode's composed form (NFC); line breaks start a new row.
    source : GlyphSource
        Of what `squares_of` finds.
    font : FontFile
        Of all else.

    Raises
    ------
    InputError
        If the font lacks a character.
    """

    text: str
    source: GlyphSource
    font: FontFile
    runs_down: bool = field(default=False, init=False)
    _glyphs: dict[str, Glyph] = field(default_factory=dict, init=False, repr=False)
    _words: dict[tuple[str, int], tuple[Page, float]] = field(
        default_factory=dict, init=False, repr=False
    )
    _pages: dict[tuple[str, ...], Page] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        self.font.check_has("".join(one for one in self.text if not _is_square(one)))

    def compose(self, length: float) -> Page:
        """The page with rows no longer than `length`, glyph units, where they can be broken."""
        key = tuple(self._rows(length))
        if key not in self._pages:
            pieces = [piece for k, row in enumerate(key) for piece in self._set_row(k, row)]
            licence = f"{self.source.licence}. {self.font.licence}"
            name = f"{self.source.name}; words in {self.font.name}"
            self._pages[key] = Page(tuple(pieces), name, licence)
        return self._pages[key]

    def least_size(self, length: float) -> tuple[float, float]:
        """Least length and height of the page, by advances alone."""
        longest = max(map(sum, self._advances)) if math.isinf(length) else 0.0
        return longest, _PITCH * (len(self._rows(length)) - 1)

    def _rows(self, length: float) -> list[str]:
        if math.isinf(length):
            return self._paragraphs
        parts = zip(self._paragraphs, self._advances, strict=True)
        return [row for part, advances in parts for row in break_line(part, advances, length)]

    @cached_property
    def _paragraphs(self) -> list[str]:
        lines = self.text.replace("\t", " ").splitlines()
        return [line.strip() for line in lines if line.strip()]

    @cached_property
    def _advances(self) -> list[list[float]]:
        """Of every character of every paragraph."""
        all_advances = []
        for part in self._paragraphs:
            advances: list[float] = []
            for run, level in _runs_of(part):
                if run.isspace():
                    advances += [_SPACE / len(run)] * len(run)
                elif _is_square(run):
                    advances.append(EM_UNITS)
                else:
                    advances += Shaper(self.font, _style_at(level)).advances(run)
            all_advances.append(advances)
        return all_advances

    def _set_row(self, number: int, row: str) -> list[Piece]:
        runs = _runs_of(row)
        placed: dict[int, list[Piece]] = {}
        x, y, before = 0.0, -_PITCH * number, ""
        for k in visual_order([level for _, level in runs]):
            run, level = runs[k]
            if before.strip() and not run.isspace() and _is_square(before) != _is_square(run):
                x += _BESIDE
            if run.isspace():
                x += _SPACE
            elif _is_square(run):
                glyph = self._glyphs.setdefault(run, self.source.load(run))
                placed[k] = [Piece(glyph, (x + glyph.middle[0], y + glyph.middle[1]))]
                x += EM_UNITS
            else:
                page, width = self._word(run, level)
                left = x + width if level % 2 else x  # its origin is where it begins
                placed[k] = [
                    replace(piece, at=(left + piece.at[0], y + piece.at[1]))
                    for piece in page.pieces
                ]
                x += width
            before = run
        return [
            replace(piece, word=(number, word))
            for word, k in enumerate(sorted(placed))
            for piece in placed[k]
        ]

    def _word(self, run: str, level: int) -> tuple[Page, float]:
        """A word in the font, from its origin on the baseline, and how far it goes on."""
        if (run, level) not in self._words:
            style = _style_at(level)
            page = FontText(run, self.font, style, self.source).compose(math.inf)
            self._words[run, level] = page, sum(Shaper(self.font, style).advances(run))
        return self._words[run, level]


def _style_at(level: int) -> Style:
    """The style of a run of one level."""
    return Style(direction="rtl" if level % 2 else "ltr")


def _runs_of(line: str) -> list[tuple[str, int]]:
    """Words, spaces, and each character that stands in a square by itself; each with its level."""
    runs: list[tuple[str, int]] = []
    levels = levels_of(line, base_level(line))
    kinds = [(_is_square(one), one.isspace()) for one in line]
    start = 0
    for ((is_square, _), level), members in groupby(zip(kinds, levels, strict=True)):
        end = start + len(list(members))
        run, start = line[start:end], end
        runs += [(part, level) for part in (run if is_square else [run])]
    return runs

"""A text of characters in squares and of words in a font, set as rows.

A word is one piece beside the characters, on the baseline that squares have.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import groupby

from paint3d.calligraphy.fonts.font_file import FontFile
from paint3d.calligraphy.fonts.shaping import Shaper, Style
from paint3d.calligraphy.fonts.typesetting import FontText, break_line
from paint3d.calligraphy.glyph_sources import GlyphSource, is_square_letter
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph
from paint3d.calligraphy.page.page import Page, Piece

__all__ = ["MixedText", "squares_of"]

_SPACE, _BESIDE = 0.3 * EM_UNITS, 0.12 * EM_UNITS  # between words; from a word to a square
_PITCH = 1.15 * EM_UNITS  # from line to line


def squares_of(text: str) -> str:
    """The characters of a text that stand in squares, each once."""
    return "".join(one for one in dict.fromkeys(text) if _is_square(one))


def _is_square(run: str) -> bool:
    """Return whether it is a character that stands in a square."""
    return len(run) == 1 and is_square_letter(run)


@dataclass(frozen=True, eq=False)
class MixedText:
    """A text whose characters are those of a source, and whose words are set in a font.

    Parameters
    ----------
    text : str
        Line breaks start a new row.
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
    _words: dict[str, tuple[Page, float]] = field(default_factory=dict, init=False, repr=False)
    _pages: dict[tuple[str, ...], Page] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        self.font.check_has("".join(one for one in self.text if not _is_square(one)))

    def compose(self, room: float) -> Page:
        """The page with rows no longer than `room`, glyph units, where they can be broken."""
        key = tuple(self._rows(room))
        if key not in self._pages:
            pieces = [piece for k, row in enumerate(key) for piece in self._set_row(k, row)]
            licence = f"{self.source.licence}. {self.font.licence}"
            name = f"{self.source.name}; words in {self.font.name}"
            self._pages[key] = Page(tuple(pieces), name, licence)
        return self._pages[key]

    def least_size(self, room: float) -> tuple[float, float]:
        """Least length and height of the page, by advances alone."""
        longest = max(map(sum, self._advances)) if math.isinf(room) else 0.0
        return longest, _PITCH * (len(self._rows(room)) - 1)

    def _rows(self, room: float) -> list[str]:
        if math.isinf(room):
            return self._paragraphs
        parts = zip(self._paragraphs, self._advances, strict=True)
        return [row for part, advances in parts for row in break_line(part, advances, room)]

    @cached_property
    def _paragraphs(self) -> list[str]:
        lines = unicodedata.normalize("NFC", self.text).replace("\t", " ").splitlines()
        return [line.strip() for line in lines if line.strip()]

    @cached_property
    def _advances(self) -> list[list[float]]:
        """Of every character of every paragraph."""
        shaper, found = Shaper(self.font, Style()), []
        for part in self._paragraphs:
            advances: list[float] = []
            for run in _runs_of(part):
                if run.isspace():
                    advances += [_SPACE / len(run)] * len(run)
                elif _is_square(run):
                    advances.append(EM_UNITS)
                else:
                    advances += shaper.advances(run)
            found.append(advances)
        return found

    def _set_row(self, number: int, row: str) -> list[Piece]:
        pieces: list[Piece] = []
        x, y, word, before = 0.0, -_PITCH * number, 0, ""
        for run in _runs_of(row):
            if run.isspace():
                x += _SPACE
            elif _is_square(run):
                x += 0.0 if not before.strip() or _is_square(before) else _BESIDE
                glyph = self._glyphs.setdefault(run, self.source.load(run))
                middle = glyph.middle
                pieces.append(Piece(glyph, (x + middle[0], y + middle[1]), (number, word)))
                x, word = x + EM_UNITS, word + 1
            else:
                x += _BESIDE if before and _is_square(before) else 0.0
                page, width = self._word(run)
                for piece in page.pieces:
                    at = (x + piece.at[0], y + piece.at[1])
                    pieces.append(replace(piece, at=at, word=(number, word)))
                x, word = x + width, word + 1
            before = run
        return pieces

    def _word(self, run: str) -> tuple[Page, float]:
        """A word in the font, from its origin on the baseline, and how far it goes on."""
        if run not in self._words:
            width = sum(Shaper(self.font, Style()).advances(run))
            self._words[run] = (
                FontText(run, self.font, Style(), self.source).compose(math.inf),
                width,
            )
        return self._words[run]


def _runs_of(line: str) -> Sequence[str]:
    """Words, spaces, and each character that stands in a square by itself."""
    runs: list[str] = []
    for kind, members in groupby(line, lambda one: (_is_square(one), one.isspace())):
        run = "".join(members)
        runs += list(run) if kind[0] else [run]
    return runs

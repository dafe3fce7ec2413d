"""Sources of glyphs: a folder of outlines, or a package of centre lines."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Protocol

from paint3d.calligraphy.glyphs import Glyph, load_glyph
from paint3d.calligraphy.kanjivg import find_kanjivg, load_lines
from paint3d.calligraphy.stroke_shapes import SOURCE_OF_SHAPES, shape_strokes
from paint3d.errors import GlyphError, InputError

__all__ = [
    "GlyphSource",
    "HanziWriterFolder",
    "KanjiVGLines",
    "has_letters",
    "is_square_letter",
    "load_glyphs",
    "missing_glyphs",
    "names_of",
    "open_glyph_folder",
    "open_glyphs",
]

_PROBE = "一"


class GlyphSource(Protocol):
    """Something that knows the strokes of characters."""

    @property
    def name(self) -> str:
        """Name of the source, for reports."""
        ...

    @property
    def licence(self) -> str:
        """Whose shapes they are and under what licence."""
        ...

    def has(self, text: str) -> bool:
        """Return whether a character is known."""
        ...

    def load(self, text: str) -> Glyph:
        """The glyph of a character."""
        ...


@dataclass(frozen=True)
class HanziWriterFolder:
    """A folder of `hanzi-writer-data`: one JSON file a character."""

    folder: Path
    name: str = "hanzi-writer-data"
    licence: str = (
        "Stroke shapes: hanzi-writer-data (Make Me a Hanzi), derived from Arphic PL KaitiM; "
        "Arphic Public License"
    )

    def has(self, text: str) -> bool:
        """Return whether there is a file for a character."""
        return text not in "/\\\0." and (self.folder / f"{text}.json").is_file()

    def load(self, text: str) -> Glyph:
        """Read a character's file."""
        return load_glyph(self.folder, text)


@dataclass(frozen=True)
class KanjiVGLines:
    """Centre lines of the installed package `kanjivg`, with widths by the types of the strokes."""

    folder: Path
    name: str = "kanjivg"
    licence: str = (
        "Stroke lines: KanjiVG (Ulrich Apel, kanjivg.tagaini.net), CC BY-SA 3.0; "
        + SOURCE_OF_SHAPES
    )

    def has(self, text: str) -> bool:
        """Return whether there is a file for a character."""
        return (self.folder / f"{ord(text):05x}.svg").is_file()

    def load(self, text: str) -> Glyph:
        """Read a character's lines and give them outlines."""
        return _shape_glyph(self.folder, text)


@lru_cache(maxsize=1024)  # a text is laid anew each time that it is moved; about 20 ms each
def _shape_glyph(folder: Path, text: str) -> Glyph:
    return Glyph(text, tuple(shape_strokes(load_lines(folder, text), repr(text))))


def open_glyphs(folder: Path | str | None) -> GlyphSource:
    """The glyphs of a folder, or without one those of the installed `kanjivg`.

    Raises
    ------
    InputError
        If the folder holds no glyphs, or none is given and `kanjivg` is not installed.
    """
    if folder is not None:
        return open_glyph_folder(folder)
    lines = find_kanjivg()
    if lines is None:
        raise InputError(
            "the shapes of the characters, KanjiVG, are not installed; expected them, or a folder "
            "of hanzi-writer-data",
            hint="pip install kanjivg",
        )
    return KanjiVGLines(lines)


def open_glyph_folder(folder: Path | str) -> HanziWriterFolder:
    """Find the glyphs in an unpacked `hanzi-writer-data`, in the folder itself or in its `data`.

    Raises
    ------
    InputError
        If there is no such folder, or it holds no glyphs.
    """
    top = Path(folder)
    if not top.is_dir():
        raise InputError("{top}: no such folder; expected one of hanzi-writer-data", top=top)
    for candidate in (top, top / "package", top / "data", top / "node_modules/hanzi-writer-data"):
        if (candidate / f"{_PROBE}.json").is_file():
            return HanziWriterFolder(candidate)
    raise InputError(
        "{top} holds no glyphs (no {probe}.json); expected the files of hanzi-writer-data, one a "
        "character",
        top=top,
        probe=_PROBE,
    )


def has_letters(text: str) -> bool:
    """Return whether a text has letters that are not written in squares, as in alphabets."""
    return any(unicodedata.category(one)[0] == "L" and not is_square_letter(one) for one in text)


def is_square_letter(character: str) -> bool:
    """Return whether it is a letter or number of Chinese, Japanese or Korean, not a mark."""
    is_theirs = unicodedata.east_asian_width(character) in "WFH"
    return is_theirs and unicodedata.category(character)[0] in "LN"


def missing_glyphs(source: GlyphSource, text: str) -> list[str]:
    """Characters of a text that a source does not know, each once, without white space."""
    characters = "".join(unicodedata.normalize("NFC", text).split())
    return [one for one in dict.fromkeys(characters) if not source.has(one)]


def names_of(characters: Iterable[str]) -> str:
    """Characters with their numbers, as messages name them."""
    return ", ".join(f"{one!r} (U+{ord(one):04X})" for one in characters)


def _check_glyphs(source: GlyphSource, text: str) -> None:
    """Refuse a text with characters that a source does not know.

    Raises
    ------
    GlyphError
        If characters are missing; the message names them all.
    """
    missing = missing_glyphs(source, text)
    if missing:
        raise GlyphError(
            "{font} has no glyph for {names}; expected characters that it has",
            font=source.name,
            names=names_of(missing),
            characters="".join(missing),
        )


def load_glyphs(source: GlyphSource, text: str) -> dict[str, Glyph]:
    """The glyphs of all characters of a text, each once.

    Raises
    ------
    GlyphError
        As `_check_glyphs`.
    """
    _check_glyphs(source, text)
    return {c: source.load(c) for c in dict.fromkeys(text)}

"""Opening pages for a window: a text in a font, a drawing, or a file of strokes."""

from __future__ import annotations

from pathlib import Path

from paint3d.calligraphy.fonts.font_file import open_font
from paint3d.calligraphy.fonts.shaping import Style
from paint3d.calligraphy.fonts.typesetting import FontText, set_text
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.kanjivg import find_kanjivg
from paint3d.calligraphy.page.page import Page
from paint3d.errors import InputError

__all__ = ["PAGE_FILES", "open_page", "set_in"]

PAGE_FILES = (".svg", ".strokes.json")


def set_in(text: str, font: Path | str, *, columns: bool) -> FontText:
    """A text set in a font, in the order and direction of strokes that kanjivg knows.

    Parameters
    ----------
    text : str
    font : path or str
        Its file, or its name on this system.
    columns : bool
        For scripts that are written so; others stand in rows all the same.

    Raises
    ------
    InputError
        If the font cannot be used, or lacks characters.
    """
    known = open_glyphs(None) if find_kanjivg() is not None else None
    order = None if columns else "row"
    return set_text(text, open_font(font), Style(), known, order)


def open_page(file: Path | str) -> Page:
    """The page in a drawing or a file of strokes, by the file's ending.

    Raises
    ------
    InputError
        If it is neither, or cannot be used.
    """
    name = Path(file).name.lower()
    if name.endswith(".svg"):
        from paint3d.calligraphy.page.svg_drawing import load_svg

        return load_svg(file)
    if name.endswith(".strokes.json"):
        from paint3d.calligraphy.page.strokes_file import load_strokes

        return load_strokes(Path(file))
    raise InputError(
        "{file}: expected a name ending in {page_files}",
        file=file,
        page_files=" or ".join(PAGE_FILES),
    )

"""A seal as it is asked for: characters that are known, a text in a font, or a drawing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from paint3d.calligraphy.seal.stone import Seal, cut_drawing, cut_font, cut_known
from paint3d.errors import InputError

__all__ = ["cut_seal"]


def cut_seal(
    text: str | None = None,
    drawing: Path | str | None = None,
    style: str = "zhuwen",
    size_mm: float = 16.0,
    *,
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
        got = "nothing" if text is None else "a text and a drawing"
        raise InputError(f"a seal of {got}; expected one of a text and a drawing")
    if drawing is not None:
        from paint3d.calligraphy.page.svg_drawing import svg_shape

        return cut_drawing(Path(drawing).name, svg_shape(drawing, ids), style, size_mm)
    assert text is not None
    if font is not None:
        from paint3d.calligraphy.fonts.font_file import open_font

        return cut_font(text, open_font(font, font_number), style, size_mm)
    from paint3d.calligraphy.fonts.fallback import with_fallback
    from paint3d.calligraphy.glyph_sources import open_glyphs

    return cut_known(text, with_fallback(open_glyphs(glyphs), text), style, size_mm)

"""Fonts made for a test, and a system that has no others."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from paint3d.calligraphy.glyph_sources import open_glyphs

__all__ = ["REFERENCE", "SystemFonts", "system_fonts"]

REFERENCE = "永中大天木水田西有年山生"
"""Characters that fonts and kanjivg have alike."""
_CONFIGURATION = """<?xml version="1.0"?><!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig><dir>{folder}</dir><cachedir>{folder}/cache</cachedir></fontconfig>
"""


class SystemFonts:
    """The fonts that fontconfig finds, none at first.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.configuration = folder / "fonts.conf"
        self.configuration.write_text(_CONFIGURATION.format(folder=folder), encoding="utf-8")

    def add(self, family: str, characters: str, scale: float = 1.0, growth: float = 0.0) -> None:
        """Add a font of kanjivg's shapes, so many times as large and then so much bolder.

        What kanjivg lacks looks like 歩, which it has for 步.
        """
        from fontTools.fontBuilder import FontBuilder
        from fontTools.pens.ttGlyphPen import TTGlyphPen

        glyphs = {".notdef": TTGlyphPen(None).glyph()}
        for one in characters:
            pen = TTGlyphPen(None)
            for ring in _rings(one, scale, growth):
                pen.moveTo(ring[0])
                for point in ring[1:]:
                    pen.lineTo(point)
                pen.closePath()
            glyphs[f"u{ord(one):04X}"] = pen.glyph()
        build = FontBuilder(1024)
        build.setupGlyphOrder(list(glyphs))
        build.setupCharacterMap({ord(one): f"u{ord(one):04X}" for one in characters})
        build.setupGlyf(glyphs)
        build.setupHorizontalMetrics(dict.fromkeys(glyphs, (1024, 0)))
        build.setupHorizontalHeader(ascent=900, descent=-124)
        names = {"familyName": family, "styleName": "Regular", "fullName": family}
        build.setupNameTable(names)
        build.setupOS2()
        build.setupPost()
        build.save(self._folder / f"{family}.ttf")

    def remove_all(self) -> None:
        """Remove what was added."""
        for file in self._folder.glob("*.ttf"):
            file.unlink()


def _rings(character: str, scale: float, growth: float) -> list[list[tuple[int, int]]]:
    from shapely import Polygon, get_parts, unary_union

    known = open_glyphs(None)
    strokes = known.load(character if known.has(character) else "歩").strokes
    ink = unary_union([Polygon(stroke.outline).buffer(0.0) for stroke in strokes])
    rings = [
        ring
        for part in get_parts(ink.buffer(growth / scale))
        for ring in (part.exterior, *part.interiors)
    ]
    return [[(round(scale * x), round(scale * y)) for x, y in ring.coords[:-1]] for ring in rings]


@pytest.fixture
def system_fonts(tmp_path_factory, monkeypatch) -> SystemFonts:
    """A system without fonts, to add some to; skips where fontconfig cannot be asked."""
    if shutil.which("fc-list") is None:
        pytest.skip("fontconfig is not installed")
    for package in ("uharfbuzz", "fontTools"):
        pytest.importorskip(package)
    fonts = SystemFonts(tmp_path_factory.mktemp("fonts"))
    monkeypatch.setenv("FONTCONFIG_FILE", str(fonts.configuration))
    return fonts

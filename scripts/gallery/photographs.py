"""A photographed character beside its painted copy, wet and dry: the photograph is of our own."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.flying_white import with_dryness
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.photo.copying import Asked, copy_sheet
from paint3d.calligraphy.photo.likeness import PaintedSheet, likeness_of, painted_sheet
from paint3d.calligraphy.writing import WritingSettings, Written, write_page
from paint3d.colour.materials import load_material
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.painter.recorded_tools import recorded_amount
from paint3d.surface.painted_surface import PaintedSurface

sys.path.insert(0, str(Path(__file__).parents[2]))
from scripts.gallery.writing import beside, seen_from_above, stacked
from tests.support.photographs import Camera, TrueSheet, photograph

TEXT, EM, RESOLUTION = "永", 60.0, 0.15
DRY = ((0.1, 0.3, 0.5), (0.0, 0.2, 0.6), (0.0, 0.0, 0.2), (0.2, 0.5, 0.7), (0.0, 0.3, 0.75))
HEIGHT = 560  # pixels


def draw_photograph(file: Path, glyphs: Path) -> None:
    """Photographs on the left, copies on the right."""
    rows = []
    for seed, dryness in ((12, None), (13, DRY)):
        shown = photograph(_sheet(dryness, seed), seed, Camera(size=1500))
        known = {TEXT: open_glyphs(None).load(TEXT)}
        sheet = copy_sheet(shown.pixels, "photograph", Asked(lines=(TEXT,), templates=known))
        written, surface = _painted(sheet.page)
        assert written.page is not None
        placed = list(zip(written.page.pieces, written.placed, strict=True))
        copy: PaintedSheet = painted_sheet(sheet, placed, surface)
        print(f"{file.name}: {likeness_of(sheet, copy).summary()}")
        rows.append(beside([_as_high(shown.pixels), _as_high(copy.picture)]))
    stacked(rows).save(file)


def _sheet(dryness: tuple[tuple[float, ...], ...] | None, seed: int) -> TrueSheet:
    """A sheet with a character that we painted, and a seal."""
    glyph = open_glyphs(None).load(TEXT)
    if dryness is not None:
        pairs = zip(glyph.strokes, dryness, strict=True)
        glyph = replace(glyph, strokes=tuple(replace(one, dryness=dry) for one, dry in pairs))
    _, surface = _painted(Page((Piece(glyph, glyph.middle),), TEXT, ""))
    half = 0.62 * EM
    picture = seen_from_above(surface, (-half, -half, half, half), 1300)
    grey = np.asarray(picture.convert("L"), np.float32)
    ink = np.clip((np.median(grey) - grey) / (np.median(grey) - grey.min()), 0.0, 1.0)
    red = np.zeros_like(ink)
    red[1060:1180, 1080:1200] = 1.0
    red[1072:1168, 1092:1188] = 0.0
    red[1090:1150, 1112:1120] = red[1090:1150, 1140:1148] = red[1116:1124, 1100:1180] = 1.0
    return TrueSheet(ink, ink > 0.5, red, np.ones_like(ink))


def _painted(page: Page) -> tuple[Written, PaintedSurface]:
    mesh, brush = load_mesh("plane"), load_brush(choose_brush(EM))
    written = write_page(mesh, page, WritingSettings(brush, EM))
    xuan = load_material("xuan")
    recording = with_dryness(written.recording, written.dryness, xuan)
    surface = PaintedSurface(mesh, RESOLUTION, material=xuan)
    Painter(surface, brush, amount=recorded_amount(recording.header)).replay(recording)
    surface.refresh()
    return written, surface


def _as_high(pixels: np.ndarray) -> Image.Image:
    picture = Image.fromarray(pixels)
    return picture.resize((round(picture.width * HEIGHT / picture.height), HEIGHT))


PICTURES = {"photograph.png": draw_photograph}

"""Copying photographs whose truth is known, drawn at random, and the table of how well it went."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from shapely import MultiPolygon

from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.flying_white import with_ink
from paint3d.calligraphy.glyph_sources import GlyphSource, open_glyphs
from paint3d.calligraphy.glyphs import Glyph
from paint3d.calligraphy.page.page import Page
from paint3d.calligraphy.photo.copying import Asked, CopiedSheet, copy_sheet
from paint3d.calligraphy.photo.likeness import (
    PaintedSheet,
    likeness_of,
    painted_sheet,
    strength_of_both,
)
from paint3d.calligraphy.photo.rehearsal import rehearse
from paint3d.calligraphy.shapes.decompose import decompose
from paint3d.calligraphy.writing import WritingSettings, Written, write_page
from paint3d.colour.materials import load_material
from paint3d.core.arrays import AnyArray
from paint3d.errors import Paint3DError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.painter.recorded_tools import recorded_amount
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.pages import draw_letters_of
from tests.support.photographs import (
    Camera,
    Judged,
    Photographed,
    carried,
    judge,
    photograph,
    sheet_of,
    strengths_of,
)

__all__ = ["copied_at_random", "painted_copy", "photos_table"]

_EM_MM, _RESOLUTION_MM, _TRIALS = 40.0, 0.15, 2


@dataclass(frozen=True)
class _Row:
    """Figures of one photograph."""

    name: str
    dry: bool
    judged: Judged
    strokes: float  # found over true ones
    of_clean: float  # found over those that the clean shapes are taken apart into
    seconds: float
    painted: float  # IoU with the true bodies; NaN where it was not painted
    painted_r: float
    painted_error: float
    strength_r: float  # of the light that ink takes; NaN where all strokes are black
    strength_error: float
    painted_strength: tuple[float, float]  # the same of the painting


def copied_at_random(
    seed: int, source: GlyphSource, pale: float = 0.0
) -> tuple[str, Photographed, CopiedSheet, float, list[Glyph]]:
    """A photograph drawn by a seed, odd ones of dry strokes, and what was found on it."""
    rng = np.random.default_rng(seed)
    text = draw_letters_of(source, int(rng.integers(1, 5)), seed)
    glyphs = [source.load(one) for one in text]
    there = photograph(
        sheet_of(glyphs, seed, dry=0.9 * (seed % 2), longest=1200, pale=pale),
        seed,
        Camera(size=int(rng.choice([1300, 1600, 2200])), jpeg=int(rng.integers(75, 95))),
    )
    asked = Asked(lines=(text,), templates=dict(zip(text, glyphs, strict=True)))
    started = time.process_time()
    sheet = copy_sheet(there.pixels, f"seed {seed}", asked)
    return text, there, sheet, time.process_time() - started, glyphs


def photos_table(n: int, seed: int, glyphs: Path | None, n_painted: int, pale: float = 0.0) -> str:
    """Copy n photographs, paint the first of them; their figures as Markdown.

    A share `pale` of the strokes is written with thin ink.
    """
    source = open_glyphs(glyphs)
    rows, lines = [], []
    for k in range(seed, seed + n):
        try:
            rows.append(_row(k, source, k < seed + n_painted, pale))
        except Paint3DError as fault:
            lines.append(f"refused: seed {k}: {fault}")
            continue
        one = rows[-1]
        print(f"{one.name} {one.judged} strokes {one.strokes:.2f} {one.seconds:.1f} s", flush=True)
    lines += ["", "| | wet: mean | least | dry: mean | least |", "|---|---|---|---|---|"]
    for name, of in _FIGURES.items():
        cells = []
        for dry in (False, True):
            values = np.array([of(row) for row in rows if row.dry is dry])
            values = values[np.isfinite(values)]
            worst = values.max if name in _WORST_IS_MOST else values.min
            cells += [f"{values.mean():.4f} | {worst():.4f}" if len(values) else "- | -"]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    within = [row.judged.corners < 0.006 for row in rows]
    lines.append(f"\ncorners within .6 % of the side: {sum(within)} of {n}")
    return "\n".join(lines)


_FIGURES = {
    "ink found, IoU": lambda row: row.judged.ink_iou,
    "strokes' bodies, IoU": lambda row: row.judged.body_iou,
    "corners off, shares of a side": lambda row: row.judged.corners,
    "seal taken for ink": lambda row: row.judged.seal,
    "dryness r": lambda row: row.judged.dryness_r if row.dry else np.nan,
    "dryness off": lambda row: row.judged.dryness_error,
    "strokes found / true": lambda row: row.strokes,
    "strokes found / of the clean shapes": lambda row: row.of_clean,
    "processor s": lambda row: row.seconds,
    "painted, IoU with the true bodies": lambda row: row.painted,
    "painted dryness r": lambda row: row.painted_r if row.dry else np.nan,
    "painted dryness off": lambda row: row.painted_error,
    "strength r": lambda row: row.strength_r,
    "strength off": lambda row: row.strength_error,
    "painted strength r": lambda row: row.painted_strength[0],
    "painted strength off": lambda row: row.painted_strength[1],
}
_WORST_IS_MOST = (
    "corners off, shares of a side", "seal taken for ink", "dryness off", "processor s",
    "strokes found / true", "strokes found / of the clean shapes", "painted dryness off",
    "strength off", "painted strength off",
)  # fmt: skip


def _row(seed: int, source: GlyphSource, paints: bool, pale: float) -> _Row:
    text, there, sheet, seconds, glyphs = copied_at_random(seed, source, pale)
    found = sum(len(piece.glyph.strokes) for piece in sheet.page.pieces)
    true = sum(len(glyph.strokes) for glyph in glyphs)
    clean = sum(len(decompose(clean_shape(glyph), template=glyph)) for glyph in glyphs)
    nothing = np.nan, np.nan
    *painted, inks = _painted(there, sheet) if paints else (np.nan, *nothing, nothing)
    strengths = _alike(*strengths_of(there, sheet))
    name = f"seed {seed} {text} {'dry' if seed % 2 else 'wet'}"
    judged = judge(there, sheet)
    return _Row(
        name, bool(seed % 2), judged, found / true, found / clean, seconds, *painted, *strengths,
        inks,
    )  # fmt: skip


def clean_shape(glyph: Glyph) -> MultiPolygon:
    """The ink of a glyph as one shape, as a scan without a fault would show it."""
    outlines = [shapely.make_valid(shapely.Polygon(stroke.outline)) for stroke in glyph.strokes]
    parts = shapely.get_parts(shapely.get_parts(shapely.unary_union(outlines)))
    return MultiPolygon([part for part in parts if part.geom_type == "Polygon"])


def _alike(one: AnyArray, other: AnyArray) -> tuple[float, float]:
    """Correlation and mean difference; NaN for the first where all of one are the same."""
    r = float(np.corrcoef(one, other)[0, 1]) if min(np.ptp(one), np.ptp(other)) > 0.05 else np.nan
    return r, float(np.abs(one - other).mean())


def _painted(
    there: Photographed, sheet: CopiedSheet
) -> tuple[float, float, float, tuple[float, float]]:
    """IoU of a painting by a full brush with the true bodies; dryness, ink of one on xuan paper."""
    _, body, _ = carried(there, sheet)
    wet = painted_copy(sheet, sheet.wet_page, "porcelain").cover > 0.5
    dry = painted_copy(sheet, sheet.page, "xuan")
    like = likeness_of(sheet, dry)
    iou = float((wet & (body > 0.5)).sum() / (wet | (body > 0.5)).sum())
    return iou, like.dryness_r, like.dryness_error, _alike(*strength_of_both(sheet, dry))


def painted_copy(
    sheet: CopiedSheet,
    page: Page,
    material: str,
    trials: int = _TRIALS,
    resolution_mm: float = _RESOLUTION_MM,
) -> PaintedSheet:
    """A page of a sheet as it is painted on a plane of a material."""
    brush, mesh = load_brush(choose_brush(_EM_MM)), load_mesh("plane")
    made_of = load_material(material)

    def paint(plan: Written) -> PaintedSurface:
        recording = with_ink(plan.recording, plan.dryness, plan.strength, made_of)
        surface = PaintedSurface(mesh, resolution_mm, material=made_of)
        Painter(surface, brush, amount=recorded_amount(recording.header)).replay(recording)
        surface.refresh()
        return surface

    plan = write_page(mesh, page, WritingSettings(brush, _EM_MM))
    written = rehearse(plan, paint, made_of, trials, replace(sheet, page=page))
    assert written.page is not None
    placed = list(zip(written.page.pieces, written.placed, strict=True))
    return painted_sheet(sheet, placed, paint(written))

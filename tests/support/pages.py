"""Writing pieces of a page, each by itself, and comparing what was painted with its shape."""

from __future__ import annotations

import time
import unicodedata
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, unary_union

from paint3d.brush.presets import choose_brush, load_brush
from paint3d.calligraphy.fonts.font_file import FontFile, open_font
from paint3d.calligraphy.fonts.shaping import Style
from paint3d.calligraphy.fonts.typesetting import set_text
from paint3d.calligraphy.glyph_sources import GlyphSource, open_glyphs
from paint3d.calligraphy.glyphs import EM_UNITS, Glyph
from paint3d.calligraphy.layout import Layout
from paint3d.calligraphy.metrics import PIXELS, Likeness, compare, copybook_mask, painted_mask
from paint3d.calligraphy.page.laying import lay_page
from paint3d.calligraphy.page.page import Page, Piece
from paint3d.calligraphy.page.svg_drawing import load_svg
from paint3d.calligraphy.path_fit import PlanSettings
from paint3d.calligraphy.planning import on_paper
from paint3d.calligraphy.shapes.ductus import known_strokes
from paint3d.calligraphy.writing import WritingSettings, write_page
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import SquareLimits, make_chart, unroll
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.found_strokes import AsListed, as_listed

__all__ = [
    "SCRIPTS",
    "PageDesk",
    "PieceCopy",
    "TakenApart",
    "copy_piece",
    "draw_letters",
    "draw_letters_of",
    "page_of",
    "pieces_of",
]

SCRIPTS = {
    "latin": ((0x41, 0x5A), (0x61, 0x7A)),
    "greek": ((0x391, 0x3A9), (0x3B1, 0x3C9)),
    "cyrillic": ((0x410, 0x44F),),
    "han": ((0x4E00, 0x9FA5),),
    "kana": ((0x3041, 0x3096), (0x30A1, 0x30FA)),
    "hangul": ((0xAC00, 0xD7A3),),
}
"""First and last characters of what letters are drawn from at random."""

_LEAST_PIXELS = 8.0  # across a stroke
_NODES_PER_EM = 24.0
_REACH = 0.08  # ems that the chart goes beyond the ink


@dataclass(frozen=True)
class PageDesk:
    """Object, brush and size that pieces are written with; as `tests.support.copybook.Desk`."""

    em_mm: float = 100.0
    on: str = "plane"
    resolution_mm: float = 0.2
    brush: str | None = None
    settings: PlanSettings = field(default_factory=PlanSettings)

    @property
    def brush_name(self) -> str:
        """The preset that is written with."""
        return self.brush or choose_brush(self.em_mm)


@dataclass(frozen=True, eq=False)
class PieceCopy:
    """A piece, written and compared.

    Attributes
    ----------
    text : str
    n_strokes : int
    likeness : Likeness
    seconds : float
        Processor time of planning, laying and timing it, s.
    painted, wanted : (576, 576) bool
    """

    text: str
    n_strokes: int
    likeness: Likeness
    seconds: float
    painted: NDArray[np.bool_]
    wanted: NDArray[np.bool_]


def page_of(
    text: str | None,
    font: str | None,
    svg: Path | None,
    *,
    number: int = 0,
    templates: bool = True,
) -> Page:
    """The page that `paint3d write` would set, in one line."""
    if svg is not None:
        return load_svg(svg)
    assert text is not None
    assert font is not None
    known = open_glyphs(None) if templates else None
    return set_text(text, open_font(font, number), Style(), known, None).compose(float("inf"))


@dataclass(frozen=True, eq=False)
class TakenApart:
    """A piece that was taken apart into strokes.

    Attributes
    ----------
    glyph : Glyph
    seconds : float
        Processor time that it took, with setting the text, s.
    listed : AsListed, optional
        How its strokes agree with the table's, if it is a letter that is known.
    """

    glyph: Glyph
    seconds: float
    listed: AsListed | None


def pieces_of(
    text: str | None,
    font: str | None,
    svg: Path | None,
    *,
    number: int = 0,
    templates: bool = True,
) -> tuple[str, list[TakenApart]]:
    """The name of a font or a drawing, and its different pieces, word by word."""
    source, name, pieces = open_glyphs(None), "", []
    words = [None] if text is None else list(dict.fromkeys(text.split()))
    page_of(words[0], font, svg, number=number, templates=templates)  # what is read but once
    for word in words:
        started = time.process_time()
        page = page_of(word, font, svg, number=number, templates=templates)
        glyphs = list({id(piece.glyph): piece.glyph for piece in page.pieces}.values())
        seconds = (time.process_time() - started) / max(1, len(glyphs))
        name = page.source
        for glyph in glyphs:
            forms = known_strokes(source, glyph.text) if len(glyph.text) == 1 else ()
            listed = as_listed(glyph.strokes, *(one.strokes for one in forms)) if forms else None
            pieces.append(TakenApart(glyph, seconds, listed))
    return name, pieces


def draw_letters(font: FontFile, script: str, n: int, seed: int) -> str:
    """Different letters of a script that a font has, drawn at random; all, where there are fewer.

    Letters whose glyph is empty are left out, and fewer come then.

    Raises
    ------
    InputError
        If it has none.
    """
    codes = [code for first, last in SCRIPTS[script] for code in range(first, last + 1)]
    known = [c for c in codes if c in font.face.unicodes and unicodedata.category(chr(c))[0] == "L"]
    if not known:
        raise InputError(f"{font.name} has no letters of {script}; expected another font")
    order = np.random.default_rng(seed).permutation(len(known))[:n]
    return "".join(chr(known[k]) for k in order if not font.is_empty(chr(known[k])))


def draw_letters_of(source: GlyphSource, count: int, seed: int) -> str:
    """Different Han characters that a source knows, drawn at random, the same for a seed."""
    low, high = SCRIPTS["han"][0]
    known = [code for code in range(low, high + 1) if source.has(chr(code))]
    order = np.random.default_rng(seed).permutation(len(known))[:count]
    return "".join(chr(known[k]) for k in order)


def copy_piece(desk: PageDesk, glyph: Glyph) -> PieceCopy:
    """Write one piece, from the plan to the paint, and compare it with its shape.

    Raises
    ------
    Paint3DError
        If it cannot be written there.
    """
    mesh = load_mesh(desk.on)
    settings = WritingSettings(load_brush(desk.brush_name), desk.em_mm, desk.settings)
    page = Page((Piece(glyph, (0.0, 0.0)),), glyph.text, "")
    started = time.process_time()
    written = write_page(mesh, page, settings)
    seconds = time.process_time() - started
    surface = PaintedSurface(mesh, desk.resolution_mm)
    Painter(surface, desk.brush_name, azimuth=desk.settings.azimuth).replay(written.recording)
    low, side, shape = _raster_of(glyph, desk.em_mm)
    wanted = _wanted(glyph, desk.em_mm, low, side)
    painted = _painted(surface, page, desk, low, side, shape)
    n = len(glyph.strokes)
    return PieceCopy(glyph.text, n, compare(painted, wanted), seconds, painted, wanted)


def _raster_of(glyph: Glyph, em_mm: float) -> tuple[AnyArray, float, AnyArray]:
    """Lower left corner and side (mm) of what is compared, and the ink's half extents.

    The side is the em, or what the ink needs, or just that where 8 pixels a stroke need it.
    """
    ink = unary_union([Polygon(s.outline, s.holes).buffer(0.0) for s in glyph.strokes])
    left, lower, right, upper = ink.bounds
    low, high = (on_paper(np.array([p]), em_mm)[0] for p in ((left, lower), (right, upper)))
    across = em_mm / EM_UNITS * 2.0 * ink.area / max(ink.length, 1e-9)
    most = float((high - low).max())
    fine = across * PIXELS / max(em_mm, most) < _LEAST_PIXELS
    side = most if fine else max(em_mm, most)
    middle = 0.5 * (low + high)
    return middle - 0.5 * side, side, 0.5 * (high - low)


def _wanted(glyph: Glyph, em_mm: float, low: AnyArray, side: float) -> NDArray[np.bool_]:
    def moved(points: AnyArray) -> AnyArray:
        return on_paper(points, em_mm) - low

    holes = [[moved(hole) for hole in stroke.holes] for stroke in glyph.strokes]
    return copybook_mask([moved(stroke.outline) for stroke in glyph.strokes], side, holes)


def _painted(
    surface: PaintedSurface,
    page: Page,
    desk: PageDesk,
    low: AnyArray,
    side: float,
    half_ink: AnyArray,
) -> NDArray[np.bool_]:
    """The raster of the painting in a chart around the piece's box, as large as its ink asks."""
    closest = ClosestPoints(surface.source)
    limits = SquareLimits(room_mm=load_brush(desk.brush_name).length_mm)
    _, placed = lay_page(closest, page, desk.em_mm, Layout(), limits)
    glyph, frame = placed[0].glyph, placed[0].square.chart.frame
    middle = on_paper(np.array([glyph.middle]), desk.em_mm)[0]
    off = np.abs(low + 0.5 * side - middle)
    half = half_ink + off + _REACH * desk.em_mm
    chart = make_chart(closest, frame, half[0], half[1], desk.em_mm / _NODES_PER_EM)
    faces, coverage = surface.paint_mesh.leaf_faces(), surface.coverage
    faces = faces[(coverage[faces] > 0.0).any(axis=1)]
    used = np.unique(faces)
    points = np.full((len(coverage), 2), np.nan)
    points[used] = unroll(chart, surface.paint_mesh.vertices[used].astype(np.float64)) + middle
    faces = faces[np.isfinite(points[faces]).all(axis=(1, 2))]
    return painted_mask(points - low, coverage, faces, side)

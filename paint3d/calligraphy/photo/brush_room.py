"""Whether a brush can write strokes as narrow and as wide as those of a page."""

from __future__ import annotations

import math

import numpy as np

from paint3d.brush.bending import build_tuft
from paint3d.brush.spec import BrushSpec
from paint3d.calligraphy.footprint_table import tabulate_footprints
from paint3d.calligraphy.glyphs import EM_UNITS, GlyphStroke
from paint3d.calligraphy.page.page import Page
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError

__all__ = ["check_widths"]

_NARROW, _WIDE = 10.0, 90.0  # per cent of the strokes' widths: what may be left to the tip
_TOO_WIDE = 1.15  # times what the brush fills at its full press
_ROUNDED = 1.05  # the size that is named, so that it does


def check_widths(page: Page, brush: BrushSpec, em_mm: float, resolution_mm: float) -> None:
    """Refuse a size at which strokes are finer or wider than the brush, or than what is seen.

    Parameters
    ----------
    page : Page
    brush : BrushSpec
    em_mm : float
        1024 glyph units, mm.
    resolution_mm : float
        Vertex spacing of the surface.

    Raises
    ------
    InputError
        The message names the size that would do.
    """
    widths = [_width(stroke) for piece in page.pieces for stroke in piece.glyph.strokes]
    narrow, wide = np.percentile(widths, (_NARROW, _WIDE)) * em_mm / EM_UNITS
    rows = tabulate_footprints(build_tuft(brush), 1e3).points
    least, most = (2.0 * float(row[:, 1].max()) for row in (rows[0], rows[-1]))
    finest = max(least, resolution_mm)
    if narrow < finest:
        what = "the brush" if least > resolution_mm else "the vertices"
        more = "" if least > resolution_mm else f", or --resolution {0.4 * narrow:.2g}"
        raise InputError(
            f"strokes are {narrow:.2g} mm wide at --size {em_mm:g}, {what} {finest:.2g} mm; "
            f"expected wider ones: --size {np.ceil(_ROUNDED * em_mm * finest / narrow):g}{more}"
        )
    if wide > _TOO_WIDE * most:
        raise InputError(
            f"strokes are {wide:.2g} mm wide at --size {em_mm:g}, the brush {brush.name} at its "
            f"full press {most:.2g} mm; expected a larger brush, or --size "
            f"{np.floor(em_mm * most / wide / _ROUNDED):g}"
        )


def _width(stroke: GlyphStroke) -> float:
    """Mean width of a stroke, glyph units."""
    rings = (stroke.outline, *stroke.holes)
    areas = [_area(ring) for ring in rings]
    length = float(np.linalg.norm(np.diff(stroke.median, axis=0), axis=1).sum())
    area = max(areas[0] - sum(areas[1:]), 0.0)
    return area / max(length + 0.25 * math.sqrt(area), 1e-9)


def _area(ring: AnyArray) -> float:
    x, y = ring.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

"""A page in the pixels of a photographed sheet, or of a raster as fine as it needs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import EM_UNITS, GlyphStroke
from paint3d.calligraphy.page.page import Page
from paint3d.core.arrays import AnyArray

__all__ = ["FlatPage", "on_sheet"]

_PIXELS_PER_EM = 400.0
_MOST_PIXELS = 16e6  # of a page of many characters
_MARGIN = 0.1  # ems around the ink


@dataclass(frozen=True, eq=False)
class FlatPage:
    """A page drawn flat.

    Attributes
    ----------
    page : Page
    size : (int, int)
        Height and width, pixels.
    per_unit : float
        Pixels to a glyph unit; the unit (x, y) of the page lies at pixel
        per_unit * (x, -y) + origin.
    origin : (2,) float64
        Pixels.
    """

    page: Page
    size: tuple[int, int]
    per_unit: float
    origin: NDArray[np.float64]

    @classmethod
    def of(cls, page: Page) -> FlatPage:
        """A page that was found on no photograph, as large as its ink."""
        low, high = cls(page, (1, 1), 1.0, np.zeros(2)).ink_bounds
        margin = _MARGIN * EM_UNITS
        wide, tall = high - low + 2.0 * margin
        per_unit = min(_PIXELS_PER_EM / EM_UNITS, math.sqrt(_MOST_PIXELS / (wide * tall)))
        size = round(per_unit * tall), round(per_unit * wide)
        return cls(page, size, per_unit, per_unit * (margin - low))

    @property
    def strokes(self) -> list[GlyphStroke]:
        """Strokes of all pieces, in writing order, glyph units."""
        return [stroke for piece in self.page.pieces for stroke in piece.glyph.strokes]

    @property
    def ink_bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The box around all strokes, in pixels: upper left (2,), lower right (2,)."""
        points = np.concatenate([stroke.outline for stroke in self.drawn()])
        return points.min(axis=0), points.max(axis=0)

    def drawn(self) -> list[GlyphStroke]:
        """Strokes of all pieces in pixels of the page, y down."""
        drawn = []
        for piece in self.page.pieces:
            there = self.origin + self.per_unit * _flip(np.array(piece.at) - piece.glyph.middle)
            drawn += [on_sheet(stroke, self.per_unit, there) for stroke in piece.glyph.strokes]
        return drawn


def on_sheet(stroke: GlyphStroke, per_unit: float, origin: AnyArray) -> GlyphStroke:
    """A stroke in pixels of a sheet, y down; see `FlatPage`."""
    return stroke.mapped(lambda points: per_unit * _flip(points) + origin)


def _flip(points: AnyArray) -> NDArray[np.float64]:
    flipped: NDArray[np.float64] = points * np.array([1.0, -1.0])
    return flipped

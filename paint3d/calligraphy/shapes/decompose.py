"""Taking an ink shape apart into strokes, each with its region and its centre line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from paint3d.calligraphy.glyphs import Glyph, GlyphStroke

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = ["decompose"]


def decompose(outline: MultiPolygon, *, template: Glyph | None = None) -> list[GlyphStroke]:
    """The strokes that an ink shape is made of, in order and direction of writing.

    Parameters
    ----------
    outline : shapely.MultiPolygon
        Any unit, y upwards.
    template : Glyph, optional
        The strokes of the character where it is known, in any frame: their order and direction
        are carried onto the shape.

    Returns
    -------
    list of GlyphStroke
        In the frame of the outline. Their regions together are the shape.
    """
    parts = sorted(outline.geoms, key=lambda part: (part.bounds[0], -part.bounds[3]))
    return [_whole(part) for part in parts]


def _whole(part: Polygon) -> GlyphStroke:
    """A polygon as one stroke along its longest axis."""
    outer = np.asarray(part.exterior.coords)[:-1]
    middle = outer.mean(axis=0)
    way = np.linalg.svd(outer - middle, full_matrices=False)[2][0]
    along = (outer - middle) @ way
    ends = 0.9 * np.array([[along.min()], [along.max()]])
    holes = tuple(np.asarray(ring.coords)[:-1] for ring in part.interiors)
    return GlyphStroke(outer, middle + ends * way, holes)

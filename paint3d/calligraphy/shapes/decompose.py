"""Taking an ink shape apart into strokes, each with its region and its centre line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.shapes.continuation import chains_of
from paint3d.calligraphy.shapes.corners import cut_at_corners
from paint3d.calligraphy.shapes.regions import Ink, Piece, piece_of, shared_out
from paint3d.calligraphy.shapes.skeleton import skeleton_of
from paint3d.calligraphy.shapes.triangles import mean_width, triangulate
from paint3d.calligraphy.shapes.writing_order import in_writing_order
from paint3d.errors import InputError

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = ["decompose"]

_SPECK = 0.01  # squares of the mean width: smaller parts are no strokes


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
        In the frame of the outline. Their regions together are the shape, but for specks of less
        than a hundredth of the square of a stroke's mean width.

    Raises
    ------
    InputError
        If the outline has no area.
    """
    parts = _parts(outline)
    pieces = [piece for part in parts for piece in _pieces_of(part)]
    return [_stroke(piece) for piece in in_writing_order(pieces)]


def _parts(outline: MultiPolygon) -> list[Polygon]:
    """The connected polygons of a shape without specks, from the left, then from the top."""
    import shapely

    valid = outline if shapely.is_valid(outline) else outline.buffer(0.0)
    parts = [part for part in shapely.get_parts(valid) if part.area > 0.0]
    if not parts:
        raise InputError("the outline has no area; expected a shape to fill")
    least = _SPECK * mean_width(valid) ** 2
    kept = [part for part in parts if part.area >= least]
    return sorted(kept, key=lambda part: (part.bounds[0], -part.bounds[3], part.area))


def _pieces_of(part: Polygon) -> list[Piece]:
    """The strokes of one connected shape."""
    triangles = triangulate(part)
    ink = Ink(triangles, skeleton_of(triangles))
    cut_at_corners(ink.skeleton, triangles, ink.half_widths)
    chains = chains_of(ink.skeleton, ink.half_widths)
    if not chains:
        return [Piece(_axis(ink), part)]
    return shared_out([piece_of(chain, ink) for chain in chains], ink)


def _axis(ink: Ink) -> NDArray[np.float64]:
    """A line along a dot, half a width from both its ends."""
    import shapely

    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(ink.shape))
    sides = np.diff(corners[:3], axis=0)
    sizes = np.linalg.norm(sides, axis=1)
    long = int(np.argmax(sizes))
    junction = next(iter(ink.skeleton.junctions.values()))
    reach = max(0.5 * (sizes[long] - sizes[1 - long]), 0.25 * junction.radius)
    way = sides[long] / sizes[long]
    line = shapely.LineString([junction.point - reach * way, junction.point + reach * way])
    inside = line.intersection(ink.shape)
    longest = max(shapely.get_parts(inside), key=lambda part: part.length)
    return np.array(longest.coords)


def _stroke(piece: Piece) -> GlyphStroke:
    """A piece as a stroke: rings without their last point."""
    region = piece.region
    rings = [np.array(ring.coords)[:-1] for ring in (region.exterior, *region.interiors)]
    return GlyphStroke(rings[0], piece.line, tuple(rings[1:]))

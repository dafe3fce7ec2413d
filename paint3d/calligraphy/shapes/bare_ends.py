"""Stubs of a bold stroke's region that its line does not reach: short strokes of their own.

What sticks out of a junction by less than its radius is taken for a corner, and belongs to the
stroke that goes by: the left arm of an f's bar, the head of an n's stem. In thin script that is
right; in bold script it is as wide as a stroke, and nothing that follows the line can fill it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from paint3d.calligraphy.glyphs import GlyphStroke
from paint3d.calligraphy.page.ink import polygons_of, rings_of
from paint3d.core.arrays import AnyArray

if TYPE_CHECKING:
    from shapely import LineString, Polygon

__all__ = ["with_stubs"]

_STATIONS = 48  # along a line, where the widest disc is asked for
_LEAST_RADIUS = 0.42  # of the half width there: a smaller rest is a corner (a square's: .17)
_LEAST_AREA = 0.25  # of the square of the width there
_OVERLAP = 0.8  # half widths that a stub reaches back into its stroke
_FROM_EDGE = 0.5  # half widths: a stub's line from the ends of its region
_TOLERANCE = 0.02
_INSET, _SHORTEST = 0.05, 0.3  # half widths: a line from its region's edge, and its length


def with_stubs(strokes: Sequence[GlyphStroke], bold: float) -> list[GlyphStroke]:
    """Strokes, each that is bold followed by what of its region its line does not reach.

    Parameters
    ----------
    strokes : sequence of GlyphStroke
    bold : float
        Width from which on a stroke is, in the strokes' unit.
    """
    found: list[GlyphStroke] = []
    for stroke in strokes:
        found.append(stroke)
        found.extend(_stubs(stroke, bold))
    return found


def _stubs(stroke: GlyphStroke, bold: float) -> list[GlyphStroke]:
    """Short strokes outwards from a line that would leave parts of its region bare."""
    import shapely

    line = shapely.LineString(stroke.median)
    region = shapely.Polygon(stroke.outline, stroke.holes)
    if line.length == 0.0 or not region.is_valid:
        return []
    stations = [line.interpolate(t, normalized=True) for t in np.linspace(0.0, 1.0, _STATIONS)]
    radii = shapely.distance(region.boundary, stations)
    half = float(np.median(radii))
    if 2.0 * half < bold:
        return []
    discs = shapely.buffer(stations, radii + _TOLERANCE * half)
    swept = shapely.union_all([shapely.union(a, b).convex_hull for a, b in pairwise(discs)])
    stubs = []
    for part in polygons_of(region.difference(swept)):
        near = line.project(part.centroid, normalized=True) * (_STATIONS - 1)
        there = max(half, float(radii[round(near)]))
        radius = float(shapely.length(shapely.maximum_inscribed_circle(part)))
        if radius > _LEAST_RADIUS * there and part.area > _LEAST_AREA * (2.0 * there) ** 2:
            stubs.append(_stub(part, region, line, half))
    return [stub for stub in stubs if stub is not None]


def _stub(part: Polygon, region: Polygon, line: LineString, half: float) -> GlyphStroke | None:
    """A stroke from the far end of a bare part into the stroke that it sticks out of."""
    import shapely

    middle = np.array(part.centroid.coords[0])
    root = np.array(line.interpolate(line.project(part.centroid)).coords[0])
    way = _direction(root - middle)
    own = part.buffer(_OVERLAP * half).intersection(region)
    own = max(polygons_of(own), key=lambda one: one.area)
    along = (np.asarray(own.exterior.coords) - middle) @ way
    start, end = along.min() + _FROM_EDGE * half, along.max() - _FROM_EDGE * half
    straight = shapely.LineString([middle + start * way, middle + max(end, 0.0) * way])
    within = shapely.get_parts(straight.intersection(own.buffer(-_INSET * half)))
    longest = max(within, key=lambda one: one.length, default=None)
    if longest is None or not longest.length > _SHORTEST * half:
        return None
    ends = np.asarray(longest.coords)
    outer, holes = rings_of(own)
    return GlyphStroke(outer, np.linspace(ends[0], ends[-1], 9), tuple(holes))


def _direction(way: AnyArray) -> AnyArray:
    length = float(np.hypot(*way))
    return way / length if length > 0.0 else np.array([1.0, 0.0])

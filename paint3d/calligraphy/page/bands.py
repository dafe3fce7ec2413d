"""Areas that are wider than a brush: filled in bands side by side, as a painter does."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from paint3d.calligraphy.glyphs import EM_UNITS, GlyphStroke
from paint3d.calligraphy.page.page import polygons_of
from paint3d.core.arrays import AnyArray

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["WIDEST", "fill_in_bands", "is_wide"]

WIDEST = 0.16 * EM_UNITS
"""Units: what a brush that suits the size fills with one stroke."""

_OVERLAP = 0.12  # of a band's width, on either side
_MOSTLY = 75.0  # per cent of the line along which a stroke may be as wide as that
_STATIONS = 24
_LEAST_AREA = 0.02  # of a square as wide as a band: what is left of it is not painted


def is_wide(stroke: GlyphStroke) -> bool:
    """Return whether most of a stroke is wider than a brush fills at once."""
    from shapely import LineString, MultiLineString, points

    rings = (stroke.outline, *stroke.holes)
    edge = MultiLineString([np.concatenate([ring, ring[:1]]) for ring in rings])
    line = LineString(stroke.median)
    at = points(
        [line.interpolate(t, normalized=True).coords[0] for t in np.linspace(0.1, 0.9, _STATIONS)]
    )
    return 2.0 * float(np.percentile([edge.distance(one) for one in at], _MOSTLY)) > WIDEST


def fill_in_bands(area: Polygon) -> list[GlyphStroke]:
    """Bands along the longest side of an area, from its upper left, that overlap a little.

    Parameters
    ----------
    area : shapely.Polygon
        Glyph units, with its holes.
    """
    from shapely import box, transform

    turn = _longest_axis(area)
    lying = transform(area, lambda points: points @ turn.T)
    left, lower, right, upper = lying.bounds
    n = max(1, math.ceil((upper - lower) / (0.8 * WIDEST)))
    width = (upper - lower) / n
    strokes = []
    for k in range(n):
        top = upper - k * width + _OVERLAP * width * (k > 0)
        bottom = upper - (k + 1) * width - _OVERLAP * width * (k < n - 1)
        parts = polygons_of(lying.intersection(box(left, bottom, right, top)))
        for part in sorted(parts, key=lambda part: part.bounds[0]):
            if part.area > _LEAST_AREA * width**2:
                strokes.append(_make_band(part, turn))
    return strokes


def _longest_axis(area: Polygon) -> AnyArray:
    """The rotation (2, 2) that lays the longest side of an area along x."""
    corners = np.asarray(area.minimum_rotated_rectangle.exterior.coords)
    sides = np.diff(corners[:3], axis=0)
    direction = sides[int(np.argmax(np.linalg.norm(sides, axis=1)))]
    direction = direction / np.linalg.norm(direction)
    if direction[0] - direction[1] < 0.0:  # to the right and downwards
        direction = -direction
    return np.array([direction, [-direction[1], direction[0]]])


def _make_band(part: Polygon, turn: AnyArray) -> GlyphStroke:
    """Make a band a stroke through the middles of its sections."""
    from shapely import LineString

    left, lower, right, upper = part.bounds
    inset = min(0.5 * (upper - lower), 0.25 * (right - left))
    line = []
    for x in np.linspace(left + inset, right - inset, _STATIONS):
        section = part.intersection(LineString([(x, lower - 1.0), (x, upper + 1.0)]))
        if not section.is_empty:
            line.append((x, section.centroid.y))
    return GlyphStroke.filling(part, np.array(line)).mapped(lambda points: points @ turn)

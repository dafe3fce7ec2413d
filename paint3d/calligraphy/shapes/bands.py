"""Areas wider than the brush, divided into bands that it fills one beside the other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from paint3d.calligraphy.shapes.regions import Piece

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["bands_of", "is_wide"]

_USUAL = 75.0  # percentile of the widths along a stroke that must be within the brush's
_BAND = 0.8  # of the widest footprint
_OVERLAP = 0.12  # of a band


def is_wide(piece: Piece, widest: float) -> bool:
    """Whether most of a stroke is wider than a brush."""
    import shapely

    points = shapely.points(piece.line)
    widths = 2.0 * shapely.distance(points, piece.region.boundary)
    return float(np.percentile(widths, _USUAL)) > widest


def bands_of(piece: Piece, widest: float) -> list[Polygon]:
    """Polygons along the longest side of a stroke's region, which overlap a little.

    Parameters
    ----------
    piece : Piece
    widest : float
        Width of the brush's widest footprint; a band has 0.8 of it.
    """
    import shapely

    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(piece.region))[:4]
    sides = np.diff(corners[:3], axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    across = int(np.argmin(lengths))
    n = math.ceil(lengths[across] / (_BAND * widest * (1.0 - _OVERLAP)))
    origin = corners[0]
    along, step = sides[1 - across], sides[across] / n
    more = 0.5 * _OVERLAP * step
    parts = []
    for k in range(n):
        low = origin + k * step - (more if k > 0 else 0.0)
        high = origin + (k + 1) * step + (more if k + 1 < n else 0.0)
        band = shapely.Polygon([low, low + along, high + along, high])
        shapes = shapely.get_parts(piece.region.intersection(band))
        parts += [part for part in shapes if part.geom_type == "Polygon" and part.area > 0.0]
    return parts

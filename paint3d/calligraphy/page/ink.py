"""Ink shapes: closed curves filled by a rule, as polygons with holes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

if TYPE_CHECKING:
    from shapely import Geometry, MultiPolygon, Polygon

__all__ = ["as_multipolygon", "bezier_points", "fill_rings", "polygons_of", "rings_of"]

_LEAST_SHARE = 1e-5  # of the largest polygon's area: smaller ones are dust of the arithmetic


def bezier_points(controls: AnyArray, flatness: float) -> NDArray[np.float64]:
    """Points (N, 2) of a Bezier curve after its start, no farther from it than `flatness`.

    Parameters
    ----------
    controls : (2..4, 2) float64
        Its control points, the start first: a line, or a quadratic or cubic curve.
    flatness : float
        In their unit.
    """
    hull: list[AnyArray] = list(np.asarray(controls, np.float64))
    degree = len(hull) - 1
    if degree < 2:
        return np.array(hull[1:])
    bend = np.linalg.norm(np.diff(np.array(hull), n=2, axis=0), axis=1).max()
    n = int(min(max(1.0, np.ceil(np.sqrt(degree * (degree - 1) * bend / (8.0 * flatness)))), 500))
    t = np.linspace(0.0, 1.0, n + 1)[1:, None]
    while len(hull) > 1:
        hull = [(1.0 - t) * a + t * b for a, b in pairwise(hull)]
    result: NDArray[np.float64] = hull[0]
    return result


def fill_rings(rings: Sequence[AnyArray], *, even_odd: bool = False) -> MultiPolygon:
    """What closed curves enclose, by how often each place is gone around.

    Parameters
    ----------
    rings : sequence of (N, 2) float64
        They may cross themselves and each other.
    even_odd : bool
        Ink is where the number of turns is odd; without it, where it is not zero.
    """
    from shapely import LineString, MultiPolygon, unary_union
    from shapely.ops import polygonize

    closed = [np.concatenate([ring, ring[:1]]) for ring in rings if len(ring) > 2]
    if not closed:
        return MultiPolygon()
    faces = list(polygonize(unary_union([LineString(ring) for ring in closed])))
    if not faces:
        return MultiPolygon()
    inside = np.array([face.representative_point().coords[0] for face in faces])
    turns = np.sum([_turns(ring, inside) for ring in closed], axis=0)
    inked = turns % 2 != 0 if even_odd else turns != 0
    return as_multipolygon(
        unary_union([face for face, ink in zip(faces, inked, strict=True) if ink])
    )


def _turns(ring: AnyArray, points: AnyArray) -> NDArray[np.int64]:
    """How often a closed ring (N, 2) goes around each of some points (M, 2), counter-clockwise."""
    a, b = ring[:-1, None], ring[1:, None]
    side = (b[..., 0] - a[..., 0]) * (points[:, 1] - a[..., 1])
    side -= (points[:, 0] - a[..., 0]) * (b[..., 1] - a[..., 1])
    below_a, below_b = a[..., 1] <= points[:, 1], b[..., 1] <= points[:, 1]
    up, down = below_a & ~below_b & (side > 0.0), ~below_a & below_b & (side < 0.0)
    result: NDArray[np.int64] = up.sum(axis=0) - down.sum(axis=0)
    return result


def polygons_of(shape: Geometry) -> list[Polygon]:
    """The polygons of a shape that have an area, without lines, points and dust."""
    from shapely import Polygon

    parts = [part for part in getattr(shape, "geoms", [shape]) if isinstance(part, Polygon)]
    least = _LEAST_SHARE * max((part.area for part in parts), default=0.0)
    return [part for part in parts if part.area > least]


def as_multipolygon(shape: Geometry) -> MultiPolygon:
    """A shape as polygons."""
    from shapely import MultiPolygon

    return MultiPolygon(polygons_of(shape))


def rings_of(polygon: Polygon) -> tuple[NDArray[np.float64], Iterable[NDArray[np.float64]]]:
    """The outer ring (N, 2) and the holes of a polygon; the last point is not the first again."""
    outer = np.asarray(polygon.exterior.coords, np.float64)[:-1]
    return outer, tuple(np.asarray(ring.coords, np.float64)[:-1] for ring in polygon.interiors)

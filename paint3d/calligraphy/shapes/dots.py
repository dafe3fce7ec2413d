"""Dots: shapes too compact to have a direction of their own, alone or run together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.shapes.regions import Ink, InkStroke
from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import line_length

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["as_dot", "dot_among", "find_dots"]

_COMPACT = 0.75  # of a disc's area at the same perimeter: a dot; a square has 0.785
_SHORTEST = 1.0  # of a dot's width: its line; shorter, two crescents of a round one stay bare
_ROUND = 1.1  # times as long as wide: a dot that is drawn level
_SQUARE = 0.88  # of a disc's area: what is less compact has corners; a hexagon has 0.907
_INTO_CORNERS = 0.9  # of its diagonal: the line of a square dot
_FALL = 0.02  # by how much a rising diagonal must be longer than a falling one
_WAIST = 0.6  # of a dot's width: where they run together they are narrower
_OVERLAP = 0.35  # of a dot's half width, that two reach into each other at their waist
_POINT = 0.2  # of a character's size: a shorter stroke of it is a dot
_SMALL = 0.5  # of the area of its largest part, at most, that of a dot
_LOOSE = 0.22  # as compact as four squares in a row, which would be 0.31 if they shared no side


def find_dots(ink: Ink) -> list[InkStroke]:
    """The dots that a shape is, each with its line; none where it is no dot.

    Dots that run together at a narrow waist, as the two of an Arabic letter do, are each one: a
    single line through all of them would leave their outer corners bare.
    """
    if ink.shape.interiors:
        return []
    compact = _compactness(ink.shape)
    if compact > _COMPACT:
        return [as_dot(ink.shape)]
    return _part_at_waists(ink) if compact > _LOOSE else []


def _compactness(shape: Polygon) -> float:
    """Its area over that of a disc of the same perimeter."""
    return 4.0 * math.pi * float(shape.area) / float(shape.length) ** 2


def _part_at_waists(ink: Ink) -> list[InkStroke]:
    """A shape divided at its waists, if all its parts are dots; else nothing.

    Every triangle goes to the core that is nearest: what is left of the shape without a rim that
    is as deep as a waist may be.
    """
    import shapely

    shape = ink.shape
    corners = ink.triangles.points[ink.triangles.corners]
    deepest = float(shapely.maximum_inscribed_circle(shape).length)  # the circle's radius
    cores = shapely.get_parts(shape.buffer(-_WAIST * deepest))
    if len(cores) < 2:
        return []
    middles = shapely.points(corners.mean(axis=1))
    nearest = np.argmin([shapely.distance(middles, core) for core in cores], axis=0)
    cells = [np.flatnonzero(nearest == k) for k in range(len(cores))]
    parts = [ink.triangles.region(mine) for mine in cells if len(mine)]
    are_dots = all(one.geom_type == "Polygon" and _compactness(one) > _COMPACT for one in parts)
    if not are_dots:
        return []
    pieces = []
    for one in parts:
        large = one.buffer(_OVERLAP * deepest, join_style="mitre").intersection(shape)
        whole = max(shapely.get_parts(large), key=shapely.area)  # a dot across a gap is another's
        pieces.append(InkStroke(as_dot(one).line, whole))
    return pieces


def dot_among(parts: Sequence[Polygon], lines: Sequence[AnyArray]) -> dict[int, int]:
    """Part of a shape that is the dot of a known character, with its stroke's number.

    Of two parts it is the smaller one, wherever it lies: an i's dot is the second stroke however
    far from its stem it is. Nothing where the character has no dot, or more strokes than two: a
    part may be several of these, as the man of 偶, whose dot touches what is beside it; and nothing
    where neither part is small.

    Parameters
    ----------
    parts : sequence of shapely.Polygon
    lines : sequence of (N, 2) float64
        The character's strokes, in any frame.
    """
    size = float(np.ptp(np.concatenate(lines), axis=0).max())
    dots = [k for k, line in enumerate(lines) if line_length(line) < _POINT * size]
    if len(parts) != 2 or len(lines) != 2 or len(dots) != 1:
        return {}
    small, large = sorted((0, 1), key=lambda k: float(parts[k].area))
    return {small: dots[0]} if parts[small].area < _SMALL * parts[large].area else {}


def as_dot(shape: Polygon) -> InkStroke:
    """A dot with its line.

    A square one is written from corner to corner, which leaves the least of its corners bare; what
    has no corners along it, half a width from both its ends, or level where it is round.
    """
    import shapely

    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shape))
    sides = np.diff(corners[:3], axis=0)
    sizes = np.linalg.norm(sides, axis=1)
    long = int(np.argmax(sizes))
    if _COMPACT < _compactness(shape) < _SQUARE:
        direction, reach = _longest_diagonal(shape)
    else:
        is_round = bool(sizes[long] < _ROUND * sizes[1 - long])
        direction = np.array([1.0, 0.0]) if is_round else sides[long] / sizes[long]
        reach = max(sizes[long] - sizes[1 - long], _SHORTEST * sizes[1 - long])
    middle = shape.centroid
    middle = middle if shape.contains(middle) else shape.representative_point()
    centre = np.array(middle.coords[0])
    line = shapely.LineString([centre - 0.5 * reach * direction, centre + 0.5 * reach * direction])
    inside = line.intersection(shape)
    longest = max(shapely.get_parts(inside), key=lambda part: part.length)
    return InkStroke(np.array(longest.coords), shape)


def _longest_diagonal(shape: Polygon) -> tuple[NDArray[np.float64], float]:
    """The vector between the corners that are farthest apart, downwards if possible; its length."""
    import shapely

    rim = shapely.get_coordinates(shape.convex_hull)
    diagonals = rim[None] - rim[:, None]
    apart = np.hypot(diagonals[..., 0], diagonals[..., 1])
    falls = diagonals[..., 0] * diagonals[..., 1] < 0.0
    from_there, to = np.unravel_index(np.argmax(apart * (1.0 + _FALL * falls)), apart.shape)
    direction, size = diagonals[from_there, to], float(apart[from_there, to])
    return direction / size * (1.0 if direction[0] >= 0.0 else -1.0), _INTO_CORNERS * size

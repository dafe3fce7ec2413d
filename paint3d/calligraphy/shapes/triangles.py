"""A shape as triangles between its edges, and which of them lie beside which.

The edges are sampled so closely that a triangle reaches across the stroke it lies in: those with
one neighbour end a stroke, those with two lie along it, and where three meet, strokes do (the
chordal axis of Prasad, 1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray

if TYPE_CHECKING:
    from shapely import Polygon, STRtree

__all__ = ["Triangles", "triangulate"]

_SAMPLES = 8.0  # of the edge, to a stroke's width
_MOST_SAMPLES = 20_000
_ROUNDED = 1e-12  # by how much of it a distance may be off


@dataclass(frozen=True, eq=False)
class Triangles:
    """A constrained Delaunay triangulation of a polygon with holes.

    Attributes
    ----------
    shape : shapely.Polygon
        What is triangulated, with its sampled edges.
    points : (P, 2) float64
    corners : (T, 3) int64
    neighbours : (T, 3) int64
        The triangle beyond the edge from corner k to corner k + 1, -1 where the shape ends.
    """

    shape: Polygon
    points: NDArray[np.float64]
    corners: NDArray[np.int64]
    neighbours: NDArray[np.int64]

    def degrees(self) -> NDArray[np.int64]:
        """Number of neighbours of each (T,)."""
        result: NDArray[np.int64] = (self.neighbours >= 0).sum(axis=1)
        return result

    @cached_property
    def beyond(self) -> list[list[int]]:
        """The neighbours as lists, which are walked in a third of the time."""
        rows: list[list[int]] = self.neighbours.tolist()
        return rows

    def edge(self, triangle: int, k: int) -> NDArray[np.float64]:
        """Corner k of a triangle and the next (2, 2)."""
        result: NDArray[np.float64] = self.points[self.corners[triangle, [k, (k + 1) % 3]]]
        return result

    @cached_property
    def middles_of_edges(self) -> NDArray[np.float64]:
        """Half-way between corner k of each triangle and the next (T, 3, 2)."""
        corners = self.points[self.corners]
        result: NDArray[np.float64] = (corners + np.roll(corners, -1, axis=1)) / 2.0
        return result

    def middle(self, triangle: int) -> NDArray[np.float64]:
        """The circumcentre; of an obtuse triangle the middle of its longest edge."""
        corners = self.points[self.corners[triangle]]
        edges = np.roll(corners, -1, axis=0) - corners
        squares = np.sum(edges**2, axis=1)
        longest = int(np.argmax(squares))
        if 2.0 * squares[longest] >= squares.sum():
            result: NDArray[np.float64] = self.middles_of_edges[triangle, longest]
            return result
        # barycentric coordinates of the circumcentre, by the edges opposite to the corners
        opposite = np.roll(squares, -1)
        weights = opposite * (squares.sum() - 2.0 * opposite)
        result = weights @ corners / weights.sum()
        return result

    @cached_property
    def _edge_index(self) -> tuple[NDArray[np.object_], STRtree]:
        """The edge's segments, and a tree that finds the nearest of them."""
        import shapely

        rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(self.shape)]
        segments = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
        lines = shapely.linestrings(segments)
        return lines, shapely.STRtree(lines)

    def to_edge(self, points: AnyArray) -> NDArray[np.float64]:
        """Distances of points (N, 2) to the edge."""
        import shapely

        lines, tree = self._edge_index
        positions = shapely.points(points)
        result: NDArray[np.float64] = shapely.distance(positions, lines[tree.nearest(positions)])
        reach = (1.0 + _ROUNDED) * result  # of some that are as near, the tree takes any
        which, near = tree.query(positions, predicate="dwithin", distance=reach)
        np.minimum.at(result, which, shapely.distance(positions[which], lines[near]))
        return result

    def region(self, triangles: AnyArray | list[int]) -> Polygon:
        """The union of some triangles."""
        import shapely

        corners = self.points[self.corners[np.asarray(triangles, np.int64)]]
        rings = np.concatenate([corners, corners[:, :1]], axis=1)
        return shapely.coverage_union_all(shapely.polygons(rings))


def triangulate(shape: Polygon) -> Triangles:
    """Sample the edges of a polygon and divide it into triangles."""
    import shapely

    perimeter = float(shape.length)
    mean_width = 2.0 * float(shape.area) / perimeter  # of its strokes
    step = max(mean_width / _SAMPLES, perimeter / _MOST_SAMPLES)
    dense = shapely.segmentize(shape, step)
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(dense))
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    points, index = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    return Triangles(dense, points, index, _neighbours(index))


def _neighbours(corners: AnyArray) -> NDArray[np.int64]:
    ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    same = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    one, two = order[:-1][same], order[1:][same]
    beyond = np.full(len(ends), -1, np.int64)
    beyond[one], beyond[two] = two // 3, one // 3
    return beyond.reshape(-1, 3)

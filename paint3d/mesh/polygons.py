"""Polygons to triangles: fans where they are right, ear clipping where a corner points inwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.core.polyline import cross_2d
from paint3d.errors import MeshError

__all__ = ["face_normals", "grid_faces", "triangulate"]

MAX_CORNERS = 100_000
MAX_CONCAVE_CORNERS = 5_000  # ear clipping takes quadratic time: 5,000 corners are about a second
MAX_EAR_TESTS = 100_000  # of about 20 us each: corners looked at in one polygon
MAX_FORCED_CUTS = 10  # where an outline crosses itself; after that no cut is better than a fan
SAME_AREA = 1e-6
ROUNDING = 1e-12  # of coordinates, in the extent of the polygon


def grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    """Triangles (F, 3) of a grid of points, numbered row by row; they face up where rows go up."""
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    return np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])


def face_normals(corners: AnyArray) -> NDArray[np.float64]:
    """Unit normals (F, 3) of triangles by their corners (F, 3, 3); 0 for those without area."""
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(crossed, axis=1, keepdims=True)
    normals: NDArray[np.float64] = crossed / np.maximum(lengths, 1e-300)
    return normals


def triangulate(
    vertices: NDArray[np.float64], corners: NDArray[np.int64], sizes: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the triangles of polygons, in the polygons' order and with their orientation.

    A polygon without inward corners becomes a fan from its first corner; one with inward corners
    is cut by ear clipping as seen along its Newell normal, so that no triangle lies outside it.
    Where it is not flat, or crosses itself, the fan may have less area, and is taken.
    Polygons of fewer than three corners have no area and are left out.

    Parameters
    ----------
    vertices : (V, 3) float64
    corners : (N,) int64
        Vertex indices of all polygons, one after the other; within 0 to V - 1.
    sizes : (P,) int64
        Number of corners of each polygon; their sum is N.

    Returns
    -------
    (F, 3) int64

    Raises
    ------
    MeshError
        If a polygon has more than 100,000 corners, or an inward-pointing one more than 5,000.
    """
    if len(sizes) == 0:
        return np.empty((0, 3), np.int64)
    if sizes.max() > MAX_CORNERS:
        which = int(sizes.argmax())
        raise MeshError(
            "face {which} has {sizes:,} corners; expected at most {most:,}",
            which=which,
            sizes=sizes[which],
            most=MAX_CORNERS,
        )
    if (sizes == 3).all():
        return corners.reshape(-1, 3)
    n_triangles = np.maximum(sizes - 2, 0)
    first_corner = np.cumsum(sizes) - sizes
    first_triangle = np.cumsum(n_triangles) - n_triangles
    faces = np.empty((int(n_triangles.sum()), 3), np.int64)
    for size in np.unique(sizes[sizes >= 3]).tolist():
        rows = np.flatnonzero(sizes == size)
        polygons = corners[first_corner[rows, None] + np.arange(size)]
        cut = _fans(polygons)
        if size > 3:
            for k in np.flatnonzero(_is_concave(vertices, polygons)):
                cut[k] = _choose_smaller(
                    vertices, cut[k], _clip_ears(vertices[polygons[k]], polygons[k])
                )
        faces[first_triangle[rows, None] + np.arange(size - 2)] = cut
    return faces


def _fans(polygons: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return (P, n - 2, 3) triangles of (P, n) polygons."""
    first = np.broadcast_to(polygons[:, :1], (len(polygons), polygons.shape[1] - 2))
    return np.stack([first, polygons[:, 1:-1], polygons[:, 2:]], axis=2)


def _choose_smaller(
    vertices: NDArray[np.float64], fan: NDArray[np.int64], ears: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the triangles of less area: those outside a polygon, or folded back, add to it.

    For a flat outline that does not cross itself no triangles have less than the ears.
    """
    fan_area, ears_area = (
        np.linalg.norm(np.cross(one[:, 1] - one[:, 0], one[:, 2] - one[:, 0]), axis=1).sum()
        for one in (vertices[fan], vertices[ears])
    )
    return fan if fan_area < (1.0 - SAME_AREA) * ears_area else ears


def _is_concave(vertices: NDArray[np.float64], polygons: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which of the polygons (P, n) have a corner that points inwards."""
    points = vertices[polygons]
    points = points - points[:, :1]
    following = np.roll(points, -1, axis=1)
    newell = np.cross(points, following).sum(axis=1)
    turn = np.cross(points - np.roll(points, 1, axis=1), following - points)
    inward = np.einsum("pnk,pk->pn", turn, newell)
    tolerance = 1e-9 * np.einsum("pk,pk->p", newell, newell)
    result: NDArray[np.bool_] = (inward < -tolerance[:, None]).any(axis=1)
    return result


def _clip_ears(points: NDArray[np.float64], ids: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the (n - 2, 3) triangles of one polygon with corners at `points` (n, 3)."""
    if len(ids) > MAX_CONCAVE_CORNERS:
        raise MeshError(
            "a face with inward corners has {n:,} of them; expected at most {most:,}",
            n=len(ids),
            most=MAX_CONCAVE_CORNERS,
        )
    flat = _flatten(points)
    rounding = ROUNDING * float(np.ptp(flat, axis=0).max()) ** 2
    left = np.arange(len(ids))
    faces, at, misses, tests, forced = [], 0, 0, 0, 0
    while len(left) > 3 and forced <= MAX_FORCED_CUTS:
        n = len(left)
        trio = left[[at - 1, at % n, (at + 1) % n]]
        tests += 1
        if tests > MAX_EAR_TESTS:
            raise MeshError(
                "a face with {n:,} corners is too tangled to be cut into triangles; expected a "
                "simpler outline",
                n=len(ids),
            )
        near = (
            rounding if misses <= n else -rounding
        )  # in a second round what nearly touches passes
        crossing = misses > 2 * n  # such outlines have no ear: cut anyway
        if crossing or _is_ear(flat, trio, left, near):
            forced += crossing
            faces.append(trio)
            left = np.delete(left, at % n)
            at, misses = at % (n - 1), 0
        else:
            at, misses = (at + 1) % n, misses + 1
    faces.extend(_fans(left[None])[0])
    return ids[np.array(faces)]


def _flatten(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners as seen along the Newell normal, (n, 2), counter-clockwise.

    They are projected along it onto the coordinate plane most nearly perpendicular to it, so
    that nothing is rounded where it is an axis. Dropping the third coordinate would do only for
    flat outlines: seen along an axis, a twisted one may turn inward corners outwards.
    """
    points = points - points.mean(axis=0)
    newell = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    drop = int(np.abs(newell).argmax())
    axes = [(drop + 1) % 3, (drop + 2) % 3]
    if newell[drop] < 0.0:
        axes.reverse()
    lean = newell[axes] / newell[drop] if newell[drop] else np.zeros(2)
    flat: NDArray[np.float64] = points[:, axes] - points[:, drop, None] * lean
    return flat


def _is_ear(
    flat: NDArray[np.float64], trio: NDArray[np.int64], left: NDArray[np.int64], near: float
) -> bool:
    """Return whether the line that cuts off three consecutive corners stays inside the polygon.

    Any other corner left in their triangle, or outside it by less than `near` (twice the area with
    that side), prevents it.
    """
    a, b, c = flat[trio]
    if cross_2d(b - a, c - b) <= max(near, 0.0):
        return False
    others = flat[left]
    inside = cross_2d(b - a, others - a) >= -near
    inside &= cross_2d(c - b, others - b) >= -near
    inside &= cross_2d(a - c, others - c) >= -near
    in_the_way = others[inside]  # among them the three themselves, and what lies in their places
    return bool((in_the_way[:, None] == flat[trio]).all(axis=2).any(axis=1).all())

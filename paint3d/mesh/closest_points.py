"""Closest points and ray hits on a mesh, many at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from paint3d.core.arrays import as_array
from paint3d.core.types import AnyArray
from paint3d.mesh.base_surface import make_base_surface
from paint3d.mesh.bvh import build_box_tree
from paint3d.mesh.kernels.bvh import ContactTree
from paint3d.mesh.kernels.closest_points import FACES_PER_LEAF, find_closest, find_hits
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["ClosestPoints", "Found", "RayHits"]


class Found(NamedTuple):
    """N points on the surface."""

    points: AnyArray
    """(N, 3) float64, mm."""
    faces: AnyArray
    """(N,) int64."""
    barycentric: AnyArray
    """(N, 3) float64, weights of the face's corners."""
    normals: AnyArray
    """(N, 3) float64, unit; interpolated where the surface is smooth, not across its edges."""


class RayHits(NamedTuple):
    """First hits of N rays."""

    hit: AnyArray
    """(N,) bool."""
    distance: AnyArray
    """(N,) float64 in lengths of the ray's direction; inf where nothing is hit."""
    faces: AnyArray
    """(N,) int64, -1 where nothing is hit."""
    points: AnyArray
    """(N, 3) float64, mm; NaN where nothing is hit."""


class ClosestPoints:
    """Closest points and ray hits on one mesh; build once, query many times.

    Parameters
    ----------
    mesh : TriangleMesh

    Attributes
    ----------
    tree : ContactTree
        Of its triangles, in which the kernels search.

    Raises
    ------
    MeshError
        If no face has an area, or more triangles share one edge than can be painted on.

    Notes
    -----
    The answers are exact to float64's rounding and depend on the mesh and the question alone:
    of triangles that are equally near the first in the mesh counts. Triangles without area, which
    cannot be painted on, are passed over.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        base = make_base_surface(mesh)
        order, boxes, triangles = build_box_tree(
            base.points, base.faces, FACES_PER_LEAF, halve=True
        )
        faces = base.source_faces.astype(np.int32)[order]
        self.tree = ContactTree(faces, boxes, triangles, base.points, base.normals)

    def find(self, points: AnyArray) -> Found:
        """The closest point of the surface to each of `points` (N, 3), mm."""
        queries = as_array(points, "points", (None, 3))
        n = len(queries)
        there, normals, weights = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
        faces = np.empty(n, np.int64)
        if find_closest(self.tree, queries, there, faces, weights, normals):
            cancelled = ~normals.any(axis=1)
            normals[cancelled] = self.mesh.face_normals[faces[cancelled]]
        return Found(there, faces, weights, normals)

    def cast(self, origins: AnyArray, directions: AnyArray) -> RayHits:
        """The first hits of rays from `origins` (N, 3) along `directions` (N, 3)."""
        origins = as_array(origins, "origins", (None, 3))
        directions = as_array(directions, "directions", (len(origins), 3))
        distance, faces = np.empty(len(origins)), np.empty(len(origins), np.int64)
        find_hits(self.tree, np.concatenate([origins, directions], axis=1), distance, faces)
        hit = np.isfinite(distance)
        points = origins + np.where(hit, distance, np.nan)[:, None] * directions
        return RayHits(hit, distance, faces, points)

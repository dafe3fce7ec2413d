"""Closest points and ray hits on a mesh, many at a time (Open3D's ray casting scene)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.arrays import as_array
from paint3d.mesh.base_surface import make_base_surface
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["ClosestPoints", "Found", "RayHits"]


class Found(NamedTuple):
    """N points on the surface."""

    points: NDArray
    """(N, 3) float64, mm."""
    faces: NDArray
    """(N,) int64."""
    barycentric: NDArray
    """(N, 3) float64, weights of the face's corners."""
    normals: NDArray
    """(N, 3) float64, unit; interpolated where the surface is smooth, not across its edges."""


class RayHits(NamedTuple):
    """First hits of N rays."""

    hit: NDArray
    """(N,) bool."""
    distance: NDArray
    """(N,) float64 in lengths of the ray's direction; inf where nothing is hit."""
    faces: NDArray
    """(N,) int64, -1 where nothing is hit."""
    points: NDArray
    """(N, 3) float64, mm; NaN where nothing is hit."""


def _corner_normals(mesh: TriangleMesh) -> NDArray:
    """Normals (F, 3, 3) at the corners of faces, those that are painted with; edges stay edges."""
    base = make_base_surface(mesh)
    normals = np.repeat(mesh.face_normals[:, None, :].astype(np.float64), 3, axis=1)
    normals[base.source_faces] = base.normals[base.faces]
    return normals


class ClosestPoints:
    """Closest points and ray hits on one mesh; build once, query many times.

    Parameters
    ----------
    mesh : TriangleMesh

    Notes
    -----
    Open3D searches in float32: points are good to about 1e-7 of the mesh's distance from the
    origin. Faces without area are never returned with NaN weights: their first corner counts.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        import open3d as o3d

        self.mesh = mesh
        self._normals = _corner_normals(mesh)
        self._tensor = o3d.core.Tensor
        self._scene = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(
            self._tensor(np.ascontiguousarray(mesh.vertices, dtype=np.float32)),
            self._tensor(np.ascontiguousarray(mesh.faces, dtype=np.uint32)),
        )

    def find(self, points: NDArray) -> Found:
        """The closest point of the surface to each of `points` (N, 3), mm."""
        queries = as_array(points, "points", (None, 3))
        answer = self._scene.compute_closest_points(self._tensor(queries.astype(np.float32)))
        faces = answer["primitive_ids"].numpy().astype(np.int64)
        return self._at(faces, answer["primitive_uvs"].numpy().astype(np.float64))

    def cast(self, origins: NDArray, directions: NDArray) -> RayHits:
        """The first hits of rays from `origins` (N, 3) along `directions` (N, 3)."""
        origins = as_array(origins, "origins", (None, 3))
        directions = as_array(directions, "directions", (len(origins), 3))
        rays = np.hstack([origins, directions]).astype(np.float32)
        answer = self._scene.cast_rays(self._tensor(rays))
        distance = answer["t_hit"].numpy().astype(np.float64)
        hit = np.isfinite(distance)
        faces = np.where(hit, answer["primitive_ids"].numpy().astype(np.int64), -1)
        points = np.full((len(origins), 3), np.nan)
        points[hit] = origins[hit] + distance[hit, None] * directions[hit]
        return RayHits(hit, distance, faces, points)

    def _at(self, faces: NDArray, uvs: NDArray) -> Found:
        weights = np.column_stack([1.0 - uvs.sum(axis=1), uvs])
        ids = self.mesh.faces[faces]
        corners = self.mesh.vertices[ids].astype(np.float64)
        normals = np.einsum("nk,nkd->nd", weights, self._normals[faces])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        flat = length[:, 0] < 1e-12
        normals[flat] = self.mesh.face_normals[faces[flat]]
        length[flat] = 1.0
        return Found(np.einsum("nk,nkd->nd", weights, corners), faces, weights, normals / length)

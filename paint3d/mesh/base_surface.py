"""A source mesh prepared for painting: welded, split at creases, without faces of no area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.errors import MeshError
from paint3d.mesh.kernels.refine import MOST_AROUND_EDGE
from paint3d.mesh.kernels.topology import (
    corner_normals,
    count_around,
    link_radial,
    longest_sides,
    measure_faces,
    smooth_corners,
    weld_positions,
)
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["CREASE_ANGLE", "BaseSurface", "make_base_surface"]

CREASE_ANGLE = np.deg2rad(40.0)  # faces whose normals differ by more meet in a crease
_AGREES = 0.8  # least cosine to the computed normal at which the file's is taken


@dataclass(frozen=True, eq=False)
class BaseSurface:
    """Triangles with one normal per smooth corner group, and the rings around their edges."""

    points: AnyArray  # (B, 3) float32, mm
    normals: AnyArray  # (B, 3) float32
    faces: AnyArray  # (R, 3) int32
    radial: AnyArray  # (3 R,) int32
    areas: AnyArray  # (R,) float64, mm2
    source_vertices: AnyArray  # (B,) int32
    source_faces: AnyArray  # (R,) int64

    def longest_edges(self) -> NDArray[np.float64]:
        """Return the longest edge of every triangle, (R,) float64, mm."""
        longest = np.empty(len(self.faces))
        longest_sides(self.points, self.faces, longest)
        return longest


def weld(vertices: AnyArray) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Positions (N, 3) without minus zeros, and their dense ids (N,); equal ones have one id."""
    points = np.ascontiguousarray(vertices, np.float32) + np.float32(0.0)
    table = np.full(1 << (2 * len(points)).bit_length(), -1, np.int32)
    ids = np.empty(len(points), np.int32)
    weld_positions(points.view(np.uint32), table, ids)
    return points, ids


def make_base_surface(mesh: TriangleMesh) -> BaseSurface:
    """Weld equal positions, split vertices at creases, leave out faces without area.

    Raises
    ------
    MeshError
        If more than 256 triangles share one edge.
    """
    points, welded = weld(mesh.vertices)
    faces = np.asarray(mesh.faces)
    face_normals, doubled = np.empty((len(faces), 3), np.float32), np.empty(len(faces))
    measure_faces(points, faces, face_normals, doubled)
    ids = welded[faces]
    distinct = (ids[:, 0] != ids[:, 1]) & (ids[:, 1] != ids[:, 2]) & (ids[:, 2] != ids[:, 0])
    keep = np.flatnonzero((doubled > 0.0) & distinct)
    if len(keep) == 0:
        raise MeshError(
            "{name}: none of {n} faces has an area; expected a surface",
            name=mesh.name, n=len(faces),
        )  # fmt: skip
    if len(keep) < len(faces):
        faces, ids, doubled = faces[keep], ids[keep], doubled[keep]
        face_normals = face_normals[keep]
    faces, ids = np.ascontiguousarray(faces), np.ascontiguousarray(ids)
    radial = link_radial(ids, int(ids.max()) + 1)
    if (most := count_around(radial)) > MOST_AROUND_EDGE:
        raise MeshError(
            "{name}: {n} triangles share one edge; expected at most {most}",
            name=mesh.name, n=most, most=MOST_AROUND_EDGE,
        )  # fmt: skip
    groups = smooth_corners(ids, face_normals, radial, float(np.cos(CREASE_ANGLE)))
    # a group is named after its first corner, so no sorting is needed to number them
    leads = groups == np.arange(len(groups), dtype=np.int32)
    first = np.flatnonzero(leads)
    corner_vertex = (np.cumsum(leads, dtype=np.int32) - 1)[groups]
    source = faces.reshape(-1)[first]
    order = np.argsort(source, kind="stable")
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    vertex_of_corner = rank[corner_vertex]
    source = source[order].astype(np.int32)
    new_faces = vertex_of_corner.reshape(-1, 3)
    base_points = np.ascontiguousarray(points[source])
    normals = np.empty((len(source), 3))
    corner_normals(base_points, new_faces, face_normals, vertex_of_corner, normals)
    return BaseSurface(
        points=base_points,
        normals=_prefer_given(normals, mesh.normals, source),
        faces=np.ascontiguousarray(new_faces),
        radial=radial,
        areas=0.5 * doubled,
        source_vertices=source,
        source_faces=keep,
    )


def _prefer_given(normals: AnyArray, given: AnyArray | None, source: AnyArray) -> AnyArray:
    """Take the file's own normal where the vertex is smooth and the two roughly agree."""
    if given is None:
        return normals.astype(np.float32)
    theirs = given[source].astype(np.float64)
    length = np.linalg.norm(theirs, axis=1, keepdims=True)
    theirs = theirs / np.where(length > 0.0, length, 1.0)
    single = np.bincount(source, minlength=len(given))[source] == 1
    agree = single & (np.einsum("ij,ij->i", theirs, normals) > _AGREES)
    return np.where(agree[:, None], theirs, normals).astype(np.float32)

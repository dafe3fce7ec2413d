"""Level of detail while the view moves: an object no finer than the screen shows.

A software renderer pays for every triangle, visible or not: two million of them take half a second,
each smaller than a pixel. `CoarseObject` clusters vertices within about a pixel of each other
(`view.kernels.clusters`) and uses few pieces, so that the picture follows the hand. At rest the
object is drawn from its patches, with every triangle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.view.kernels.clusters import (
    Members,
    cluster_vertices,
    coarse_triangles,
    list_members,
    mean_of,
    renumber,
)
from paint3d.view.live_patches import LivePatches

__all__ = ["CoarseObject", "CoarsePiece"]

_MOST = 0.95  # quantile of the area that `triangle_mm` is taken at
_PIECES = 24  # at most: each costs the renderer some tens of microseconds a frame


@dataclass(frozen=True, eq=False)
class CoarsePiece:
    """A part of the coarse object.

    Attributes
    ----------
    clusters : (K,) int32
        Its vertices.
    points, normals : (K, 3) float32
        mm and unit vectors.
    faces : (L, 3) int32
        Triangles with numbers into `clusters`.
    centre : (3,) float64
        Mean of its points, mm.
    """

    clusters: NDArray[np.int32]
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    faces: NDArray[np.int32]
    centre: NDArray[np.float64]


class CoarseObject:
    """A mesh simplified by clustering vertices within a distance.

    Parameters
    ----------
    mesh : PaintMesh
        Refining it further invalidates this object.
    patches : LivePatches
        Of that mesh, up to date.
    size : float
        The distance, mm.
    shown : callable
        Maps vertices (N,) int32 and the paint on all (V, 3) to the visible (N, 4) uint8: colour,
        lit, and shine (`surface.sheen`).
    srgb : (V, 3) uint8
        The paint on every vertex.
    parts : (V,) int, optional
        Numbers from 0; vertices of different parts are never clustered.

    Attributes
    ----------
    n_vertices, n_faces : int
        Of the mesh at the time, and of the coarse object.
    pieces : list of CoarsePiece
    points, normals : (C, 3) float32
        Of the clusters, mm and unit vectors.
    colours : (C, 4) uint8
        Of the clusters: colour, lit, and shine.

    Notes
    -----
    Cost: 0.1 us a vertex.
    """

    def __init__(
        self,
        mesh: PaintMesh,
        patches: LivePatches,
        size: float,
        shown: Callable[[AnyArray, AnyArray], AnyArray],
        srgb: NDArray[np.uint8],
        parts: AnyArray | None = None,
    ) -> None:
        self.size, self._look = size, shown
        self.n_vertices = n = mesh.n_vertices
        self._cluster, count = _clusters(mesh, size)
        if parts is not None:
            apart = self._cluster * (int(parts.max()) + 1) + parts
            kept, self._cluster = np.unique(apart, return_inverse=True)
            self._cluster, count = self._cluster.ravel().astype(np.int32), len(kept)
        self._members = Members(np.zeros(count + 1, np.int32), np.empty(n, np.int32))
        list_members(self._cluster, *self._members)
        every = np.arange(count, dtype=np.int32)
        self.points, self.normals = (
            self._mean(every, np.stack([c[:n] for c in columns], axis=1)) for columns in _of(mesh)
        )
        length = np.linalg.norm(self.normals, axis=1, keepdims=True)
        self.normals /= np.maximum(length, 1e-6)
        self._shown = np.empty((n, 4), np.uint8)
        self.colours = np.empty((count, 4), np.uint8)
        self.pieces = self._cut(patches, count)
        self.n_faces = sum(len(piece.faces) for piece in self.pieces)
        self.repaint(np.arange(n, dtype=np.int32), srgb)

    @cached_property
    def triangle_mm(self) -> float:
        """Size of its triangles, mm; 95 % of its area lies in smaller ones."""
        pairs = [(piece.points[piece.faces[:, k]] for k in range(3)) for piece in self.pieces]
        normals = [np.cross(b - a, c - a) for a, b, c in pairs] or [np.zeros((1, 3))]
        areas = np.sort(np.linalg.norm(np.concatenate(normals), axis=1))
        sums = np.cumsum(areas, dtype=np.float64)
        return float(np.sqrt(areas[np.searchsorted(sums, _MOST * sums[-1])]))

    def repaint(self, vertex_ids: AnyArray, srgb: AnyArray) -> None:
        """Update the paint (V, 3) of some vertices (N,) int32; vertices added since are ignored."""
        ids = vertex_ids[vertex_ids < self.n_vertices]
        self._shown[ids] = self._look(ids, srgb)
        touched = np.zeros(len(self.colours), bool)
        touched[self._cluster[ids]] = True
        chosen = np.flatnonzero(touched).astype(np.int32)
        mean_of(self._members, chosen, self._shown, self.colours)

    def _mean(self, chosen: AnyArray, columns: AnyArray) -> AnyArray:
        out = np.empty((len(self._members.starts) - 1, columns.shape[1]), np.float32)
        mean_of(self._members, chosen, columns, out)
        return out

    def _cut(self, patches: LivePatches, count: int) -> list[CoarsePiece]:
        """Return the triangles in pieces, each a run of patches with vertices of its own."""
        faces, leaves = patches.leaves()
        runs = np.array_split(np.arange(len(leaves)), min(_PIECES, len(leaves)))
        ends = np.cumsum([sum(len(leaves[p]) for p in run) for run in runs])
        out, out_ends = np.empty((ends[-1], 3), np.int32), np.empty(len(runs), np.int64)
        coarse_triangles(faces, np.concatenate(leaves), ends, self._cluster, out, out_ends)
        numbers, pieces = np.full(count, -1, np.int32), []
        for first, last in zip([0, *out_ends[:-1]], out_ends, strict=True):
            if last == first:
                continue
            triangles, ids = out[first:last], np.empty(3 * (last - first), np.int32)
            ids = ids[: renumber(triangles, numbers, ids)].copy()
            points = self.points[ids]
            middle = points.mean(axis=0, dtype=np.float64)
            pieces.append(CoarsePiece(ids, points, self.normals[ids], triangles, middle))
        return pieces


def _of(mesh: PaintMesh) -> tuple[tuple[AnyArray, ...], ...]:
    """Return the columns of positions, and of normals."""
    field = mesh.arrays
    return (field.px, field.py, field.pz), (field.nx, field.ny, field.nz)


def _clusters(mesh: PaintMesh, size: float) -> tuple[AnyArray, int]:
    """Return the cluster of each vertex (V,), and the number of clusters."""
    n = mesh.n_vertices
    columns = [column[:n] for column in _of(mesh)[0]]
    low = np.array([float(c.min()) for c in columns])
    cells = np.array([float(c.max()) for c in columns]) - low
    cells = (cells / size).astype(np.int64) + 2
    table = np.full(1 << int(2 * n).bit_length(), -1, np.int32)
    cluster = np.empty(n, np.int32)
    count = cluster_vertices(
        mesh.arrays, n, low, cells, size, table, np.empty(n, np.int64), cluster
    )
    return cluster, int(count)

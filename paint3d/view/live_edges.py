"""Shares covered by paint on a live object, ready for sharp edges, updated while it is painted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, grown
from paint3d.mesh.kernels.topology import link_radial
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.view.edges import LEAST, MIXED
from paint3d.view.kernels.edges import Shares, Triangles, follow_shares

__all__ = ["LiveEdges"]


class LiveEdges:
    """The shares of `view.edges` on a surface, updated as it changes.

    Cost: .2 us for every vertex whose share painted has changed, or that is new beside paint, and
    for those around it.

    Parameters
    ----------
    surface : PaintedSurface
    """

    def __init__(self, surface: PaintedSurface) -> None:
        self._surface, mesh = surface, surface.paint_mesh
        none = np.zeros(0, np.uint8)
        self._shares = Shares(none, np.zeros(0, np.float32), none, none, np.zeros(0, np.int32))
        self._face_of = np.zeros(0, np.int32)
        self._changed = np.zeros(0, np.int32)
        self._n_faces = 0
        self._radial = None if mesh.refines else link_radial(mesh.base_faces, mesh.n_base_vertices)

    def shares(self, ids: AnyArray) -> NDArray[np.uint8]:
        """Return the shares (N, 2) of vertices (N,) as of the last `follow`; see `Edges`."""
        return np.stack([self._shares.sharp[ids], self._shares.painted[ids]], axis=1)

    def follow(self, inked: NDArray[np.int32]) -> NDArray[np.int32]:
        """Update; return the vertices (N,) whose share at an edge has changed.

        Parameters
        ----------
        inked : (M,) int32
            Vertices whose ink may have changed.
        """
        mesh = self._surface.paint_mesh
        if len(self._face_of) < mesh.capacity:
            self._fit(mesh.capacity)
        faces = mesh.arrays.node_vertices if mesh.refines else mesh.base_faces
        radial = mesh.arrays.radial if self._radial is None else self._radial
        fresh = self._fresh_faces(faces)
        shares = self._shares
        codes = self._surface.coverage_codes(inked)
        moved = inked[codes != shares.painted[inked]]
        shares.painted[inked] = codes
        beside = (shares.painted[fresh] > 0) | (shares.smooth[fresh] > 0.0)
        ids = np.concatenate([moved, fresh[beside.any(axis=1)].ravel()])
        if not len(ids):
            return ids
        triangles = Triangles(faces, radial, self._face_of)
        n = follow_shares(ids, triangles, MIXED, LEAST, shares, self._changed)
        return self._changed[:n].copy()

    def _fresh_faces(self, faces: AnyArray) -> AnyArray:
        """Return the triangles (F, 3) that refinement has made since the last call."""
        mesh, first = self._surface.paint_mesh, self._n_faces
        last = int(mesh.arrays.counts[1]) if mesh.refines else len(faces)
        numbers = np.arange(first, last, dtype=np.int32)
        if mesh.refines:
            numbers = numbers[mesh.arrays.child[first:last] < 0]
        fresh = faces[numbers]
        for corner in range(3):
            self._face_of[fresh[:, corner]] = numbers
        self._n_faces = last
        return fresh

    def _fit(self, capacity: int) -> None:
        known = len(self._face_of)
        self._shares = Shares(*(grown(a, known, capacity) for a in self._shares))
        for array in self._shares:
            array[known:] = 0
        self._face_of = grown(self._face_of, known, capacity)
        self._face_of[known:] = -1
        self._changed = np.empty(capacity, np.int32)

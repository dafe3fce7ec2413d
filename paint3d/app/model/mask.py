"""Where paint is taken: by the angle of the surface, and by regions that were picked.

Nothing in the painting knows of it. After a brush went on, vertices that are masked get back what
they had, and what would have stayed on them stays in the brush: a stencil drinks no ink. So the
ledger closes. With a mask strokes are painted sample by sample, so that how samples come in batches
makes no difference. Without a mask this costs nothing, with one as much as vertices were masked.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.errors import InputError
from paint3d.mesh.polygons import face_normals
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.surface.eraser import give_back
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["AngleMask", "Mask", "RegionPick", "Stencil", "face_at", "nearest_vertex",
           "region_faces"]  # fmt: skip

_KINDS = ("crease", "piece")


@dataclass(frozen=True)
class AngleMask:
    """Paint is taken where the normal leans from a direction by at most some degrees.

    Attributes
    ----------
    direction : (float, float, float)
        In the object's frame, of any length: towards the viewer, say.
    degrees : float
        0 to 180.

    Raises
    ------
    InputError
        If the direction is 0 or the angle out of its range.
    """

    direction: tuple[float, float, float]
    degrees: float

    def __post_init__(self) -> None:
        if not np.linalg.norm(as_array(self.direction, "direction of the mask", (3,))) > 0.0:
            raise InputError("the direction of the mask is 0; expected a direction")
        as_number(self.degrees, "angle of the mask (degrees)", 0.0, 180.0)


@dataclass(frozen=True)
class RegionPick:
    """A region of the object around one of its faces.

    Attributes
    ----------
    face : int
        Of `PaintMesh.base_faces`; see `face_at`.
    up_to : {"crease", "piece"}
        How far it goes: to edges sharper than `degrees`, or as far as faces are joined.
    degrees : float
        0 to 180.

    Raises
    ------
    InputError
        If a value is none of those.
    """

    face: int
    up_to: str = "crease"
    degrees: float = 30.0

    def __post_init__(self) -> None:
        if self.up_to not in _KINDS:
            raise InputError(
                "up_to is {up_to!r}; expected 'crease' or 'piece'",
                up_to=self.up_to,
            )
        as_number(self.degrees, "crease (degrees)", 0.0, 180.0)


@dataclass(frozen=True)
class Mask:
    """Paint is taken where all of it allows.

    Attributes
    ----------
    angle : AngleMask or None
    regions : tuple of RegionPick
        Paint is taken in any of them; everywhere if there is none.
    inverted : bool
        Whether paint is taken outside of the regions instead.
    """

    angle: AngleMask | None = None
    regions: tuple[RegionPick, ...] = ()
    inverted: bool = False

    @property
    def is_open(self) -> bool:
        """True if paint is taken everywhere."""
        return self.angle is None and not self.regions


def nearest_vertex(mesh: PaintMesh, point: AnyArray) -> int:
    """The vertex nearest to a point (3,), mm."""
    away = mesh.vertices - point.astype(np.float32)
    return int(np.argmin(np.einsum("ij,ij->i", away, away)))


def face_at(mesh: PaintMesh, vertex_id: int) -> int:
    """A base face that a vertex lies on.

    Raises
    ------
    InputError
        If there is no such vertex, or no face has it.
    """
    faces = np.flatnonzero((mesh.leaf_faces() == vertex_id).any(axis=1))
    if not len(faces):
        raise InputError(
            "vertex {vertex_id} belongs to no face; expected one that does",
            vertex_id=vertex_id,
        )
    return int(mesh.leaf_roots()[faces[0]])


def region_faces(mesh: PaintMesh, pick: RegionPick) -> NDArray[np.bool_]:
    """(R,) bool: the base faces of a region.

    Raises
    ------
    InputError
        If there is no such face.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    faces = mesh.base_faces
    n = len(faces)
    if isinstance(pick.face, bool) or not 0 <= pick.face < n:
        raise InputError("face is {face}; expected 0 to {last}", face=pick.face, last=n - 1)
    one, two = _find_neighbours(mesh)
    if pick.up_to == "crease":
        normals = face_normals(mesh.vertices[mesh.base_faces].astype(np.float64))
        cosine = np.einsum("ij,ij->i", normals[one], normals[two])
        smooth = cosine >= math.cos(math.radians(pick.degrees)) - 1e-9
        one, two = one[smooth], two[smooth]
    joined = coo_matrix((np.ones(len(one), np.int8), (one, two)), (n, n))
    _, label = connected_components(joined, directed=False)
    result: NDArray[np.bool_] = label == label[pick.face]
    return result


def _find_neighbours(mesh: PaintMesh) -> tuple[AnyArray, AnyArray]:
    """Pairs of faces that share an edge, wherever its vertices are split by normals."""
    points = mesh.vertices[: mesh.n_base_vertices]
    _, position = np.unique(points, axis=0, return_inverse=True)
    corners = position.reshape(-1)[mesh.base_faces]
    edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(corners)), 3)
    order = np.lexsort(edges.T)
    edges, owner = edges[order], owner[order]
    same = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    return owner[same], owner[same + 1]


class Stencil:
    """A mask laid on a surface.

    Parameters
    ----------
    surface : PaintedSurface
    mask : Mask

    Raises
    ------
    InputError
        If the mask names a face that is not there.
    """

    def __init__(self, surface: PaintedSurface, mask: Mask) -> None:
        self._surface = surface
        self._mask = mask
        self._faces: AnyArray | None = None
        if mask.regions:
            picked = [region_faces(surface.paint_mesh, pick) for pick in mask.regions]
            self._faces = np.logical_or.reduce(picked) != mask.inverted
        self._open = np.zeros(0, bool)  # by the regions
        self._leans = np.zeros(0, bool)  # by the angle
        self._known = 0, 0
        self._looked = self._masked = np.empty(0, np.int32)

    def covers(self, vertex_ids: AnyArray) -> NDArray[np.bool_]:
        """(N,) bool: whether vertices (N,) take no paint."""
        self._learn_vertices()
        return ~(self._open[vertex_ids] & self._leans[vertex_ids])

    def _learn_vertices(self) -> None:
        """Learn about vertices that have appeared."""
        mesh = self._surface.paint_mesh
        fields, (n, nodes) = mesh.arrays, (int(c) for c in mesh.arrays.counts)
        known, known_nodes = self._known
        if known == n:
            return
        self._open = np.pad(self._open, (0, n - known), constant_values=self._faces is None)
        if self._faces is not None:
            if known == 0:
                self._open[mesh.base_faces[self._faces]] = True
            fresh = slice(known_nodes, nodes)
            allowed = self._faces[fields.node_root[fresh]]
            self._open[fields.node_vertices[fresh][allowed]] = True
        self._leans = np.pad(self._leans, (0, n - known), constant_values=True)
        angle = self._mask.angle
        if angle is not None:
            towards = np.asarray(angle.direction, np.float64)
            towards /= np.linalg.norm(towards)
            height = sum(
                getattr(fields, name)[known:n] * part
                for name, part in zip(("nx", "ny", "nz"), towards, strict=True)
            )
            self._leans[known:n] = height >= math.cos(math.radians(angle.degrees)) - 1e-6
        self._known = n, nodes

    def wipe(self, before: Callable[[AnyArray], tuple[AnyArray, AnyArray]]) -> AnyArray:
        """Restore masked vertices, and return to the brush what fell on them.

        Parameters
        ----------
        before : callable
            Returns amounts (N, P) and coverage (N,) of vertices (N,) before the brush came.

        Returns
        -------
        (P,) float64
            What the surface's brush has now more, or less where it drank through the stencil,
            coats x mm2.
        """
        ink = self._surface.ink
        ids = self._find_touched()
        if not len(ids):
            return np.zeros(len(ink.load))
        amounts, coverage = before(ids)
        came = ink.amounts[ids].astype(np.float64) - amounts
        moved = came.any(axis=1)
        if not moved.any() and np.array_equal(ink.coverage[ids], coverage):
            return np.zeros(len(ink.load))
        ink.amounts[ids], ink.coverage[ids] = amounts, coverage
        return give_back(self._surface, ids[moved], came[moved])

    def _find_touched(self) -> AnyArray:
        """Masked vertices among those that were touched since colours were refreshed last."""
        ink = self._surface.ink
        dirty, known = ink.dirty_ids[: int(ink.n_dirty[0])], self._looked
        if not np.array_equal(dirty[: len(known)], known):
            known, self._masked = known[:0], np.empty(0, np.int32)
        if len(dirty) > len(known):
            fresh = dirty[len(known) :]
            self._masked = np.concatenate([self._masked, fresh[self.covers(fresh)]])
            self._looked = dirty.copy()
        return self._masked

"""Partition of an object into patches, so that only what has changed is sent to the renderer.

VTK uploads whole arrays: with a single array of a million vertices every touch of the brush would
upload a million colours. The sheets of the paint mesh are grouped, separately for each of the six
axis directions that they face, into compact patches of about `FACES` triangles once fully refined,
each with its own arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, grown
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.view.kernels.chunks import Entries, add_faces, mark_holders, mark_split, place_faces

__all__ = ["FACES", "LivePatches", "PatchChange", "turned_away"]

FACES = 6000
_FACE_AREA = 0.18  # area of a refined triangle over the squared resolution; measured
_MOST_PATCHES = 400  # each costs the renderer some tens of microseconds a frame
_GROUP = 1.4  # times the target area, above which a group is halved
_GROWTH = 1.5


@dataclass(frozen=True, eq=False)
class PatchChange:
    """A patch to be redrawn.

    Attributes
    ----------
    patch : int
    vertex_ids : (K,) int32
        Its vertices on the object; the list only ever grows at its end.
    faces : (L, 3) int32 or None
        Its triangles with numbers into `vertex_ids`; None where only colours have changed.
    """

    patch: int
    vertex_ids: NDArray[np.int32]
    faces: NDArray[np.int32] | None


class LivePatches:
    """The patches of one paint mesh, updated while it is refined.

    Parameters
    ----------
    mesh : PaintMesh
    faces : int
        Approximate number of triangles in a patch.

    Notes
    -----
    Must not be used while another thread refines the mesh. Cost: 0.1 us for every triangle, at the
    start or when refinement creates it, and 1 ms per million triangles in every `changes` after a
    refinement.
    """

    def __init__(self, mesh: PaintMesh, faces: int = FACES) -> None:
        self.mesh = mesh
        self._sheet_patch, self._area = _cut(mesh, faces)
        self.n_patches = int(self._sheet_patch.max()) + 1
        self._ids = [np.empty(0, np.int32) for _ in range(self.n_patches)]
        self._leaves = [np.empty(0, np.int32) for _ in range(self.n_patches)]
        self._face_patch = np.empty(0, np.int32)
        self._n_faces = 0
        none = np.empty(0, np.int32)
        self._entries = Entries(none, none, none, none, np.zeros(1, np.int64))

    def vertex_ids(self, patch: int) -> NDArray[np.int32]:
        """Return the vertices (K,) int32 of one patch."""
        return self._ids[patch]

    def changes(self, vertex_ids: NDArray[np.int32]) -> list[PatchChange]:
        """Return the patches to redraw after colours have changed and the mesh was refined.

        Parameters
        ----------
        vertex_ids : (N,) int32
            Vertices with new colours; vertices added since the last call need not be included.

        Returns
        -------
        list of PatchChange
            By patch. The first call returns the whole object.
        """
        rebuilt = self._rebuild()
        marks = np.zeros(self.n_patches, np.uint8)
        if len(vertex_ids):
            mark_holders(np.ascontiguousarray(vertex_ids, np.int32), self._entries, marks)
        marks[list(rebuilt)] = 1
        return [
            PatchChange(int(p), self._ids[p], rebuilt.get(int(p))) for p in np.flatnonzero(marks)
        ]

    @property
    def n_leaves(self) -> int:
        """Number of triangles."""
        return sum(map(len, self._leaves))

    @property
    def fine_area(self) -> float:
        """Approximate area of the refined part of the mesh, mm^2."""
        return min(self._area, _FACE_AREA * self.mesh.resolution**2 * self.n_leaves)

    def leaves(self) -> tuple[AnyArray, list[AnyArray]]:
        """Return all triangles (F, 3), also bisected ones, and the present ones (L,) per patch."""
        return self._all_faces()[0], self._leaves

    # -- refinement -------------------------------------------------------------------------

    def _rebuild(self) -> dict[int, AnyArray]:
        """Assign new triangles to patches; return the faces of the patches that they change."""
        faces, child = self._all_faces()
        before, n = self._n_faces, len(faces)
        if n == before:
            return {}
        field = self.mesh.arrays
        self._face_patch = _with_room(self._face_patch, before, n)
        place_faces(field, faces, before, self._sheet_patch, self._face_patch)
        marks = np.zeros(self.n_patches, np.uint8)
        fresh = np.arange(before, n, dtype=np.int32)
        if child is not None:
            mark_split(child, before, self._face_patch, marks)
            fresh = fresh[child[before:n] < 0]
        # Sort by patch: a patch's new triangles are fresh[starts[p] : starts[p + 1]].
        patches = self._face_patch[fresh]
        counts = np.bincount(patches, minlength=self.n_patches)
        fresh = fresh[np.argsort(patches, kind="stable")]
        starts = np.concatenate([[0], np.cumsum(counts)])
        marks[counts > 0] = 1
        self._n_faces = n
        return {
            int(p): self._refit(int(p), faces, child, fresh[starts[p] : starts[p + 1]])
            for p in np.flatnonzero(marks)
        }

    def _all_faces(self) -> tuple[AnyArray, AnyArray | None]:
        """Return all triangles (F, 3), also bisected ones, and their first children, if any."""
        mesh = self.mesh
        if not mesh.refines:
            return mesh.base_faces, None
        n = int(mesh.arrays.counts[1])
        return mesh.arrays.node_vertices[:n], mesh.arrays.child[:n]

    def _refit(
        self, patch: int, faces: AnyArray, child: AnyArray | None, fresh: AnyArray
    ) -> AnyArray:
        """Update a patch's triangles, and return them with indices into the patch's vertices."""
        leaves = self._leaves[patch]
        if child is not None:
            leaves = leaves[child[leaves] < 0]
        chosen = np.concatenate([leaves, fresh])
        self._reserve(3 * len(chosen))
        local, new_ids = np.empty((len(chosen), 3), np.int32), np.empty(3 * len(chosen), np.int32)
        ids = self._ids[patch]
        n_new = add_faces(faces, chosen, patch, len(ids), self._entries, local, new_ids)
        if n_new:
            self._ids[patch] = np.concatenate([ids, new_ids[:n_new]])
        self._leaves[patch] = chosen
        return local

    def _reserve(self, extra: int) -> None:
        """Grow the table of entries by `extra`, and to all vertices up to the mesh's capacity."""
        old, count = self._entries, int(self._entries.count[0])
        head = old.head
        if len(head) < self.mesh.n_vertices:
            head = np.full(self.mesh.capacity, -1, np.int32)
            head[: len(old.head)] = old.head
        patch, place, following = old.patch, old.place, old.following
        if len(old.patch) < count + extra:
            patch, place, following = (
                _with_room(column, count, count + extra) for column in (patch, place, following)
            )
        self._entries = Entries(head, patch, place, following, old.count)


def _cut(mesh: PaintMesh, faces: int) -> tuple[NDArray[np.int32], float]:
    """Return the patch of each sheet (S,) int32, and the total area."""
    field = mesh.arrays
    along = np.abs(field.sheet_normal).argmax(axis=1)
    looks = np.take_along_axis(field.sheet_normal, along[:, None], axis=1)[:, 0] < 0.0
    sides = 2 * along + looks
    total = float(field.sheet_area.sum())
    target = max(_FACE_AREA * mesh.resolution**2 * faces, total / _MOST_PATCHES, 1e-30)
    numbers, n = np.empty(len(sides), np.int32), 0
    for side in range(6):
        chosen = np.flatnonzero(sides == side)
        places, areas = field.sheet_centre[chosen], field.sheet_area[chosen]
        for group in _compact_groups(places, areas, target):
            numbers[chosen[group]] = n
            n += 1
    return numbers, total


def _compact_groups(places: AnyArray, areas: AnyArray, target: float) -> list[AnyArray]:
    """Halve points (N, 3) with areas (N,) recursively into groups of about `target` area."""
    groups, waiting = [], [np.arange(len(places))] if len(places) else []
    while waiting:
        group = waiting.pop()
        if len(group) == 1 or areas[group].sum() <= _GROUP * target:
            groups.append(group)
            continue
        along = np.ptp(places[group], axis=0).argmax()
        group = group[np.argsort(places[group, along], kind="stable")]
        sums = np.cumsum(areas[group])
        half = np.clip(np.searchsorted(sums, 0.5 * sums[-1]) + 1, 1, len(group) - 1)
        waiting += [group[half:], group[:half]]
    return groups


def _with_room(array: AnyArray, used: int, capacity: int) -> AnyArray:
    """Return an array of at least `capacity` whose first `used` entries are those of the given."""
    return array if len(array) >= capacity else grown(array, used, int(capacity * _GROWTH) + 64)


# ---- Back-face culling ---------------------------------------------------------------------------
# Culling of whole patches that face away from the eye.
#
# A patch has a cone around its normals (`view.kernels.chunks.cone_of`; Shirman and Abi-Ezzi, The
# cone of normals technique for fast processing of curved patches, 1993).


_SLACK = 1e-4  # of cosines, for rounding


def turned_away(bounds: AnyArray, cones: AnyArray, eye: AnyArray) -> AnyArray:
    """Return whether each patch faces away from an eye with all its triangles.

    Parameters
    ----------
    bounds : (P, 6)
        Lowest and highest corner of each patch's bounding box, mm.
    cones : (P, 4)
        `kernels.chunks.cone_of` each.
    eye : (3,)
        mm.

    Returns
    -------
    (P,) bool
        False where it is not certain.
    """
    low, high = bounds[:, :3], bounds[:, 3:]
    radius = 0.5 * np.linalg.norm(high - low, axis=1)
    ahead = 0.5 * (low + high) - eye
    away = np.linalg.norm(ahead, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        # Seen from behind if the angle between the cone's axis and the ray to the box, plus the
        # cone's half angle, plus the half angle under which the box is seen, is below 90 degrees.
        spread = np.arccos(np.clip(cones[:, 3] - _SLACK, -1.0, 1.0))
        seen_under = np.arcsin(np.minimum(radius / away, 1.0))
        between = np.arccos(np.clip((ahead * cones[:, :3]).sum(axis=1) / away, -1.0, 1.0))
        result: AnyArray = between + spread + seen_under < 0.5 * np.pi
        return result

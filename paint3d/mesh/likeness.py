"""Indexing of a remeshed object so that a brush moves on it as on the original mesh.

Where a footprint lies follows from normals and from the sheets of surface in the cells around it.
On a surface bent as sharply as the rim of a bowl these depend on the triangles and on the lattice:
the lattice begins at the object's bounding box and its cells grow with the resolution, vertices on
coarse triangles have other normals, and a sheet that just faces away from the foot may or may not
count. So wherever the new mesh is the same surface, it takes over the original's lattice, normals
and sheets. Where the object was changed, it keeps its own.
"""

from __future__ import annotations

import dataclasses
import hashlib
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.mesh.base_surface import make_base_surface
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["Original", "build_like", "digest_of"]

_DIGEST_BYTES = 8
_FEWEST_EDGES, _MOST_EDGES = 2.0, 64.0  # per cell of a lattice that is taken over
_ALIKE = 0.5  # least fraction of vertices on the original for it to be the same object
_FACES_AS = 0.5  # least cosine between corresponding normals
_FITS = 1.5  # mm: sheets that differ by more in position and turn are not the same
_TURN_MM = 1.0  # what a turn of the mean normal by one radian counts


class Original(NamedTuple):
    """The mesh and resolution on which an object was first painted."""

    mesh: TriangleMesh
    resolution: float
    """mm"""


def digest_of(mesh: TriangleMesh) -> str:
    """Return 16 hexadecimal digits that tell meshes of one name apart: a hash of their arrays."""
    digest = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for array in (mesh.vertices, mesh.faces, mesh.normals):
        digest.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def build_like(
    mesh: TriangleMesh, resolution: float | None, original: Original
) -> PaintMesh | None:
    """Index a mesh for painting (`PaintMesh.build`) like its original.

    Parameters
    ----------
    mesh : TriangleMesh
    resolution : float or None
        Longest edge after refinement, mm.
    original : Original

    Returns
    -------
    PaintMesh or None
        None where the original makes no difference: the two meshes are the same, less than half
        of the vertices lie on it, or its cells do not suit the resolution.

    Raises
    ------
    MeshError
        See `PaintMesh.build`.
    """
    if resolution is None:
        return None
    if resolution == original.resolution and digest_of(mesh) == digest_of(original.mesh):
        return None
    first = PaintMesh.build(original.mesh, original.resolution)
    size = first.arrays.cell_size
    if not (first.refines and _FEWEST_EDGES <= size / resolution <= _MOST_EDGES):
        return None
    base = make_base_surface(mesh)
    nearest = ClosestPoints(original.mesh).find(base.points.astype(np.float64))
    away = np.linalg.norm(nearest.points - base.points, axis=1)
    is_there = away <= original.resolution
    if is_there.mean() < _ALIKE:
        return None
    agrees = np.einsum("ij,ij->i", nearest.normals, base.normals) >= _FACES_AS
    normals = np.where((is_there & agrees)[:, None], nearest.normals, base.normals)
    base = dataclasses.replace(base, normals=normals.astype(np.float32))
    own = PaintMesh(base, resolution, (first.arrays.origin, size))
    own.arrays = own.arrays._replace(sheet_pack=_merge_sheets(own, first))
    return own


def _merge_sheets(own: PaintMesh, first: PaintMesh) -> AnyArray:
    """Return the own `sheet_pack` (S, 8), with the first's rows for the sheets that both have.

    Both have one lattice. Each sheet of `first` is matched with at most one of its own: a sliver
    that was cut off it keeps its row.
    """
    pack, theirs = own.arrays.sheet_pack.copy(), first.arrays.sheet_pack
    further = np.rint((first.arrays.origin - own.arrays.origin) / own.arrays.cell_size)
    keys = _keys(own.arrays.sheet_place[:, :3])
    known = _keys(first.arrays.sheet_place[:, :3] + further)
    order = np.argsort(known, kind="stable")
    start, end = (np.searchsorted(known, keys, side, sorter=order) for side in ("left", "right"))
    best, partner = np.full(len(pack), _FITS), np.full(len(pack), -1)
    for nth in range(int((end - start).max(initial=0))):
        mine = np.flatnonzero(start + nth < end)
        other = order[start[mine] + nth]
        off = _sheet_distance(pack[mine], theirs[other])
        nearer = off < best[mine]
        best[mine[nearer]], partner[mine[nearer]] = off[nearer], other[nearer]
    mine = np.flatnonzero(partner >= 0)
    mine = mine[np.argsort(pack[mine, 3], kind="stable")]  # the largest last: it wins
    chosen = np.full(len(theirs), -1)
    chosen[partner[mine]] = mine
    taken = np.flatnonzero(chosen >= 0)
    pack[chosen[taken]] = theirs[taken]
    return pack


def _keys(positions: AnyArray) -> NDArray[np.int64]:
    """Pack lattice positions (n, 3), at most 2^20 along an axis, into one number each."""
    p = positions.astype(np.int64)
    return (p[:, 0] << 42) | (p[:, 1] << 21) | p[:, 2]


def _sheet_distance(one: AnyArray, other: AnyArray) -> AnyArray:
    """Distance (n,) of sheets (n, 8), mm: that of their centres, plus their turn."""
    distance = np.linalg.norm(one[:, 4:7] - other[:, 4:7], axis=1)
    area = np.maximum(np.maximum(one[:, 3], other[:, 3]), 1e-9)
    off: AnyArray = distance + _TURN_MM * np.linalg.norm(one[:, :3] - other[:, :3], axis=1) / area
    return off

"""An object that was meshed anew, made ready so that a brush moves on it as on the first mesh.

Where a footprint lies follows from normals and from the sheets of surface in the cells around it.
On what is bent as sharply as the rim of a bowl all of these depend on the triangles and on where
the lattice lies: the lattice begins at the box around the object and its cells grow with the
resolution, vertices on coarse triangles lean otherwise, and a sheet that looks just away from the
foot counts or does not. So the second mesh takes over, wherever it is the same surface: the first
one's lattice, its normals at the own vertices, and what its sheets say of the shape. Where the
object was changed it stands for itself.
"""

from __future__ import annotations

import dataclasses
import hashlib
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray
from paint3d.mesh.base_surface import BaseSurface, make_base_surface
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh

__all__ = ["Original", "build_like", "digest_of"]

_DIGEST_BYTES = 8
_FEWEST_EDGES, _MOST_EDGES = 2.0, 64.0  # to a cell that is taken over
_ALIKE = 0.5  # share of the vertices that lie on the original where it is the same object
_FACES_AS = 0.5  # cosine of normals that are one another's
_FITS = 1.5  # mm: two sheets farther apart, or by as much turned, are not the same
_TURN_MM = 1.0  # that a turn of the mean normal by one radian counts as


class Original(NamedTuple):
    """What an object's painting was first painted on."""

    mesh: TriangleMesh
    resolution: float
    """mm"""


def digest_of(mesh: TriangleMesh) -> str:
    """16 hexadecimal digits of vertices, faces and normals: they tell meshes of one name apart."""
    digest = hashlib.blake2b(digest_size=_DIGEST_BYTES)
    for array in (mesh.vertices, mesh.faces, mesh.normals):
        digest.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def build_like(
    mesh: TriangleMesh, resolution: float | None, original: Original
) -> PaintMesh | None:
    """Index a mesh for painting (`PaintMesh.build`) as its original was.

    Parameters
    ----------
    mesh : TriangleMesh
    resolution : float or None
        Longest edge wanted, mm.
    original : Original

    Returns
    -------
    PaintMesh or None
        None where the original makes no difference: the two meshes are one, less than half of the
        vertices lie on it, or its cells do not suit the resolution.

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
    base, is_there = _with_normals(make_base_surface(mesh), original)
    if is_there.mean() < _ALIKE:
        return None
    own = PaintMesh(base, resolution, (first.arrays.origin, size))
    pack = _with_sheets(own, first)
    own.arrays = own.arrays._replace(sheet_pack=pack)
    return own


def _with_normals(base: BaseSurface, original: Original) -> tuple[BaseSurface, NDArray[np.bool_]]:
    """The surface with the original's normals where it lies on it, and where that is (B,)."""
    found = ClosestPoints(original.mesh).find(base.points.astype(np.float64))
    away = np.linalg.norm(found.points - base.points, axis=1)
    is_there = away <= original.resolution
    agrees = np.einsum("ij,ij->i", found.normals, base.normals) >= _FACES_AS
    chosen = np.where((is_there & agrees)[:, None], found.normals, base.normals)
    return dataclasses.replace(base, normals=chosen.astype(np.float32)), is_there


def _with_sheets(own: PaintMesh, first: PaintMesh) -> AnyArray:
    """What is known of the own sheets (S, 8), of those that are the first's too as it is there.

    Both lie in one lattice. Each sheet of the first is at most one of the own: a sliver that fell
    off it stays as it is.
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
        off = _differ(pack[mine], theirs[other])
        nearer = off < best[mine]
        best[mine[nearer]], partner[mine[nearer]] = off[nearer], other[nearer]
    mine = np.flatnonzero(partner >= 0)
    mine = mine[np.argsort(pack[mine, 3], kind="stable")]  # the largest last: it stays
    chosen = np.full(len(theirs), -1)
    chosen[partner[mine]] = mine
    taken = np.flatnonzero(chosen >= 0)
    pack[chosen[taken]] = theirs[taken]
    return pack


def _keys(places: AnyArray) -> NDArray[np.int64]:
    """One number for each place of a lattice (n, 3), which has at most 2^20 along an axis."""
    p = places.astype(np.int64)
    return (p[:, 0] << 42) | (p[:, 1] << 21) | p[:, 2]


def _differ(one: AnyArray, other: AnyArray) -> AnyArray:
    """How far sheets (n, 8) are from one another: way of their middles and turn, mm."""
    way = np.linalg.norm(one[:, 4:7] - other[:, 4:7], axis=1)
    area = np.maximum(np.maximum(one[:, 3], other[:, 3]), 1e-9)
    off: AnyArray = way + _TURN_MM * np.linalg.norm(one[:, :3] - other[:, :3], axis=1) / area
    return off

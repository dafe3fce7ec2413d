"""A refined mesh as a list of bisections, small to keep and safe to take from a stranger."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError
from paint3d.mesh.kernels.refine import BAD_LOG, NO_ROOM, repeat_splits
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["refinement_log", "repeat_refinement", "saved_ids"]

_HALVED_AT_ONCE = 1 << 16  # some hundredths of a second
_FIRST_ROOM = 1 << 18  # a log may come from a stranger: more room is made as it proves right


def refinement_log(mesh: PaintMesh) -> NDArray[np.int32]:
    """Return the nodes that were halved (n,), in the order in which they were.

    Nodes are numbered from the source's triangles on, so a log depends on the source mesh and on
    the rules of `mesh.kernels.refine`, but not on the lattice in which vertices are found.
    """
    child = mesh.arrays.child[: int(mesh.arrays.counts[1])]
    halved = np.flatnonzero(child >= 0)
    return halved[np.argsort(child[halved], kind="stable")].astype(np.int32)


def repeat_refinement(
    mesh: PaintMesh, log: NDArray[np.int32], progress: Callable[[float], None] | None = None
) -> None:
    """Refine a fresh mesh as the log says: the same vertices and triangles, in the same order.

    Parameters
    ----------
    mesh : PaintMesh
    log : (n,) int32
    progress : callable, optional
        Called with the share done, now and then; what it raises stops it.

    Raises
    ------
    MeshError
        If the log does not belong to this mesh.
    """
    if len(log) and not mesh.refines:
        raise MeshError("a mesh that is never refined has a refinement log; expected none")
    log, at = np.ascontiguousarray(log, np.int32), np.zeros(1, np.int64)
    if len(log):
        mesh.reserve(min(len(log), _FIRST_ROOM))
    state = 0
    for end in range(_HALVED_AT_ONCE, len(log) + _HALVED_AT_ONCE, _HALVED_AT_ONCE):
        while (state := repeat_splits(mesh.arrays, log[:end], at)) == NO_ROOM:
            mesh.reserve()
        if state == BAD_LOG:
            break
        if progress is not None:
            progress(min(1.0, end / len(log)))
    if state == BAD_LOG:
        raise MeshError(
            f"bisection {int(at[0])} of the refinement log halves triangle {log[at[0]]}, which "
            "this mesh would not halve; expected the log of this mesh"
        )


def saved_ids(mesh: PaintMesh) -> NDArray[np.int32]:
    """Return for each vertex (V,) the number that does not depend on the lattice.

    Base vertices count as they do in the source (one on a crease once for each of its normals),
    added ones follow in the order in which they came.
    """
    ids = np.empty(mesh.n_vertices, np.int32)
    ids[mesh.source_order()] = np.arange(mesh.n_vertices, dtype=np.int32)
    return ids

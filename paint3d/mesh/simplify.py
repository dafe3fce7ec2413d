"""Take back the bisections that colour does not need: the file is small, the picture the same.

Every halved triangle may be made whole again where interpolating the colours of its corners gives
the colours of all the vertices inside to within a tolerance. The surface does not change, nor does
any vertex; without paint the triangles of the source come back.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["coarse_faces"]

Difference = Callable[[AnyArray, AnyArray], AnyArray]

_JUDGED_AT_ONCE = 1 << 16  # triangles: some hundredths of a second


def coarse_faces(
    paint_mesh: PaintMesh,
    colours: AnyArray,
    tolerance: float,
    difference: Difference,
    progress: Callable[[float], None] | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the vertices and triangles that show the colours to within a tolerance.

    Parameters
    ----------
    paint_mesh : PaintMesh
    colours : (V, 3)
        Colours in the space in which a viewer interpolates them (as a rule sRGB codes).
    tolerance : float
        Largest difference that any vertex may have from the interpolated colour; 0 keeps every
        vertex whose colour is not interpolated exactly.
    difference : callable
        ``difference(a, b)`` of colours (n, 3), (n, 3) float64 as (n,), for example CIEDE2000.
    progress : callable, optional
        Called with the share done, now and then; what it raises stops it.

    Returns
    -------
    vertex_ids : (K,) int32
        Vertices of the paint mesh that are kept: base vertices in the source's order, then added
        ones in ascending order.
    faces : (F, 3) int32
        Triangles as places in `vertex_ids`. There are no cracks: triangles on one edge are halved
        together.

    Raises
    ------
    InputError
        If `colours` is not finite or has the wrong shape, or the tolerance is negative.

    Notes
    -----
    The bound holds at every vertex of the paint mesh, because each is compared with all the
    triangles of the forest that it lies in. Cost: about one difference for each halved triangle
    with changing colour and each level above it, and none where colour is uniform.
    """
    colours = as_array(colours, "colours", (paint_mesh.n_vertices, 3))
    tolerance = as_number(tolerance, "tolerance", low=0.0)
    order = paint_mesh.source_order()
    if not paint_mesh.refines:
        return _compact(order, paint_mesh.base_faces, paint_mesh.n_base_vertices)
    forest = _Forest(paint_mesh)
    wanted = forest.close(forest.coarse_misses(colours, tolerance, difference, progress))
    return _compact(order, forest.faces(wanted), paint_mesh.n_base_vertices)


def _compact(order: AnyArray, faces: AnyArray, n_base: int) -> tuple[AnyArray, AnyArray]:
    """Number the vertices that are used, in the given order; base vertices always stay."""
    used = np.zeros(len(order), bool)
    used[:n_base] = True
    used[faces] = True
    kept = order[used[order]]
    place = np.empty(len(order), np.int32)
    place[kept] = np.arange(len(kept), dtype=np.int32)
    return kept, place[faces]


class _Forest:
    """The bisection forest, seen from its halved nodes (H of them, out of N nodes)."""

    def __init__(self, mesh: PaintMesh) -> None:
        field, n = mesh.arrays, int(mesh.arrays.counts[1])
        self.n_roots = len(mesh.base_faces)
        self.nodes = field.node_vertices[:n]
        self.child = field.child[:n]
        self.edge = field.longest[:n].astype(np.int64)
        self.halved = np.flatnonzero(self.child >= 0)
        self.parent = np.full(n, -1, np.int32)
        for side in (0, 1):
            self.parent[self.child[self.halved] + side] = self.halved
        self.split = _splits(mesh)[self.nodes[self.child[self.halved], 1]]

    def coarse_misses(
        self,
        colours: AnyArray,
        tolerance: float,
        difference: Difference,
        progress: Callable[[float], None] | None = None,
    ) -> NDArray[np.bool_]:
        """(N,) bool: nodes that are too coarse for one of the vertices inside."""
        misses = np.zeros(len(self.nodes), bool)
        node: AnyArray = self.halved
        vertex = self.nodes[self.child[node], 1]
        weights = np.zeros((len(node), 3))
        rows = np.arange(len(node))
        weights[rows, self.edge[node]] = 0.5
        weights[rows, (self.edge[node] + 1) % 3] = 0.5
        total, done = self._n_judged() if progress is not None else 0, 0
        while len(node):
            for at in range(0, len(node), _JUDGED_AT_ONCE):
                some = slice(at, at + _JUDGED_AT_ONCE)
                told = node[some], vertex[some], weights[some]
                self._judge(misses, *told, colours, tolerance, difference)
                if progress is not None:
                    done += len(told[0])
                    progress(done / total)
            above = self.parent[node]
            inner = above >= 0
            weights = self._lift(node[inner], above[inner], weights[inner])
            node, vertex = above[inner], vertex[inner]
        return misses

    def _n_judged(self) -> int:
        """How many pairs there are of a halved node and itself or one above it."""
        node: AnyArray = self.halved
        total = 0
        while len(node):
            total += len(node)
            above = self.parent[node]
            node = above[above >= 0]
        return total

    def _judge(
        self,
        misses: AnyArray,
        node: AnyArray,
        vertex: AnyArray,
        weights: AnyArray,
        colours: AnyArray,
        tolerance: float,
        difference: Difference,
    ) -> None:
        open_rows = np.flatnonzero(~misses[node])
        node, vertex = node[open_rows], vertex[open_rows]
        corners = colours[self.nodes[node]]
        plain = (corners == colours[vertex][:, None]).all(axis=(1, 2))
        rows = np.flatnonzero(~plain)
        shown = np.einsum("nk,nkc->nc", weights[open_rows[rows]], corners[rows])
        if len(rows):
            far = difference(shown, colours[vertex[rows]]) > tolerance
            misses[node[rows[far]]] = True

    def _lift(self, node: AnyArray, above: AnyArray, weights: AnyArray) -> AnyArray:
        """Barycentric weights in a node as weights in its parent.

        Child 0 of (a, b, c) halved at m on ab is (a, m, c), child 1 is (m, b, c).
        """
        rows = np.arange(len(node))
        second = node != self.child[above]
        middle = np.where(second, 0, 1)
        half = 0.5 * weights[rows, middle]
        own = weights[rows, 1 - middle]
        turn = self.edge[above]
        lifted = np.empty_like(weights)
        lifted[rows, turn] = np.where(second, half, own + half)
        lifted[rows, (turn + 1) % 3] = np.where(second, own + half, half)
        lifted[rows, (turn + 2) % 3] = weights[:, 2]
        return lifted

    def close(self, misses: AnyArray) -> NDArray[np.bool_]:
        """(N,) bool: nodes to halve, with all that must be halved before or along with them."""
        wanted = np.zeros(int(self.split.max(initial=-1)) + 1, bool)
        split_of = np.full(len(self.nodes), -1, np.int64)
        split_of[self.halved] = self.split
        fresh = np.zeros_like(wanted)
        fresh[split_of[misses]] = True
        while fresh.any():
            wanted |= fresh
            above = self.parent[self.halved[fresh[self.split]]]
            fresh = np.zeros_like(wanted)
            fresh[split_of[above[above >= 0]]] = True
            fresh &= ~wanted
        halve = np.zeros(len(self.nodes), bool)
        halve[self.halved] = wanted[self.split]
        return halve

    def faces(self, halve: AnyArray) -> AnyArray:
        """Triangles (F, 3) of the forest with only some of its nodes halved."""
        there = np.zeros(len(self.nodes), bool)
        there[: self.n_roots] = True
        for side in (0, 1):
            there[self.child[halve] + side] = True
        return self.nodes[there & ~halve]


def _splits(mesh: PaintMesh) -> NDArray[np.int64]:
    """(V,) int64: which halving of an edge made a vertex; both sides of a crease share one.

    They are made one after the other, with the same key.
    """
    keys = mesh.arrays.key[: mesh.n_vertices]
    starts = np.ones(len(keys), bool)
    starts[1:] = keys[1:] != keys[:-1]
    return np.cumsum(starts) - 1

"""Undo the bisections that colour does not need: a smaller file, the same picture.

A halved triangle is merged again where interpolating the colours of its corners gives the colours
of all the vertices inside to within a tolerance. The surface does not change, nor does any vertex;
without paint the result is the triangles of the source.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from paint3d.core.arrays import AnyArray, as_array, as_number
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["coarse_faces"]

Difference = Callable[[AnyArray, AnyArray], AnyArray]

_BLOCK = 1 << 16  # triangles compared at a time: some hundredths of a second


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
        Called with the fraction done, now and then; what it raises aborts.

    Returns
    -------
    vertex_ids : (K,) int32
        Vertices of the paint mesh that are kept: base vertices in the source's order, then added
        ones in ascending order.
    faces : (F, 3) int32
        Triangles as indices into `vertex_ids`. There are no cracks: triangles on one edge are
        halved together.

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
    """Renumber the vertices that are used, in the given order; base vertices always stay."""
    used = np.zeros(len(order), bool)
    used[:n_base] = True
    used[faces] = True
    kept = order[used[order]]
    index = np.empty(len(order), np.int32)
    index[kept] = np.arange(len(kept), dtype=np.int32)
    return kept, index[faces]


class _Forest:
    """The bisection forest: N nodes, of which H are halved."""

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
        # One halving of an edge makes its vertices, several on a crease, one after the other and
        # with the same key: number the halvings by the runs of keys.
        keys = mesh.arrays.key[: mesh.n_vertices]
        starts = np.ones(len(keys), bool)
        starts[1:] = keys[1:] != keys[:-1]
        split_of_vertex: AnyArray = np.cumsum(starts) - 1
        self.split = split_of_vertex[self.nodes[self.child[self.halved], 1]]

    def coarse_misses(
        self,
        colours: AnyArray,
        tolerance: float,
        difference: Difference,
        progress: Callable[[float], None] | None = None,
    ) -> NDArray[np.bool_]:
        """Return the nodes (N,) bool that are too coarse for one of the vertices inside."""
        misses = np.zeros(len(self.nodes), bool)
        node: AnyArray = self.halved
        vertex = self.nodes[self.child[node], 1]
        weights = np.zeros((len(node), 3))
        rows = np.arange(len(node))
        weights[rows, self.edge[node]] = 0.5
        weights[rows, (self.edge[node] + 1) % 3] = 0.5
        total, done = self._count_pairs() if progress is not None else 0, 0
        while len(node):
            for start in range(0, len(node), _BLOCK):
                block = np.arange(start, min(start + _BLOCK, len(node)))
                done += len(block)
                block = block[~misses[node[block]]]
                corners = colours[self.nodes[node[block]]]
                # nothing to compare where all corners have the vertex's own colour
                uniform = (corners == colours[vertex[block]][:, None]).all(axis=(1, 2))
                block, corners = block[~uniform], corners[~uniform]
                if len(block):
                    shown = np.einsum("nk,nkc->nc", weights[block], corners)
                    far = difference(shown, colours[vertex[block]]) > tolerance
                    misses[node[block[far]]] = True
                if progress is not None:
                    progress(done / total)
            above = self.parent[node]
            inner = above >= 0
            weights = self._lift(node[inner], above[inner], weights[inner])
            node, vertex = above[inner], vertex[inner]
        return misses

    def _count_pairs(self) -> int:
        """Count the pairs of a halved node and itself or an ancestor."""
        node: AnyArray = self.halved
        total = 0
        while len(node):
            total += len(node)
            above = self.parent[node]
            node = above[above >= 0]
        return total

    def _lift(self, node: AnyArray, above: AnyArray, weights: AnyArray) -> AnyArray:
        """Convert barycentric weights in a node to weights in its parent.

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
        """Return the nodes (N,) bool to halve, with all that must be halved before or with them."""
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
        """Return the triangles (F, 3) of the forest with only the nodes `halve` (N,) halved."""
        there = np.zeros(len(self.nodes), bool)
        there[: self.n_roots] = True
        for side in (0, 1):
            there[self.child[halve] + side] = True
        return self.nodes[there & ~halve]

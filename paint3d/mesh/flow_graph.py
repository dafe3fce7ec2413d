"""The graph on which liquids move over a patch of surface: who touches whom, how strongly.

Vertices at the same place on both sides of a crease are one node. Weights are the cotangents of
the intrinsic Delaunay triangulation of the patch (`kernels.intrinsic`); areas are those of the
paint mesh, so that what is counted here is what is counted there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from paint3d.kernels.intrinsic import cotangent_weights, flip_to_delaunay, pair_edges

__all__ = ["FlowGraph", "build_flow_graph", "graph_of_triangles"]


class FlowGraph(NamedTuple):
    """N nodes, L links in either direction, C vertices (several on a crease share a node)."""

    vertices: NDArray  # (C,) int32, ids in the paint mesh
    node_of: NDArray  # (C,) int32
    points: NDArray  # (N, 3) float64, mm
    area: NDArray  # (N,) float64, mm2
    rim: NDArray  # (N,) uint8, 1 where triangles around the node are missing
    runs: NDArray  # (N + 1,) int64
    links: NDArray  # (L,) int32
    weights: NDArray  # (L,) float64, >= 0

    @property
    def n_nodes(self) -> int:
        """Nodes, N."""
        return len(self.area)


def graph_of_triangles(points: NDArray, faces: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Links of a triangle mesh: points (N, 3), faces (F, 3) to `runs`, `links`, `weights`.

    Triangles without an area are left out. Cost: about 1.5 us a triangle.
    """
    faces = np.array(faces, np.int32)
    corners = points[faces].astype(np.float64)
    lengths = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    longest = lengths.max(axis=1)
    solid = (lengths.sum(axis=1) - 2.0 * longest > 1e-9 * longest) & (lengths.min(axis=1) > 0.0)
    faces, lengths = np.ascontiguousarray(faces[solid]), np.ascontiguousarray(lengths[solid])
    n = len(points)
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
    keys = ends.min(axis=1) * n + ends.max(axis=1)
    mates = np.empty(len(keys), np.int64)
    pair_edges(np.argsort(keys, kind="stable"), keys, mates)
    flip_to_delaunay(faces, lengths, mates)
    halves = np.empty(lengths.shape)
    cotangent_weights(lengths, halves)
    return _links(n, faces.ravel(), np.roll(faces, -1, axis=1).ravel(), halves.ravel())


def _links(n: int, a: NDArray, b: NDArray, halves: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Add up the weights of half-edges a-b; negative ones, at borders alone, become 0."""
    key = np.concatenate([a.astype(np.int64) * n + b, b.astype(np.int64) * n + a])
    weight = np.concatenate([halves, halves])
    order = np.argsort(key, kind="stable")
    key, weight = key[order], weight[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])) if len(key) else key
    weight = np.add.reduceat(weight, first) if len(key) else weight
    key = key[first]
    kept = (weight > 0.0) & (key // n != key % n)
    key, weight = key[kept], weight[kept]
    runs = np.searchsorted(key, np.arange(n + 1, dtype=np.int64) * n)
    return runs.astype(np.int64), (key % n).astype(np.int32), weight


def build_flow_graph(fields, faces: NDArray, area_of: NDArray, in_patch: NDArray) -> FlowGraph:
    """The graph of all triangles that have a vertex in the patch.

    Parameters
    ----------
    fields : SurfaceField
    faces : (F, 3) int32
        The triangles that there are.
    area_of : (V,) float64
        mm2 that each vertex stands for.
    in_patch : (V,) bool
        Vertices whose triangles are wanted; the others of these triangles become the rim.
    """
    chosen = faces[in_patch[faces].any(axis=1)]
    ids = np.unique(chosen)
    ids = ids[np.argsort(fields.vertex_sheet[ids], kind="stable")]  # near in space, near in memory
    _, first, inverse = np.unique(fields.key[ids], return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int32)
    rank[np.argsort(first, kind="stable")] = np.arange(len(first), dtype=np.int32)
    node_of = rank[inverse.ravel()]
    n = len(first)
    local = np.empty(len(in_patch), np.int32)
    local[ids] = node_of
    points = np.empty((n, 3))
    points[node_of] = np.column_stack([fields.px[ids], fields.py[ids], fields.pz[ids]])
    rim = np.zeros(n, np.uint8)
    rim[node_of[~in_patch[ids]]] = 1
    area = np.bincount(node_of, weights=area_of[ids], minlength=n)
    links = graph_of_triangles(points, local[chosen])
    return FlowGraph(ids.astype(np.int32), node_of, points, area, rim, *links)

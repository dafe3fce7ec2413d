"""Box trees over triangles, and the contact tree of a paint mesh that is asked for footprints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from paint3d.core.types import AnyArray
from paint3d.mesh.kernels.bvh import LEAF_SIZE, ContactTree, build_boxes
from paint3d.mesh.kernels.median_split import order_by_halving
from paint3d.mesh.refined_mesh import PaintMesh

__all__ = ["build_box_tree", "build_contact_tree"]


def build_contact_tree(mesh: PaintMesh) -> ContactTree:
    """Build the box tree over the base triangles of `mesh`, in Morton order of their centres."""
    triangles = np.ascontiguousarray(mesh.base_faces, dtype=np.int32)
    n_base = mesh.n_base_vertices
    points = np.ascontiguousarray(mesh.vertices[:n_base], dtype=np.float32)
    normals = np.ascontiguousarray(mesh.normals[:n_base], dtype=np.float32)
    order, boxes, triangles = build_box_tree(points, triangles, LEAF_SIZE)
    return ContactTree(order, boxes, triangles, points, normals)


def build_box_tree(
    points: NDArray[np.float32],
    triangles: NDArray[np.int32],
    leaf_size: int,
    *,
    halve: bool = False,
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Build a box tree over triangles.

    Parameters
    ----------
    points : (V, 3) float32
    triangles : (T, 3) int32
    leaf_size : int
        Triangles to each leaf.
    halve : bool
        Whether every half, quarter and so on shall lie together in a box; else they are in Morton
        order. Closest points are found three times as fast; a million triangles take 0.4 s more.

    Returns
    -------
    order : (T,) int32
        The triangles in the tree's order.
    boxes : (2 L, 6) float32
        Low and high corners in heap order, the triangles lying in the latter half, the leaves.
    triangles : (T, 3) int32
        Vertex ids in that order.
    """
    centres = _centres(points, triangles)
    order = _morton_order(centres)
    n_leaves = 1
    while n_leaves * leaf_size < len(triangles):
        n_leaves *= 2
    if halve:
        order_by_halving(np.ascontiguousarray(centres[order]), n_leaves, leaf_size, order)
    triangles = np.ascontiguousarray(triangles[order])
    boxes = np.empty((2 * n_leaves, 6), np.float32)
    build_boxes(triangles, points, boxes, leaf_size)
    return order, boxes, triangles


def _centres(points: AnyArray, triangles: AnyArray) -> AnyArray:
    """Three times the triangles' centres (T, 3) float32."""
    centres = np.zeros((len(triangles), 3), np.float32)
    for corner in range(3):
        centres += points[triangles[:, corner]]
    return centres


def _morton_order(centres: AnyArray) -> AnyArray:
    """Triangle ids (T,) int32 sorted by the interleaved bits of their centres' coordinates."""
    low = centres.min(axis=0)
    span = max(float((centres.max(axis=0) - low).max()), 1e-12)
    grid = ((centres - low) * (1023.0 / span)).astype(np.uint32)
    code = np.zeros(len(centres), np.uint32)
    for axis in range(3):
        bits = grid[:, axis]
        for shift, mask in (
            (16, 0x030000FF),
            (8, 0x0300F00F),
            (4, 0x030C30C3),
            (2, 0x09249249),
        ):
            bits = (bits | (bits << np.uint32(shift))) & np.uint32(mask)
        code |= bits << np.uint32(axis)
    return np.argsort(code, kind="stable").astype(np.int32)

"""Ball pivoting: a surface through a point cloud by a ball that rolls over it."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from paint3d.errors import MeshError

__all__ = ["surface_through"]

FEWEST_POINTS = 20
NEIGHBOURS = 16
RADII = (1.0, 1.5, 2.5, 4.0)  # of the ball, in typical distances between neighbours
LEAST_REACHED = 0.9  # of the points that the surface must reach to be worth painting


def surface_through(
    points: NDArray[np.float64], normals: NDArray[np.float64] | None = None
) -> NDArray[np.int64]:
    """Return triangles between the points of a scanned surface.

    Ball pivoting keeps the points as vertices and bridges no gap wider than four spacings, so
    holes of the scan stay holes.

    Parameters
    ----------
    points : (V, 3) float64
    normals : (V, 3) float64, optional
        Outward directions. Estimated where not given, and then turned consistently and, on the
        whole, away from the middle.

    Returns
    -------
    (F, 3) int64

    Raises
    ------
    MeshError
        If there are fewer than 20 points or fewer than nine in ten of them could be joined.
    """
    if len(points) < FEWEST_POINTS:
        raise MeshError(
            "it has {n} points and no triangles; expected at least {fewest_points} points to build "
            "a surface through",
            n=len(points),
            fewest_points=FEWEST_POINTS,
        )
    open3d = _open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    if normals is not None and np.isfinite(normals).all() and normals.any(axis=1).all():
        cloud.normals = open3d.utility.Vector3dVector(normals)
    else:
        _estimate_normals(cloud, points)
    spacing = float(np.median(cloud.compute_nearest_neighbor_distance()))
    if not (np.isfinite(spacing) and spacing > 0.0):
        raise MeshError(
            "most of its {n:,} points lie in the place of another; expected points that lie evenly "
            "on a surface",
            n=len(points),
        )
    radii = open3d.utility.DoubleVector([k * spacing for k in RADII])
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        build = open3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting
        try:
            faces = np.asarray(build(cloud, radii).triangles, np.int64).copy()
        except RuntimeError as cause:
            raise MeshError("no surface goes through its points: {cause}", cause=cause) from None
    reached = len(np.unique(faces)) / len(points)
    if reached < LEAST_REACHED:
        raise MeshError(
            "a surface through its {n:,} points reaches only {reached:.0%} of them; expected "
            "points that lie evenly on a surface",
            n=len(points),
            reached=reached,
        )
    return faces


def _open3d() -> ModuleType:
    try:
        import open3d
    except ImportError as cause:
        raise MeshError(
            "it is a point cloud, and a surface through points is built by Open3D: {cause}; "
            "expected a file with triangles",
            cause=cause,
            hint="pip install 'paint3d[open3d]'",
        ) from None
    return open3d


def _estimate_normals(cloud: Any, points: NDArray[np.float64]) -> None:
    open3d = _open3d()
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(NEIGHBOURS))
    cloud.normals = open3d.utility.Vector3dVector(_orient(points, np.asarray(cloud.normals)))


def _orient(points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return normals (V, 3) that agree among neighbours and point away from the middle.

    The sign is handed on along the tree between neighbours whose normals differ least (Hoppe et
    al. 1992, section 3.3), in each connected piece. Open3D's own way takes seven times as long.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, connected_components
    from scipy.sparse.csgraph import minimum_spanning_tree as spanning_tree
    from scipy.spatial import cKDTree

    n = len(points)
    near = cKDTree(points).query(points, min(NEIGHBOURS, n))[1].astype(np.int32)
    ends = np.repeat(np.arange(n, dtype=np.int32), near.shape[1]), near.ravel()
    alike = np.abs(np.einsum("ij,ij->i", normals[ends[0]], normals[ends[1]]))
    # the sum of equal pairs would be their weight; a weight of 0 would be no edge
    tree = spanning_tree(coo_array((1.01 - alike, ends), shape=(n, n)).tocsr())
    n_pieces, piece = connected_components(tree, directed=False)
    turned, sign = normals.copy(), np.ones(n, np.int8)
    for k in range(n_pieces):
        members = np.flatnonzero(piece == k)
        order, before = breadth_first_order(tree, members[0], directed=False)
        same = np.einsum("ij,ij->i", normals[order[1:]], normals[before[order[1:]]]) >= 0.0
        for node, agrees in zip(order[1:].tolist(), same.tolist(), strict=True):
            sign[node] = sign[before[node]] if agrees else -sign[before[node]]
        ours = normals[members] * sign[members, None]
        outward = np.einsum("ij,ij->", ours, points[members] - points[members].mean(axis=0))
        turned[members] = -ours if outward < 0.0 else ours
    return turned

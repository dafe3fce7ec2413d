"""Closest points and ray hits: what a search through every triangle finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.kernels.bvh import _enters, order_by_halving
from paint3d.mesh.triangle_mesh import TriangleMesh
from scripts.solids import make_bowl, make_plane

UP = np.array([0.0, 0.0, 1.0])
seeds = st.integers(0, 2**32 - 1)


def soup(seed: int, n_faces: int, slivers: bool = True) -> TriangleMesh:
    """Triangles anywhere, among them slivers, doubled ones, and ones without area."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(scale=10.0, size=(n_faces, 1, 3)) + rng.normal(size=(n_faces, 3, 3))
    kind = rng.integers(0 if slivers else 2, 6, n_faces)
    kind[0] = 5
    line = corners[:, 0] + rng.uniform(-1.0, 2.0, (n_faces, 1)) * (corners[:, 1] - corners[:, 0])
    corners[:, 2][kind == 0] = line[kind == 0]
    corners[:, 2][kind == 1] = line[kind == 1] + 1e-4
    corners[:, 1][kind == 2] = corners[:, 0][kind == 2]
    corners[kind == 3] = corners[0]
    return TriangleMesh(corners.reshape(-1, 3), np.arange(3 * n_faces).reshape(-1, 3))


def queries(seed: int, mesh: TriangleMesh, n: int) -> NDArray:
    """Points near and far, and some that lie on corners and edges."""
    rng = np.random.default_rng(seed)
    points = rng.normal(scale=rng.choice([2.0, 12.0, 300.0], (n, 1)), size=(n, 3))
    corners = mesh.vertices[mesh.faces[rng.integers(0, mesh.n_faces, n)]].astype(np.float64)
    points[::4] = corners[::4, 0]
    points[1::4] = 0.5 * (corners[1::4, 0] + corners[1::4, 1])
    return points


def test_rays_do_not_enter_boxes_that_hold_nothing() -> None:
    boxes = np.array([[-np.inf] * 6, [np.inf] * 3 + [-np.inf] * 3, [0.0] * 3 + [1.0] * 3])
    ray = np.array([0.5, 0.5, 9.0, 0.1, 0.0, -2.0])
    assert not _enters(boxes, 1, ray, np.inf)
    assert _enters(boxes, 2, ray, np.inf)


def distance_to_segments(points: NDArray, a: NDArray, b: NDArray) -> NDArray:
    """Distances (N, F) of points (N, 3) from segments (F, 3)."""
    along = b - a
    length2 = np.sum(along * along, axis=1)
    share = np.einsum("nfk,fk->nf", points[:, None] - a, along)
    share = np.clip(share / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    return np.linalg.norm(points[:, None] - a - share[..., None] * along, axis=2)


def brute_distance(mesh: TriangleMesh, points: NDArray) -> NDArray:
    """Distances (N,) of points from a mesh: to every edge, and to every plane above an inside."""
    faces = mesh.faces[mesh.double_areas > 0.0]
    a, b, c = (mesh.vertices[faces[:, k]].astype(np.float64) for k in range(3))
    edges = [distance_to_segments(points, p, q) for p, q in ((a, b), (b, c), (c, a))]
    nearest = np.minimum.reduce(edges)
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    normal /= np.where(area > 0.0, area, 1.0)[:, None]
    sides = [
        np.einsum("nfk,fk->nf", np.cross(q - p, points[:, None] - p), normal)
        for p, q in ((a, b), (b, c), (c, a))
    ]
    above = (np.minimum.reduce(sides) >= 0.0) & (area > 1e-9)
    height = np.abs(np.einsum("nfk,fk->nf", points[:, None] - a, normal))
    return np.where(above, np.minimum(nearest, height), nearest).min(axis=1)


@settings(deadline=None, max_examples=25)
@given(seed=seeds, n_faces=st.integers(1, 80))
def test_no_triangle_is_nearer(seed: int, n_faces: int) -> None:
    mesh = soup(seed, n_faces)
    points = queries(seed, mesh, 60)
    found = ClosestPoints(mesh).find(points)
    away = np.linalg.norm(found.points - points, axis=1)
    expected = brute_distance(mesh, points)
    np.testing.assert_allclose(away, expected, rtol=1e-9, atol=1e-7)
    corners = mesh.vertices[mesh.faces[found.faces]].astype(np.float64)
    np.testing.assert_allclose(
        np.einsum("nk,nkd->nd", found.barycentric, corners), found.points, atol=1e-9
    )
    assert (found.barycentric >= -1e-12).all()
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0, atol=1e-12)
    assert (mesh.double_areas[found.faces] > 0.0).all()


def test_a_needle_has_edges_only() -> None:
    corners = np.array([[0, 0, 0], [9227465, 5702887, 0], [5702887, 3524578, 0]]) / 2**16
    needle = ClosestPoints(TriangleMesh(corners, [[0, 1, 2]]))  # 2e-10 mm2, 165 mm long
    along = np.random.default_rng(4).uniform(size=(200, 1)) * corners[1]
    away = np.linalg.norm(needle.find(along + UP).points - along, axis=1)
    np.testing.assert_allclose(away, 0.0, atol=1e-9)


@settings(deadline=None, max_examples=25)
@given(seed=seeds, n_faces=st.integers(1, 80), length=st.floats(0.01, 100.0))
def test_no_triangle_is_hit_before(seed: int, n_faces: int, length: float) -> None:
    mesh = soup(seed, n_faces, slivers=False)  # where a ray meets a sliver is hardly a question
    rng = np.random.default_rng(seed)
    origins = rng.normal(scale=20.0, size=(60, 3))
    aims = np.einsum(
        "nk,nkd->nd",
        rng.dirichlet(np.ones(3), 60),
        mesh.vertices[mesh.faces[rng.integers(0, n_faces, 60)]].astype(np.float64),
    )
    directions = aims - origins
    directions[::2] = rng.normal(size=(30, 3))
    directions *= length / np.linalg.norm(directions, axis=1, keepdims=True)
    hits = ClosestPoints(mesh).cast(origins, directions)
    a, b, c = (mesh.vertices[mesh.faces[:, k]].astype(np.float64) for k in range(3))
    expected = np.full(60, np.inf)
    for i in range(60):
        for f in range(n_faces):
            system = np.column_stack([b[f] - a[f], c[f] - a[f], -directions[i]])
            if abs(np.linalg.det(system)) < 1e-9 * length:
                continue
            v, w, t = np.linalg.solve(system, origins[i] - a[f])
            if min(v, w, 1.0 - v - w) > 1e-7 and t >= 0.0:
                expected[i] = min(expected[i], t)
    clear = np.isfinite(expected) | ~hits.hit  # what only grazes an edge may be hit or not
    np.testing.assert_allclose(hits.distance[clear], expected[clear], rtol=1e-6)
    assert (hits.distance[~clear] > 0.0).all()
    assert (hits.faces[hits.hit] >= 0).all()
    assert (hits.faces[~hits.hit] == -1).all()
    on = hits.points[hits.hit]
    assert np.isnan(hits.points[~hits.hit]).all()
    if len(on):
        assert brute_distance(mesh, on).max() < 1e-6


def test_rays_find_no_gap_between_triangles() -> None:
    bowl = make_bowl()
    low, high = bowl.bounds
    rng = np.random.default_rng(5)
    share = rng.uniform(size=(bowl.n_faces, 1))
    edge = bowl.vertices[bowl.faces].astype(np.float64)
    on_edges = edge[:, 0] + share * (edge[:, 1] - edge[:, 0])
    aims = np.concatenate([on_edges, edge[:, 0]])
    origin = 0.5 * (low + high) + np.array([0.0, 0.0, 3.0 * (high - low)[2]])
    hits = ClosestPoints(bowl).cast(np.broadcast_to(origin, aims.shape), aims - origin)
    assert hits.hit.all()
    assert (hits.distance <= 1.0 + 1e-9).all()


def test_rays_find_no_gap_where_flat_boxes_meet() -> None:
    plane = make_plane()
    surface, aims = ClosestPoints(plane), plane.vertices.astype(np.float64)
    inside = (np.abs(aims[:, :2]) < aims[:, :2].max()).all(axis=1)  # at the rim rounding decides
    ways = np.random.default_rng(9).normal(size=(8, 3))
    ways[:, 2] = np.abs(ways[:, 2]) + 0.5
    for way, at in [([0, 0, 1], aims), ([0, 0, -1], aims), *((way, aims[inside]) for way in ways)]:
        hits = surface.cast(at - way, np.broadcast_to(way, at.shape))
        assert hits.hit.all()
        np.testing.assert_allclose(hits.points, at, atol=1e-9)


def test_what_lies_behind_is_not_hit() -> None:
    slope = ClosestPoints(TriangleMesh(np.array([[0, 0, 0], [4, 0, 4], [0, 4, 4]]), [[0, 1, 2]]))
    above = np.array([[1.0, 1.0, 2.5]] * 3)
    hits = slope.cast(above, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 1.0, 2.0]])
    np.testing.assert_array_equal(hits.distance, [np.inf, 0.5, np.inf])
    along = slope.cast([[-1.0, -1.0, -2.0]], [[1.0, 1.0, 2.0]])
    assert not along.hit.any()  # a ray within the plane meets the triangle's edges at most


@settings(deadline=None, max_examples=25)
@given(seed=seeds, n=st.integers(1, 300), leaf_size=st.sampled_from([1, 2, 8]))
def test_halves_lie_apart(seed: int, n: int, leaf_size: int) -> None:
    rng = np.random.default_rng(seed)
    centres = rng.integers(0, 6, (n, 3)).astype(np.float32)  # many are equal
    n_leaves = 1
    while n_leaves * leaf_size < n:
        n_leaves *= 2
    order, sorted_centres = rng.permutation(n).astype(np.int32), centres.copy()
    numbered = np.empty_like(centres)
    numbered[order] = centres
    order_by_halving(sorted_centres, n_leaves, leaf_size, order)
    assert sorted(order) == list(range(n))
    np.testing.assert_array_equal(sorted_centres, numbered[order])
    size = n_leaves * leaf_size
    while size > leaf_size:
        for low in range(0, n, size):
            part = sorted_centres[low : low + size]
            axis = np.argmax(part.max(axis=0) - part.min(axis=0))
            if len(part) > size // 2:  # along the longest side, and of equal ones by their numbers
                key = list(zip(part[:, axis].tolist(), order[low : low + size], strict=True))
                assert max(key[: size // 2]) < min(key[size // 2 :])
        size //= 2


def test_of_equal_triangles_the_first_counts() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    once = [[0, 1, 2], [2, 1, 3]]
    points = np.array([[0.2, 0.2, 1.0], [0.8, 0.7, -2.0], [0.5, 0.5, 1.0], [0.0, 0.0, 1e200]])
    for order in ([0, 1], [1, 0]):
        surface = ClosestPoints(TriangleMesh(corners, np.array(once)[order * 20]))
        assert surface.find(points).faces.tolist() == [order[0], order[1], 0, 0]
        assert surface.cast(points[:1], [[0.0, 0.0, -1.0]]).faces.tolist() == [order[0]]


def test_where_corner_normals_cancel_out_the_face_has_its_own() -> None:
    surface = ClosestPoints(TriangleMesh(np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]]), [[0, 1, 2]]))
    twisted = np.array([[0, 1, 0], [0, -1, 0], [0, 1, 0]], np.float32)
    surface.tree = surface.tree._replace(normals=twisted)
    normals = surface.find([[1.0, -1.0, 3.0], [0.0, 0.0, 3.0]]).normals
    np.testing.assert_array_equal(normals, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


def test_normals_bend_with_the_surface_and_keep_its_edges() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 97)[:-1]
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    rims = [np.column_stack([30.0 * ring, np.full(96, z)]) for z in (0.0, 20.0)]
    k = np.arange(96)
    n = (k + 1) % 96
    wall = np.concatenate([np.column_stack([k, n, n + 96]), np.column_stack([k, n + 96, k + 96])])
    lid = np.column_stack([k + 96, n + 96, np.full(96, 192)])
    mesh = TriangleMesh(np.concatenate([*rims, [[0.0, 0.0, 20.0]]]), np.concatenate([wall, lid]))
    turn = np.array([0.013, 1.7, 4.0])
    way = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(3)])
    found = ClosestPoints(mesh).find(35.0 * way + [0.0, 0.0, 7.0])
    half_a_facet = np.pi / 96.0
    assert np.arccos(np.sum(found.normals * way, axis=1)).max() < 0.2 * half_a_facet
    above = ClosestPoints(mesh).find(29.9 * way + [0.0, 0.0, 21.0])
    np.testing.assert_allclose(above.normals, [[0.0, 0.0, 1.0]] * 3, atol=1e-6)


def test_points_that_are_none_are_refused() -> None:
    surface = ClosestPoints(make_bowl())
    with pytest.raises(InputError, match="points"):
        surface.find(np.array([[0.0, np.nan, 1.0]]))
    with pytest.raises(InputError, match="directions"):
        surface.cast(np.zeros((2, 3)), np.zeros((1, 3)))
    assert surface.find(np.zeros((0, 3))).faces.shape == (0,)
    assert not surface.cast([[0.0, 0.0, 1e3]], [[0.0, 0.0, 0.0]]).hit.any()

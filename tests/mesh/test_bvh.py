"""Foot points: the kernel's search against brute force and against other programs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from paint3d.errors import InputError
from paint3d.mesh.bvh import ClosestPoints, build_contact_tree
from paint3d.mesh.kernels.bvh import _enters, closest_point, find_foot, order_by_halving
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from scripts.solids import make_bowl, make_plane
from tests.support.surface_cases import ball, flat, sheet, together, turned_over

UP = (0.0, 0.0, 1.0)


def noisy(seed: int = 2, n: int = 250) -> TriangleMesh:
    """A rough height field of irregular triangles."""
    rng = np.random.default_rng(seed)
    plan = rng.uniform(-10.0, 10.0, (n, 2))
    height = np.sin(0.5 * plan[:, 0]) + rng.normal(0.0, 0.15, n)
    faces = Delaunay(plan).simplices
    a, b, c = (plan[faces[:, k]] for k in range(3))
    left = np.cross(np.c_[b - a, np.zeros(len(a))], np.c_[c - a, np.zeros(len(a))])[:, 2] < 0.0
    faces[left] = faces[left][:, ::-1]
    return TriangleMesh(np.column_stack([plan, height]), faces)


def queries(n: int, low: float, high: float, seed: int = 5) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.uniform([-9.0, -9.0, low], [9.0, 9.0, high], (n, 3))


def foots(search, mesh: TriangleMesh, points: np.ndarray, up=UP, reach: float = 50.0):
    tree = build_contact_tree(PaintMesh.build(mesh, None))
    out = np.zeros((len(points), 6))
    hit = []
    for k, p in enumerate(points):
        extra = () if search is closest_point else (np.zeros(5),)
        hit.append(search(tree, tuple(p), tuple(up), reach, out[k], *extra))
    return np.array(hit), out, tree


def test_going_on_from_the_last_foot_finds_the_same():
    angle = np.linspace(0.0, 0.5, 300)
    points = 60.0 * np.stack([np.sin(angle), 0.2 * angle, np.cos(angle)], axis=1)
    mesh = ball(30.0, 3.0)
    hit, cold, tree = foots(find_foot, mesh, points)
    warm, out = np.zeros(5), np.zeros(6)
    for k, point in enumerate(points):
        triangle = find_foot(tree, tuple(point), UP, 50.0, out, warm)
        assert (triangle >= 0) == (hit[k] >= 0)
        np.testing.assert_allclose(out, cold[k], atol=3e-4)
    far = find_foot(tree, (0.0, 0.0, 500.0), UP, 50.0, out, warm)
    assert far == -1
    assert warm[0] == 0.0


def test_closest_point_is_that_of_the_facing_triangles():
    mesh = together(ball(6.0, 1.0), noisy())
    up = np.array([0.6, 0.0, 0.8])
    points = queries(300, -8.0, 9.0)
    hit, out, _ = foots(closest_point, mesh, points, up)
    facing = mesh.face_normals @ up > 0.0
    other = ClosestPoints(TriangleMesh(mesh.vertices, mesh.faces[facing])).find(points)
    ours = np.linalg.norm(out[:, :3] - points, axis=1)
    theirs = np.linalg.norm(other.points - points, axis=1)
    assert (hit >= 0).all()
    np.testing.assert_allclose(ours, theirs, atol=2e-5)


def test_nothing_within_reach_is_told():
    hit, _, _ = foots(closest_point, noisy(), queries(5, 30.0, 31.0), reach=20.0)
    assert (hit == -1).all()
    hit, _, _ = foots(find_foot, noisy(), queries(5, 30.0, 31.0), reach=20.0)
    assert (hit == -1).all()
    hit, _, _ = foots(find_foot, turned_over(sheet(flat, (5.0, 5.0))), np.array([[0.0, 0.0, 3.0]]))
    assert (hit == -1).all()


def test_the_foot_lies_on_its_triangle():
    mesh = noisy()
    hit, out, tree = foots(find_foot, mesh, queries(200, 2.0, 8.0))
    place = np.argsort(tree.order)[hit]  # triangles lie in the order of the leaves
    corner = tree.points[tree.triangles[place]].astype(float)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.abs(np.sum((out[:, :3] - corner[:, 0]) * normal, axis=1)).max() < 1e-5
    np.testing.assert_allclose(np.linalg.norm(out[:, 3:], axis=1), 1.0, atol=1e-12)


def residuals(points: np.ndarray, out: np.ndarray) -> np.ndarray:
    """How far the interpolated normals miss the points they should pass through."""
    away = points - out[:, :3]
    along = np.sum(away * out[:, 3:], axis=1, keepdims=True)
    return np.linalg.norm(away - along * out[:, 3:], axis=1)


def samples(tree, per_edge: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Points and interpolated normals, spread over every triangle."""
    i, j = np.meshgrid(np.arange(per_edge + 1), np.arange(per_edge + 1))
    keep = (i + j) <= per_edge
    weights = np.stack([i[keep], j[keep], per_edge - i[keep] - j[keep]], axis=1) / per_edge
    points = np.einsum("wc,fck->fwk", weights, tree.points[tree.triangles].astype(float))
    normals = np.einsum("wc,fck->fwk", weights, tree.normals[tree.triangles].astype(float))
    normals = normals.reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return points.reshape(-1, 3), normals


def test_the_foot_is_as_good_as_the_best_of_a_dense_search():
    """Near the closest point no sample of the surface has a normal that passes much nearer."""
    mesh = noisy()
    points = queries(60, 2.0, 6.0, seed=8)
    _, out, tree = foots(find_foot, mesh, points)
    ours = residuals(points, out)
    places, normals = samples(tree)
    for point, foot, rest in zip(points, out[:, :3], ours, strict=True):
        near = np.linalg.norm(places - foot, axis=1) < 0.3
        away = point - places[near]
        along = np.sum(away * normals[near], axis=1, keepdims=True)
        best = np.linalg.norm(away - along * normals[near], axis=1).min()
        assert rest < best + 0.35
    assert np.median(ours) < 1e-3


def test_on_a_sphere_the_foot_is_the_radial_one():
    mesh = ball(30.0, 2.0)
    rng = np.random.default_rng(4)
    away = rng.normal(size=(200, 3)) * [1.0, 1.0, 0.3] + [0.0, 0.0, 1.5]
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    points = 55.0 * away
    hit, out, _ = foots(find_foot, mesh, points, reach=60.0)
    assert (hit >= 0).all()
    assert np.abs(out[:, :3] / np.linalg.norm(out[:, :3], axis=1)[:, None] - away).max() < 1e-3
    closest, flat_foot, _ = foots(closest_point, mesh, points, reach=60.0)
    assert (closest >= 0).all()
    plain = flat_foot[:, :3] / np.linalg.norm(flat_foot[:, :3], axis=1)[:, None]
    assert np.abs(plain - away).max() > 5e-3  # which is why the plain closest point will not do


def test_the_foot_moves_evenly():
    """Over faceted ground the foot of an even motion has no jumps; the closest point has."""
    angle = np.linspace(0.0, 0.5, 400)
    points = 60.0 * np.stack([np.sin(angle), np.zeros(400), np.cos(angle)], axis=1)
    mesh = ball(30.0, 3.0)
    steps = []
    for search in (find_foot, closest_point):
        _, out, _ = foots(search, mesh, points)
        steps.append(np.linalg.norm(np.diff(out[:, :3], axis=0), axis=1))
    even = 30.0 * angle[1]
    assert np.abs(steps[0] - even).max() < 0.25 * even
    assert np.abs(steps[1] - even).max() > 0.75 * even


@pytest.mark.parametrize("n", [1, 8, 9, 100])
def test_trees_of_any_size(n):
    rng = np.random.default_rng(n)
    points = rng.uniform(-5.0, 5.0, (3 * n, 3)).astype(np.float32)
    faces = np.arange(3 * n).reshape(-1, 3)
    mesh = TriangleMesh(points, faces)
    hit, out, _ = foots(closest_point, mesh, queries(50, -5.0, 5.0))
    facing = mesh.face_normals[:, 2] > 0.0
    if not facing.any():
        assert (hit == -1).all()
        return
    other = ClosestPoints(TriangleMesh(points, faces[facing])).find(queries(50, -5.0, 5.0))
    np.testing.assert_allclose(out[:, :3], other.points, atol=2e-5)


def test_closest_points_agree_with_trimesh():
    import trimesh

    mesh = noisy(n=80)
    points = queries(100, -3.0, 5.0)
    found = ClosestPoints(mesh).find(points)
    other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    places, distances, _ = trimesh.proximity.closest_point_naive(other, points)
    ours = np.linalg.norm(found.points - points, axis=1)
    np.testing.assert_allclose(ours, distances, atol=2e-5)
    unique = np.linalg.norm(found.points - places, axis=1) < 1e-3
    assert unique.mean() > 0.95
    corner = mesh.vertices[mesh.faces[found.faces]].astype(float)
    np.testing.assert_allclose(
        np.einsum("nk,nkd->nd", found.barycentric, corner), found.points, atol=1e-12
    )
    assert found.barycentric.min() > -1e-6
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0, atol=1e-12)


def test_rays_hit_what_they_must():
    scene = ClosestPoints(sheet(flat, (5.0, 5.0)))
    origins = np.array([[0.2, 0.3, 4.0], [0.0, 0.0, 4.0], [20.0, 0.0, 4.0]])
    directions = np.array([[0.0, 0.0, -2.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    hits = scene.cast(origins, directions)
    assert hits.hit.tolist() == [True, False, False]
    assert hits.distance[0] == pytest.approx(2.0)
    np.testing.assert_allclose(hits.points[0], [0.2, 0.3, 0.0], atol=1e-6)
    assert np.isnan(hits.points[1:]).all()
    assert hits.faces[1:].tolist() == [-1, -1]


# -- closest points and ray hits ---------------------------------------------------------------


UPWARD = np.array([0.0, 0.0, 1.0])
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


def places_about(seed: int, mesh: TriangleMesh, n: int) -> NDArray:
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
    points = places_about(seed, mesh, 60)
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
    away = np.linalg.norm(needle.find(along + UPWARD).points - along, axis=1)
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

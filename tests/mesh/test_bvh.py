"""Foot points: the kernel's search against brute force and against other programs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from paint3d.mesh.bvh import ClosestPoints, build_contact_tree
from paint3d.mesh.kernels.bvh import closest_point, find_foot
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh
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

"""TriangleMesh: what it refuses, and its measures on shapes with known ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.errors import MeshError
from paint3d.mesh.polygons import triangulate
from paint3d.mesh.triangle_mesh import TriangleMesh

SQUARE = np.array([[0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0]], float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def test_measures_of_a_rectangle():
    mesh = TriangleMesh(SQUARE, TWO)
    assert mesh.area == pytest.approx(12.0)
    assert mesh.bounds.tolist() == [[0, 0, 0], [3, 4, 0]]
    assert (mesh.n_vertices, mesh.n_faces) == (4, 2)
    np.testing.assert_array_equal(mesh.face_normals, [[0, 0, 1], [0, 0, 1]])


def test_arrays_are_private_and_read_only():
    vertices = SQUARE.astype(np.float32)
    mesh = TriangleMesh(
        vertices, TWO, np.zeros((4, 3), np.uint8), "a", np.tile([0, 0, 1.0], (4, 1))
    )
    vertices[0] = 9.0
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    for array in (mesh.vertices, mesh.faces, mesh.colours, mesh.normals):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert (mesh.vertices.dtype, mesh.faces.dtype) == (np.float32, np.int32)


def test_faces_without_area_are_allowed_among_others():
    mesh = TriangleMesh(SQUARE, [[0, 1, 2], [0, 0, 1]])
    assert mesh.face_normals[1].tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("vertices", "faces", "others", "message"),
    [
        (np.empty((0, 3)), TWO, {}, "vertices is empty"),
        (SQUARE, np.empty((0, 3), int), {}, "no faces"),
        (SQUARE[:, :2], TWO, {}, r"vertices has shape \(4, 2\)"),
        (SQUARE * np.nan, TWO, {}, r"vertices\[0, 0\] is nan"),
        (SQUARE * 1e30, TWO, {}, "a coordinate is"),
        (SQUARE, [[0, 1, 4]], {}, "face 0 refers to vertex 4; expected 0 to 3"),
        (SQUARE, [[0, 1, 2], [-1, 1, 2]], {}, "face 1 refers to vertex -1"),
        (SQUARE, [[0.0, 1.0, 2.0]], {}, "faces has type float64; expected integers"),
        (SQUARE, [[0, 1, 2, 3]], {}, r"faces has shape \(1, 4\)"),
        (SQUARE, TWO, {"colours": np.zeros((4, 3))}, "colours has type float64"),
        (SQUARE, TWO, {"colours": np.zeros((3, 3), np.uint8)}, r"expected \(4, 3\)"),
        (SQUARE, TWO, {"normals": np.zeros((3, 3))}, r"normals has shape \(3, 3\)"),
        (SQUARE, TWO, {"normals": np.full((4, 3), np.inf)}, r"normals\[0, 0\] is inf"),
    ],
)
def test_bad_arrays_are_refused_by_name(vertices, faces, others, message):
    with pytest.raises(MeshError, match=message):
        TriangleMesh(vertices, faces, **others)


@settings(deadline=None, max_examples=40)
@given(st.integers(3, 40), st.integers(0, 10_000), st.integers(0, 5))
def test_any_star_shaped_polygon_keeps_its_area_and_orientation(n, seed, turn):
    rng = np.random.default_rng(seed)
    angle = (np.arange(n) + 0.4 * rng.random(n)) * 2 * np.pi / n
    ring = rng.uniform(0.2, 1.0, n)[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    axis = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = np.c_[ring, np.zeros(n)] @ axis
    faces = triangulate(points, np.roll(np.arange(n), turn), np.array([n]))
    after = np.roll(ring, -1, axis=0)
    area = 0.5 * (ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]).sum()
    up = np.linalg.det(axis) * axis[2]
    cross = np.cross(
        points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    )
    assert len(faces) == n - 2
    assert 0.5 * np.linalg.norm(cross, axis=1).sum() == pytest.approx(area)
    assert (cross @ up >= -1e-12).all()


def test_polygons_of_mixed_sizes_keep_their_order():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 3, 0]], float)
    corners = np.array([0, 1, 2, 0, 1, 2, 3, 0, 1, 0, 1, 2, 4, 3])
    faces = triangulate(points, corners, np.array([3, 4, 2, 5]))
    assert faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 4], [0, 4, 3]]


def test_absurd_polygons_are_refused():
    points = np.zeros((3, 3))
    with pytest.raises(MeshError, match="face 0 has 1,000,000 corners; expected at most 100,000"):
        triangulate(points, np.zeros(1_000_000, int), np.array([1_000_000]))


def test_outlines_that_cross_themselves_are_cut_all_the_same():
    rng = np.random.default_rng(4)
    points = np.c_[rng.uniform(size=(8, 2)), np.zeros(8)]
    corners = rng.integers(0, 8, 1500)  # from one corner to another, again and again
    faces = triangulate(points, corners, np.array([1500]))
    assert faces.shape == (1498, 3)
    assert set(faces.ravel()) <= set(range(8))


def test_outlines_too_tangled_to_cut_are_refused(monkeypatch):
    monkeypatch.setattr("paint3d.mesh.polygons.MAX_EAR_TESTS", 20)
    angle = np.arange(30) * 2 * np.pi / 30
    star = np.where(np.arange(30) % 2, 0.2, 1.0)[:, None] * np.c_[np.cos(angle), np.sin(angle)]
    with pytest.raises(MeshError, match="with 30 corners is too tangled"):
        triangulate(np.c_[star, np.zeros(30)], np.arange(30), np.array([30]))


def test_a_large_convex_polygon_is_a_fan():
    angle = np.arange(20_000) * 2 * np.pi / 20_000
    points = np.stack([np.cos(angle), np.sin(angle), np.zeros(20_000)], axis=1)
    faces = triangulate(points, np.arange(20_000), np.array([20_000]))
    assert TriangleMesh(points, faces).area == pytest.approx(np.pi, rel=1e-6)


CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
SIDES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]], np.int32
)  # fmt: skip


def test_the_skin_of_a_body_is_told_from_a_sheet() -> None:
    assert TriangleMesh(CUBE, SIDES).is_solid
    assert TriangleMesh(CUBE + 1000.0, SIDES).is_solid
    assert not TriangleMesh(CUBE, SIDES[1:]).is_solid  # a hole
    assert not TriangleMesh(CUBE, SIDES[:, ::-1]).is_solid  # inside out
    one_turned = SIDES.copy()
    one_turned[3] = one_turned[3, ::-1]
    assert not TriangleMesh(CUBE, one_turned).is_solid
    two = np.concatenate([CUBE, CUBE + 5.0])
    assert TriangleMesh(two, np.concatenate([SIDES, SIDES + 8])).is_solid
    assert not TriangleMesh(two, np.concatenate([SIDES, SIDES[:, ::-1] + 8])).is_solid
    apart = CUBE[SIDES].reshape(-1, 3)  # as STL has it: no two faces share a corner
    assert not TriangleMesh(apart, np.arange(36, dtype=np.int32).reshape(-1, 3)).is_solid

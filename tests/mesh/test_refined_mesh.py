"""PaintMesh: welding, creases, areas, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.errors import MeshError
from paint3d.mesh import refined_mesh as paint_mesh
from paint3d.mesh.kernels.cell_components import gather_links
from paint3d.mesh.kernels.refine import activate_cell
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import poses


def fan(blades, radius=10.0, height=0.0):
    """Like triangles around one vertex, on a cone of the given height."""
    angle = np.arange(blades) * (2.0 * np.pi / blades)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(blades)], axis=1)
    i = np.arange(blades)
    faces = np.stack([np.zeros(blades, int), i + 1, (i + 1) % blades + 1], axis=1)
    return TriangleMesh(np.vstack([[[0.0, 0.0, height]], rim]), faces)


def ridge(angle):
    """Two triangles that turn by `angle` (rad) along the x axis."""
    points = [[0, 0, 0], [3, 0, 0], [0, -2, 0], [0, 2 * np.cos(angle), -2 * np.sin(angle)]]
    return TriangleMesh(np.array(points, float), [(0, 2, 1), (0, 1, 3)])


def cylinder(points=64):
    """An open cylinder with smooth sides and a flat lid."""
    angle = np.arange(points) * (2.0 * np.pi / points)
    ring = np.stack([5.0 * np.cos(angle), 5.0 * np.sin(angle)], axis=1)
    low = np.column_stack([ring, np.zeros(points)])
    high = np.column_stack([ring, np.full(points, 8.0)])
    i, j = np.arange(points), np.roll(np.arange(points), -1)
    sides = [np.stack([i, j, j + points], 1), np.stack([i, j + points, i + points], 1)]
    lid = np.stack([i + points, j + points, np.full(points, 2 * points)], 1)
    return TriangleMesh(np.vstack([low, high, [[0, 0, 8.0]]]), np.vstack([*sides, lid]))


def test_many_like_triangles_around_a_vertex_do_not_overflow_its_area():
    mesh = fan(250)
    painted = PaintMesh.build(mesh, 1.0)
    centre = np.flatnonzero((painted.vertices == 0.0).all(axis=1))
    assert painted.vertex_areas[centre] == pytest.approx(mesh.area / 3.0, rel=1e-9)
    painted.refine_all()
    assert (painted.arrays.area_units[: painted.n_vertices] > 0).all()
    assert painted.vertex_areas.sum() == pytest.approx(mesh.area, rel=1e-9)


def test_areas_match_the_leaves():
    painted = PaintMesh.build(cylinder(), 0.9)
    painted.refine_all()
    corner = painted.vertices.astype(float)[painted.leaf_faces()]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    thirds = np.linalg.norm(cross, axis=1) / 6.0
    summed = np.zeros(painted.n_vertices)
    np.add.at(summed, painted.leaf_faces().ravel(), np.repeat(thirds, 3))
    np.testing.assert_allclose(painted.vertex_areas, summed, rtol=1e-4)


@pytest.mark.parametrize(("degrees", "vertices"), [(0, 4), (38, 4), (42, 6), (170, 6)])
def test_a_crease_doubles_its_vertices(degrees, vertices):
    painted = PaintMesh.build(ridge(np.deg2rad(degrees)), None)
    assert painted.n_vertices == vertices
    if vertices == 6:
        corner = painted.normals[painted.base_faces]
        np.testing.assert_allclose(corner, np.repeat(corner[:, :1], 3, axis=1), atol=1e-6)


def test_midpoints_of_a_crease_keep_both_normals():
    painted = PaintMesh.build(ridge(np.deg2rad(90.0)), 0.5)
    painted.refine_all()
    on_edge = (painted.vertices[:, 1:] == 0.0).all(axis=1)
    turned = {tuple(n) for n in np.round(painted.normals[on_edge], 5).tolist()}
    assert turned == {(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)}
    assert on_edge.sum() % 2 == 0
    assert on_edge.sum() >= 14


def test_smooth_sides_and_a_flat_lid():
    painted = PaintMesh.build(cylinder(), None)
    flat = painted.normals[:, 2] > 0.999
    assert flat.sum() == 65
    sides = painted.vertices[~flat]
    radial = sides[:, :2] / np.linalg.norm(sides[:, :2], axis=1, keepdims=True)
    assert (painted.normals[~flat, :2] * radial).sum(axis=1).min() > 0.9999


def test_normals_of_the_file_are_used_where_they_agree():
    mesh = fan(12, height=1.0)
    given = np.tile([[0.0, 0.0, 2.0]], (13, 1))
    given[3] = [0.0, 0.0, -1.0]
    given[4] = 0.0
    with_normals = TriangleMesh(mesh.vertices, mesh.faces, normals=given)
    own = PaintMesh.build(mesh, None)
    painted = PaintMesh.build(with_normals, None)
    believed = ~np.isin(painted.source_vertices, [3, 4])
    np.testing.assert_array_equal(painted.normals[believed], [[0.0, 0.0, 1.0]] * 11)
    np.testing.assert_array_equal(painted.normals[~believed], own.normals[~believed])


def test_own_vertices_without_resolution():
    mesh = cylinder()
    painted = PaintMesh.build(mesh, None)
    painted.refine_all()
    assert not painted.refines
    assert painted.vertices[painted.leaf_faces()].tolist() == mesh.vertices[mesh.faces].tolist()
    assert len(painted.arrays.radial) == len(painted.arrays.child) == 0


def test_fine_meshes_have_no_forest():
    painted = PaintMesh.build(cylinder(), 50.0)
    assert not painted.refines
    assert len(painted.arrays.radial) == 0
    assert painted.vertex_areas.sum() == pytest.approx(cylinder().area)


def test_source_vertices_are_where_the_source_is():
    mesh = cylinder()
    painted = PaintMesh.build(mesh, 0.9)
    base = painted.n_base_vertices
    np.testing.assert_array_equal(painted.vertices, mesh.vertices[painted.source_vertices])
    painted.refine_all()
    order = painted.source_order()
    assert sorted(order.tolist()) == list(range(painted.n_vertices))
    assert (np.diff(painted.source_vertices[order[:base]]) >= 0).all()


def test_faces_without_area_are_left_out():
    mesh = ridge(0.3)
    points = np.vstack([mesh.vertices, [[1.5, 0.0, 0.0], [3.0, 0.0, 0.0]]])
    faces = [*mesh.faces.tolist(), (0, 1, 4), (1, 5, 2), (2, 2, 3)]
    painted = PaintMesh.build(TriangleMesh(points, faces), 0.4)
    painted.refine_all()
    assert len(painted.base_faces) == 2
    assert np.isfinite(painted.vertices).all()
    assert painted.vertex_areas.sum() == pytest.approx(mesh.area, rel=1e-6)


def test_opposed_normals_leave_a_unit_normal_between(monkeypatch):
    painted = PaintMesh.build(fan(3), 5.0)
    painted.arrays.nz[:2] = [1.0, -1.0]
    painted.arrays.nx[:2] = painted.arrays.ny[:2] = 0.0
    painted.refine_all()
    assert np.linalg.norm(painted.normals, axis=1) == pytest.approx(1.0, abs=1e-5)


def test_a_long_chain_of_bisections_needs_no_more_scratch(monkeypatch):
    roomy = PaintMesh.build(cylinder(), 0.9)
    roomy.refine_all()
    monkeypatch.setattr(paint_mesh, "_PATH", 2)
    tight = PaintMesh.build(cylinder(), 0.9)
    tight.refine_all()
    np.testing.assert_array_equal(
        np.sort(tight.arrays.key[: tight.n_vertices]), np.sort(roomy.arrays.key[: roomy.n_vertices])
    )


def test_activating_twice_changes_nothing():
    painted = PaintMesh.build(cylinder(), 0.9)
    assert activate_cell(painted.arrays, 7) == 0
    counts = painted.arrays.counts.copy()
    assert activate_cell(painted.arrays, 7) == 0
    np.testing.assert_array_equal(painted.arrays.counts, counts)
    assert painted.arrays.done[7] == 1
    assert painted.arrays.done.sum() == 1


def test_far_from_the_origin():
    near = PaintMesh.build(fan(8), 1.0)
    near.refine_all()
    mesh = fan(8)
    far = PaintMesh.build(TriangleMesh(mesh.vertices + np.float32(250_000.0), mesh.faces), 1.0)
    far.refine_all()
    assert (far.arrays.vertex_sheet[: far.n_vertices] >= 0).all()
    assert far.n_vertices == pytest.approx(near.n_vertices, rel=0.1)
    away = TriangleMesh(mesh.vertices + np.float32(2e7), mesh.faces)
    match = r"\(--unit\) if it is not so far, or at least 16 mm \(--resolution\), or .* the origin"
    with pytest.raises(MeshError, match=match):
        PaintMesh.build(away, 1.0)


@pytest.mark.parametrize("side", [1e7, 1e11])
def test_too_long_for_the_resolution(side):
    points = np.array([[0, 0, 0], [side, 0, 0], [0, 1, 0]], float)
    with pytest.raises(MeshError, match=r"mm long.*expected another unit \(--unit\).*resolution"):
        PaintMesh.build(TriangleMesh(points, [(0, 1, 2)]), 1e-3)


def test_too_much_surface_for_the_resolution():
    points = np.array([[0, 0, 0], [6e5, 0, 0], [0, 6e5, 0]], float)
    match = r"surface of 1\.8e\+05 m2 is too large .* every 1 mm; expected another unit \(--unit\)"
    with pytest.raises(MeshError, match=match) as caught:
        PaintMesh.build(TriangleMesh(points, [(0, 1, 2)]), 1.0)
    assert "at least 1.2 mm (--resolution)" in str(caught.value)


def square(side):
    points = np.array([[0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]], float)
    return TriangleMesh(points, [(0, 1, 2), (0, 2, 3)])


def test_cells_grow_with_a_large_surface_and_with_no_other(monkeypatch):
    monkeypatch.setattr(paint_mesh, "_MOST_CELLS", 2e4)
    sizes, cells = [], []
    for side in (50.0, 100.0, 400.0, 1000.0):
        mesh = PaintMesh.build(square(side), 0.4)
        sizes.append(float(mesh.arrays.cell_size))
        cells.append(mesh.n_cells)
    assert sizes == pytest.approx([2.0, 2.0, 4.0, 10.0])
    assert cells[1] == pytest.approx(4 * cells[0], rel=0.1)
    assert max(cells) == pytest.approx(min(cells[2:]), rel=0.1)
    with pytest.raises(MeshError, match="too large"):
        PaintMesh.build(square(20_000.0), 0.4)


def test_the_same_is_painted_on_larger_cells(monkeypatch):
    recording = poses(
        np.column_stack([np.linspace(180.0, 220.0, 20), np.full(20, 200.0), np.zeros(20)]),
        (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), np.full(20, 0.4),
    )  # fmt: skip
    painted = []
    for most in (4e6, 2e4):
        monkeypatch.setattr(paint_mesh, "_MOST_CELLS", most)
        painter = Painter(PaintedSurface(square(400.0), 0.8), "full")
        painter.replay(recording)
        surface = painter.surface
        here = surface.coverage[: surface.n_vertices] > 0.0
        points = surface.paint_mesh.vertices[here].astype(float)
        order = np.lexsort(points.T)
        painted.append((points[order], surface.coverage[: surface.n_vertices][here][order]))
    (points, cover), (more_points, more_cover) = painted
    assert len(points) == len(more_points) > 500
    np.testing.assert_array_equal(points, more_points)
    np.testing.assert_allclose(cover, more_cover, atol=1e-5)


def test_too_many_triangles_on_one_edge():
    blades = 300
    angle = np.linspace(0.0, 6.0, blades)
    tips = np.stack([np.cos(angle), np.sin(angle), np.zeros(blades)], axis=1)
    points = np.vstack([[[0, 0, 0], [0, 0, 5.0]], tips])
    faces = [(0, 1, i + 2) for i in range(blades)]
    with pytest.raises(MeshError, match="300 triangles share one edge; expected at most 256"):
        PaintMesh.build(TriangleMesh(points, faces), 0.5)


@pytest.mark.parametrize("n_links", [0, 1, 400, 5000])
def test_links_become_a_graph_with_each_once_in_either_direction(n_links: int) -> None:
    links = np.random.default_rng(2).integers(0, 60, (n_links, 2)).astype(np.int32)
    runs, linked = gather_links(links, 64)
    both = np.unique(np.concatenate([links, links[:, ::-1]]), axis=0)
    np.testing.assert_array_equal(np.repeat(np.arange(64), np.diff(runs)), both[:, 0])
    np.testing.assert_array_equal(linked, both[:, 1])

"""Cells and sheets: what meets what, how much of it, and what is connected within a ball."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.mesh.kernels.mesh_arrays import find_cell, flood_patch, make_patch, sheet_of
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh

WEIGHTS = np.array([(i, j, 20 - i - j) for i in range(21) for j in range(21 - i)]) / 20.0


def plates(gap=1.0, side=12.0, n=4):
    """Two flat plates `gap` mm apart, not connected."""
    line = np.linspace(0.0, side, n)
    x, y = (a.ravel() for a in np.meshgrid(line, line, indexing="ij"))
    i = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.vstack([np.stack([i, i + n, i + n + 1], 1), np.stack([i, i + n + 1, i + 1], 1)])
    low = np.column_stack([x, y, np.zeros_like(x)])
    high = low + np.array([0.0, 0.0, gap])
    return TriangleMesh(np.vstack([low, high]), np.vstack([faces, faces + n * n]))


def bowl(points=48, rings=20, thickness=1.0, radius=20.0):
    """Half a sphere with a wall: inside and outside meet at the rim only."""
    polar = np.linspace(0.05, 0.5 * np.pi, rings)
    profile = np.vstack(
        [
            np.column_stack([np.sin(polar), -np.cos(polar)]) * radius,
            (np.column_stack([np.sin(polar), -np.cos(polar)]) * (radius - thickness))[::-1],
        ]
    )
    angle = np.arange(points) * (2.0 * np.pi / points)
    x = profile[:, :1] * np.cos(angle)
    y = profile[:, :1] * np.sin(angle)
    z = np.repeat(profile[:, 1:], points, axis=1)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(len(profile) - 1), np.arange(points), indexing="ij")
    a, b = (row * points + column).ravel(), (row * points + (column + 1) % points).ravel()
    faces = np.vstack(
        [np.stack([a, b, b + points], 1), np.stack([a, b + points, a + points], 1)],
    )
    return TriangleMesh(vertices, faces)


def soup(seed=0, count=12):
    """Loose triangles, thin and fat, in all directions."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0.0, 15.0, (count, 1, 3)) + rng.normal(0.0, 4.0, (count, 3, 3))
    return TriangleMesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def flood(mesh, point, radius):
    """The patch around the vertex nearest to `point`."""
    nearest = int(np.linalg.norm(mesh.vertices - point, axis=1).argmin())
    start = int(mesh.arrays.vertex_sheet[nearest])
    patch = make_patch(mesh.n_sheets)
    n = flood_patch(mesh.arrays, start, np.asarray(point, float), radius, patch)
    sheets = patch.sheets[:n]
    assert (patch.ticks[sheets] == 1).all()
    assert patch.ticks.sum() == n == patch.count[0] == len(set(sheets.tolist()))
    return sheets.copy()


@pytest.mark.parametrize("seed", range(4))
def test_every_point_of_a_triangle_lies_in_a_cell_that_lists_it(seed):
    mesh = PaintMesh.build(soup(seed), 0.6)
    corners = mesh.vertices.astype(float)[mesh.base_faces]
    for root, points in enumerate(np.einsum("wc,fck->fwk", WEIGHTS, corners)):
        for point in points:
            cell = find_cell(mesh.arrays, *point)
            assert cell >= 0
            assert sheet_of(mesh.arrays, cell, root) >= 0


@pytest.mark.parametrize("seed", range(4))
def test_no_cell_lists_a_triangle_that_is_far_away(seed):
    mesh = PaintMesh.build(soup(seed), 0.6)
    field, size = mesh.arrays, mesh.arrays.cell_size
    corners = mesh.vertices.astype(float)[mesh.base_faces]
    runs = np.repeat(np.arange(mesh.n_cells), np.diff(field.cell_pairs))
    middle = field.origin + (field.cell_place[runs] + 0.5) * size
    face = corners[field.pair_root]
    normal = np.cross(face[:, 1] - face[:, 0], face[:, 2] - face[:, 0])
    off = np.abs(np.einsum("nk,nk->n", middle - face[:, 0], normal))
    assert (off <= 0.502 * size * np.abs(normal).sum(axis=1)).all()
    assert (face.min(axis=1) <= middle + 0.502 * size).all()
    assert (face.max(axis=1) >= middle - 0.502 * size).all()


def test_places_without_surface_have_no_cell():
    mesh = PaintMesh.build(plates(gap=30.0), 0.4)
    assert find_cell(mesh.arrays, 6.0, 6.0, 15.0) == -1
    assert find_cell(mesh.arrays, -100.0, 6.0, 0.0) == -1
    cell = find_cell(mesh.arrays, 0.0, 0.0, 0.0)
    assert sheet_of(mesh.arrays, cell, len(mesh.base_faces) - 1) == -1


@pytest.mark.parametrize("make", [plates, bowl, soup])
def test_sheets_hold_the_whole_surface(make):
    source = make()
    mesh = PaintMesh.build(source, 0.5)
    field = mesh.arrays
    assert field.sheet_area.sum() == pytest.approx(source.area, rel=1e-9)
    # the mean over the sheets is the mean over the surface: their centres are exact
    corners = mesh.vertices.astype(float)[mesh.base_faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(cross, axis=1)
    centre = (areas[:, None] * corners.mean(axis=1)).sum(axis=0)
    np.testing.assert_allclose(
        (field.sheet_area[:, None] * field.sheet_centre).sum(axis=0), centre, rtol=1e-6, atol=1e-4
    )
    real = field.sheet_area > 1e-9
    off = field.sheet_centre - (
        field.origin + (field.cell_place[field.sheet_cell] + 0.5) * field.cell_size
    )
    assert np.abs(off[real]).max() <= 0.5 * field.cell_size * (1.0 + 1e-9)


def test_flat_sheets_have_their_faces_normal():
    mesh = PaintMesh.build(plates(), 0.4)
    field = mesh.arrays
    normals = np.zeros((mesh.n_sheets, 3))
    normals[:, 2] = field.sheet_area
    np.testing.assert_allclose(np.abs(field.sheet_normal), normals, atol=1e-6)


def test_links_go_both_ways_between_neighbours():
    mesh = PaintMesh.build(bowl(), 0.5)
    field = mesh.arrays
    start = np.repeat(np.arange(mesh.n_sheets), np.diff(field.sheet_links))
    links = set(zip(start.tolist(), field.linked_sheet.tolist(), strict=True))
    assert links == {(b, a) for a, b in links}
    places = field.cell_place[field.sheet_cell]
    apart = np.abs(places[start] - places[field.linked_sheet]).max(axis=1)
    assert apart.min() == apart.max() == 1


def test_two_plates_in_one_cell_are_two_sheets():
    mesh = PaintMesh.build(plates(gap=0.3), 0.4)
    lower = mesh.vertices[:, 2] == 0.0
    patch = flood(mesh, [6.0, 6.0, 0.0], 4.0)
    sheets = mesh.arrays.vertex_sheet[: mesh.n_vertices]
    assert not set(sheets[lower]) & set(sheets[~lower])
    heights = mesh.arrays.sheet_centre[patch, 2]
    assert np.abs(heights).max() < 1e-6
    both = np.isin(mesh.arrays.sheet_cell[sheets[lower]], mesh.arrays.sheet_cell[sheets[~lower]])
    assert both.any()


def test_a_ball_reaches_all_of_a_flat_patch():
    mesh = PaintMesh.build(plates(gap=40.0), 0.4)
    patch = flood(mesh, [6.0, 6.0, 0.0], 3.0)
    field, size = mesh.arrays, mesh.arrays.cell_size
    low = field.origin + field.cell_place[field.sheet_cell] * size
    away = np.maximum(0.0, np.maximum(low - [6, 6, 0], [6, 6, 0] - low - size))
    near = np.flatnonzero(np.linalg.norm(away, axis=1) <= 3.0)
    np.testing.assert_array_equal(np.sort(patch), near)


def test_paint_does_not_leak_through_the_wall_of_a_bowl():
    mesh = PaintMesh.build(bowl(), 0.3)
    radius = 18.0 * np.array([0.6, 0.0, -0.8])
    patch = flood(mesh, radius / 18.0 * 19.0, 5.0)
    centre = mesh.arrays.sheet_centre[patch]
    inner = np.linalg.norm(centre, axis=1) < 19.5
    assert len(patch) > 20
    assert inner.all()
    around_rim = flood(mesh, [19.0, 0.0, 0.0], 5.0)
    distance = np.linalg.norm(mesh.arrays.sheet_centre[around_rim], axis=1)
    assert distance.min() < 19.2
    assert distance.max() > 19.8


def test_a_fold_is_reached_only_along_the_surface():
    """A sheet folded back on itself, 1 mm apart: a ball on one leaf stays there."""
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 7)
    xs = np.concatenate([[0.0, 10.0], 20.0 + 0.5 * np.cos(turn), [10.0, 0.0]])
    zs = np.concatenate([[-0.5, -0.5], 0.5 * np.sin(turn), [0.5, 0.5]])
    points = np.vstack([np.column_stack([xs, np.full_like(xs, y), zs]) for y in (0.0, 8.0)])
    i, n = np.arange(len(xs) - 1), len(xs)
    faces = np.vstack([np.stack([i, i + 1, i + n + 1], 1), np.stack([i, i + n + 1, i + n], 1)])
    mesh = PaintMesh.build(TriangleMesh(points, faces), 0.4)
    patch = flood(mesh, [0.0, 0.0, -0.5], 6.0)
    assert np.allclose(mesh.arrays.sheet_centre[patch][:, 2], -0.5, atol=1e-5)
    patch = flood(mesh, [20.5, 0.0, 0.0], 6.0)
    assert np.ptp(mesh.arrays.sheet_centre[patch][:, 2]) > 0.9


def test_base_vertices_stand_in_runs_by_cell():
    mesh = PaintMesh.build(bowl(), 0.5)
    field = mesh.arrays
    assert field.base_start[0] == 0
    assert field.base_start[-1] == mesh.n_base_vertices
    cell = np.repeat(np.arange(mesh.n_cells), np.diff(field.base_start))
    place = np.floor((mesh.vertices - field.origin) / field.cell_size)
    np.testing.assert_array_equal(place, field.cell_place[cell])
    np.testing.assert_array_equal(field.sheet_cell[field.vertex_sheet[: len(cell)]], cell)


def test_cells_are_in_morton_order():
    mesh = PaintMesh.build(soup(), 0.4)
    places = mesh.arrays.cell_place.tolist()
    bits = [
        sum(((p[axis] >> b) & 1) << (3 * b + axis) for b in range(12) for axis in range(3))
        for p in places
    ]
    assert bits == sorted(set(bits))


def test_large_triangles_span_many_cells():
    corners = 100.0 * np.array([[0, 0, 0], [1, 0, 0.3], [0, 1, 0.6], [1, 1, 0.2]])
    source = TriangleMesh(corners, [(0, 1, 2), (1, 3, 2)])
    mesh = PaintMesh.build(source, 0.8)
    assert mesh.n_cells > 800
    assert mesh.arrays.sheet_area.sum() == pytest.approx(source.area, rel=1e-9)
    patch = flood(mesh, corners[0], 1e3)
    assert len(patch) == mesh.n_sheets

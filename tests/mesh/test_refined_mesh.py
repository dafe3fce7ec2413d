"""PaintMesh: welding, creases, areas, and what it refuses."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import paint3d
from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.errors import InputError, MeshError
from paint3d.mesh import refined_mesh as paint_mesh
from paint3d.mesh.kernels.cell_components import gather_links
from paint3d.mesh.kernels.mesh_arrays import find_cell, flood_patch, make_patch, sheet_of
from paint3d.mesh.kernels.refine import activate_cell
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.simplify import coarse_faces
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
    assert painted.vertex_areas[centre] == pytest.approx(mesh.area / 4.0, rel=1e-3)
    painted.refine_all()
    assert (painted.arrays.area_units[: painted.n_vertices] > 0).all()
    assert painted.vertex_areas.sum() == pytest.approx(mesh.area, rel=1e-9)


def test_areas_match_the_leaves():
    painted = PaintMesh.build(cylinder(), 0.9)
    painted.refine_all()
    corner = painted.vertices.astype(float)[painted.leaf_faces()]
    area = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    area /= 2.0
    side = np.linalg.norm(np.roll(corner, -1, axis=1) - np.roll(corner, 1, axis=1), axis=2)
    cosine = (np.sum(side**2, axis=1, keepdims=True) - 2.0 * side**2) / 2.0  # times both sides
    cotangent = cosine / (2.0 * area[:, None])
    nearest = side**2 * cotangent  # twice four times what lies nearest to each end of a side
    share = (np.roll(nearest, 1, axis=1) + np.roll(nearest, -1, axis=1)) / 8.0
    is_obtuse = cotangent.min(axis=1) < 0.0
    share[is_obtuse] = area[is_obtuse, None] * np.where(cotangent[is_obtuse] < 0.0, 0.5, 0.25)
    summed = np.zeros(painted.n_vertices)
    np.add.at(summed, painted.leaf_faces().ravel(), share.ravel())
    np.testing.assert_allclose(painted.vertex_areas, summed, rtol=1e-4)


def test_on_a_lattice_all_vertices_stand_for_the_same_area():
    painted = PaintMesh.build(paint3d.load_mesh("plane"), 2.0)
    painted.refine_all()
    inside = (np.abs(painted.vertices[:, :2]) < 30.0).all(axis=1)
    assert np.ptp(painted.vertex_areas[inside]) < 1e-6 * painted.vertex_areas[inside].mean()


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
    with pytest.raises(
        MeshError, match="at least 16 mm, or the object moved to the origin"
    ) as found:
        PaintMesh.build(away, 1.0)
    assert found.value.hint == "--unit, --resolution"


@pytest.mark.parametrize("side", [1e7, 1e11])
def test_too_long_for_the_resolution(side):
    points = np.array([[0, 0, 0], [side, 0, 0], [0, 1, 0]], float)
    with pytest.raises(MeshError, match="mm long") as found:
        PaintMesh.build(TriangleMesh(points, [(0, 1, 2)]), 1e-3)
    assert found.value.message.fields["span"] == pytest.approx(side)
    assert found.value.hint == "--unit, --resolution"


def test_too_much_surface_for_the_resolution():
    points = np.array([[0, 0, 0], [6e5, 0, 0], [0, 6e5, 0]], float)
    with pytest.raises(MeshError, match=r"surface .* is too large") as caught:
        PaintMesh.build(TriangleMesh(points, [(0, 1, 2)]), 1.0)
    assert caught.value.message.fields["area"] == pytest.approx(1.8e5)
    assert caught.value.message.fields["least"] == pytest.approx(1.2, abs=0.05)
    assert caught.value.hint == "--unit, --resolution"


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


# -- bisections taken back ---------------------------------------------------------------------


BARE = np.array([240.0, 236.0, 228.0])


def difference(a, b):
    return delta_e(lab_from_srgb(a / 255.0), lab_from_srgb(b / 255.0))


def box(side=6.0):
    corners = side * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return TriangleMesh(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def blot(points):
    """A soft blot on a corner of the box."""
    distance = np.linalg.norm(points - [6.0, 6.0, 6.0], axis=1)
    cover = np.clip((2.5 - distance) / 0.8, 0.0, 1.0)[:, None]
    return np.round((1.0 - cover) * BARE + cover * [20.0, 30.0, 90.0])


def refined(lazily=False):
    mesh = PaintMesh.build(box(), 0.5)
    if lazily:
        middle = mesh.arrays.origin + (mesh.arrays.cell_place + 0.5) * mesh.arrays.cell_size
        size = mesh.arrays.cell_size
        for cell in np.flatnonzero(np.linalg.norm(middle - 6.0, axis=1) < 2.5 + size):
            assert activate_cell(mesh.arrays, int(cell)) == 0
    else:
        mesh.refine_all()
    return mesh


def locate(points, corners):
    """Barycentric weights (n, 3) of n points in n triangles."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    system = np.stack([u, v, np.cross(u, v)], axis=2)
    solved = np.linalg.solve(system, (points - corners[:, 0])[:, :, None])[:, :, 0]
    solved = np.column_stack([1.0 - solved[:, 0] - solved[:, 1], solved])
    return solved[:, :3], np.abs(solved[:, 3])


def worst(mesh, colours, ids, faces, normals):
    """Largest difference at any vertex from the coarse triangles that hold it."""
    points, found = mesh.vertices.astype(float), np.zeros(mesh.n_vertices)
    for face in ids[faces]:
        flat = np.abs(normals - normals[face[0]]).max(axis=1) < 1e-6
        rows = np.flatnonzero(flat)
        corners = np.broadcast_to(points[face], (len(rows), 3, 3))
        weights, off = locate(points[rows], corners)
        inside = (weights > -1e-6).all(axis=1) & (off < 1e-6)
        shown = weights[inside] @ colours[face]
        found[rows[inside]] = np.maximum(
            found[rows[inside]], difference(shown, colours[rows[inside]])
        )
    return found.max()


def test_without_paint_the_source_comes_back():
    mesh = refined()
    ids, faces = coarse_faces(mesh, np.tile(BARE, (mesh.n_vertices, 1)), 0.0, difference)
    source = box()
    np.testing.assert_array_equal(mesh.vertices[ids][faces], source.vertices[source.faces])
    assert len(ids) == mesh.n_base_vertices


def test_meshes_without_forest():
    mesh = PaintMesh.build(box(), None)
    ids, faces = coarse_faces(mesh, blot(mesh.vertices), 1.0, difference)
    np.testing.assert_array_equal(mesh.vertices[ids][faces], box().vertices[box().faces])


@pytest.mark.parametrize("tolerance", [0.5, 1.0, 3.0])
def test_no_vertex_misses_by_more_than_the_tolerance(tolerance):
    mesh = refined()
    colours = blot(mesh.vertices)
    ids, faces = coarse_faces(mesh, colours, tolerance, difference)
    assert mesh.n_base_vertices < len(ids) < 0.5 * mesh.n_vertices
    found = worst(mesh, colours, ids, faces, mesh.normals)
    assert 0.2 * tolerance < found <= tolerance + 1e-6


def test_no_cracks_across_creases():
    mesh = refined()
    ids, faces = coarse_faces(mesh, blot(mesh.vertices), 1.0, difference)
    keys = mesh.arrays.key[ids]
    edges = Counter(
        tuple(sorted((int(keys[a]), int(keys[b]))))
        for face in faces
        for a, b in zip(face, np.roll(face, -1), strict=True)
    )
    assert set(edges.values()) == {2}


def test_lazy_and_uniform_export_the_same():
    found = []
    for lazily in (True, False):
        mesh = refined(lazily)
        ids, faces = coarse_faces(mesh, blot(mesh.vertices), 1.0, difference)
        keys = mesh.arrays.key[ids][faces]
        found.append(Counter(tuple(sorted(row)) for row in keys.tolist()))
    assert found[0] == found[1]


def test_zero_tolerance_keeps_what_is_not_exact():
    mesh = refined()
    colours = np.random.default_rng(1).integers(0, 256, (mesh.n_vertices, 3)).astype(float)
    ids, faces = coarse_faces(mesh, colours, 0.0, difference)
    assert len(ids) == mesh.n_vertices
    assert len(faces) == len(mesh.leaf_faces())


def test_refusals():
    mesh = PaintMesh.build(box(), 0.5)
    colours = np.tile(BARE, (mesh.n_vertices, 1))
    with pytest.raises(InputError, match="tolerance"):
        coarse_faces(mesh, colours, -1.0, difference)
    with pytest.raises(InputError, match="colours"):
        coarse_faces(mesh, colours[1:], 1.0, difference)


# -- cells and sheets --------------------------------------------------------------------------


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

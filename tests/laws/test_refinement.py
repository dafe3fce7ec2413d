"""Laws of lazy refinement: order, conformity, areas, and agreement with refining everything."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from paint3d.mesh import refined_mesh as paint_mesh
from paint3d.mesh.kernels.refine import activate_cell, spread_areas
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.examples import examples


def scan(seed=3):
    """An irregular height field: thin and fat triangles, open border."""
    rng = np.random.default_rng(seed)
    plan = rng.uniform(0.0, 9.0, (60, 2)) ** [1.0, 1.3]
    z = np.sin(plan[:, 0]) + 0.2 * plan[:, 1]
    return TriangleMesh(np.column_stack([plan, z]), Delaunay(plan).simplices, name="scan")


def cube(side=5.0):
    """Twelve triangles on eight shared vertices: every edge but the diagonals is a crease."""
    corners = side * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return TriangleMesh(corners, faces, name="cube")


def octahedron():
    """Eight triangles whose edges are all exactly as long: only the keys decide."""
    points = 4.0 * np.vstack([np.eye(3), -np.eye(3)])
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    return TriangleMesh(points, faces, name="octahedron")


def fin():
    """Three triangles on one edge."""
    points = [[0, 0, 0], [0, 0, 6], [4, 1, 2], [-4, 1, 3], [0, -5, 4]]
    return TriangleMesh(np.array(points, float), [(0, 1, 2), (0, 1, 3), (0, 1, 4)], name="fin")


def doubled():
    """The same, with one of the three there twice, back to back."""
    return TriangleMesh(fin().vertices, [(0, 1, 2), (0, 1, 3), (0, 1, 4), (1, 0, 4)])


def seamed_tube():
    """A tube whose texture seam doubles a column of vertices."""
    angle, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 9), np.linspace(0.0, 6.0, 3))
    angle[:, -1] = 0.0
    points = np.stack([2.0 * np.cos(angle), 2.0 * np.sin(angle), height], axis=-1).reshape(-1, 3)
    i = (np.arange(2)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.stack([i, i + 1, i + 10], 1), np.stack([i, i + 10, i + 9], 1)])
    return TriangleMesh(points, faces, name="tube")


MESHES = {
    "scan": scan,
    "cube": cube,
    "octahedron": octahedron,
    "fin": fin,
    "doubled": doubled,
    "tube": seamed_tube,
}
EDGE = 0.8
RELAXED = settings(
    deadline=None,
    max_examples=examples(25),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
every_mesh = pytest.mark.parametrize("shape", sorted(MESHES))
# the inner edges of a doubled triangle lie on one another, so uses cannot be counted by place
each_place_once = pytest.mark.parametrize("shape", sorted(set(MESHES) - {"doubled"}))


def refine(mesh, cells):
    for cell in cells:
        while activate_cell(mesh.arrays, int(cell)) < 0:
            mesh.reserve()
    return mesh


def some_cells(mesh, seed, share=0.3):
    order = np.random.default_rng(seed).permutation(mesh.n_cells)
    return order[: max(1, int(share * mesh.n_cells))]


def names(mesh):
    """What tells a vertex from all others, whatever its index: its key and its normal."""
    keys = mesh.arrays.key[: mesh.n_vertices]
    return [(int(k), n.tobytes()) for k, n in zip(keys, mesh.normals, strict=True)]


def triangles(mesh, rows=None):
    """The triangles as a multiset of names, each turned so that its least name comes first."""
    name = names(mesh)
    found = Counter()
    for face in mesh.leaf_faces() if rows is None else mesh.leaf_faces()[rows]:
        corner = [name[v] for v in face]
        first = corner.index(min(corner))
        found[tuple(corner[first:] + corner[:first])] += 1
    return found


def edge_lengths(points, faces):
    corner = points.astype(np.float64)[faces]
    return np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)


WEIGHTS = np.array([(i, j, 12 - i - j) for i in range(13) for j in range(13 - i)]) / 12.0


def rows_meeting(mesh, cells):
    """Leaves with one of 91 points, spread evenly over each, in one of the cells."""
    points = np.einsum("wc,fck->fwk", WEIGHTS, mesh.vertices.astype(float)[mesh.leaf_faces()])
    place = np.floor((points - mesh.arrays.origin) / mesh.arrays.cell_size).astype(np.int64)
    code = place @ np.array([1, 1 << 20, 1 << 40])
    wanted = mesh.arrays.cell_place[cells].astype(np.int64) @ np.array([1, 1 << 20, 1 << 40])
    return np.isin(code, wanted).any(axis=1)


def length_by_use(keys, points, faces):
    """Total length of the edges that 1, 3, 4... triangles share; new inner edges have two."""
    length, uses = {}, Counter()
    for face, row in zip(faces, edge_lengths(points, faces), strict=True):
        for i in range(3):
            edge = tuple(sorted((int(keys[face[i]]), int(keys[face[(i + 1) % 3]]))))
            uses[edge] += 1
            length[edge] = row[i]
    total = Counter()
    for edge, count in uses.items():
        total[count] += length[edge]
    total.pop(2, None)
    return dict(total)


@every_mesh
@given(seed=st.integers(0, 10_000))
@RELAXED
def test_order_of_cells_changes_nothing(shape, seed):
    one, two = (PaintMesh.build(MESHES[shape](), EDGE) for _ in range(2))
    cells = some_cells(one, seed)
    refine(one, cells)
    refine(two, np.sort(cells))
    assert triangles(one) == triangles(two)
    sums = [
        Counter(dict(zip(names(m), m.arrays.area_units[: m.n_vertices].tolist(), strict=True)))
        for m in (one, two)
    ]
    assert sums[0] == sums[1]
    place = [dict(zip(names(m), map(bytes, m.vertices), strict=True)) for m in (one, two)]
    assert place[0] == place[1]


@every_mesh
@given(seed=st.integers(0, 10_000))
@RELAXED
def test_done_cells_are_fine_and_equal_to_uniform(shape, seed):
    lazy, uniform = (PaintMesh.build(MESHES[shape](), EDGE) for _ in range(2))
    cells = some_cells(lazy, seed)
    refine(lazy, cells)
    uniform.refine_all()
    rows = rows_meeting(lazy, cells)
    assert rows.any()
    assert edge_lengths(lazy.vertices, lazy.leaf_faces())[rows].max() <= EDGE
    assert triangles(lazy, rows) == triangles(uniform, rows_meeting(uniform, cells))
    assert edge_lengths(uniform.vertices, uniform.leaf_faces()).max() <= EDGE


@every_mesh
@given(seed=st.integers(0, 10_000))
@RELAXED
def test_a_finished_vertex_never_changes(shape, seed):
    mesh = PaintMesh.build(MESHES[shape](), EDGE)
    cells = some_cells(mesh, seed)
    refine(mesh, cells)
    place = np.floor((mesh.vertices - mesh.arrays.origin) / mesh.arrays.cell_size).astype(int)
    done = {tuple(p) for p in mesh.arrays.cell_place[cells].tolist()}
    finished = np.array([tuple(p) in done for p in place.tolist()])
    areas = mesh.arrays.area_units[: mesh.n_vertices][finished].copy()
    before = triangles(mesh, finished[mesh.leaf_faces()].any(axis=1))
    count = mesh.n_vertices
    mesh.refine_all()
    finished = np.concatenate([finished, np.zeros(mesh.n_vertices - count, bool)])
    assert triangles(mesh, finished[mesh.leaf_faces()].any(axis=1)) == before
    np.testing.assert_array_equal(mesh.arrays.area_units[: len(finished)][finished], areas)


@each_place_once
@given(seed=st.integers(0, 10_000), share=st.sampled_from([0.1, 0.6, 1.0]))
@RELAXED
def test_no_cracks(shape, seed, share):
    mesh = PaintMesh.build(MESHES[shape](), EDGE)
    keys = mesh.arrays.key[: mesh.n_vertices].copy()
    base = length_by_use(keys, mesh.vertices, mesh.base_faces)
    refine(mesh, some_cells(mesh, seed, share))
    keys = mesh.arrays.key[: mesh.n_vertices]
    now = length_by_use(keys, mesh.vertices, mesh.leaf_faces())
    assert now == pytest.approx(base, rel=1e-5)


@each_place_once
def test_rings_close_around_leaves(shape):
    mesh = PaintMesh.build(MESHES[shape](), EDGE)
    refine(mesh, some_cells(mesh, 5))
    field = mesh.arrays
    nodes = int(field.counts[1])
    leaves = np.flatnonzero(field.child[:nodes] < 0)

    def edge(h):
        face = field.node_vertices[h // 3]
        return tuple(sorted((int(field.key[face[h % 3]]), int(field.key[face[(h % 3 + 1) % 3]]))))

    around = Counter(edge(3 * t + e) for t in leaves.tolist() for e in range(3))
    for t in leaves.tolist():
        for h in (3 * t, 3 * t + 1, 3 * t + 2):
            ring = [h]
            while (following := int(field.radial[ring[-1]])) != h:
                assert len(ring) < 300
                ring.append(following)
            assert all(field.child[g // 3] < 0 and edge(g) == edge(h) for g in ring)
            assert len(ring) == around[edge(h)]


@every_mesh
def test_areas_are_exact_sums(shape):
    mesh = PaintMesh.build(MESHES[shape](), EDGE)
    source_area = MESHES[shape]().area
    whole = int(mesh.arrays.area_units[: mesh.n_vertices].sum())
    refine(mesh, some_cells(mesh, 1, 0.5))
    field, nodes = mesh.arrays, int(mesh.arrays.counts[1])
    leaves = np.flatnonzero(field.child[:nodes] < 0)
    roots = np.zeros(len(mesh.base_faces), np.int64)
    np.add.at(roots, field.node_root[leaves], field.node_area[leaves])
    np.testing.assert_array_equal(roots, field.node_area[: len(roots)])
    assert int(field.area_units[: mesh.n_vertices].sum()) == whole
    assert mesh.vertex_areas.sum() == pytest.approx(source_area, rel=1e-9)
    summed = np.zeros(mesh.n_vertices, np.int64)
    corners, areas = field.node_vertices[leaves], field.node_area[leaves]
    spread_areas(field.px, field.py, field.pz, corners, areas, summed)
    np.testing.assert_array_equal(summed, field.area_units[: mesh.n_vertices])


@every_mesh
def test_a_key_is_a_place(shape):
    mesh = PaintMesh.build(MESHES[shape](), EDGE)
    mesh.refine_all()
    keys = mesh.arrays.key[: mesh.n_vertices]
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    np.testing.assert_array_equal(mesh.vertices, mesh.vertices[first[same]])
    assert len(first) == len(np.unique(mesh.vertices, axis=0))
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1.0, abs=1e-5)


@every_mesh
def test_every_vertex_is_found_in_its_cell(shape):
    mesh = PaintMesh.build(MESHES[shape](), EDGE)
    refine(mesh, some_cells(mesh, 8))
    field = mesh.arrays
    place = np.floor((mesh.vertices - field.origin) / field.cell_size).astype(int)
    seen = Counter()
    for cell in range(mesh.n_cells):
        v = int(field.head[cell])
        listed = list(range(field.base_start[cell], field.base_start[cell + 1]))
        while v >= 0:
            listed.append(v)
            v = int(field.next_in_cell[v])
        seen.update(listed)
        assert all((place[v] == field.cell_place[cell]).all() for v in listed)
        assert all(field.sheet_cell[field.vertex_sheet[v]] == cell for v in listed)
    assert seen == Counter(range(mesh.n_vertices))


@each_place_once
@pytest.mark.parametrize("piece", [0, 3, 40])
def test_running_out_of_room_leaves_the_mesh_whole(shape, piece, monkeypatch):
    roomy = PaintMesh.build(MESHES[shape](), EDGE)
    roomy.refine_all()
    monkeypatch.setattr(paint_mesh, "_GROWTH", 0)
    tight = PaintMesh.build(MESHES[shape](), EDGE)
    base = length_by_use(tight.arrays.key, tight.vertices, tight.base_faces)
    stops = 0
    for cell in range(tight.n_cells):
        while activate_cell(tight.arrays, cell) < 0:
            stops += 1
            if stops == 1:
                now = length_by_use(tight.arrays.key, tight.vertices, tight.leaf_faces())
                assert now == pytest.approx(base, rel=1e-5)
            tight.reserve(piece)
    assert triangles(tight) == triangles(roomy)
    assert stops > 0 or tight.n_vertices < tight.capacity


def test_room_does_run_out(monkeypatch):
    monkeypatch.setattr(paint_mesh, "_GROWTH", 0)
    mesh = PaintMesh.build(cube(), 0.4)
    results = [activate_cell(mesh.arrays, cell) for cell in range(mesh.n_cells)]
    assert -1 in results
    assert mesh.n_vertices <= mesh.capacity
    assert int(mesh.arrays.counts[1]) <= len(mesh.arrays.child)

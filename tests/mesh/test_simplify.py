"""Taking bisections back: the bound, the base, and no cracks."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from paint3d.colour.difference import delta_e, lab_from_srgb
from paint3d.errors import InputError
from paint3d.mesh.kernels.refine import activate_cell
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.simplify import coarse_faces
from paint3d.mesh.triangle_mesh import TriangleMesh

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

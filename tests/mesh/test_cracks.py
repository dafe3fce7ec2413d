"""Open edges that lie beside other surface: a brush goes over cracks that no hair gets into."""

import numpy as np
import pytest

from paint3d.mesh.kernels.mesh_arrays import Cells, flood_patch, make_patch
from paint3d.mesh.kernels.topology import link_cracks
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh

SIDE = 30.0


def sheets_of(*corners):
    """One square each, none joined to another."""
    points = np.concatenate([np.array(four, float) for four in corners])
    faces = [
        [4 * k + i for i in three] for three in ((0, 1, 2), (0, 2, 3)) for k in range(len(corners))
    ]
    return TriangleMesh(points, np.array(faces))


def halves(gap):
    """Two halves of a square, as a body that was mirrored and not joined."""
    a, b = -0.5 * gap, 0.5 * gap
    return sheets_of(
        [(-SIDE, 0, 0), (a, 0, 0), (a, SIDE, 0), (-SIDE, SIDE, 0)],
        [(b, 0, 0), (SIDE, 0, 0), (SIDE, SIDE, 0), (b, SIDE, 0)],
    )


def wall_on_a_floor(gap):
    """A wall whose foot stands across a floor that does not know of it."""
    return sheets_of(
        [(-SIDE, -SIDE, 0), (SIDE, -SIDE, 0), (SIDE, SIDE, 0), (-SIDE, SIDE, 0)],
        [(-9, 0, gap), (11, 0, gap), (11, 0, SIDE), (-9, 0, SIDE)],
    )


def reached(mesh, place, radius=3.0):
    """Faces of the source that the patch around a place lies on."""
    built = PaintMesh.build(mesh, 0.5)
    nearest = int(np.linalg.norm(built.vertices - place, axis=1).argmin())
    start = int(built.arrays.vertex_sheet[nearest])
    patch, field = make_patch(built.n_sheets), built.arrays
    n = flood_patch(field, start, np.asarray(place, float), radius, patch)
    return {int(face) for s in patch.sheets[:n] for face in field.pair_root[field.pair_sheet == s]}


@pytest.mark.parametrize(("gap", "joined"), [(0.02, True), (0.09, True), (0.2, False)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_patch_goes_over_a_crack_and_not_over_a_gap(gap, joined, side):
    left, right = {0, 2}, {1, 3}
    found = reached(halves(gap), [side * 0.5 * gap, 0.0, 0.0], 12.0)
    assert bool(found & left) == (joined or side < 0.0)
    assert bool(found & right) == (joined or side > 0.0)


@pytest.mark.parametrize(("gap", "joined"), [(0.0, True), (0.05, True), (0.5, False)])
def test_a_wall_that_stands_on_a_floor_is_painted_with_it(gap, joined):
    floor, wall = {0, 2}, {1, 3}
    found = reached(wall_on_a_floor(gap), [-9.0, 0.0, gap], 15.0)
    assert found & wall
    assert bool(found & floor) == joined


def test_closed_bodies_and_bare_edges_have_no_cracks():
    corners = np.array([(0, 0, 0), (20, 0, 0), (0, 20, 0), (0, 0, 20)], float)
    closed = TriangleMesh(corners, np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]))
    single = sheets_of([(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0)])
    for mesh in (closed, single):
        field = PaintMesh.build(mesh, 1.0).arrays
        cells = Cells(*(getattr(field, name) for name in Cells._fields))
        links = np.empty((100, 2), np.int32)
        points = np.column_stack([field.px, field.py, field.pz]).astype(np.float32)
        faces = np.ascontiguousarray(field.node_vertices[: len(mesh.faces)])
        n = link_cracks(points, faces, field.radial[: 3 * len(faces)], cells, 0.1, links)
        assert n == 0

"""Shapes that are hard to paint: the far side of a wall, edges, folds, shells, no thickness."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.mesh.kernels.mesh_arrays import Cells, flood_patch, make_patch
from paint3d.mesh.kernels.topology import link_cracks
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support import surface_cases as sc


def test_a_plane_takes_the_whole_footprint():
    case = sc.measure("plane", sc.sheet(sc.flat, (30.0, 30.0)))
    assert case.ratio == pytest.approx(1.0, abs=0.01)
    assert case.off == 0.0


@pytest.mark.parametrize("pressure", [0.2, 0.4, 0.8])
@pytest.mark.parametrize("side", [sc.bowl_inside, sc.bowl_outside])
def test_paint_does_not_go_through_a_wall(side, pressure):
    case = side(pressure=pressure)
    assert case.astray == 0.0
    assert case.ratio > 0.5


@pytest.mark.parametrize("pressure", [0.2, 0.8])
@pytest.mark.parametrize("case", [sc.shells, sc.plates, sc.fold, sc.two_sided])
def test_only_the_touched_layer_is_painted(case, pressure):
    found = case(pressure=pressure)
    assert found.astray == 0.0
    assert found.painted > 0.5 * found.footprint


def test_layers_without_curvature_take_the_whole_footprint():
    for case in (sc.plates(), sc.fold(), sc.two_sided()):
        assert case.ratio == pytest.approx(1.0, abs=0.01)
        assert case.off == 0.0


def test_a_sharp_edge_is_not_painted_over():
    for distance in (4.0, 2.0, 0.5):
        case = sc.box_edge(distance)
        assert case.astray == 0.0
        assert 0.2 < case.ratio < 1.0


def test_an_edge_takes_the_part_that_lies_on_the_face():
    """The plane leans over the edge, so less than half of the footprint has surface there."""
    ratios = [sc.box_edge(distance).ratio for distance in (0.01, 1.0, 2.0, 4.0, 8.0)]
    assert ratios == sorted(ratios)
    assert 0.2 < ratios[0] < 0.5
    assert ratios[-1] == pytest.approx(1.0, abs=0.02)
    assert sc.box_edge(0.01).off > 0.01  # the first film lies on what there is


def test_a_rim_is_painted_on_top_only():
    case = sc.bowl_rim()
    assert case.astray == 0.0
    assert case.ratio > 0.5


@pytest.mark.parametrize("radius", [50.0, 75.0, 150.0, 1000.0])
def test_gently_curved_ground_takes_the_whole_footprint(radius):
    for case in (sc.sphere(radius), sc.dish(radius)):
        assert case.ratio == pytest.approx(1.0, abs=0.05)


def test_the_stretch_falls_with_the_radius():
    ratios = [sc.sphere(radius).ratio for radius in (20.0, 50.0, 150.0, 1000.0)]
    assert ratios == sorted(ratios)
    assert ratios[0] > 0.3
    assert ratios[1] > 0.7
    assert ratios[-1] == pytest.approx(1.0, abs=0.01)


def test_a_cylinder_bends_one_way():
    along = sc.cylinder(20.0, (0.0, 1.0, 0.0))
    across = sc.cylinder(20.0, (1.0, 0.0, 0.0))
    assert along.ratio == pytest.approx(1.0, abs=0.05)
    assert across.ratio < along.ratio


def test_the_back_of_a_surface_is_not_there():
    """From behind there is nothing to touch: nothing is painted, and no ink leaves the brush."""
    painter = sc.press(sc.turned_over(sc.sheet(sc.flat, (30.0, 30.0))))
    assert not painter.surface.coverage.any()
    ledger = painter.ledger()
    assert ledger["in_brush"] == ledger["loaded"]
    assert ledger["off_surface"] == 0.0


def test_the_table_has_every_case(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["surface_cases.py"])
    monkeypatch.setattr(sc, "cases", lambda: [sc.from_behind(), sc.plates()])
    sc.main()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert lines[3].startswith("plates 1 mm apart")
    assert np.isclose(float(lines[3].split()[-3]), 1.0, atol=0.01)


# -- cracks ------------------------------------------------------------------------------------


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

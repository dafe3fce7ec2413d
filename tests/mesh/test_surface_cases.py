"""Shapes that are hard to paint: the far side of a wall, edges, folds, shells, no thickness."""

from __future__ import annotations

import numpy as np
import pytest

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
    assert sc.box_edge(0.01).off > 0.3


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

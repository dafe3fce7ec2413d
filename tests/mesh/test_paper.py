"""Where outlines meet vertices on paper, and how much of the ink they take."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from paint3d.files.load import load_mesh
from paint3d.mesh.kernels.paper import MOST_ASIDE_MM
from paint3d.mesh.refined_mesh import PaintMesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, sheet


def met(mesh: PaintMesh) -> NDArray[np.float64]:
    """(V, 3) mm, how far from each vertex an outline meets it."""
    n, field = mesh.n_vertices, mesh.arrays
    places = np.stack([field.mx[:n], field.my[:n], field.mz[:n]], axis=1)
    return places.astype(float) - mesh.vertices


def on(name: str, material: str, resolution: float) -> PaintMesh:
    surface = PaintedSurface(load_mesh(name), resolution, material)
    surface.refine_all()
    return surface.paint_mesh


def test_a_glaze_meets_outlines_where_it_is_and_takes_alike() -> None:
    mesh = on("bowl", "porcelain", 2.0)
    assert not met(mesh).any()
    assert (mesh.arrays.take[: mesh.n_vertices] == 1.0).all()


@pytest.mark.parametrize(("name", "resolution"), [("bowl", 1.5), ("plane", 2.0)])
def test_outlines_are_met_in_the_surface_and_not_far_off(name: str, resolution: float) -> None:
    mesh = on(name, "xuan", resolution)
    aside = met(mesh)
    assert np.linalg.norm(aside, axis=1).max() < MOST_ASIDE_MM
    assert np.abs((aside * mesh.normals).sum(axis=1)).max() < 2e-5  # float32 coordinates
    assert aside.std() > 0.02


def test_a_place_has_the_same_paper_whoever_comes_there_first() -> None:
    """Vertices that were there and those that refinement adds; cells in any order."""
    fine = PaintedSurface(sheet(flat, (8.0, 8.0), 0.5), None, "xuan").paint_mesh
    coarse = PaintedSurface(sheet(flat, (8.0, 8.0), 4.0), 0.71, "xuan")
    coarse.refine_all()
    added = coarse.paint_mesh
    of = {tuple(place): k for k, place in enumerate(np.round(fine.vertices, 4))}
    pairs = [(k, of[p]) for k, p in enumerate(map(tuple, np.round(added.vertices, 4))) if p in of]
    own, other = np.array(pairs).T
    assert len(own) > 200
    longest = fine.arrays.soft_edge / added.arrays.soft_edge
    assert longest == pytest.approx(0.5 / 0.71, rel=0.5)
    shown = np.corrcoef(met(added)[own, 0], met(fine)[other, 0])[0, 1]
    assert shown > 0.9  # octaves that only the finer ones show are missing


def test_the_sheet_takes_its_share_on_the_whole() -> None:
    mesh = on("plane", "xuan", 1.0)
    take = mesh.arrays.take[: mesh.n_vertices]
    assert take.mean() == pytest.approx(1.0, abs=0.05)
    assert 0.015 < take.std() < 0.25


def stroke(speed: float = 60.0, y: float = 0.0, length: float = 24.0) -> Recording:
    """Along x; mm and mm/s."""
    n = round(80 * length / 24.0)
    x = np.linspace(-0.5 * length, 0.5 * length, n)
    at = np.column_stack([x, np.full(n, y), np.full(n, 30.0)])
    pressure = np.where((np.arange(n) > 0) & (np.arange(n) < n - 1), 0.3, 0.0)
    times = np.round(np.arange(n) * length / n / speed * 1e9).astype(np.int64)
    return Recording(times, at, np.tile((1.0, 0.0, 0.0, 0.0), (n, 1)), pressure)


def test_what_is_painted_twice_has_one_edge() -> None:
    surface = PaintedSurface(load_mesh("plane"), 0.3, "xuan")
    Painter(surface, "full", "pine soot").replay(stroke())
    once = surface.coverage.copy()
    Painter(surface, "full", "pine soot").replay(stroke())
    np.testing.assert_array_equal(surface.coverage[: len(once)], once)


def test_an_edge_strays_on_paper_by_some_hundredths_of_a_millimetre() -> None:
    covered = []
    for material in ("porcelain", "xuan"):
        surface = PaintedSurface(sheet(flat, (8.0, 6.0)), 0.2, material)
        surface.refine_all()
        Painter(surface, "full", "pine soot").replay(stroke())
        covered.append(surface.coverage.astype(float))
    strayed = np.abs(covered[1] - covered[0]) @ surface.vertex_areas / (2.0 * 16.0)
    assert 0.015 < strayed < 0.1
    assert covered[1].sum() == pytest.approx(covered[0].sum(), rel=0.03)


def covered(speed: float, load: float = 1.0) -> tuple[float, float]:
    """Cover along the middle of 150 mm, of its first third and of its last."""
    surface = PaintedSurface(sheet(flat, (85.0, 12.0), 4.0), 0.2, "xuan")
    painter = Painter(surface, "full", "pine soot")
    painter.wipe(1.0 - load)
    painter.replay(stroke(speed, length=150.0))
    x, y, _ = surface.paint_mesh.vertices.T
    middle = np.abs(y) < 1.2
    first, last = middle & (x > -65.0) & (x < -30.0), middle & (x > 25.0) & (x < 60.0)
    return float(surface.coverage[first].mean()), float(surface.coverage[last].mean())


@pytest.mark.parametrize("load", [1.0, 0.6])
def test_a_fast_brush_comes_down_wet_and_flies_white_at_the_end(load) -> None:
    """docs/model.md, equation (13): ink cannot follow from the belly."""
    first, last = covered(400.0, load)
    assert first > 0.95 > 0.9 > last > 0.3
    assert covered(100.0, load)[1] > last + 0.1


def test_the_last_of_a_fast_brush_still_marks() -> None:
    assert min(covered(300.0, 0.125)) > 0.05


STROKES_Y = (-60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0)


def coats_within(material: str, speed: float) -> tuple[float, float]:
    """Mean coats along the middles of shafts of strokes, and beside them, just within their edges.

    Strokes lie apart, for each has lanes of its own.
    """
    surface = PaintedSurface(load_mesh("plane"), 0.2, material)
    for y in STROKES_Y:
        Painter(surface, "full", "pine soot").replay(stroke(speed, y))
    vertices = surface.paint_mesh.vertices
    shaft = (np.abs(vertices[:, 0]) < 6.0) & (surface.coverage > 0.95)
    aside = np.abs(vertices[:, 1:2] - np.array(STROKES_Y)).min(axis=1)
    edge = aside[shaft].max()
    coats = surface.amounts.sum(axis=1)
    middle, rim = shaft & (aside < 0.2 * edge), shaft & (aside > 0.7 * edge)
    return float(coats[middle].mean()), float(coats[rim].mean())


def test_paper_takes_more_where_the_hand_lingers_and_a_glaze_does_not() -> None:
    """docs/model.md, equation (12b)."""
    slow, fast = coats_within("xuan", 15.0)[0], coats_within("xuan", 120.0)[0]
    assert slow > 1.15 * fast
    slow, fast = coats_within("porcelain", 15.0)[0], coats_within("porcelain", 120.0)[0]
    assert slow == pytest.approx(fast, rel=0.01)


def test_paper_takes_most_under_the_middle_of_a_tuft_and_a_glaze_at_the_rim() -> None:
    """Equation (12b); on a glaze the film is drawn to its rims (12)."""
    (middle, rim), (glazed_middle, glazed_rim) = (
        coats_within(material, 30.0) for material in ("xuan", "porcelain")
    )
    assert middle / rim > 1.05 > glazed_middle / glazed_rim


def test_a_brush_that_rests_on_the_paper_is_filled_again() -> None:
    """Ink comes down from the belly meanwhile: equation (13)."""
    halves = []
    for pause in (0.0, 2.0):
        surface = PaintedSurface(sheet(flat, (85.0, 12.0), 4.0), 0.2, "xuan")
        going = stroke(400.0, length=150.0)
        half = len(going.time_ns) // 2
        resting = 40 if pause else 0
        order = np.r_[0:half, np.full(resting, half), half : len(going.time_ns)]
        steps = np.r_[0, np.diff(going.time_ns)][order]
        steps[half : half + resting] = int(pause * 1e9 / max(resting, 1))
        Painter(surface, "full", "pine soot").replay(
            Recording(np.cumsum(steps), going.position[order], going.orientation[order],
                      going.pressure[order])
        )  # fmt: skip
        x, y, _ = surface.paint_mesh.vertices.T
        after = (np.abs(y) < 1.2) & (x > 12.0) & (x < 30.0)
        halves.append(float(surface.coverage[after].mean()))
    assert halves[1] > 0.98 > halves[0] + 0.03

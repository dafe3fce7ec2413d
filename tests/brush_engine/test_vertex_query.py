"""Whole blocks of vertices are passed over or taken: the same paint as weighing every vertex."""

import math

import numpy as np
import pytest

import paint3d.brush_engine.scratch
from paint3d.device.recorded import Recording
from paint3d.mesh.triangle_mesh import TriangleMesh
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from scripts.solids import make_sphere


def turning_stroke() -> Recording:
    """A pressed stroke along an arc that turns, thickens and thins; root over z = 0."""
    t = np.linspace(0.0, 1.0, 60)
    angle = 2.0 * t
    turn = 0.75 * angle
    position = np.stack([18.0 * np.sin(angle) - 9.0, 12.0 * np.cos(angle), 30.0 + 0.0 * t], axis=1)
    orientation = np.stack([np.cos(turn), 0.0 * t, 0.0 * t, np.sin(turn)], axis=1)
    pressure = 0.1 + 0.8 * np.sin(math.pi * t)
    return Recording((t * 1.2e9).astype(np.int64), position, orientation, pressure)


def fine_plane() -> TriangleMesh:
    side, spacing = 181, 0.4
    line = (np.arange(side) - 0.5 * (side - 1)) * spacing
    x, y = (axis.ravel() for axis in np.meshgrid(line, line))
    i = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return TriangleMesh(np.stack([x, y, 0.0 * x], axis=1), faces.astype(np.int32))


def fine_sphere() -> TriangleMesh:
    ball = make_sphere()
    vertices = np.array(ball.vertices, np.float64)
    return TriangleMesh(vertices - [0.0, 0.0, vertices[:, 2].max()], ball.faces)


def painted(
    mesh: TriangleMesh, growth: float, brush: str = "full", hairs: int | None = None
) -> tuple[np.ndarray, np.ndarray, int]:
    """Amounts and coverage with the balls around the blocks made larger by so many mm.

    Hairs are dry.
    """
    surface = PaintedSurface(mesh, resolution=None)
    surface.paint_mesh.arrays.block_balls[3] += growth
    painter = Painter(surface, brush, hairs=hairs)
    painter.wipe(0.8 if hairs else 0.0)
    painter.replay(turning_stroke())
    return surface.amounts[:, 0], surface.coverage, painter.report()["vertices_visited"]


@pytest.mark.parametrize(
    ("make", "brush", "hairs"),
    [
        (fine_plane, "full", None),
        (fine_sphere, "full", None),
        (fine_plane, "full", 1000),  # blunt at both ends
        (fine_plane, "zhongbaiyun", None),  # has a blunt tip
    ],
)
def test_blocks_change_nothing(make, brush, hairs) -> None:
    mesh = make()
    amounts, coverage, visited = painted(mesh, 0.0, brush, hairs)
    all_amounts, all_coverage, all_visited = painted(mesh, 1e3, brush, hairs)
    assert np.count_nonzero(coverage > 0.5) > 50
    assert visited < all_visited
    assert np.abs(amounts - all_amounts).max() < 1e-6 * all_amounts.max()
    assert np.abs(coverage - all_coverage).max() < 1e-6


def test_a_ball_that_is_too_small_would_show() -> None:
    mesh = fine_plane()
    amounts, _, _ = painted(mesh, 0.0)
    less, _, _ = painted(mesh, -1.2)
    assert np.abs(amounts - less).max() > 0.02 * amounts.max()


@pytest.mark.parametrize("hairs", [0, 200])
def test_a_block_goes_on_where_the_last_one_ended(monkeypatch, hairs) -> None:
    """Base vertices and those added for painting, in blocks of 48 and of as many as there are."""
    found = {}
    for block in (48, 8192):
        monkeypatch.setattr(paint3d.brush_engine.scratch, "_BLOCK", block)
        surface = PaintedSurface(fine_plane(), resolution=0.25)
        painter = Painter(surface, "full", hairs=hairs)
        painter.replay(turning_stroke())
        found[block] = (surface.amounts, surface.coverage, painter.report()["vertices_visited"])
    amounts, coverage, visited = found[48]
    whole_amounts, whole_coverage, whole_visited = found[8192]
    assert np.count_nonzero(coverage > 0.5) > 200
    assert visited == whole_visited
    assert np.abs(amounts - whole_amounts).max() < 1e-6 * amounts.max()
    assert np.abs(coverage - whole_coverage).max() < 1e-6

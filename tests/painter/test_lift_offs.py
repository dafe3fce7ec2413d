"""What a fast hand leaves as it lifts the brush: a tail, measured from flank to flank."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.outlines import lift_off
from tests.support.surface_cases import flat, poses, sheet

BEGINS, LIFT_MM = 0.25, 14.0  # 70 ms of a hand of 200 mm/s
RESOLUTION = 0.1  # mm
COLUMN = 0.5  # mm: rows of vertices, 2 / 16 mm apart, fall evenly into it
THIN = 1.0  # mm


def painted_widths(hairs: int | None, azimuth: str) -> tuple[NDArray, NDArray, float]:
    """Middles of columns (mm), how wide all the mark is there (mm), and where it ends (mm)."""
    x = np.arange(-14.0, LIFT_MM + 1e-9, 0.8)  # 250 samples a second
    places = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    pressure = BEGINS * np.clip(1.0 - x / LIFT_MM, 0.0, 1.0)
    recording = poses(places, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), pressure, "full", rate=250.0)
    surface = PaintedSurface(sheet(flat, (22.0, 7.0), 2.0), RESOLUTION, "porcelain")
    Painter(surface, "full", azimuth=azimuth, hairs=hairs).replay(recording)
    along, cover = np.asarray(surface.paint_mesh.vertices)[:, 0], surface.coverage
    edges = np.arange(0.2, LIFT_MM + 1.0, COLUMN)
    areas, _ = np.histogram(along, edges, weights=np.minimum(cover, 1.0) * surface.vertex_areas)
    return edges[:-1] + 0.5 * COLUMN, areas / COLUMN, float(along[cover > 0.2].max())


@pytest.mark.parametrize("azimuth", ["commanded", "dragged"])
@pytest.mark.parametrize(("hairs", "narrower"), [(None, 0.04), (1000, 0.32)])
def test_a_tail_is_as_long_as_the_way_that_a_footprint_is_narrow(hairs, narrower, azimuth):
    """No lag and no raster shortens it, and nothing of it swells; hairs end .9 mm sooner."""
    meant, half = lift_off(build_tuft(load_brush("full")), BEGINS, LIFT_MM)
    at, width, end = painted_widths(hairs, azimuth)
    on_the_way = at < end - 0.5 * COLUMN
    at, width = at[on_the_way], width[on_the_way]
    missing = np.interp(at, meant, 2.0 * half) - width
    assert missing.min() > -0.04
    assert missing.max() < narrower
    tail = end - np.interp(-THIN, -width, at)
    assert tail == pytest.approx(meant[half > 0.0][-1] - meant[half > 0.5 * THIN][-1], abs=0.25)
    assert end > LIFT_MM - 1.1
    slope = -np.diff(width) / COLUMN
    assert slope.min() > 0.0
    assert np.abs(np.diff(slope)).max() < 0.06

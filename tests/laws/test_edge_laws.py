"""Laws of the edges that a footprint draws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import flat, sheet


def unevenness(aside: float, pressure: float, step_mm: float, hairs: int | None) -> float:
    """How much the ink of a row of vertices varies along a stroke, over its mean: the worst row.

    Rows that the outline hardly reaches do not count. The tuft lies `aside` (rad) of where it would
    trail; edges lie along the rows.
    """
    n = 1 + round(40.0 / step_mm)
    x, half = np.linspace(-20.0, 20.0, n), 0.5 * (math.pi + aside)
    position = np.stack([x, 0.0 * x, np.full(n, 30.0)], axis=1)
    turned = np.tile([math.cos(half), 0.0, 0.0, math.sin(half)], (n, 1))
    surface = PaintedSurface(sheet(flat, (30.0, 30.0), 4.0), 0.25, "porcelain")
    recording = Recording(np.arange(n) * 8_000_000, position, turned, np.full(n, pressure))
    Painter(surface, "slender", hairs=hairs).replay(recording)
    vertices, ink = np.asarray(surface.mesh.vertices, float), surface.amounts.sum(axis=1)
    far = abs(vertices[:, 0]) < 2.5  # from where the stroke begins and ends
    rows, row = np.unique(np.round(vertices[far, 1], 3), return_inverse=True)
    worst = 0.0
    for i in range(len(rows)):
        here, there = ink[far][row == i], vertices[far, 0][row == i]
        if here.mean() > 0.2 and surface.coverage[far][row == i].mean() > 0.15:
            trend = np.polyval(np.polyfit(there, here, 1), there)  # it runs out of ink
            worst = max(worst, float((here - trend).std() / here.mean()))
    assert worst > 0.0
    return worst


@pytest.mark.parametrize("hairs", [None, 300])
@settings(deadline=None, max_examples=25)
@given(
    aside=st.floats(0.6, 2.0),
    left=st.booleans(),
    pressure=st.floats(0.15, 0.55),
    step_mm=st.sampled_from([0.17, 1.0 / 3.0, 0.7]),
)
def test_a_tuft_that_goes_sideways_draws_edges_without_teeth(hairs, aside, left, pressure, step_mm):
    assert unevenness(-aside if left else aside, pressure, step_mm, hairs) < 0.2

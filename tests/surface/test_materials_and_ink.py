"""How ink stands on paper, sized or not, and on silk: the width of what runs out of a stroke."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

LIGHT = {"pine soot": 0.2, "water": 0.8}
SEEN = 0.02  # coats


def stroke() -> Recording:
    """15 mm along x, with light ink."""
    n = 38
    at = np.column_stack([np.linspace(-7.5, 7.5, n), np.zeros(n), np.full(n, 30.0)])
    pressure = np.where((np.arange(n) > 0) & (np.arange(n) < n - 1), 0.35, 0.0)
    times = np.arange(n, dtype=np.int64) * 15_000_000
    return Recording(times, at, np.tile((1.0, 0.0, 0.0, 0.0), (n, 1)), pressure)


def half_width(surface: PaintedSurface) -> float:
    """Of what is seen, mm; the mean along the middle of the stroke."""
    points = surface.mesh.vertices
    soot = [k for k, pigment in enumerate(surface.pigments) if pigment.name != "water"]
    seen = surface.amounts[:, soot].sum(axis=1) * surface.coverage > SEEN
    reaches = []
    for x in np.arange(-3.0, 3.0, 0.6):
        here = seen & (np.abs(points[:, 0] - x) < 0.3)
        reaches.append(np.abs(points[here, 1]).max())
    return float(np.mean(reaches))


@cache
def halo(material: str) -> float:
    """By how much a stroke grows to either side in half a minute, mm."""
    surface = PaintedSurface(load_mesh("plane"), 0.4, material)
    Painter(surface, "full", LIGHT).replay(stroke())
    before = half_width(surface)
    surface.diffuse(30.0)
    return half_width(surface) - before


@pytest.mark.long
def test_raw_xuan_feathers_and_sized_xuan_and_silk_hold_the_ink() -> None:
    assert halo("xuan") == pytest.approx(1.9, abs=0.3)
    assert halo("sized xuan") < 0.3
    assert halo("silk") < 0.5


def test_half_sized_paper_lies_between() -> None:
    assert halo("silk") < 0.5 * halo("tinted xuan") < 0.5 * halo("xuan")

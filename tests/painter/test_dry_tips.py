"""A tuft of hairs that runs dry: where its mark ends, and how its outline gets there."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.brush_engine.dry_contact import bundle_noise, contact_noise
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface
from tests.painter.test_hair_painting import sample_of
from tests.support.cases import long_but
from tests.support.surface_cases import flat, on_sphere, poses, sheet

CELL_MM = 0.25
THINNEST_MM = 0.4  # a wet hair


def lifted(n: int, brush: str) -> Recording:
    """A stroke along x that is lifted evenly from place 1 mm to where it ends, at 10 mm."""
    x = np.linspace(-8.0, 10.0, n)
    points = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
    pressure = 0.42 * np.clip((10.0 - x) / 9.0, 0.0, 1.0)
    return poses(points, (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), pressure, brush, rate=125.0)


def dry_brush(hairs: int, load: float, place=flat, brush: str = "full") -> Painter:
    surface = PaintedSurface(sheet(place, (24.0, 7.0), 2.0), 0.15, "porcelain")
    painter = Painter(surface, brush, hairs=hairs)
    painter.wipe(1.0 - load)
    return painter


def widths_along(surface: PaintedSurface) -> np.ndarray:
    """Width of the mark (mm) in cells along x, from place 0 to its end."""
    vertices = np.asarray(surface.mesh.vertices, float)[surface.coverage > 0.3]
    cells = np.floor(vertices[:, 0] / CELL_MM).astype(int)
    return np.array([np.ptp(vertices[cells == k, 1]) for k in range(cells.max() + 1)])


@pytest.mark.parametrize("place", [flat, on_sphere(75.0)], ids=["flat", "ball"])
@pytest.mark.parametrize(
    ("hairs", "load"),
    long_but([(1000, 0.25), (100, 0.36)], [(1000, 0.36), (1000, 0.25), (100, 0.36)]),
)
def test_beyond_a_dry_tip_no_line_is_drawn(hairs, load, place):
    """Where most hairs have left the surface the few that have not draw no line on: it tapers."""
    painter = dry_brush(hairs, load, place)
    painter.replay(lifted(120, "full"))
    widths = widths_along(painter.surface)
    thin = len(widths) - 1 - np.flatnonzero(widths > THINNEST_MM)[-1]
    assert thin * CELL_MM <= 0.75
    assert -np.diff(widths).min() < 0.6


@pytest.mark.parametrize("brush", ["full", "slender"])
@pytest.mark.parametrize("load", [0.5, 0.36, 0.16])
def test_the_outline_of_hairs_changes_without_jumps(brush, load):
    """Law 1 for hairs that are lifted: neither end of the outline, nor its width, jumps (mm)."""
    painter, recording = dry_brush(1000, load, brush=brush), lifted(180, brush)
    found = []
    for k in range(len(recording)):
        painter.advance([sample_of(recording, k)])
        values = painter.stamp.values[0]
        if 0.0 < recording.pressure[k] < 0.4 and values["touches"] > 0.0:
            found.append((values["heel"], values["tip"], values["widest"]))
    painter.finish()
    assert len(found) > 70
    assert np.abs(np.diff(found, n=2, axis=0)).max() < 0.15


def test_bundles_are_read_from_the_noise_of_the_tooth():
    """Four bytes to a number: a place, a step across, a step along, and both; it repeats."""
    noise, four = contact_noise().reshape(64, 64, 64), bundle_noise().view(np.int8)
    for layer, packed in zip((3, 35), four.reshape(2, 64, 64, 4), strict=True):
        for place, (across, along) in enumerate(((0, 0), (1, 0), (0, 1), (1, 1))):
            there = np.roll(noise[layer], (-across, -along), axis=(0, 1))
            assert (packed[:, :, place] == there).all()
    assert (four != 0).any()

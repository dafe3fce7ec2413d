"""Outlines of strokes by Guo 2015's zones, against unions of footprints and painted areas."""

import functools
import math

import numpy as np
import pytest
from shapely import Polygon, unary_union

from paint3d.brush.bending import build_tuft
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.stroke_sides import stroke_outlines, stroke_polygon
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.painter.painter import Painter
from paint3d.recording.recording import Recording
from paint3d.surface.painted_surface import PaintedSurface

BRUSH = "zhongbaiyun"


@functools.cache
def tuft():
    return build_tuft(load_brush(BRUSH))


def recording(xy, bend, pressure, **header):
    n = len(xy)
    height = tuft().length - np.asarray(pressure) * tuft().full_press
    half = 0.5 * np.asarray(bend)
    turn = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
    position = np.column_stack([xy, height])
    return Recording(np.arange(n) * 4_000_000, position, turn, pressure, header=header)


def curved(n=240):
    """A stroke that bends, swells and turns the tuft."""
    t = np.linspace(0.0, 1.0, n)
    xy = 30.0 * np.column_stack([t - 0.5, 0.6 * np.sin(2.5 * t)])
    pressure = 0.45 * np.sin(np.pi * t) ** 0.7
    return xy, math.pi + 1.2 * t, np.where((t == 0) | (t == 1), 0.0, pressure)


def turning(n=120):
    """A press that turns on the spot."""
    t = np.linspace(0.0, 1.0, n)
    pressure = 0.4 * np.minimum(1.0, 8.0 * np.minimum(t, 1.0 - t))
    return np.zeros((n, 2)), 2.0 * t, pressure


def returning(n=240):
    """There and back, pressed deeper on the way back."""
    t = np.linspace(0.0, 1.0, n)
    xy = np.column_stack([20.0 * np.sin(np.pi * t), 0 * t])
    return xy, np.full(n, math.pi), np.minimum(0.2 + 0.3 * t, 6.0 * np.minimum(t, 1.0 - t))


def area(rings):
    """Area inside, holes running the other way round."""
    total = 0.0
    for ring in rings:
        x, y = ring.T
        total += 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    return total


@functools.cache
def painted_area(kind):
    surface = PaintedSurface(load_mesh("plane"), resolution=0.2)
    Painter(surface, brush=BRUSH).replay(recording(*kind()))
    mesh = surface.mesh
    corners = np.asarray(mesh.vertices, float)[mesh.faces]
    size = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    cover = np.asarray(surface.coverage, float)[mesh.faces]
    return float((size * np.clip(cover, 0.0, 1.0).mean(axis=1)).sum())


@pytest.mark.parametrize("kind", [curved, turning, returning])
def test_area_is_that_of_the_painted_stroke(kind):
    (rings,) = stroke_outlines(recording(*kind()), load_brush(BRUSH))
    assert area(rings) == pytest.approx(painted_area(kind), rel=0.01)


@pytest.mark.parametrize("kind", [curved, turning, returning])
def test_every_footprint_lies_within(kind):
    xy, azimuth, pressure = kind()
    prints = [
        make_footprint(tuft(), p * tuft().full_press, 0.5 * math.pi, a)
        for p, a in zip(pressure, azimuth, strict=True)
        if p > 0.0
    ]
    feet = xy[np.asarray(pressure) > 0.0]
    kept = [not f.is_empty for f in prints]
    feet, prints = feet[kept], [f for f in prints if not f.is_empty]
    shape = stroke_polygon(feet, prints)
    union = unary_union(
        [Polygon(f.polygon() + foot).buffer(0) for f, foot in zip(prints, feet, strict=True)]
    )
    assert union.difference(shape).area < 0.004 * union.area


def test_strokes_are_told_apart():
    xy, azimuth, pressure = curved()
    both = recording(
        np.concatenate([xy, xy + 40.0]), np.r_[azimuth, azimuth], np.r_[pressure, pressure]
    )
    outlines = stroke_outlines(both, load_brush(BRUSH))
    assert len(outlines) == 2
    assert area(outlines[0]) == pytest.approx(area(outlines[1]), rel=1e-6)


def test_a_recording_that_cannot_be_outlined_is_refused():
    xy, azimuth, pressure = curved(20)
    with pytest.raises(InputError, match="commanded azimuth"):
        stroke_outlines(recording(xy, azimuth, pressure, azimuth="dragged"), load_brush(BRUSH))
    leaning = Recording(
        np.arange(2), np.zeros((2, 3)), np.tile([0.92388, 0.38268, 0, 0], (2, 1)), np.full(2, 0.3)
    )
    with pytest.raises(InputError, match="upright"):
        stroke_outlines(leaning, load_brush(BRUSH))

"""A tuft of hairs and a solid one of the same brush: alike where they stand, land and leave."""

from __future__ import annotations

import dataclasses
import json
from importlib.resources import files

import numpy as np
import pytest

from paint3d.brush_engine.bristles.bend import BLOCK, SAMPLES
from paint3d.brush_engine.bristles.contact import BEGIN, END
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.painter.test_hair_painting import covered, paint, plane, sample_of
from tests.support.cases import long_but
from tests.support.surface_cases import flat, on_sphere, poses, sheet

UP, BACK = (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)
PRESETS = sorted(json.loads(files("paint3d.brush").joinpath("presets.json").read_text()))
STANCES = [(tilt, press) for tilt in (90, 60, 45) for press in (0.25, 0.4, 0.7)]


def standing(painter, tilt, press):
    """Length and width of the footprint of a brush that stands pressed, mm."""
    still = np.zeros((6, 3))
    still[:, 0] = np.linspace(0.0, -0.02, 6)
    pressure, brush = np.full(6, press), painter.brush.name
    recording = poses(still, UP, BACK, pressure, brush, np.radians(tilt), 125.0)
    painter.dip()
    painter.advance(sample_of(recording, k) for k in range(6))
    values = painter.stamp.values[0].copy()
    painter.finish()
    return values["tip"] - values["heel"], 2.0 * values["widest"]


@pytest.mark.parametrize("brush", PRESETS)
def test_hairs_and_solid_tuft_stand_alike(brush):
    surface = PaintedSurface(sheet(flat, (75.0, 40.0), 5.0), 0.5, "porcelain")
    painters = [Painter(surface, brush, hairs=n) for n in (0, 1000)]
    sizes = np.array([[standing(p, *stance) for stance in STANCES] for p in painters])
    off = np.abs(sizes[1] / sizes[0] - 1.0)
    assert (off[:, 0] <= 0.1).sum() >= 7
    assert off[:, 0].max() <= (0.14 if brush == "gongbi" else 0.13)  # 0.4 mm of the finest
    slim = 0.42 / sizes[0, :, 1]  # mm: hairs and their film are no thinner under a thin brush
    assert (off[:, 1] <= np.maximum(0.135, slim)).all()


@pytest.mark.parametrize(
    ("brush", "press", "tilt"),
    [("full", 0.25, 90), ("full", 0.4, 60), ("full", 0.7, 45), ("zhongkai", 0.4, 90),
     ("dabaiyun", 0.4, 60)],
)  # fmt: skip
def test_what_they_paint_standing_is_alike(brush, press, tilt):
    still = np.zeros((4, 3))
    still[:, 0] = [0.0, -0.03, -0.07, -0.1]  # mm: so much that it inks
    recording = poses(still, UP, BACK, np.full(4, press), brush, np.radians(tilt), 125.0)
    found = [
        covered(paint(recording, surface=plane(0.3, (60.0, 15.0)), hairs=n, brush=brush))
        for n in (0, 1000)
    ]
    (length, width), (hair_length, hair_width) = (np.ptp(points[:, :2], axis=0) for points in found)
    assert hair_length == pytest.approx(length, rel=0.1)
    assert hair_width == pytest.approx(width, abs=max(0.1 * width, 0.7))  # two vertices


@pytest.mark.parametrize("tilt", [90, 60])
def test_a_light_touch_widens_without_steps(tilt):
    """Writing is done with the last millimetres of the tuft: a hair more must not be seen."""
    surface = PaintedSurface(sheet(flat, (75.0, 40.0), 5.0), 0.5, "porcelain")
    presses = np.arange(0.02, 0.122, 0.006)
    painters = [Painter(surface, "zhongbaiyun", hairs=n) for n in (0, 1000)]
    solid, hairs = (np.array([standing(p, tilt, press) for press in presses]) for p in painters)
    assert np.abs(hairs[:, 1] / solid[:, 1] - 1.0).max() < 0.2
    assert np.abs(hairs[:, 0] - solid[:, 0]).max() < 0.35  # mm
    assert np.diff(hairs[:, 1]).max() < 0.3  # mm, of both sides
    assert np.diff(hairs[:, 1]).min() > -0.05


@pytest.mark.parametrize("press", [0.05, 0.062, 0.2])
@pytest.mark.parametrize("tilt", [90, 60])
def test_what_touches_lies_on_the_paper(tilt, press):
    """No hair touches first where it hangs over the surface: half a millimetre on the straight line
    between two of its points is the most that its curve may lie below that."""
    surface = PaintedSurface(sheet(flat, (75.0, 40.0), 5.0), 0.5, "porcelain")
    painter = Painter(surface, "zhongbaiyun", hairs=1000)
    standing(painter, tilt, press)
    work = painter.hairs.work(surface)
    heights = work.points[:, :, 2 * BLOCK :].astype(float)  # block, point, hair
    hair_contacts = work.hair_contacts.astype(float)
    touching = 0
    for g, row in enumerate(hair_contacts):
        for j in range(BLOCK):
            begin, end = row[BEGIN + j], row[END + j]
            if end < 0.0:
                continue
            touching += 1
            height = np.interp(begin, np.arange(SAMPLES), heights[g, :, j])
            assert height <= 0.5, (g, j, begin, end)
    assert touching > 300


def painted(press, hairs, brush, way, material="porcelain"):
    n = len(press)
    points = np.zeros((n, 3))
    points[:, 0] = np.linspace(-0.5 * way, 0.5 * way, n)
    painter = Painter(
        PaintedSurface(sheet(flat, (45.0, 20.0), 5.0), 0.4, material), brush, hairs=hairs
    )
    painter.replay(poses(points, UP, BACK, press, brush, rate=125.0))
    return painter


def widths_along(painter):
    """Width of what was painted, mm, in steps of 1 mm along the stroke."""
    points = painter.surface.mesh.vertices[painter.surface.coverage > 0.5].astype(float)
    at = np.floor(points[:, 0] + 45.0).astype(int)
    return np.array([np.ptp(points[at == k, 1]) if (at == k).any() else 0.0 for k in range(90)])


@pytest.mark.parametrize("brush", ["full", "zhongkai", "dabaiyun"])
def test_a_press_that_comes_and_goes_is_as_wide_everywhere(brush):
    press = 0.6 * np.sin(np.pi * np.linspace(0.0, 1.0, 40))
    solid, hairs = (widths_along(painted(press, n, brush, 16.0)) for n in (0, 1000))
    assert np.abs(hairs - solid).sum() < 0.09 * solid.sum()
    assert np.abs(hairs - solid).max() < 0.22 * solid.max()


@pytest.mark.parametrize("press", [0.04, 0.08])
def test_a_light_hand_gives_what_it_gives_with_a_solid_tuft(press):
    held = np.full(40, press)
    solid, hairs = (painted(held, n, "full", 24.0) for n in (0, 1000))
    assert hairs.ledger()["wet"] == pytest.approx(solid.ledger()["wet"], rel=0.1)
    assert hairs.surface.coverage.sum() == pytest.approx(solid.surface.coverage.sum(), rel=0.15)


def painted_round(radius, tilt, press, hairs):
    """A stroke of 36 mm along a sphere, from outside or (negative radius) from inside."""
    painter = Painter(
        PaintedSurface(sheet(on_sphere(radius), (30.0, 20.0), 2.5), 0.5, "porcelain"),
        "full", hairs=hairs,
    )  # fmt: skip
    angle, out = np.linspace(-18.0, 18.0, 40) / abs(radius), np.sign(radius)
    sine, cosine, none = np.sin(angle), np.cos(angle), np.zeros(40)
    points = np.stack([abs(radius) * sine, none, radius * (cosine - 1.0)], axis=1)
    normals = np.stack([out * sine, none, cosine], axis=1)
    back = np.stack([-cosine, none, out * sine], axis=1)
    for k in range(40):
        held = np.full(1, press)
        recording = poses(points[k : k + 1], normals[k], back[k], held, "full", np.radians(tilt))
        sample = sample_of(recording, 0)
        painter.advance([dataclasses.replace(sample, time_ns=8_000_000 * k)])
    painter.finish()
    return painter


@pytest.mark.parametrize("radius", long_but([75.0, -40.0], [75.0, 150.0, -40.0]))
@pytest.mark.parametrize(
    ("tilt", "press"), [(60, 0.05), (60, 0.15), (60, 0.3), (45, 0.15), (90, 0.15)]
)
def test_hairs_find_a_curved_surface_as_the_solid_tuft_does(radius, tilt, press):
    """How deep they are pressed counts from where the tuft touches, not from the plane there."""
    solid, hairs = (painted_round(radius, tilt, press, n) for n in (0, 1000))
    assert hairs.ledger()["wet"] == pytest.approx(solid.ledger()["wet"], rel=0.1)
    wide = [np.count_nonzero(p.surface.coverage > 0.5) for p in (solid, hairs)]
    assert 0.8 < wide[1] / wide[0] < 1.5

"""A pressed footprint against a slow, obvious twin: carry every vertex, ask the polygon."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from paint3d.brush.bending import tuft_on
from paint3d.brush.footprint import make_footprint
from paint3d.brush.presets import load_brush
from paint3d.brush_engine.footprint import PROFILE_CELLS
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.support.surface_cases import UPRIGHT, flat, on_cylinder, on_sphere, poses, sheet

NEAR = 0.15  # mm from the outline, where soft edges may say either


def press(mesh, pressure, azimuth=0.0, tilt=UPRIGHT, brush="full", resolution=0.3) -> Painter:
    """Set the brush on the origin and leave it there."""
    painter = Painter(PaintedSurface(mesh, resolution), brush)
    along = (np.cos(azimuth), np.sin(azimuth), 0.0)
    here = np.zeros((2, 3))
    painter.replay(poses(here, (0.0, 0.0, 1.0), along, np.full(2, pressure), brush, tilt))
    return painter


def inside(points: NDArray, polygon: NDArray) -> NDArray:
    """Whether each point (N, 2) lies in a closed polygon (K, 2): crossings to the right."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return (spans & (x < at)).sum(axis=1) % 2 == 1


def distance(points: NDArray, polygon: NDArray) -> NDArray:
    """Distance of each point (N, 2) to the polygon's outline, mm."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    edge = b - a
    t = np.einsum("nkd,kd->nk", points[:, None] - a, edge) / np.sum(edge * edge, axis=1)
    nearest = a + np.clip(t, 0.0, 1.0)[..., None] * edge
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)


def disagreements(painter: Painter, places: NDArray, polygon: NDArray, bare: NDArray) -> int:
    """Vertices painted by one and not by the other, away from the outline."""
    painted = painter.surface.coverage >= 0.5
    near = np.abs(places).max(axis=1) < 60.0
    twin = np.zeros(len(places), bool)
    clear = np.ones(len(places), bool)
    twin[near] = inside(places[near], polygon)
    clear[near] = distance(places[near], polygon) > NEAR
    twin &= ~bare
    return int(np.count_nonzero((painted != twin) & clear))


@pytest.mark.parametrize("brush", ["full", "slender", "xiaokai"])
@pytest.mark.parametrize(
    ("pressure", "azimuth", "tilt"),
    [(0.4, 0.0, UPRIGHT), (0.15, 2.1, UPRIGHT), (0.8, -1.0, 1.3), (0.4, 0.7, 0.7)],
)
def test_a_dab_on_the_plane_is_the_footprint(brush, pressure, azimuth, tilt):
    painter = press(sheet(flat, (40.0, 40.0), 5.0), pressure, azimuth, tilt, brush)
    spec = load_brush(brush)
    tuft = tuft_on(spec, painter.surface.material)
    footprint = make_footprint(tuft, pressure * spec.full_press_mm, tilt, azimuth)
    footprint = footprint.rounded()
    vertices = painter.surface.paint_mesh.vertices
    no = np.zeros(len(vertices), bool)
    assert np.count_nonzero(painter.surface.coverage >= 0.5) > 20
    assert disagreements(painter, vertices[:, :2].astype(float), footprint.polygon(), no) == 0
    area = float(painter.surface.vertex_areas @ painter.surface.coverage)
    assert area == pytest.approx(footprint.area, rel=0.05, abs=0.3)


@pytest.mark.parametrize("shape", ["sphere", "dish", "cylinder"])
def test_a_dab_on_curved_ground_is_carried_along_normals(shape):
    place = {"sphere": on_sphere(40.0), "dish": on_sphere(-60.0), "cylinder": on_cylinder(30.0)}
    painter = press(sheet(place[shape], (25.0, 25.0), 1.0), 0.4, 0.5)
    values = painter.stamp.values[0]
    profile = painter.stamp.half_widths[: PROFILE_CELLS + 1]
    normal, bend, cross, foot = (values[k] for k in ("normal", "bend", "cross", "origin"))
    vertices = painter.surface.paint_mesh.vertices.astype(float)
    normals = painter.surface.paint_mesh.normals.astype(float)
    facing = normals @ normal
    away = vertices - foot
    landed = away - normals * (away @ normal / facing)[:, None]
    places = np.stack([landed @ bend, landed @ cross], axis=1)
    reach = np.linspace(values["heel"], values["tip"], len(profile))
    polygon = np.column_stack([np.r_[reach, reach[-2:0:-1]], np.r_[profile, -profile[-2:0:-1]]])
    sphere = values["sphere_centre"]
    outside = np.linalg.norm(foot + landed - sphere, axis=1) > values["radius"] + 0.2
    assert np.count_nonzero(painter.surface.coverage >= 0.5) > 200
    assert disagreements(painter, places, polygon, (facing < 0.25) | outside) == 0


def test_the_plane_leans_to_the_mean_normal():
    """On a sphere the patch lies ahead of the foot, so the plane leans that way; on a plane not."""
    normals = {}
    for name, place in (("plane", flat), ("sphere", on_sphere(60.0)), ("dish", on_sphere(-60.0))):
        painter = press(sheet(place, (25.0, 25.0), 1.0), 0.4)
        normals[name] = painter.stamp.values[0]["normal"]
    np.testing.assert_allclose(normals["plane"], [0.0, 0.0, 1.0], atol=1e-6)
    assert 0.005 < normals["sphere"][0] < 0.2
    assert -0.2 < normals["dish"][0] < -0.005
    assert np.abs([n[1] for n in normals.values()]).max() < 0.01


def test_the_mesh_under_the_brush_does_not_move_the_plane():
    """The mean runs over surface, not over vertices: a mesh that is finer ahead changes nothing."""
    rng = np.random.default_rng(1)
    leans = []
    for edge in (0.7, 2.0):
        mesh = sheet(on_sphere(60.0), (25.0, 25.0), edge)
        values = press(mesh, 0.4, rng.uniform(0.0, 1e-9)).stamp.values
        leans.append(values[0]["normal"][0])
    assert leans[0] == pytest.approx(leans[1], abs=3e-3)

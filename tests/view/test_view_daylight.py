"""Shadows and mirrored studio against what geometry says."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.view import daylight
from paint3d.view.daylight import Ground, Occluder, light_ground
from paint3d.view.studio import (
    SOFTBOXES,
    Sun,
    light_samples,
    linear_to_srgb,
    make_panorama,
    srgb_to_linear,
)
from tests.support.view_shapes import ball, sheet

FREE = Ground(np.zeros(3), 1.0, np.ones((1, 1)))


def sun(direction, share=0.0) -> Sun:
    direction = np.asarray(direction, dtype=float)
    return Sun(direction / np.linalg.norm(direction), np.ones(3), share)


def test_a_convex_body_is_lit_by_the_cosine_and_does_not_shade_itself():
    vertices, faces, normals = ball(n=120)
    light = sun((1, 2, 3))
    lit, hidden = Occluder(vertices, faces).shine([light], vertices, normals, 0.5, FREE)
    expected = np.maximum(normals @ light.direction, 0)
    assert np.abs(lit[:, 0] - expected).max() < 1e-5
    assert np.all(hidden == 0)


@pytest.mark.parametrize("direction", [(0, 0, 1), (0.5, 0.2, 1), (-1, 0.5, 1)])
def test_a_sheet_shades_exactly_what_lies_behind_it(direction):
    vertices, faces, _ = sheet(40.0, 40.0)
    light = sun(direction, share=0.25)
    ticks = np.linspace(-30, 70, 201)
    x, y = np.meshgrid(ticks, ticks)
    points = np.stack([x, y, np.full_like(x, -10)], axis=-1).reshape(-1, 3).astype(np.float32)
    normals = np.tile(np.float32([0, 0, 1]), (len(points), 1))
    occluder = Occluder(vertices, faces)
    lit, hidden = occluder.shine([light], points, normals, 0.0, FREE)
    crossing = points[:, :2] + 10 * light.direction[:2] / light.direction[2]
    margin = np.minimum(crossing, 40 - crossing).min(axis=1)  # mm inside the sheet's edge
    far = np.abs(margin) > 1.5 * occluder.cell
    assert np.array_equal(lit[far, 0] == 0, margin[far] > 0)
    assert np.allclose(lit[:, 0] + hidden, light.direction[2], atol=1e-6)


def test_the_object_is_looked_at_once_from_each_light(monkeypatch: pytest.MonkeyPatch) -> None:
    """The floor and the object ask for the same depth maps, each of 400,000 samples."""
    filled: list[bytes] = []
    fill = daylight.fill_depth_map
    monkeypatch.setattr(
        daylight, "fill_depth_map", lambda p, to: filled.append(to.axes.tobytes()) or fill(p, to)
    )
    vertices, faces, normals = ball(n=40)
    occluder, suns = Occluder(vertices, faces), light_samples(48)[::6]
    ground = light_ground(occluder, suns)
    light = daylight.light_points(occluder, ground, suns, vertices, normals, 0.8)
    assert len(filled) == len(set(filled)) == len(suns) > 30
    again = daylight.light_points(Occluder(vertices, faces), ground, suns, vertices, normals, 0.8)
    assert np.array_equal(light, again)


def test_the_floor_is_dark_under_the_object_and_free_far_away():
    vertices, faces, _ = ball(n=120)
    ground = light_ground(Occluder(vertices, faces), light_samples())
    middle = len(ground.openness) // 2
    assert ground.openness.min() >= 0
    assert ground.openness.max() <= 1 + 1e-9
    assert ground.openness[middle, middle] < 0.15
    assert ground.openness[[0, 0, -1, -1], [0, -1, 0, -1]].min() > 0.95


def test_samples_of_the_studio_cover_the_sphere_evenly():
    suns = light_samples()
    directions = np.array([sun.direction for sun in suns])
    shares = np.array([sun.share for sun in suns])
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert shares.sum() == pytest.approx(1)
    assert np.abs(shares @ directions).max() < 0.01
    cosines = np.maximum(directions @ [0.36, -0.48, 0.8], 0)
    assert shares @ cosines == pytest.approx(0.25, rel=0.02)


def test_the_panorama_shows_each_softbox_where_it_stands():
    panorama = make_panorama(128)
    for box in SOFTBOXES:
        x, y, z = box.axes()[2]
        row = int((np.arcsin(z) / np.pi + 0.5) * 128)
        column = int((np.arctan2(-y, x) / (2 * np.pi) + 0.5) * 256)
        assert np.all(panorama[row, column] >= np.asarray(box.radiance)) == box.mirrored


def test_every_srgb_code_survives_the_way_to_linear_light_and_back():
    codes = np.arange(256, dtype=np.uint8)
    linear = srgb_to_linear(codes)
    assert linear[[0, 255]].tolist() == [0, 1]
    assert linear[188] == pytest.approx(0.5029, abs=1e-4)
    assert np.array_equal(np.rint(255 * linear_to_srgb(linear)), codes)

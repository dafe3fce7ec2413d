"""The side that is looked at, and whether the object fits the frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from paint3d.errors import InputError
from paint3d.view.camera import (
    VIEW_ANGLE,
    View,
    find_view,
    fit_camera,
    is_flat,
    studio_axes,
    vertex_areas,
)
from tests.support.view_shapes import BARE, INK, ball, sheet

ANGLES = st.floats(-np.pi, np.pi)


def paint_towards(normals: np.ndarray, direction: np.ndarray, reach: float) -> np.ndarray:
    srgb = np.tile(BARE, (len(normals), 1))
    srgb[normals @ direction > reach] = INK
    return srgb


def from_above(camera, vertices: np.ndarray) -> np.ndarray:
    """Return where vertices appear: (V, 2), in half-heights of the frame."""
    back = camera.position - camera.focus
    back /= np.linalg.norm(back)
    right = np.cross(camera.up, back)
    seen = vertices - camera.position
    depth = -(seen @ back) * np.tan(camera.view_angle / 2)
    return np.stack([seen @ right / depth, seen @ camera.up / depth], axis=1)


def test_vertex_areas_sum_to_the_area_of_the_mesh():
    vertices, faces, _ = sheet(30.0, 20.0)
    assert vertex_areas(vertices, faces).sum() == pytest.approx(30.0 * 20.0)


@settings(max_examples=25, deadline=None)
@given(turn=ANGLES, height=st.floats(-0.2, 0.9))
def test_the_painted_side_faces_the_camera(turn, height):
    vertices, faces, normals = ball()
    level = np.sqrt(1 - height**2)
    side = np.array([level * np.cos(turn), level * np.sin(turn), height])
    srgb = paint_towards(normals, side, 0.9)
    view = find_view(vertices, normals, srgb, vertex_areas(vertices, faces))
    assert view.direction @ side > np.cos(np.radians(45))
    assert view.direction[2] > 0


def test_the_larger_colour_is_the_bare_one_whatever_it_is():
    vertices, faces, normals = ball()
    srgb = paint_towards(normals, np.array([1.0, 0, 0]), 0.8)
    swapped = np.where(srgb == INK, BARE, INK).astype(np.uint8)
    areas = vertex_areas(vertices, faces)
    views = [find_view(vertices, normals, colours, areas) for colours in (srgb, swapped)]
    assert np.allclose(views[0].direction, views[1].direction)
    assert views[0].direction[0] > 0.8


def test_a_bare_object_is_seen_from_the_front():
    vertices, faces, normals = ball()
    srgb = np.tile(BARE, (len(vertices), 1))
    direction = find_view(vertices, normals, srgb, vertex_areas(vertices, faces)).direction
    assert direction[0] == pytest.approx(0, abs=1e-9)
    assert direction[1] < -0.5 < 0 < direction[2]


@pytest.mark.parametrize("height", [-0.4, 0.0, 0.15])
def test_paint_all_around_is_seen_from_the_side(height):
    vertices, faces, normals = ball()
    srgb = np.where(np.abs(normals[:, 2:] - height) < 0.1, INK, BARE).astype(np.uint8)
    direction = find_view(vertices, normals, srgb, vertex_areas(vertices, faces)).direction
    assert direction[1] < -0.9
    assert 0.0 < direction[2] < np.sin(np.radians(20.0))


def test_of_paint_all_around_the_side_that_shows_most_is_seen():
    vertices, faces, normals = ball()
    band = np.abs(normals[:, 2]) < 0.15
    thicker = (np.abs(normals[:, 2]) < 0.3) & (normals[:, 0] > 0.85)
    srgb = np.where((band | thicker)[:, None], INK, BARE).astype(np.uint8)
    direction = find_view(vertices, normals, srgb, vertex_areas(vertices, faces)).direction
    assert direction[0] > 0.7
    assert direction[2] < np.sin(np.radians(20.0))


def test_paint_all_around_within_a_hollow_is_seen_from_above():
    vertices, faces, normals = ball()
    srgb = np.where(np.abs(normals[:, 2:] + 0.1) < 0.15, INK, BARE).astype(np.uint8)
    direction = find_view(vertices, -normals, srgb, vertex_areas(vertices, faces)).direction
    assert direction[2] > np.sin(np.radians(45.0))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_sheet_is_looked_at_squarely_from_its_painted_side(axis):
    vertices, faces, normals = sheet(30.0, 20.0)
    vertices, normals = np.roll(vertices, axis, axis=1), -np.roll(normals, axis, axis=1)
    srgb = np.tile(BARE, (len(vertices), 1))
    srgb[: len(srgb) // 8] = INK
    view = find_view(vertices, normals, srgb, vertex_areas(vertices, faces))
    assert is_flat(vertices)
    assert np.allclose(view.direction, normals[0], atol=1e-6)
    assert np.allclose(studio_axes(vertices, view)[2], normals[0], atol=1e-6)


@settings(max_examples=25, deadline=None)
@given(turn=ANGLES, height=st.floats(-0.9, 0.9), aspect=st.floats(0.4, 2.5))
def test_the_object_fits_and_fills_the_frame(turn, height, aspect):
    vertices = ball()[0] * np.float32([1.0, 2.0, 0.6]) + np.float32([300, -20, 7])
    level = np.sqrt(1 - height**2)
    view = View((level * np.cos(turn), level * np.sin(turn), height))
    camera = fit_camera(vertices, view, aspect)
    reach = np.abs(from_above(camera, vertices)).max(axis=0) / (aspect, 1)
    assert camera.view_angle == pytest.approx(VIEW_ANGLE)
    assert 0.7 < reach.max() < 0.9


def test_zoom_magnifies():
    vertices = ball()[0]
    near = fit_camera(vertices, View((0, -1, 0.2), zoom=2.0), 1.0)
    far = fit_camera(vertices, View((0, -1, 0.2)), 1.0)
    ratio = np.abs(from_above(near, vertices)).max() / np.abs(from_above(far, vertices)).max()
    assert ratio == pytest.approx(2.0, rel=0.01)


@settings(max_examples=25, deadline=None)
@given(turn=ANGLES, height=st.floats(-1, 1))
def test_studio_axes_are_a_rotation(turn, height):
    level = np.sqrt(1 - height**2)
    away, up = np.array([level * np.cos(turn), level * np.sin(turn), height]), (0.1, 0.2, 1.0)
    assume(np.linalg.norm(np.cross(away, up)) > 1e-6)  # looked at along up, there is no way round
    view = View(tuple(away), up=up)
    axes = studio_axes(ball()[0], view)
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(axes) == pytest.approx(1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"direction": (0, 0, 0)}, "length 0"),
        ({"direction": (0, 0, 2)}, "parallel"),
        ({"direction": (1, np.nan, 0)}, "finite"),
        ({"direction": (1, 0)}, "shape"),
        ({"direction": (1, 0, 0), "zoom": 0.0}, "zoom"),
    ],
)
def test_a_view_that_cannot_be_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        View(**arguments)

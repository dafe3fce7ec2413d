"""Moving the camera: what is under the hand stays there."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.input.navigation import (
    approach,
    dolly,
    frame,
    orbit,
    pan,
    picture_axes,
    ray_at,
    roll,
    roll_at,
    roll_of,
    turn_to_see,
    zoom_at,
)
from paint3d.errors import InputError
from paint3d.view.camera import Camera

SIZE = (800.0, 600.0)
DRAGS = st.floats(-300, 300)


def camera(position=(0.0, -300.0, 120.0), focus=(5.0, 0.0, 10.0), up=(0.0, 0.0, 1.0)):
    return Camera(np.array(position), np.array(focus), np.array(up), math.radians(30.0))


def pixel(view, point):
    """Where a point appears, pixels from the upper left corner."""
    right, up, back = picture_axes(view)
    off = np.asarray(point) - view.position
    scale = 0.5 * SIZE[1] / math.tan(0.5 * view.view_angle) / -(off @ back)
    return np.array([0.5 * SIZE[0] + scale * (off @ right), 0.5 * SIZE[1] - scale * (off @ up)])


def distance(view):
    return np.linalg.norm(view.position - view.focus)


@settings(deadline=None, max_examples=40)
@given(DRAGS, DRAGS, st.booleans())
def test_orbit_keeps_distance_focus_and_upright(dx, dy, z_up):
    view = orbit(camera(), dx, dy, SIZE[1], z_up)
    assert distance(view) == pytest.approx(distance(camera()))
    np.testing.assert_array_equal(view.focus, camera().focus)
    right, up, _ = picture_axes(view)
    assert up @ view.up > 0.999
    if z_up:
        assert abs(right[2]) < 1e-9
        assert up[2] > 0.0


@given(st.floats(-3.0, 3.0), DRAGS, DRAGS)
def test_a_rolled_picture_stays_rolled_while_it_is_turned(angle, dx, dy):
    rolled = roll(camera(), angle)
    assert roll_of(rolled) == pytest.approx(angle, abs=1e-7)
    view = orbit(rolled, dx, dy, SIZE[1])
    assert roll_of(view) == pytest.approx(angle, abs=1e-6)
    assert distance(view) == pytest.approx(distance(rolled))


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.0])
@pytest.mark.parametrize("way", [(6.0, 0.0), (0.0, 6.0), (-4.0, 3.0)])
def test_what_is_near_follows_the_hand_however_the_picture_is_rolled(angle, way):
    rolled = roll(camera(focus=(0.0, 0.0, 0.0), position=(0.0, -300.0, 60.0)), angle)
    point = picture_axes(rolled)[2] * 40.0  # in the middle, toward the viewer
    before = np.array(pixel(rolled, point))
    moved = np.array(pixel(orbit(rolled, *way, SIZE[1]), point)) - before
    assert moved @ way > 0.97 * np.linalg.norm(moved) * np.linalg.norm(way)


@given(st.floats(-3.0, 3.0), st.floats(0, 800), st.floats(0, 600))
def test_rolling_leaves_what_is_under_the_pointer(angle, x, y):
    before = camera()
    ray = ray_at(before, x, y, SIZE)
    right, _, back = picture_axes(before)
    far = -distance(before) / (ray.direction @ back)
    point = before.position + far * ray.direction
    view = roll_at(before, angle, x, y, SIZE)
    np.testing.assert_allclose(pixel(view, point), [x, y], atol=1e-6)
    step = np.array(pixel(view, point + 0.1 * right)) - [x, y]
    assert math.atan2(-step[1], step[0]) == pytest.approx(angle, abs=1e-3)


def test_orbit_turns_what_is_near_with_the_hand():
    near = np.array([5.0, -20.0, 10.0])  # in front of the focus
    for z_up in (True, False):
        before = pixel(camera(), near)
        assert pixel(orbit(camera(), 10, 0, SIZE[1], z_up), near)[0] > before[0]
        assert pixel(orbit(camera(), 0, 10, SIZE[1], z_up), near)[1] > before[1]
    back = orbit(orbit(camera(), 40, 10, SIZE[1]), -40, -10, SIZE[1])
    np.testing.assert_allclose(back.position, camera().position, atol=1e-9)


@settings(deadline=None, max_examples=25)
@given(DRAGS, DRAGS)
def test_pan_takes_the_focus_along(dx, dy):
    view = pan(camera(), dx, dy, SIZE[1])
    moved = pixel(view, camera().focus) - pixel(camera(), camera().focus)
    np.testing.assert_allclose(moved, [dx, dy], atol=1e-6)
    np.testing.assert_allclose(view.position - view.focus, camera().position - camera().focus)


@settings(deadline=None, max_examples=25)
@given(st.floats(0.2, 5.0), st.floats(0, 800), st.floats(0, 600))
def test_zooming_leaves_what_is_under_the_pointer(factor, x, y):
    before = camera()
    ray = ray_at(before, x, y, SIZE)
    _, _, back = picture_axes(before)
    depth = distance(before) / -(ray.direction @ back)
    point = ray.origin + depth * ray.direction
    np.testing.assert_allclose(pixel(before, point), [x, y], atol=1e-6)
    view = zoom_at(before, factor, x, y, SIZE)
    assert distance(view) == pytest.approx(distance(before) / factor)
    np.testing.assert_allclose(pixel(view, point), [x, y], atol=1e-6)


@pytest.mark.parametrize("aspect", [0.5, 4 / 3])
def test_framing_shows_the_whole_ball_and_fills_the_picture(aspect):
    view = frame(camera(), (50, 20, 0), 40.0, aspect)
    np.testing.assert_array_equal(view.focus, [50, 20, 0])
    apparent = math.asin(40.0 / distance(view))
    half = 0.5 * view.view_angle
    half = min(half, math.atan(aspect * math.tan(half)))
    assert 0.8 * half < apparent < half


def test_coming_near_never_goes_away():
    far = camera()
    near = approach(far, (50, 20, 0), 10.0)
    np.testing.assert_array_equal(near.position, frame(far, (50, 20, 0), 10.0).position)
    again = approach(near, (0, 0, 0), 40.0)
    np.testing.assert_array_equal(again.focus, [0, 0, 0])
    assert distance(again) == pytest.approx(distance(near))


def test_a_picture_is_rolled_by_the_angle_and_come_near_by_a_factor():
    turned = roll(camera(), 0.3)
    assert picture_axes(turned)[1] @ picture_axes(camera())[1] == pytest.approx(math.cos(0.3))
    with pytest.raises(InputError, match="expected"):
        dolly(camera(), 0.0)
    assert distance(dolly(camera(), 1e6)) > 0.0


@pytest.mark.parametrize("degrees", [0.0, 90.0, 200.0])
def test_the_view_turns_to_what_is_on_the_far_side_and_only_there(degrees):
    angles = np.radians(degrees + np.array([-20.0, 0.0, 20.0]))  # around a body; -90 is in front
    normals = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    before = camera(focus=(0.0, 0.0, 10.0))
    seen = turn_to_see(before, 40.0 * normals, normals)
    assert distance(seen) == pytest.approx(distance(before))
    assert seen.position[2] == pytest.approx(before.position[2])
    assert roll_of(seen) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(pixel(seen, 40.0 * normals[1])[0], 0.5 * SIZE[0], atol=1e-6)
    assert turn_to_see(seen, 40.0 * normals, normals) is seen
    assert turn_to_see(before, [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]]) is before
    all_around = np.concatenate([normals, -normals])
    assert turn_to_see(before, 40.0 * all_around, all_around) is before

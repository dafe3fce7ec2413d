"""The contact of one pose, by name."""

import dataclasses
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import paint3d
from paint3d.errors import InputError

UPRIGHT = (1.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def painter():
    return paint3d.Painter(paint3d.PaintedSurface(paint3d.load_mesh("plane"), 2.0, "xuan"), "full")


def test_three_newton_on_the_plane_leave_the_footprint_of_the_model(painter):
    contact = painter.contact((3.0, -4.0, 28.0), UPRIGHT, 3.0 / 7.9)
    np.testing.assert_allclose(contact.foot, (3.0, -4.0, 0.0), atol=1e-5)
    np.testing.assert_allclose(contact.normal, (0.0, 0.0, 1.0), atol=1e-6)
    np.testing.assert_allclose(contact.bend, (1.0, 0.0, 0.0), atol=1e-6)
    assert contact.length == pytest.approx(7.92, rel=0.01)
    assert contact.width == pytest.approx(7.21, rel=0.01)
    assert 37.2 < contact.area < 1.06 * 37.2  # the meniscus rounds its tip


def test_the_depth_follows_from_the_height_of_the_root(painter):
    contact = painter.contact((0.0, 0.0, 28.0), UPRIGHT)
    assert contact.descent == pytest.approx(35.0 - 28.0)
    assert contact.pressure == pytest.approx(7.0 / 17.5)
    assert contact.sphere_centre[2] + contact.sphere_radius >= 28.0


def test_a_brush_in_the_air_touches_nothing(painter):
    above = painter.contact((0.0, 0.0, 36.0), UPRIGHT)
    assert above.area == 0.0
    assert painter.contact((0.0, 0.0, 80.0), UPRIGHT) is None


def test_who_presses_touches_from_any_height_but_not_from_beside(painter):
    near = painter.contact((3.0, -4.0, 28.0), UPRIGHT, 0.4)
    far = painter.contact((3.0, -4.0, 500.0), UPRIGHT, 0.4)
    assert (far.length, far.width, far.area) == (near.length, near.width, near.area)
    np.testing.assert_allclose(far.foot, near.foot, atol=1e-9)
    np.testing.assert_allclose(far.origin, near.origin, atol=1e-9)
    edge = painter.surface.source.bounds[1][0]
    assert painter.contact((edge + 60.0, 0.0, 100.0), UPRIGHT, 0.4) is None
    assert painter.contact((0.0, 0.0, 80.0), UPRIGHT, 0.0) is None


def test_on_a_sphere_the_normal_is_the_radius():
    surface = paint3d.PaintedSurface(paint3d.load_mesh("sphere"), 2.0)
    painter = paint3d.Painter(surface, "full")
    axis = np.array([0.36, 0.48, 0.8])
    turn = np.array([1.0 + axis[2], -axis[1], axis[0], 0.0])  # carries z to the axis
    contact = painter.contact(103.0 * axis, turn / np.linalg.norm(turn), 0.3)
    np.testing.assert_allclose(contact.foot, 75.0 * axis, atol=0.05)
    assert contact.normal @ axis > np.cos(np.deg2rad(3.0))


@pytest.mark.parametrize(
    ("position", "orientation", "pressure", "said"),
    [
        ((0, 0, np.nan), UPRIGHT, None, "position"),
        ((0, 0), UPRIGHT, None, "position"),
        ((0, 0, 1), (1, 1, 0, 0), None, "orientation has length"),
        ((0, 0, 1), UPRIGHT, 1.5, "pressure is 1.5"),
    ],
)
def test_a_pose_must_be_one(painter, position, orientation, pressure, said):
    with pytest.raises(InputError, match=said):
        painter.contact(position, orientation, pressure)


def test_a_contact_is_that_of_a_thread_that_has_found_none_before(painter):
    """A thread keeps its scratch from one contact to the next: nothing of the last one stays."""
    ball = paint3d.Painter(paint3d.PaintedSurface(paint3d.load_mesh("sphere"), 2.0), "full")
    rng, touching = np.random.default_rng(4), 0
    for _ in range(60):
        one = (painter, ball)[rng.integers(2)]
        middle = (0.0, 0.0, 35.0 if one is painter else 100.0)
        place, q = middle + rng.uniform(-12.0, 12.0, 3), rng.normal(UPRIGHT, 0.2)
        pose = place, q / np.linalg.norm(q)
        with ThreadPoolExecutor(1) as new:
            anew = new.submit(one.contact, *pose).result()
        found = one.contact(*pose)
        assert (found is None) == (anew is None)
        if found is not None:
            touching += found.area > 0.0
            for field in dataclasses.fields(found):
                was, now = getattr(anew, field.name), getattr(found, field.name)
                np.testing.assert_array_equal(now, was, err_msg=field.name)
    assert 10 < touching < 50

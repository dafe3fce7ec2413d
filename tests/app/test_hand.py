"""From a pointer to a brush on the surface: pressure, steadiness, tilt, sizes, images."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.app.model.brush_in_hand import resized, scaled, stepped
from paint3d.app.model.input.event_clock import EventClock
from paint3d.app.model.input.fingers import Fingers
from paint3d.app.model.input.hand import Hand, HandSettings, PointerInput
from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.app.model.input.symmetry import (
    MirrorPlane,
    RadialSymmetry,
    Symmetry,
    transform_samples,
)
from paint3d.brush.presets import brush_names, load_brush
from paint3d.brush_engine.outline import OUTLINE_CAPACITY, SCRATCH_SIZE, trace_outline
from paint3d.core.quaternion import matrices_from_quaternions, rotate
from paint3d.errors import BrushError, InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.triangle_mesh import TriangleMesh
from tests.support.app.hands import line, paint, sample, small_plane

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui

from paint3d.app.model.document import Document
from paint3d.cli.main import main
from paint3d.view.camera import picture_axes
from tests.support.app.gestures import BUTTON, KIND, live, mouse
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, settled

BRUSH = load_brush("full")
MS = 1_000_000


@pytest.fixture(scope="module")
def plane():
    return ClosestPoints(load_mesh("plane"))


@pytest.fixture(scope="module")
def sphere():
    return ClosestPoints(load_mesh("sphere"))


def over(k, x, y, **rest):
    """A pointer that looks straight down on the plane, 10 ms after the one before."""
    return PointerInput(10 * MS * k, origin=(x, y, 90), direction=(0, 0, -1), **rest)


def draw(hand, points, **rest):
    samples = list(hand.begin(over(1, *points[0], **rest), BRUSH))
    for k, point in enumerate(points[1:], 2):
        samples += hand.move(over(k, *point, **rest), BRUSH)
    return samples + hand.end(10 * MS * (len(points) + 1), BRUSH)


def places(samples):
    return np.array([s.contact for s in samples])


def test_a_click_of_a_mouse_is_a_dot_and_that_of_a_pen_what_it_pressed(plane):
    for pressure, most in ((None, 0.1), (0.0, 0.0)):
        hand = Hand(plane, HandSettings(mouse_smoothing=0.3))
        samples = list(hand.begin(over(1, 3.0, 4.0, pressure=pressure), BRUSH))
        samples += hand.end(90 * MS, BRUSH, over(9, 3.0, 4.0, pressure=pressure))
        assert max(sample.pressure for sample in samples) >= most
        assert (max(sample.pressure for sample in samples) > 0.0) == (most > 0.0)
        assert samples[-1].pressure == 0.0
        np.testing.assert_allclose(places(samples)[:, :2], [[3.0, 4.0]] * len(samples), atol=1e-6)


def test_a_tap_that_takes_no_time_is_a_dot_as_large(plane):
    pressures = []
    for end in (11, 200):
        hand = Hand(plane, HandSettings(mouse_smoothing=0.3))
        samples = list(hand.begin(over(1, 3.0, 4.0), BRUSH))
        samples += hand.end(end * MS, BRUSH, replace(over(1, 3.0, 4.0), time_ns=end * MS))
        assert (np.diff([sample.time_ns for sample in samples]) > 0).all()
        pressures.append(max(sample.pressure for sample in samples))
    assert pressures[0] == pressures[1] > 0.1


def test_the_brush_stands_on_the_normal_where_the_ray_meets_the_object(sphere):
    hand = Hand(sphere)
    event = PointerInput(MS, origin=(100, 20, 10), direction=(-1, 0, 0))
    shown = hand.hover(event, BRUSH)
    up = rotate(shown.orientation, np.array([0.0, 0.0, 1.0]))
    foot = shown.position - 1.25 * BRUSH.length_mm * up
    np.testing.assert_allclose(foot[1:], [20, 10], atol=0.1)
    np.testing.assert_allclose(shown.contact, foot, atol=1e-6)
    assert up @ foot == pytest.approx(np.linalg.norm(foot), rel=1e-3)
    beside = PointerInput(2 * MS, origin=(100, 20, 500), direction=(-1, 0, 0))
    assert hand.hover(beside, BRUSH) is None
    assert hand.begin(beside, BRUSH) is None


def test_a_stroke_comes_down_and_is_lifted(plane):
    hand = Hand(plane)
    samples = draw(hand, [(0, 0), (5, 0), (10, 0)], pressure=0.4)
    assert [s.pressure for s in samples] == pytest.approx([0.0, 0.4, 0.4, 0.4, 0.0])
    np.testing.assert_allclose(places(samples)[:, 0], [0, 0, 5, 10, 10], atol=1e-5)
    times = [s.time_ns for s in samples]
    assert times == sorted(set(times))
    document = small_plane()
    document.begin_stroke()
    document.feed(samples)
    document.end_stroke()
    assert document.surface.painted.any()


TILTS = [(0.0, 0.0)] + [
    (t * np.cos(a), t * np.sin(a)) for t in (30.0, 60.0) for a in np.arange(8) * np.pi / 4
]


@pytest.mark.parametrize("tilt", TILTS, ids=lambda t: f"{t[0]:.0f},{t[1]:.0f}")
def test_the_middle_of_the_footprint_lies_under_the_pointer(plane, tilt):
    views = {"right": (1, 0, 0), "up": (0, 1, 0), "x_tilt": tilt[0], "y_tilt": tilt[1]}
    samples = draw(Hand(plane), [(2 * k, k) for k in range(12)], pressure=0.3, **views)
    painter = small_plane().painter
    assert len(samples) == 1 + 12 + 1  # it is put down and lifted
    for k, one in enumerate(samples[2:13], 1):
        contact = painter.contact(one.position, one.orientation, one.pressure, one.contact)
        np.testing.assert_allclose(one.contact, [2.0 * k, k, 0.0], atol=1e-4)
        middle = contact.origin + contact.bend * _middle(contact, painter.tuft)
        np.testing.assert_allclose(middle, one.contact, atol=1e-4)
        np.testing.assert_allclose(contact.bend[:2], [-(0.8**0.5), -(0.2**0.5)], atol=0.01)


@pytest.mark.parametrize(("sign", "most"), [(-1.0, 20.0), (1.0, 55.0)], ids=["roof", "valley"])
def test_over_a_sharp_edge_the_handle_turns_by_and_by(sign, most):
    """It would lie flat on one face while it still stands on the other, and smear a blot there."""
    slope = sign * np.tan(np.radians(35.0))
    x = np.array([-20.0, 0.0, 20.0])
    corners = [(a, b, slope * abs(a)) for b in (-20.0, 20.0) for a in x]
    faces = [(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4)]
    edge = ClosestPoints(TriangleMesh(np.array(corners), np.array(faces)))
    samples = draw(Hand(edge), [(0.5 * k - 7.75, 0.0) for k in range(32)], pressure=0.25)
    up = np.array([rotate(s.orientation, np.array([0.0, 0.0, 1.0])) for s in samples])
    turned = np.degrees(np.arccos(np.clip((up[1:] * up[:-1]).sum(axis=1), -1.0, 1.0)))
    assert turned.max() < most  # of 70 degrees altogether
    sine = sign * np.sin(np.radians(35.0))
    np.testing.assert_allclose(up[[0, -1], 0], [sine, -sine], atol=1e-6)
    assert (np.abs(up[:, 1]) < 1e-9).all()


@pytest.mark.parametrize("degrees", [90.0, 100.0])
def test_over_a_right_angle_the_handle_turns_by_and_by_and_the_tuft_stays_behind(degrees):
    """Laid into the other face at once, the tip came to lie under the brush, and along the edge."""
    slope = -np.tan(np.radians(0.5 * degrees))
    x = np.array([-20.0, 0.0, 20.0])
    corners = [(a, b, slope * abs(a)) for b in (-20.0, 20.0) for a in x]
    faces = [(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4)]
    edge = ClosestPoints(TriangleMesh(np.array(corners), np.array(faces)))
    places = [(0.5 * k - 7.75, 0.15 * k - 2.4) for k in range(32)]
    samples = draw(Hand(edge), places, pressure=0.25)
    up = np.array([rotate(s.orientation, np.array([0.0, 0.0, 1.0])) for s in samples])
    turned = np.degrees(np.arccos(np.clip((up[1:] * up[:-1]).sum(axis=1), -1.0, 1.0)))
    assert turned.max() < 0.55 * degrees
    down = [s for s in samples if s.pressure > 0.0]
    way = np.diff([s.contact for s in down], axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    bend = np.array([rotate(s.orientation, np.array([1.0, 0.0, 0.0])) for s in down])
    assert (bend[1:] * way).sum(axis=1).max() < -0.6


@pytest.mark.parametrize("phase", [0.0, 0.5, 1.0, 1.5])
def test_a_fast_hand_turns_the_handle_over_an_edge_by_and_by_too(phase):
    """From one event to the next it turned by half, and between them lay down on the surface."""
    x = np.array([-20.0, 0.0, 20.0])
    corners = [(a, b, -abs(a)) for b in (-20.0, 20.0) for a in x]
    faces = [(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4)]
    edge = ClosestPoints(TriangleMesh(np.array(corners), np.array(faces)))
    samples = draw(Hand(edge), [(2.0 * k - 8.0 + phase, 0.0) for k in range(9)], pressure=0.25)
    up = np.array([rotate(s.orientation, np.array([0.0, 0.0, 1.0])) for s in samples])
    turned = np.degrees(np.arccos(np.clip((up[1:] * up[:-1]).sum(axis=1), -1.0, 1.0)))
    assert turned.max() < 30.0  # of 90 degrees altogether; it was 39 to 45
    assert (np.diff([s.time_ns for s in samples]) > 0).all()
    down = places([s for s in samples if s.pressure > 0.0])
    np.testing.assert_allclose(down[:, 2], -np.abs(down[:, 0]), atol=1e-9)
    assert {s.pressure for s in samples[:-1]} == {0.0, 0.25}


@pytest.mark.parametrize("x_tilt", [-60.0, 0.0, 60.0])
def test_a_brush_that_is_pulled_over_a_ridge_does_not_lie_down_on_the_other_side(x_tilt):
    x, slope = np.array([-20.0, 0.0, 20.0]), np.tan(np.radians(60.0))
    corners = [(a, b, -slope * abs(a)) for b in (-20.0, 20.0) for a in x]
    faces = [(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4)]
    ridge = ClosestPoints(TriangleMesh(np.array(corners), np.array(faces)))
    hand = Hand(ridge, HandSettings(smoothing=1.0))
    leaning = {"right": (1, 0, 0), "up": (0, 1, 0), "x_tilt": x_tilt, "pressure": 0.3}
    samples = draw(hand, [(0.7 * k - 7.0, 0.0) for k in range(21)], **leaning)
    assert len(samples) > 30  # the string is run in when the pen is lifted
    up = np.array([rotate(s.orientation, np.array([0.0, 0.0, 1.0])) for s in samples])
    normals = ridge.find(places(samples)).normals
    assert np.einsum("ij,ij->i", up, normals).min() > 0.2


def _middle(contact, tuft):
    """From where the outline is counted to its middle, mm."""
    reach, half = np.empty(OUTLINE_CAPACITY), np.empty(OUTLINE_CAPACITY)
    pressed = contact.descent, contact.tilt, contact.pressure
    n = trace_outline(tuft, *pressed, np.empty(SCRATCH_SIZE), reach, half)
    return 0.5 * (reach[0] + reach[n - 1])


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (40.0, 0.0), (-40.0, 0.0), (20.0, 35.0)])
@pytest.mark.parametrize("pressure", [0.05, 0.6])
def test_the_root_is_where_the_model_would_have_it(plane, tilt, pressure):
    """A program that paints by the root paints in the same place, as the papers' model has it."""
    views = {"right": (1, 0, 0), "up": (0, 1, 0), "x_tilt": tilt[0], "y_tilt": tilt[1]}
    painter = small_plane().painter
    for one in draw(Hand(plane), [(2 * k, 0) for k in range(6)], pressure=pressure, **views)[1:6]:
        by_place = painter.contact(one.position, one.orientation, one.pressure, one.contact)
        by_root = painter.contact(one.position, one.orientation, one.pressure)
        np.testing.assert_allclose(by_root.origin, by_place.origin, atol=1.5)


@pytest.mark.parametrize("tilt", TILTS[1:], ids=lambda t: f"{t[0]:.0f},{t[1]:.0f}")
def test_a_leaning_pen_bends_its_tuft_along_the_way(plane, tilt):
    views = {"right": (1, 0, 0), "up": (0, 1, 0), "x_tilt": tilt[0], "y_tilt": tilt[1]}
    samples = draw(Hand(plane), [(k, 2 * k) for k in range(12)], pressure=0.3, **views)
    x = matrices_from_quaternions(np.array([s.orientation for s in samples]))[:, :2, 0]
    way = -np.array([0.2**0.5, 0.8**0.5])
    np.testing.assert_allclose(x / np.linalg.norm(x, axis=1)[:, None], [way] * len(x), atol=1e-6)


@given(st.floats(0, 2 * np.pi), st.floats(0, 2 * np.pi))
@settings(deadline=None, max_examples=25)
def test_a_stroke_comes_down_trailing_its_own_way(plane_once, before, after):
    """However the one before it went; not one sample is bent otherwise."""
    hand = Hand(plane_once)
    for angle, at in ((before, -30.0), (after, 30.0)):
        way = np.array([np.cos(angle), np.sin(angle)])
        samples = draw(hand, [(at, 0) + 0.4 * k * way for k in range(20)], pressure=0.4)
        bends = rotate(np.array([s.orientation for s in samples]), np.array([1.0, 0.0, 0.0]))
        np.testing.assert_allclose(bends[:, :2], [-way] * len(bends), atol=1e-3)


def test_a_dab_has_its_tip_up_left_as_seen_or_away_from_the_lean(plane):
    views = {"right": (0, 1, 0), "up": (-1, 0, 0), "pressure": 0.4}
    for tilt, wanted in (((0, 0), (-(0.5**0.5), -(0.5**0.5))), ((30, 0), (0.0, -1.0))):
        samples = draw(Hand(plane), [(5, 5)] * 30, x_tilt=tilt[0], y_tilt=tilt[1], **views)
        assert len(samples) == 1 + 30 + 1
        bends = rotate(np.array([s.orientation for s in samples]), np.array([1.0, 0.0, 0.0]))
        bends = bends[:, :2] / np.linalg.norm(bends[:, :2], axis=1)[:, None]
        np.testing.assert_allclose(bends, [wanted] * len(bends), atol=1e-6)


def test_a_pen_is_lifted_where_it_says(plane):
    hand = Hand(plane)
    samples = list(hand.begin(over(1, 0, 0, pressure=0.3), BRUSH))
    samples += hand.move(over(2, 4, 0, pressure=0.3), BRUSH)
    samples += hand.end(30 * MS, BRUSH, over(3, 6, 0, pressure=0.0))
    np.testing.assert_allclose(places(samples)[:, 0], [0, 0, 4, 6], atol=1e-5)
    assert [s.pressure for s in samples] == [0.0, 0.3, 0.3, 0.0]
    hand.begin(over(4, 0, 0, pressure=0.3), BRUSH)
    hand.move(over(5, 4, 0, pressure=0.3), BRUSH)
    (far,) = hand.end(60 * MS, BRUSH, over(6, 60, 0, pressure=0.0))
    np.testing.assert_allclose(far.contact, [4, 0, 0], atol=1e-5)


def across(bowl, *targets):
    """Samples of a stroke over places of the bowl, as the front of the picture shows them."""
    eye = np.array([0.0, -400.0, 300.0])
    events = [
        PointerInput(10 * MS * (k + 1), origin=eye, direction=np.subtract(place, eye))
        for k, place in enumerate(targets)
    ]
    hand = Hand(bowl, HandSettings(landing_s=0.0))
    samples = list(hand.begin(events[0], BRUSH))
    for event in events[1:]:
        samples += hand.move(event, BRUSH)
    return samples + hand.end(events[-1].time_ns, BRUSH)


def test_the_brush_is_lifted_over_what_hides_the_rest():
    bowl = ClosestPoints(load_mesh("bowl"))
    low, high = bowl.mesh.bounds
    inside = [(x, 0.6 * high[1], 0.7 * high[2]) for x in (0.0, 4.0)]
    outside = [(x, low[1], 0.6 * high[2]) for x in (8.0, 12.0)]
    away = [(16.0, 5.0 * low[1], -500.0)]  # beside the object
    samples = across(bowl, *inside, *outside, *away, *outside)
    pressed = [s.pressure > 0.0 for s in samples]
    there = [False, True, True, False]  # put down, moved on, lifted
    assert pressed == 3 * there
    assert (np.diff([s.time_ns for s in samples]) > 0).all()
    y = places(samples)[:, 1]
    assert (y[:4] > 0.0).all()
    assert (y[4:] < 0.8 * low[1]).all()


@pytest.mark.parametrize("x", [-62.0, -56.0, -48.0, -30.0, 0.0, 52.0, 60.0])
def test_the_brush_is_lifted_where_a_rim_hides_the_wall_behind_it(x):
    bowl = ClosestPoints(load_mesh("bowl"))
    (low, high), eye = bowl.mesh.bounds, np.array([0.0, -400.0, 300.0])
    ways = np.linspace([x, 0.0, 0.9 * high[2]], [x, low[1], 0.3 * high[2]], 60) - eye
    hits = bowl.cast(np.tile(eye, (60, 1)), ways)
    seen = hits.points[hits.hit]
    leaps = np.linalg.norm(np.diff(seen, axis=0), axis=1) > 12.0
    assert leaps.sum() == 1  # from the wall inside to the rim before it
    samples = across(bowl, *seen)
    down = np.array([s.pressure > 0.0 for s in samples])
    assert np.count_nonzero(down[:-1] & ~down[1:]) == 2
    gaps = np.linalg.norm(np.diff(np.array([s.contact for s in samples]), axis=0), axis=1)
    assert gaps[down[:-1] & down[1:]].max() < 12.0


def test_the_brush_stays_down_over_a_round_body(sphere):
    eye, turn = np.array([0.0, -400.0, 0.0]), np.radians(np.arange(-60, 61, 30))
    ring = 50.0 * np.column_stack([np.sin(turn), -np.cos(turn), np.zeros(5)])
    hand = Hand(sphere, HandSettings(landing_s=0.0))
    events = [
        PointerInput(10 * MS * (k + 1), origin=eye, direction=p - eye) for k, p in enumerate(ring)
    ]
    samples = list(hand.begin(events[0], BRUSH))
    for event in events[1:]:
        samples += hand.move(event, BRUSH)
    assert [s.pressure > 0.0 for s in samples] == [False] + [True] * (len(samples) - 1)
    assert len(samples) >= 6


def test_the_tuft_trails_behind(plane):
    samples = draw(Hand(plane), [(x, 0) for x in range(0, 40, 2)], pressure=0.4)
    bends = rotate(np.array([s.orientation for s in samples]), np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(bends[5:], np.tile([-1.0, 0.0, 0.0], (len(bends) - 5, 1)), atol=1e-6)


def test_the_pen_leans_as_in_the_picture(plane):
    views = {"right": (1, 0, 0), "up": (0, 1, 0), "pressure": 0.4}
    for tilt, wanted in (((30, 0), (0.5, 0.0)), ((0, 30), (0.0, -0.5)), ((0, 0), (0.0, 0.0))):
        shown = Hand(plane).hover(over(1, 0, 0, x_tilt=tilt[0], y_tilt=tilt[1], **views), BRUSH)
        up = rotate(shown.orientation, np.array([0.0, 0.0, 1.0]))
        np.testing.assert_allclose(up[:2], wanted, atol=1e-6)


def test_twist_turns_the_bend_clockwise(plane):
    _, shown = Hand(plane).begin(over(1, 0, 0, rotation=90.0, pressure=0.4), BRUSH)
    bend = rotate(shown.orientation, np.array([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(bend, [0.0, -1.0, 0.0], atol=1e-6)


def test_a_mouse_gets_its_pressure_from_keys_by_the_time_they_are_held(plane):
    for steps in (10, 100):
        hand = Hand(plane, force=1.0)
        hand.begin(over(0, 0, 0), BRUSH)
        for k in range(1, steps + 1):
            event = PointerInput(
                k * 1000 * MS // steps, origin=(9 * k / steps, 0, 9), direction=(0, 0, -1),
                harder=True,
            )  # fmt: skip
            samples = hand.move(event, BRUSH)
        assert hand.force == pytest.approx(4.0)
        assert samples[-1].pressure == pytest.approx(4.0 / 7.9)
    hand.hover(over(101, 0, 0, wheel=-100.0), BRUSH)
    assert hand.force == 0.0


def test_a_mouse_comes_down_softly(plane):
    hand = Hand(plane, force=3.95)
    samples = draw(hand, [(k, 0) for k in range(12)])
    pressures = [s.pressure for s in samples[:-1]]
    assert pressures[:4] == pytest.approx([0.0, 11.0 / 72, 20.0 / 72, 27.0 / 72])
    assert pressures[7:] == pytest.approx([0.5] * 5)


def test_by_speed_a_hasty_mouse_presses_less(plane):
    pressures = []
    for step in (0.2, 4.0):
        hand = Hand(plane, HandSettings(pressure_by="speed"))
        samples = draw(hand, [(step * k, 0) for k in range(15)])
        pressures.append(samples[-2].pressure)
    assert pressures[1] < 0.5 * pressures[0]


STRENGTHS = st.floats(0.0, 1.0)
WAYS = st.lists(st.tuples(st.floats(-40, 40), st.floats(-40, 40)), min_size=2, max_size=20)


@settings(deadline=None, max_examples=25)
@given(STRENGTHS, WAYS)
def test_a_steadied_stroke_starts_and_ends_where_the_pointer_did(plane_once, strength, way):
    hand = Hand(plane_once, HandSettings(smoothing=strength))
    samples = draw(hand, way, pressure=0.5)
    at = places(samples)[:, :2]
    np.testing.assert_allclose(at[0], way[0], atol=1e-3)
    np.testing.assert_allclose(at[-1], way[-1], atol=1e-3)
    assert (np.diff([s.time_ns for s in samples]) > 0).all()
    lengths = [np.linalg.norm(np.diff(np.array(p), axis=0), axis=1).sum() for p in (at, way)]
    assert lengths[0] <= lengths[1] + 1e-3


@pytest.fixture(scope="module")
def plane_once(plane):
    return plane


def test_a_string_takes_the_tremor_out(plane):
    rng = np.random.default_rng(5)
    way = np.stack([np.linspace(-40, 40, 200), rng.normal(0, 1.0, 200)], axis=1)
    rough = places(draw(Hand(plane), way, pressure=0.5))[:, 1]
    hand = Hand(plane, HandSettings(smoothing=0.5))
    smooth = places(draw(hand, way, pressure=0.5))[:-21, 1]
    assert np.abs(np.diff(smooth)).mean() < 0.2 * np.abs(np.diff(rough)).mean()


POINTS = st.lists(
    st.tuples(st.floats(0.01, 0.99), st.floats(0, 1)),
    max_size=8,
    unique_by=lambda p: round(p[0], 2),
)


@settings(deadline=None, max_examples=40)
@given(POINTS, st.floats(0, 1), st.floats(0, 1))
def test_a_pressure_curve_never_falls_and_meets_its_points(points, low, high):
    xs = sorted(x for x, _ in points)
    ys = sorted(y for _, y in points)
    curve = PressureCurve(((0.0, 0.0), *zip(xs, ys, strict=True), (1.0, 1.0)))
    low, high = sorted((low, high))
    assert 0.0 <= curve(low) <= curve(high) <= 1.0
    for x, y in curve.points:
        assert curve(x) == pytest.approx(y, abs=0.12)  # a steep step lies between two samples
    assert curve(0.0) == 0.0
    assert curve(1.0) == 1.0


def test_points_of_the_curve_are_dragged_as_far_as_they_go():
    curve = PressureCurve().with_point(0.5, 0.8)
    assert curve.points == ((0, 0), (0.5, 0.8), (1, 1))
    assert curve(0.5) == pytest.approx(0.8, abs=1e-3)
    assert curve.moved(1, 2.0, -1.0).points[1] == (0.99, 0.0)
    assert curve.moved(0, 0.4, 0.2).points[0] == (0.0, 0.2)
    assert curve.without_point(1) == PressureCurve()
    for bad in ((), ((0, 0), (0.5, 1.2), (1, 1)), ((0, 1), (1, 0)), ((0.1, 0), (1, 1)), "x"):
        with pytest.raises(InputError, match="pressure curve"):
            PressureCurve(bad)


@pytest.mark.parametrize("name", brush_names())
def test_a_brush_in_another_size_is_as_full_and_leaves_as_much(name):
    brush = load_brush(name)
    large = scaled(brush, 1.5)
    assert large.volume / brush.volume == pytest.approx(1.5**3)
    assert large.load / large.volume == pytest.approx(brush.load / brush.volume)
    left = [b.load * b.transfer_per_mm / b.root_diameter_mm for b in (brush, large)]
    assert left[1] == pytest.approx(left[0])
    back = resized(large, brush.length_mm)
    assert back.load == pytest.approx(brush.load, rel=1e-3)
    assert stepped(brush, 100).length_mm == 200.0
    assert stepped(brush, -100).length_mm >= 5.0
    with pytest.raises(BrushError, match="length"):
        resized(brush, 1000.0)


def test_images_of_planes_and_turns():
    x, y = (MirrorPlane((0, 0, 0), n) for n in ((1, 0, 0), (0, 2, 0)))
    assert len(Symmetry((x,)).images()) == 1
    assert len(Symmetry((x, y)).images()) == 3
    assert len(Symmetry((x,), RadialSymmetry(6)).images()) == 11
    assert len(Symmetry((x, x)).images()) == 1  # twice the same
    (moved,) = transform_samples([sample(1, 3, 4)], Symmetry((x,)).images()[0])
    np.testing.assert_allclose(moved.position, [-3, 4, 35])
    np.testing.assert_allclose(rotate(moved.orientation, np.eye(3)[0]), [-1, 0, 0], atol=1e-12)
    assert moved.contact is None
    meant = replace(sample(1, 3, 4), contact=np.array([3.0, 4.0, 0.0]))
    (moved,) = transform_samples([meant], Symmetry((x,)).images()[0])
    np.testing.assert_allclose(moved.contact, [-3, 4, 0])
    for bad in (
        lambda: Symmetry((MirrorPlane((0, 0, 0), (0, 0, 0)),)),
        lambda: Symmetry((), RadialSymmetry(0)),
        lambda: Symmetry((x, y), RadialSymmetry(33)),
    ):
        with pytest.raises(InputError, match="expected"):
            bad()


def test_images_are_painted_and_the_ledger_closes():
    document = small_plane()
    document.set_symmetry(
        Symmetry((MirrorPlane((0, 0, 0), (0, 1, 0)),), RadialSymmetry(2, (0, 0, 0)))
    )
    paint(document, (20, 25), (50, 25))
    surface = document.surface
    points, inked = surface.paint_mesh.vertices, surface.amounts[:, 0] * surface.vertex_areas
    for side in (1, -1):
        for end in (1, -1):
            here = (side * points[:, 0] > 10) & (end * points[:, 1] > 10)
            assert inked[here].sum() == pytest.approx(inked.sum() / 4, rel=0.03)
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)
    alone = small_plane()
    paint(alone, (20, 25), (50, 25))
    assert document.painter.in_brush() == alone.painter.in_brush()
    document.undo()
    assert not surface.painted.any()
    assert document.painter.ledger()["loaded"] == pytest.approx(6000.0)
    document.begin_stroke()
    document.feed(line((20, 25), (50, 25)))
    document.cancel_stroke()
    accounts = document.painter.ledger()
    assert accounts["loaded"] == accounts["in_brush"] == pytest.approx(6000.0)


# -- a tuft bent with a mouse ------------------------------------------------------------------


SHIFT = QtCore.Qt.KeyboardModifier.ShiftModifier
LEFT = BUTTON.LeftButton


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 1.5, "porcelain", drawn=False) as window:
        yield window


def turn_in_place(window, way, keys, goes_on=False):
    """Press in the middle, go a way of (x, y) pixels with these keys held; the samples."""
    canvas = window.canvas
    x, y = 0.5 * canvas.width(), 0.55 * canvas.height()
    mouse(canvas, KIND.MouseMove, x, y)
    mouse(canvas, KIND.MouseButtonPress, x, y, LEFT, LEFT)
    live(0.03)
    for k in range(1, 13):
        place = x + way[0] * k / 12, y + way[1] * k / 12
        mouse(canvas, KIND.MouseMove, *place, BUTTON.NoButton, LEFT, keys)
        live(0.01)
    end = x + way[0], y + way[1]
    if goes_on:
        for _ in range(10):
            end = end[0] + 6.0, end[1]
            mouse(canvas, KIND.MouseMove, *end, BUTTON.NoButton, LEFT)
            live(0.01)
    mouse(canvas, KIND.MouseButtonRelease, *end, LEFT, BUTTON.NoButton)
    settled(window)
    return window.document.strokes[-1].samples


@pytest.mark.parametrize("way", [(60, 0), (-60, 0), (0, 60), (0, -60)])
def test_with_shift_the_mouse_turns_the_bend_and_the_brush_stays(window, way) -> None:
    samples = turn_in_place(window, way, SHIFT)
    places = np.array([sample.contact for sample in samples])
    assert np.ptp(places, axis=0).max() < 1e-6
    right, up, _ = picture_axes(window.hand.camera)
    wanted = way[0] * right - way[1] * up
    bend = rotate(samples[-1].orientation, np.array([1.0, 0.0, 0.0]))
    wanted[2] = bend[2] = 0.0
    assert bend @ wanted > 0.99 * np.linalg.norm(bend) * np.linalg.norm(wanted)


def test_without_shift_the_brush_goes_along(window) -> None:
    samples = turn_in_place(window, (60, 0), QtCore.Qt.KeyboardModifier.NoModifier)
    assert np.ptp([sample.contact[0] for sample in samples]) > 5.0


def test_after_shift_the_brush_goes_on_from_where_it_stood(window) -> None:
    samples = turn_in_place(window, (0, 60), SHIFT, goes_on=True)
    places = np.array([sample.contact for sample in samples])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert np.ptp(places[:, 0]) > 5.0
    assert np.ptp(places[:, 1]) < 1e-3  # the way that turned the bend moved nothing
    assert steps.max() < 3.0  # no leap to where the pointer is
    bend = rotate(samples[-1].orientation, np.array([1.0, 0.0, 0.0]))
    assert bend[0] < -0.9 * np.linalg.norm(bend[:2])  # and the tuft trails again, as it went


def test_the_mark_is_another_one_and_is_replayed_to_the_bit(window, tmp_path, monkeypatch) -> None:
    marks = []
    for way in ((60, 0), (0, -60)):
        turn_in_place(window, way, SHIFT)
        stroke, other = window.document.strokes[-1], Document.new("plane", 1.5)
        other.begin_stroke()
        other.feed(list(stroke.samples))
        other.end_stroke()
        marks.append(other.surface.coverage)
    assert marks[0].shape != marks[1].shape or not np.array_equal(*marks)
    file, out = tmp_path / "bends.score.jsonl", tmp_path / "bends.p3d"
    monkeypatch.setattr(window.targets, "ask", lambda *asked: file)
    window.workspace.actions["save_recording"].trigger()
    assert main(["replay", str(file), "--on", "plane", "--out", str(out), "--quiet"]) == 0
    again = Document.open(out)
    same_vertices(again.surface, window.document.surface)
    assert len(again.strokes) == len(window.document.strokes) >= 2


# -- how hard a finger presses -----------------------------------------------------------------


CAN = QtGui.QInputDevice.Capability
STATE = QtGui.QEventPoint.State


class Point:
    """A finger at a place, with a contact so many pixels across."""

    def __init__(self, x, y, across, state, pressure=1.0) -> None:
        self._place, self._across, self._state = QtCore.QPointF(x, y), across, state
        self._pressure = pressure

    def id(self) -> int:
        return 1

    def state(self):
        return self._state

    def position(self):
        return self._place

    def pressure(self) -> float:
        return self._pressure

    def ellipseDiameters(self):
        return QtCore.QSizeF(self._across, self._across)


class Touched(QtGui.QTouchEvent):
    """Qt makes no points with a size for tests: these are as its own would be."""

    def __init__(self, kind, device, point) -> None:
        super().__init__(kind, device)
        self._point = point

    def points(self) -> list[Point]:
        return [self._point]


def stroke_pressures(window, can, across_mm, pressure=1.0):
    """The pressures of a stroke by a finger whose contact is so large, mm."""
    canvas = window.canvas
    device = QtGui.QPointingDevice(
        "screen", 7, QtGui.QInputDevice.DeviceType.TouchScreen,
        QtGui.QPointingDevice.PointerType.Finger, CAN.Position | can, 5, 1,
    )  # fmt: skip
    fine = canvas.screen().physicalDotsPerInch() / 25.4
    y, n = 0.55 * canvas.height(), len(window.document.strokes)
    for k, x in enumerate(np.linspace(0.42, 0.58, 16) * canvas.width()):
        state, kind = (STATE.Updated, KIND.TouchUpdate) if k else (STATE.Pressed, KIND.TouchBegin)
        canvas.event(Touched(kind, device, Point(x, y, across_mm * fine, state, pressure)))
        live(0.01)
    canvas.event(Touched(KIND.TouchEnd, device, Point(x, y, 0.0, STATE.Released)))
    settled(window)
    assert len(window.document.strokes) == n + 1
    return [sample.pressure for sample in window.document.strokes[-1].samples[2:-2]]


@pytest.mark.parametrize(("across", "wanted"), [(7.0, 0.25), (10.0, 0.5), (30.0, 1.0)])
def test_the_contact_is_the_pressure(window, across, wanted) -> None:
    assert np.allclose(stroke_pressures(window, CAN.Area, across), wanted, atol=0.01)


def test_without_a_size_it_is_as_with_a_mouse(window) -> None:
    force = window.hand.hand.force / 7.9
    for can, across in ((CAN.Position, 10.0), (CAN.Area, 0.3)):
        assert max(stroke_pressures(window, can, across)) == pytest.approx(force)


def test_a_screen_that_tells_the_pressure_itself(window) -> None:
    told = stroke_pressures(window, CAN.Pressure, 0.0, pressure=0.4)
    assert np.allclose(told, 0.4, atol=0.01)


# -- what fingers mean -------------------------------------------------------------------------


def said_by(*steps):
    """What is said over steps of (milliseconds, places); as (kind, ...) in order."""
    fingers = Fingers()
    return [one for ms, places in steps for one in fingers.follow(ms * MS, places)]


def kinds(said):
    return [one.kind for one in said]


def test_one_finger_paints_from_where_and_when_it_came_down():
    said = said_by((0, {1: (10, 10)}), (8, {1: (14, 10)}), (16, {1: (30, 10)}), (24, {}))
    assert kinds(said) == ["press", "move", "move", "release"]
    assert [(one.time_ns // MS, one.x) for one in said] == [(0, 10), (8, 14), (16, 30), (24, 30)]


def test_a_dab_is_a_press_and_a_lift():
    assert kinds(said_by((0, {1: (10, 10)}), (60, {}))) == ["press", "release"]
    held = said_by((0, {1: (10, 10)}), (130, {1: (11, 10)}), (200, {}))
    assert kinds(held) == ["press", "move", "release"]


@pytest.mark.parametrize("count", [2, 3])
def test_taps_are_counted_and_leave_no_dot(count):
    down = {k: (100.0 * k, 50.0) for k in range(count)}
    one_by_one = [(20 * k, {j: down[j] for j in range(k + 1)}) for k in range(count)]
    said = said_by(*one_by_one, (120, down), (140, {0: down[0]}), (150, {}))
    assert [(one.kind, one.count) for one in said] == [("tap", count)]
    slow = said_by((0, down), (600, {}))
    assert slow == []


def test_two_fingers_move_zoom_and_roll():
    fingers = Fingers()
    fingers.follow(0, {1: (100, 100), 2: (200, 100)})
    said = []
    for k in range(1, 11):  # turned by a right angle clockwise, twice as far apart, moved by 50
        turn, half = 0.05 * math.pi * k, 50 * (1 + k / 10)
        x, y = 150 + 5 * k, 100
        dx, dy = half * math.cos(turn), half * math.sin(turn)
        places = {1: (x - dx, y - dy), 2: (x + dx, y + dy)}
        said += fingers.follow(10 * k * MS, places)
    said += fingers.follow(200 * MS, {})
    assert set(kinds(said)) == {"pinch"}
    factor = math.prod(one.factor for one in said)
    assert factor == pytest.approx(2.0, rel=0.15)  # the first pixels tell a drag from a tap
    assert sum(one.angle for one in said) == pytest.approx(-math.pi / 2, rel=0.15)
    assert sum(one.dx for one in said) == pytest.approx(50, abs=6)


def test_three_fingers_turn():
    places = {k: (100.0 * k, 50.0) for k in range(3)}
    moved = {k: (x + 20, y) for k, (x, y) in places.items()}
    again = {k: (x + 20, y) for k, (x, y) in moved.items()}
    said = said_by((0, places), (20, moved), (40, again), (60, {}))
    assert kinds(said) == ["turn", "turn"]
    assert said[1].dx == pytest.approx(20)


def test_a_second_finger_soon_takes_the_stroke_back_and_later_is_passed_over():
    began = [(0, {1: (10, 10)}), (20, {1: (40, 10)})]
    soon = said_by(*began, (120, {1: (60, 10), 2: (200, 10)}), (150, {}))
    assert kinds(soon) == ["press", "move", "cancel"]
    late = said_by(
        *began, (400, {1: (60, 10), 2: (200, 10)}), (420, {1: (80, 10), 2: (200, 10)}), (450, {})
    )
    assert kinds(late) == ["press", "move", "move", "move", "release"]
    lifted = said_by(*began, (400, {1: (60, 10), 2: (9, 9)}), (420, {2: (9, 9)}), (450, {}))
    assert kinds(lifted) == ["press", "move", "move", "release"]


def test_a_finger_that_stays_begins_nothing_new():
    said = said_by(
        (0, {1: (0, 0), 2: (90, 0)}), (20, {1: (30, 0), 2: (120, 0)}), (40, {2: (120, 0)}),
        (60, {2: (150, 50)}), (80, {}), (100, {3: (5, 5)}), (110, {}),
    )  # fmt: skip
    assert kinds(said) == ["pinch", "press", "release"]
    fingers = Fingers()
    fingers.follow(0, {1: (0, 0)})
    assert kinds(fingers.follow(10 * MS, {1: (50, 0)})) == ["press", "move"]
    assert kinds(fingers.cancel(20 * MS)) == ["cancel"]
    assert kinds(fingers.follow(30 * MS, {4: (0, 0)})) == []
    assert kinds(fingers.follow(40 * MS, {})) == ["press", "release"]


# -- times of events ---------------------------------------------------------------------------


START_MS = 7_000_000


def times(stamps, handled, kind="pen"):
    clock = EventClock()
    found = [
        clock.time_ns(kind, stamp, round(at), painting=k > 0)
        for k, (stamp, at) in enumerate(zip(stamps, handled, strict=True))
    ]
    return found, clock


def steps(values):
    return [b - a for a, b in pairwise(values)]


WAITS = st.lists(st.floats(0.0, 400.0), min_size=30, max_size=30)


@settings(deadline=None)
@given(st.lists(st.integers(1, 60), min_size=30, max_size=30), WAITS)
def test_the_steps_are_the_devices_own(gaps, waits):
    stamps = [START_MS + sum(gaps[: k + 1]) for k in range(len(gaps))]
    late, at = [], 0.0
    for stamp, wait in zip(stamps, waits, strict=True):  # in order, and never before it happened
        at = max(at, 3e12 + (stamp - START_MS + wait) * MS)
        late.append(at)
    at_once, _ = times(stamps, [3e12 + (s - START_MS) * MS for s in stamps])
    found, clock = times(stamps, late)
    assert steps(found) == steps(at_once) == [MS * gap for gap in gaps[1:]]
    assert not clock.untimed


def test_events_of_one_millisecond_keep_their_order():
    found, clock = times([START_MS] * 8 + [START_MS + 1], [5e12] * 9)
    assert steps(found) == [125_000] * 8
    assert not clock.untimed


def test_a_device_without_times_gets_even_ones():
    handed = [5e12 + 200 * MS * (k // 25) + 10_000 * (k % 25) for k in range(100)]  # 5 a second
    for stamps in ([0] * 100, [START_MS] * 100):
        found, clock = times(stamps, handed)
        assert clock.untimed == {"pen"}
        later = steps(found)[25:]
        assert min(later) > 0
        assert max(later) < 60 * MS < max(steps(handed))


def test_a_stamp_that_jumps_back_does_not_turn_time():
    found, _ = times([START_MS, START_MS + 8, 50, 58], [5e12, 5e12 + 8e6, 5e12 + 16e6, 5e12 + 24e6])
    assert steps(found) == [8 * MS] * 3


def test_an_event_that_seems_to_come_from_the_future_maps_the_clock_anew_between_strokes():
    clock = EventClock()
    late = 300 * MS
    clock.time_ns("pen", START_MS, 5 * 10**12 + late, False)  # the first one waited for a picture
    handed = 5 * 10**12 + 100 * MS
    assert clock.time_ns("pen", START_MS + 100, 5 * 10**12 + late + 1, True) > handed
    clock.time_ns("pen", START_MS + 101, 5 * 10**12 + late + 2, False)  # a burst's pause
    assert clock.time_ns("pen", START_MS + 109, 5 * 10**12 + late + 3, True) == handed + 309 * MS
    found = clock.time_ns("pen", START_MS + 600, 5 * 10**12 + 600 * MS, False)
    assert found == 5 * 10**12 + 600 * MS


@given(late=st.integers(0, 4000), wraps=st.integers(0, 3), rest=st.integers(0, MS - 1))
def test_a_clock_that_is_the_programs_own_is_taken_as_it_is(late, wraps, rest):
    """However late the first event is handed over, the next stroke keeps its distance."""
    clock, now = EventClock(), START_MS + wraps * (1 << 32)
    for k, wait in enumerate((late, 0, late, 0)):
        handed = (now + 1000 * k + wait) * MS + rest
        found = clock.time_ns("pen", START_MS + 1000 * k, handed, False)
        assert found == (now + 1000 * k) * MS


def test_a_stroke_of_another_device_begins_behind_the_last_and_keeps_its_pace():
    clock, now = EventClock(), 5 * 10**12
    for k in range(100):  # handed over faster than the hand wrote
        pen = clock.time_ns("pen", START_MS + 10 * k, now + k, painting=k > 0)
    found = [
        clock.time_ns("touch", START_MS + 1000 + 10 * k, now + 200 * MS + k, painting=k > 0)
        for k in range(20)
    ]
    assert found[0] > pen
    assert steps(found) == [10 * MS] * 19
    later = clock.time_ns("touch", START_MS + 4000, now + 3200 * MS, painting=False)
    assert later == now + 3200 * MS


@pytest.mark.parametrize("begins_ms", [START_MS, 50])
def test_a_device_that_begins_to_tell_the_time_is_heard_at_its_time(begins_ms: int) -> None:
    """By the computer's clock or by one of its own, in a stroke that had begun without."""
    clock, now = EventClock(), START_MS * MS
    for k in range(20):
        clock.time_ns("pen", 0, now + 8 * k * MS, painting=k > 0)
    found = [
        clock.time_ns("pen", begins_ms + 8 * k, now + 8 * k * MS, painting=True)
        for k in range(20, 60)
    ]
    assert found[-1] == now + 8 * 59 * MS


def test_a_stroke_without_times_of_its_own_keeps_its_pace_behind_a_clock_that_leads():
    clock, now = EventClock(), 5 * 10**12
    for k in range(100):  # handed over faster than the hand wrote: a minute ahead in the end
        pen = clock.time_ns("pen", START_MS + 600 * k, now + k * MS, painting=k > 0)
    found = [
        clock.time_ns("mouse", 0, now + 1000 * MS + 8 * k * MS, painting=k > 0) for k in range(30)
    ]
    assert found[0] > pen
    assert all(7 * MS <= step <= 9 * MS for step in steps(found)[1:])
    later = now + 90_000 * MS
    assert clock.time_ns("mouse", 0, later, painting=False) == later

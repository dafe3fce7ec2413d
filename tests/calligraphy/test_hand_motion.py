"""Motions of a hand on objects, the ways between them, and how they vary."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.bending import build_tuft
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.hand_motion import join_motions, move_between, to_hand_motion
from paint3d.calligraphy.timing import Motion, Tempo
from paint3d.calligraphy.variation import vary_motion
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.core.quaternion import rotate
from paint3d.errors import InputError
from paint3d.files.load import load_mesh
from paint3d.mesh.bvh import ClosestPoints
from paint3d.mesh.chart import frame_at, make_chart

EM = 20.0


@functools.cache
def sphere():
    return ClosestPoints(load_mesh("sphere"))


@functools.cache
def tuft():
    return build_tuft(load_brush("xiaobaiyun"))


def motion(n=200):
    """A curl over the em square, that comes down and goes up again."""
    t = np.linspace(0.0, 1.0, n)
    handle = EM * np.column_stack([0.2 + 0.6 * t, 0.5 + 0.3 * np.sin(5 * t)])
    height = 20.0 - 22.0 * np.sin(np.pi * t)
    zero = np.zeros(n, np.int32)
    none = zero.astype(np.int64)
    return Motion(t, handle, 3.0 * t, height, zero, none, none)


def laid(point):
    frame = frame_at(sphere(), point, (0.0, 0.0, 1.0))
    chart = make_chart(sphere(), frame, 11.0, 11.0)
    return to_hand_motion(motion(), chart, EM, tuft()), chart


def test_the_holder_stands_on_the_wall_over_its_foot():
    hand, chart = laid((0, -75, 0))
    plan = motion()
    up = rotate(hand.orientation, np.array([0.0, 0.0, 1.0]))
    feet = hand.position - (tuft().length + plan.height)[:, None] * up
    assert np.linalg.norm(feet, axis=1) == pytest.approx(75.0, abs=0.05)
    assert np.einsum("ij,ij->i", up, feet) / 75.0 == pytest.approx(1.0, abs=1e-3)
    assert feet == pytest.approx(chart.points(plan.handle - 0.5 * EM), abs=1e-9)
    assert hand.pressure == pytest.approx(np.maximum(0.0, -plan.height) / tuft().full_press)


def test_the_bend_keeps_its_azimuth():
    hand, chart = laid((0, -75, 0))
    plan = motion()
    bend = rotate(hand.orientation, np.array([1.0, 0.0, 0.0]))
    frames = chart.tangents(plan.handle - 0.5 * EM)
    x, y = (np.einsum("ij,ij->i", bend, frames[:, :, k]) for k in (0, 1))
    assert np.unwrap(np.arctan2(y, x)) == pytest.approx(plan.azimuth, abs=1e-9)


@pytest.mark.parametrize("goal", [(75, 0, 0), (0, 75, 0), (10, -74, 5)])
def test_ways_keep_clear_of_the_object_and_within_limits(goal):
    (one, _), (two, _) = laid((0, -75, 0)), laid(goal)
    tempo = Tempo()
    way = move_between(one, two, sphere(), tuft(), tempo)
    up = rotate(way.orientation, np.array([0.0, 0.0, 1.0]))
    for share in (0.0, 0.5, 1.0):
        along = way.position - share * tuft().length * up
        assert np.linalg.norm(along, axis=1).min() > 75.0 + 5.0
    whole = join_motions([one, way, two]).position[len(one.position) - 1 :][: len(way.position) + 2]
    speed = np.linalg.norm(np.diff(whole, axis=0), axis=1) * tempo.rate_hz
    assert speed.max() <= tempo.most_speed
    assert speed[[0, -1]].max() < 0.05 * tempo.most_speed
    jerk = np.linalg.norm(np.diff(whole, 3, axis=0), axis=1) * tempo.rate_hz**3
    assert jerk.max() <= 1.05 * tempo.most_jerk
    assert (way.pressure == 0.0).all()


# -- a hand's variation ------------------------------------------------------------------------


MIDDLE = np.array([15.0, 15.0])
LETTER = 30.0


@functools.cache
def three_strokes() -> Motion:
    """Three strokes of 1 s, and ways of .3 s between them."""
    stroke = np.concatenate([[-1] * 20, *([k] * 100 + [-1] * 30 for k in range(3))])
    n = len(stroke)
    t = np.arange(n) / 100.0
    handle = MIDDLE + np.stack([8.0 * np.sin(1.3 * t), 6.0 * np.cos(1.7 * t)], axis=1)
    height = np.where(stroke >= 0, -3.0, 4.0)
    still = np.zeros(n, np.int32)
    return Motion(t, handle, 0.5 * t, height, still, still.astype(np.int64), stroke)


@given(amount=st.floats(0.05, 3.0), seed=st.integers(0, 2**31))
@settings(deadline=None)
def test_a_hand_stays_within_its_habits_and_goes_smoothly(amount: float, seed: int) -> None:
    plan, varied = three_strokes(), vary_motion(three_strokes(), MIDDLE, LETTER, amount, [seed, 0])
    off = np.linalg.norm(varied.handle - plan.handle, axis=1)
    assert 0.0 < off.max() < 0.12 * LETTER * amount
    step, own = (np.linalg.norm(np.diff(m.handle, axis=0), axis=1) for m in (plan, varied))
    assert own.max() < step.max() + 0.012 * LETTER * amount  # no jump, between strokes either
    assert ((varied.height < 0.0) == (plan.height < 0.0)).all() or amount > 2.0
    np.testing.assert_array_equal(varied.height[plan.height > 0.0], plan.height[plan.height > 0.0])
    again = vary_motion(three_strokes(), MIDDLE, LETTER, amount, [seed, 0])
    np.testing.assert_array_equal(again.handle, varied.handle)
    other = vary_motion(three_strokes(), MIDDLE, LETTER, amount, [seed, 1])
    assert np.abs(other.handle - varied.handle).max() > 0.0


def test_without_variation_it_is_the_copybook_s() -> None:
    assert vary_motion(three_strokes(), MIDDLE, LETTER, 0.0, [1, 2]) is three_strokes()


def test_a_large_character_shakes_no_more_often_than_a_small_one() -> None:
    plan = three_strokes()
    small = vary_motion(plan, MIDDLE, 40.0, 1.0, [3, 1])
    slower = replace(plan, time_s=5.0 * plan.time_s)
    large = vary_motion(slower, MIDDLE, 200.0, 1.0, [3, 1])
    assert np.ptp(small.height[plan.stroke == 0]) > 0.05
    np.testing.assert_allclose(large.height, small.height, atol=1e-9)


class OneStroke:
    """A source in which every character is one bar."""

    name, licence = "bars", "CC0"

    def has(self, character: str) -> bool:
        return True

    def load(self, character: str) -> Glyph:
        bar = np.array([[100.0, 380.0], [900.0, 380.0], [900.0, 480.0], [100.0, 480.0]])
        stroke = GlyphStroke(bar, np.array([[130.0, 430.0], [870.0, 430.0]]))
        return Glyph(character, (stroke,))


def ways(variation: float, seed: int = 0) -> np.ndarray:
    settings = WritingSettings(load_brush("xiaokai"), 20.0, variation=variation, seed=seed)
    written = write_text(load_mesh("plane"), "一一", OneStroke(), settings)
    assert written.recording.header.get("variation", 0.0) == variation
    return written.recording.position


def test_a_character_that_comes_twice_is_not_written_twice_alike() -> None:
    plain, varied = ways(0.0), ways(1.0)
    np.testing.assert_array_equal(varied, ways(1.0))
    assert varied.shape != ways(1.0, 5).shape or not np.array_equal(varied, ways(1.0, 5))
    assert varied.shape != plain.shape or not np.array_equal(varied, plain)


def test_a_faster_hand_goes_the_same_ways_in_less_time() -> None:
    usual = WritingSettings(load_brush("xiaokai"), 20.0, variation=1.0)
    one, two = (
        write_text(load_mesh("plane"), "一一", OneStroke(), settings).recording
        for settings in (usual, replace(usual, hand_speed=4.0))
    )
    np.testing.assert_array_equal(4 * two.time_ns, one.time_ns)
    np.testing.assert_array_equal(two.position, one.position)
    with pytest.raises(InputError, match="hand_speed"):
        write_text(load_mesh("plane"), "一", OneStroke(), replace(usual, hand_speed=5.0))


def test_a_hand_that_shakes_too_much_is_refused() -> None:
    with pytest.raises(InputError, match="variation"):
        ways(3.5)

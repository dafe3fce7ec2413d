"""Variation of planned strokes: a hand's, within its habits, and never twice the same."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.path_fit import StrokePath
from paint3d.calligraphy.timing import Tempo, time_paths
from paint3d.calligraphy.variation import vary_paths
from paint3d.calligraphy.writing import WritingSettings, write_text
from paint3d.errors import InputError
from paint3d.files.load import load_mesh

EM = 30.0
MIDDLE = np.array([15.0, 15.0])


def path(start, end, em=EM, depth=2.0, n=300):
    """A straight stroke that sinks within a width and rises within one."""
    u = np.linspace(0.0, 1.0, n)
    handle = np.array(start) + u[:, None] * (np.array(end) - start)
    length = float(np.linalg.norm(handle[-1] - handle[0]))
    from_end = length * np.minimum(u, 1.0 - u)
    descent = depth * np.minimum(1.0, from_end / (0.085 * em))
    none = np.zeros(n)
    return StrokePath(handle, none, descent, handle, none, none)


@functools.cache
def strokes(em=EM):
    """A stroke, one far from it, and one that begins on it."""
    ends = [((4, 6), (26, 7)), ((5, 25), (24, 26)), ((15, 6.5), (16, 21))]
    return [path(np.array(a) * em / EM, np.array(b) * em / EM, em) for a, b in ends]


def way(one):
    return np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(one.handle, axis=0), axis=1))]


@given(amount=st.floats(0.05, 3.0), seed=st.integers(0, 2**31))
@settings(deadline=None)
def test_a_hand_stays_within_its_habits(amount: float, seed: int) -> None:
    varied = vary_paths(strokes(), MIDDLE, EM, amount, [seed, 0])
    for plan, own in zip(strokes(), varied, strict=True):
        apart = np.linalg.norm(own.handle[:, None] - plan.handle, axis=2).min(axis=1)
        assert 0.0 < apart.max() < 0.12 * EM * amount
        assert np.linalg.norm(np.diff(own.handle, axis=0), axis=1).max() < 0.02 * EM
        assert own.descent[0] == own.descent[-1] == pytest.approx(0.0, abs=1e-9)
        assert (own.descent >= 0.0).all()
        assert own.descent.max() < 2.0 * (1.0 + amount)
    again = vary_paths(strokes(), MIDDLE, EM, amount, [seed, 0])
    other = vary_paths(strokes(), MIDDLE, EM, amount, [seed, 1])
    for own, same, differing in zip(varied, again, other, strict=True):
        np.testing.assert_array_equal(own.handle, same.handle)
        assert own.handle.shape != differing.handle.shape or (own.handle != differing.handle).any()


@given(seed=st.integers(0, 2**31))
@settings(deadline=None)
def test_a_little_varies_by_little(seed: int) -> None:
    for plan, own in zip(
        strokes(), vary_paths(strokes(), MIDDLE, EM, 1e-3, [seed, 0]), strict=True
    ):
        at, where = (way(one) / way(one)[-1] for one in (own, plan))
        for axis in range(2):
            assert np.interp(where, at, own.handle[:, axis]) == pytest.approx(
                plan.handle[:, axis], abs=1e-3 * EM
            )
        assert np.interp(where, at, own.descent) == pytest.approx(plan.descent, abs=0.05)


def test_without_variation_it_is_the_copybook_s() -> None:
    for plan, own in zip(strokes(), vary_paths(strokes(), MIDDLE, EM, 0.0, [1, 2]), strict=True):
        assert own is plan


@given(seed=st.integers(0, 2**31))
@settings(deadline=None)
def test_a_large_character_varies_as_a_small_one_does(seed: int) -> None:
    small = vary_paths(strokes(), MIDDLE, EM, 1.0, [seed, 1])
    large = vary_paths(strokes(5.0 * EM), 5.0 * MIDDLE, 5.0 * EM, 1.0, [seed, 1])
    for one, five in zip(small, large, strict=True):
        assert five.handle == pytest.approx(5.0 * one.handle, abs=1e-6 * EM)
        assert five.descent == pytest.approx(one.descent, abs=1e-6)


@given(seed=st.integers(0, 2**31), amount=st.floats(0.1, 3.0))
@settings(deadline=None, max_examples=20)
def test_a_varied_hand_keeps_the_limits_of_a_hand(seed: int, amount: float) -> None:
    """Ends that go back on themselves take their time."""
    tempo = Tempo()
    motion = time_paths([vary_paths(strokes(), MIDDLE, EM, amount, [seed, 0])], EM, tempo)
    place = np.column_stack([motion.handle, motion.height])
    for order, most in enumerate(
        (tempo.most_speed, tempo.most_acceleration, tempo.most_jerk), start=1
    ):
        rate = np.linalg.norm(np.diff(place, order, axis=0), axis=1) * tempo.rate_hz**order
        assert rate.max() <= 1.02 * most


def test_ends_are_not_all_alike() -> None:
    """Some begin as planned, with an open tip; some go back over their begin, more or less."""
    back = []
    for seed in range(60):
        first, *_ = vary_paths(strokes(), MIDDLE, EM, 1.0, [seed, 0])
        along = (first.handle[-1] - first.handle[0]) / np.linalg.norm(
            first.handle[-1] - first.handle[0]
        )
        reached = (first.handle - first.handle[0]) @ along
        back.append(-reached.min() / EM)
    back = np.array(back)
    assert 0.15 < (back < 1e-3).mean() < 0.5
    assert np.ptp(back[back > 1e-3]) > 0.02


@given(seed=st.integers(0, 2**31))
@settings(deadline=None)
def test_an_end_that_meets_another_stroke_keeps_to_it(seed: int) -> None:
    """The third stroke begins on the first: it neither starts short of it nor goes back there."""
    third = vary_paths(strokes(), MIDDLE, EM, 1.0, [seed, 0])[2]
    outward = third.handle[0] - third.handle[80]
    outward /= np.linalg.norm(outward)
    assert ((third.handle - third.handle[0]) @ outward).max() < 0.004 * EM


@given(seed=st.integers(0, 2**31), amount=st.floats(0.1, 3.0))
@settings(deadline=None)
def test_strokes_of_one_shape_vary_as_one(seed: int, amount: float) -> None:
    """What lies in one place still does, and is pressed as much more or less."""
    here = path((4, 6), (26, 7)), path((26, 7), (4, 6))
    one, other = vary_paths(here, MIDDLE, EM, amount, [seed, 0], joined=True)
    assert np.abs(one.handle - here[0].handle).max() > 1e-3 * EM * amount
    assert other.handle[::-1] == pytest.approx(one.handle, abs=1e-9)
    assert other.descent[::-1] == pytest.approx(one.descent, abs=1e-9)


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

"""A hand's variation: within its habits, and the same from the same seed."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from paint3d.brush.presets import load_brush
from paint3d.calligraphy.glyphs import Glyph, GlyphStroke
from paint3d.calligraphy.timing import Motion
from paint3d.calligraphy.variation import vary_motion
from paint3d.calligraphy.writing import Pen, write_text
from paint3d.errors import InputError
from paint3d.files.load import load_mesh

MIDDLE = np.array([15.0, 15.0])
EM = 30.0


@functools.cache
def motion() -> Motion:
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
    plan, varied = motion(), vary_motion(motion(), MIDDLE, EM, amount, [seed, 0])
    off = np.linalg.norm(varied.handle - plan.handle, axis=1)
    assert 0.0 < off.max() < 0.12 * EM * amount
    step, own = (np.linalg.norm(np.diff(m.handle, axis=0), axis=1) for m in (plan, varied))
    assert own.max() < step.max() + 0.012 * EM * amount  # no jump, between strokes either
    assert ((varied.height < 0.0) == (plan.height < 0.0)).all() or amount > 2.0
    np.testing.assert_array_equal(varied.height[plan.height > 0.0], plan.height[plan.height > 0.0])
    again = vary_motion(motion(), MIDDLE, EM, amount, [seed, 0])
    np.testing.assert_array_equal(again.handle, varied.handle)
    other = vary_motion(motion(), MIDDLE, EM, amount, [seed, 1])
    assert np.abs(other.handle - varied.handle).max() > 0.0


def test_without_variation_it_is_the_copybook_s() -> None:
    assert vary_motion(motion(), MIDDLE, EM, 0.0, [1, 2]) is motion()


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
    pen = Pen(load_brush("xiaokai"), 20.0, variation=variation, seed=seed)
    written = write_text(load_mesh("plane"), "一一", OneStroke(), pen)
    assert written.recording.header.get("variation", 0.0) == variation
    return written.recording.position


def test_a_character_that_comes_twice_is_not_written_twice_alike() -> None:
    plain, varied = ways(0.0), ways(1.0)
    np.testing.assert_array_equal(varied, ways(1.0))
    assert varied.shape != ways(1.0, 5).shape or not np.array_equal(varied, ways(1.0, 5))
    assert varied.shape != plain.shape or not np.array_equal(varied, plain)


def test_a_hand_that_shakes_too_much_is_refused() -> None:
    with pytest.raises(InputError, match="variation"):
        ways(3.5)

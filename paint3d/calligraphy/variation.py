"""Variation of a planned motion within a writer's habits: no two strokes are alike.

A copybook has each character once. A hand that writes it again enters a little elsewhere, leans
otherwise, presses more here and less there. Each character is turned, stretched and shifted as a
whole, each stroke once more, and the brush sinks deeper or less deep by a slow tremor; between
strokes, while the brush is up, one goes over into the next. Everything follows from a seed and the
character's index in the text.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from paint3d.calligraphy.timing import Motion, minimum_jerk
from paint3d.core.arrays import AnyArray

__all__ = ["vary_motion"]

# Standard deviations at a variation of 1, set by eye beside pages that one hand wrote: of a
# character as a whole, and of each stroke in it.
_TURN, _STROKE_TURN = 0.012, 0.018  # rad
_STRETCH, _STROKE_STRETCH = 0.016, 0.022
_SHIFT, _STROKE_SHIFT = 0.007, 0.006  # ems
_PRESS, _STROKE_PRESS = 0.03, 0.07  # of the depth that the brush is pressed to
_LEAN = 0.03  # rad, of the bend's direction, for each stroke
_TREMOR, _TREMOR_S = 0.035, (0.9, 0.5, 0.28)  # of the depth; periods of its waves, s, up to an em
_TREMOR_MM = 40.0  # of so much; where a stroke is larger its waves are longer, and as few
_MOST = 2.0  # standard deviations: a hand that is practised makes no slips


def vary_motion(
    motion: Motion, middle: AnyArray, em_mm: float, amount: float, seed: list[int]
) -> Motion:
    """Return a character's motion as a hand would write it once more.

    Parameters
    ----------
    motion : Motion
    middle : (2,) float64
        Of the character, mm: what it is turned and stretched about.
    em_mm : float
        Side of the em square.
    amount : float
        0: as planned; 1: as a practised hand varies.
    seed : list of int
        The same seed gives the same motion.
    """
    if amount <= 0.0:
        return motion
    rng = np.random.default_rng(seed)
    strokes = int(motion.stroke.max(initial=-1)) + 1
    own = np.clip(rng.standard_normal((strokes + 1, 7)), -_MOST, _MOST) * amount
    own[1:] *= (*[_STROKE_TURN], *[_STROKE_STRETCH] * 2, *[_STROKE_SHIFT] * 2, _STROKE_PRESS, _LEAN)
    own[0] *= (*[_TURN], *[_STRETCH] * 2, *[_SHIFT] * 2, _PRESS, 0.0)
    of_stroke = _blend_strokes(own[1:], motion.stroke)
    centres = np.array(
        [motion.handle[motion.stroke == k].mean(axis=0) for k in range(strokes)]
    ).reshape(-1, 2)
    handle = _transform(motion.handle, _blend_strokes(centres, motion.stroke), of_stroke, em_mm)
    handle = _transform(handle, middle, np.broadcast_to(own[0], of_stroke.shape), em_mm)
    time_s = motion.time_s / max(1.0, em_mm / _TREMOR_MM)
    tremor = sum(
        np.sin(2.0 * np.pi * (time_s / period + phase))
        for period, phase in zip(_TREMOR_S, rng.random(len(_TREMOR_S)), strict=True)
    )
    depth = np.maximum(0.0, 1.0 + of_stroke[:, 5] + own[0, 5] + amount * _TREMOR * tremor)
    height = np.where(motion.height < 0.0, motion.height * depth, motion.height)
    return replace(motion, handle=handle, height=height, azimuth=motion.azimuth + of_stroke[:, 6])


def _blend_strokes(values: AnyArray, stroke: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return values (S, K) of strokes at samples (N,): between two strokes from one to the next."""
    at = np.flatnonzero(stroke >= 0)
    if not len(at):
        return np.zeros((len(stroke), values.shape[1]))
    n = np.arange(len(stroke))
    after = np.searchsorted(at, n)
    last, following = at[np.maximum(after - 1, 0)], at[np.minimum(after, len(at) - 1)]
    last, following = np.where(stroke >= 0, n, last), np.where(stroke >= 0, n, following)
    last, following = np.where(n < at[0], following, last), np.where(n > at[-1], last, following)
    part = minimum_jerk((n - last) / np.maximum(following - last, 1))[:, None]
    result: NDArray[np.float64] = (
        values[stroke[last]] * (1.0 - part) + values[stroke[following]] * part
    )
    return result


def _transform(points: AnyArray, about: AnyArray, how: AnyArray, em_mm: float) -> AnyArray:
    """Turn, stretch and shift points (N, 2) about others by rows (N, 7) of `vary_motion`."""
    c, s = np.cos(how[:, 0]), np.sin(how[:, 0])
    x, y = ((points - about) * (1.0 + how[:, 1:3])).T
    turned = np.stack([c * x - s * y, s * x + c * y], axis=1)
    moved: AnyArray = about + turned + em_mm * how[:, 3:5]
    return moved

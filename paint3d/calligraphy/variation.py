"""Variation of planned strokes within a writer's habits: no two are alike.

A copybook has each character once. A hand that writes it again enters a little elsewhere, leans
otherwise, presses more here and less there, goes round a corner once and into it another time.
Each character is turned, stretched and bent as a whole; each stroke once more, bows a little, is
heavier at one end or in its middle, swells by a slow tremor, and begins and ends in its own way.
Everything follows from a seed and the character's index in the text.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from paint3d.calligraphy.path_fit import StrokePath
from paint3d.calligraphy.timing import minimum_jerk
from paint3d.core.arrays import AnyArray

__all__ = ["vary_paths"]

# Standard deviations at a variation of 1, set by eye beside pages that one hand wrote: of a
# character as a whole, and of each stroke in it.
_TURN, _STROKE_TURN = 0.012, 0.018  # rad
_STRETCH, _STROKE_STRETCH = 0.016, 0.022
_SHIFT, _STROKE_SHIFT = 0.007, 0.006  # ems
_SWAY, _SWAY_WAVES = 0.005, (2.0, 1.4, 1.0)  # ems: how far the square is bent, and its waves
_PRESS, _STROKE_PRESS = 0.03, 0.07  # of the depth that the brush is pressed to
_SLOPE, _WAIST = 0.06, 0.05  # of it: at one end more than at the other, at both than between
_LEAN = 0.03  # rad, of the bend's direction, for each stroke
_BOW, _DOUBLE_BOW = 0.012, 0.006  # of a stroke's chord
_TREMOR, _TREMOR_WAVES = 0.035, (1.0, 0.55, 0.3)  # of the depth; ems
_MOST = 2.0  # standard deviations: a hand that is practised makes no slips

# Ends of strokes, and corners.
_REACH = 0.085  # ems, about a stroke's width: how far in an end's own way is felt
_LONGER, _ASIDE = 0.022, 0.012  # ems
_END_PRESS, _END_LEAN = 0.16, 0.22  # of the depth; rad
_MEETING = 1.3  # reaches: what is nearer to another stroke meets it
_OPEN = 0.4  # so many ends stay as planned, to one that is closed more or less
_CLOSED, _TURN_BACK, _BACK = 1.3, 0.33, 0.45  # reaches: from where, to where, how far back
_CORNER = 0.25  # reaches aside, of where the brush comes down and where it turns
_STRAIGHT, _BROAD = 0.9, 0.75  # net over its way; of the median depth: what may be closed
_ROUND, _ROUND_SPACING = 0.04, 0.15  # ems: corners are rounded over it at the most; in turn so far
_STEP = 0.004  # ems between points that are made


def vary_paths(
    paths: Sequence[StrokePath],
    middle: AnyArray,
    em_mm: float,
    amount: float,
    seed: list[int],
    *,
    joined: bool = False,
) -> list[StrokePath]:
    """Return a character's strokes as a hand would write them once more.

    Their handle, azimuth and descent vary; what their footprints were planned to be does not.

    Parameters
    ----------
    paths : sequence of StrokePath
    middle : (2,) float64
        Of the character, mm: what it is turned and stretched about.
    em_mm : float
        Side of the em square.
    amount : float
        0: as planned; 1: as a practised hand varies.
    seed : list of int
        The same seed gives the same strokes.
    joined : bool
        Whether they were one shape: they vary as one, so that no gap opens between them.
    """
    if amount <= 0.0:
        return list(paths)
    rng = np.random.default_rng(seed)
    strokes = [np.column_stack([one.handle, one.azimuth, one.descent]) for one in paths]
    if not joined:
        handles = [poses[:, :2] for poses in strokes]
        strokes = [
            _vary_stroke(poses, handles[:k] + handles[k + 1 :], em_mm, amount, rng)
            for k, poses in enumerate(strokes)
        ]
    whole = amount * _draw(rng, _TURN, _STRETCH, _STRETCH, _SHIFT, _SHIFT, _PRESS)
    waves = []  # which axis sways, along what, from where on
    for length in _SWAY_WAVES:
        for axis in range(2):
            turn, phase = 2.0 * np.pi * rng.random(), rng.random()
            waves.append((axis, np.array([np.cos(turn), np.sin(turn)]) / (length * em_mm), phase))
    varied = []
    for path, poses in zip(paths, strokes, strict=True):
        handle = _transform(poses[:, :2], middle, whole, em_mm)
        for axis, wave, phase in waves:
            sway = np.sin(2.0 * np.pi * ((handle - middle) @ wave + phase))
            handle[:, axis] += amount * _SWAY * em_mm * sway
        descent = poses[:, 3] * max(0.0, 1.0 + whole[5])
        varied.append(replace(path, handle=handle, azimuth=poses[:, 2], descent=descent))
    return varied


def _vary_stroke(
    poses: AnyArray,
    others: Sequence[AnyArray],
    em_mm: float,
    amount: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Vary a stroke by itself: poses (N, 4) of x, y (mm), azimuth (rad) and descent (mm).

    The number of its poses may change. The handles of the other strokes (M, 2) say which of its
    ends meet another: those are neither closed nor made shorter.
    """
    reach = _REACH * em_mm
    is_free = [
        all((np.linalg.norm(other - end, axis=1) > _MEETING * reach).all() for other in others)
        for end in poses[[0, -1], :2]
    ]
    for order, free in zip((1, -1), is_free, strict=True):
        strength, own = rng.uniform(-_OPEN, 1.0), _draw(rng, _END_PRESS, _CORNER, _CORNER)
        if free and strength > 0.0:
            closed = _close_begin(poses[::order], em_mm, min(1.0, amount * strength), own)
            poses = closed[::order]
    # Corners: between going into one and going round it, each in its own way.
    way = _way_along(poses)
    length = max(float(way[-1]), _STEP * em_mm)
    count = max(2, round(length / (_ROUND_SPACING * em_mm)) + 1)
    rounding = np.interp(way, np.linspace(0.0, length, count), rng.random(count))
    poses = poses + min(amount, 1.0) * rounding[:, None] * (_round(poses, way, em_mm) - poses)
    # The stroke as a whole.
    turn, *transform, press, slope, waist, lean, bow, double_bow = amount * _draw(
        rng, _STROKE_TURN, *[_STROKE_STRETCH] * 2, *[_STROKE_SHIFT] * 2, _STROKE_PRESS,
        _SLOPE, _WAIST, _LEAN, _BOW, _DOUBLE_BOW,
    )  # fmt: skip
    u = way / length
    depth = 1.0 + press + slope * (1.0 - 2.0 * u) + waist * np.cos(2.0 * np.pi * u)
    for wave in _TREMOR_WAVES:
        tremor = np.sin(2.0 * np.pi * (way / (wave * em_mm) + rng.random()))
        depth = depth + amount * _TREMOR * tremor
    handle, azimuth = poses[:, :2], poses[:, 2] + lean
    handle = _transform(handle, handle.mean(axis=0), np.array([turn, *transform]), em_mm)
    aside = bow * 4.0 * u * (1.0 - u) + double_bow * np.sin(2.0 * np.pi * u)
    handle = handle + aside[:, None] * _turn_left(handle[-1] - handle[0])
    # Its ends.
    for from_end, free in zip((way, length - way), is_free, strict=True):
        longer, sideways, press, lean = amount * _draw(rng, _LONGER, _ASIDE, _END_PRESS, _END_LEAN)
        near = np.exp(-0.5 * (from_end / reach) ** 2)
        near *= min(1.0, length / (4.0 * reach))  # a dot's two ends are one
        end, inner = np.argmin(from_end), np.argmin(np.abs(from_end - 2.0 * reach))
        outward = handle[end] - handle[inner]
        outward /= max(float(np.linalg.norm(outward)), 1e-6 * em_mm)
        longer = longer if free else abs(longer)
        shift = em_mm * (longer * outward + sideways * _turn_left(outward))
        handle = handle + near[:, None] * shift
        depth, azimuth = depth + press * near, azimuth + lean * near
    return np.column_stack([handle, azimuth, np.maximum(0.0, poses[:, 3] * depth)])


def _close_begin(poses: AnyArray, em_mm: float, strength: float, own: AnyArray) -> AnyArray:
    """Begin a stroke (N, 4) with its tip hidden (strength 1), as planned (0), or between the two.

    The brush comes down within the stroke, goes back towards its begin while it sinks, turns there
    and goes on: the begin is blunt, and not a point. By `own` it is pressed more there, of the
    depth, and lies aside where it comes down and where it turns, in reaches. A begin that is drawn
    out thin, or that goes about corners, stays. Read backwards it is the end of one.
    """
    way, reach, deep = _way_along(poses), _REACH * em_mm, poses[:, 3]
    inside = _CLOSED * reach
    n = int(np.searchsorted(way, inside))
    if way[-1] < 3.0 * inside:
        return poses
    ahead = int(np.searchsorted(way, 2.0 * inside))  # a hook is no end of the stroke it stands on
    is_straight = np.linalg.norm(poses[ahead, :2] - poses[0, :2]) > _STRAIGHT * way[ahead]
    if not is_straight or deep[n] < _BROAD * float(np.median(deep)):
        return poses
    turn = strength * _TURN_BACK * reach
    landing = turn + strength * _BACK * reach
    press, aside_landing, aside_turn = own
    most = strength * (1.0 + press) * deep[n] + (1.0 - strength) * float(np.interp(turn, way, deep))
    step = _STEP * em_mm
    back = np.linspace(landing, turn, max(2, round((landing - turn) / step)), endpoint=False)
    on = np.linspace(turn, way[n], max(2, round((way[n] - turn) / step)), endpoint=False)
    begin = np.column_stack([np.interp(np.r_[back, on], way, column) for column in poses.T])
    eased = minimum_jerk((on - turn) / (way[n] - turn))
    down = minimum_jerk(np.linspace(0.0, 1.0, len(back), endpoint=False))
    begin[: len(back), 3] = most * down
    begin[len(back) :, 3] += (1.0 - eased) * (most - begin[len(back), 3])
    aside = np.r_[aside_landing + (aside_turn - aside_landing) * down, aside_turn * (1.0 - eased)]
    inward = poses[n, :2] - poses[0, :2]
    across = _turn_left(inward / np.linalg.norm(inward))
    begin[:, :2] += strength * reach * aside[:, None] * across
    return np.concatenate([begin, poses[n:]])


def _way_along(poses: AnyArray) -> NDArray[np.float64]:
    """Length of the handle's way (N,) up to each pose, mm."""
    steps = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
    way: NDArray[np.float64] = np.r_[0.0, np.cumsum(steps)]
    return way


def _turn_left(vector: AnyArray) -> AnyArray:
    return np.array([-vector[1], vector[0]])


def _round(poses: AnyArray, way: AnyArray, em_mm: float) -> NDArray[np.float64]:
    """Poses (N, K) evened out along their way, by a Gaussian that keeps both ends."""
    count = max(2, round(float(way[-1]) / (_STEP * em_mm)) + 1)
    even = np.linspace(0.0, float(way[-1]), count)
    on_grid = np.column_stack([np.interp(even, way, column) for column in poses.T])
    sigma = _ROUND / _STEP
    pad = min(count - 1, round(4.0 * sigma))
    padded = np.pad(on_grid, ((pad, pad), (0, 0)), mode="reflect", reflect_type="odd")
    smooth = gaussian_filter1d(padded, sigma, axis=0)[pad : pad + count]
    return np.column_stack([np.interp(way, even, column) for column in smooth.T])


def _draw(rng: np.random.Generator, *deviations: float) -> NDArray[np.float64]:
    """Normal values of these deviations, none beyond `_MOST` of its own."""
    values: NDArray[np.float64] = np.clip(rng.standard_normal(len(deviations)), -_MOST, _MOST)
    return values * deviations


def _transform(points: AnyArray, about: AnyArray, how: AnyArray, em_mm: float) -> AnyArray:
    """Turn (rad), stretch and shift (ems) points (N, 2) about one by the first five values."""
    c, s = np.cos(how[0]), np.sin(how[0])
    x, y = ((points - about) * (1.0 + how[1:3])).T
    moved: AnyArray = about + np.stack([c * x - s * y, s * x + c * y], axis=1) + em_mm * how[3:5]
    return moved

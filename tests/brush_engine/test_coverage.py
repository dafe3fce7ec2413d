"""What a sweep covers of vertices' boxes, beside many points under many outlines."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from paint3d.brush_engine.coverage import fill_chords, make_chords, weigh
from paint3d.brush_engine.footprint import PROFILE_CELLS, SWEEP, Stamp, keep_profile, make_stamp

BOX = 0.25  # mm
MOMENTS, POINTS = 48, 10


def stamp_of(length: float, breadth: float, blunt: float) -> Stamp:
    """An outline as long and broad, mm; the less `blunt`, the longer its points."""
    stamp = make_stamp()
    part = np.linspace(0.0, 1.0, PROFILE_CELLS + 1)
    stamp.half_widths[:-1] = 0.5 * breadth * np.sin(np.pi * part) ** blunt
    keep_profile(stamp, -0.3 * length, 0.7 * length)
    stamp.values["touches"] = 1.0
    return stamp


def covered(stamps, turns, at: float, xs: NDArray, ys: NDArray) -> NDArray:
    """What of boxes (N,) lies under the outline after a part of the way."""
    x, y, c, s = (1.0 - at) * turns[0] + at * turns[1]
    c, s = np.array([c, s]) / np.hypot(c, s)
    heel, tip = (
        (1.0 - at) * stamps[0].values[0][end] + at * stamps[1].values[0][end]
        for end in ("heel", "tip")
    )
    widths = (1.0 - at) * stamps[0].half_widths[:-1] + at * stamps[1].half_widths[:-1]
    inner = ((np.arange(POINTS) + 0.5) / POINTS - 0.5) * BOX
    dx = xs[:, None, None] + inner[None, :, None] - x
    dy = ys[:, None, None] + inner[None, None, :] - y
    along, across = c * dx + s * dy, np.abs(c * dy - s * dx)
    stations = np.linspace(heel, tip, PROFILE_CELLS + 1)
    return (across <= np.interp(along, stations, widths, -1.0, -1.0)).mean(axis=(1, 2))


@pytest.mark.parametrize(("length", "breadth"), [(9.0, 5.0), (14.0, 1.2), (2.0, 0.4)])
@pytest.mark.parametrize("direction", [0.0, 0.7, 1.57])
def test_shares_and_covers_are_those_of_many_points(direction, length, breadth) -> None:
    random = np.random.default_rng(3)
    stamps = stamp_of(length, breadth, 0.6), stamp_of(1.03 * length, 1.05 * breadth, 0.6)
    way = 0.8 * BOX
    angles = direction, direction + 0.15 / length
    turns = np.array([(k * way, 0.0, np.cos(a), np.sin(a)) for k, a in enumerate(angles)])
    sweep = np.zeros(1, SWEEP).view(np.recarray)
    sweep[0].to_before, sweep[0].to_after, sweep[0].scale = turns[0], turns[1], 1.0 / BOX
    chords = make_chords()
    fill_chords(*stamps, sweep[0], chords)
    reach = 0.8 * length
    xs, ys = random.uniform(-reach, reach, (2, 2000)).astype(np.float32)
    share, cover = np.zeros((2, len(xs)), np.float32)
    weigh(
        len(xs), 1.0 / BOX, chords.flanks, chords.grids, *chords.lines, xs, ys,
        np.ones_like(xs), share, cover,
    )  # fmt: skip
    moments = (np.arange(MOMENTS) + 0.5) / MOMENTS
    seen = np.array([covered(stamps, turns, at, xs, ys) for at in (*moments, 0.0, 1.0)])
    mean, most = seen[:MOMENTS].mean(axis=0), seen.max(axis=0)
    assert np.abs(share - mean).sum() < (0.03 if breadth > 1.0 else 0.06) * mean.sum()
    assert abs(share.sum() / mean.sum() - 1.0) < 0.01
    assert np.sqrt(np.mean((cover - most)[most > 0.0] ** 2)) < 0.05

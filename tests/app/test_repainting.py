"""Strokes of hands at random, painted live, and their recording: the same painting to the bit."""

from __future__ import annotations

import numpy as np
import pytest

from paint3d.app.model import paint_thread as paint_threads
from paint3d.app.model.paint_thread import PaintThread
from paint3d.device.sample import DeviceSample
from paint3d.painter.painter import Painter
from paint3d.surface.painted_surface import PaintedSurface
from tests.app.test_wet import Wall
from tests.support.app.hands import UPRIGHT, same_vertices, small_plane


def stroke(rng: np.random.Generator, t0: int, has_place: bool) -> list[DeviceSample]:
    """A bow by a hand that trembles, stops, and may lift the brush within."""
    n = int(rng.integers(4, 150))
    along = np.linspace(0.0, 1.0, n)[:, None]
    start = rng.uniform(-30.0, 30.0, 2)
    way, bow, wave = rng.uniform(-25.0, 25.0, (3, 2))
    xy = start + along * way + along**2 * bow + 0.3 * np.sin(5.0 * along) * wave
    xy += rng.normal(0.0, 0.02, (n, 2))
    pressure = np.clip(
        0.5 * np.sin(np.pi * along[:, 0]) ** 0.5 + rng.normal(0.0, 0.03, n), 0.0, 1.0
    )
    pressure[[0, -1]] = 0.0
    if n > 30 and rng.random() < 0.4:
        at = int(rng.integers(8, n - 8))
        pressure[at : at + 3] = 0.0
    steps = rng.integers(1_000_000, 20_000_000, n)
    steps[rng.random(n) < 0.01] += 700_000_000
    turn = rng.uniform(0.0, np.pi)
    held = np.array([np.cos(turn), 0.0, 0.0, np.sin(turn)])
    return [
        DeviceSample(
            int(time_ns), np.array([*at, 35.0]), held, float(press), 0, np.zeros(3), UPRIGHT,
            np.array([*at, 0.0]) if has_place else None,
        )
        for at, press, time_ns in zip(xy, pressure, t0 + np.cumsum(steps), strict=True)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("brush", "seed", "wet"),
    [("full", 42, True), ("feibai", 2, True), ("feibai", 34, False)]
    + [pytest.param("full", 8, True, marks=pytest.mark.long)]
    + [pytest.param(b, k, w, marks=pytest.mark.long)
       for b in ("full", "feibai", "zhongbaiyun") for k in range(43, 47) for w in (False, True)],
)  # fmt: skip
def test_a_recording_paints_the_same_to_the_bit(monkeypatch, brush, seed, wet):
    rng, wall = np.random.default_rng(seed), Wall(monkeypatch)
    monkeypatch.setattr(paint_threads.Pace, "most", lambda pace, behind_s: 10**9)
    document = small_plane(2.0, material="xuan", brush=brush)
    paint_thread, t0 = PaintThread(document, wet=wet), int(rng.integers(0, 10**15))
    wall.now = 1e-9 * t0
    for number in range(4):
        samples = stroke(rng, t0, bool(seed % 2))
        if number and rng.random() < 0.4:
            paint_thread.post("dip")
        paint_thread.post("begin_stroke")
        paint_thread.feed(samples)
        paint_thread.post("end_stroke")
        t0 = samples[-1].time_ns + int(rng.uniform(4e6, (3e7, 2e8, 4e9)[number % 3]))
    paint_thread.stop()
    surface = PaintedSurface(document.surface.source, 2.0, "xuan")
    Painter(surface, brush).replay(document.recording(), wet=wet)
    same_vertices(document.surface, surface)
    if wet:
        assert surface.flow.water == document.surface.flow.water > 0.0

"""The drawn brush does not hide what was painted just now, by real events in the window."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from tests.support.app.gestures import BUTTON, HAND, KIND, live, mouse, pen
from tests.support.app.windows import opened, settled


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:300x220", 3.0, "xuan") as window:
        yield window


def seen(window) -> np.ndarray:
    """(H, W, 3) of the canvas, the first row on top."""
    live(0.1)
    return window.stage.picture()[::-1, :, :3].astype(int)


def hidden_on(window, way: np.ndarray) -> float:
    """How much the brush takes off the contrast of a stroke to its sheet, 0 to 1."""
    with_brush = seen(window)
    window.stage.shows_brush = False
    without = seen(window)
    window.stage.shows_brush = True
    at = way[8:-8].astype(int)
    ink, sheet = (without[at[:, 1] + off, at[:, 0]].mean() for off in (0, 60))
    shown = with_brush[at[:, 1], at[:, 0]].mean(axis=1)
    return float(np.max((shown - ink) / (sheet - ink)))


@pytest.mark.parametrize("tilt", [pytest.param((0, 0), marks=pytest.mark.long), (45, 10)])
def test_a_stroke_is_seen_through_a_leaning_pen_pressed_and_lifted(window, tilt) -> None:
    wide, high = window.canvas.width(), window.canvas.height()
    x = np.linspace(0.62, 0.36, 60) * wide  # the handle leans back over the stroke
    way = np.stack([x, np.full(60, (0.45 if tilt[0] else 0.6) * high)], axis=1)
    HAND.begin()
    for k, place in enumerate(way):
        pen(window.canvas, KIND.TabletMove if k else KIND.TabletPress, *place, 0.5, tilt)
        live(0.006)
        HAND.pass_by(0.008)
    settled(window)
    assert hidden_on(window, way) < 0.6
    pen(window.canvas, KIND.TabletRelease, *way[-1], 0.0, tilt)
    for k in range(5):
        HAND.pass_by(0.05)
        pen(window.canvas, KIND.TabletMove, way[-1][0] + k, way[-1][1], 0.0, tilt)
        live(0.02)
    settled(window)
    assert hidden_on(window, way) < 0.6


def test_a_column_by_the_mouse_is_seen_behind_the_handle_that_rises_over_it(window) -> None:
    wide, high = window.canvas.width(), window.canvas.height()
    way = np.stack([np.full(50, 0.5 * wide), np.linspace(0.3, 0.7, 50) * high], axis=1)
    mouse(window.canvas, KIND.MouseMove, *way[0])
    mouse(window.canvas, KIND.MouseButtonPress, *way[0], BUTTON.LeftButton, BUTTON.LeftButton)
    for place in way:
        mouse(window.canvas, KIND.MouseMove, *place, BUTTON.NoButton, BUTTON.LeftButton)
        live(0.01)
    mouse(window.canvas, KIND.MouseButtonRelease, *way[-1], BUTTON.LeftButton)
    mouse(window.canvas, KIND.MouseMove, way[-1][0] + 1, way[-1][1])
    settled(window)
    with_brush = seen(window)
    window.stage.shows_brush = False
    without = seen(window)
    window.stage.shows_brush = True
    at = way[8:-8].astype(int)
    shown, ink = (picture[at[:, 1], at[:, 0]].mean() for picture in (with_brush, without))
    assert ink < 80
    assert shown < ink + 0.3 * (200 - ink)

"""What stands on the screen is what the window would draw anew, though only parts are repainted."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui

from tests.support.app.gestures import BUTTON, KIND, live, mouse, wait_for
from tests.support.app.windows import opened, settled


@pytest.fixture(autouse=True, scope="module")
def plain_edges() -> None:
    """Edges are smoothed here as users see them."""


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "bowl", 2.0, "porcelain") as window:
        yield window


def pixels(image: QtGui.QImage) -> np.ndarray:
    image = image.convertToFormat(QtGui.QImage.Format.Format_RGB32)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1, 4)
    return rows[:, : image.width(), :3].copy()


def on_screen(window) -> np.ndarray:
    """The canvas as the screen has it."""
    live(0.05)
    canvas = window.canvas
    place = canvas.mapTo(window, QtCore.QPoint(0, 0))
    shown = window.screen().grabWindow(window.winId())
    return pixels(shown.copy(QtCore.QRect(place, canvas.size())).toImage())


def with_nothing_new(window) -> None:
    """Compare the two while no picture comes between them."""
    window.workspace.hold()
    try:
        shown, anew = on_screen(window), pixels(window.canvas.grab().toImage())
    finally:
        window.workspace.go_on()
    np.testing.assert_array_equal(shown, anew)


def repainted(window) -> list[float]:
    """The shares of the canvas that are repainted from now on."""
    shares: list[float] = []
    canvas = window.canvas

    def note(painter: QtGui.QPainter, area: QtCore.QRect) -> None:
        clip = painter.clipBoundingRect()
        shares.append(clip.width() * clip.height() / (area.width() * area.height()))

    canvas.overlays.append(note)
    return shares


def test_the_screen_shows_what_a_whole_repaint_would(window) -> None:
    canvas = window.canvas
    width, height = canvas.width(), canvas.height()
    window.workspace.actions["dip"].trigger()
    settled(window)
    shares = repainted(window)
    mouse(canvas, KIND.MouseMove, 0.4 * width, 0.6 * height)
    mouse(canvas, KIND.MouseButtonPress, 0.4 * width, 0.6 * height, BUTTON.LeftButton)
    for k in range(12):
        x, y = (0.4 + 0.02 * k) * width, (0.6 + 0.005 * k) * height
        mouse(canvas, KIND.MouseMove, x, y, buttons=BUTTON.LeftButton)
        live(0.03)
        if k % 4 == 3:
            settled(window)
            with_nothing_new(window)
    mouse(canvas, KIND.MouseButtonRelease, x, y, BUTTON.LeftButton)
    assert min(shares) < 0.3
    assert min(shares[: len(shares) // 2]) < 0.3
    mouse(canvas, KIND.MouseMove, 0.3 * width, 0.3 * height)
    settled(window)
    wait_for(lambda: window.stage.is_drawn)
    with_nothing_new(window)


def test_the_plate_is_repainted_where_the_ink_becomes_less(window) -> None:
    """The screen's plate is the one that is drawn anew, though the brush is far from it."""
    window.workspace.actions["rinse"].trigger()
    settled(window)
    wait_for(lambda: window.stage.is_drawn)
    before = on_screen(window)
    window.workspace.actions["dip"].trigger()
    settled(window)
    after = on_screen(window)
    with_nothing_new(window)
    corner = np.s_[-60:, :250]
    assert (before[corner] != after[corner]).any()

"""The window while the painting is busy or behind, and a stroke that is taken back."""

from __future__ import annotations

import threading
import time

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.window.job import run_beside
from paint3d.brush.presets import load_brush
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    answer,
    drag,
    live,
    mouse,
    pen,
    type_key,
    wait_for,
)
from tests.support.app.windows import opened, pretend_saved, settled


@pytest.fixture(scope="module")
def window(program):
    """A window with a sheet in it."""
    with opened(program, material="porcelain") as window:
        yield window


@pytest.mark.parametrize("name", ["pick_colour", "pick_region"])
def test_what_looks_under_the_pointer_does_not_wait_for_a_long_step(window, name: str) -> None:
    settled(window)
    mouse(window.canvas, KIND.MouseMove, window.canvas.width() / 2, window.canvas.height() / 2)
    gate = threading.Event()
    window.stage.paint_thread.post(lambda document: gate.wait(300))
    live(0.05)
    started = time.thread_time()  # waiting takes no time of the thread's own
    try:
        window.workspace.actions[name].trigger()
        assert "Still painting" in window.status.told.text()
        assert not gate.is_set()
        assert time.thread_time() - started < 5.0
    finally:
        gate.set()
    settled(window)


@pytest.mark.parametrize("how", ["waiting", "going on"])
def test_leaving_asks_about_what_is_still_to_be_done(window, how: str) -> None:
    """A stroke that waits, or a step that takes long and is the last that was asked for."""
    settled(window)
    pretend_saved(window.stage.paint_thread)
    gate = threading.Event()
    paint_thread = window.stage.paint_thread
    paint_thread.post(lambda document: gate.wait(300) and document.dry())
    if how == "waiting":
        drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    else:
        wait_for(lambda: paint_thread.queue_length == 0)
    assert not window.document.modified
    asked = []

    def cancel(box) -> None:
        asked.append(box.text())
        QtTest.QTest.keyClick(box, QtCore.Qt.Key.Key_Escape)

    answer(cancel)
    try:
        assert not window.saving.may_leave()
    finally:
        gate.set()
    assert len(asked) == 1
    settled(window)
    assert window.document.modified


def test_leaving_does_not_ask_about_time_that_passes_for_the_ink(
    window, monkeypatch: pytest.MonkeyPatch
) -> None:
    settled(window)
    asked, paint_thread = [], window.stage.paint_thread
    monkeypatch.setattr(QtWidgets.QMessageBox, "exec", lambda box: asked.append(box.text()))
    pretend_saved(paint_thread)
    with paint_thread.paused():
        paint_thread.post("follow_time", 0.01)
        assert window.saving.may_leave()
    assert asked == []
    settled(window)


@pytest.mark.parametrize("how", ["key", "panel"])
def test_another_brush_is_shown_while_the_painting_is_behind(window, how: str) -> None:
    window.workspace.post("set_brush", load_brush("full"))
    settled(window)
    window.panels.docks["brushes"].raise_()
    gate = threading.Event()
    window.stage.paint_thread.post(lambda document: gate.wait(300))
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    view = window.panels.brushes.findChild(QtWidgets.QListWidget)
    try:
        if how == "key":
            type_key(window.canvas, QtCore.Qt.Key.Key_4)
        else:
            place = view.visualItemRect(view.item(3)).center()
            QtTest.QTest.mouseClick(view.viewport(), BUTTON.LeftButton, pos=place)
        wait_for(lambda: window.panels.brushes.brush.name == "xiaokai")
        behind = window.document.painter.brush.name, window.panels.brushes.brush.name
        row = view.currentRow()
    finally:
        gate.set()
    settled(window)
    assert behind == ("full", "xiaokai")
    assert row == 3
    assert window.document.painter.brush.name == "xiaokai"
    wait_for(lambda: view.currentRow() == 3)


@pytest.mark.parametrize("how", ["dialog", "job"])
def test_a_stroke_that_is_interrupted_ends_there(window, how: str) -> None:
    settled(window)
    n = len(window.document.strokes)
    drag(window.canvas, (0.45, 0.6), (0.55, 0.6), n=6, release=False)
    assert window.hand.in_stroke
    if how == "dialog":
        answer(lambda box: QtTest.QTest.keyClick(box, QtCore.Qt.Key.Key_Escape))
        window.workspace.actions["shortcuts"].trigger()
    else:
        run_beside(window, "nothing", lambda progress: None)
    assert not window.hand.in_stroke
    width, height = window.canvas.width(), window.canvas.height()
    left = BUTTON.LeftButton
    mouse(window.canvas, KIND.MouseMove, 0.6 * width, 0.6 * height, buttons=left)
    assert not window.hand.in_stroke
    mouse(window.canvas, KIND.MouseMove, 0.6 * width, 0.6 * height)
    settled(window)
    assert len(window.document.strokes) == n + 1


def test_a_stroke_that_is_taken_back_does_not_begin_again_while_the_button_is_down(window) -> None:
    settled(window)
    n = len(window.document.strokes)
    drag(window.canvas, (0.45, 0.4), (0.5, 0.4), n=6, release=False)
    window.hand.cancel()
    width, height = window.canvas.width(), window.canvas.height()
    for k in range(5):
        left = BUTTON.LeftButton
        mouse(window.canvas, KIND.MouseMove, (0.5 + 0.01 * k) * width, 0.4 * height, buttons=left)
    assert not window.hand.in_stroke
    mouse(window.canvas, KIND.MouseButtonRelease, 0.54 * width, 0.4 * height, BUTTON.LeftButton)
    settled(window)
    assert len(window.document.strokes) == n
    drag(window.canvas, (0.45, 0.4), (0.55, 0.4), n=6)
    settled(window)
    assert len(window.document.strokes) == n + 1


@pytest.mark.parametrize("device", ["mouse", "pen"])
def test_what_was_pressed_elsewhere_does_not_paint(window, device: str) -> None:
    """A press that closed a menu is the menu's; what is dragged after it is no stroke."""
    settled(window)
    n = len(window.document.strokes)
    width, height = window.canvas.width(), window.canvas.height()
    for k in range(8):
        x, y = (0.4 + 0.02 * k) * width, 0.5 * height
        if device == "mouse":
            mouse(window.canvas, KIND.MouseMove, x, y, buttons=BUTTON.LeftButton)
        else:
            pen(window.canvas, KIND.TabletMove, x, y, 0.5)
        live(0.01)
    assert not window.hand.in_stroke
    if device == "mouse":
        mouse(window.canvas, KIND.MouseButtonRelease, x, y, BUTTON.LeftButton)
    else:
        pen(window.canvas, KIND.TabletRelease, x, y, 0.0)
    settled(window)
    assert len(window.document.strokes) == n
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    settled(window)
    assert len(window.document.strokes) == n + 1

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
    answer_bar,
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
    with opened(program, material="porcelain", drawn=False) as window:
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
        assert "Still painting" in window.status.message_label.text()
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


# -- letting go of a painting ------------------------------------------------------------------


LONGEST_S = 300.0  # that a step goes on which nobody ends
N_WAITING = 6
TICKS = 20


@pytest.fixture
def one_window(program):
    with opened(program, material="porcelain", drawn=False) as one_window:
        yield one_window


@pytest.fixture
def step_gate():
    """Ends a step of the painting."""
    step_gate = threading.Event()
    yield step_gate
    step_gate.set()


def be_behind(one_window, step_gate: threading.Event) -> None:
    """Paint strokes that wait for a step that lasts."""
    settled(one_window)
    one_window.stage.paint_thread.post(lambda document: step_gate.wait(LONGEST_S))
    for k in range(N_WAITING):
        y = 0.4 + 0.03 * k
        drag(one_window.canvas, (0.45, y), (0.55, y), n=6)
    assert not one_window.document.strokes


def cancel(bar: QtWidgets.QProgressDialog) -> None:
    bar.findChild(QtWidgets.QPushButton).click()


def cancelling_the_wait() -> QtCore.QTimer:
    """Press *Cancel* in the bar of the step that is waited for; one of reading may come before."""

    def look() -> None:
        for bar in QtWidgets.QApplication.topLevelWidgets():
            is_bar = isinstance(bar, QtWidgets.QProgressDialog) and bar.isVisible()
            if is_bar and "current step" in bar.labelText():
                cancel(bar)

    timer = QtCore.QTimer()
    timer.timeout.connect(look)
    timer.start(20)
    return timer


def discard(box: QtWidgets.QMessageBox) -> None:
    next(b for b in box.buttons() if b.text() == "Do not save").click()


def test_the_window_lives_while_a_step_of_the_old_painting_goes_on(one_window, step_gate) -> None:
    be_behind(one_window, step_gate)
    before, ticked = one_window.document, []

    def tick() -> None:  # also the window's own ticks come then
        ticked.append(one_window.document is before)
        if len(ticked) > TICKS:
            step_gate.set()

    timer = QtCore.QTimer(one_window)
    timer.timeout.connect(tick)
    answer_bar(lambda bar: timer.start(10))
    assert one_window.opening.open_path("sphere", 8.0, asked=True)
    timer.stop()
    assert len(ticked) > TICKS
    assert all(ticked)
    assert step_gate.is_set()  # it was not left to itself
    assert one_window.document.surface.source.name == "sphere"
    assert not before.strokes  # what waited was not wanted any more
    drag(one_window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    settled(one_window)
    assert len(one_window.document.strokes) == 1


def test_cancel_goes_on_with_the_old_painting_and_all_that_waits(one_window, step_gate) -> None:
    be_behind(one_window, step_gate)
    before = one_window.document
    timer = cancelling_the_wait()
    assert not one_window.opening.open_path("sphere", 8.0, asked=True)
    timer.stop()
    assert not step_gate.is_set()
    assert one_window.document is before
    assert "Stopped" in one_window.status.message_label.text()
    step_gate.set()
    settled(one_window)
    assert len(one_window.document.strokes) == N_WAITING
    painted = one_window.document.surface.painted.sum()
    for _ in range(N_WAITING):
        one_window.workspace.actions["undo"].trigger()
        settled(one_window)
    assert not one_window.document.strokes
    assert one_window.document.surface.painted.sum() < painted
    drag(one_window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    settled(one_window)
    assert len(one_window.document.strokes) == 1


def test_what_waits_is_in_the_file_that_is_saved_first(one_window, step_gate, tmp_path) -> None:
    """Asked what becomes of it, the hand says: save."""
    be_behind(one_window, step_gate)
    file = tmp_path / "mine.p3d"
    with one_window.stage.paint_thread.paused(0.0) as document:
        assert document is None
    one_window.document.path = file
    answer_bar(lambda bar: step_gate.set())
    answer(lambda box: box.defaultButton().click(), QtWidgets.QMessageBox)
    assert one_window.opening.open_path("sphere", 8.0)
    assert one_window.document.surface.source.name == "sphere"
    assert one_window.opening.open_path(str(file), asked=True)
    assert len(one_window.document.strokes) == N_WAITING


def test_the_window_closes_with_a_bar_too_and_stays_where_it_is_stopped(
    one_window, step_gate
) -> None:
    be_behind(one_window, step_gate)

    def stay(box: QtWidgets.QMessageBox) -> None:
        answer_bar(cancel)
        discard(box)

    answer(stay, QtWidgets.QMessageBox)
    assert not one_window.close()
    assert one_window.isVisible()
    assert not step_gate.is_set()
    step_gate.set()
    settled(one_window)
    assert len(one_window.document.strokes) == N_WAITING
    live(0.1)
    wait_for(one_window.workspace.actions["undo"].isEnabled)

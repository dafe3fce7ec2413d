"""Strokes edited from the history panel, in the real window."""

from __future__ import annotations

import threading

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model import document as documents
from paint3d.app.window.history.stroke_editing import MoveDialog, TimeDialog
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    answer,
    answer_bar,
    drag,
    live,
    mouse,
    pen_stroke,
    wait_for,
    when,
)
from tests.support.app.windows import faults, opened, press, row_place, settled

ROWS = (0.40, 0.45, 0.50, 0.55, 0.60)
LEFT, RIGHT = QtCore.Qt.MouseButton.LeftButton, QtCore.Qt.MouseButton.RightButton


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 1.5, "porcelain", drawn=False) as window:
        for k, row in enumerate(ROWS):
            if k == 3:
                window.workspace.post("dip", "indigo")
            pen_stroke(window.canvas, (0.42, row), (0.55, row), [0.1, *[0.5] * 10, 0.0])
            settled(window)
        yield window


@pytest.fixture(autouse=True)
def as_it_was(window):
    """Every test leaves the painting as it found it, by undo."""
    before = state(window), len(window.document.strokes)
    with faults() as found:
        yield
        settled(window)
    while window.document.edits.n_done:
        press(window, QtCore.Qt.Key.Key_Z, QtCore.Qt.KeyboardModifier.ControlModifier)
    same(window, before[0])
    assert len(window.document.strokes) == before[1]
    assert found == []


def state(window) -> list[np.ndarray]:
    """What lies on every vertex: ink in all, how much of it is covered, and the colour."""
    with window.stage.paint_thread.paused() as document:
        document.refresh()
        surface = document.surface
        return [surface.amounts.sum(axis=1), surface.coverage.copy(), surface.srgb.astype(int)]


def same(window, before: list[np.ndarray]) -> None:
    """To the bit; of colours to one code, which rounds otherwise with every pigment."""
    for one, now, most in zip(before, state(window), (0, 0, 1), strict=True):
        np.testing.assert_allclose(now[: len(one)], one, rtol=0, atol=most)
        assert (now[len(one) :] == now[-1:]).all()  # vertices that came since are bare


def inked(window) -> np.ndarray:
    with window.stage.paint_thread.paused() as document:
        surface = document.surface
        return surface.paint_mesh.vertices[surface.coverage > 0.0].copy()


def choose(window, row: int, name: str) -> None:
    """Open the menu of a row by the right button, and choose an action by a click."""
    rows, place = window.panels.history.list, row_place(window, row)
    chosen = rows.currentRow()
    QtTest.QTest.mouseClick(rows.viewport(), RIGHT, pos=place)
    assert rows.currentRow() == chosen  # it only asks for the menu, which the platform sends:
    everywhere = rows.viewport().mapToGlobal(place)
    event = QtGui.QContextMenuEvent(QtGui.QContextMenuEvent.Reason.Mouse, place, everywhere)
    QtWidgets.QApplication.sendEvent(rows.viewport(), event)
    wait_for(lambda: isinstance(QtWidgets.QApplication.activePopupWidget(), QtWidgets.QMenu))
    menu = QtWidgets.QApplication.activePopupWidget()
    action = next(action for action in menu.actions() if action.objectName() == name)
    QtTest.QTest.mouseClick(menu, LEFT, pos=menu.actionGeometry(action).center())
    live(0.05)


def test_a_stroke_in_the_middle_is_deleted_and_undone_and_done_again(window) -> None:
    before = state(window)
    choose(window, 1, "delete")
    settled(window)
    assert len(window.document.strokes) == 4
    assert window.panels.history.list.count() == 4
    assert "Stroke 2 edited; 3 after it repainted" in window.status.message_label.text()
    gone = state(window)
    assert (gone[1] != before[1]).any()
    control = QtCore.Qt.KeyboardModifier.ControlModifier
    press(window, QtCore.Qt.Key.Key_Z, control)
    same(window, before)
    press(window, QtCore.Qt.Key.Key_Z, control | QtCore.Qt.KeyboardModifier.ShiftModifier)
    same(window, gone)


def test_a_stroke_is_dragged_on_the_object(window) -> None:
    canvas, before = window.canvas, inked(window)
    n_samples = window.stage.paint_thread.n_painted
    choose(window, 0, "drag")
    assert "Drag stroke 1" in window.status.message_label.text()
    drag(canvas, (0.48, 0.40), (0.48, 0.30))
    settled(window)
    assert len(window.document.strokes) == 5
    assert window.stage.paint_thread.n_painted == n_samples  # the drag did not paint
    after = inked(window)
    assert after[:, 1].max() > before[:, 1].max() + 3.0
    assert not window.editing.drag.is_on


def test_a_drag_beside_the_object_waits_and_esc_leaves_it(window) -> None:
    canvas, before = window.canvas, state(window)
    choose(window, 0, "drag")
    drag(canvas, (0.01, 0.02), (0.02, 0.03))
    assert window.editing.drag.is_on
    assert "beside the object" in window.status.message_label.text()
    press(window, QtCore.Qt.Key.Key_Escape)
    assert not window.editing.drag.is_on
    same(window, before)


def test_a_stroke_is_moved_by_numbers(window) -> None:
    def fill(dialog) -> None:
        assert isinstance(dialog, MoveDialog)
        dialog.up.setValue(-6.0)
        dialog.turn.setValue(90.0)
        dialog.accept()

    before = window.document.strokes[2].samples
    answer(fill)
    choose(window, 2, "move")
    settled(window)
    now = window.document.strokes[2].samples
    places = [np.mean([s.contact for s in samples], axis=0) for samples in (before, now)]
    np.testing.assert_allclose(places[1] - places[0], [0.0, -6.0, 0.0], atol=1.0)
    spans = [np.ptp([s.contact for s in samples], axis=0) for samples in (before, now)]
    np.testing.assert_allclose(spans[1][:2], spans[0][1::-1], atol=1e-6)


def test_a_stroke_takes_the_ink_and_the_brush_in_hand(window) -> None:
    window.workspace.post("dip", {"cinnabar": 1.0})
    window.workspace.post("set_brush", "feibai")
    settled(window)
    choose(window, 1, "ink")
    settled(window)
    choose(window, 2, "brush")
    settled(window)
    strokes = window.document.strokes
    assert [s.ink for s in strokes][1] == {"cinnabar": 1.0}
    assert [s.brush.name for s in strokes].count("feibai") == 1
    assert strokes[2].brush.name == "feibai"
    assert window.document.painter.brush.name == "feibai"  # what was in hand stays in it


def test_a_stroke_takes_another_time(window) -> None:
    def fill(dialog) -> None:
        assert isinstance(dialog, TimeDialog)
        dialog.seconds.setValue(3.0)
        dialog.accept()

    answer(fill)
    choose(window, 3, "time")
    settled(window)
    assert window.document.strokes[3].duration_s == pytest.approx(3.0)
    answer(lambda dialog: dialog.reject())
    choose(window, 2, "time")
    settled(window)
    assert window.document.strokes[3].duration_s == pytest.approx(3.0)


def test_a_history_that_becomes_lower_shows_where_the_painting_is(window) -> None:
    rows = window.panels.history.list
    window.panels.docks["history"].raise_()
    live(0.05)
    rows.scrollToTop()
    before = rows.maximumHeight()
    rows.setMaximumHeight(6 + 2 * rows.sizeHintForRow(0))
    last = rows.item(len(window.document.strokes) - 1)
    wait_for(lambda: rows.viewport().rect().contains(rows.visualItemRect(last).center()), 10.0)
    rows.setMaximumHeight(before)


def test_the_button_edits_the_stroke_that_is_shown_last(window) -> None:
    panel = window.panels.history
    window.panels.docks["history"].raise_()
    live(0.05)
    QtTest.QTest.mouseClick(
        panel.list.viewport(), LEFT, pos=panel.list.visualItemRect(panel.list.item(1)).center()
    )
    settled(window)
    assert len(window.document.strokes) == 2
    menu = panel.edit.menu()
    delete = next(action for action in menu.actions() if action.objectName() == "delete")

    def click() -> None:
        QtTest.QTest.mouseClick(menu, LEFT, pos=menu.actionGeometry(delete).center())

    when(menu.isVisible, click, "the button's menu opens")
    QtTest.QTest.mouseClick(panel.edit, LEFT)
    wait_for(lambda: window.document.edits.n_done == 1)
    settled(window)
    assert len(window.document.strokes) == 4  # those behind it have come back


def test_what_cannot_be_is_told_and_cancel_leaves_everything(window, monkeypatch) -> None:
    before = state(window)
    window.workspace.post("undo")
    settled(window)
    choose(window, 4, "delete")
    settled(window)
    assert "stroke 5 is undone" in str(window.workspace.error)
    window.workspace.post("redo")
    settled(window)
    play, cancelled = documents.play, threading.Event()

    def slowly(*given):
        for step in play(*given):
            for _ in range(3000):  # of a tenth of a second, until the bar has been answered
                yield step
                if cancelled.wait(0.1):
                    break

    def cancel(bar) -> None:
        bar.findChild(QtWidgets.QPushButton).click()
        cancelled.set()

    monkeypatch.setattr(documents, "play", slowly)
    answer_bar(cancel)
    choose(window, 0, "delete")
    wait_for(lambda: not window.workspace.is_waiting)
    settled(window)
    assert window.status.message_label.text() == "Stopped"
    assert len(window.document.strokes) == 5
    same(window, before)


def test_a_pen_drags_too(window) -> None:
    before = inked(window)
    choose(window, 0, "drag")
    pen_stroke(window.canvas, (0.48, 0.40), (0.48, 0.33), [0.5] * 6)
    settled(window)
    assert inked(window)[:, 1].max() > before[:, 1].max() + 1.0
    mouse(window.canvas, KIND.MouseButtonRelease, 5, 5, BUTTON.LeftButton)

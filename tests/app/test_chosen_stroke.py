"""The stroke that is chosen in the history is marked in the picture, on the object."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from tests.support.app.gestures import live, pen_stroke, type_key, wait_for, when
from tests.support.app.pointers import Touching, move_view, places
from tests.support.app.windows import click_row, faults, opened, row_place, settled

LEFT, RIGHT = QtCore.Qt.MouseButton.LeftButton, QtCore.Qt.MouseButton.RightButton
PRESSURES = [0.1, *[0.4] * 12, 0.0]


def accents(window) -> np.ndarray:
    """(H, W) bool: pixels of the picture in the colour of the mark's middle line."""
    settled(window)
    wait_for(lambda: window.stage.is_drawn)
    accent = QtGui.QColor(window.workspace.theme.accent).getRgb()[:3]
    return (np.abs(window.canvas.pixels[:, :, :3].astype(int) - accent) <= 8).all(axis=2)


def choose_in_menu(window, name: str) -> None:
    """Open the menu of *Edit*, and choose an action by a click."""
    panel = window.panels.history
    window.panels.docks["history"].raise_()
    menu = panel.edit.menu()
    action = next(one for one in menu.actions() if one.objectName() == name)
    chosen = []

    def click() -> None:
        chosen.append(name)
        QtTest.QTest.mouseClick(menu, LEFT, pos=menu.actionGeometry(action).center())

    when(menu.isVisible, click, "the button's menu opens")
    QtTest.QTest.mouseClick(panel.edit, LEFT)
    wait_for(lambda: chosen)
    live(0.05)


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 1.5, "porcelain") as window:
        for row in (0.42, 0.50, 0.58):
            pen_stroke(window.canvas, (0.42, row), (0.56, row), PRESSURES)
            settled(window)
        window.workspace.actions["brush"].trigger()  # its figure is not to hide anything
        window.workspace.actions["grips"].trigger()
        yield window


@pytest.fixture(autouse=True)
def no_faults(window):
    with faults() as found:
        yield
        settled(window)
    window.editing.drag.end()
    window.mark.choose(None)
    while window.document.edits.n_done:
        window.workspace.post("undo")
        settled(window)
    window.workspace.post("replay_history", 3)
    settled(window)
    assert found == []


def test_a_row_that_is_clicked_is_marked_along_its_way_until_esc(window) -> None:
    assert not accents(window).any()
    click_row(window, 1)
    assert len(window.document.strokes) == 2
    found = np.argwhere(accents(window))
    height, width = window.canvas.pixels.shape[:2]
    low, high = found.min(axis=0) / (height, width), found.max(axis=0) / (height, width)
    assert 0.46 < low[0] < high[0] < 0.54  # along the second stroke's row
    assert low[1] == pytest.approx(0.42, abs=0.02)
    assert high[1] == pytest.approx(0.56, abs=0.02)
    assert window.panels.history.list.item(1).font().bold()
    window.canvas.setFocus()
    type_key(window.canvas, QtCore.Qt.Key.Key_Escape)
    assert not accents(window).any()
    assert not window.panels.history.list.item(1).font().bold()


def test_the_menu_marks_the_stroke_that_it_is_about(window) -> None:
    rows, place = window.panels.history.list, row_place(window, 0)
    event = QtGui.QContextMenuEvent(
        QtGui.QContextMenuEvent.Reason.Mouse, place, rows.viewport().mapToGlobal(place)
    )
    QtWidgets.QApplication.sendEvent(rows.viewport(), event)
    wait_for(lambda: isinstance(QtWidgets.QApplication.activePopupWidget(), QtWidgets.QMenu))
    QtWidgets.QApplication.activePopupWidget().close()
    found = np.argwhere(accents(window))
    assert len(window.document.strokes) == 3  # it was only asked
    height = window.canvas.pixels.shape[0]
    assert found[:, 0].mean() / height == pytest.approx(0.42, abs=0.02)


def test_painting_undo_and_the_slider_let_the_mark_go(window) -> None:
    click_row(window, 2)
    assert accents(window).any()
    pen_stroke(window.canvas, (0.42, 0.66), (0.56, 0.66), PRESSURES)
    assert not accents(window).any()
    click_row(window, 3)
    assert accents(window).any()
    window.canvas.setFocus()
    type_key(window.canvas, QtCore.Qt.Key.Key_Z, QtCore.Qt.KeyboardModifier.ControlModifier)
    settled(window)
    assert not accents(window).any()
    click_row(window, 2)
    assert accents(window).any()
    window.panels.history.slider.setFocus()
    QtTest.QTest.keyClick(window.panels.history.slider, QtCore.Qt.Key.Key_Left)
    assert not accents(window).any()


def test_it_costs_nothing_while_nothing_is_chosen(window, monkeypatch) -> None:
    asked, actors = [], window.stage.scene.renderer.GetActors
    monkeypatch.setattr(window.stage, "show_faces", lambda name, *_: asked.append(name))
    before = actors().GetNumberOfItems()
    pen_stroke(window.canvas, (0.42, 0.66), (0.56, 0.66), PRESSURES)
    settled(window)
    assert asked == []
    monkeypatch.undo()
    click_row(window, 0)
    assert actors().GetNumberOfItems() == before + 3
    window.mark.choose(None)
    assert actors().GetNumberOfItems() == before


def test_a_click_on_its_paint_chooses_a_stroke_and_a_drag_moves_it(window) -> None:
    canvas, n_painted = window.canvas, window.stage.paint_thread.n_painted
    choose_in_menu(window, "pick")
    assert window.editing.drag.is_on
    pen_stroke(canvas, (0.48, 0.58), (0.48, 0.58), [0.5, 0.5, 0.0])
    found = np.argwhere(accents(window))
    assert found[:, 0].mean() / canvas.pixels.shape[0] == pytest.approx(0.58, abs=0.02)
    assert window.mark.indices == (2,)
    pen_stroke(canvas, (0.48, 0.50), (0.48, 0.70), [0.5] * 8 + [0.0])
    settled(window)
    assert window.document.edits.n_done == 1
    assert window.stage.paint_thread.n_painted == n_painted  # neither painted
    assert not window.editing.drag.is_on
    found = np.argwhere(accents(window))  # the mark has gone with it
    assert found[:, 0].mean() / canvas.pixels.shape[0] == pytest.approx(0.70, abs=0.03)


def test_of_two_strokes_at_one_place_the_upper_one_is_chosen(window) -> None:
    pen_stroke(window.canvas, (0.42, 0.58), (0.56, 0.58), PRESSURES)
    settled(window)
    choose_in_menu(window, "pick")
    pen_stroke(window.canvas, (0.48, 0.58), (0.48, 0.58), [0.5, 0.5, 0.0])
    assert window.mark.indices == (3,)


def test_beside_all_paint_no_stroke_is_chosen(window) -> None:
    choose_in_menu(window, "pick")
    pen_stroke(window.canvas, (0.48, 0.75), (0.48, 0.75), [0.5, 0.5, 0.0])
    assert window.mark.indices == ()
    assert "There is no stroke there" in window.status.message_label.text()
    assert window.editing.drag.is_on
    window.canvas.setFocus()
    type_key(window.canvas, QtCore.Qt.Key.Key_Escape)
    assert not window.editing.drag.is_on


@pytest.mark.parametrize("finger", ["auto", "turn"])
def test_a_finger_drags_a_stroke_and_does_not_paint(window, finger) -> None:
    window.canvas.finger = finger
    before, camera = window.stage.paint_thread.n_painted, window.hand.camera
    document = window.document
    count = len(document.strokes) + len(document.undone_strokes)
    window.panels.history.edited.emit("drag", 0)
    with Touching(window.canvas) as fingers:
        fingers.drag({1: places(window, (0.48, 0.42), (0.48, 0.30))})
    wait_for(lambda: window.document.edits.n_done)
    settled(window)
    assert document.edits.n_done == 1
    assert len(document.strokes) == count
    assert window.stage.paint_thread.n_painted == before
    assert window.hand.camera is camera  # nor did it turn the view
    ways = [np.mean([s.contact for s in one.samples], axis=0) for one in document.strokes]
    assert ways[0][1] > ways[1][1] + 10.0


def test_two_fingers_move_the_view_while_a_drag_is_waited_for(window) -> None:
    camera = window.hand.camera
    window.panels.history.edited.emit("drag", 0)
    move_view(window)
    settled(window)
    assert window.hand.camera is not camera
    assert window.editing.drag.is_on
    assert window.document.edits.n_done == 0
    window.hand.look(camera)


def test_what_lies_behind_the_wall_does_not_show_through(program) -> None:
    """A stroke inside a bowl's far wall, seen from the outside of that wall."""
    with opened(program, "bowl", 2.0, "porcelain") as window:
        pen_stroke(window.canvas, (0.45, 0.35), (0.55, 0.35), PRESSURES)
        window.workspace.actions["brush"].trigger()
        settled(window)
        window.panels.history.list.setCurrentRow(0)
        window.mark.choose(0)
        seen = accents(window).sum()
        assert seen > 40
        window.workspace.actions["look_back"].trigger()
        assert accents(window).sum() == 0

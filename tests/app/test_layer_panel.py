"""The panel of layers, by real events: opacity, blend, copies and merging, with their keys."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from tests.support.app.gestures import BUTTON, KIND, live, mouse, pen_stroke, type_key, wait_for
from tests.support.app.windows import opened, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sheet:120x120", 2.0, "xuan") as window:
        window.panels.docks["layers"].raise_()
        yield window


@pytest.fixture(autouse=True)
def bare(window) -> None:
    while window.document.can_undo:
        window.stage.paint_thread.post("undo").result(300)
    settled(window)


def click(button) -> None:
    QtTest.QTest.mouseClick(button, BUTTON.LeftButton)


def test_the_slider_is_dragged_and_is_one_step(window) -> None:
    slider = window.panels.layers.opacity
    wait_for(slider.isVisible)
    middle = slider.height() // 2
    here, there = (
        QtCore.QPoint(slider.width() - 8, middle),
        QtCore.QPoint(slider.width() // 2, middle),
    )
    QtTest.QTest.mousePress(slider, BUTTON.LeftButton, pos=here)
    for k in range(1, 9):
        at = here + (there - here) * k / 8
        mouse(slider, KIND.MouseMove, at.x(), at.y(), buttons=BUTTON.LeftButton)
    QtTest.QTest.mouseRelease(slider, BUTTON.LeftButton, pos=there)
    wait_for(lambda: window.document.layers[0].opacity < 0.9)
    settled(window)
    assert window.document.layers[0].opacity == pytest.approx(0.5, abs=0.08)
    assert len(window.document.steps.done) == 1
    assert window.panels.layers.percent.text() == f"{slider.value()} %"
    type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
    wait_for(lambda: slider.value() == 100)


def test_buttons_and_keys_copy_merge_and_multiply(window) -> None:
    panel = window.panels.layers
    pen_stroke(window.canvas, (0.3, 0.5), (0.7, 0.5), [0.5] * 12)
    settled(window)
    click(panel.buttons["copy"])
    wait_for(lambda: panel.list.count() == 2)
    assert window.document.active_layer == 1
    panel.blend.setFocus()
    QtTest.QTest.keyClick(panel.blend, KEY.Key_Down)
    QtTest.QTest.keyClick(panel.blend, KEY.Key_Return)
    wait_for(lambda: window.document.layers[1].blend == "multiply")
    settled(window)
    type_key(window.canvas, KEY.Key_J, HELD.ControlModifier | HELD.ShiftModifier)
    wait_for(lambda: panel.list.count() == 1)
    settled(window)
    assert window.document.layers[0].is_plain
    assert not panel.buttons["merge"].isEnabled()
    type_key(window.canvas, KEY.Key_J, HELD.ControlModifier)
    wait_for(lambda: panel.list.count() == 2)


def picture(window, row: int) -> np.ndarray:
    """The colours (28, 28, 3) that a row of the list shows of its layer."""
    layers = window.panels.layers.list
    label = layers.itemWidget(layers.item(row)).findChild(QtWidgets.QLabel, "thumbnail")
    image = label.pixmap().toImage().convertToFormat(QtGui.QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def test_each_row_shows_what_is_on_its_layer(window) -> None:
    window.workspace.actions["look_top"].trigger()
    window.stage.paint_thread.post("dip", "cinnabar").result(300)
    pen_stroke(window.canvas, (0.4, 0.35), (0.6, 0.35), [0.5] * 12)
    settled(window)
    type_key(window.canvas, KEY.Key_N, HELD.ControlModifier | HELD.ShiftModifier)
    wait_for(lambda: window.panels.layers.list.count() == 2)

    def is_red(row: int) -> np.ndarray:
        shown = picture(window, row)
        return shown[:, :, 0] - shown[:, :, 2] > 80

    wait_for(lambda: is_red(1).any())  # the lower one, in the upper half
    assert np.argwhere(is_red(1))[:, 0].max() < 14
    assert not is_red(0).any()
    window.workspace.actions["hide_layer"].trigger()
    settled(window)
    assert is_red(1).any()


def row_of(panel, text: str):
    """The row of the list whose name this is."""
    for k in range(panel.list.count()):
        row = panel.list.itemWidget(panel.list.item(k))
        if row.findChild(QtWidgets.QLineEdit).text() == text:
            return row
    raise AssertionError(f"no row {text}: {names(panel)}")


def names(panel) -> list[str]:
    rows = (panel.list.itemWidget(panel.list.item(k)) for k in range(panel.list.count()))
    return [row.findChild(QtWidgets.QLineEdit).text() for row in rows]


def click_name(panel, text: str, held=HELD.NoModifier) -> None:
    QtTest.QTest.mouseClick(row_of(panel, text).findChild(QtWidgets.QLineEdit),
                            BUTTON.LeftButton, held)  # fmt: skip


def test_groups_are_made_folded_shown_moved_copied_and_dissolved(window) -> None:
    panel, document = window.panels.layers, lambda: window.document
    for n in (2, 3):
        type_key(window.canvas, KEY.Key_N, HELD.ControlModifier | HELD.ShiftModifier)
        wait_for(lambda n=n: panel.list.count() == n)
    settled(window)
    click_name(panel, "Layer 2", HELD.ShiftModifier)
    type_key(window.canvas, KEY.Key_G, HELD.ControlModifier)
    wait_for(lambda: names(panel) == ["Group 1", "Layer 3", "Layer 2", "Layer 1"])
    click_name(panel, "Group 1")
    settled(window)
    panel.opacity.setFocus()
    QtTest.QTest.keyClick(panel.opacity, KEY.Key_Left)  # a page goes to another layer
    wait_for(lambda: document().layers[2].group.opacity == 0.99)
    assert document().layers[2].opacity == 1.0
    click(row_of(panel, "Group 1").findChildren(QtWidgets.QToolButton)[0])  # the eye
    wait_for(lambda: not document().layers[1].is_seen)
    settled(window)
    type_key(window.canvas, KEY.Key_H)
    wait_for(lambda: document().layers[1].is_seen)
    click(row_of(panel, "Group 1").findChild(QtWidgets.QToolButton, "fold_group"))
    wait_for(lambda: names(panel) == ["Group 1", "Layer 1"])
    click(panel.buttons["down"])
    wait_for(lambda: names(panel) == ["Layer 1", "Group 1"])
    click(row_of(panel, "Group 1").findChild(QtWidgets.QToolButton, "fold_group"))
    wait_for(lambda: names(panel) == ["Layer 1", "Group 1", "Layer 3", "Layer 2"])
    click_name(panel, "Layer 1")
    wait_for(lambda: document().active_layer == 2)
    settled(window)
    click(panel.buttons["down"])  # into the group
    wait_for(lambda: names(panel) == ["Group 1", "Layer 1", "Layer 3", "Layer 2"])
    type_key(window.canvas, KEY.Key_PageUp, HELD.ControlModifier)  # and out again
    wait_for(lambda: names(panel) == ["Layer 1", "Group 1", "Layer 3", "Layer 2"])
    click_name(panel, "Group 1")
    click(panel.buttons["copy"])
    wait_for(lambda: len(document().layers) == 5)
    settled(window)
    assert names(panel)[:4] == ["Layer 1", "Group 2", "Layer 3", "Layer 2"]
    type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
    wait_for(lambda: len(document().layers) == 3)
    settled(window)
    click_name(panel, "Group 1")
    click(panel.buttons["group"])  # is to ungroup there
    wait_for(lambda: names(panel) == ["Layer 1", "Layer 3", "Layer 2"])
    type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
    wait_for(lambda: "Group 1" in names(panel))
    settled(window)
    click_name(panel, "Group 1")
    name = row_of(panel, "Group 1").findChild(QtWidgets.QLineEdit)
    QtTest.QTest.mouseDClick(name, BUTTON.LeftButton)
    QtTest.QTest.keyClicks(name, "branch")
    QtTest.QTest.keyClick(name, KEY.Key_Return)
    wait_for(lambda: document().layers[0].group.name == "branch")


def test_a_name_that_is_left_as_it_was_stays_in_the_windows_language(window) -> None:
    panel = window.panels.layers
    settled(window)
    kept = [layer.name for layer in window.document.layers]
    row = panel.list.itemWidget(panel.list.item(0))
    name = row.findChild(QtWidgets.QLineEdit)
    shown = name.text()
    for typed in ("", shown):
        panel.list.setCurrentRow(0)
        panel.rename()
        name.setText(typed)
        QtTest.QTest.keyClick(name, KEY.Key_Return)
        assert name.text() == shown
        assert name.isReadOnly()
    settled(window)
    assert [layer.name for layer in window.document.layers] == kept


def test_each_of_two_quick_clicks_on_an_eye_counts(window) -> None:
    paint_thread = window.stage.paint_thread
    seen = []

    def twice(ask) -> None:
        paint_thread.halt()
        for _ in range(2):
            ask()
            seen.append(paint_thread.post(lambda document: document.layers[0].visible))
        paint_thread.go_on()
        settled(window)

    eye = row_of(window.panels.layers, "Layer 1").findChild(QtWidgets.QToolButton)
    twice(lambda: click(eye))
    twice(lambda: type_key(window.canvas, KEY.Key_H))
    assert [one.result(300) for one in seen] == [False, True, False, True]


def test_an_eye_waits_for_moves_of_layers_that_were_asked_before(window) -> None:
    panel, paint_thread = window.panels.layers, window.stage.paint_thread
    window.workspace.actions["add_layer"].trigger()
    wait_for(lambda: panel.list.count() == 2)
    settled(window)
    upper = row_of(panel, "Layer 2").findChild(QtWidgets.QToolButton)
    paint_thread.halt()
    panel.step(-1)  # Layer 2 below Layer 1, once the painting thread goes on
    click(upper)
    live(0.2)  # the click waits meanwhile
    paint_thread.go_on()
    wait_for(lambda: not all(layer.visible for layer in window.document.layers))
    settled(window)
    seen = {layer.name: layer.visible for layer in window.document.layers}
    assert seen == {"2": False, "1": True}
    assert [layer.name for layer in window.document.layers] == ["2", "1"]


def test_an_eye_is_for_the_layer_it_is_shown_beside_though_others_have_gone(window) -> None:
    panel, paint_thread = window.panels.layers, window.stage.paint_thread
    window.workspace.actions["add_layer"].trigger()
    wait_for(lambda: panel.list.count() == 2)
    settled(window)
    upper, lower = (row_of(panel, f"Layer {n}").findChild(QtWidgets.QToolButton) for n in (2, 1))
    paint_thread.post("remove_layer", 0).result(300)  # and the panel still shows it
    click(lower)
    assert [one.visible for one in paint_thread.post(lambda d: d.layers).result(300)] == [True]
    click(upper)
    assert [one.visible for one in paint_thread.post(lambda d: d.layers).result(300)] == [False]
    settled(window)


def test_a_layer_that_steps_into_a_folded_group_has_its_row(window) -> None:
    panel, actions = window.panels.layers, window.workspace.actions
    actions["add_layer"].trigger()
    wait_for(lambda: panel.list.count() == 2)
    actions["add_group"].trigger()
    wait_for(lambda: window.document.layers[-1].group is not None)
    settled(window)
    window.workspace.post("set_group_folded", 1)
    click_name(panel, "Layer 1")
    settled(window)
    actions["raise_layer"].trigger()
    wait_for(lambda: window.document.layers[0].group is not None)
    settled(window)
    wait_for(lambda: "Layer 1" in names(panel))

"""A seal in the studio: asked for by the menu, pressed by a click, taken back by a key."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from tests.support.app.gestures import BUTTON, KIND, answer, live, mouse, type_key, wait_for
from tests.support.app.pointers import Touching, move_view, places
from tests.support.app.windows import opened, settled


@pytest.fixture(scope="module")
def window(program):
    """A window with a sheet in it."""
    with opened(program, resolution=0.8) as window:
        yield window


@pytest.fixture(autouse=True)
def bare(window) -> None:
    while window.document.can_undo:
        window.stage.paint_thread.post("undo").result(300)
    settled(window)


def type_text(text: str, style: str = ""):
    """What deals with the dialog: types a text, chooses a style, and accepts."""

    def fill(dialog: QtWidgets.QDialog) -> None:
        dialog.drawing.clear()  # which the dialog keeps
        dialog.text.selectAll()
        event = QtGui.QInputMethodEvent()  # as the system's input method commits it
        event.setCommitString(text)
        QtWidgets.QApplication.sendEvent(dialog.text, event)
        if style:
            dialog.style_box.setCurrentIndex(dialog.style_box.findData(style))
        box = dialog.findChild(QtWidgets.QDialogButtonBox)
        QtTest.QTest.mouseClick(
            box.button(QtWidgets.QDialogButtonBox.StandardButton.Ok), BUTTON.LeftButton
        )

    return fill


def click(canvas, x: float, y: float) -> None:
    place = x * canvas.width(), y * canvas.height()
    mouse(canvas, KIND.MouseMove, *place)
    mouse(canvas, KIND.MouseButtonPress, *place, BUTTON.LeftButton, BUTTON.LeftButton)
    mouse(canvas, KIND.MouseButtonRelease, *place, BUTTON.LeftButton)


def ask(window, text: str, style: str = "") -> None:
    answer(type_text(text, style))
    window.workspace.actions["seal"].trigger()
    wait_for(lambda: window.sealing.seal is not None)


def test_a_seal_is_pressed_where_one_clicks_and_is_one_step(window) -> None:
    ask(window, "永", "baiwen")
    assert window.sealing.seal.style == "baiwen"
    click(window.canvas, 0.5, 0.5)
    wait_for(lambda: window.document.steps.done == ["seal"])
    settled(window)
    surface = window.document.surface
    where = surface.mesh.vertices[surface.share_painted() > 0.5]
    middle = 0.5 * (where.min(axis=0) + where.max(axis=0))
    np.testing.assert_allclose(middle, window.hand.place(), atol=1.0)
    assert np.ptp(where[:, 0]) == pytest.approx(16.0, abs=1.2)
    assert len(window.document.strokes) == 0  # the click painted nothing
    wait_for(lambda: "Seal pressed" in window.status.told.text())
    type_key(window.canvas, QtCore.Qt.Key.Key_Z, QtCore.Qt.KeyboardModifier.ControlModifier)
    wait_for(lambda: not window.document.surface.painted.any())


def test_escape_lets_it_be_and_the_next_click_paints(window) -> None:
    ask(window, "永")
    type_key(window.canvas, QtCore.Qt.Key.Key_Escape)
    assert window.sealing.seal is None
    click(window.canvas, 0.5, 0.5)
    settled(window)
    live(0.1)
    assert "seal" not in window.document.steps.done


def test_a_press_beside_the_object_turns_it_and_the_seal_waits(window) -> None:
    ask(window, "永")
    click(window.canvas, 0.02, 0.02)
    settled(window)
    assert window.sealing.seal is not None
    assert window.document.steps.done == []
    window.sealing.let_be()


@pytest.mark.parametrize("finger", ["auto", "turn"])
def test_a_finger_presses_it_too_and_paints_nothing(window, finger) -> None:
    window.canvas.finger = finger
    ask(window, "永")
    with Touching(window.canvas) as fingers:
        fingers.drag({1: places(window, (0.5, 0.5), (0.52, 0.5))})
    wait_for(lambda: window.document.steps.done == ["seal"])
    settled(window)
    assert len(window.document.strokes) == 0
    assert window.canvas.tool is None


def test_two_fingers_move_the_view_and_the_seal_waits(window) -> None:
    camera = window.hand.camera
    ask(window, "永")
    move_view(window)
    settled(window)
    assert window.hand.camera is not camera
    assert window.sealing.seal is not None
    assert window.document.steps.done == []
    window.hand.look(camera)
    window.sealing.let_be()


def test_the_rest_of_a_drag_paints_nothing_after_esc(window) -> None:
    canvas = window.canvas
    ask(window, "永")
    (x, y), end = places(window, (0.4, 0.5), (0.6, 0.5))
    mouse(canvas, KIND.MouseButtonPress, x, y, BUTTON.LeftButton, BUTTON.LeftButton)
    canvas.setFocus()
    type_key(canvas, QtCore.Qt.Key.Key_Escape)
    assert window.sealing.seal is None
    for share in np.linspace(0.1, 1.0, 8):
        mouse(canvas, KIND.MouseMove, *((1 - share) * np.array([x, y]) + share * end),
              BUTTON.NoButton, BUTTON.LeftButton)  # fmt: skip
    mouse(canvas, KIND.MouseButtonRelease, *end, BUTTON.LeftButton)
    settled(window)
    assert window.document.steps.done == []


def test_a_stroke_that_goes_on_when_it_is_asked_for_is_painted_to_its_end(window) -> None:
    canvas = window.canvas
    (x, y), end = places(window, (0.4, 0.5), (0.6, 0.5))
    mouse(canvas, KIND.MouseButtonPress, x, y, BUTTON.LeftButton, BUTTON.LeftButton)
    ask(window, "永")
    mouse(canvas, KIND.MouseMove, *end, BUTTON.NoButton, BUTTON.LeftButton)
    mouse(canvas, KIND.MouseButtonRelease, *end, BUTTON.LeftButton)
    settled(window)
    assert len(window.document.strokes) == 1
    assert not window.hand.in_stroke
    assert window.sealing.seal is not None
    window.sealing.let_be()


def test_one_tool_lets_the_other_be(window) -> None:
    drag, canvas = window.editing.drag, window.canvas
    steers = canvas.mode_at
    ask(window, "永")
    drag.begin()
    assert window.sealing.seal is None
    assert drag.is_waiting
    ask(window, "永")
    assert not drag.is_waiting
    assert canvas.mode_at == steers
    window.sealing.let_be()
    assert canvas.tool is None


def test_a_drawing_that_is_none_is_said(window, monkeypatch) -> None:
    told = []
    monkeypatch.setattr(QtWidgets.QMessageBox, "warning", lambda *words: told.append(words[-1]))
    monkeypatch.setattr(window.workspace, "quiet", False)

    def fill(dialog) -> None:
        dialog.drawing.setText("/nowhere/logo.svg")
        dialog.accept()

    answer(fill)
    window.workspace.actions["seal"].trigger()
    wait_for(lambda: told)
    assert "logo.svg" in told[0]
    assert window.sealing.seal is None

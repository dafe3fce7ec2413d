"""What the papers describe is reached in the studio's window: menus, keys, sliders, the line of
status."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.commands import COMMANDS, SHORTCUTS
from paint3d.app.model.persistence.settings import load_settings
from paint3d.app.window.object.new_dialog import NewDialog
from paint3d.app.window.questions import PreferencesDialog
from paint3d.app.window.wording import say
from paint3d.core.quaternion import matrices_from_quaternions
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    answer,
    drag,
    live,
    mouse,
    pen_stroke,
    wait_for,
)
from tests.support.app.pointers import Touching
from tests.support.app.windows import faults, opened, settled
from tests.test_papers import ROWS, WORDS

KEY = QtCore.Qt.Key
PRESSURES = [0.1, *[0.5] * 10, 0.0]


@pytest.fixture(scope="module")
def window(program):
    with faults() as found, opened(program, "plane", 2.5, "porcelain", drawn=False) as window:
        yield window
    assert found == []


def click_menu(window, menu: str, action: str) -> None:
    """Open a menu by a click on its title, and click an action."""
    bar, shown = window.menuBar(), window.commands.menus[menu]
    QtTest.QTest.mouseClick(
        bar, BUTTON.LeftButton, pos=bar.actionGeometry(shown.menuAction()).center()
    )
    wait_for(shown.isVisible)
    place = shown.actionGeometry(window.workspace.actions[action]).center()
    QtTest.QTest.mouseClick(shown, BUTTON.LeftButton, pos=place)
    settled(window)


def test_undo_in_the_menu_takes_back_stroke_after_stroke(window) -> None:
    n, kept = len(window.document.strokes), []
    for row in (0.35, 0.40, 0.45):
        kept.append(window.document.surface.amounts.sum(dtype=np.float64))
        pen_stroke(window.canvas, (0.4, row), (0.55, row), PRESSURES)
        settled(window)
    for amount in kept[::-1]:
        click_menu(window, "edit", "undo")
        assert window.document.surface.amounts.sum(dtype=np.float64) == pytest.approx(amount)
    assert len(window.document.strokes) == n
    click_menu(window, "edit", "redo")
    assert len(window.document.strokes) == n + 1


def test_a_mouse_presses_harder_while_the_key_is_held(window) -> None:
    canvas = window.canvas
    size = np.array([canvas.width(), canvas.height()])
    canvas.setFocus()
    window.hand.hand.force = 1.0
    mouse(canvas, KIND.MouseButtonPress, *(0.40, 0.55) * size, BUTTON.LeftButton, BUTTON.LeftButton)
    for k, x in enumerate(np.linspace(0.40, 0.60, 40)):
        if k == 12:
            QtTest.QTest.keyPress(canvas, KEY.Key_Period)
        mouse(canvas, KIND.MouseMove, *(x, 0.55) * size, buttons=BUTTON.LeftButton)
        live(0.02)
    QtTest.QTest.keyRelease(canvas, KEY.Key_Period)
    mouse(canvas, KIND.MouseButtonRelease, *(0.60, 0.55) * size, BUTTON.LeftButton)
    settled(window)
    pressures = [sample.pressure for sample in window.document.strokes[-1].samples]
    assert max(pressures) > 1.5 * pressures[8] > 0.0
    assert window.hand.hand.force > 1.5


def bends(window, trail: int) -> np.ndarray:
    """Directions of the bend over a stroke around a corner, with this trail of the tuft."""
    window.panels.docks["hand"].raise_()
    live(0.05)
    slider = window.panels.hand.trail
    slider.setFocus()
    QtTest.QTest.keyClick(slider, KEY.Key_Home)
    for _ in range(trail):
        QtTest.QTest.keyClick(slider, KEY.Key_Right)
    drag(window.canvas, (0.40, 0.62), (0.52, 0.62), release=False)
    size = np.array([window.canvas.width(), window.canvas.height()])
    for y in np.linspace(0.62, 0.70, 12):
        mouse(window.canvas, KIND.MouseMove, *(0.52, y) * size, buttons=BUTTON.LeftButton)
        live(0.008)
    mouse(window.canvas, KIND.MouseButtonRelease, *(0.52, 0.70) * size, BUTTON.LeftButton)
    settled(window)
    turns = np.array([sample.orientation for sample in window.document.strokes[-1].samples])
    return matrices_from_quaternions(turns)[:, :2, 0]


def test_the_trail_of_the_tuft_is_how_slowly_it_comes_round(window) -> None:
    short, long = (bends(window, steps)[-4] for steps in (0, 38))
    assert window.hand.settings.trail == pytest.approx(0.4)
    assert abs(short[1]) > abs(long[1]) + 0.1  # after a corner the long trail still points back


def test_the_line_of_status_tells_how_far_painting_is_behind(window) -> None:
    pen_stroke(window.canvas, (0.4, 0.75), (0.55, 0.75), PRESSURES)
    settled(window)
    frame, told = window.stage.frame, window.status.state
    for lag_s, waiting, wanted in (
        (0.9, 3, "is catching up with your strokes, 0.9 s"), (0.0042, 0, "keeps up, 4.2 ms"),
        (0.5, 2, "0.5 s"), (0.25, 3, "keeps up, 250"), (0.5, 2, "0.5 s"), (0.5, 0, "has caught up"),
    ):  # fmt: skip
        window.status.show(dataclasses.replace(frame, lag_s=lag_s, queue_length=waiting), 0.02)
        assert wanted in told.text()
    assert "50 pictures/s" in told.text()


def test_the_brush_size_follows_a_drag_with_its_key(window) -> None:
    canvas, length = window.canvas, window.document.painter.brush.length_mm
    canvas.setFocus()
    mouse(canvas, KIND.MouseMove, 300, 300)
    QtTest.QTest.keyPress(canvas, KEY.Key_F)
    for x in (320, 340, 360):
        mouse(canvas, KIND.MouseMove, x, 300)
    QtTest.QTest.keyRelease(canvas, KEY.Key_F)
    wait_for(lambda: window.document.painter.brush.length_mm > 1.2 * length)
    assert not window.document.in_stroke


@pytest.mark.parametrize("choice", ["turn", "paint"])
def test_one_finger_does_what_the_preferences_say(window, choice: str) -> None:
    def choose(dialog: PreferencesDialog) -> None:
        box = dialog.boxes["finger"]
        box.setCurrentIndex(box.findData(choice))
        dialog.accept()

    answer(choose)
    window.workspace.actions["preferences"].trigger()
    strokes, camera = len(window.document.strokes), window.hand.camera
    size = np.array([window.canvas.width(), window.canvas.height()])
    with Touching(window.canvas) as fingers:
        fingers.drag({1: ((0.42, 0.5) * size, (0.52, 0.5) * size)}, n=16)
    settled(window)
    assert len(window.document.strokes) - strokes == (choice == "paint")
    assert (window.hand.camera is camera) == (choice == "paint")
    assert load_settings()[0].finger == choice
    window.hand.look(camera)


def test_a_new_painting_begins_bare(window, monkeypatch) -> None:
    asked = []
    monkeypatch.setattr(window.saving, "may_leave", lambda: asked.append(True) or True)
    pen_stroke(window.canvas, (0.42, 0.5), (0.52, 0.5), PRESSURES)
    settled(window)
    assert window.document.strokes

    def choose(dialog: NewDialog) -> None:
        dialog.choose("plane")
        dialog.resolution.setValue(4.0)
        dialog.accept()

    answer(choose)
    click_menu(window, "file", "new")
    wait_for(lambda: window.document.surface.resolution == 4.0)
    settled(window)
    assert asked == [True]
    assert not window.document.strokes
    assert window.document.surface.amounts.sum() == 0.0
    assert not window.document.can_undo


@pytest.fixture(scope="module")
def shown(window) -> set[str]:
    """All that a studio with a painting shows: menus, tools, panels, preferences, list of keys."""
    dialog = PreferencesDialog(window, load_settings()[0])
    found = {say(COMMANDS[one.action].text) for one in SHORTCUTS if one.gesture != "press"}
    for root in (window, dialog):
        for action in root.findChildren(QtGui.QAction):
            found |= {action.text(), action.toolTip()}
        for widget in (root, *root.findChildren(QtWidgets.QWidget)):
            found |= {widget.toolTip(), widget.windowTitle(), widget.accessibleName()}
            if isinstance(widget, QtWidgets.QLabel | QtWidgets.QAbstractButton):
                found.add(widget.text())
            if isinstance(widget, QtWidgets.QComboBox):
                found |= {widget.itemText(k) for k in range(widget.count())}
    dialog.close()
    return found


@pytest.mark.parametrize(
    "word", sorted({word for row in ROWS.values() for word in WORDS.findall(row)})
)
def test_words_of_the_papers_page_are_seen_in_the_window(shown: set[str], word: str) -> None:
    assert word in shown

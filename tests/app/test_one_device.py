"""With a pen alone, with fingers alone, with keys alone: everything that painting needs."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.input.navigation import roll_of
from paint3d.view.camera import picture_axes
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    NO_KEY,
    PEN,
    drag,
    live,
    mouse,
    type_key,
    wait_for,
)
from tests.support.app.pointers import Touching, pen_drag, tap
from tests.support.app.windows import faults, opened, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier


@pytest.fixture(scope="module")
def window(program, tmp_path_factory):
    with opened(program, "sphere", 4.0, "porcelain", drawn=False) as window:
        assert window.saving.save_to(tmp_path_factory.mktemp("saved") / "ball.p3d")
        yield window


class ByPen:
    """Everything with a pen; on buttons and panels Qt makes a mouse of it, as it is not taken."""

    def __init__(self, window) -> None:
        self.window = window

    def drag(self, start, end) -> None:
        pen_drag(self.window.canvas, start, end)

    def press(self, widget, place: QtCore.QPoint) -> None:
        at = QtCore.QPointF(place)
        for kind, mouse_kind in (
            (KIND.TabletPress, KIND.MouseButtonPress),
            (KIND.TabletRelease, KIND.MouseButtonRelease),
        ):
            down = BUTTON.LeftButton if kind == KIND.TabletPress else BUTTON.NoButton
            event = QtGui.QTabletEvent(
                kind, PEN, at, widget.mapToGlobal(at), 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, NO_KEY,
                BUTTON.LeftButton, down,
            )  # fmt: skip
            event.ignore()
            QtWidgets.QApplication.sendEvent(widget, event)
            assert not event.isAccepted()
            mouse(widget, mouse_kind, at.x(), at.y(), BUTTON.LeftButton, down)
        live(0.03)

    def undo(self) -> None:
        self.tool("undo")

    def tool(self, name: str) -> None:
        bar = self.window.findChild(QtWidgets.QToolBar, "tools")
        button = bar.widgetForAction(self.window.workspace.actions[name])
        wait_for(button.isEnabled)
        assert button.isVisible()
        self.press(button, button.rect().center())

    def turn(self) -> None:
        self.drag((0.03, 0.1), (0.1, 0.2))

    def grip(self, name: str) -> None:
        canvas = self.window.canvas
        at = self.window.steering.grips.box(name, canvas.rect()).center()
        start = np.array([at.x() / canvas.width(), at.y() / canvas.height()])
        self.drag(start, start + np.array([0.0, 0.08]))

    def roll(self) -> None:
        self.grip("roll")

    def zoom(self) -> None:
        self.grip("dolly")

    def raise_panel(self, name: str) -> None:
        title = self.window.panels.docks[name].windowTitle()
        for bar in self.window.findChildren(QtWidgets.QTabBar):
            for k in range(bar.count()):
                if bar.tabText(k) == title:
                    self.press(bar, bar.tabRect(k).center())
                    return
        raise AssertionError(name)

    def brush(self) -> None:
        self.raise_panel("brushes")
        view = self.window.panels.brushes.findChild(QtWidgets.QListWidget)
        row = 0 if view.currentRow() else 2
        self.press(view.viewport(), view.visualItemRect(view.item(row)).center())

    def size(self) -> None:
        self.raise_panel("brushes")
        slider = self.window.panels.brushes.findChild(QtWidgets.QSlider)
        self.press(slider, QtCore.QPoint(slider.width() - 12, slider.height() // 2))

    def ink(self) -> None:
        self.raise_panel("inks")
        dishes = self.window.panels.inks.dishes
        wait_for(dishes.isVisible)
        name = next(n for n in dishes.names[:4] if n != dishes.chosen)
        self.press(dishes, dishes.box(dishes.names.index(name)).center().toPoint())

    def dip(self) -> None:
        self.tool("dip")

    def rinse(self) -> None:
        self.tool("rinse")

    def save(self) -> None:
        self.tool("save")


class ByFingers(ByPen):
    """Everything with fingers on the screen."""

    def drag(self, start, end) -> None:
        canvas = self.window.canvas
        size = np.array([canvas.width(), canvas.height()])
        with Touching(canvas) as fingers:
            fingers.drag({1: (np.array(start) * size, np.array(end) * size)})

    def press(self, widget, place: QtCore.QPoint) -> None:
        with Touching(widget) as fingers:
            fingers.set({1: (place.x(), place.y())}, wait=0.0)
        live(0.05)

    def undo(self) -> None:
        canvas = self.window.canvas
        middle = np.array([canvas.width() / 2, canvas.height() / 2])
        tap(canvas, middle, middle + 60.0)

    def roll(self) -> None:
        canvas = self.window.canvas
        a = np.array([0.4 * canvas.width(), 0.5 * canvas.height()])
        b = np.array([0.6 * canvas.width(), 0.5 * canvas.height()])
        with Touching(canvas) as fingers:
            fingers.drag({1: (a, a + np.array([20, 60])), 2: (b, b - np.array([20, 60]))})

    def zoom(self) -> None:
        canvas = self.window.canvas
        a = np.array([0.4 * canvas.width(), 0.5 * canvas.height()])
        b = np.array([0.6 * canvas.width(), 0.5 * canvas.height()])
        with Touching(canvas) as fingers:
            fingers.drag({1: (a, a - np.array([60, 0])), 2: (b, b + np.array([60, 0]))})


class ByKeys:
    """Everything with the keyboard; it goes to whatever has the focus."""

    def __init__(self, window) -> None:
        self.window = window

    def press(self, key, held=HELD.NoModifier) -> None:
        wait_for(lambda: QtWidgets.QApplication.focusWidget() is not None)
        target = QtWidgets.QApplication.focusWidget()
        type_key(target, key, held)
        live(0.03)

    def turn(self) -> None:
        self.press(KEY.Key_Left)

    def roll(self) -> None:
        self.press(KEY.Key_BracketRight, HELD.ControlModifier)

    def zoom(self) -> None:
        self.press(KEY.Key_Plus)

    def undo(self) -> None:
        wait_for(self.window.workspace.actions["undo"].isEnabled)
        self.press(KEY.Key_Z, HELD.ControlModifier)

    def brush(self) -> None:
        self.press(KEY.Key_1 if STATES["brush"](self.window) != "full" else KEY.Key_4)

    def size(self) -> None:
        self.press(KEY.Key_BracketRight)

    def ink(self) -> None:
        for _ in range(2):
            self.press(KEY.Key_F6)
        assert QtWidgets.QApplication.focusWidget() is self.window.panels.inks.dishes
        for key in (KEY.Key_Right, KEY.Key_Down, KEY.Key_Return, KEY.Key_Escape):
            self.press(key)
        assert QtWidgets.QApplication.focusWidget() is self.window.canvas

    def dip(self) -> None:
        self.press(KEY.Key_D)

    def rinse(self) -> None:
        self.press(KEY.Key_R)

    def save(self) -> None:
        self.press(KEY.Key_S, HELD.ControlModifier)


def far(window) -> float:
    camera = window.hand.camera
    return float(np.linalg.norm(camera.position - camera.focus))


STATES = {
    "turn": lambda window: tuple(picture_axes(window.hand.camera)[2].round(4)),
    "roll": lambda window: round(roll_of(window.hand.camera), 3),
    "zoom": lambda window: round(far(window), 1),
    "undo": lambda window: len(window.document.strokes),
    "brush": lambda window: window.document.painter.brush.name.split(" @")[0],
    "size": lambda window: window.document.painter.brush.length_mm,
    "ink": lambda window: window.document.inks[0],
    "dip": lambda window: float(window.document.surface.ink.load.sum()),
    "rinse": lambda window: bool(window.document.surface.ink.load.sum() > 0.0),
    "save": lambda window: window.document.modified,
}


@pytest.mark.parametrize("what", STATES)
@pytest.mark.parametrize("by", [ByPen, ByFingers, ByKeys])
def test_every_way_alone_is_enough(window, by, what) -> None:
    window.hand.show_all()
    window.canvas.pen_seen_ns = None
    window.activateWindow()
    window.canvas.setFocus()
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    settled(window)
    wait_for(lambda: not window.panels.brushes.is_settling)
    window.workspace.post("wipe" if what == "dip" else "dip")
    settled(window)
    live(0.05)
    state = STATES[what]
    before = state(window)
    with faults() as found:
        getattr(by(window), what)()
        wait_for(lambda: state(window) != before)
        settled(window)
    assert found == []
    if what == "save":
        assert "ball.p3d" in window.status.message_label.text()


# -- menus by keys -----------------------------------------------------------------------------


@pytest.fixture
def menus(window):
    window.canvas.setFocus()
    for _ in range(5):  # where the machine is busy, what was asked before may close it at once
        settled(window)
        press(window, KEY.Key_F10)
        live(0.5)
        if open_menu() is not None:
            break
    assert open_menu() is not None
    yield list(window.commands.menus.values())
    while open_menu() is not None:
        open_menu().close()
    window.menuBar().setActiveAction(None)
    window.canvas.setFocus()
    live(0.1)


def press(window, key) -> None:
    """Press a key as the system hands it over: to the window that has the keyboard."""
    QtTest.QTest.keyClick(window.windowHandle(), key)
    live(0.05)


def open_menu() -> QtWidgets.QMenu | None:
    return QtWidgets.QApplication.activePopupWidget()


def test_arrows_go_from_menu_to_menu_and_leave_the_view(window, menus) -> None:
    camera = window.hand.camera
    for menu in (*menus[1:], menus[0], menus[1]):
        press(window, KEY.Key_Right)
        assert open_menu() is menu
    press(window, KEY.Key_Left)
    assert open_menu() is menus[0]
    assert np.array_equal(window.hand.camera.position, camera.position)


def test_what_is_pressed_in_a_menu_is_not_meant_for_brush_and_picture(window, menus) -> None:
    brush, camera = window.document.painter.brush, window.hand.camera
    for key in (KEY.Key_4, KEY.Key_BracketRight, KEY.Key_F, KEY.Key_Period):
        press(window, key)
    settled(window)
    assert open_menu() is menus[0]
    assert window.document.painter.brush == brush
    assert not window.hand.held
    assert np.array_equal(window.hand.camera.position, camera.position)

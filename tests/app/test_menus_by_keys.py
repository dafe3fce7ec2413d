"""With keys alone: every menu is reached, and what is pressed in it does not reach the picture."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from tests.support.app.gestures import live, wait_for
from tests.support.app.windows import opened, settled

KEY = QtCore.Qt.Key


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sphere", 4.0, "porcelain") as window:
        yield window


@pytest.fixture
def menus(window):
    window.canvas.setFocus()
    press(window, KEY.Key_F10)
    wait_for(lambda: open_menu() is not None)
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

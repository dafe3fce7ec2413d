"""In a low window nothing of the inks is cut off, whatever is stirred, by real events."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from tests.support.app.gestures import BUTTON, live, wait_for
from tests.support.app.windows import opened

SIZES = [(1280, 800), (1366, 768), (1024, 640), (1093, 614)]
"""Of screens, the last two as a scale of 1.25 leaves them of the first."""


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 3.0, "xuan", drawn=False) as window:
        window.panels.docks["inks"].raise_()
        yield window


def stir(window, name: str) -> None:
    dishes = window.panels.inks.dishes
    place = dishes.box(dishes.names.index(name)).center().toPoint()
    QtTest.QTest.mouseClick(dishes, BUTTON.RightButton, pos=place)


@pytest.mark.parametrize("size", SIZES)
def test_mixing_dish_and_all_below_it_are_seen_whole(window, size) -> None:
    panel, area = window.panels.inks, window.panels.docks["inks"].widget()
    panel.empty()
    window.resize(*size)
    wait_for(lambda: (window.width(), window.height()) == size)
    for name in ("cinnabar", "pine soot", "azurite"):
        stir(window, name)
    panel.water.setValue(40)
    QtTest.QTest.mouseClick(button(panel, "Dip"), BUTTON.LeftButton)
    wait_for(lambda: panel.last.buttons[0].isVisible())
    live(0.1)
    seen = QtCore.QRect(QtCore.QPoint(), area.viewport().size())
    direct = QtCore.Qt.FindChildOption.FindDirectChildrenOnly
    for widget in panel.findChildren(QtWidgets.QWidget, options=direct):
        if widget.isVisible():
            box = QtCore.QRect(widget.mapTo(area.viewport(), QtCore.QPoint()), widget.size())
            assert seen.contains(box), f"{widget.objectName() or widget} at {box} of {seen}"
    assert panel.fold.isChecked() == (size[1] >= 750)
    assert panel.pickup.isVisible() == panel.fold.isChecked()


def test_no_panel_that_scrolls_is_wider_than_what_shows_it(window) -> None:
    window.resize(1024, 640)
    for dock in window.panels.docks.values():
        area = dock.widget()
        if isinstance(area, QtWidgets.QScrollArea):
            dock.raise_()
            live(0.05)
            if dock.isVisible():
                assert area.widget().width() <= area.viewport().width(), dock.objectName()
    window.panels.docks["inks"].raise_()


def test_what_is_folded_away_is_reached_by_a_click_and_stays(window) -> None:
    panel, area = window.panels.inks, window.panels.docks["inks"].widget()
    window.resize(1024, 640)
    wait_for(lambda: not panel.pickup.isVisible())
    QtTest.QTest.mouseClick(panel.fold, BUTTON.LeftButton)
    wait_for(panel.pickup.isVisible)
    wait_for(lambda: area.verticalScrollBar().maximum() > 0)
    area.ensureWidgetVisible(panel.pickup)
    box = QtCore.QRect(panel.pickup.mapTo(area.viewport(), QtCore.QPoint()), panel.pickup.size())
    assert area.viewport().rect().contains(box)
    window.resize(1024, 700)
    live(0.1)
    assert panel.pickup.isVisible(), "who unfolded it wants it"


def click_tab(window, text: str) -> None:
    """Click the tab of a panel."""
    for bar in window.findChildren(QtWidgets.QTabBar):
        for k in range(bar.count()):
            if bar.tabText(k) == text and bar.isVisible():
                QtTest.QTest.mouseClick(bar, BUTTON.LeftButton, pos=bar.tabRect(k).center())


def test_a_panel_gets_the_height_that_it_needs_where_its_tab_is_clicked(window) -> None:
    window.resize(1280, 800)
    live(0.1)
    copybook, inks = window.panels.docks["copybook"], window.panels.docks["inks"]
    before = window.panels.docks["layers"].height()
    click_tab(window, "Text and seal")
    wait_for(lambda: copybook.height() > before + 200)
    click_tab(window, "Hand")
    click_tab(window, "Inks")
    wait_for(lambda: inks.widget().verticalScrollBar().maximum() == 0)
    click_tab(window, "Text and seal")
    wait_for(lambda: copybook.height() > before + 200)
    low = inks.height()
    click_tab(window, "Inks")  # which is shown already
    wait_for(lambda: inks.height() > low + 50)


def button(panel, text: str) -> QtWidgets.QPushButton:
    return next(b for b in panel.findChildren(QtWidgets.QPushButton) if b.text() == text)


def turn_wheel(widget: QtWidgets.QWidget) -> None:
    """One click of the wheel down over a widget; what does not take it hands it on."""
    middle = QtCore.QPointF(widget.rect().center())
    event = QtGui.QWheelEvent(
        middle, widget.mapToGlobal(middle), QtCore.QPoint(), QtCore.QPoint(0, -120),
        BUTTON.NoButton, QtCore.Qt.KeyboardModifier.NoModifier,
        QtCore.Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QtWidgets.QApplication.sendEvent(widget, event)


def test_a_wheel_that_scrolls_a_panel_changes_no_number_in_it(window) -> None:
    window.panels.docks["copybook"].raise_()
    window.resize(1024, 640)
    panel = window.panels.copybook
    number = panel.findChild(QtWidgets.QDoubleSpinBox)
    wait_for(number.isVisible)
    window.canvas.setFocus()
    before = number.value()
    turn_wheel(number)
    assert number.value() == before
    number.setFocus()
    wait_for(number.hasFocus)
    turn_wheel(number)
    assert number.value() != before


def test_brushes_have_room_again_where_another_panel_was_shown(window) -> None:
    window.resize(1280, 800)
    brushes = window.panels.brushes._list
    for text in ("Inks", "Hand", "Brushes"):
        click_tab(window, text)
        live(0.1)
    assert brushes.viewport().height() >= 7.5 * brushes.sizeHintForRow(0)
    window.panels.docks["inks"].raise_()

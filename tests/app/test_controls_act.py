"""Nothing is shown for brush and surface that does nothing: every control is turned by hand."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.persistence.settings import Settings
from paint3d.app.window.object.material_box import MaterialBox
from paint3d.app.window.studio import StudioWindow
from tests.support.app.gestures import answer, drag, live, wait_for
from tests.support.app.windows import close_unasked, pretend_saved, settled

WITHOUT_EFFECT = {
    "Edit…": "opens the editor, whose controls are turned by themselves below",
    "Open…": "asks for a file of a brush",
    "Paint anew at another detail": "asks how fine the surface is to be",
}
"""What a control says (its words, or its object's name), and why it changes nothing that is
painted, seen or felt."""
TURNED = (
    QtWidgets.QAbstractSlider,
    QtWidgets.QAbstractSpinBox,
    QtWidgets.QComboBox,
    QtWidgets.QAbstractButton,
    QtWidgets.QAbstractItemView,
)
KEY = QtCore.Qt.Key


@pytest.fixture
def window(program):
    window = StudioWindow(program, Settings(material="xuan", wet=False))
    window.resize(1280, 800)
    window.show()
    window.workspace.quiet = True
    assert window.opening.open_path("plane", 2.0, "xuan", asked=True)
    wait_for(lambda: window.stage.is_lit)
    yield window
    close_unasked(window)


def controls(panel: QtWidgets.QWidget) -> list[QtWidgets.QWidget]:
    """What can be turned in a panel, as it is laid out; parts of controls and bars left out."""
    found = []
    for widget in panel.findChildren(QtWidgets.QWidget):
        if not isinstance(widget, TURNED) or isinstance(widget, QtWidgets.QScrollBar):
            continue
        around = widget.parent()
        while around is not panel and not isinstance(around, TURNED):
            around = around.parent()
        if around is panel and not widget.isHidden():
            found.append(widget)
    return found


def words(widget: QtWidgets.QWidget) -> str:
    """What a control is called in messages."""
    text = getattr(widget, "text", None)
    told = text() if callable(text) and not isinstance(widget, QtWidgets.QComboBox) else ""
    return told or widget.objectName() or type(widget).__name__


def turn(widget: QtWidgets.QWidget) -> None:
    """Another value, by the keyboard or the mouse."""
    widget.setFocus()
    if isinstance(widget, QtWidgets.QAbstractButton):
        QtTest.QTest.mouseClick(widget, QtCore.Qt.MouseButton.LeftButton)
    elif isinstance(widget, QtWidgets.QAbstractSlider):
        at_end = widget.value() == widget.maximum()
        for _ in range(20):
            QtTest.QTest.keyClick(widget, KEY.Key_Left if at_end else KEY.Key_Right)
    elif isinstance(widget, QtWidgets.QAbstractItemView):
        QtTest.QTest.keyClick(widget, KEY.Key_Down)
        QtTest.QTest.keyClick(widget, KEY.Key_Return)
    else:
        at_end = isinstance(widget, QtWidgets.QComboBox) and (
            widget.currentIndex() == widget.count() - 1
        )
        QtTest.QTest.keyClick(widget, KEY.Key_Up if at_end else KEY.Key_Down)
    live(0.3)  # sliders settle


def state(window: StudioWindow) -> tuple[object, ...]:
    """All that brush and surface are, and what lies on it."""
    wait_for(lambda: not window.panels.brushes.is_settling)
    settled(window)
    with window.stage.paint_thread.paused() as document:
        assert document is not None
        surface, painter = document.surface, document.painter
        return (
            painter.brush,
            painter.hairs is None,
            surface.material,
            surface.n_vertices,
            surface.amounts.tobytes(),
            surface.flow_patience == math.inf,  # dry
            window.workspace.actions["wet"].isChecked(),
        )


def paint_something(window: StudioWindow) -> None:
    """A stroke in wet ink."""
    drag(window.canvas, (0.42, 0.5), (0.58, 0.5))
    settled(window)
    assert window.document.strokes


def turn_all(window: StudioWindow, name: str) -> list[str]:
    """Turn every control of a panel, each by itself; what was turned."""
    panel, turned = getattr(window.panels, name), []
    window.panels.docks[name].raise_()
    live(0.1)
    # what begins anew comes last: it takes the paint away that others act on
    for widget in sorted(controls(panel), key=lambda widget: isinstance(widget, MaterialBox)):
        if words(widget) in WITHOUT_EFFECT:
            continue
        assert widget.isEnabled(), f"{words(widget)} of {name} cannot be turned"
        if isinstance(widget, MaterialBox):
            pretend_saved(window.stage.paint_thread)
            answer(lambda box: next(b for b in box.buttons() if "anew" in b.text()).click())
        before = state(window)
        live(0.2)
        assert state(window) == before, f"something else changes before {words(widget)}"
        turn(widget)
        assert state(window) != before, f"{words(widget)} of {name} does nothing"
        if isinstance(widget, QtWidgets.QAbstractButton) and widget.isCheckable():
            turn(widget)
        turned.append(words(widget))
    return turned


def test_every_control_of_brush_and_surface_acts(window) -> None:
    paint_something(window)
    assert len(turn_all(window, "brushes")) >= 2
    assert len(turn_all(window, "surface")) >= 4


def test_every_control_of_the_brush_editor_acts(window) -> None:
    """On the brush that it makes; that every parameter acts is held by `tests/laws`."""
    window.findChild(QtWidgets.QPushButton, "edit_brush").click()
    editor = window.brushes.editor
    editor.activateWindow()  # or the picture's shortcuts take its keys
    wait_for(editor.isActiveWindow)
    editor.single.click()  # hairs, or theirs could not be turned
    assert editor.brush.bristles is not None
    found = [editor.hair, editor.table, *(row.slider for row in editor.rows.values())]
    for page in range(editor.tabs.count()):
        editor.tabs.setCurrentIndex(page)
        live(0.05)
        for widget in [widget for widget in found if widget.isVisible()]:
            found.remove(widget)
            assert widget.isEnabled()
            before = editor.brush
            if isinstance(widget, QtWidgets.QSlider):  # some stand for whole numbers
                widget.setFocus()
                at_end = widget.value() == widget.maximum()
                QtTest.QTest.keyClick(widget, KEY.Key_Home if at_end else KEY.Key_End)
            else:
                turn(widget)
            idle = f"the one before {len(found)} others does nothing"
            wait_for(lambda before=before: editor.brush != before, fault=idle)
    assert found == []
    editor.close()


def test_a_control_that_does_nothing_is_found(window) -> None:
    slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
    slider.setObjectName("nothing")
    window.panels.brushes.layout().addWidget(slider)
    live(0.1)
    with pytest.raises(AssertionError, match="nothing of brushes does nothing"):
        turn_all(window, "brushes")


def test_what_is_left_out_is_shown(window) -> None:
    there = {
        words(widget)
        for name in ("brushes", "surface")
        for widget in controls(getattr(window.panels, name))
    }
    assert set(WITHOUT_EFFECT) <= there


def test_return_takes_what_is_chosen_in_an_open_list(window) -> None:
    """And arrows there turn no view."""
    window.panels.docks["copybook"].raise_()
    box, camera = window.panels.copybook.grid_box, window.hand.open_camera
    was = box.currentIndex()
    box.showPopup()
    wait_for(lambda: QtWidgets.QApplication.activePopupWidget() is not None)
    for key in (KEY.Key_Down, KEY.Key_Return):
        QtTest.QTest.keyClick(box.view(), key)
    wait_for(lambda: QtWidgets.QApplication.activePopupWidget() is None, 10.0)
    assert box.currentIndex() == was + 1
    assert window.hand.open_camera is camera

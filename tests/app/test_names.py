"""What can have the keys says what it is, for those who hear the window instead of seeing it."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from tests.support.app.windows import opened


def name_of(widget: QtWidgets.QWidget) -> str:
    """What a screen reader says of a widget: Qt has it from its name, its text or its label."""
    interface = QtGui.QAccessible.queryAccessibleInterface(widget)
    return interface.text(QtGui.QAccessible.Text.Name) if interface is not None else ""


def test_all_that_takes_keys_has_a_name(program) -> None:
    with opened(program, "plane", 8.0, "porcelain", drawn=False) as window:
        tab = QtCore.Qt.FocusPolicy.TabFocus
        nameless = []
        for widget in [window.canvas, *window.findChildren(QtWidgets.QWidget)]:
            inner = widget.objectName().startswith("qt_") or isinstance(
                widget, QtWidgets.QScrollArea | QtWidgets.QMenuBar | QtWidgets.QMenu
            )
            parent = widget.parentWidget()
            part = isinstance(
                parent,
                QtWidgets.QAbstractSpinBox | QtWidgets.QComboBox | QtWidgets.QAbstractItemView,
            )
            part = part or widget.window() is not window  # the list that a box opens
            if widget.focusPolicy() & tab and not inner and not part and not name_of(widget):
                where = [dock.windowTitle() for dock in window.panels.docks.values()
                         if dock.isAncestorOf(widget)]  # fmt: skip
                nameless.append((type(widget).__name__, widget.objectName(), *where))
        assert not nameless, "\n".join(map(str, nameless))

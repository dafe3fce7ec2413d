"""Small dialogs with a row for each question."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.wording import say

__all__ = ["FormDialog", "SizeBoxes", "buttons", "leave_wheel_to_scrolling", "stored_number"]

LEAST_PIXELS, MOST_PIXELS = 64, 4096


def buttons(dialog: QtWidgets.QDialog, accept: str) -> QtWidgets.QDialogButtonBox:
    """Return buttons: OK, by another name, and Cancel."""
    standard = QtWidgets.QDialogButtonBox.StandardButton
    box = QtWidgets.QDialogButtonBox(standard.Ok | standard.Cancel)
    box.button(standard.Ok).setText(accept)
    box.button(standard.Cancel).setText(say("Cancel"))
    box.accepted.connect(dialog.accept)
    box.rejected.connect(dialog.reject)
    return box


def stored_number(stored: Mapping[str, object], name: str, default: float) -> float:
    """Return a number stored under a name; the default where there is none."""
    value = stored.get(name)
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        return default
    return float(value)


class _WithoutWheel(QtCore.QObject):
    """Leaves the wheel to the area around a number or a list without the focus."""

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Ignore a wheel over a widget without the focus, so that its parent gets it."""
        if event.type() != QtCore.QEvent.Type.Wheel or watched.hasFocus():  # type: ignore[attr-defined]
            return False
        event.ignore()
        return True


def leave_wheel_to_scrolling(parent: QtWidgets.QWidget) -> None:
    """Keep a wheel that scrolls over a panel's numbers, sliders and lists from changing them."""
    guard = _WithoutWheel(parent)
    for kind in (QtWidgets.QAbstractSpinBox, QtWidgets.QComboBox, QtWidgets.QSlider):
        for child in parent.findChildren(kind):
            if child.focusPolicy() == QtCore.Qt.FocusPolicy.WheelFocus:
                child.setFocusPolicy(QtCore.Qt.FocusPolicy.StrongFocus)
            child.installEventFilter(guard)


class FormDialog(QtWidgets.QDialog):
    """A dialog whose rows are added to `form`; close it with `finish`.

    Parameters
    ----------
    parent : QWidget
    title : str
    beside : bool
        Whether the rows stand in `rows`, a widget to be laid out beside something else.
    """

    def __init__(self, parent: QtWidgets.QWidget, title: str, *, beside: bool = False) -> None:
        super().__init__(parent)
        self.setWindowTitle(title)
        self.rows = QtWidgets.QWidget(self) if beside else self
        self.form = QtWidgets.QFormLayout(self.rows)
        self.form.setContentsMargins(18, 16, 18, 14)
        self.form.setVerticalSpacing(10)

    def finish(self, accept: str) -> None:
        """Put the buttons below."""
        self.form.addRow(buttons(self, accept))

    def add_box(
        self, label: str, choices: Mapping[Any, str], chosen: object
    ) -> QtWidgets.QComboBox:
        """Add a row to choose one of several: texts by their values."""
        box = QtWidgets.QComboBox()
        for value, text in choices.items():
            box.addItem(text, value)
        box.setCurrentIndex(max(0, list(choices).index(chosen) if chosen in choices else 0))
        self.form.addRow(label, box)
        return box

    def add_number(
        self, label: str, low: float, high: float, value: float, unit: str = "", digits: int = 0
    ) -> QtWidgets.QDoubleSpinBox:
        """Add a row for a number."""
        box = QtWidgets.QDoubleSpinBox()
        box.setDecimals(digits)
        box.setRange(low, high)
        box.setSuffix(f" {unit}" if unit else "")
        box.setValue(value)
        self.form.addRow(label, box)
        return box

    def add_check(self, text: str, on: bool) -> QtWidgets.QCheckBox:
        """Add a row for yes or no."""
        box = QtWidgets.QCheckBox(text)
        box.setChecked(on)
        self.form.addRow("", box)
        return box


class SizeBoxes(QtWidgets.QWidget):
    """Width and height of a picture, pixels; by default in the screen's proportions."""

    def __init__(self, size: tuple[int, int], proportions: tuple[int, int]) -> None:
        super().__init__()
        self._ratio = proportions[1] / proportions[0]
        row = QtWidgets.QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        self.width_box, self.height_box = QtWidgets.QSpinBox(), QtWidgets.QSpinBox()
        for box, value in ((self.width_box, size[0]), (self.height_box, size[1])):
            box.setRange(LEAST_PIXELS, MOST_PIXELS)
            box.setSingleStep(16)
            box.setValue(value)
        self.keeps_ratio = QtWidgets.QCheckBox(say("In proportion"))
        self.keeps_ratio.setChecked(abs(size[1] - self._ratio * size[0]) <= 1.0)
        row.addWidget(self.width_box)
        row.addWidget(QtWidgets.QLabel("×"))
        row.addWidget(self.height_box)
        row.addWidget(self.keeps_ratio)
        self.width_box.valueChanged.connect(lambda n: self._follow(self.height_box, n, self._ratio))
        self.height_box.valueChanged.connect(
            lambda n: self._follow(self.width_box, n, 1.0 / self._ratio)
        )

    def _follow(self, box: QtWidgets.QSpinBox, pixels: int, ratio: float) -> None:
        if self.keeps_ratio.isChecked():
            box.blockSignals(True)
            box.setValue(round(pixels * ratio))
            box.blockSignals(False)

    def size_in_pixels(self) -> tuple[int, int]:
        """Return width and height."""
        return self.width_box.value(), self.height_box.value()

"""A number to be chosen: what it is, a slider, a box with its unit, and between what it may lie."""

from __future__ import annotations

import math

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.wording import say

__all__ = ["NumberRow"]

_STEPS = 1000
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_DIGITS = 3  # significant, of the narrower end of a range


class NumberRow(QtCore.QObject):
    """One row of a grid.

    Parameters
    ----------
    grid : QGridLayout
        Where it is put, below what is there.
    name : str
        Which number; said with a change.
    label : (str, str)
        What it is called, and what its tool tip says.
    unit : str
    whole : bool
        Whether only whole numbers can be chosen.
    even : bool
        Whether the slider goes in even steps; if not, in even ratios.

    Signals
    -------
    changed : (str, float)
        Chosen by hand.
    """

    changed = QtCore.Signal(str, float)

    def __init__(
        self,
        grid: QtWidgets.QGridLayout,
        name: str,
        label: tuple[str, str],
        unit: str = "",
        *,
        whole: bool = False,
        even: bool = True,
    ) -> None:
        super().__init__(grid)
        self.name, self._whole, self._even = name, whole, even
        self._low, self._high, self._shown = 0.0, 1.0, 0.0
        self.label = QtWidgets.QLabel(say(label[0]))
        self.slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        self.slider.setRange(0, _STEPS)
        self.slider.setMinimumWidth(90)
        self.box = _PlainBox()
        self.box.setObjectName(name)
        self.box.setKeyboardTracking(False)
        self.box.setSuffix(f" {unit}" if unit else "")
        self.box.setMinimumWidth(96)
        self.range = QtWidgets.QLabel()
        self.range.setObjectName("faint")
        for widget in (self.label, self.slider, self.box):
            widget.setToolTip(label[1])
        self.slider.setAccessibleName(say(label[0]))
        self.box.setAccessibleName(say(label[0]))
        row = grid.rowCount()
        for column, one in enumerate((self.label, self.slider, self.box, self.range)):
            grid.addWidget(one, row, column)
        self.slider.valueChanged.connect(self._slid)
        self.box.valueChanged.connect(self._typed)

    def show_value(self, value: float, low: float, high: float) -> None:
        """Show a value and between what it may lie, and tell nothing."""
        self._low, self._high, self._shown = low, high, value
        digits = 0 if self._whole else _digits_for(low, high, self._even)
        with QtCore.QSignalBlocker(self.slider), QtCore.QSignalBlocker(self.box):
            self.box.setDecimals(digits)
            self.box.setRange(low, high)
            self.box.setSingleStep(1.0 if self._whole else 10.0 ** (1 - digits))
            self.box.setValue(value)
            self.slider.setValue(round(_STEPS * self._share(value)))
        self.range.setText(f"{_told(low)} – {_told(high)}")

    def enable(self, on: bool) -> None:
        """Let it be chosen, or not."""
        for widget in (self.label, self.slider, self.box, self.range):
            widget.setEnabled(on)

    def _share(self, value: float) -> float:
        low, high = self._low, self._high
        if self._even:
            return (value - low) / (high - low)
        return math.log(value / low) / math.log(high / low)

    def _slid(self, step: int) -> None:
        share = step / _STEPS
        low, high = self._low, self._high
        value = low + share * (high - low) if self._even else low * (high / low) ** share
        self._say(min(max(float(f"{value:.4g}"), low), high))

    def _typed(self, value: float) -> None:
        self._say(min(max(value, self._low), self._high))

    def _say(self, value: float) -> None:
        value = float(round(value)) if self._whole else value
        if value != self._shown:
            self.changed.emit(self.name, value)


class _PlainBox(QtWidgets.QDoubleSpinBox):
    """Shows no zeros behind the last digit that says something."""

    def textFromValue(self, value: float) -> str:
        """The number as it is shown."""
        text = super().textFromValue(value)
        point = self.locale().decimalPoint()
        return text.rstrip("0").removesuffix(point) if point in text else text


def _told(number: float) -> str:
    """An end of a range: three digits; powers of ten below a thousandth and from a million on."""
    if number != 0.0 and not 1e-3 <= abs(number) < 1e6:
        digits, power = f"{number:.2e}".split("e")
        digits = digits.rstrip("0").rstrip(".")
        return f"{'' if digits == '1' else digits + '·'}10{str(int(power)).translate(_RAISED)}"
    return f"{number:.3g}" if abs(number) < 1e3 else f"{number:.0f}"


def _digits_for(low: float, high: float, even: bool) -> int:
    """How many decimals tell values of a range apart."""
    span = high - low if even else low
    return min(max(_DIGITS - 1 - math.floor(math.log10(max(span, 1e-9))), 0), 7)

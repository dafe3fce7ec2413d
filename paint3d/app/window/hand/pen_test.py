"""A page to try a pen on: what it reports, and what the pressure curve makes of it."""

from __future__ import annotations

import math
from collections import deque

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.app.window.hand.canvas import touch_of_tablet
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say

__all__ = ["PenPad", "PenTestDialog"]

_WIDEST_PX = 14.0  # half the width of a line at full pressure
_EVENTS = 128  # that the rate is measured over
_PAUSE_MS = 300  # between two events: the pen was away
_NS_PER_MS = 1_000_000
_ERASER = QtGui.QPointingDevice.PointerType.Eraser
_DEG = 180.0 / math.pi


class PenPad(QtWidgets.QWidget):
    """A sheet that shows a pen's position, pressure and tilt.

    Signals
    -------
    received : ()
        An event has come; the attributes describe it.

    Attributes
    ----------
    device : str
        Name of the last device; empty before.
    is_mouse : bool
        Whether it was a mouse, or a pen whose driver makes one of it.
    pressure, least, most : float
        Now, and so far while it touched; 0 to 1, as the pen reports it.
    tilts, turn : (float, float), float
        Degrees from upright to the right and towards the hand; degrees about its own axis.
    leaned, turned : bool
        Whether these were ever other than 0.
    is_eraser : bool
    buttons : int
        Down now, bit by bit.
    """

    received = QtCore.Signal()

    def __init__(self, theme: Theme, curve: PressureCurve) -> None:
        super().__init__()
        self._theme, self._curve = theme, curve
        self._times: deque[int] = deque(maxlen=_EVENTS)
        self._position: QtCore.QPointF | None = None
        self._down = False
        self._picture = QtGui.QImage()
        self.setMinimumSize(420, 300)
        self.setAccessibleName(say("A sheet to try the pen on"))
        self.setCursor(QtCore.Qt.CursorShape.CrossCursor)
        self.setMouseTracking(True)
        self.clear()

    def clear(self) -> None:
        """Take a new sheet, and forget all events."""
        self.device, self.is_mouse, self.is_eraser, self.buttons = "", False, False, 0
        self.pressure, self.least, self.most = 0.0, 1.0, 0.0
        self.tilts, self.turn, self.leaned, self.turned = (0.0, 0.0), 0.0, False, False
        self._times.clear()
        self._picture.fill(QtGui.QColor(self._theme.field))
        self.update()

    def rate(self) -> float:
        """Return the events a second while the pen moved last; 0 before there are enough."""
        if len(self._times) < 8 or self._times[-1] <= self._times[0]:
            return 0.0
        return 1000.0 * (len(self._times) - 1) / (self._times[-1] - self._times[0])

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Copy the drawing to the new size."""
        larger = QtGui.QImage(self.size(), QtGui.QImage.Format.Format_RGB32)
        larger.fill(QtGui.QColor(self._theme.field))
        painter = QtGui.QPainter(larger)
        painter.drawImage(0, 0, self._picture)
        painter.end()
        self._picture = larger

    def tabletEvent(self, event: QtGui.QTabletEvent) -> None:
        """Draw with the pen, as wide as the curve makes its pressure."""
        event.accept()
        touch = touch_of_tablet(event, event.timestamp() * _NS_PER_MS)
        self._note_event(event.pointingDevice().name(), event.timestamp(), mouse=False)
        pressure = self.pressure = touch.pressure or 0.0
        self.tilts = touch.tilt_x * _DEG, touch.tilt_y * _DEG
        self.turn = touch.twist * _DEG
        self.leaned |= self.tilts != (0.0, 0.0)
        self.turned |= self.turn != 0.0
        self.is_eraser = event.pointerType() == _ERASER
        self.buttons = event.buttons().value
        if touch.down and pressure > 0.0:
            self.least, self.most = min(self.least, pressure), max(self.most, pressure)
        self._draw_to(event.position(), touch.down, self._curve(pressure))

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Draw with a mouse, which reports no pressure."""
        down = bool(event.buttons() & QtCore.Qt.MouseButton.LeftButton)
        self._note_event(event.pointingDevice().name(), event.timestamp(), mouse=True)
        self.pressure, self.is_eraser, self.buttons = 0.0, False, event.buttons().value
        self._draw_to(event.position(), down, 0.15)

    mouseMoveEvent = mouseReleaseEvent = mousePressEvent

    def _note_event(self, device: str, time_ms: int, *, mouse: bool) -> None:
        if self._times and not 0 <= time_ms - self._times[-1] < _PAUSE_MS:
            self._times.clear()
        self._times.append(time_ms)
        self.device, self.is_mouse = device, mouse

    def _draw_to(self, position: QtCore.QPointF, down: bool, strength: float) -> None:
        if down:
            painter = QtGui.QPainter(self._picture)
            painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
            colour = self._theme.accent if self.is_eraser else self._theme.text
            pen = QtGui.QPen(QtGui.QColor(colour), max(1.0, 2.0 * _WIDEST_PX * strength))
            pen.setCapStyle(QtCore.Qt.PenCapStyle.RoundCap)
            painter.setPen(pen)
            start = self._position if self._down and self._position is not None else position
            painter.drawLine(start, position)
            painter.end()
        self._position, self._down = position, down
        self.update()
        self.received.emit()

    def leaveEvent(self, event: QtCore.QEvent) -> None:
        """Remove the pen's picture."""
        self._position = None
        self.update()

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw the sheet, and the pen on it with its tilt and its side."""
        painter = QtGui.QPainter(self)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        painter.drawImage(0, 0, self._picture)
        painter.setPen(QtGui.QPen(QtGui.QColor(self._theme.line), 1))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))
        if self._position is not None and not self.is_mouse:
            across, along = (math.sin(angle / _DEG) for angle in self.tilts)
            end = self._position + QtCore.QPointF(90.0 * across, 90.0 * along)
            painter.setPen(QtGui.QPen(QtGui.QColor(self._theme.good), 3))
            painter.drawLine(self._position, end)
            painter.drawEllipse(self._position, 6.0, 6.0)
            if self.turned:
                angle = self.turn / _DEG
                side = QtCore.QPointF(14.0 * math.sin(angle), -14.0 * math.cos(angle))
                painter.drawLine(end, end + side)
        painter.end()


class PenTestDialog(QtWidgets.QDialog):
    """Tries a pen: a sheet to draw on, and what it reports in numbers."""

    def __init__(self, parent: QtWidgets.QWidget, theme: Theme, curve: PressureCurve) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Test the pen"))
        self.pad = PenPad(theme, curve)
        self.pad.received.connect(self._show)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setWordWrap(True)
        self.message_label.setMinimumWidth(420)
        self.rows: dict[str, QtWidgets.QLabel] = {}
        form = QtWidgets.QFormLayout()
        for name, text in (
            ("device", say("Device")),
            ("end", say("End")),
            ("pressure", say("Pressure")),
            ("lean", say("Tilt")),
            ("turn", say("Rotation")),
            ("buttons", say("Buttons")),
            ("rate", say("Events a second")),
        ):
            self.rows[name] = QtWidgets.QLabel()
            form.addRow(text, self.rows[name])
        clear = QtWidgets.QPushButton(say("New sheet"))
        clear.clicked.connect(self._begin_anew)
        leave = QtWidgets.QPushButton(say("Close"))
        leave.setDefault(True)
        leave.clicked.connect(self.accept)
        row = QtWidgets.QHBoxLayout()
        row.addStretch(1)
        row.addWidget(clear)
        row.addWidget(leave)
        column = QtWidgets.QVBoxLayout(self)
        column.addWidget(self.message_label)
        column.addWidget(self.pad, 1)
        column.addLayout(form)
        column.addLayout(row)
        self._show()

    def _begin_anew(self) -> None:
        self.pad.clear()
        self._show()

    def _show(self) -> None:
        pad, rows = self.pad, self.rows
        self.message_label.setText(self._verdict())
        rows["device"].setText(pad.device or "–")
        eraser = say("the eraser") if pad.is_eraser else say("the tip")
        rows["end"].setText(eraser if pad.device and not pad.is_mouse else "–")
        pressure = say("none") if pad.is_mouse else f"{100.0 * pad.pressure:.0f} %"
        if pad.most > 0.0:
            pressure += "   " + say(
                "so far {least:.1f} to {most:.1f} %", least=100 * pad.least, most=100 * pad.most
            )
        rows["pressure"].setText(pressure if pad.device else "–")
        rows["lean"].setText(self._tilt_text() if pad.leaned else "–")
        rows["turn"].setText(f"{pad.turn:.0f}°" if pad.turned else "–")
        down = [str(bit + 1) for bit in range(8) if pad.buttons >> bit & 1]
        rows["buttons"].setText(" ".join(down) or "–")
        rows["rate"].setText(f"{pad.rate():.0f}" if pad.rate() else "–")

    def _tilt_text(self) -> str:
        across, along = self.pad.tilts
        if across >= 0.0:
            aside = say("{angle:.0f}° to the right", angle=across)
        else:
            aside = say("{angle:.0f}° to the left", angle=-across)
        if along >= 0.0:
            return f"{aside}, " + say("{angle:.0f}° towards you", angle=along)
        return f"{aside}, " + say("{angle:.0f}° away from you", angle=-along)

    def _verdict(self) -> str:
        pad = self.pad
        if not pad.device:
            return say("Draw on the sheet: softly, firmly, with the pen upright and laid down.")
        if pad.is_mouse:
            return say(
                "This comes as a mouse, without pressure. If it is a pen, its driver is missing or "
                "set to be a mouse."
            )
        if pad.most == 0.0:
            return say("The pen is seen; press it on the sheet.")
        if pad.most - pad.least < 0.02:
            return say("Only one pressure has arrived so far: press softly, then firmly.")
        if not pad.leaned:
            return say(
                "Pressure arrives. Tilt the pen: if nothing arrives then, the brush stands upright."
            )
        return say("Pressure and tilt arrive: the brush follows both.")

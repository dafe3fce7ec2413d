"""A curve to drag, by which an input of the hand drives a setting of the brush."""

from __future__ import annotations

import math

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.dialogs.brush_draft import Points
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say
from paint3d.brush_engine.tuft import MOST_POINTS

__all__ = ["FactorCurve"]

_GRIP, _NEAR = 5.5, 12.0
_LEAST, _MOST = 0.05, 20.0
_MARGIN = QtCore.QMarginsF(34, 12, 14, 22)
_APART = 0.01  # of the width: points lie at least so far from each other


class FactorCurve(QtWidgets.QWidget):
    """Points (input, factor) joined by straight lines; outside the first and last these hold.

    Signals
    -------
    changed : tuple of (float, float)
        All points, when one was added, moved or taken away.
    """

    changed = QtCore.Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self.points: Points = ()
        self._low, self._high, self._unit = 0.0, 1.0, ""
        self._held = -1
        self.setMinimumSize(250, 150)
        self.setToolTip(say("Drag points; click to add one, right button to take one away"))

    def show_points(self, points: Points, low: float, high: float, unit: str) -> None:
        """Show other points, over inputs from low to high, and tell nothing."""
        self.points, self._low, self._high, self._unit = points, low, high, unit
        self._held = self._held if self._held < len(points) else -1
        self.update()

    def place(self, x: float, y: float) -> QtCore.QPointF:
        """Where an input and a factor lie in the widget."""
        area = QtCore.QRectF(self.rect()).marginsRemoved(_MARGIN)
        along = (x - self._low) / (self._high - self._low)
        up = math.log(y / _LEAST) / math.log(_MOST / _LEAST)
        return QtCore.QPointF(
            area.left() + min(max(along, 0.0), 1.0) * area.width(),
            area.bottom() - min(max(up, 0.0), 1.0) * area.height(),
        )

    def _value(self, place: QtCore.QPointF) -> tuple[float, float]:
        area = QtCore.QRectF(self.rect()).marginsRemoved(_MARGIN)
        along = min(max((place.x() - area.left()) / area.width(), 0.0), 1.0)
        up = min(max((area.bottom() - place.y()) / area.height(), 0.0), 1.0)
        x = self._low + along * (self._high - self._low)
        return float(f"{x:.3g}"), float(f"{_LEAST * (_MOST / _LEAST) ** up:.3g}")

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw axes, curve and points."""
        painter, theme = QtGui.QPainter(self), self.theme
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        area = QtCore.QRectF(self.rect()).marginsRemoved(_MARGIN)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1))
        painter.setBrush(QtGui.QColor(theme.field))
        painter.drawRoundedRect(area.adjusted(-5, -5, 5, 5), 6, 6)
        small = painter.font()
        small.setPointSizeF(small.pointSizeF() - 1.5)
        painter.setFont(small)
        for factor in (0.1, 0.3, 1.0, 3.0, 10.0):
            y = self.place(self._low, factor).y()
            painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 2.0 if factor == 1.0 else 1.0))
            painter.drawLine(QtCore.QPointF(area.left(), y), QtCore.QPointF(area.right(), y))
            painter.setPen(QtGui.QColor(theme.faint))
            box = QtCore.QRectF(0, y - 8, area.left() - 8, 16)
            painter.drawText(box, QtCore.Qt.AlignmentFlag.AlignRight, f"×{factor:g}")
        below = QtCore.QRectF(area.left(), area.bottom() + 5, area.width(), 16)
        painter.drawText(below, QtCore.Qt.AlignmentFlag.AlignLeft, f"{self._low:g}")
        most = f"{self._high:g} {self._unit}".rstrip()
        painter.drawText(below, QtCore.Qt.AlignmentFlag.AlignRight, most)
        if self.points:
            self._draw_curve(painter, area)
        painter.end()

    def _draw_curve(self, painter: QtGui.QPainter, area: QtCore.QRectF) -> None:
        places = [self.place(x, y) for x, y in self.points]
        ends = (
            QtCore.QPointF(area.left(), places[0].y()), QtCore.QPointF(area.right(), places[-1].y())
        )  # fmt: skip
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 2.2))
        painter.drawPolyline([ends[0], *places, ends[1]])
        painter.setBrush(QtGui.QColor(self.theme.raised))
        for place in places:
            painter.drawEllipse(place, _GRIP, _GRIP)

    def _point_at(self, place: QtCore.QPointF) -> int:
        near = [
            ((self.place(*point) - place).manhattanLength(), k)
            for k, point in enumerate(self.points)
        ]
        distance, k = min(near, default=(math.inf, -1))
        return k if distance < _NEAR else -1

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Hold a point, make one, or take one away."""
        left = QtCore.Qt.MouseButton.LeftButton
        if event.button() != left and event.buttons() & left:
            return  # beside the button that holds one
        place = event.position()
        at = self._point_at(place)
        if event.button() == QtCore.Qt.MouseButton.RightButton:
            if at >= 0:
                self._tell(self.points[:at] + self.points[at + 1 :])
            return
        if at < 0 and len(self.points) < MOST_POINTS:
            x, y = self._value(place)
            at = sum(point[0] < x for point in self.points)
            if self._fits(x, at, at):
                self._tell((*self.points[:at], (x, y), *self.points[at:]))
            else:
                at = -1
        self._held = at

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Drag the point that is held, between its neighbours."""
        at = self._held
        if at < 0:
            return
        x, y = self._value(event.position())
        x = x if self._fits(x, at, at + 1) else self.points[at][0]
        self._tell((*self.points[:at], (x, y), *self.points[at + 1 :]))

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """Let go of it with the button that holds it."""
        if not event.buttons() & QtCore.Qt.MouseButton.LeftButton:
            self._held = -1

    def _fits(self, x: float, at: int, after: int) -> bool:
        """Whether an input lies between the points before a place and from another on."""
        apart = _APART * (self._high - self._low)
        before = self.points[at - 1][0] if at > 0 else -math.inf
        behind = self.points[after][0] if after < len(self.points) else math.inf
        return before + apart <= x <= behind - apart

    def _tell(self, points: Points) -> None:
        self.points = points
        self.update()
        self.changed.emit(points)

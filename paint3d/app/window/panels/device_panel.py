"""The devices: what each hand holds, how hard it presses, how punctually it speaks."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.frame import Frame
from paint3d.app.model.input.devices import DeviceHub, DeviceView
from paint3d.app.window.keeping_up import keeping_up
from paint3d.app.window.panels.device_forms import MouseForm, StylusForm
from paint3d.app.window.theme import STATES, Theme
from paint3d.app.window.wording import say
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import MAX_FORCE_N

__all__ = ["DevicePanel", "HandsPicture"]

_LATE_MS = 8.0


class HandsPicture(QtWidgets.QWidget):
    """Both hands: the object as the left one holds it, the brush in the right one, its force."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self.object_axes: AnyArray = np.eye(3)
        self.brush_axis: AnyArray = np.array([0.0, 0.0, 1.0])
        self.force = 0.0
        self.setMinimumHeight(132)

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw them."""
        painter, theme = QtGui.QPainter(self), self.theme
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        area = QtCore.QRectF(self.rect()).adjusted(1, 1, -1, -1)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1))
        painter.setBrush(QtGui.QColor(theme.field))
        painter.drawRoundedRect(area, 8, 8)
        third = area.width() / 3.0
        self._draw_object(painter, QtCore.QPointF(area.left() + 0.55 * third, area.center().y()))
        self._draw_brush(painter, QtCore.QPointF(area.left() + 1.65 * third, area.center().y()))
        self._draw_force(painter, area)
        painter.end()

    def _draw_object(self, painter: QtGui.QPainter, centre: QtCore.QPointF) -> None:
        """A cube as the left hand turns it, seen from the front and a little from above."""
        corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 21.0
        seen = corners @ self.object_axes.T
        flat = np.stack([seen[:, 0] + 0.35 * seen[:, 1], -seen[:, 2] - 0.25 * seen[:, 1]], axis=1)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.text), 1.5))
        for a in range(8):
            for b in range(a + 1, 8):
                if bin(a ^ b).count("1") == 1:
                    painter.drawLine(
                        centre + QtCore.QPointF(*flat[a]), centre + QtCore.QPointF(*flat[b])
                    )

    def _draw_brush(self, painter: QtGui.QPainter, tip: QtCore.QPointF) -> None:
        x, y, z = self.brush_axis
        way = QtCore.QPointF(x + 0.35 * y, -z - 0.25 * y)
        length = max(1e-6, math.hypot(way.x(), way.y()))
        way *= 52.0 * min(1.0, length) / length
        tip += QtCore.QPointF(0, 34)
        pen = QtGui.QPen(QtGui.QColor("#b08850"), 6)
        pen.setCapStyle(QtCore.Qt.PenCapStyle.RoundCap)
        painter.setPen(pen)
        painter.drawLine(tip + way * 0.4, tip + way * 1.5)
        pen.setColor(QtGui.QColor(self.theme.text))
        pen.setWidthF(5 + 4 * self.force / MAX_FORCE_N)
        painter.setPen(pen)
        painter.drawLine(tip, tip + way * 0.4)

    def _draw_force(self, painter: QtGui.QPainter, area: QtCore.QRectF) -> None:
        """A gauge with a needle, marks and the number: the shape tells, not a colour."""
        centre = QtCore.QPointF(area.right() - area.width() / 6.2, area.center().y() + 18)
        radius = min(42.0, area.width() / 7.5)
        arc = QtCore.QRectF(centre.x() - radius, centre.y() - radius, 2 * radius, 2 * radius)
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.line), 5))
        painter.drawArc(arc, 0, 180 * 16)
        share = min(1.0, self.force / MAX_FORCE_N)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 5))
        painter.drawArc(arc, 180 * 16, -round(180 * 16 * share))
        angle = math.pi * (1.0 - share)
        end = centre + QtCore.QPointF(math.cos(angle), -math.sin(angle)) * (radius - 7)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.text), 2))
        painter.drawLine(centre, end)
        painter.drawText(
            QtCore.QRectF(centre.x() - 40, centre.y() + 4, 80, 18),
            QtCore.Qt.AlignmentFlag.AlignCenter,
            f"{self.force:.1f} N",
        )


class DevicePanel(QtWidgets.QWidget):
    """Both hands, a line for each device, and what is chosen for them."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.picture = HandsPicture(theme)
        self.lines = QtWidgets.QLabel()
        self.lines.setWordWrap(True)
        self.lines.setTextFormat(QtCore.Qt.TextFormat.PlainText)
        self.lines.setTextInteractionFlags(QtCore.Qt.TextInteractionFlag.TextSelectableByMouse)
        self.stylus, self.mouse = StylusForm(), MouseForm()
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(10, 6, 10, 8)
        layout.addWidget(self.picture)
        layout.addWidget(self.lines)
        layout.addWidget(self.stylus)
        layout.addWidget(self.mouse)
        layout.addStretch(1)
        self.show_desk(None, None)

    def show_brush(self, axis: AnyArray, force: float) -> None:
        """Show how the brush is held (3,), in the world, and how hard it presses, N."""
        self.picture.brush_axis, self.picture.force = axis, force
        self.picture.update()

    def show_object(self, axes: AnyArray) -> None:
        """Show how the object is held: its axes (3, 3), columns, in the world."""
        self.picture.object_axes = axes
        self.picture.update()

    def show_desk(self, desk: DeviceHub | None, frame: Frame | None) -> None:
        """Show what is plugged in, and how it does."""
        views = [] if desk is None else desk.views()
        lines = [] if desk is None else _lines_of(desk, views)
        if not views:
            lines.append(f"{STATES['off']} {say('device.none')}")
        state, told = keeping_up(frame)
        lines.append(f"{STATES[state]} {say('Painting')}: {told}")
        self.lines.setText("\n\n".join(lines))

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = self.picture.theme = theme
        self.picture.update()


def _lines_of(desk: DeviceHub, views: Sequence[DeviceView]) -> list[str]:
    """A line for each device, and one for what was lost."""
    lines = []
    for view in views:
        if not view.is_open:
            lines.append(f"{STATES['bad']} {view.name}\n     {view.message}")
            continue
        late, rate = desk.lateness_ms(view.hand), desk.rate_hz(view.hand)
        state = STATES["slow" if late > _LATE_MS else "good"]
        told = f"{say('device.rate', hz=rate)}, {say('device.late', ms=late)}"
        hand = say(f"device.{view.hand}_hand")
        lines.append(f"{state} {view.name}\n     {hand}: {told}")
    if desk.lost():
        lines.append(f"{STATES['slow']} {say('device.lost', count=desk.lost())}")
    return lines

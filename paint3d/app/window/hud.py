"""What lies over the picture: the brush in use, its ink and how much of it is left."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6 import QtCore, QtGui

from paint3d.app.window.brush_panel import plain_name
from paint3d.app.window.wording import say, say_length

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["Hud"]

_PORCELAIN = "#f3f0ea"
_MARGIN, _HEIGHT, _WIDTH = 14, 46, 236


class Hud:
    """A small plate in the lower left corner of the canvas."""

    def __init__(self, window: StudioWindow) -> None:
        self._window = window
        window.canvas.overlays.append(self.paint)

    def paint(self, painter: QtGui.QPainter, area: QtCore.QRect) -> None:
        """Draw it."""
        window = self._window
        frame, theme = window.stage.frame, window.theme
        if window.stage.easel is None or frame is None:
            return
        brush = window.document.painter.brush
        plate = QtCore.QRectF(
            area.left() + _MARGIN, area.bottom() - _MARGIN - _HEIGHT, _WIDTH, _HEIGHT
        )
        back = QtGui.QColor(theme.panel)
        back.setAlpha(222)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1))
        painter.setBrush(back)
        painter.drawRoundedRect(plate, 10, 10)
        seen = frame.brush
        ink = QtGui.QColor(*(int(c) for c in seen.srgb)) if seen is not None else None
        load = seen.load if seen is not None else 1.0
        self._paint_drop(painter, plate, ink, load)
        painter.setPen(QtGui.QColor(theme.text))
        text = plate.adjusted(52, 5, -8, -_HEIGHT / 2)
        left = QtCore.Qt.AlignmentFlag.AlignLeft | QtCore.Qt.AlignmentFlag.AlignVCenter
        painter.drawText(text, left, f"{say(plain_name(brush))}  ·  {say_length(brush.length_mm)}")
        painter.setPen(QtGui.QColor(theme.faint))
        below = plate.adjusted(52, _HEIGHT / 2 - 2, -8, -4)
        told = f"{say('ink {share:.0f} %', share=100 * load)}  ·  {window.panels.ink_name()}"
        right = QtCore.Qt.TextElideMode.ElideRight
        painter.drawText(below, left, painter.fontMetrics().elidedText(told, right, below.width()))

    def _paint_drop(
        self, painter: QtGui.QPainter, plate: QtCore.QRectF, ink: QtGui.QColor | None, load: float
    ) -> None:
        """A dish with as much ink in it as the brush has."""
        theme = self._window.theme
        box = QtCore.QRectF(plate.left() + 9, plate.top() + 7, 32, 32)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.faint), 1.4))
        painter.setBrush(QtGui.QColor(_PORCELAIN))
        painter.drawEllipse(box)
        if ink is None or load <= 0.0:
            return
        clip = QtGui.QPainterPath()
        clip.addEllipse(box.adjusted(2, 2, -2, -2))
        painter.save()
        painter.setClipPath(clip)
        top = box.bottom() - 2 - (box.height() - 4) * load
        painter.fillRect(QtCore.QRectF(box.left(), top, box.width(), box.height()), ink)
        painter.restore()

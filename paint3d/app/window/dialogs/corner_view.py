"""The corners of a sheet over its photograph, to be dragged."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui

from paint3d.app.window.dialogs.picture_view import PictureView, image_of, length_of
from paint3d.app.window.theme import Theme

__all__ = ["CornerView"]

_GRIP, _NEAR = 8.0, 26.0
_STEPS = {
    QtCore.Qt.Key.Key_Left: (-1, 0), QtCore.Qt.Key.Key_Right: (1, 0),
    QtCore.Qt.Key.Key_Up: (0, -1), QtCore.Qt.Key.Key_Down: (0, 1),
}  # fmt: skip
_FAR = 10  # pixels that Shift goes at once


class CornerView(PictureView):
    """Four corners, dragged by pen, mouse or finger; arrows move the chosen one, 1 to 4 choose.

    Parameters
    ----------
    theme : Theme
    pixels : (H, W, 3) uint8
        The photograph.
    """

    def __init__(self, theme: Theme, pixels: NDArray[np.uint8]) -> None:
        super().__init__(theme)
        self._image = image_of(pixels)
        self.corners = np.zeros((4, 2))
        self._chosen = 0
        self.show_area(QtCore.QRectF(self._image.rect()))

    def show_corners(self, corners: NDArray[np.float64]) -> None:
        """Show other corners (4, 2), pixels."""
        self.corners = np.array(corners, np.float64)
        self.update()

    def take_hold(self, place: QtCore.QPointF) -> bool:
        """Whether a corner is there."""
        away = [length_of(self.place(*corner) - place) for corner in self.corners]
        nearest = int(np.argmin(away))
        if away[nearest] > _NEAR:
            return False
        self._chosen = nearest
        self.update()
        return True

    def drag_to(self, place: QtCore.QPointF) -> None:
        """Bring the chosen corner there; it stays on the picture."""
        self._put(np.array(self.pixel(place)))

    def _put(self, pixel: NDArray[np.float64]) -> None:
        most = self._image.width(), self._image.height()
        self.corners[self._chosen] = np.clip(pixel, 0.0, most)
        self.update()

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Choose a corner by its number, or move the chosen one by a pixel, with Shift by ten."""
        key = QtCore.Qt.Key(event.key())
        if key in _STEPS:
            far = bool(event.modifiers() & QtCore.Qt.KeyboardModifier.ShiftModifier)
            self._put(self.corners[self._chosen] + np.array(_STEPS[key]) * (_FAR if far else 1))
        elif event.text() in ("1", "2", "3", "4"):
            self._chosen = int(event.text()) - 1
            self.update()
        else:
            super().keyPressEvent(event)

    def draw(self, painter: QtGui.QPainter) -> None:
        """Draw the photograph."""
        painter.drawImage(0, 0, self._image)

    def draw_marks(self, painter: QtGui.QPainter) -> None:
        """Draw the sheet's sides and corners."""
        places = [self.place(*corner) for corner in self.corners]
        line = QtGui.QPolygonF(places)
        for colour, width in (("#ffffff", 4.0), (self.theme.accent, 2.0)):
            painter.setPen(QtGui.QPen(QtGui.QColor(colour), width))
            painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
            painter.drawPolygon(line)
        for k, place in enumerate(places):
            is_chosen = k == self._chosen
            painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 2.0))
            painter.setBrush(QtGui.QColor(self.theme.accent if is_chosen else "#ffffff"))
            painter.drawEllipse(place, _GRIP + 3.0 * is_chosen, _GRIP + 3.0 * is_chosen)
            painter.setPen(QtGui.QColor("#ffffff" if is_chosen else "#2a2825"))
            box = QtCore.QRectF(place.x() - 10.0, place.y() - 10.0, 20.0, 20.0)
            painter.drawText(box, QtCore.Qt.AlignmentFlag.AlignCenter, str(k + 1))

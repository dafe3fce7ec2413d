"""A view of a picture that zooms about a point and moves."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.theme import Theme

__all__ = ["PictureView", "image_of", "length_of"]

_STEP = 1.25  # per notch of the wheel
_FARTHEST, _CLOSEST = 0.25, 40.0  # of the scale at first
_STILL = 6.0  # pixels: a press that goes no farther is a click
_MARGIN = 14.0
_KIND, _BUTTON = QtCore.QEvent.Type, QtCore.Qt.MouseButton


def image_of(pixels: NDArray[np.uint8]) -> QtGui.QImage:
    """Return a Qt image of pixels (H, W, 3)."""
    height, width, _ = pixels.shape
    rows = np.ascontiguousarray(pixels)
    form = QtGui.QImage.Format.Format_RGB888
    return QtGui.QImage(rows.data, width, height, 3 * width, form).copy()


def length_of(vector: QtCore.QPointF) -> float:
    """Return the length of a vector."""
    return math.hypot(vector.x(), vector.y())


class PictureView(QtWidgets.QWidget):
    """Shows a picture; the wheel, two fingers or + and - zoom, a drag moves it, 0 shows all.

    Signals
    -------
    clicked : (float, float)
        A point of the picture, in its pixels.
    """

    clicked = QtCore.Signal(float, float)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self._area = QtCore.QRectF(0.0, 0.0, 1.0, 1.0)
        self._scale, self._offset = 1.0, QtCore.QPointF()
        self._is_whole = True
        self._pressed: QtCore.QPointF | None = None
        self._last, self._moved, self._holds = QtCore.QPointF(), False, False
        self._button = _BUTTON.LeftButton
        self.setMinimumSize(300, 240)
        self.setFocusPolicy(QtCore.Qt.FocusPolicy.StrongFocus)
        self.grabGesture(QtCore.Qt.GestureType.PinchGesture)

    # -- scale and position -----------------------------------------------------------------

    def show_area(self, area: QtCore.QRectF) -> None:
        """Show this part of the picture, its pixels, as large as there is room."""
        self._area = area
        self.show_whole()

    def show_whole(self) -> None:
        """Show all of that part."""
        room = QtCore.QRectF(self.rect())
        self._scale = max(
            min(
                (room.width() - 2.0 * _MARGIN) / self._area.width(),
                (room.height() - 2.0 * _MARGIN) / self._area.height(),
            ),
            1e-6,
        )
        self._offset = room.center() - self._area.center() * self._scale
        self._is_whole = True
        self.update()

    @property
    def scale(self) -> float:
        """Pixels of the widget to one of the picture."""
        return self._scale

    def place(self, x: float, y: float) -> QtCore.QPointF:
        """Return the widget's point at a point of the picture."""
        return self._offset + QtCore.QPointF(x, y) * self._scale

    def pixel(self, position: QtCore.QPointF) -> tuple[float, float]:
        """Return the picture's point at a point of the widget."""
        point = (position - self._offset) / self._scale
        return point.x(), point.y()

    def zoom(self, by: float, about: QtCore.QPointF | None = None) -> None:
        """Zoom about a point of the widget, by default its middle."""
        about = QtCore.QRectF(self.rect()).center() if about is None else about
        x, y = self.pixel(about)
        room = self.size()
        whole = min(room.width() / self._area.width(), room.height() / self._area.height())
        self._scale = min(max(self._scale * by, _FARTHEST * whole), _CLOSEST * whole)
        self._offset = about - QtCore.QPointF(x, y) * self._scale
        self._is_whole = False
        self.update()

    # -- input ------------------------------------------------------------------------------

    def take_hold(self, place: QtCore.QPointF) -> bool:
        """Return whether a drag from there moves something else than the picture."""
        return False

    def drag_to(self, place: QtCore.QPointF) -> None:
        """Move what is dragged to a point of the widget."""

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin a click or a drag."""
        self._begin(event.position(), event.button(), event.buttons())

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Go on with a drag."""
        self._go_on(event.position())

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """End the drag, or emit a click where nothing was moved."""
        self._end(event.position(), event.buttons())

    def tabletEvent(self, event: QtGui.QTabletEvent) -> None:
        """Do the same with a pen."""
        if event.type() == _KIND.TabletPress:
            self._begin(event.position(), event.button(), event.buttons())
        elif event.type() == _KIND.TabletRelease:
            self._end(event.position(), event.buttons())
        else:
            self._go_on(event.position())
        event.accept()

    def _begin(
        self, position: QtCore.QPointF, button: QtCore.Qt.MouseButton, down: QtCore.Qt.MouseButton
    ) -> None:
        if self._pressed is not None and button != self._button and down & self._button:
            return  # beside the button that drags
        self._last, self._moved, self._pressed, self._button = position, False, position, button
        self._holds = button == _BUTTON.LeftButton and self.take_hold(position)

    def _go_on(self, position: QtCore.QPointF) -> None:
        if self._pressed is None:
            return
        if self._holds:
            self.drag_to(position)
            return
        self._moved |= (position - self._pressed).manhattanLength() > _STILL
        if self._moved:
            self._offset += position - self._last
            self._last, self._is_whole = position, False
            self.update()

    def _end(self, position: QtCore.QPointF, still_down: QtCore.Qt.MouseButton) -> None:
        if still_down & self._button:
            return  # another button was released
        was_click = self._pressed is not None and not (self._moved or self._holds)
        self._pressed = None
        if was_click and self._button == _BUTTON.LeftButton:
            self.clicked.emit(*self.pixel(position))

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Zoom about the pointer."""
        self.zoom(_STEP ** (event.angleDelta().y() / 120.0), event.position())

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Zoom by + and -, show all by 0; other keys are the dialog's."""
        if event.text() in ("+", "="):
            self.zoom(_STEP)
        elif event.text() == "-":
            self.zoom(1.0 / _STEP)
        elif event.text() == "0":
            self.show_whole()
        else:
            super().keyPressEvent(event)

    def event(self, event: QtCore.QEvent) -> bool:
        """Zoom by two fingers, which move nothing else."""
        if event.type() == _KIND.Gesture and isinstance(event, QtWidgets.QGestureEvent):
            pinch = event.gesture(QtCore.Qt.GestureType.PinchGesture)
            if isinstance(pinch, QtWidgets.QPinchGesture):
                self._pressed = None
                about = self.mapFromGlobal(pinch.centerPoint())
                self._offset += pinch.centerPoint() - pinch.lastCenterPoint()
                self.zoom(pinch.scaleFactor(), about)
                return True
        return super().event(event)

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Show all again, if all was shown."""
        super().resizeEvent(event)
        if self._is_whole:
            self.show_whole()

    # -- drawing ----------------------------------------------------------------------------

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw the picture, and the marks over it."""
        painter = QtGui.QPainter(self)
        painter.setRenderHints(
            QtGui.QPainter.RenderHint.Antialiasing | QtGui.QPainter.RenderHint.SmoothPixmapTransform
        )
        painter.fillRect(self.rect(), QtGui.QColor(self.theme.window))
        painter.save()
        painter.translate(self._offset)
        painter.scale(self._scale, self._scale)
        self.draw(painter)
        painter.restore()
        self.draw_marks(painter)
        painter.end()

    def draw(self, painter: QtGui.QPainter) -> None:
        """Draw in pixels of the picture."""

    def draw_marks(self, painter: QtGui.QPainter) -> None:
        """Draw in pixels of the widget, whatever the zoom."""

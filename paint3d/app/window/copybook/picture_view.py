"""A picture that is looked at from near: zoomed about a place, and moved."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.theme import Theme

__all__ = ["PictureView", "image_of", "length_of"]

_STEP = 1.25  # per notch of the wheel
_FARTHEST, _CLOSEST = 0.25, 40.0  # times what is shown first
_STILL = 6.0  # pixels: a press that goes no farther is a click
_MARGIN = 14.0
_KIND, _BUTTON = QtCore.QEvent.Type, QtCore.Qt.MouseButton


def image_of(pixels: NDArray[np.uint8]) -> QtGui.QImage:
    """Pixels (H, W, 3) as a picture of its own."""
    height, width, _ = pixels.shape
    rows = np.ascontiguousarray(pixels)
    form = QtGui.QImage.Format.Format_RGB888
    return QtGui.QImage(rows.data, width, height, 3 * width, form).copy()


def length_of(way: QtCore.QPointF) -> float:
    """The length of a way from one place to another."""
    return math.hypot(way.x(), way.y())


class PictureView(QtWidgets.QWidget):
    """Shows a picture; the wheel, two fingers or + and - zoom, a drag moves it, 0 shows all.

    Signals
    -------
    clicked : (float, float)
        A place in the picture, its pixels.
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

    # -- where things are -------------------------------------------------------------------

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
        """Where a place of the picture lies in the widget."""
        return self._offset + QtCore.QPointF(x, y) * self._scale

    def pixel(self, place: QtCore.QPointF) -> tuple[float, float]:
        """Which place of the picture lies there."""
        there = (place - self._offset) / self._scale
        return there.x(), there.y()

    def zoom(self, by: float, about: QtCore.QPointF | None = None) -> None:
        """Show it larger about a place of the widget, by default its middle."""
        about = QtCore.QRectF(self.rect()).center() if about is None else about
        x, y = self.pixel(about)
        room = self.size()
        whole = min(room.width() / self._area.width(), room.height() / self._area.height())
        self._scale = min(max(self._scale * by, _FARTHEST * whole), _CLOSEST * whole)
        self._offset = about - QtCore.QPointF(x, y) * self._scale
        self._is_whole = False
        self.update()

    # -- what the hand does -----------------------------------------------------------------

    def take_hold(self, place: QtCore.QPointF) -> bool:
        """Whether something at a place of the widget is dragged from now on; not the picture."""
        return False

    def drag_to(self, place: QtCore.QPointF) -> None:
        """Bring what is held to a place of the widget."""

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin a click or a drag."""
        self._begin(event.position(), event.button(), event.buttons())

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Go on with it."""
        self._go_on(event.position())

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """End it; where nothing was moved it was a click."""
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
        self, place: QtCore.QPointF, button: QtCore.Qt.MouseButton, down: QtCore.Qt.MouseButton
    ) -> None:
        if self._pressed is not None and button != self._button and down & self._button:
            return  # beside the button that drags
        self._last, self._moved, self._pressed, self._button = place, False, place, button
        self._holds = button == _BUTTON.LeftButton and self.take_hold(place)

    def _go_on(self, place: QtCore.QPointF) -> None:
        if self._pressed is None:
            return
        if self._holds:
            self.drag_to(place)
            return
        self._moved |= (place - self._pressed).manhattanLength() > _STILL
        if self._moved:
            self._offset += place - self._last
            self._last, self._is_whole = place, False
            self.update()

    def _end(self, place: QtCore.QPointF, still_down: QtCore.Qt.MouseButton) -> None:
        if still_down & self._button:
            return  # another button was let go of
        was_click = self._pressed is not None and not (self._moved or self._holds)
        self._pressed = None
        if was_click and self._button == _BUTTON.LeftButton:
            self.clicked.emit(*self.pixel(place))

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
        """Show all of it still, if all was shown."""
        super().resizeEvent(event)
        if self._is_whole:
            self.show_whole()

    # -- drawing ----------------------------------------------------------------------------

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw the picture, and over it what it shows."""
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

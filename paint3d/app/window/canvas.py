"""The picture one paints on: the stage's pixels in a widget, and what the hand does over it."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.event_clock import EventClock
from paint3d.app.window.touch import touch_of_mouse, touch_of_tablet

__all__ = ["Canvas"]


class Canvas(QtWidgets.QWidget):
    """Shows pixels; tells what pen, mouse and wheel do.

    Signals
    -------
    touched : Touch
        A pen or the mouse has moved, come down or gone up, no other button or key being meant.
    steered : (str, float, float)
        "begin", "move" or "end" of a drag that steers the view, and where.
    wheeled : (float, float, float)
        Notches of the wheel, and where.
    left : ()
        The pointer has gone out of the picture.
    resized : ()
    dropped : str
        A file was let fall here.
    untimed : ()
        A pen gives no times of its own: the first time that this is found.
    """

    touched = QtCore.Signal(object)
    steered = QtCore.Signal(str, object)
    wheeled = QtCore.Signal(float, float, float)
    left = QtCore.Signal()
    resized = QtCore.Signal()
    dropped = QtCore.Signal(str)
    untimed = QtCore.Signal()

    def __init__(self, parent: QtWidgets.QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setTabletTracking(True)
        self.setAcceptDrops(True)
        self.setFocusPolicy(QtCore.Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(320, 240)
        self.setAttribute(QtCore.Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setSizePolicy(
            QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Expanding
        )
        self.overlays: list[Callable[[QtGui.QPainter, QtCore.QRect], None]] = []
        self._image: QtGui.QImage | None = None
        self._pixels: NDArray | None = None
        self._steering = False
        self._pen_down = False
        self._clock = EventClock()

    @property
    def pixel_size(self) -> tuple[int, int]:
        """Width and height in the screen's own pixels."""
        ratio = self.devicePixelRatioF()
        return max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio))

    def show_pixels(self, pixels: NDArray) -> None:
        """Show (H, W, 4) uint8 pixels, the first row at the bottom."""
        self._pixels = np.ascontiguousarray(pixels[::-1])
        height, width = pixels.shape[:2]
        form = QtGui.QImage.Format.Format_RGBX8888
        self._image = QtGui.QImage(self._pixels.data, width, height, 4 * width, form)
        self._image.setDevicePixelRatio(self.devicePixelRatioF())
        self.update()

    # -- what Qt calls ----------------------------------------------------------------------

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Paint the picture, and what lies over it."""
        painter = QtGui.QPainter(self)
        if self._image is None:
            painter.fillRect(event.rect(), self.palette().window())
        else:
            painter.drawImage(self.rect(), self._image)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        for overlay in self.overlays:
            overlay(painter, self.rect())
        painter.end()

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Have it drawn at the new size."""
        super().resizeEvent(event)
        self.resized.emit()

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin to steer with Alt or another button; else the brush comes down."""
        self.setFocus(QtCore.Qt.FocusReason.MouseFocusReason)
        if _steers(event):
            self._steering = True
            self.steered.emit("begin", event)
        elif not self._pen_down:
            self.touched.emit(touch_of_mouse(event, self._time_ns("mouse", event)))
        event.accept()

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Steer, or move the brush."""
        if self._steering:
            self.steered.emit("move", event)
        elif not self._pen_down:
            self.touched.emit(touch_of_mouse(event, self._time_ns("mouse", event)))
        event.accept()

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """Stop steering, or lift the brush."""
        if self._steering:
            if not event.buttons():
                self._steering = False
            self.steered.emit("end", event)
        elif not self._pen_down:
            self.touched.emit(touch_of_mouse(event, self._time_ns("mouse", event)))
        event.accept()

    def tabletEvent(self, event: QtGui.QTabletEvent) -> None:
        """Paint with the pen; accepted, so that no mouse events are made of it."""
        if event.modifiers() & QtCore.Qt.KeyboardModifier.AltModifier and not self._pen_down:
            event.ignore()  # comes again as a mouse event, and steers
            return
        touch = touch_of_tablet(event, self._time_ns("pen", event))
        self._pen_down = touch.down
        self.touched.emit(touch)
        event.accept()

    def _time_ns(self, kind: str, event: QtGui.QPointerEvent) -> int:
        """When an event happened."""
        known = len(self._clock.untimed)
        painting = self._pen_down or bool(event.buttons() & QtCore.Qt.MouseButton.LeftButton)
        handled = time.perf_counter_ns()
        found = self._clock.time_ns(kind, event.timestamp(), handled, painting)
        if kind == "pen" and len(self._clock.untimed) > known:
            self.untimed.emit()
        return found

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Come nearer."""
        place = event.position()
        self.wheeled.emit(event.angleDelta().y() / 120.0, place.x(), place.y())
        event.accept()

    def leaveEvent(self, event: QtCore.QEvent) -> None:
        """Take the brush out of the picture."""
        super().leaveEvent(event)
        self.left.emit()

    def dragEnterEvent(self, event: QtGui.QDragEnterEvent) -> None:
        """Take files."""
        urls = event.mimeData().urls()
        if len(urls) == 1 and urls[0].isLocalFile():
            event.acceptProposedAction()

    def dropEvent(self, event: QtGui.QDropEvent) -> None:
        """Open the file."""
        self.dropped.emit(event.mimeData().urls()[0].toLocalFile())
        event.acceptProposedAction()


def _steers(event: QtGui.QMouseEvent) -> bool:
    alt = bool(event.modifiers() & QtCore.Qt.KeyboardModifier.AltModifier)
    return alt or event.button() != QtCore.Qt.MouseButton.LeftButton

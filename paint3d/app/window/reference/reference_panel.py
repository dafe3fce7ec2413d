"""The panel of the reference: the picture with a loupe, and how it is shown over the work."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say
from paint3d.errors import Message

__all__ = ["PLACES", "ReferenceLook", "ReferencePanel", "ReferenceView", "image_of"]

PLACES = ("beside", "pinned", "laid")
"""Places of the picture: in the panel alone; over the view, too; on the object, too."""
_PLACE_NAMES = {
    "beside": Message("Beside the work"),
    "pinned": Message("Over the picture"),
    "laid": Message("On the object"),
}
_LOUPE, _TIMES = 46.0, 6.0  # radius, pixels; how many times as large
_NEARER, _MOST_ZOOM = 1.2, 40.0
_CLICK = 5.0  # pixels


class ReferenceLook(TypedDict):
    """The look of a reference: one of `PLACES`, its opacity (0 to 1), times its first size."""

    place: str
    opacity: float
    scale: float


def image_of(pixels: NDArray[np.uint8]) -> QtGui.QImage:
    """Return a Qt image of (H, W, 3) sRGB codes."""
    height, width = pixels.shape[:2]
    data = np.ascontiguousarray(pixels)
    form = QtGui.QImage.Format.Format_RGB888
    return QtGui.QImage(data.data, width, height, 3 * width, form).copy()


class ReferenceView(QtWidgets.QWidget):
    """Shows a picture: the wheel comes nearer, a drag moves it, a click picks a colour.

    Signals
    -------
    picked : QColor
    """

    picked = QtCore.Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self.image: QtGui.QImage | None = None
        self._zoom, self._middle = 1.0, QtCore.QPointF(0.5, 0.5)  # fractions of the picture
        self._at: QtCore.QPointF | None = None
        self._dragged_from: QtCore.QPointF | None = None
        self._moved = 0.0
        self.setMouseTracking(True)
        self.setMinimumHeight(150)
        self.setAccessibleName(say("Reference picture"))
        self.setToolTip(say("A click mixes the colour under the loupe; wheel and drag move it"))

    def show_image(self, image: QtGui.QImage | None) -> None:
        """Show another picture whole, or none."""
        self.image, self._zoom, self._middle = image, 1.0, QtCore.QPointF(0.5, 0.5)
        self.update()

    def _scale(self) -> float:
        """Return the pixels of the widget to one of the picture."""
        assert self.image is not None, "it is shown"
        size = self.image.size()
        return self._zoom * min(self.width() / size.width(), self.height() / size.height())

    def _onto(self) -> QtGui.QTransform:
        """Return the transform from the picture's pixels to the widget's."""
        assert self.image is not None, "it is shown"
        scale, size = self._scale(), self.image.size()
        x, y = self._middle.x() * size.width(), self._middle.y() * size.height()
        return QtGui.QTransform(
            scale, 0.0, 0.0, scale, 0.5 * self.width() - scale * x, 0.5 * self.height() - scale * y
        )

    def place_of(self, at: QtCore.QPointF) -> QtCore.QPoint | None:
        """Return the picture's pixel at a point of the widget; None beside it."""
        if self.image is None:
            return None
        back, _ = self._onto().inverted()
        point = back.map(at)
        pixel = QtCore.QPoint(int(np.floor(point.x())), int(np.floor(point.y())))
        return pixel if self.image.rect().contains(pixel) else None

    def colour_at(self, at: QtCore.QPointF) -> QtGui.QColor | None:
        """Return the mean colour of 3 x 3 pixels at a point; None beside the picture."""
        pixel = self.place_of(at)
        if pixel is None or self.image is None:
            return None
        around = QtCore.QRect(pixel - QtCore.QPoint(1, 1), QtCore.QSize(3, 3))
        around &= self.image.rect()
        colours = [
            self.image.pixelColor(x, y)
            for y in range(around.top(), around.bottom() + 1)
            for x in range(around.left(), around.right() + 1)
        ]
        codes = [(one.red(), one.green(), one.blue()) for one in colours]
        red, green, blue = (round(float(part)) for part in np.mean(codes, axis=0))
        return QtGui.QColor(red, green, blue)

    # -- events -----------------------------------------------------------------------------

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw the picture, and the loupe over it."""
        painter = QtGui.QPainter(self)
        painter.fillRect(self.rect(), QtGui.QColor(self.theme.field))
        if self.image is None:
            painter.setPen(QtGui.QColor(self.theme.faint))
            middle = QtCore.Qt.AlignmentFlag.AlignCenter | QtCore.Qt.TextFlag.TextWordWrap
            painter.drawText(self.rect(), middle, say("No picture is open"))
            painter.end()
            return
        painter.setRenderHint(QtGui.QPainter.RenderHint.SmoothPixmapTransform)
        painter.save()
        painter.setTransform(self._onto(), True)
        painter.drawImage(0, 0, self.image)
        painter.restore()
        if self._at is not None and self._dragged_from is None:
            self._draw_loupe(painter, self._at)
        painter.end()

    def _draw_loupe(self, painter: QtGui.QPainter, at: QtCore.QPointF) -> None:
        colour = self.colour_at(at)
        if colour is None or self.image is None:
            return
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        path = QtGui.QPainterPath()
        path.addEllipse(at, _LOUPE, _LOUPE)
        painter.save()
        painter.setClipPath(path)
        painter.translate(at)
        painter.scale(_TIMES, _TIMES)
        painter.translate(-at)
        painter.setTransform(self._onto(), True)
        painter.setRenderHint(QtGui.QPainter.RenderHint.SmoothPixmapTransform, False)
        painter.drawImage(0, 0, self.image)
        painter.restore()
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(colour, 7.0))
        painter.drawEllipse(at, _LOUPE, _LOUPE)
        painter.setPen(QtGui.QPen(QtGui.QColor("#ffffff"), 1.5))
        painter.drawEllipse(at, _LOUPE + 4.0, _LOUPE + 4.0)
        painter.drawRect(QtCore.QRectF(at.x() - 4.0, at.y() - 4.0, 8.0, 8.0))

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin to drag the picture."""
        self._dragged_from, self._moved = event.position(), 0.0

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Move it, or the loupe."""
        self._at = event.position()
        if self._dragged_from is not None and self.image is not None:
            shift = self._at - self._dragged_from
            self._moved += shift.manhattanLength()
            if self._moved > _CLICK:
                scale, size = self._scale(), self.image.size()
                self._middle -= QtCore.QPointF(
                    shift.x() / scale / size.width(), shift.y() / scale / size.height()
                )
            self._dragged_from = self._at
        self.update()

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """Pick the colour, if nothing was moved."""
        began, self._dragged_from = self._dragged_from, None
        colour = self.colour_at(event.position())
        if began is not None and self._moved <= _CLICK and colour is not None:
            self.picked.emit(colour)
        self.update()

    def leaveEvent(self, event: QtCore.QEvent) -> None:
        """Put the loupe away."""
        self._at = None
        self.update()

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Zoom in or out."""
        factor = _NEARER ** (event.angleDelta().y() / 120.0)
        self._zoom = min(_MOST_ZOOM, max(1.0, self._zoom * factor))
        if self._zoom == 1.0:
            self._middle = QtCore.QPointF(0.5, 0.5)
        event.accept()
        self.update()


class ReferencePanel(QtWidgets.QWidget):
    """The picture, and its controls.

    Signals
    -------
    asked, closed, copied : ()
        A picture is to be opened, closed, or laid out as a copybook.
    changed : ()
        Its place, opacity or size was changed.
    picked : QColor
        A colour of it is to be mixed.
    """

    asked = QtCore.Signal()
    closed = QtCore.Signal()
    copied = QtCore.Signal()
    changed = QtCore.Signal()
    picked = QtCore.Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.view = ReferenceView(theme)
        self.view.picked.connect(self.picked)
        self.place = QtWidgets.QComboBox()
        for name in PLACES:
            self.place.addItem(say(_PLACE_NAMES[name]), name)
        self.place.setAccessibleName(say("Where the reference is shown"))
        self.place.activated.connect(lambda _: self.changed.emit())
        self.opacity = self._slider(5, 100, 50, say("How dense the picture is over the work"))
        self.scale = self._slider(10, 300, 100, say("How large the picture is over the work"))
        self.open_button = QtWidgets.QPushButton(say("Open a picture…"))
        self.close_button = QtWidgets.QPushButton(say("Take away"))
        self.copy_button = QtWidgets.QPushButton(say("Use as copybook"))
        self.copy_button.setToolTip(say("Find its strokes and lay them out to be written after"))
        for button, signal in (
            (self.open_button, self.asked),
            (self.close_button, self.closed),
            (self.copy_button, self.copied),
        ):
            button.clicked.connect(lambda _=False, signal=signal: signal.emit())
        layout = QtWidgets.QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 8)
        layout.addWidget(self.view, 1)
        form = QtWidgets.QFormLayout()
        form.addRow(say("Shown"), self.place)
        form.addRow(say("Density"), self.opacity)
        form.addRow(say("Scale"), self.scale)
        layout.addLayout(form)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.open_button, 1)
        row.addWidget(self.close_button)
        layout.addLayout(row)
        layout.addWidget(self.copy_button)
        self.show_image(None)

    def _slider(self, low: int, high: int, value: int, tip: str) -> QtWidgets.QSlider:
        slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        slider.setRange(low, high)
        slider.setValue(value)
        slider.setToolTip(tip)
        slider.setAccessibleName(tip)
        slider.valueChanged.connect(lambda _: self.changed.emit())
        return slider

    def show_image(self, image: QtGui.QImage | None) -> None:
        """Show another picture, or none."""
        self.view.show_image(image)
        for widget in (self.place, self.opacity, self.scale, self.close_button, self.copy_button):
            widget.setEnabled(image is not None)

    def values(self) -> ReferenceLook:
        """Return the chosen look."""
        return {
            "place": self.place.currentData(),
            "opacity": self.opacity.value() / 100.0,
            "scale": self.scale.value() / 100.0,
        }

    def show_values(self, place: str, opacity: float, scale: float) -> None:
        """Show these values, without emitting a signal."""
        blocked = [QtCore.QSignalBlocker(slider) for slider in (self.opacity, self.scale)]
        self.place.setCurrentIndex(max(0, self.place.findData(place)))
        self.opacity.setValue(round(100 * opacity))
        self.scale.setValue(round(100 * scale))
        del blocked

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self.view.theme = theme
        self.view.update()

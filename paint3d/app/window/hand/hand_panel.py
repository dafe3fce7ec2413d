"""Settings of the hand: pressure curve, steadiness, images of the stroke, mask by angle."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.input.hand import HandSettings
from paint3d.app.model.input.pressure_curve import PressureCurve
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.errors import InputError, Message

__all__ = ["CurveEditor", "HandPanel"]

_RULER_NAMES = {
    "none": Message("None"),
    "straight": Message("Straight"),
    "ring": Message("Around the object"),
    "profile": Message("Along its profile"),
}
_GRIP = 6.0
_NEAR = 12.0


class CurveEditor(QtWidgets.QWidget):
    """A pressure curve to drag.

    Signals
    -------
    changed : PressureCurve
    """

    changed = QtCore.Signal(object)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.theme, self.curve = theme, PressureCurve()
        self.pressure: float | None = None
        self._dragged = -1
        self.setMinimumHeight(112)
        self.setToolTip(say("Drag points; click to add one, right-click to remove one"))

    def _area(self) -> QtCore.QRectF:
        return QtCore.QRectF(self.rect()).adjusted(10, 10, -10, -10)

    def _position(self, x: float, y: float) -> QtCore.QPointF:
        area = self._area()
        return QtCore.QPointF(area.left() + x * area.width(), area.bottom() - y * area.height())

    def _value(self, position: QtCore.QPointF) -> tuple[float, float]:
        area = self._area()
        x = (position.x() - area.left()) / area.width()
        y = (area.bottom() - position.y()) / area.height()
        return min(max(x, 0.0), 1.0), min(max(y, 0.0), 1.0)

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Draw the curve, its points, and where the pen presses now."""
        painter, theme = QtGui.QPainter(self), self.theme
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.line), 1))
        painter.setBrush(QtGui.QColor(theme.field))
        painter.drawRoundedRect(self._area().adjusted(-6, -6, 6, 6), 6, 6)
        for k in (0.25, 0.5, 0.75):
            painter.drawLine(self._position(k, 0), self._position(k, 1))
            painter.drawLine(self._position(0, k), self._position(1, k))
        path = QtGui.QPainterPath(self._position(0.0, self.curve(0.0)))
        for k in range(1, 65):
            path.lineTo(self._position(k / 64, self.curve(k / 64)))
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.accent), 2.2))
        painter.drawPath(path)
        painter.setBrush(QtGui.QColor(theme.raised))
        for x, y in self.curve.points:
            painter.drawEllipse(self._position(x, y), _GRIP, _GRIP)
        if self.pressure is not None:
            painter.setBrush(QtGui.QColor(theme.text))
            painter.setPen(QtCore.Qt.PenStyle.NoPen)
            painter.drawEllipse(self._position(self.pressure, self.curve(self.pressure)), 4, 4)
        painter.end()

    def _point_at(self, position: QtCore.QPointF) -> int:
        for k, (x, y) in enumerate(self.curve.points):
            if (self._position(x, y) - position).manhattanLength() < _NEAR:
                return k
        return -1

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin to drag a point, add one, or remove one."""
        left = QtCore.Qt.MouseButton.LeftButton
        if event.button() != left and event.buttons() & left:
            return  # beside the button that drags one
        position = event.position()
        at = self._point_at(position)
        try:
            if event.button() == QtCore.Qt.MouseButton.RightButton:
                if at >= 0:
                    self.set_curve(self.curve.without_point(at))
                return
            if at < 0:
                self.set_curve(self.curve.with_point(*self._value(position)))
                at = self._point_at(position)
        except InputError:
            return  # the ends stay, and so do the most points there can be
        self._dragged = at

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Drag the point that was pressed."""
        if self._dragged >= 0:
            self.set_curve(self.curve.moved(self._dragged, *self._value(event.position())))

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """End the drag with the button that began it."""
        if not event.buttons() & QtCore.Qt.MouseButton.LeftButton:
            self._dragged = -1

    def set_curve(self, curve: PressureCurve) -> None:
        """Show another curve, and emit it."""
        self.curve = curve
        self.update()
        self.changed.emit(curve)


class HandPanel(QtWidgets.QWidget):
    """Pressure, steadiness, symmetry and mask.

    Signals
    -------
    read : dict
        Changes of `HandSettings` by name.
    pressed : float
        Force of a mouse, N.
    ruled : bool
        Whether strokes follow a ruler from now on.
    turns : int
        Images of radial symmetry.
    mask_degrees : float
    """

    read = QtCore.Signal(object)
    pressed = QtCore.Signal(float)
    ruled = QtCore.Signal(bool)
    turns = QtCore.Signal(int)
    mask_degrees = QtCore.Signal(float)

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._last_ruler = "straight"
        form = QtWidgets.QFormLayout(self)
        form.setContentsMargins(10, 6, 10, 8)
        form.setVerticalSpacing(8)
        self.curve = CurveEditor(theme)
        self.curve.changed.connect(lambda curve: self.read.emit({"curve": curve}))
        straight = QtWidgets.QPushButton(say("Straight line"))
        straight.clicked.connect(lambda: self.curve.set_curve(PressureCurve()))
        head = QtWidgets.QHBoxLayout()
        head.addWidget(QtWidgets.QLabel(say("Pressure curve")), 1)
        head.addWidget(straight)
        form.addRow(head)
        form.addRow(self.curve)
        self.smoothing = self._slider(0, 100, lambda v: self.read.emit({"smoothing": v / 100}))
        self.trail = self._slider(2, 40, lambda v: self.read.emit({"trail": v / 100}))
        self.mouse = self._slider(0, 100, lambda v: self.read.emit({"mouse_smoothing": v / 100}))
        self.mouse.setToolTip(say("At least so steady where nothing tells the pressure"))
        self.force = self._slider(0, 100, lambda v: self.pressed.emit(0.01 * v * MAX_FORCE_N))
        self.force.setToolTip(
            say("How hard a mouse presses; so do the wheel in a stroke, and . and , held")
        )
        self.by_speed = QtWidgets.QCheckBox(say("Less where it is fast"))
        self.by_speed.toggled.connect(
            lambda on: self.read.emit({"pressure_by": "speed" if on else "keys"})
        )
        self.ruler = QtWidgets.QComboBox()
        for kind, text in _RULER_NAMES.items():
            self.ruler.addItem(say(text), kind)
        self.ruler.setToolTip(say("What strokes are led along; U switches it on and off"))
        self.ruler.setAccessibleName(say("Ruler"))
        self.ruler.currentIndexChanged.connect(self._choose_ruler)
        for slider, name in (
            (self.smoothing, say("Steadiness")),
            (self.mouse, say("Steadiness of a mouse")),
            (self.force, say("Press of a mouse")),
            (self.trail, say("Trail of the tuft")),
        ):
            slider.setAccessibleName(name)
        form.addRow(say("Steadiness"), self.smoothing)
        form.addRow(say("of a mouse"), self.mouse)
        form.addRow(say("Press of a mouse"), self.force)
        form.addRow("", self.by_speed)
        form.addRow(say("Ruler"), self.ruler)
        form.addRow(say("Trail of the tuft"), self.trail)
        self.count = QtWidgets.QSpinBox()
        self.count.setRange(2, 24)
        self.count.setValue(6)
        self.count.valueChanged.connect(self.turns)
        form.addRow(say("Radial symmetry"), self.count)
        self.angle = self._slider(5, 120, lambda v: self.mask_degrees.emit(float(v)))
        self.angle.setValue(75)
        form.addRow(say("By angle"), self.angle)

    def _slider(self, low: int, high: int, message: Callable[[int], object]) -> QtWidgets.QSlider:
        slider = QtWidgets.QSlider(QtCore.Qt.Orientation.Horizontal)
        slider.setRange(low, high)
        slider.valueChanged.connect(message)
        return slider

    def show_settings(self, settings: HandSettings) -> None:
        """Show the hand's settings."""
        for slider, value in (
            (self.smoothing, settings.smoothing),
            (self.mouse, settings.mouse_smoothing),
            (self.trail, settings.trail),
        ):
            with QtCore.QSignalBlocker(slider):
                slider.setValue(round(100 * value))
        with QtCore.QSignalBlocker(self.by_speed):
            self.by_speed.setChecked(settings.pressure_by == "speed")
        self.curve.curve = settings.curve
        self.curve.update()

    def show_force(self, newtons: float) -> None:
        """Show a mouse's force, whatever changed it."""
        if not self.force.isSliderDown():
            with QtCore.QSignalBlocker(self.force):
                self.force.setValue(round(100.0 * newtons / MAX_FORCE_N))

    def _choose_ruler(self, _: int) -> None:
        kind = self.ruler.currentData()
        self._last_ruler = kind if kind != "none" else self._last_ruler
        self.read.emit({"ruler": kind})
        self.ruled.emit(kind != "none")

    def set_ruler(self, on: bool) -> None:
        """Lead strokes along the ruler that was chosen last, or along none."""
        self.ruler.setCurrentIndex(self.ruler.findData(self._last_ruler if on else "none"))

    def set_smoothing(self, fraction: float) -> None:
        """Steady the stroke so much, 0 to 1."""
        self.smoothing.setValue(round(100 * fraction))

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self.curve.theme = theme
        self.curve.update()

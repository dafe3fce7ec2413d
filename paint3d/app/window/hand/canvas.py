"""The picture one paints on: the stage's pixels in a widget, and what the hand does over it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.input.event_clock import EventClock
from paint3d.app.model.input.fingers import Fingers, Meaning
from paint3d.core.arrays import AnyArray
from paint3d.view.live_layers import Box

__all__ = [
    "WRITING",
    "CanvasWidget",
    "Drag",
    "Touch",
    "pressure_of_contact",
    "touch_of_mouse",
    "touch_of_tablet",
]

# ---- Touches -------------------------------------------------------------------------------------
# Mouse, pen and finger events as readings of one kind.


_LEAST_MM, _LIGHT_MM, _FIRM_MM = 2.0, 4.0, 16.0  # across the contact of a fingertip
_CAN = QtGui.QInputDevice.Capability
_LEFT = QtCore.Qt.MouseButton.LeftButton


@dataclass(frozen=True)
class Touch:
    """A position of a mouse, a pen or a finger, and how it is held.

    Attributes
    ----------
    time_ns : int
        When it happened, by `EventClock`.
    x, y : float
        In the canvas, its pixels as the window system counts them, y down.
    pressure : float or None
        0 to 1; None from a mouse, and from a finger on a screen that does not say.
    tilt_x, tilt_y : float
        Lean of the pen to the right and toward the user, rad; 0 upright.
    twist : float
        About its axis, rad.
    down : bool
        Whether it touches: the left button, or the tip.
    eraser : bool
        The other end of the pen.
    bends : bool
        Whether Shift is held with a mouse: its motion turns the tuft's bend in place.
    """

    time_ns: int
    x: float
    y: float
    pressure: float | None = None
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    twist: float = 0.0
    down: bool = False
    eraser: bool = False
    bends: bool = False


def touch_of_mouse(event: QtGui.QMouseEvent, time_ns: int) -> Touch:
    """Return a mouse event as a touch."""
    position = event.position()
    down = bool(event.buttons() & _LEFT)
    bends = bool(event.modifiers() & QtCore.Qt.KeyboardModifier.ShiftModifier)
    return Touch(time_ns, position.x(), position.y(), down=down, bends=bends)


def pressure_of_contact(
    point: QtGui.QEventPoint, can: QtGui.QInputDevice.Capability, px_per_mm: float
) -> float | None:
    """Return a finger's pressure, 0 to 1, by the size of its contact.

    Parameters
    ----------
    point : QEventPoint
    can : QInputDevice.Capability
        What the screen reports of fingers.
    px_per_mm : float
        Of the picture's pixels.

    Returns
    -------
    float or None
        4 mm across is 0, 16 mm is 1. A screen without sizes gives its own pressure; None if it has
        neither, or reports a size of no fingertip.
    """
    size = point.ellipseDiameters()
    across = math.sqrt(max(0.0, size.width() * size.height())) / max(px_per_mm, 1e-6)
    if can & _CAN.Area and across >= _LEAST_MM:
        return min(1.0, max(0.02, (across - _LIGHT_MM) / (_FIRM_MM - _LIGHT_MM)))
    if can & _CAN.Pressure and 0.0 < point.pressure() < 1.0:
        return float(point.pressure())
    return None


def touch_of_tablet(event: QtGui.QTabletEvent, time_ns: int) -> Touch:
    """Return a pen's event as a touch; a pressure outside 0 to 1 is clipped."""
    position = event.position()
    pressure = min(max(0.0, event.pressure()), 1.0)  # in this order NaN becomes 0
    is_release = event.type() == QtCore.QEvent.Type.TabletRelease  # of any button, and maybe stale
    return Touch(
        time_ns,
        position.x(),
        position.y(),
        pressure,
        math.radians(event.xTilt()),
        math.radians(event.yTilt()),
        math.radians(event.rotation()),
        bool(event.buttons() & _LEFT) or (pressure > 0.0 and not is_release),
        event.pointerType() == _ERASER,
    )


# ---- The canvas ----------------------------------------------------------------------------------


WRITING = (QtWidgets.QLineEdit, QtWidgets.QAbstractSpinBox, QtWidgets.QPlainTextEdit)
"""Widgets that want every key for themselves."""

_MM_PER_INCH = 25.4
_S = 1_000_000_000  # ns; all of these by the events' own times, however late they arrive:
_PEN_LEFT_NS = 600 * _S  # for so long after a pen was seen, a finger alone does not paint
_PALM_NS = _S // 5  # for so long after a pen was seen, what touches is the hand that holds it
_STRAY_NS = _S // 10  # so shortly before or after a pen's touch, a mouse's is made up by its driver
_PRESSURE_SLACK = 1e-3  # beyond 0 to 1: a driver's rounding
_KIND, _BUTTON, _KEY = QtCore.QEvent.Type, QtCore.Qt.MouseButton, QtCore.Qt.KeyboardModifier
_TOUCHES = (_KIND.TouchBegin, _KIND.TouchUpdate, _KIND.TouchEnd, _KIND.TouchCancel)
_RELEASED = QtGui.QEventPoint.State.Released
_ERASER = QtGui.QPointingDevice.PointerType.Eraser


@dataclass(frozen=True)
class Drag:
    """A drag that steers the view: its action, and its position, pixels, y down."""

    mode: str
    x: float
    y: float


class CanvasWidget(QtWidgets.QWidget):
    """Shows pixels; emits what pen, mouse, fingers and wheel do.

    Signals
    -------
    touched : Touch
        A pen, the mouse or a finger has moved, come down or gone up, to paint.
    taken_back : ()
        What a finger began was the beginning of a gesture of several.
    steered : (str, Drag)
        "begin", "move" or "end" of a drag that steers the view.
    gestured : Meaning
        Several fingers have moved or tapped.
    wheeled : (float, float, float)
        Notches of the wheel, and where.
    left : ()
        The pointer has gone out of the picture.
    resized : ()
    dropped : str
        A file was dropped here.
    untimed : ()
        A pen gives no times of its own; emitted once.
    misread : ()
        A pen gives a pressure outside 0 to 1; emitted once.

    Attributes
    ----------
    mode_at : callable
        Given x, y and the modifier keys; returns the mode of a drag that begins there, or None if
        it paints.
    grip_at : callable
        Given x and y; returns whether there is a handle to drag, where the brush does not paint.
    tool : callable or None
        Is given each `Touch` first, from whatever hand, and returns whether it was for itself: then
        nothing is painted until that hand is lifted. While there is one, one finger is always such
        a hand. See `take_up`.
    finger : {"auto", "paint", "turn"}
        What one finger does; "auto": it paints until a pen was seen, then it turns.
    pen_seen_ns : int or None
        When a pen was here last.
    pixels : (H, W, 4) uint8 or None
        The picture, the first row at the top.
    """

    touched = QtCore.Signal(object)
    taken_back = QtCore.Signal()
    steered = QtCore.Signal(str, object)
    gestured = QtCore.Signal(object)
    wheeled = QtCore.Signal(float, float, float)
    left = QtCore.Signal()
    resized = QtCore.Signal()
    dropped = QtCore.Signal(str)
    untimed = QtCore.Signal()
    misread = QtCore.Signal()

    def __init__(self, parent: QtWidgets.QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setTabletTracking(True)
        self.setAcceptDrops(True)
        self.setAttribute(QtCore.Qt.WidgetAttribute.WA_AcceptTouchEvents)
        self.setFocusPolicy(QtCore.Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(320, 240)
        self.setAttribute(QtCore.Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setSizePolicy(
            QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Expanding
        )
        self.overlays: list[Callable[[QtGui.QPainter, QtCore.QRect], None]] = []
        self._image: QtGui.QImage | None = None
        self.pixels: AnyArray | None = None
        self.mode_at: Callable[..., str | None] = lambda x, y, keys: None
        self.grip_at: Callable[..., object] = lambda x, y: None
        self.tool: Callable[[Touch], bool] | None = None
        self._put_down: Callable[[], None] = lambda: None  # ends what the tool is for
        self._is_down = False
        self._had_by: Callable[[Touch], bool] | None = None  # the tool that the press was for
        self.finger = "auto"
        self._fingers = Fingers()
        self._mode: str | None = None  # of the drag that steers now
        self._by = ""  # what began it: "mouse", "pen" or "finger"
        self._finger_pressure: float | None = None
        self._pen_down = self._mouse_down = self._finger_down = self._palm = False
        self._pressed_ns = 0  # when mouse or finger came down last
        self._pen_touched_ns: int | None = None  # when a pen was down last, on whatever
        self._has_misread = False
        self.pen_seen_ns: int | None = None
        self._pen_handled_ns = 0  # when its last event was handed over
        self._clock = EventClock()

    @property
    def pixel_size(self) -> tuple[int, int]:
        """Width and height in the screen's own pixels, up to the last that it touches."""
        ratio = self.devicePixelRatioF()
        return max(1, math.ceil(self.width() * ratio)), max(1, math.ceil(self.height() * ratio))

    @property
    def is_steering(self) -> bool:
        """True during a drag that turns or moves the view."""
        return self._mode is not None

    def show_pixels(self, pixels: AnyArray, changed: Box | None = None) -> None:
        """Show (H, W, 4) uint8 pixels, the first row at the bottom.

        Parameters
        ----------
        pixels : (H, W, 4) uint8
        changed : Box, optional
            The part that differs from the picture before; None: all.
        """
        before = self._image
        self.pixels = np.ascontiguousarray(pixels[::-1])
        height, width = pixels.shape[:2]
        form = QtGui.QImage.Format.Format_RGBX8888
        self._image = QtGui.QImage(self.pixels.data, width, height, 4 * width, form)
        ratio = self.devicePixelRatioF()
        if changed is None or before is None or before.size() != self._image.size():
            self.update()
            return
        x0, y0, x1, y1 = (edge / ratio for edge in changed)
        box = QtCore.QRectF(x0, height / ratio - y1, x1 - x0, y1 - y0).toAlignedRect()
        self.update(box.adjusted(-1, -1, 1, 1))  # the widget may begin between two pixels

    # -- Qt's calls -------------------------------------------------------------------------

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Paint the picture, and what lies over it."""
        painter = QtGui.QPainter(self)
        painter.setClipRect(event.rect())
        if self._image is None:
            painter.fillRect(event.rect(), self.palette().window())
        else:
            self._draw(painter, self._image)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        for overlay in self.overlays:
            overlay(painter, self.rect())
        painter.end()

    def _draw(self, painter: QtGui.QPainter, image: QtGui.QImage) -> None:
        """Draw an image pixel for pixel, from the screen's pixel that the widget begins with.

        Where the screen's ratio is no whole number a widget may begin and end between two pixels.
        Stretched to it, a picture would have another pixel here and there, and not the same ones
        where a part of it is drawn.
        """
        if image.size() != QtCore.QSize(*self.pixel_size):  # of the size before
            painter.drawImage(self.rect(), image)
            return
        onto = painter.deviceTransform()
        left, top = (math.floor(start + 0.5) for start in (onto.dx(), onto.dy()))
        back, _ = onto.inverted()
        painter.save()
        painter.setWorldTransform(QtGui.QTransform.fromTranslate(left, top) * back)
        painter.drawImage(0, 0, image)
        painter.restore()

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        """Ask for a picture of the new size."""
        super().resizeEvent(event)
        self.resized.emit()

    def event(self, event: QtCore.QEvent) -> bool:
        """Take fingers, on the screen or on a touch pad."""
        if event.type() in _TOUCHES:
            self._take_fingers(cast(QtGui.QTouchEvent, event))
            event.accept()
            return True
        if isinstance(event, QtGui.QNativeGestureEvent) and self._take_native(event):
            return True
        return super().event(event)

    # -- mouse ------------------------------------------------------------------------------

    def mousePressEvent(self, event: QtGui.QMouseEvent) -> None:
        """Begin to steer with Alt, another button or beside the object; else the brush lands."""
        handled = time.perf_counter_ns()
        self.setFocus(QtCore.Qt.FocusReason.MouseFocusReason)
        event.accept()
        if self._mode is not None or self._mouse_down or self._pen_down or self._finger_down:
            return  # one thing after the other
        position = event.position()
        time_ns = self._time_ns("mouse", event, handled)
        pressed = handled if "mouse" in self._clock.untimed else time_ns  # not evened out
        if self._was_just(self._pen_touched_ns, pressed, _STRAY_NS):
            return
        self._pressed_ns = pressed
        mode = _steering_mode(event) or self.mode_at(position.x(), position.y(), event.modifiers())
        if mode is not None:
            self._begin(mode, "mouse", position)
        else:
            self._mouse_down = True
            self._touch(touch_of_mouse(event, time_ns))

    def mouseMoveEvent(self, event: QtGui.QMouseEvent) -> None:
        """Steer, or move the brush; what was pressed elsewhere, on a menu, does not paint."""
        handled = time.perf_counter_ns()
        event.accept()
        self._take_focus()
        position = event.position()
        self._mouse_down = self._mouse_down and bool(event.buttons() & _BUTTON.LeftButton)
        if self._by == "mouse":
            self._go_on(position)
        elif self._mouse_down or not (self._pen_down or self._finger_down or self._mode):
            if not self._mouse_down and self.grip_at(position.x(), position.y()):
                self.left.emit()
            else:
                touch = touch_of_mouse(event, self._time_ns("mouse", event, handled))
                self._touch(replace(touch, down=self._mouse_down))

    def mouseReleaseEvent(self, event: QtGui.QMouseEvent) -> None:
        """Stop steering, or lift the brush."""
        handled = time.perf_counter_ns()
        event.accept()
        if self._by == "mouse":
            if not event.buttons():
                self._end(event.position())
        elif self._mouse_down and not event.buttons() & _BUTTON.LeftButton:
            time_ns = self._time_ns("mouse", event, handled)
            self._mouse_down = False
            self._touch(touch_of_mouse(event, time_ns))

    def _time_ns(self, kind: str, event: QtGui.QPointerEvent, handled: int) -> int:
        """Return the time of an event that was handed over at `handled`, ns."""
        known = len(self._clock.untimed)
        painting = self._pen_down or self._mouse_down or self._finger_down
        if kind == "touch":
            painting = event.type() != _KIND.TouchBegin
        when_ns = self._clock.time_ns(kind, event.timestamp(), handled, painting)
        if kind == "pen" and len(self._clock.untimed) > known:
            self.untimed.emit()
        return when_ns

    def _take_focus(self) -> None:
        """Take the focus from a button that was clicked, once the pointer is back."""
        focus = QtWidgets.QApplication.focusWidget()
        if focus is not self and self.isActiveWindow() and not isinstance(focus, WRITING):
            self.setFocus(QtCore.Qt.FocusReason.MouseFocusReason)

    # -- pen --------------------------------------------------------------------------------

    def tabletEvent(self, event: QtGui.QTabletEvent) -> None:
        """Paint or steer with the pen; accepted, so that no mouse events are made of it."""
        handled = time.perf_counter_ns()
        event.accept()
        self._take_focus()
        self._pen_handled_ns = handled
        time_ns = self.pen_seen_ns = self._time_ns("pen", event, handled)
        is_pressure = -_PRESSURE_SLACK <= event.pressure() <= 1.0 + _PRESSURE_SLACK
        if not (self._has_misread or is_pressure):
            self._has_misread = True
            self.misread.emit()
        position = event.position()
        if self._by == "pen":  # steering, until tip and buttons are released
            self._pen_touched_ns = time_ns
            is_over = event.type() == _KIND.TabletRelease and not event.buttons()
            (self._end if is_over else self._go_on)(position)
            return
        if event.type() == _KIND.TabletPress and not self._pen_down:
            self._take_over(time_ns, position)
            self._pen_touched_ns = time_ns
            self.setFocus(QtCore.Qt.FocusReason.MouseFocusReason)
            mode = _pen_steering_mode(event)
            if mode is None and event.pointerType() != _ERASER:
                mode = self.mode_at(position.x(), position.y(), event.modifiers())
            if mode is not None:
                self._begin(mode, "pen", position)
                return
        touch = touch_of_tablet(event, time_ns)
        was_down = self._pen_down
        self._pen_down = touch.down and (was_down or event.type() == _KIND.TabletPress)
        touch = replace(touch, down=self._pen_down)
        if touch.down or was_down:
            self._pen_touched_ns = time_ns
            self._touch(touch)  # a stroke ends on a grip, too
        elif not self.grip_at(position.x(), position.y()):
            self._touch(touch)
        else:
            self.left.emit()

    def _take_over(self, time_ns: int, position: QtCore.QPointF) -> None:
        """Give the picture to a pen that comes down: what mouse or finger do ends there.

        What they began just before is taken back: a mouse's press was made up by the pen's driver,
        a finger's was the hand that holds the pen.
        """
        if self._by:
            self._end(position)
        if self._mouse_down or self._finger_down:
            self._mouse_down = self._finger_down = False
            if self._had_by is None and time_ns - self._pressed_ns < _STRAY_NS:
                self._is_down = False
                self.taken_back.emit()
            else:
                self._touch(Touch(time_ns, position.x(), position.y()))
        self._fingers.cancel(time_ns)
        self._palm = True  # until all fingers are lifted

    # -- fingers ----------------------------------------------------------------------------

    def _take_fingers(self, event: QtGui.QTouchEvent) -> None:
        """Follow fingers, unless they belong to the hand that holds the pen."""
        now = self._time_ns("touch", event, time.perf_counter_ns())
        if event.type() == _KIND.TouchBegin:
            self._palm = self._pen_down or self._saw_pen(now, _PALM_NS)
        if self._palm:
            return
        fingers = [point for point in event.points() if point.state() != _RELEASED]
        if len(fingers) == 1:
            can = event.pointingDevice().capabilities()
            px_per_mm = self.screen().physicalDotsPerInch() / _MM_PER_INCH
            self._finger_pressure = pressure_of_contact(fingers[0], can, px_per_mm)
        if event.type() == _KIND.TouchCancel:
            meanings = self._fingers.cancel(now)
        else:
            positions = {p.id(): (p.position().x(), p.position().y()) for p in fingers}
            meanings = self._fingers.follow(now, positions)
        for one in meanings:
            self._do_fingers(one)

    def _do_fingers(self, meant: Meaning) -> None:
        if meant.kind in ("turn", "pinch", "tap"):
            self.gestured.emit(meant)
            return
        position = QtCore.QPointF(meant.x, meant.y)
        if meant.kind == "press":
            self.setFocus(QtCore.Qt.FocusReason.MouseFocusReason)
            mode = self.mode_at(meant.x, meant.y, _KEY.NoModifier)
            if mode is None and not self._finger_paints(meant.time_ns):
                mode = "orbit"
            if mode is not None:
                self._begin(mode, "finger", position)
                return
        if self._by == "finger":
            (self._go_on if meant.kind == "move" else self._end)(position)
        elif meant.kind == "cancel":
            self._finger_down = self._is_down = False
            self.taken_back.emit()
        else:
            if meant.kind == "press":
                self._pressed_ns = meant.time_ns
            down = self._finger_down = meant.kind != "release"
            pressure = self._finger_pressure
            self._touch(Touch(meant.time_ns, meant.x, meant.y, pressure, down=down))
            if not down:
                self.left.emit()  # a finger that has left points at nothing

    def _finger_paints(self, time_ns: int) -> bool:
        if self.tool is not None:
            return True
        if self.finger != "auto":
            return self.finger == "paint"
        return not self._saw_pen(time_ns, _PEN_LEFT_NS)

    def _saw_pen(self, time_ns: int, within_ns: int) -> bool:
        """Return whether a pen was here so shortly before."""
        return self._was_just(self.pen_seen_ns, time_ns, within_ns)

    def _was_just(self, pen_ns: int | None, time_ns: int, within_ns: int) -> bool:
        """Return whether the pen did something so shortly before, by its event's time.

        Where a pen's times lie ahead, all that others do seems to follow at once; not later than a
        picture takes after the pen's last event was handed over.
        """
        waited_ns = time.perf_counter_ns() - self._pen_handled_ns
        return pen_ns is not None and time_ns - pen_ns < within_ns and waited_ns < within_ns + _S

    def _take_native(self, event: QtGui.QNativeGestureEvent) -> bool:
        """Take fingers on a touch pad, which pinch and roll; return whether they did."""
        kind, position = event.gestureType(), event.position()
        at = time.perf_counter_ns(), position.x(), position.y()
        if kind == QtCore.Qt.NativeGestureType.ZoomNativeGesture:
            self.gestured.emit(Meaning("pinch", *at, factor=max(0.1, 1.0 + event.value())))
        elif kind == QtCore.Qt.NativeGestureType.RotateNativeGesture:
            self.gestured.emit(Meaning("pinch", *at, angle=-math.radians(event.value())))
        else:
            return False
        return True

    # -- tools ------------------------------------------------------------------------------

    def take_up(self, tool: Callable[[Touch], bool], put_down: Callable[[], None]) -> None:
        """Give the touches to a tool; one that had them before is put down.

        Parameters
        ----------
        tool : callable
            As `tool`.
        put_down : callable
            Called when another tool is taken up: ends what this one is for, and lays it down.
        """
        if self.tool is not None:
            self._put_down()
        self.tool, self._put_down = tool, put_down

    def lay_down(self, tool: Callable[[Touch], bool]) -> None:
        """Give the touches back to the brush, if this tool has them."""
        if self.tool == tool:
            self.tool = None

    def _touch(self, touch: Touch) -> None:
        """Hand a pen's, a mouse's or a finger's touch to the tool, or let it paint.

        Until it is lifted it belongs to the one it came down for, whatever is taken up meanwhile.
        """
        if not self._is_down:
            tool = self.tool
            self._had_by = tool if tool is not None and tool(touch) else None
        elif self._had_by is not None and self._had_by == self.tool:
            self._had_by(touch)
        self._is_down = touch.down
        if self._had_by is None:
            self.touched.emit(touch)

    # -- steering ---------------------------------------------------------------------------

    def _begin(self, mode: str, by: str, position: QtCore.QPointF) -> None:
        self._mode, self._by = mode, by
        self.steered.emit("begin", Drag(mode, position.x(), position.y()))

    @property
    def _steering(self) -> str:
        assert self._mode is not None, "a drag goes on"
        return self._mode

    def _go_on(self, position: QtCore.QPointF) -> None:
        self.steered.emit("move", Drag(self._steering, position.x(), position.y()))

    def _end(self, position: QtCore.QPointF) -> None:
        mode, self._mode, self._by = self._steering, None, ""
        self.steered.emit("end", Drag(mode, position.x(), position.y()))

    def wheelEvent(self, event: QtGui.QWheelEvent) -> None:
        """Emit the wheel's notches."""
        position = event.position()
        self.wheeled.emit(event.angleDelta().y() / 120.0, position.x(), position.y())
        event.accept()

    def leaveEvent(self, event: QtCore.QEvent) -> None:
        """Emit that the pointer has left."""
        super().leaveEvent(event)
        self.left.emit()

    def dragEnterEvent(self, event: QtGui.QDragEnterEvent) -> None:
        """Accept a single file."""
        urls = event.mimeData().urls()
        if len(urls) == 1 and urls[0].isLocalFile():
            event.acceptProposedAction()

    def dropEvent(self, event: QtGui.QDropEvent) -> None:
        """Open the file."""
        self.dropped.emit(event.mimeData().urls()[0].toLocalFile())
        event.acceptProposedAction()


def _steering_mode(event: QtGui.QMouseEvent) -> str | None:
    """Return the mode by which a mouse's buttons and keys steer; None if they do not."""
    keys, button = event.modifiers(), event.button()
    if button == _BUTTON.RightButton:
        return "dolly"
    if button == _BUTTON.MiddleButton:
        if keys & _KEY.ControlModifier:
            return "dolly"
        return "pan" if keys & (_KEY.ShiftModifier | _KEY.AltModifier) else "orbit"
    return "orbit" if keys & _KEY.AltModifier or button != _BUTTON.LeftButton else None


def _pen_steering_mode(event: QtGui.QTabletEvent) -> str | None:
    """Return the mode of a pen's buttons, which Qt counts as right and middle, or of Alt."""
    if event.buttons() & _BUTTON.MiddleButton:
        return "pan"
    turns = event.buttons() & _BUTTON.RightButton or event.modifiers() & _KEY.AltModifier
    return "orbit" if turns else None

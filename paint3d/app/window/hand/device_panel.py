"""The devices: what each hand holds, how hard it presses, how punctually it speaks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.frame import PaintingFrame
from paint3d.app.model.input.devices import DeviceHub, DeviceView
from paint3d.app.window.status_line import keeping_up
from paint3d.app.window.theme import STATES, Theme
from paint3d.app.window.wording import say, say_error
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import MAX_FORCE_N
from paint3d.device.six_dof import AXES
from paint3d.errors import Message
from paint3d.haptics.settings import Feel
from paint3d.haptics.stylus_choice import STYLI
from paint3d.pose.mouse_settings import ACTIONS, MODES, MouseSettings
from paint3d.pose.steering import SteeringOptions
from paint3d.pose.touching import SHEET_MM

__all__ = ["DevicePanel", "HandsPicture", "MouseForm", "StylusForm"]

# ---- Forms ---------------------------------------------------------------------------------------
# Settings of the hands' devices: the stylus that pushes back, the 6-DOF mouse.


_STYLUS_NAMES = {
    "auto": Message("The first there is"),
    "hid": Message("HID protocol of paint3d"),
    "openhaptics": Message("OpenHaptics (Touch, Phantom)"),
    "inverse3": Message("Haply Inverse3"),
    "none": Message("None"),
}
_HANDS = {"left": Message("Left hand"), "right": Message("Right hand")}
_MODE_NAMES = {"object": Message("the object"), "camera": Message("the viewer")}
_ACTION_NAMES = {
    "": Message("Nothing"),
    "recentre": Message("Recentre"),
    "dip": Message("Dip"),
    "undo": Message("Undo"),
    "redo": Message("Redo"),
    "toggle_turning": Message("Lock turning"),
    "toggle_moving": Message("Lock moving"),
    "toggle_dominant_axis": Message("One axis at a time"),
    "toggle_camera": Message("Object or viewer"),
    "calibrate_rest": Message("The cap rests here"),
}
_MOTIONS = (
    Message("Right by"),
    Message("Away by"),
    Message("Up by"),
    Message("Turn about right by"),
    Message("Turn about away by"),
    Message("Turn about up by"),
)
_MOST_BUTTONS = 31
_BY_BUTTONS = ("moving", "turning", "dominant_axis", "mode")  # what buttons toggle


class _Form(QtWidgets.QWidget):
    """Rows with a label each."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self._form = QtWidgets.QFormLayout(self)
        self._form.setContentsMargins(0, 6, 0, 0)
        head = QtWidgets.QLabel(title)
        head.setObjectName("title")
        self._form.addRow(head)

    def _box(self, label: str, choices: Mapping[str, str]) -> QtWidgets.QComboBox:
        box = QtWidgets.QComboBox()
        box.setSizeAdjustPolicy(
            QtWidgets.QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        for value, text in choices.items():
            box.addItem(say(text), value)
        self._form.addRow(label, box)
        return box

    def _number(
        self, label: str, low: float, high: float, unit: str, digits: int = 0
    ) -> QtWidgets.QDoubleSpinBox:
        box = QtWidgets.QDoubleSpinBox()
        box.setDecimals(digits)
        box.setRange(low, high)
        box.setSuffix(f" {unit}")
        box.setKeyboardTracking(False)
        self._form.addRow(label, box)
        return box


class StylusForm(_Form):
    """Settings of the haptic stylus: its kind, its greatest force, its calibration.

    Signals
    -------
    chosen : str
        One of `STYLI`, also if it was chosen before: to try again.
    felt : dict of str to float
        Changes of `Feel` by name.
    calibrated : (float, float)
        The corners of a sheet are to be touched that is so wide and deep, mm; (0, 0) stops it.
    touched : ()
        The corner that was asked for is touched now: for a stylus without a button.
    """

    chosen = QtCore.Signal(str)
    felt = QtCore.Signal(object)
    calibrated = QtCore.Signal(float, float)
    touched = QtCore.Signal()

    def __init__(self) -> None:
        super().__init__(say("Stylus that pushes back"))
        self.kind = self._box(say("Reached by"), {kind: _STYLUS_NAMES[kind] for kind in STYLI})
        self.kind.activated.connect(lambda: self.chosen.emit(self.kind.currentData()))
        self.limit = self._number(say("Pushes at most"), 0.0, 7.9, "N", 1)
        self.limit.valueChanged.connect(lambda n: self.felt.emit({"limit_n": n}))
        self.ahead = self._number(say("Felt before contact"), 0.0, 20.0, "mm")
        self.ahead.valueChanged.connect(lambda n: self.felt.emit({"anticipation_mm": n}))
        self.click = self._number(say("Click at a dip"), 0.0, 1.0, "N", 1)
        self.click.valueChanged.connect(lambda n: self.felt.emit({"click_n": n}))
        self.texture = self._number(say("Grain is felt"), 0.0, 1.0, "", 1)
        self.texture.setSingleStep(0.1)
        self.texture.valueChanged.connect(lambda n: self.felt.emit({"texture": n}))
        self.width_box = self._number(say("Sheet to touch, wide"), 20.0, 2000.0, "mm")
        self.depth_box = self._number(say("and deep"), 20.0, 2000.0, "mm")
        for box, value in zip((self.width_box, self.depth_box), SHEET_MM, strict=True):
            box.setValue(value)
        self.calibrate = QtWidgets.QPushButton(say("Calibrate…"))
        self.calibrate.setToolTip(say("Touch the four corners of a sheet on the table"))
        self.calibrate.clicked.connect(self._ask)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setObjectName("faint")
        self.message_label.setWordWrap(True)
        self.touches = QtWidgets.QPushButton(say("It touches"))
        self.touches.setToolTip(say("For a stylus without a button, by the other hand"))
        self.touches.setEnabled(False)
        self.touches.clicked.connect(self.touched)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.calibrate, 1)
        row.addWidget(self.touches, 1)
        self._form.addRow(row)
        self._form.addRow(self.message_label)
        self._going_on = False

    def show_choices(self, stylus: str, feel: Feel) -> None:
        """Show what is chosen."""
        kind = stylus.partition("=")[0]
        self.kind.setCurrentIndex(max(0, self.kind.findData(kind)))
        for box, value in (
            (self.limit, feel.limit_n),
            (self.ahead, feel.anticipation_mm),
            (self.click, feel.click_n),
            (self.texture, feel.texture),
        ):
            with QtCore.QSignalBlocker(box):
                box.setValue(value)

    def show_calibrating(self, message: str, going_on: bool) -> None:
        """Show which corner is to be touched next, or the result."""
        self._going_on = going_on
        self.message_label.setText(message)
        self.calibrate.setText(say("Cancel") if going_on else say("Calibrate…"))
        self.touches.setEnabled(going_on)

    def _ask(self) -> None:
        sheet = (0.0, 0.0) if self._going_on else (self.width_box.value(), self.depth_box.value())
        self.calibrated.emit(*sheet)


class MouseForm(_Form):
    """Settings of the 6-DOF mouse and of its buttons.

    Signals
    -------
    read : MouseSettings
    pressed : (int, str)
        A button, from 0, is to do this from now on; "": nothing.
    """

    read = QtCore.Signal(object)
    pressed = QtCore.Signal(int, str)

    def __init__(self) -> None:
        super().__init__(say("6-DOF mouse"))
        self._actions: Mapping[int, str] = {}
        self._mouse = MouseSettings()
        self.mode = self._choice(
            say("The cap is"), "mode", {mode: _MODE_NAMES[mode] for mode in MODES}
        )
        self.speed = self._scaled(say("Moves"), "speed_mm_s", (0.0, 5000.0), "mm/s")
        self.turn = self._scaled(say("Turns"), "turn_deg_s", (0.0, 2800.0), "°/s")
        self.dead_zone = self._scaled(say("Dead zone"), "dead_zone", (0.0, 90.0), "%", 0.01)
        self.curve = self._scaled(say("Finer near rest"), "curve", (1.0, 4.0), "", digits=1)
        self.moving = self._check(say("It moves"), "moving")
        self.turning = self._check(say("It turns"), "turning")
        self.dominant = self._check(say("One axis at a time"), "dominant_axis")
        zooms = {"y": Message("the cap is pushed"), "z": Message("the cap is lifted")}
        self.zoom = self._choice(say("Comes near when"), "zoom_axis", zooms)
        signed = {sign + axis: sign + axis for axis in AXES for sign in ("", "-")}
        self.axes = [self._box(say(motion), signed) for motion in _MOTIONS]
        for k, box in enumerate(self.axes):
            box.activated.connect(self._swapper(k))
        self.button = QtWidgets.QSpinBox()
        self.button.setRange(1, _MOST_BUTTONS)
        self._form.addRow(say("Button"), self.button)
        self.action = self._box(say("does"), {a: _ACTION_NAMES[a] for a in ("", *ACTIONS)})
        self.button.valueChanged.connect(lambda: self._show_action())
        self.action.activated.connect(
            lambda: self.pressed.emit(self.button.value() - 1, self.action.currentData())
        )

    def _choice(self, label: str, name: str, choices: Mapping[str, str]) -> QtWidgets.QComboBox:
        box = self._box(label, choices)
        box.activated.connect(lambda: self._change(name, box.currentData()))
        return box

    def _scaled(
        self,
        label: str,
        name: str,
        span: tuple[float, float],
        unit: str,
        scale: float = 1.0,
        digits: int = 0,
    ) -> QtWidgets.QDoubleSpinBox:
        box = self._number(label, *span, unit, digits)
        box.valueChanged.connect(lambda value: self._change(name, scale * value))
        return box

    def _check(self, label: str, name: str) -> QtWidgets.QCheckBox:
        check = QtWidgets.QCheckBox(label)
        check.toggled.connect(lambda on: self._change(name, on))
        self._form.addRow(check)
        return check

    def _change(self, name: str, value: object) -> None:
        changes: dict[str, Any] = {name: value}
        self._mouse = replace(self._mouse, **changes)
        self.read.emit(self._mouse)

    def show_choices(self, mouse: MouseSettings, actions: Mapping[int, str]) -> None:
        """Show what is chosen."""
        self._actions, self._mouse = actions, mouse
        numbers = (
            (self.speed, mouse.speed_mm_s),
            (self.turn, mouse.turn_deg_s),
            (self.dead_zone, 100.0 * mouse.dead_zone),
            (self.curve, mouse.curve),
        )
        for box, value in numbers:
            with QtCore.QSignalBlocker(box):
                box.setValue(value)
        self._show_locks()
        self.zoom.setCurrentIndex(self.zoom.findData(mouse.zoom_axis))
        for choice, axis in zip(self.axes, mouse.axes, strict=True):
            choice.setCurrentIndex(choice.findData(axis))
        self._show_action()

    def show_locks(self, steering: SteeringOptions) -> None:
        """Show what the mouse's own buttons locked or chose, which the next change keeps."""
        now = {name: getattr(steering, name) for name in _BY_BUTTONS}
        if any(getattr(self._mouse, name) != value for name, value in now.items()):
            self._mouse = replace(self._mouse, **now)
            self._show_locks()

    def _show_locks(self) -> None:
        mouse = self._mouse
        checks = (
            (self.moving, mouse.moving),
            (self.turning, mouse.turning),
            (self.dominant, mouse.dominant_axis),
        )
        for check, on in checks:
            with QtCore.QSignalBlocker(check):
                check.setChecked(on)
        self.mode.setCurrentIndex(self.mode.findData(mouse.mode))

    def _show_action(self) -> None:
        action = self._actions.get(self.button.value() - 1, "")
        self.action.setCurrentIndex(max(0, self.action.findData(action)))

    def _swapper(self, k: int) -> Callable[[], None]:
        """Return a slot that swaps axes: the chosen one's motion before gets the one given up."""

        def swap() -> None:
            wanted, axes = self.axes[k].currentData(), list(self._mouse.axes)
            old = axes[k]
            for other, axis in enumerate(axes):
                if other != k and axis.removeprefix("-") == wanted.removeprefix("-"):
                    axes[other] = old
            axes[k] = wanted
            for box, axis in zip(self.axes, axes, strict=True):
                box.setCurrentIndex(box.findData(axis))
            self._change("axes", tuple(axes))

        return swap


# ---- The panel -----------------------------------------------------------------------------------


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
        """Draw both hands and the force."""
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
        """Draw a cube as the left hand turns it, seen from the front and a little from above."""
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
        direction = QtCore.QPointF(x + 0.35 * y, -z - 0.25 * y)
        length = max(1e-6, math.hypot(direction.x(), direction.y()))
        direction *= 52.0 * min(1.0, length) / length
        tip += QtCore.QPointF(0, 34)
        pen = QtGui.QPen(QtGui.QColor("#b08850"), 6)
        pen.setCapStyle(QtCore.Qt.PenCapStyle.RoundCap)
        painter.setPen(pen)
        painter.drawLine(tip + direction * 0.4, tip + direction * 1.5)
        pen.setColor(QtGui.QColor(self.theme.text))
        pen.setWidthF(5 + 4 * self.force / MAX_FORCE_N)
        painter.setPen(pen)
        painter.drawLine(tip, tip + direction * 0.4)

    def _draw_force(self, painter: QtGui.QPainter, area: QtCore.QRectF) -> None:
        """Draw a gauge with a needle and the number: read by its shape, not by a colour."""
        centre = QtCore.QPointF(area.right() - area.width() / 6.2, area.center().y() + 18)
        radius = min(42.0, area.width() / 7.5)
        arc = QtCore.QRectF(centre.x() - radius, centre.y() - radius, 2 * radius, 2 * radius)
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.line), 5))
        painter.drawArc(arc, 0, 180 * 16)
        fraction = min(1.0, self.force / MAX_FORCE_N)
        painter.setPen(QtGui.QPen(QtGui.QColor(self.theme.accent), 5))
        painter.drawArc(arc, 180 * 16, -round(180 * 16 * fraction))
        angle = math.pi * (1.0 - fraction)
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

    def show_desk(self, desk: DeviceHub | None, frame: PaintingFrame | None) -> None:
        """Show the devices that are plugged in, and how punctual they are."""
        views = [] if desk is None else desk.views()
        lines = [] if desk is None else _lines_of(desk, views)
        if not views:
            lines.append(f"{STATES['off']} {say('Nothing is plugged in: mouse and keys paint')}")
        state, message = keeping_up(frame)
        lines.append(f"{STATES[state]} {say('Painting')}: {message}")
        self.lines.setText("\n\n".join(lines))

    def set_theme(self, theme: Theme) -> None:
        """Use other colours."""
        self._theme = self.picture.theme = theme
        self.picture.update()


def _lines_of(desk: DeviceHub, views: Sequence[DeviceView]) -> list[str]:
    """Return a line for each device, and one for lost events."""
    lines = []
    for view in views:
        if not view.is_open:
            why = "" if view.error is None else say_error(view.error)
            lines.append(f"{STATES['bad']} {view.name}\n     {why}")
            continue
        late, rate = desk.lateness_ms(view.hand), desk.rate_hz(view.hand)
        state = STATES["slow" if late > _LATE_MS else "good"]
        message = f"{say('{hz:.0f} Hz', hz=rate)}, {say('{ms:.1f} ms late', ms=late)}"
        hand = say(_HANDS[view.hand])
        lines.append(f"{state} {view.name}\n     {hand}: {message}")
    if desk.lost():
        lines.append(f"{STATES['slow']} {say('{count} lost', count=desk.lost())}")
    return lines

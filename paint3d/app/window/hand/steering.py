"""Turning, moving, rolling and zooming the view: by drags, grips, fingers, wheel and keys."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from PySide6 import QtCore, QtGui

from paint3d.app.model.commands import COMMANDS
from paint3d.app.model.input import navigation
from paint3d.app.model.input.fingers import Meaning
from paint3d.app.window.hand.canvas import CanvasWidget, Drag
from paint3d.app.window.hand.canvas_hand import ADJUSTED, CanvasHand
from paint3d.app.window.theme import Theme, make_icon
from paint3d.app.window.wording import say
from paint3d.view.camera import Camera

__all__ = ["GRIPS", "STEPS", "Grips", "Steering"]

# ---- Grips ---------------------------------------------------------------------------------------
# Grips on the picture that turn, move, zoom and roll it, for a pen without buttons and keys.


GRIPS = ("orbit", "pan", "dolly", "roll")
"""From the top, each by the name of its action."""

_ICONS = {"orbit": "orbit", "pan": "move", "dolly": "zoom", "roll": "roll"}
_SIZE, _GAP, _MARGIN = 36, 8, 14
_EDGE = 2  # around what is drawn, for its lines


class Grips:
    """A column of round grips in the upper right corner of a canvas.

    Parameters
    ----------
    theme : callable
        Returns the colours to use.

    Attributes
    ----------
    shown : bool
    held, under : str or None
        The grip that is held, and the one under the pointer.
    """

    def __init__(self, theme: Callable[[], Theme]) -> None:
        self._theme = theme
        self.shown = True
        self.held: str | None = None
        self.under: str | None = None
        self._looks: tuple[Theme, str | None, str | None, float] | None = None
        self._drawn = QtGui.QPixmap()

    def box(self, name: str, area: QtCore.QRect) -> QtCore.QRectF:
        """Return a grip's rectangle in a picture."""
        top = _MARGIN + GRIPS.index(name) * (_SIZE + _GAP)
        return QtCore.QRectF(area.right() + 1 - _MARGIN - _SIZE, area.top() + top, _SIZE, _SIZE)

    def at(self, x: float, y: float, area: QtCore.QRect) -> str | None:
        """Return the grip at a point, or None."""
        if not self.shown:
            return None
        point = QtCore.QPointF(x, y)
        half = 0.5 * _GAP
        return next(
            (
                n
                for n in GRIPS
                if self.box(n, area).adjusted(-half, -half, half, half).contains(point)
            ),
            None,
        )

    def tool_tip(self, name: str) -> str:
        """Return a grip's tool tip."""
        return say("Drag: {action}", action=say(COMMANDS[name].text)) + {
            "roll": f"\n{say('Tap: {action}', action=say('Hold upright'))}",
            "dolly": f"\n{say('Tap: {action}', action=say('Show everything'))}",
        }.get(name, "")

    def paint(self, painter: QtGui.QPainter, area: QtCore.QRect) -> None:
        """Draw the grips."""
        if not self.shown:
            return
        looks = self._theme(), self.held, self.under, painter.device().devicePixelRatioF()
        if looks != self._looks:
            self._looks, self._drawn = looks, self._draw(looks[0], looks[3])
        corner = self.box(GRIPS[0], area).topLeft()
        painter.drawPixmap(corner - QtCore.QPointF(_EDGE, _EDGE), self._drawn)

    def _draw(self, theme: Theme, pixel_ratio: float) -> QtGui.QPixmap:
        """Draw the whole column once, as every picture shows it and its icons take 4 ms."""
        high = len(GRIPS) * (_SIZE + _GAP) - _GAP
        size = QtCore.QSize(_SIZE + 2 * _EDGE, high + 2 * _EDGE)
        column = QtGui.QPixmap(size * pixel_ratio)
        column.setDevicePixelRatio(pixel_ratio)
        column.fill(QtCore.Qt.GlobalColor.transparent)
        painter = QtGui.QPainter(column)
        painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
        for k, name in enumerate(GRIPS):
            box = QtCore.QRectF(_EDGE, _EDGE + k * (_SIZE + _GAP), _SIZE, _SIZE)
            marked = name in (self.held, self.under)
            fill = QtGui.QColor(theme.chosen if name == self.held else theme.panel)
            fill.setAlpha(235 if marked else 150)
            painter.setPen(QtGui.QPen(QtGui.QColor(theme.accent if marked else theme.line), 1.2))
            painter.setBrush(fill)
            painter.drawEllipse(box)
            inner = box.adjusted(8, 8, -8, -8).toRect()
            make_icon(_ICONS[name], theme).paint(painter, inner)
        painter.end()
        return column


# ---- Steering ------------------------------------------------------------------------------------


_NEARER_A_NOTCH, _NEARER_A_PIXEL = 1.14, 1.006
_LEAP = 1000.0  # pixels between two events of a drag that count
_BESIDE = 24.0  # pixels that a drag begins away from the object, to turn it
_AROUND = [(0.0, 0.0), *((math.cos(k * math.pi / 4), math.sin(k * math.pi / 4)) for k in range(8))]
_TAP = 4.0  # pixels that a tap on a grip moves at most
_TURN_STEP, _MOVE_STEP = 1.0 / 24.0, 1.0 / 16.0  # of the picture's height
_ROLL_STEP = math.radians(7.5)
_TAPPED = {"roll": "upright", "dolly": "frame_all"}  # command of a tap on a grip
_FINGERS_TAPPED = {2: "undo", 3: "redo"}

STEPS: dict[str, tuple[str, float, float]] = {
    "turn_left": ("orbit", -_TURN_STEP, 0.0),
    "turn_right": ("orbit", _TURN_STEP, 0.0),
    "turn_up": ("orbit", 0.0, -_TURN_STEP),
    "turn_down": ("orbit", 0.0, _TURN_STEP),
    "pan_left": ("pan", -_MOVE_STEP, 0.0),
    "pan_right": ("pan", _MOVE_STEP, 0.0),
    "pan_up": ("pan", 0.0, -_MOVE_STEP),
    "pan_down": ("pan", 0.0, _MOVE_STEP),
    "nearer": ("dolly", _NEARER_A_NOTCH, 0.0),
    "farther": ("dolly", 1.0 / _NEARER_A_NOTCH, 0.0),
    "roll_left": ("roll", _ROLL_STEP, 0.0),
    "roll_right": ("roll", -_ROLL_STEP, 0.0),
}
"""Actions that move the view a step: how, and how far (fractions of the picture's height, a factor,
or rad)."""


class Steering(QtCore.QObject):
    """Joins what steers the view to the camera of one canvas.

    Parameters
    ----------
    canvas : CanvasWidget
    hand : CanvasHand
        Has the camera.
    theme : callable
        Returns the colours of the grips.

    Signals
    -------
    asked : str
        An action that was asked for by a tap.
    """

    asked = QtCore.Signal(str)

    def __init__(self, canvas: CanvasWidget, hand: CanvasHand, theme: Callable[[], Theme]) -> None:
        super().__init__(canvas)
        self._canvas, self._hand = canvas, hand
        self.grips = Grips(theme)
        self._from = 0.0, 0.0
        self._travel = 0.0
        canvas.mode_at, canvas.grip_at = self.mode_at, self.grip_at
        canvas.steered.connect(self._steer)
        canvas.wheeled.connect(self._wheel)
        canvas.gestured.connect(self._gesture)
        canvas.overlays.append(self.grips.paint)

    # -- pressing ---------------------------------------------------------------------------

    def grip_at(self, x: float, y: float) -> str | None:
        """Return the grip under the pointer; mark it and show its tool tip."""
        if self._hand.camera is None:
            return None
        grip = self.grips.at(x, y, self._canvas.rect())
        if grip != self.grips.under:
            self.grips.under = grip
            self._canvas.setToolTip(self.grips.tool_tip(grip) if grip else "")
            self._canvas.update()
        return grip

    def mode_at(self, x: float, y: float, keys: QtCore.Qt.KeyboardModifier) -> str | None:
        """Return the mode of a drag that begins here; None: it paints."""
        if self._hand.camera is None or self._hand.held & ADJUSTED:
            return None
        if "steer" in self._hand.held:
            return _mode_with_space(keys)
        grip = self.grip_at(x, y)
        if grip is None and self._is_beside(x, y):
            return "orbit"
        if grip != self.grips.held:
            self.grips.held = grip
            self._canvas.update()
        return grip

    def _is_beside(self, x: float, y: float) -> bool:
        """Return whether the object is neither here nor close by."""
        points = np.array([x, y]) + _BESIDE * np.array(_AROUND)
        return not self._hand.meets(points).any()

    # -- drags, wheel, fingers --------------------------------------------------------------

    def _steer(self, what: str, drag: Drag) -> None:
        if self._hand.camera is None:
            return
        if what == "begin":
            self._from, self._travel = (drag.x, drag.y), 0.0
            self._hand.leave()  # a pointer that moves the view is no brush
            self._canvas.setCursor(QtCore.Qt.CursorShape.ClosedHandCursor)
        elif what == "move":
            dx, dy = drag.x - self._from[0], drag.y - self._from[1]
            self._travel += math.hypot(dx, dy)
            self._drag(drag.mode, dx, dy)
            self._from = drag.x, drag.y
        else:
            self._canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
            held, self.grips.held = self.grips.held, None
            self._canvas.update()
            if held in _TAPPED and self._travel < _TAP:
                self.asked.emit(_TAPPED[held])

    def _drag(self, mode: str, dx: float, dy: float) -> None:
        """Steer by a drag of (dx, dy) pixels from where the pointer was."""
        camera, height = self._hand.open_camera, self._canvas.height()
        if mode == "dolly":
            pixels = min(max(dx - dy, -_LEAP), _LEAP)
            self._look(navigation.dolly(camera, _NEARER_A_PIXEL**pixels))
        elif mode == "pan":
            self._look(navigation.pan(camera, dx, dy, height))
        elif mode == "roll":
            self._look(navigation.roll(camera, self._angle(dx, dy)))
        else:
            self._look(navigation.orbit(camera, dx, dy, height))

    def _angle(self, dx: float, dy: float) -> float:
        """Return a drag's angle, anticlockwise, rad.

        About the picture's middle; from the grip, which is far from there, as along a wheel's rim.
        """
        if self.grips.held == "roll":
            return -2.0 * math.pi * (dx + dy) / self._canvas.height()
        x, y = (
            self._from[0] - 0.5 * self._canvas.width(),
            self._from[1] - 0.5 * self._canvas.height(),
        )
        before, after = math.atan2(y, x), math.atan2(y + dy, x + dx)
        return math.remainder(before - after, 2.0 * math.pi)

    def _wheel(self, notches: float, x: float, y: float) -> None:
        if self._hand.camera is None or self._hand.take_wheel(notches):
            return
        factor = _NEARER_A_NOTCH**notches
        self._look(navigation.zoom_at(self._hand.camera, factor, x, y, self._size()))

    def _gesture(self, meant: Meaning) -> None:
        """Do a gesture of several fingers."""
        camera = self._hand.camera
        if camera is None:
            return
        if meant.kind == "tap":
            if meant.count in _FINGERS_TAPPED:
                self.asked.emit(_FINGERS_TAPPED[meant.count])
        elif meant.kind == "turn":
            self._look(navigation.orbit(camera, meant.dx, meant.dy, self._canvas.height()))
        else:
            moved = navigation.pan(camera, meant.dx, meant.dy, self._canvas.height())
            rolled = navigation.roll_at(moved, meant.angle, meant.x, meant.y, self._size())
            self._look(navigation.zoom_at(rolled, meant.factor, meant.x, meant.y, self._size()))

    # -- steps ------------------------------------------------------------------------------

    def step(self, action: str) -> None:
        """Move the view by one of `STEPS`."""
        camera = self._hand.camera
        if camera is None or self._hand.in_stroke:
            return
        how, x, y = STEPS[action]
        height = self._canvas.height()
        if how == "orbit":
            self._look(navigation.orbit(camera, x * height, y * height, height))
        elif how == "pan":
            self._look(navigation.pan(camera, x * height, y * height, height))
        elif how == "dolly":
            self._look(navigation.dolly(camera, x))
        else:
            self._look(navigation.roll(camera, x))

    def upright(self) -> None:
        """Roll the view upright."""
        camera = self._hand.camera
        if camera is not None:
            self._look(navigation.roll(camera, -navigation.roll_of(camera)))

    def _look(self, camera: Camera) -> None:
        self._hand.look(camera)

    def _size(self) -> tuple[int, int]:
        return self._canvas.width(), self._canvas.height()


def _mode_with_space(keys: QtCore.Qt.KeyboardModifier) -> str:
    shift = bool(keys & QtCore.Qt.KeyboardModifier.ShiftModifier)
    ctrl = bool(keys & QtCore.Qt.KeyboardModifier.ControlModifier)
    if shift and ctrl:
        return "roll"
    return "pan" if shift else "dolly" if ctrl else "orbit"

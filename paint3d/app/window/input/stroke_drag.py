"""A stroke that is dragged to another place: where it is taken hold of, and where let go."""

from __future__ import annotations

from collections.abc import Callable

from PySide6 import QtCore, QtGui

from paint3d.app.window.input.canvas import Canvas
from paint3d.app.window.input.touch import Touch
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.arrays import AnyArray

__all__ = ["StrokeDrag"]

_KIND = QtCore.QEvent.Type
_KEYS = (_KIND.ShortcutOverride, _KIND.KeyPress)
_RADIUS, _WIDTH = 6.0, 2.0  # of what is drawn, pixels
_CLICK = 5.0  # pixels that a pen goes at most while it only chooses


class StrokeDrag(QtCore.QObject):
    """Waits for one drag over the picture by mouse, pen or finger, which does not paint.

    Parameters
    ----------
    workspace : Workspace
    canvas : Canvas
    stroke_at : callable
        The number of the stroke that lies at a place (3,) of the object, from 0, or None.

    Signals
    -------
    chosen : int
        The stroke that was taken hold of, where none was named.
    dragged : (int, object)
        The stroke, and two places (2, 3) on the object: where it began and where it ended.
    """

    chosen = QtCore.Signal(int)
    dragged = QtCore.Signal(int, object)

    def __init__(
        self,
        workspace: Workspace,
        canvas: Canvas,
        stroke_at: Callable[[AnyArray], int | None],
    ) -> None:
        super().__init__(canvas)
        self._workspace, self._canvas, self._stroke_at = workspace, canvas, stroke_at
        self._named: int | None = None  # the stroke that is to be moved
        self._number: int | None = None  # the one that is held
        self._from: tuple[QtCore.QPointF, AnyArray] | None = None
        self._now = QtCore.QPointF()
        self._is_down = False
        self._mode_at: Callable[..., str | None] = canvas.mode_at
        canvas.overlays.append(self._paint)
        canvas.taken_back.connect(self._drop)
        workspace.opened.connect(lambda _: self.end())

    @property
    def is_waiting(self) -> bool:
        """Whether the next drag moves a stroke."""
        return self._canvas.tool == self._take

    def begin(self, number: int | None = None) -> None:
        """Let the next drag move this stroke, or the one at which it begins."""
        self.end()
        self._named = number
        self._is_down = False
        self._canvas.take_up(self._take, self.end)
        self._mode_at, self._canvas.mode_at = self._canvas.mode_at, self._mode
        self._canvas.installEventFilter(self)
        self._canvas.setCursor(QtCore.Qt.CursorShape.OpenHandCursor)
        self._canvas.setFocus()
        told = (
            say("Click a stroke on the object, or drag it to where it is to lie; Esc leaves it")
            if number is None
            else say("Drag stroke {n} to where it is to lie; Esc leaves it", n=number + 1)
        )
        self._workspace.tell(told, stays=True)

    def end(self) -> None:
        """Paint again with the next drag."""
        if not self.is_waiting:
            return
        self._named = self._number = self._from = None
        self._canvas.lay_down(self._take)
        self._canvas.mode_at = self._mode_at
        self._canvas.removeEventFilter(self)
        self._canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
        self._canvas.update()
        self._workspace.tell(say("status.ready"))

    # -- what the hand does -----------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Leave it by Esc."""
        if not self.is_waiting or event.type() not in _KEYS:
            return False
        if not isinstance(event, QtGui.QKeyEvent):
            return False
        if event.key() != QtCore.Qt.Key.Key_Escape:
            return False
        event.accept()
        if event.type() == _KIND.KeyPress:
            self.end()
        return True

    def _mode(self, x: float, y: float, keys: QtCore.Qt.KeyboardModifier) -> str | None:
        """How a drag that begins here steers: by grips and with Space; beside the object not."""
        steers = self._canvas.grip_at(x, y) or "steer" in self._workspace.hand.held
        return self._mode_at(x, y, keys) if steers or not self.is_waiting else None

    def _take(self, touch: Touch) -> bool:
        """Follow a mouse, a pen or a finger; False while it is only over the picture."""
        was_down, self._is_down = self._is_down, touch.down
        if not (was_down or touch.down):
            return False
        self._now = QtCore.QPointF(touch.x, touch.y)
        if not was_down:
            self._take_hold()
        elif not touch.down:
            self._let_go()
        self._canvas.update()
        return True

    def _drop(self) -> None:
        """Hold nothing: what a finger began was the beginning of a gesture of several."""
        self._is_down = False
        if self.is_waiting:
            self._hold_nothing()
            self._canvas.update()

    def _hold_nothing(self) -> None:
        self._number = self._from = None
        self._canvas.setCursor(QtCore.Qt.CursorShape.OpenHandCursor)

    def _place(self) -> AnyArray | None:
        return self._workspace.hand.place_at(self._now.x(), self._now.y())

    def _take_hold(self) -> None:
        place = self._place()
        if place is None:
            self._workspace.tell(say("There is nothing of the object there"), state="bad")
            return
        self._number = self._stroke_at(place) if self._named is None else self._named
        if self._number is None:
            self._workspace.tell(say("No stroke lies there"), state="bad")
            return
        if self._named is None:
            self.chosen.emit(self._number)
        self._from = self._now, place
        self._canvas.setCursor(QtCore.Qt.CursorShape.ClosedHandCursor)

    def _let_go(self) -> None:
        held, place, number = self._from, self._place(), self._number
        if held is None or number is None:
            return
        way = self._now - held[0]
        if self._named is None and abs(way.x()) + abs(way.y()) < _CLICK:
            self._hold_nothing()
        elif place is None:
            self._hold_nothing()
            self._workspace.tell(say("There is nothing of the object there"), state="bad")
        else:
            self.end()
            self.dragged.emit(number, (held[1], place))

    def _paint(self, painter: QtGui.QPainter, _: QtCore.QRect) -> None:
        """Draw how far it is dragged."""
        if self._from is None:
            return
        theme = self._workspace.theme
        painter.setPen(QtGui.QPen(QtGui.QColor(theme.accent), _WIDTH))
        painter.setBrush(QtCore.Qt.BrushStyle.NoBrush)
        painter.drawEllipse(self._from[0], _RADIUS, _RADIUS)
        painter.drawLine(self._from[0], self._now)
        painter.setBrush(QtGui.QColor(theme.accent))
        painter.drawEllipse(self._now, 0.5 * _RADIUS, 0.5 * _RADIUS)

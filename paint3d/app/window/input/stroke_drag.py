"""A stroke that is dragged to another place: where it is taken hold of, and where let go."""

from __future__ import annotations

from PySide6 import QtCore, QtGui

from paint3d.app.window.input.canvas import Canvas
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.core.types import AnyArray

__all__ = ["StrokeDrag"]

_KIND = QtCore.QEvent.Type
_DOWN = (_KIND.MouseButtonPress, _KIND.TabletPress)
_MOVE = (_KIND.MouseMove, _KIND.TabletMove)
_UP = (_KIND.MouseButtonRelease, _KIND.TabletRelease)
_KEYS = (_KIND.ShortcutOverride, _KIND.KeyPress)
_RADIUS, _WIDTH = 6.0, 2.0  # of what is drawn, pixels


class StrokeDrag(QtCore.QObject):
    """Waits for one drag over the picture, which does not paint.

    Signals
    -------
    dragged : (int, object)
        The stroke, and two places (2, 3) on the object: where it began and where it ended.
    """

    dragged = QtCore.Signal(int, object)

    def __init__(self, workspace: Workspace, canvas: Canvas) -> None:
        super().__init__(canvas)
        self._workspace, self._canvas = workspace, canvas
        self._number: int | None = None
        self._from: tuple[QtCore.QPointF, AnyArray] | None = None
        self._now = QtCore.QPointF()
        canvas.overlays.append(self._paint)
        workspace.opened.connect(lambda _: self.end())

    @property
    def is_waiting(self) -> bool:
        """Whether the next drag moves a stroke."""
        return self._number is not None

    def begin(self, number: int) -> None:
        """Let the next drag move a stroke."""
        self._number, self._from = number, None
        self._canvas.installEventFilter(self)
        self._canvas.setCursor(QtCore.Qt.CursorShape.OpenHandCursor)
        self._canvas.setFocus()
        told = say("Drag stroke {n} to where it is to lie; Esc leaves it", n=number + 1)
        self._workspace.tell(told, stays=True)

    def end(self) -> None:
        """Paint again with the next drag."""
        if self._number is None:
            return
        self._number = self._from = None
        self._canvas.removeEventFilter(self)
        self._canvas.unsetCursor()
        self._canvas.update()
        self._workspace.tell(say("status.ready"))

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Take the drag away from the canvas."""
        kind = event.type()
        if kind in _KEYS and isinstance(event, QtGui.QKeyEvent):
            return self._key(event)
        if not isinstance(event, QtGui.QSinglePointEvent) or kind not in (*_DOWN, *_MOVE, *_UP):
            return False
        if kind in _DOWN and event.button() != QtCore.Qt.MouseButton.LeftButton:
            return False  # it steers the view
        if kind in _MOVE and self._from is None:
            return False
        event.accept()
        self._now = event.position()
        if kind in _DOWN:
            self._take_hold()
        elif kind in _UP:
            self._let_go()
        self._canvas.update()
        return True

    def _key(self, event: QtGui.QKeyEvent) -> bool:
        if event.key() != QtCore.Qt.Key.Key_Escape:
            return False
        event.accept()
        if event.type() == _KIND.KeyPress:
            self.end()
        return True

    def _place(self) -> AnyArray | None:
        return self._workspace.hand.place_at(self._now.x(), self._now.y())

    def _take_hold(self) -> None:
        place = self._place()
        if place is None:
            self._workspace.tell(say("There is nothing of the object there"), state="bad")
            return
        self._from = self._now, place
        self._canvas.setCursor(QtCore.Qt.CursorShape.ClosedHandCursor)

    def _let_go(self) -> None:
        held, place, number = self._from, self._place(), self._number
        if held is None or number is None:
            return
        if place is None:
            self._from = None
            self._canvas.setCursor(QtCore.Qt.CursorShape.OpenHandCursor)
            self._workspace.tell(say("There is nothing of the object there"), state="bad")
            return
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

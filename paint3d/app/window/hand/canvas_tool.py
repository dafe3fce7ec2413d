"""Base of tools that get the picture's drags while they are on, to choose, move or scale things.

The canvas hands touches to one tool at a time (`CanvasWidget.take_up`). All tools of this kind
follow one press to its end, leave steering to Space and the view's grips, end by Esc, and drop what
they drag when a finger turns out to be one of several.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from PySide6 import QtCore, QtGui

from paint3d.app.window.hand.canvas import CanvasWidget, Touch
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["CLICK", "CanvasTool", "draw_grip"]

CLICK = 5.0
"""Pixels that a hand goes at most while it only points."""
_KIND, _KEY = QtCore.QEvent.Type, QtCore.Qt.Key


class CanvasTool(QtCore.QObject):
    """Base of the picture's tools: while one is on, drags are its own and do not paint.

    Parameters
    ----------
    workspace : Workspace

    Signals
    -------
    turned_on : bool

    Attributes
    ----------
    keys : frozenset of Qt.Key
        That it gets while it is on, besides Esc; see `press_key`.
    cursor : Qt.CursorShape
        Of the pointer while it is on.
    """

    turned_on = QtCore.Signal(bool)
    keys: ClassVar[frozenset[QtCore.Qt.Key]] = frozenset()
    cursor: ClassVar[QtCore.Qt.CursorShape] = QtCore.Qt.CursorShape.OpenHandCursor

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._workspace = workspace
        self._canvas: CanvasWidget = workspace.canvas
        self._is_down = False
        self._mode_at: Callable[..., str | None] = self._canvas.mode_at
        self._canvas.overlays.append(lambda painter, _: self.paint(painter) if self.is_on else None)
        self._canvas.taken_back.connect(self._take_back)
        workspace.opened.connect(lambda _: self.end())

    @property
    def is_on(self) -> bool:
        """True if drags are this tool's."""
        return self._canvas.tool == self._take

    def turn_on(self, message: str) -> None:
        """Take the drags until `end`, and show how the tool is used."""
        if self.is_on:
            return
        self._canvas.take_up(self._take, self.end)
        self._mode_at, self._canvas.mode_at = self._canvas.mode_at, self._mode
        self._canvas.installEventFilter(self)
        self._canvas.setCursor(self.cursor)
        self._canvas.setFocus()
        self._is_down = False
        self._workspace.tell(message, stays=True)
        self.turned_on.emit(True)
        self._canvas.update()

    def end(self) -> None:
        """Paint again with the next drag."""
        if not self.is_on:
            return
        self.drop()
        self._canvas.lay_down(self._take)
        self._canvas.mode_at = self._mode_at
        self._canvas.removeEventFilter(self)
        self._canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
        self._canvas.update()
        self._workspace.tell(say("Ready"))
        self.turned_on.emit(False)

    # -- to be overridden -------------------------------------------------------------------

    def take_hold(self, at: QtCore.QPointF, *, adds: bool) -> None:
        """Begin a drag; `adds` where Shift is held."""

    def drag(self, at: QtCore.QPointF) -> None:
        """Go on with a drag."""

    def let_go(self, at: QtCore.QPointF) -> None:
        """End a drag."""

    def drop(self) -> None:
        """Drop what is dragged, and change nothing."""

    def press_key(self, event: QtGui.QKeyEvent) -> None:
        """Do the command of one of `keys`."""

    def takes(self, at: QtCore.QPointF) -> bool:
        """Return whether a drag that begins there is the tool's, not the view's."""
        return True

    def paint(self, painter: QtGui.QPainter) -> None:
        """Draw over the picture, while the tool is on."""

    # -- keys and hands ---------------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Take the tool's keys, and end by Esc."""
        if not self.is_on or not isinstance(event, QtGui.QKeyEvent):
            return False
        if event.type() not in (_KIND.ShortcutOverride, _KIND.KeyPress):
            return False
        if event.key() != _KEY.Key_Escape and event.key() not in self.keys:
            return False
        event.accept()
        if event.type() == _KIND.ShortcutOverride:
            return True
        if event.key() == _KEY.Key_Escape:
            self.end()
        else:
            self.press_key(event)
        return True

    def _mode(self, x: float, y: float, keys: QtCore.Qt.KeyboardModifier) -> str | None:
        """Return a drag's mode: by the view's grips, with Space, or where the tool takes none."""
        steers = self._canvas.grip_at(x, y) or "steer" in self._workspace.hand.held
        if self.is_on and not steers and self.takes(QtCore.QPointF(x, y)):
            return None
        return self._mode_at(x, y, keys)

    def _take(self, touch: Touch) -> bool:
        """Follow a mouse, a pen or a finger; False while it is only over the picture."""
        was_down, self._is_down = self._is_down, touch.down
        if not (was_down or touch.down):
            return False
        at = QtCore.QPointF(touch.x, touch.y)
        if not was_down:
            self.take_hold(at, adds=touch.bends)
        elif touch.down:
            self.drag(at)
        else:
            self.let_go(at)
        self._canvas.update()
        return True

    def _take_back(self) -> None:
        """Drop what a finger drags: it was the beginning of a gesture of several."""
        self._is_down = False
        if self.is_on:
            self.drop()
            self._canvas.update()


def draw_grip(painter: QtGui.QPainter, name: str, at: QtCore.QPointF, half: float) -> None:
    """Draw a grip of `half` pixels to each side: round to turn, flat to space, else a square."""
    box = QtCore.QRectF(at.x() - half, at.y() - half, 2.0 * half, 2.0 * half)
    thin = 0.5 * half
    if name == "turn":
        painter.drawEllipse(box)
    elif name == "down":
        painter.drawRoundedRect(box.adjusted(0, thin, 0, -thin), 3, 3)
    elif name == "across":
        painter.drawRoundedRect(box.adjusted(thin, 0, -thin, 0), 3, 3)
    else:
        painter.drawRect(box)

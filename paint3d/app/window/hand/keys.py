"""Keys that act while they are down, and those of the keypad, wherever the focus is.

Size, water, force, harder, softer, the lamp; Space, which steers. The keypad turns the view with
NumLock or without: Qt would take its digits for those above the letters.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.commands import SHORTCUTS
from paint3d.app.window.hand.canvas import WRITING
from paint3d.app.window.hand.canvas_hand import ADJUSTED, CanvasHand
from paint3d.app.window.job import is_waiting

__all__ = ["HeldKeys"]

_KIND, _KEY = QtCore.QEvent.Type, QtCore.Qt.Key
_PAD = QtCore.Qt.KeyboardModifier.KeypadModifier
_OTHERS = (  # that count together with a key of the keypad
    QtCore.Qt.KeyboardModifier.ControlModifier | QtCore.Qt.KeyboardModifier.AltModifier
)
_PRESSES = (_KIND.MouseButtonPress, _KIND.TabletPress, _KIND.TouchBegin)
_SETTLED_MS = 300  # after which the focus is settled
_WHILE_S = 5.0  # within which a window manager reports a move, however busy it is
_DIGITS = {
    _KEY.Key_Insert: _KEY.Key_0, _KEY.Key_End: _KEY.Key_1, _KEY.Key_Down: _KEY.Key_2,
    _KEY.Key_PageDown: _KEY.Key_3, _KEY.Key_Left: _KEY.Key_4, _KEY.Key_Clear: _KEY.Key_5,
    _KEY.Key_Right: _KEY.Key_6, _KEY.Key_Home: _KEY.Key_7, _KEY.Key_Up: _KEY.Key_8,
    _KEY.Key_PageUp: _KEY.Key_9, _KEY.Key_Delete: _KEY.Key_Period, _KEY.Key_Comma: _KEY.Key_Period,
}  # fmt: skip
"""Keys of the keypad without NumLock, to those with it; some layouts have a comma."""


class HeldKeys(QtCore.QObject):
    """Watches the keys of one window.

    A key that is both held and pressed counts as pressed if nothing was dragged with it.

    Signals
    -------
    tapped : str
        The action of a key that was released at once, or of one of the keypad.
    alt_taken : ()
        The window was moved with Alt, as some window managers do, where Alt was to turn the view.
    """

    tapped = QtCore.Signal(str)
    alt_taken = QtCore.Signal()

    def __init__(
        self, window: QtWidgets.QWidget, canvas: QtWidgets.QWidget, hand: CanvasHand
    ) -> None:
        super().__init__(window)
        self._window, self._canvas, self._hand = window, canvas, hand
        self._alt = False
        self._alt_at: float | None = None  # when it was pressed, if nothing else has been since
        self._keys: dict[int, tuple[str, str]] = {}
        held = {one.keys: one.action for one in SHORTCUTS if one.gesture in ("hold", "drag")}
        self._taps = {one.keys: one.action for one in SHORTCUTS if one.gesture == "press"}
        self._held = {
            _combined(keys): (keys, action)
            for keys, action in held.items()
            if action in (*ADJUSTED, "harder", "softer")
        }
        self._pad = {_combined(one.keys): one.action for one in SHORTCUTS if "Num+" in one.keys}
        self._everywhere = _Everywhere(self, self._look_at_keys)
        window.installEventFilter(self)

    def taps(self) -> set[str]:
        """Return actions whose key is also one to hold down: they come by `tapped`."""
        return {self._taps[keys] for keys, _ in self._held.values() if keys in self._taps}

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Forget all keys when the focus is lost; notice a window that is moved with Alt."""
        kind = event.type()
        if kind in (_KIND.WindowActivate, _KIND.WindowDeactivate):
            self._everywhere.watch(self._window.isActiveWindow())
        if kind == _KIND.WindowDeactivate:
            self._alt = False
            self._keys.clear()
            self._hand.held.clear()
        elif kind == _KIND.WindowUnblocked and QtGui.QGuiApplication.focusWindow() is not None:
            QtCore.QTimer.singleShot(_SETTLED_MS, self, self._take_back_keys)
        elif kind == _KIND.Move and (self._alt or self._was_alt_alone() or _is_alt_down()):
            self._alt_at = None
            self.alt_taken.emit()
        return False

    def _look_at_keys(self, event: QtCore.QEvent) -> bool:
        """Look at keys of this window, unless something is being written."""
        kind = event.type()
        if kind in _PRESSES:
            self._alt_at = None  # the press that it belongs to has reached the window
        if kind not in (_KIND.KeyPress, _KIND.KeyRelease, _KIND.ShortcutOverride):
            return False
        if not isinstance(event, QtGui.QKeyEvent) or not self._window.isActiveWindow():
            return False
        if kind != _KIND.KeyRelease and is_waiting(self._window):
            return False  # the job's own filter drops them, also where this one comes first
        if event.key() == _KEY.Key_Alt:
            self._alt = kind != _KIND.KeyRelease
            self._alt_at = time.monotonic() if self._alt else self._alt_at
        elif kind == _KIND.KeyPress:
            self._alt_at = None
        if kind != _KIND.KeyRelease and QtWidgets.QApplication.activePopupWidget() is not None:
            if kind == _KIND.ShortcutOverride:
                event.accept()  # or arrows in a menu would turn the view, as shortcuts
            return False  # a box's list takes Return from it
        if isinstance(QtWidgets.QApplication.focusWidget(), WRITING):
            return False
        if kind == _KIND.KeyRelease:
            return self._release(event)
        if event.modifiers() & _PAD:
            return self._press_pad(kind, event)
        if kind == _KIND.ShortcutOverride:
            return False
        if event.key() == _KEY.Key_Space and self._is_over_canvas():
            return self._hold(event, ("Space", "steer"))
        key = self._held.get(event.keyCombination().toCombined())
        return False if key is None else self._hold(event, key)

    def _take_back_keys(self) -> None:
        """Take the focus after a dialog that had it, where it went to no window.

        On X11 it may be given to a dialog that closes just then, and no window gets it afterwards.
        """
        if QtGui.QGuiApplication.focusWindow() is None and self._window.isVisible():
            self._window.activateWindow()

    def _was_alt_alone(self) -> bool:
        """Return whether Alt was pressed recently and nothing since; it may be up again."""
        return self._alt_at is not None and time.monotonic() - self._alt_at < _WHILE_S

    def _is_over_canvas(self) -> bool:
        """Return whether a key is for the picture, and not for a button with the focus."""
        focus = QtWidgets.QApplication.focusWidget()
        return focus is None or focus is self._canvas

    def _press_pad(self, kind: QtCore.QEvent.Type, event: QtGui.QKeyEvent) -> bool:
        """Do the command of a key of the keypad, and consume the key."""
        key = QtCore.Qt.Key(event.key())
        keys = (event.modifiers() & _OTHERS) | _PAD
        combined = QtCore.QKeyCombination(keys, _DIGITS.get(key, key)).toCombined()
        action = self._pad.get(combined)
        if action is None:
            return False
        event.accept()
        if kind == _KIND.KeyPress:
            self.tapped.emit(action)
        return True

    def _hold(self, event: QtGui.QKeyEvent, key: tuple[str, str]) -> bool:
        if not event.isAutoRepeat() and event.key() not in self._keys:
            self._keys[event.key()] = key
            self._hand.held.add(key[1])
            self._hand.adjusted = False
        return True

    def _release(self, event: QtGui.QKeyEvent) -> bool:
        if event.isAutoRepeat() or event.key() not in self._keys:
            return False
        keys, action = self._keys.pop(event.key())
        self._hand.held.discard(action)
        if keys in self._taps and not self._hand.adjusted:
            self.tapped.emit(self._taps[keys])
        return True


class _Everywhere(QtCore.QObject):
    """Looks at all events of the program, only while its window is active.

    To hand an event to Python costs more than most of them do, and while a window is made and shown
    there are ten thousand.
    """

    def __init__(self, owner: QtCore.QObject, look: Callable[[QtCore.QEvent], bool]) -> None:
        super().__init__(owner)
        self._look = look

    def watch(self, on: bool) -> None:
        """Begin or end to look at events."""
        program = QtWidgets.QApplication.instance()
        assert program is not None, "a window has one"
        program.removeEventFilter(self)
        if on:
            program.installEventFilter(self)

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Return whether the event is consumed."""
        return self._look(event)


def _combined(keys: str) -> int:
    """Return Qt's number of a key with its modifiers."""
    sequence: Any = QtGui.QKeySequence(keys)  # Qt's stubs lack its indexing
    combined: int = sequence[0].toCombined()
    return combined


def _is_alt_down() -> bool:
    """Return whether the system reports Alt as down: a window that is moved has no focus."""
    modifiers = QtGui.QGuiApplication.queryKeyboardModifiers()
    return bool(modifiers & QtCore.Qt.KeyboardModifier.AltModifier)

"""Keys that count while they are held, wherever the focus is: size, force, harder, softer."""

from __future__ import annotations

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.shortcuts import SHORTCUTS
from paint3d.app.window.hand import CanvasHand

__all__ = ["HeldKeys"]

_WRITING = (QtWidgets.QLineEdit, QtWidgets.QAbstractSpinBox, QtWidgets.QPlainTextEdit)


class HeldKeys(QtCore.QObject):
    """Watches the keys of one window.

    A key that is both held and pressed counts as pressed if nothing was dragged with it.

    Signals
    -------
    tapped : str
        The action of a key that was let go at once.
    """

    tapped = QtCore.Signal(str)

    def __init__(self, window: QtWidgets.QWidget, hand: CanvasHand) -> None:
        super().__init__(window)
        self._window, self._hand = window, hand
        self._keys: dict[int, tuple[str, str]] = {}
        held = {one.keys: one.action for one in SHORTCUTS if one.gesture in ("hold", "drag")}
        self._taps = {one.keys: one.action for one in SHORTCUTS if one.gesture == "press"}
        self._held = {
            QtGui.QKeySequence(keys)[0].toCombined(): (keys, action)
            for keys, action in held.items()
            if action in ("size", "force", "harder", "softer")
        }
        QtWidgets.QApplication.instance().installEventFilter(self)

    def taps(self) -> set[str]:
        """Actions whose key is also one to hold: they come by `tapped`."""
        return {self._taps[keys] for keys, _ in self._held.values() if keys in self._taps}

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Look at keys of this window, unless something is being written."""
        kind = event.type()
        if kind not in (QtCore.QEvent.Type.KeyPress, QtCore.QEvent.Type.KeyRelease):
            return False
        if not self._window.isActiveWindow() or isinstance(
            QtWidgets.QApplication.focusWidget(), _WRITING
        ):
            return False
        if kind == QtCore.QEvent.Type.KeyRelease:
            return self._let_go(event)
        found = self._held.get(event.keyCombination().toCombined())
        if found is None:
            return False
        if not event.isAutoRepeat() and event.key() not in self._keys:
            self._keys[event.key()] = found
            self._hand.held.add(found[1])
            self._hand.adjusted = False
        return True

    def _let_go(self, event: QtGui.QKeyEvent) -> bool:
        if event.isAutoRepeat() or event.key() not in self._keys:
            return False
        keys, action = self._keys.pop(event.key())
        self._hand.held.discard(action)
        if keys in self._taps and not self._hand.adjusted:
            self.tapped.emit(self._taps[keys])
        return True

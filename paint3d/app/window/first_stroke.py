"""The program of a process that `paint3d bench start` measures: the studio, until it has paint on.

``python -m paint3d.app.window.first_stroke SINCE ARGUMENTS`` is `paint3d ARGUMENTS`, which should
be `paint ...`. SINCE is when the process was begun, by `time.monotonic`. Each milestone is a line:
seconds since then, and what it is. The last one ends the process, and what was painted is lost.
"""

from __future__ import annotations

import logging
import os
import runpy
import sys
import time
from typing import Any

_HEARS = "hears the hand"  # the last that `start` logs
_PAINTED = "stroke painted"
_LOOK_MS = 5
_PATH = (0.0, 4.0, 8.0, 12.0)  # pixels across the middle


class _Milestones(logging.Handler):
    """Writes the milestones that the window's start logs, then begins a stroke."""

    def __init__(self, since: float) -> None:
        super().__init__()
        self._since = since

    def emit(self, record: logging.LogRecord) -> None:
        """Write a milestone; begin the stroke at the last one."""
        self.write(record.getMessage())
        if record.getMessage() == _HEARS:
            self._stroke = _Stroke(self)  # Qt keeps no reference

    def write(self, what: str) -> None:
        """Write a milestone with its time."""
        sys.stdout.write(f"{time.monotonic() - self._since:.4f} {what}\n")
        sys.stdout.flush()


class _Stroke:
    """A short stroke of a mouse in the middle of the picture, by Qt's events."""

    def __init__(self, milestones: _Milestones) -> None:
        from PySide6 import QtCore, QtWidgets

        self._milestones = milestones
        widgets: list[Any] = QtWidgets.QApplication.topLevelWidgets()
        self._window = next(widget for widget in widgets if widget.objectName() == "studio")
        kinds, buttons = QtCore.QEvent.Type, QtCore.Qt.MouseButton
        left, none = buttons.LeftButton, buttons.NoButton
        self._send(kinds.MouseButtonPress, _PATH[0], left, left)
        for x in _PATH:
            self._send(kinds.MouseMove, x, none, left)
        self._send(kinds.MouseButtonRelease, _PATH[-1], left, none)
        self._timer = QtCore.QTimer(self._window)
        self._timer.timeout.connect(self._look)
        self._timer.start(_LOOK_MS)

    def _send(self, kind: Any, x: float, button: Any, down: Any) -> None:
        from PySide6 import QtCore, QtGui, QtWidgets

        canvas = self._window.canvas
        position = QtCore.QPointF(canvas.rect().center()) + QtCore.QPointF(x, 0.0)
        keys = QtCore.Qt.KeyboardModifier.NoModifier
        event = QtGui.QMouseEvent(kind, position, canvas.mapToGlobal(position), button, down, keys)
        event.setTimestamp(int(1000.0 * time.monotonic()))
        QtWidgets.QApplication.sendEvent(canvas, event)

    def _look(self) -> None:
        if self._window.document.surface.painted.any():
            self._milestones.write(_PAINTED)
            os._exit(0)


def main() -> None:
    """Run the program, with its start logged."""
    log = logging.getLogger("paint3d.start")
    log.addHandler(_Milestones(float(sys.argv[1])))
    log.setLevel(logging.DEBUG)
    log.propagate = False
    sys.argv = ["paint3d", *sys.argv[2:]]
    runpy.run_module("paint3d", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()

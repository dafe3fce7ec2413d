"""Open the studio, paint one stroke with the mouse, save it to the file that is named, and leave.

    python -I - FILE.p3d < scripts/one_stroke.py

It needs the program alone, so that it can try one that is installed; `scripts/unprivileged` does.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.start import make_program
from paint3d.app.window.studio import StudioWindow

LIMIT_S = 900.0  # the first start compiles what paints
KIND, BUTTON = QtCore.QEvent.Type, QtCore.Qt.MouseButton
NO_KEY = QtCore.Qt.KeyboardModifier.NoModifier


def wait_for(what: str, holds: Callable[[], bool]) -> None:
    """Process events until a condition holds."""
    until = time.monotonic() + LIMIT_S
    while not holds():
        if time.monotonic() > until:
            sys.exit(f"not within {LIMIT_S:.0f} s: {what}")
        QtWidgets.QApplication.processEvents(QtCore.QEventLoop.ProcessEventsFlag.AllEvents, 10)
        time.sleep(0.005)


def main() -> None:
    """Do it."""
    program = make_program()
    window = StudioWindow(program)
    window.show()
    window.workspace.quiet = True
    if not window.opening.open_path("plane", 1.5, "xuan", asked=True):
        sys.exit(f"the plane was not opened: {window.workspace.error}")
    wait_for("the plane is lit", lambda: window.stage.is_lit)
    canvas = window.canvas
    ways = [(0.4 + 0.01 * k, 0.5) for k in range(21)]
    for k, (across, down) in enumerate(ways):
        position = QtCore.QPointF(across * canvas.width(), down * canvas.height())
        kind = KIND.MouseButtonPress if k == 0 else KIND.MouseMove
        kind = KIND.MouseButtonRelease if k == len(ways) - 1 else kind
        changed = BUTTON.NoButton if kind == KIND.MouseMove else BUTTON.LeftButton
        held = BUTTON.NoButton if kind == KIND.MouseButtonRelease else BUTTON.LeftButton
        there = canvas.mapToGlobal(position)
        event = QtGui.QMouseEvent(kind, position, there, changed, held, NO_KEY)
        QtWidgets.QApplication.sendEvent(canvas, event)
        began = time.monotonic()
        wait_for("20 ms go by", lambda began=began: time.monotonic() > began + 0.02)
    painted = window.stage.paint_thread.post(lambda document: int(document.surface.painted.sum()))
    wait_for("the stroke is painted", painted.done)
    if not painted.result():
        sys.exit("the stroke left nothing")
    if not window.saving.save_to(Path(sys.argv[1])):
        sys.exit(f"it was not saved: {window.workspace.error}")
    window.close()
    print(f"{painted.result()} vertices painted")


if __name__ == "__main__":
    main()

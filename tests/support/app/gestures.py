"""A hand for tests: real Qt events to a window's canvas, in real time."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.window.hand.canvas import CanvasWidget

BUTTON, KIND = QtCore.Qt.MouseButton, QtCore.QEvent.Type
NO_KEY, ALT = QtCore.Qt.KeyboardModifier.NoModifier, QtCore.Qt.KeyboardModifier.AltModifier
PEN = QtGui.QPointingDevice(
    "pen", 1, QtGui.QInputDevice.DeviceType.Stylus, QtGui.QPointingDevice.PointerType.Pen,
    QtGui.QInputDevice.Capability.Pressure | QtGui.QInputDevice.Capability.Position, 1, 3,
)  # fmt: skip

_ROUNDS = 3  # of the event loop
_TOUCHES = (KIND.TouchBegin, KIND.TouchUpdate, KIND.TouchEnd, KIND.TouchCancel)
_MICE = (KIND.MouseButtonPress, KIND.MouseMove, KIND.MouseButtonRelease, KIND.MouseButtonDblClick)

AWAITED: dict[object, str] = {}
"""What tests wait for with `when` and `answer`, in words."""


class HandsTime(QtCore.QObject):
    """When the hand does what it does, by the devices' clock, as if the machine always kept up.

    Attributes
    ----------
    now_ms : int
        Of the next event. It never lies ahead of the computer's own monotonic clock for long.
    """

    def __init__(self) -> None:
        super().__init__()
        self.now_ms = 0

    def begin(self) -> None:
        """Begin something new, now by the computer's clock."""
        self.now_ms = max(self.now_ms, time.monotonic_ns() // 1_000_000)

    def pass_by(self, seconds: float) -> None:
        """Advance the hand's clock by this time, at least a millisecond."""
        self.now_ms += max(1, round(1000 * seconds))

    def commit(self, sequence) -> None:
        """Send touches, which reach the program through Qt's window, with this time."""
        program = QtWidgets.QApplication.instance()
        program.installEventFilter(self)
        try:
            sequence.commit()
        finally:
            program.removeEventFilter(self)

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Give touches on the picture their times, and what Qt makes of those beside it.

        A tap on a busy machine would last as long there as the machine takes to send it.
        """
        if event.type() in _MICE:
            event.setTimestamp(self.now_ms)
            return False
        if event.type() not in _TOUCHES or not isinstance(watched, CanvasWidget):
            return False
        if event.type() != KIND.TouchBegin:
            event.setTimestamp(self.now_ms)
            return False
        copy = event.clone()  # Qt loses hold of a finger whose first event was changed
        copy.setTimestamp(self.now_ms)
        taken = watched.event(copy)
        event.setAccepted(copy.isAccepted())
        return taken


HAND = HandsTime()


def live(seconds: float = 0.05) -> None:
    """Process events for a while, and at least a few rounds.

    What the screen answers to what was asked of it before, as to move the window, has come then.
    """
    until, rounds = time.perf_counter() + seconds, 0
    QtGui.QGuiApplication.sync()
    while rounds < _ROUNDS or time.perf_counter() < until:
        QtWidgets.QApplication.processEvents(QtCore.QEventLoop.ProcessEventsFlag.AllEvents, 10)
        time.sleep(0.002)
        rounds += 1


def wait_for(condition, seconds: float = 300.0, fault: str = "it did not come about") -> None:
    """Live until something holds."""
    until = time.perf_counter() + seconds
    while not condition():
        assert time.perf_counter() < until, fault
        live(0.02)


def when(ready, act, what: str, seconds: float = 300.0) -> None:
    """Act as soon as something is so, also while a dialog has a loop of its own.

    When it is not so in time, what is open is closed, and the test fails in that slot. It is in
    `AWAITED` until it acts, and nothing happens any more once it is taken out of there.
    """
    until = time.perf_counter() + seconds
    key = object()
    AWAITED[key] = what

    def look() -> None:
        if key not in AWAITED:
            return
        if ready():
            del AWAITED[key]
            act()
        elif time.perf_counter() < until:
            QtCore.QTimer.singleShot(30, look)
        else:
            del AWAITED[key]
            while (dialog := QtWidgets.QApplication.activeModalWidget()) is not None:
                dialog.close()
                dialog.hide()
            raise AssertionError(f"not within {seconds:.0f} s: {what}")

    QtCore.QTimer.singleShot(30, look)


def answer(press, kind=QtWidgets.QDialog, but=QtWidgets.QProgressDialog) -> None:
    """Call `press` with the dialog that opens next.

    Where that fails the dialog is closed: nobody else would, and the test would wait for ever.
    Bars that show how far something is are left alone; see `answer_bar`.
    """

    def waits() -> bool:
        dialog = QtWidgets.QApplication.activeModalWidget()
        return isinstance(dialog, kind) and not isinstance(dialog, but) and dialog.isVisible()

    def act() -> None:
        dialog = QtWidgets.QApplication.activeModalWidget()
        try:
            press(dialog)
        except BaseException:
            dialog.reject()
            raise

    when(waits, act, f"a {kind.__name__} opens")


def answer_bar(press) -> None:
    """Call `press` with the bar that opens next."""
    answer(press, QtWidgets.QProgressDialog, ())


def take_file(path: str | Path):
    """Make a `press` that types a path in the next file dialog and accepts it.

    Picking one in the dialog's list would have to wait until the folder is listed.
    """

    def type_it(dialog: QtWidgets.QFileDialog) -> None:
        dialog.findChild(QtWidgets.QLineEdit, "fileNameEdit").setText(str(path))
        dialog.accept()

    return type_it


def type_key(widget, key, held=NO_KEY) -> None:
    """Press and release a key in a window that has the keyboard; shortcuts are heard there only."""
    window = widget.window()
    window.activateWindow()
    wait_for(window.isActiveWindow)
    QtTest.QTest.keyClick(widget, key, held)


def click_button(panel, text: str) -> None:
    """Click the button that says this."""
    button = next(b for b in panel.findChildren(QtWidgets.QPushButton) if b.text() == text)
    QtTest.QTest.mouseClick(button, BUTTON.LeftButton)


def mouse(canvas, kind, x, y, button=BUTTON.NoButton, buttons=BUTTON.NoButton, keys=NO_KEY):
    """Send one mouse event."""
    position = QtCore.QPointF(x, y)
    event = QtGui.QMouseEvent(kind, position, canvas.mapToGlobal(position), button, buttons, keys)
    QtWidgets.QApplication.sendEvent(canvas, event)


def drag(canvas, start, end, button=BUTTON.LeftButton, keys=NO_KEY, n=15, release=True):
    """Drag from one place to another; places are shares of the canvas's size."""
    size = np.array([canvas.width(), canvas.height()])
    path = np.linspace(np.array(start) * size, np.array(end) * size, n)
    mouse(canvas, KIND.MouseMove, *path[0], keys=keys)
    mouse(canvas, KIND.MouseButtonPress, *path[0], button, button, keys)
    for x, y in path:
        mouse(canvas, KIND.MouseMove, x, y, BUTTON.NoButton, button, keys)
        live(0.008)
    if release:
        mouse(canvas, KIND.MouseButtonRelease, *path[-1], button, BUTTON.NoButton, keys)
        live()


def pen(canvas, kind, x, y, pressure, tilt=(0.0, 0.0)):
    """Send one event of a tablet's pen."""
    down = BUTTON.NoButton if kind == KIND.TabletRelease else BUTTON.LeftButton
    position = QtCore.QPointF(x, y)
    event = QtGui.QTabletEvent(
        kind, PEN, position, canvas.mapToGlobal(position), pressure, *tilt, 0.0, 0.0, 0.0, NO_KEY,
        BUTTON.LeftButton, down,
    )  # fmt: skip
    event.setTimestamp(HAND.now_ms)
    QtWidgets.QApplication.sendEvent(canvas, event)


def pen_stroke(canvas, start, end, pressures, tilt=(0.0, 0.0)):
    """A stroke with a tablet's pen."""
    size = np.array([canvas.width(), canvas.height()])
    path = np.linspace(np.array(start) * size, np.array(end) * size, len(pressures))
    HAND.begin()
    for k, ((x, y), pressure) in enumerate(zip(path, pressures, strict=True)):
        kind = KIND.TabletPress if k == 0 else KIND.TabletMove
        kind = KIND.TabletRelease if k == len(pressures) - 1 else kind
        pen(canvas, kind, x, y, pressure, tilt)
        live(0.008)
        HAND.pass_by(0.008)
    live()

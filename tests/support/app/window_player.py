"""Plays a recording of a hand into the window, its dialogs and menus, and waits as a hand does.

What is pressed is looked for by the name that a screen reader tells, where it is seen: see
`tests/app/README.md`.
"""

from __future__ import annotations

import time

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.window.studio import StudioWindow
from tests.support.app.calm import Calm
from tests.support.app.controls import (
    POPUP,
    Control,
    find_control,
    named_controls,
    title_of,
    windows,
)
from tests.support.app.event_player import (
    BUTTONS,
    PENS,
    TABLET_KINDS,
    DeviceEvent,
    EventRecording,
    buttons_of,
    modifiers_of,
)
from tests.support.app.gestures import HAND, wait_for

__all__ = ["WindowPlayer"]

_QTEST = QtTest.QTest
_LOOK_MS, _PATIENCE_S = 20, 300.0
_REST_MS = 60  # at most, between two things that a hand does
_SENDING_S = 0.05  # what takes longer has opened a dialog, in which the hand goes on


class WindowPlayer(QtCore.QObject):
    """Does in one window what a recording says, each as soon as it can be done.

    Events are sent through Qt's window system: popups, modal dialogs, focus and shortcuts get them
    as they get a mouse's and a keyboard's. A pen's go to the picture, where it is seen.

    Parameters
    ----------
    window : StudioWindow
    """

    def __init__(self, window: StudioWindow) -> None:
        super().__init__(window)
        self._window, self._calm = window, Calm(window)
        self._events: list[DeviceEvent] = []
        self._fault: Exception | None = None
        self._held: tuple[QtWidgets.QWidget, Control] | None = None  # what was pressed, where
        self._seen: tuple[QtWidgets.QWidget, Control] | None = None  # at the last look
        self._sent_s: float | None = None  # when what is being sent was sent
        self._until = 0.0

    def play(self, recording: EventRecording) -> None:
        """Play a recording to its end, and wait until all is done that it asks for.

        Raises
        ------
        AssertionError
            If what is pressed is not there in time.
        """
        self._window.resize(*recording.header["window"])
        self._events, self._fault = list(recording.events), None
        program = QtWidgets.QApplication.instance()
        program.installEventFilter(HAND)
        try:
            self._calm.ask()
            self._go_on(0)
            patience = _PATIENCE_S * (1 + len(recording.events))
            wait_for(lambda: self._fault is not None or not self._events, patience)
        finally:
            program.removeEventFilter(HAND)
            self._events = []
        if self._fault is not None:
            raise self._fault
        wait_for(self._calm)

    def _go_on(self, wait_ms: int) -> None:
        """Do the next thing after a while; also in a dialog that what is done now may open."""
        self._until = time.perf_counter() + _PATIENCE_S
        QtCore.QTimer.singleShot(wait_ms, self._step)

    def _step(self) -> None:
        """Do what comes next if it can be done, else look again."""
        if not self._events or self._fault is not None:
            return
        if self._sent_s is not None and time.perf_counter() - self._sent_s < _SENDING_S:
            QtCore.QTimer.singleShot(_LOOK_MS, self._step)  # Qt looks for events while it sends one
            return
        event = self._events[0]
        try:
            if self._do(event):
                return
            assert time.perf_counter() < self._until, self._missing(event)
            QtCore.QTimer.singleShot(_LOOK_MS, self._step)
        except Exception as error:
            self._fault = error
            while (dialog := QtWidgets.QApplication.activeModalWidget()) is not None:
                dialog.close()  # nobody else would, and the test would wait for ever
                dialog.hide()

    def _do(self, event: DeviceEvent) -> bool:
        """Do something, if it can be done; return whether it could."""
        deliberate = event.kind in ("press", "wheel")
        if deliberate and not (self._calm.hears if event.hasty else self._calm()):
            return False
        if event.device == "key":
            found = windows(event.window)
            if not found and event.kind == "press":
                return False
            self._take(event)
            self._sent_s = time.perf_counter()
            self._send_key(event, found[0] if found else None)
        else:
            held = self._held or self._look_for(event)
            seen, self._seen = self._seen, held
            if held is None or (deliberate and held != seen):
                return False  # what still moves is pressed once it has come to rest
            self._seen = None
            self._take(event)
            self._held = held if event.kind == "press" or event.buttons else None
            self._sent_s = time.perf_counter()
            self._send_pointer(event, *held)
        self._sent_s = None
        if deliberate or event.kind == "release":
            self._calm.ask()
        return True

    def _take(self, event: DeviceEvent) -> None:
        """Take an event off those to come; the next is done when as much time is gone, or soon."""
        del self._events[0]
        wait_ms = 0
        if self._events:
            wait_ms = max(0, self._events[0].time_ms - event.time_ms)
        if event.kind == "press":
            HAND.begin()
        self._go_on(min(wait_ms, _REST_MS))
        self._wait_ms = wait_ms

    def _look_for(self, event: DeviceEvent) -> tuple[QtWidgets.QWidget, Control] | None:
        """Return the window and the control that an event is for, if it is seen there."""
        for window in windows(event.window):
            control = find_control(window, event.on, event.place)
            if control is not None:
                return window, control
        return None

    def _send_pointer(
        self, event: DeviceEvent, window: QtWidgets.QWidget, control: Control
    ) -> None:
        place, canvas = control.place(event.place), self._window.canvas
        if event.device in PENS:
            local = canvas.mapFromGlobal(place)
            made = QtGui.QTabletEvent(
                TABLET_KINDS[event.kind], PENS[event.device], local, place, event.pressure,
                *event.tilt, 0.0, event.rotation, 0.0, modifiers_of(event), BUTTONS["left"],
                buttons_of(event),
            )  # fmt: skip
            made.setTimestamp(HAND.now_ms)
            HAND.pass_by(1e-3 * self._wait_ms)
            QtWidgets.QApplication.sendEvent(canvas, made)
            return
        handle = window.windowHandle()
        if handle is None or not handle.isVisible():
            return  # the press has closed it
        at, keys = handle.mapFromGlobal(place.toPoint()), modifiers_of(event)
        HAND.pass_by(1e-3 * self._wait_ms)
        if event.kind == "wheel":
            _QTEST.wheelEvent(handle, at, QtCore.QPoint(0, round(120 * event.notches)))
        elif event.kind == "move":
            _QTEST.mouseMove(handle, at)
        else:
            button = BUTTONS[event.button]
            press = event.kind == "press"
            if press:
                _QTEST.mouseMove(handle, at)
            (_QTEST.mousePress if press else _QTEST.mouseRelease)(handle, button, keys, at)

    def _send_key(self, event: DeviceEvent, window: QtWidgets.QWidget | None) -> None:
        """Type into a window; a key that has opened or closed it is let go in another."""
        if window is not None and title_of(window) != POPUP:
            window.activateWindow()
        handle = QtGui.QGuiApplication.focusWindow() if window is None else window.windowHandle()
        if handle is None:
            return
        combination = QtGui.QKeySequence(event.key)[0]
        press = event.kind == "press"
        action = _QTEST.KeyAction.Press if press else _QTEST.KeyAction.Release
        _QTEST.sendKeyEvent(
            action, handle, combination.key(), event.text, combination.keyboardModifiers()
        )  # fmt: skip

    def _missing(self, event: DeviceEvent) -> str:
        """Say what there is in place of what is looked for."""
        open_now = [w for w in QtWidgets.QApplication.topLevelWidgets() if w.isVisible()]
        titles = [title_of(window) for window in open_now]
        there = [one.name for window in windows(event.window) for one in named_controls(window)]
        return (
            f"{event.on or event.key!r} of {event.window!r} is not there in {_PATIENCE_S:.0f} s, "
            f"or the window does not rest; windows are {titles}, and in it {there}"
        )

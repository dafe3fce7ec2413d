"""Pens with buttons, and fingers, for tests: real Qt events to a window's canvas.

Their times are the hand's, not those at which a busy machine gets to them: see `HandsTime`.
"""

from __future__ import annotations

import numpy as np
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from tests.support.app.gestures import BUTTON, HAND, KIND, NO_KEY, PEN, live

_SCREEN: list = []


def pen(canvas, kind, x, y, *, pressure=0.4, button=BUTTON.LeftButton, buttons=None, keys=NO_KEY):
    """Send one event of a pen; by default its tip is down unless it is released."""
    if buttons is None:
        buttons = button if kind != KIND.TabletRelease and pressure > 0.0 else BUTTON.NoButton
    position = QtCore.QPointF(x, y)
    event = QtGui.QTabletEvent(
        kind, PEN, position, canvas.mapToGlobal(position), pressure, 0.0, 0.0, 0.0, 0.0, 0.0, keys,
        button, buttons,
    )  # fmt: skip
    event.setTimestamp(HAND.now_ms)
    QtWidgets.QApplication.sendEvent(canvas, event)
    live(0.008)
    HAND.pass_by(0.008)


def pen_drag(canvas, start, end, *, held=BUTTON.NoButton, pressure=0.4, keys=NO_KEY, n=8):
    """Drag a pen, with one of its buttons held or not; pressure 0: above the tablet."""
    size = np.array([canvas.width(), canvas.height()])
    path = np.linspace(np.array(start) * size, np.array(end) * size, n)
    tip = BUTTON.LeftButton if pressure > 0.0 else BUTTON.NoButton
    first = BUTTON.LeftButton if pressure > 0.0 else held
    HAND.begin()
    options = {"pressure": pressure, "keys": keys}
    pen(canvas, KIND.TabletPress, *path[0], button=first, buttons=held | tip, **options)
    for at in path:
        pen(canvas, KIND.TabletMove, *at, button=BUTTON.NoButton, buttons=held | tip, **options)
    last = {"pressure": 0.0, "keys": keys, "button": first, "buttons": BUTTON.NoButton}
    pen(canvas, KIND.TabletRelease, *path[-1], **last)
    live(0.03)


class Touching:
    """Fingers on a canvas; all are lifted at the end."""

    def __init__(self, canvas) -> None:
        if not _SCREEN:
            _SCREEN.append(QtTest.QTest.createTouchDevice())
        self._canvas, self._down = canvas, {}

    def __enter__(self) -> Touching:
        HAND.begin()
        return self

    def set(self, places, wait=0.012) -> None:
        """Put fingers at these positions, by their numbers; others are lifted."""
        sequence = QtTest.QTest.touchEvent(self._canvas, _SCREEN[0], False)
        for number in {*places, *self._down}:
            at = places.get(number, self._down.get(number))
            position = QtCore.QPoint(round(float(at[0])), round(float(at[1])))
            if number not in places:
                sequence.release(number, position, self._canvas)
            elif number in self._down:
                sequence.move(number, position, self._canvas)
            else:
                sequence.press(number, position, self._canvas)
        HAND.commit(sequence)
        self._down = dict(places)
        live(wait)
        HAND.pass_by(wait)

    def drag(self, ways, n=8) -> None:
        """Drag fingers from where to where, and lift them."""
        for t in np.linspace(0.0, 1.0, n):
            self.set(
                {
                    k: (1 - t) * np.asarray(start) + t * np.asarray(end)
                    for k, (start, end) in ways.items()
                }
            )
        self.set({})

    def __exit__(self, *_) -> None:
        if self._down:
            self.set({})
        live(0.05)


def places(window, *shares) -> list[np.ndarray]:
    """Places in the picture by shares of its size."""
    return [np.array(one) * (window.canvas.width(), window.canvas.height()) for one in shares]


def move_view(window) -> None:
    """Put one finger on the object, move it, and go on with two."""
    with Touching(window.canvas) as fingers:
        one, begun, other, there, aside = places(
            window, (0.44, 0.42), (0.46, 0.42), (0.54, 0.42), (0.49, 0.44), (0.60, 0.44)
        )
        fingers.set({1: one})
        fingers.set({1: begun})
        fingers.drag({1: (begun, there), 2: (other, aside)})


def tap(canvas, *places) -> None:
    """Tap with fingers at these places, one after the other, and lift them."""
    with Touching(canvas) as fingers:
        for k in range(1, 1 + len(places)):
            fingers.set(dict(enumerate(places[:k])), 0.0)
        fingers.set({}, 0.0)

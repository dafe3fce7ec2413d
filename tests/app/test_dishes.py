"""The dishes of ink, pressed by a finger, a pen or a mouse for as long as their events say."""

from __future__ import annotations

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.ink.ink_panel import DishGrid
from paint3d.app.window.theme import LIGHT_THEME
from tests.support.app.gestures import BUTTON, KIND, NO_KEY, wait_for

NAMES = ["pine soot", "cinnabar", "gamboge"]


class Touched:
    """A grid of dishes, and what was asked of it."""

    def __init__(self) -> None:
        self.grid, self.asked = DishGrid(NAMES, LIGHT_THEME), []
        self.grid.taken.connect(lambda name: self.asked.append(("taken", name)))
        self.grid.stirred.connect(lambda name: self.asked.append(("stirred", name)))
        self.grid.resize(280, 120)
        self.grid.show()

    def send(self, kind, index: int, at_ms: int) -> None:
        """One event of a mouse, as Qt makes it of a finger too, with a time of its own."""
        place = self.grid.box(index).center()
        down = BUTTON.LeftButton if kind == KIND.MouseButtonPress else BUTTON.NoButton
        whole = self.grid.mapToGlobal(place)
        event = QtGui.QMouseEvent(kind, place, whole, BUTTON.LeftButton, down, NO_KEY)
        event.setTimestamp(at_ms)
        QtWidgets.QApplication.sendEvent(self.grid, event)

    def picture(self) -> bytes:
        """What is shown."""
        image = self.grid.grab().toImage().convertToFormat(QtGui.QImage.Format.Format_RGB32)
        return bytes(image.constBits())


@pytest.fixture
def touched(program):
    held = Touched()
    yield held
    held.grid.close()


def wait_long(touched: Touched) -> None:
    """Let the time pass after which a press is a long one, which is none for this one."""
    (timer,) = touched.grid.findChildren(QtCore.QTimer)
    timer.start(0)
    wait_for(lambda: not timer.isActive())


@pytest.mark.parametrize(("held_ms", "asked"), [(40, "taken"), (499, "taken"), (500, "stirred")])
@pytest.mark.parametrize("heard_late", [False, True])
def test_the_events_say_how_long_a_dish_was_pressed(touched, held_ms, asked, heard_late) -> None:
    """A busy window hears of a short press late; it is a short one."""
    touched.send(KIND.MouseButtonPress, 1, 70_000)
    if heard_late:
        wait_long(touched)
    assert touched.asked == []
    touched.send(KIND.MouseButtonRelease, 1, 70_000 + held_ms)
    assert touched.asked == [(asked, "cinnabar")]


def test_a_press_that_slides_off_asks_for_nothing(touched) -> None:
    touched.send(KIND.MouseButtonPress, 1, 0)
    touched.send(KIND.MouseButtonRelease, 2, 900)
    assert touched.asked == []


def test_it_shows_when_it_has_been_pressed_long_enough(touched) -> None:
    still = touched.picture()
    touched.send(KIND.MouseButtonPress, 0, 0)
    short = touched.picture()
    wait_long(touched)
    assert touched.picture() not in (still, short)
    touched.send(KIND.MouseButtonRelease, 0, 900)
    assert touched.picture() == short

"""A finger presses as hard as its contact is large, where the screen says how large that is."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui

from paint3d.app.model.input.event_clock import EventClock
from tests.support.app.gestures import KIND, live
from tests.support.app.windows import opened, settled

CAN = QtGui.QInputDevice.Capability
STATE = QtGui.QEventPoint.State


class Point:
    """A finger at a place, with a contact so many pixels across."""

    def __init__(self, x, y, across, state, pressure=1.0) -> None:
        self._place, self._across, self._state = QtCore.QPointF(x, y), across, state
        self._pressure = pressure

    def id(self) -> int:
        return 1

    def state(self):
        return self._state

    def position(self):
        return self._place

    def pressure(self) -> float:
        return self._pressure

    def ellipseDiameters(self):
        return QtCore.QSizeF(self._across, self._across)


class Touched(QtGui.QTouchEvent):
    """Qt makes no points with a size for tests: these are as its own would be."""

    def __init__(self, kind, device, point) -> None:
        super().__init__(kind, device)
        self._point = point

    def points(self) -> list[Point]:
        return [self._point]


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 1.5, "porcelain") as window:
        yield window


def stroke_pressures(window, can, across_mm, pressure=1.0):
    """The pressures of a stroke by a finger whose contact is so large, mm."""
    canvas = window.canvas
    canvas._clock = EventClock()
    device = QtGui.QPointingDevice(
        "screen", 7, QtGui.QInputDevice.DeviceType.TouchScreen,
        QtGui.QPointingDevice.PointerType.Finger, CAN.Position | can, 5, 1,
    )  # fmt: skip
    fine = canvas.screen().physicalDotsPerInch() / 25.4
    y, n = 0.55 * canvas.height(), len(window.document.strokes)
    for k, x in enumerate(np.linspace(0.42, 0.58, 16) * canvas.width()):
        state, kind = (STATE.Updated, KIND.TouchUpdate) if k else (STATE.Pressed, KIND.TouchBegin)
        canvas.event(Touched(kind, device, Point(x, y, across_mm * fine, state, pressure)))
        live(0.01)
    canvas.event(Touched(KIND.TouchEnd, device, Point(x, y, 0.0, STATE.Released)))
    settled(window)
    assert len(window.document.strokes) == n + 1
    return [sample.pressure for sample in window.document.strokes[-1].samples[2:-2]]


@pytest.mark.parametrize(("across", "wanted"), [(7.0, 0.25), (10.0, 0.5), (30.0, 1.0)])
def test_the_contact_is_the_pressure(window, across, wanted) -> None:
    assert np.allclose(stroke_pressures(window, CAN.Area, across), wanted, atol=0.01)


def test_without_a_size_it_is_as_with_a_mouse(window) -> None:
    force = window.hand.hand.force / 7.9
    for can, across in ((CAN.Position, 10.0), (CAN.Area, 0.3)):
        assert max(stroke_pressures(window, can, across)) == pytest.approx(force)


def test_a_screen_that_tells_the_pressure_itself(window) -> None:
    told = stroke_pressures(window, CAN.Pressure, 0.0, pressure=0.4)
    assert np.allclose(told, 0.4, atol=0.01)

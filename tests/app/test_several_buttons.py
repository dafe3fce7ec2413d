"""A second button, a mouse that a pen's driver makes up, a broken pressure: a stroke stays one."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.model.input.event_clock import EventClock
from paint3d.app.window.brush.brush_editor import FactorCurve
from paint3d.app.window.copybook.picture_view import PictureView
from paint3d.app.window.hand.hand_panel import CurveEditor
from paint3d.app.window.theme import LIGHT_THEME
from tests.support.app.gestures import BUTTON, HAND, KIND, NO_KEY, live, mouse
from tests.support.app.pointers import Touching, pen, pen_drag
from tests.support.app.windows import faults, opened, settled

TIP, SIDE, NONE = BUTTON.LeftButton, BUTTON.RightButton, BUTTON.NoButton


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 4.0, "porcelain", drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def fresh(window, monkeypatch: pytest.MonkeyPatch):
    """A canvas that knows of no device yet; nothing may go wrong unseen in what Qt calls."""
    monkeypatch.setattr(window.canvas, "_clock", EventClock())
    for name, first in {
        "pen_seen_ns": None,
        "_pen_touched_ns": None,
        "_has_misread": False,
    }.items():
        monkeypatch.setattr(window.canvas, name, first)
    HAND.begin()
    with faults() as found:
        yield
    settled(window)
    assert not found
    assert not window.hand.in_stroke
    assert not window.canvas.is_steering


def strokes(window) -> int:
    settled(window)
    return len(window.document.strokes)


def place(window, x: float, y: float = 0.5) -> tuple[float, float]:
    return x * window.canvas.width(), y * window.canvas.height()


def stray(window, kind, x: float, button=NONE, buttons=TIP, y: float = 0.5) -> None:
    """A mouse's event with the time of the pen's, as a driver makes it up."""
    at = QtCore.QPointF(*place(window, x, y))
    event = QtGui.QMouseEvent(kind, at, window.canvas.mapToGlobal(at), button, buttons, NO_KEY)
    event.setTimestamp(HAND.now_ms)
    QtWidgets.QApplication.sendEvent(window.canvas, event)
    HAND.pass_by(0.001)


def last_way(window) -> np.ndarray:
    """(2,) how far the samples of the last stroke go along x and y, mm."""
    settled(window)
    samples = window.document.strokes[-1].samples
    places = np.array([sample.position[:2] for sample in samples if sample.pressure])
    return np.ptp(places, axis=0)


def pressures(window) -> set[float]:
    """Those of the last stroke."""
    settled(window)
    return {round(sample.pressure, 3) for sample in window.document.strokes[-1].samples}


@pytest.mark.parametrize("pressure", [0.5, 0.0])
def test_a_pens_side_button_clicked_while_it_paints_leaves_one_stroke(window, pressure) -> None:
    """Qt says `TabletRelease` for each button, with the pressure of the tip, or none at all."""
    canvas, n = window.canvas, strokes(window)
    pen_drag(canvas, (0.4, 0.5), (0.6, 0.5))
    whole = last_way(window)
    HAND.pass_by(0.5)
    pen(canvas, KIND.TabletPress, *place(window, 0.4), button=TIP)
    for x in np.linspace(0.4, 0.5, 5):
        pen(canvas, KIND.TabletMove, *place(window, x), button=NONE, buttons=TIP)
    held = TIP | SIDE
    pen(canvas, KIND.TabletPress, *place(window, 0.5), button=SIDE, buttons=held)
    pen(canvas, KIND.TabletMove, *place(window, 0.5), button=NONE, buttons=held)
    options = {"button": SIDE, "buttons": TIP, "pressure": pressure}
    pen(canvas, KIND.TabletRelease, *place(window, 0.5), **options)
    assert window.hand.in_stroke
    for x in np.linspace(0.5, 0.6, 5):
        pen(canvas, KIND.TabletMove, *place(window, x), button=NONE, buttons=TIP)
    pen(canvas, KIND.TabletRelease, *place(window, 0.6), button=TIP, buttons=NONE, pressure=0.3)
    assert strokes(window) == n + 2
    np.testing.assert_allclose(last_way(window), whole, atol=0.05 * whole[0])


def test_a_mouses_right_button_clicked_while_the_left_paints_leaves_one_stroke(window) -> None:
    canvas, n, before = window.canvas, strokes(window), window.hand.camera
    both = TIP | SIDE
    mouse(canvas, KIND.MouseMove, *place(window, 0.4))
    mouse(canvas, KIND.MouseButtonPress, *place(window, 0.4), TIP, TIP)
    mouse(canvas, KIND.MouseMove, *place(window, 0.45), NONE, TIP)
    mouse(canvas, KIND.MouseButtonPress, *place(window, 0.5), SIDE, both)
    mouse(canvas, KIND.MouseMove, *place(window, 0.5), NONE, both)
    mouse(canvas, KIND.MouseButtonRelease, *place(window, 0.5), SIDE, TIP)
    assert window.hand.in_stroke
    mouse(canvas, KIND.MouseMove, *place(window, 0.6), NONE, TIP)
    mouse(canvas, KIND.MouseButtonRelease, *place(window, 0.6), TIP, NONE)
    assert strokes(window) == n + 1
    assert window.hand.camera is before


@pytest.mark.parametrize("by", ["pen", "mouse"])
def test_another_button_clicked_on_a_grip_lets_it_be_held(window, by) -> None:
    """And what is let go of last ends it: nothing is painted then."""
    canvas, n, before = window.canvas, strokes(window), window.hand.camera
    x, y = window.steering.grips.box("dolly", canvas.rect()).center().toTuple()
    kinds = KIND.MouseButtonPress, KIND.MouseMove, KIND.MouseButtonRelease
    if by == "pen":
        kinds = KIND.TabletPress, KIND.TabletMove, KIND.TabletRelease

    def send(kind, y, button, buttons) -> None:
        if by == "pen":
            pen(canvas, kind, x, y, button=button, buttons=buttons)
        else:
            mouse(canvas, kind, x, y, button, buttons)

    send(kinds[0], y, TIP, TIP)
    send(kinds[0], y, SIDE, TIP | SIDE)
    send(kinds[2], y, SIDE, TIP)
    assert canvas.is_steering
    send(kinds[1], y - 40, NONE, TIP)
    send(kinds[2], y - 40, TIP, NONE)
    assert not canvas.is_steering
    assert np.linalg.norm(window.hand.camera.position - before.position) > 1.0
    window.hand.look(before)
    assert strokes(window) == n


@pytest.mark.parametrize("moved", [False, True])
def test_a_mouse_press_just_before_a_pens_is_taken_back(window, moved) -> None:
    canvas, n = window.canvas, strokes(window)
    pen_drag(canvas, (0.4, 0.5), (0.6, 0.5))
    alone = pressures(window)
    HAND.pass_by(0.5)
    pen(canvas, KIND.TabletMove, *place(window, 0.4), pressure=0.0, button=NONE)
    stray(window, KIND.MouseButtonPress, 0.4, TIP)
    if moved:
        stray(window, KIND.MouseMove, 0.42)
    pen(canvas, KIND.TabletPress, *place(window, 0.4))
    for x in np.linspace(0.4, 0.6, 8):
        pen(canvas, KIND.TabletMove, *place(window, x), button=NONE, buttons=TIP)
        stray(window, KIND.MouseMove, x)
    pen(canvas, KIND.TabletRelease, *place(window, 0.6), pressure=0.0)
    stray(window, KIND.MouseButtonRelease, 0.6, TIP, NONE)
    assert strokes(window) == n + 2
    assert pressures(window) == alone


def test_a_mouse_press_just_after_a_pens_lift_is_not_painted_but_a_later_one_is(window) -> None:
    n = strokes(window)
    pen_drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
    for wait_s in (0.02, 0.3):
        HAND.pass_by(wait_s)
        stray(window, KIND.MouseButtonPress, 0.6, TIP)
        stray(window, KIND.MouseMove, 0.62)
        stray(window, KIND.MouseButtonRelease, 0.62, TIP, NONE)
        assert strokes(window) == n + 1 + (wait_s > 0.1)


def test_a_mouse_press_just_before_a_pens_steers_nothing(window) -> None:
    before, n = window.hand.camera, strokes(window)
    stray(window, KIND.MouseButtonPress, 0.03, TIP, y=0.03)
    assert window.canvas.is_steering  # beside the object
    pen_drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
    stray(window, KIND.MouseButtonRelease, 0.6, TIP, NONE)
    assert strokes(window) == n + 1
    assert window.hand.camera is before


def test_a_hand_that_lies_down_just_before_its_pen_leaves_no_dot(window) -> None:
    canvas, n = window.canvas, strokes(window)
    with Touching(canvas) as fingers:
        fingers.set({1: place(window, 0.55, 0.6)})
        fingers.set({1: np.add(place(window, 0.55, 0.6), (12, 0))})
        assert window.hand.in_stroke
        pen(canvas, KIND.TabletPress, *place(window, 0.4))
        for x in np.linspace(0.4, 0.6, 8):
            pen(canvas, KIND.TabletMove, *place(window, x), button=NONE, buttons=TIP)
            fingers.set({1: np.add(place(window, 0.55, 0.6), (100 * x, 0))})
        pen(canvas, KIND.TabletRelease, *place(window, 0.6), pressure=0.0)
    assert strokes(window) == n + 1
    way = last_way(window)
    assert way[1] < 0.1 * way[0]  # nothing from the hand's place to the pen's


@pytest.mark.parametrize(("given", "painted"), [(1.7, 1.0), (-0.4, 0.0), (math.nan, 0.0)])
def test_a_pressure_that_is_none_is_clipped_and_told_once(window, given, painted) -> None:
    canvas, told = window.canvas, []
    canvas.misread.connect(lambda: told.append(1))
    n, heard = strokes(window), []
    canvas.touched.connect(lambda touch: heard.append(touch.pressure))
    pen(canvas, KIND.TabletPress, *place(window, 0.4), buttons=TIP, pressure=given)
    for x in (0.45, 0.5, 0.55):
        pen(canvas, KIND.TabletMove, *place(window, x), button=NONE, buttons=TIP, pressure=given)
    pen(canvas, KIND.TabletRelease, *place(window, 0.6), pressure=0.0)
    assert strokes(window) == n + 1
    assert heard[:4] == [painted] * 4
    assert len(told) == 1
    assert "pressures outside 0 to 1" in window.status.message_label.text()  # after the stroke, too


def click_beside(widget, x: float, y: float) -> None:
    """Click the right button while the left is held."""
    mouse(widget, KIND.MouseButtonPress, x, y, SIDE, TIP | SIDE)
    mouse(widget, KIND.MouseButtonRelease, x, y, SIDE, TIP)


@pytest.mark.parametrize("kind", ["pressure", "factor"])
def test_a_point_of_a_curve_stays_held_while_the_right_button_is_clicked(program, kind) -> None:
    if kind == "pressure":
        curve = CurveEditor(LIGHT_THEME)
    else:
        curve = FactorCurve(LIGHT_THEME)
    curve.resize(200, 200)
    points = (lambda: curve.curve.points) if kind == "pressure" else (lambda: curve.points)
    mouse(curve, KIND.MouseButtonPress, 100, 100, TIP, TIP)
    made = points()
    click_beside(curve, 100, 100)
    mouse(curve, KIND.MouseMove, 100, 60, NONE, TIP)
    mouse(curve, KIND.MouseButtonRelease, 100, 60, TIP, NONE)
    moved = points()
    assert len(moved) == len(made)
    assert [new[1] > old[1] for new, old in zip(moved, made, strict=True)].count(True) == 1
    mouse(curve, KIND.MouseMove, 100, 100)
    assert points() == moved


def test_a_picture_is_dragged_on_while_the_right_button_is_clicked(program) -> None:
    picture = PictureView(LIGHT_THEME)
    picture.resize(300, 300)
    picture.show_area(QtCore.QRectF(0.0, 0.0, 100.0, 100.0))
    clicked: list[tuple[float, float]] = []
    picture.clicked.connect(lambda *at: clicked.append(at))
    start = picture.place(0.0, 0.0)
    mouse(picture, KIND.MouseButtonPress, 100, 100, TIP, TIP)
    mouse(picture, KIND.MouseMove, 150, 100, NONE, TIP)
    click_beside(picture, 150, 100)
    mouse(picture, KIND.MouseMove, 200, 100, NONE, TIP)
    mouse(picture, KIND.MouseButtonRelease, 200, 100, TIP, NONE)
    assert picture.place(0.0, 0.0).x() - start.x() == pytest.approx(100.0)
    assert clicked == []


def test_a_dish_is_taken_once_though_the_right_button_is_clicked(window) -> None:
    dishes = window.panels.inks.dishes
    taken, stirred = [], []
    dishes.taken.connect(taken.append)
    dishes.stirred.connect(stirred.append)
    at = dishes.box(0).center().toPoint().toTuple()
    mouse(dishes, KIND.MouseButtonPress, *at, TIP, TIP)
    click_beside(dishes, *at)
    assert (taken, stirred) == ([], [])
    mouse(dishes, KIND.MouseButtonRelease, *at, TIP, NONE)
    live(0.05)
    assert (len(taken), stirred) == (1, [])

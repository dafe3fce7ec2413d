"""The view is turned, moved, rolled and brought near: by mouse, pen, fingers and keys."""

from __future__ import annotations

import shutil
import subprocess
from contextlib import closing

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.input.event_clock import EventClock
from paint3d.app.model.input.navigation import dolly, roll_of
from paint3d.app.window.hand import keys
from paint3d.app.window.hand import steering as module
from paint3d.app.window.hand.steering import GRIPS, Grips
from paint3d.app.window.theme import DARK_THEME, LIGHT_THEME
from paint3d.view.camera import picture_axes
from tests.support.app.gestures import ALT, BUTTON, KIND, drag, live, mouse, type_key, wait_for
from tests.support.app.pointers import HAND, Touching, pen, pen_drag, tap
from tests.support.app.windows import faults, opened, seen, settled
from tests.support.cases import long_but

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier
CORNER = (0.04, 0.05)  # beside the object, in shares of the canvas


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "sphere", 4.0, "porcelain", drawn=False) as window:
        yield window


@pytest.fixture(scope="module")
def at_first(window) -> tuple:
    """The view and the brush in hand when it was opened."""
    return window.hand.camera, window.document.painter.brush


@pytest.fixture(autouse=True)
def first_view(window, at_first, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(window.canvas, "_clock", EventClock())  # knows no device of other tests
    window.hand.look(at_first[0])
    window.hand.show_all()
    window.workspace.post("set_brush", at_first[1])
    window.canvas.pen_seen_ns = None  # no pen was ever here
    window.activateWindow()
    wait_for(window.isActiveWindow)  # keys are heard there only
    window.canvas.setFocus()
    live(0.05)
    yield
    settled(window)
    assert not window.canvas.is_steering
    assert not window.hand.in_stroke


def back(window) -> np.ndarray:
    return picture_axes(window.hand.camera)[2]


def distance(window) -> float:
    camera = window.hand.camera
    return float(np.linalg.norm(camera.position - camera.focus))


def by(x: float, y: float) -> np.ndarray:
    return np.array([x, y], float)


def strokes(window) -> int:
    settled(window)
    return len(window.document.strokes)


def changes(window, before) -> set[str]:
    """What became of the view since `before`: turned, rolled, moved, zoomed."""
    now, found = window.hand.camera, set()
    if picture_axes(now)[2] @ picture_axes(before)[2] < 1 - 1e-6:
        found.add("orbit")
    if abs(roll_of(now) - roll_of(before)) > 1e-3:
        found.add("roll")
    if np.linalg.norm(now.focus - before.focus) > 1e-3:
        found.add("pan")
    far = [np.linalg.norm(view.position - view.focus) for view in (now, before)]
    if abs(far[0] / far[1] - 1) > 1e-3:
        found.add("dolly")
    return found


@pytest.mark.parametrize("brush", ["gongbi", "full"])
def test_near_shows_three_quarters_of_a_tuft_all_round_and_never_less_near(window, brush) -> None:
    canvas = window.canvas
    window.workspace.post("set_brush", brush)
    settled(window)
    length = window.document.painter.brush.length_mm
    mouse(canvas, KIND.MouseMove, 0.45 * canvas.width(), 0.5 * canvas.height())
    place, first = window.hand.place(), distance(window)
    type_key(canvas, KEY.Key_F)
    live(0.1)
    camera = window.hand.camera
    np.testing.assert_allclose(camera.focus, place, atol=1e-6)
    half = np.tan(0.5 * camera.view_angle) * distance(window)
    assert distance(window) < 0.5 * first
    assert 0.75 * length <= half <= 1.0 * length
    for _ in range(6):
        canvas.wheeled.emit(3.0, 0.5 * canvas.width(), 0.5 * canvas.height())
    near = distance(window)
    type_key(canvas, KEY.Key_F)
    assert distance(window) <= near * (1 + 1e-9)


def test_near_asked_for_again_changes_nothing_until_the_pointer_or_the_brush_does(window) -> None:
    """The place that was come near to is in the middle then, and another under the pointer."""
    canvas = window.canvas
    at = 0.4 * canvas.width(), 0.4 * canvas.height()
    window.workspace.post("set_brush", "gongbi")
    settled(window)
    mouse(canvas, KIND.MouseMove, *at)
    type_key(canvas, KEY.Key_F)
    near = window.hand.camera
    for _ in range(3):
        type_key(canvas, KEY.Key_F)
        mouse(canvas, KIND.MouseMove, at[0] + 1, at[1])  # no hand is that still
    assert window.hand.camera is near
    window.workspace.post("step_brush", -1)
    settled(window)
    type_key(canvas, KEY.Key_F)
    nearer = window.hand.camera
    assert nearer is not near
    mouse(canvas, KIND.MouseMove, 0.6 * canvas.width(), 0.6 * canvas.height())
    type_key(canvas, KEY.Key_F)
    assert changes(window, nearer) == {"pan"}
    assert distance(window) == pytest.approx(np.linalg.norm(nearer.position - nearer.focus))


SIDES = [f"look_{side}" for side in ("front", "back", "left", "right", "top", "bottom")]


@pytest.mark.parametrize("action", [*SIDES, "frame_all"])
def test_all_is_seen_as_large_as_there_is_room_from_each_side_also_when_asked_again(
    window, action
) -> None:
    """From a side the ball was as small as the box around it needs when it is turned."""
    window.hand.look(dolly(window.hand.camera, 3.0))
    window.workspace.actions[action].trigger()
    first = window.hand.camera
    points = window.document.surface.source.vertices - first.position
    right, up, back = picture_axes(first)
    high, wide = (np.abs(points @ way / (points @ back)).max() for way in (up, right))
    half = np.tan(0.5 * first.view_angle)
    aspect = window.canvas.width() / window.canvas.height()
    assert 0.75 < max(high / half, wide / (half * aspect)) < 1.0
    window.workspace.actions[action].trigger()
    assert changes(window, first) == set()


@pytest.mark.parametrize(
    ("key", "held", "towards"),
    [
        (KEY.Key_1, HELD.NoModifier, (0, -1, 0)),
        (KEY.Key_1, HELD.ControlModifier, (0, 1, 0)),
        (KEY.Key_3, HELD.NoModifier, (1, 0, 0)),
        (KEY.Key_3, HELD.ControlModifier, (-1, 0, 0)),
        (KEY.Key_7, HELD.NoModifier, (0, 0, 1)),
        (KEY.Key_7, HELD.ControlModifier, (0, 0, -1)),
        (KEY.Key_End, HELD.NoModifier, (0, -1, 0)),  # the same keys without NumLock
        (KEY.Key_PageDown, HELD.NoModifier, (1, 0, 0)),
        (KEY.Key_Home, HELD.NoModifier, (0, 0, 1)),
    ],
)
def test_the_keypad_turns_the_view_and_leaves_the_brush(window, key, held, towards) -> None:
    brush, load = window.document.painter.brush, window.document.surface.ink.load.copy()
    with faults() as found:
        type_key(window.canvas, key, held | HELD.KeypadModifier)
        settled(window)
    assert found == []
    np.testing.assert_allclose(back(window), towards, atol=1e-9)
    assert window.document.painter.brush == brush
    assert (window.document.surface.ink.load == load).all()


def test_the_digits_above_the_letters_still_take_brushes(window) -> None:
    camera = window.hand.camera
    for key, held, name in (
        (KEY.Key_1, HELD.NoModifier, "full"), (KEY.Key_0, HELD.NoModifier, "zhongbaiyun"),
        (KEY.Key_2, HELD.ControlModifier, "feibai"), (KEY.Key_7, HELD.NoModifier, "gongbi"),
        (KEY.Key_3, HELD.ControlModifier, "langhao"), (KEY.Key_5, HELD.ControlModifier, "jianhao"),
    ):  # fmt: skip
        type_key(window.canvas, key, held)
        settled(window)
        assert window.document.painter.brush.name == name
    assert window.hand.camera is camera


def test_a_drag_beside_the_object_turns_it_and_one_near_its_edge_paints(window) -> None:
    n, before = strokes(window), window.hand.camera
    drag(window.canvas, CORNER, (0.2, 0.2))
    assert changes(window, before) == {"orbit"}
    assert strokes(window) == n
    window.hand.look(before)
    canvas = window.canvas
    x = next(x for x in range(canvas.width()) if window.hand.meets([(x, 0.5 * canvas.height())])[0])
    drag(canvas, ((x - 10) / canvas.width(), 0.5), (0.5, 0.5))
    assert changes(window, before) == set()
    assert strokes(window) == n + 1


def is_brush_seen(window) -> bool:
    """Whether the brush stands in the picture once it has been drawn."""
    with seen(window):
        settled(window)
        return window.stage.brush_box is not None


def test_a_pointer_that_moves_the_view_is_no_brush(window) -> None:
    canvas = window.canvas
    mouse(canvas, KIND.MouseMove, 0.5 * canvas.width(), 0.5 * canvas.height())
    wait_for(lambda: is_brush_seen(window))
    drag(canvas, (0.5, 0.5), (0.6, 0.55), BUTTON.MiddleButton, release=False)
    assert not is_brush_seen(window)
    x, y = 0.6 * canvas.width(), 0.55 * canvas.height()
    mouse(canvas, KIND.MouseButtonRelease, x, y, BUTTON.MiddleButton)
    mouse(canvas, KIND.MouseMove, x - 2.0, y)
    wait_for(lambda: is_brush_seen(window))


STEERED = [
    (HELD.NoModifier, "orbit"),
    (HELD.ShiftModifier, "pan"),
    (HELD.ControlModifier, "dolly"),
    (HELD.ShiftModifier | HELD.ControlModifier, "roll"),
]


@pytest.mark.parametrize(
    ("keys", "what", "by"),
    long_but(
        [(*case, by) for case, by in zip(STEERED, ("mouse", "pen") * 2, strict=True)],
        [(*case, by) for case in STEERED for by in ("mouse", "pen")],
    ),
)
def test_space_held_steers_over_the_object(window, keys, what, by) -> None:
    n, before = strokes(window), window.hand.camera
    QtTest.QTest.keyPress(window.canvas, KEY.Key_Space, keys)
    if by == "mouse":
        drag(window.canvas, (0.5, 0.4), (0.56, 0.5), keys=keys)
    else:
        pen_drag(window.canvas, (0.5, 0.4), (0.56, 0.5), keys=keys)
    QtTest.QTest.keyRelease(window.canvas, KEY.Key_Space, keys)
    assert changes(window, before) == {what}
    assert strokes(window) == n
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5))
    assert strokes(window) == n + 1


def test_space_presses_a_button_that_has_the_focus(window) -> None:
    window.panels.docks["inks"].raise_()
    window.panels.inks.fold.setChecked(True)
    window.panels.inks.tip_only.setFocus()
    before = window.panels.inks.tip_only.isChecked()
    type_key(window.panels.inks.tip_only, KEY.Key_Space)
    assert window.panels.inks.tip_only.isChecked() is not before
    window.panels.inks.tip_only.setChecked(before)


def test_keys_that_are_held_are_let_go_of_with_the_focus(window) -> None:
    QtTest.QTest.keyPress(window.canvas, KEY.Key_Space)
    assert "steer" in window.hand.held
    QtWidgets.QApplication.sendEvent(window, QtCore.QEvent(QtCore.QEvent.Type.WindowDeactivate))
    assert not window.hand.held
    QtTest.QTest.keyRelease(window.canvas, KEY.Key_Space)


@pytest.mark.parametrize("name", ["orbit", "pan", "dolly", "roll"])
@pytest.mark.parametrize("by", ["mouse", "pen", "finger"])
def test_grips_steer_whatever_takes_them(window, name, by) -> None:
    n, before, canvas = strokes(window), window.hand.camera, window.canvas
    box = window.steering.grips.box(name, canvas.rect())
    size = np.array([canvas.width(), canvas.height()])
    start = np.array([box.center().x(), box.center().y()]) / size
    end = start + np.array([-0.05, 0.1])
    if by == "mouse":
        drag(canvas, start, end)
    elif by == "pen":
        pen_drag(canvas, start, end)
    else:
        with Touching(canvas) as fingers:
            fingers.drag({1: (start * size, end * size)})
    assert changes(window, before) == {name}
    assert strokes(window) == n


def test_a_tap_on_a_grip_holds_upright_or_shows_everything(window) -> None:
    canvas, first = window.canvas, window.hand.camera
    type_key(canvas, KEY.Key_BracketLeft, HELD.ControlModifier)
    assert roll_of(window.hand.camera) > 0.1
    type_key(canvas, KEY.Key_Plus)
    for name in ("roll", "dolly"):
        at = window.steering.grips.box(name, canvas.rect()).center()
        drag(canvas, *[(at.x() / canvas.width(), at.y() / canvas.height())] * 2, n=2)
    assert roll_of(window.hand.camera) == pytest.approx(0.0, abs=1e-6)
    assert changes(window, first) == set()


@pytest.mark.parametrize("leap", [-9000.0, 9000.0])
def test_a_drag_may_leap_over_screens_between_two_events(window, leap) -> None:
    canvas, before = window.canvas, window.hand.camera
    with faults() as found:
        mouse(canvas, KIND.MouseButtonPress, 40, 40, BUTTON.RightButton, BUTTON.RightButton)
        mouse(canvas, KIND.MouseMove, 40 + leap, 40, BUTTON.NoButton, BUTTON.RightButton)
        mouse(canvas, KIND.MouseButtonRelease, 40 + leap, 40, BUTTON.RightButton)
        live()
    assert not found
    assert changes(window, before) == {"dolly"}


def test_a_pens_buttons_steer(window) -> None:
    n = strokes(window)
    for button, what in ((BUTTON.RightButton, "orbit"), (BUTTON.MiddleButton, "pan")):
        before = window.hand.camera
        pen_drag(window.canvas, (0.45, 0.5), (0.55, 0.55), held=button)  # the tip on the tablet
        assert changes(window, before) == {what}
        before = window.hand.camera
        pen_drag(window.canvas, (0.45, 0.5), (0.55, 0.55), held=button, pressure=0.0)  # above it
        assert changes(window, before) == {what}
        window.hand.look(before)
    before = window.hand.camera
    pen_drag(window.canvas, (0.45, 0.5), (0.55, 0.5), keys=ALT)
    assert changes(window, before) == {"orbit"}
    assert strokes(window) == n
    pen_drag(window.canvas, (0.45, 0.5), (0.55, 0.5))
    assert strokes(window) == n + 1


def test_two_fingers_move_zoom_and_roll_and_three_turn(window) -> None:
    n, canvas = strokes(window), window.canvas
    w, h = canvas.width(), canvas.height()
    a, b = np.array([0.4 * w, 0.5 * h]), np.array([0.6 * w, 0.5 * h])
    before = window.hand.camera
    with Touching(canvas) as fingers:
        fingers.drag({1: (a, a + by(0, 60)), 2: (b, b + by(0, 60))})
    assert changes(window, before) == {"pan"}
    window.hand.look(before)
    with Touching(canvas) as fingers:
        fingers.drag({1: (a, a - by(60, 0)), 2: (b, b + by(60, 0))})
    assert "dolly" in changes(window, before)
    assert "roll" not in changes(window, before)
    assert distance(window) < np.linalg.norm(before.position - before.focus)
    window.hand.look(before)
    with Touching(canvas) as fingers:
        fingers.drag({1: (a, a + by(30, 60)), 2: (b, b - by(30, 60))})
    assert "roll" in changes(window, before)
    assert roll_of(window.hand.camera) > 0.2  # anticlockwise, as the fingers went
    window.hand.look(before)
    with Touching(canvas) as fingers:
        three = {
            1: (a, a + by(50, 0)),
            2: (b, b + by(50, 0)),
            3: ((a + b) / 2, (a + b) / 2 + by(50, 0)),
        }
        fingers.drag(three)
    assert changes(window, before) == {"orbit"}
    assert strokes(window) == n


def test_taps_undo_and_redo_and_one_finger_paints_until_a_pen_is_used(window) -> None:
    canvas = window.canvas
    w, h = canvas.width(), canvas.height()
    a, b = np.array([0.45 * w, 0.5 * h]), np.array([0.55 * w, 0.5 * h])
    before, n = window.hand.camera, strokes(window)
    with Touching(canvas) as fingers:
        fingers.drag({1: (a, b)})
    assert strokes(window) == n + 1
    assert changes(window, before) == set()
    wait_for(window.workspace.actions["undo"].isEnabled)
    tap(canvas, a, b)
    assert strokes(window) == n
    wait_for(window.workspace.actions["redo"].isEnabled)
    tap(canvas, a, b, (a + b) / 2)
    assert strokes(window) == n + 1
    pen(canvas, KIND.TabletMove, *a, pressure=0.0)
    live(0.3)
    HAND.pass_by(0.3)
    with Touching(canvas) as fingers:
        fingers.drag({1: (a, b)})
    assert strokes(window) == n + 1
    assert changes(window, before) == {"orbit"}
    canvas.finger = "paint"
    with Touching(canvas) as fingers:
        fingers.drag({1: (a, b)})
    assert strokes(window) == n + 2
    canvas.finger = "auto"


def test_the_palm_beside_a_pen_does_nothing(window) -> None:
    canvas, before = window.canvas, window.hand.camera
    w, h = canvas.width(), canvas.height()
    n = strokes(window)
    with Touching(canvas) as fingers:
        pen(canvas, KIND.TabletPress, 0.45 * w, 0.5 * h)
        fingers.drag({1: ((0.6 * w, 0.7 * h), (0.65 * w, 0.75 * h))})
        pen(canvas, KIND.TabletMove, 0.55 * w, 0.5 * h)
        pen(canvas, KIND.TabletRelease, 0.55 * w, 0.5 * h, pressure=0.0)
    assert strokes(window) == n + 1
    assert changes(window, before) == set()


@pytest.mark.parametrize(("rest_s", "busy_s", "what"), [(0.05, 0.3, set()), (0.3, 0.0, {"orbit"})])
def test_a_palm_is_known_by_the_hands_time_however_late_it_is_told(
    window, rest_s, busy_s, what
) -> None:
    before, n = window.hand.camera, strokes(window)
    with Touching(window.canvas) as fingers:
        HAND.now_ms -= 1000
        pen(window.canvas, KIND.TabletMove, 300.0, 200.0, pressure=0.0)
        live(busy_s)
        HAND.pass_by(rest_s)
        fingers.drag({1: ((300.0, 200.0), (340.0, 240.0))})
    assert changes(window, before) == what
    assert strokes(window) == n


def test_a_stroke_that_ends_on_a_grip_has_ended(window) -> None:
    canvas, before, n = window.canvas, window.hand.camera, strokes(window)
    grip = window.steering.grips.box("dolly", canvas.rect()).center()
    pen_drag(canvas, (0.5, 0.5), (grip.x() / canvas.width(), grip.y() / canvas.height()))
    assert not window.hand.in_stroke
    assert strokes(window) == n + 1
    assert changes(window, before) == set()


def test_a_mouse_that_is_pushed_does_not_lift_a_finger(window) -> None:
    canvas, n = window.canvas, strokes(window)
    w, h = canvas.width(), canvas.height()
    canvas.finger = "paint"
    with Touching(canvas) as fingers:
        fingers.set({1: (0.45 * w, 0.5 * h)})
        fingers.set({1: (0.48 * w, 0.5 * h)})
        mouse(canvas, KIND.MouseMove, 0.6 * w, 0.6 * h)
        fingers.set({1: (0.55 * w, 0.5 * h)})
    canvas.finger = "auto"
    assert strokes(window) == n + 1


def test_a_second_finger_soon_takes_the_dot_back(window) -> None:
    canvas = window.canvas
    w, h = canvas.width(), canvas.height()
    n = strokes(window)
    with Touching(canvas) as fingers:
        fingers.set({1: (0.45 * w, 0.5 * h)})
        fingers.set({1: (0.48 * w, 0.5 * h)})
        fingers.set({1: (0.48 * w, 0.5 * h), 2: (0.6 * w, 0.5 * h)})
        fingers.set({1: (0.48 * w, 0.6 * h), 2: (0.6 * w, 0.6 * h)})
    assert strokes(window) == n


@pytest.mark.parametrize("what", ["finger", "pen"])
def test_the_stroke_after_one_that_was_taken_back_is_whole(window, what) -> None:
    canvas = window.canvas
    size = np.array([canvas.width(), canvas.height()])
    a, b, n = np.array([0.45, 0.5]) * size, np.array([0.55, 0.5]) * size, strokes(window)
    with Touching(canvas) as fingers:
        fingers.set({1: a})
        fingers.set({1: a + by(0, 9)})
        fingers.set({1: a + by(0, 9), 2: b})
        fingers.set({1: a + by(0, 60), 2: b + by(0, 60)})
    assert strokes(window) == n
    window.hand.show_all()
    if what == "finger":
        with Touching(canvas) as fingers:
            fingers.drag({1: (a, b)})
    else:
        pen_drag(canvas, (0.45, 0.5), (0.55, 0.5))
    assert strokes(window) == n + 1


@pytest.mark.parametrize(
    ("key", "held", "what"),
    [
        (KEY.Key_Left, HELD.NoModifier, "orbit"),
        (KEY.Key_Right, HELD.NoModifier, "orbit"),
        (KEY.Key_Up, HELD.NoModifier, "orbit"),
        (KEY.Key_Down, HELD.NoModifier, "orbit"),
        (KEY.Key_Left, HELD.ShiftModifier, "pan"),
        (KEY.Key_Down, HELD.ShiftModifier, "pan"),
        (KEY.Key_Plus, HELD.NoModifier, "dolly"),
        (KEY.Key_Minus, HELD.NoModifier, "dolly"),
        (KEY.Key_BracketLeft, HELD.ControlModifier, "roll"),
        (KEY.Key_BracketRight, HELD.ControlModifier, "roll"),
        (KEY.Key_4, HELD.KeypadModifier, "orbit"),
        (KEY.Key_8, HELD.KeypadModifier | HELD.ControlModifier, "pan"),
        (KEY.Key_Plus, HELD.KeypadModifier, "dolly"),
        (KEY.Key_Slash, HELD.KeypadModifier, "roll"),
    ],
)
def test_keys_steer(window, key, held, what) -> None:
    before = window.hand.camera
    type_key(window.canvas, key, held)
    live(0.02)
    assert changes(window, before) == {what}


def test_arrows_and_tab_belong_to_the_panel_that_has_the_focus(window) -> None:
    before = window.hand.camera
    window.panels.docks["brushes"].raise_()
    brushes = window.panels.brushes.findChild(QtWidgets.QListWidget)
    brushes.setFocus()
    row = brushes.currentRow()
    type_key(brushes, KEY.Key_Down if row == 0 else KEY.Key_Up)
    assert brushes.currentRow() != row
    assert window.hand.camera is before
    type_key(brushes, KEY.Key_Tab)
    assert window.panels.docks["brushes"].isVisible()
    assert QtWidgets.QApplication.focusWidget() is not brushes
    window.panels.brushes.show_brush(window.document.painter.brush)


def test_alt_that_moves_the_window_is_told(window) -> None:
    QtTest.QTest.keyPress(window.canvas, KEY.Key_Alt, ALT)
    window.move(window.x() + 7, window.y() + 5)
    live(0.1)
    QtTest.QTest.keyRelease(window.canvas, KEY.Key_Alt)
    assert "Space" in window.status.message_label.text()


@pytest.mark.parametrize("elsewhere", [False, True])
def test_alt_that_has_moved_the_window_is_told_after_it_was_let_go(window, elsewhere: bool) -> None:
    """Who is quick has let go of it before the screen says where the window is."""
    drag(window.canvas, (0.05, 0.5), (0.06, 0.5), n=2)
    window.workspace.tell("")
    QtTest.QTest.keyPress(window.canvas, KEY.Key_Alt, ALT)
    QtTest.QTest.keyRelease(window.canvas, KEY.Key_Alt)
    if elsewhere:  # what Alt was pressed for came to the window: it is moved by its frame
        drag(window.canvas, (0.05, 0.5), (0.06, 0.5), n=2)
    window.move(window.x() + 7, window.y() + 5)
    live(0.1)
    wait_for(lambda: ("Space" in window.status.message_label.text()) != elsewhere)


def test_a_window_manager_that_takes_the_keys_while_it_moves_the_window_is_told(
    window, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As openbox does: the window has no focus until it stands, and nobody hears of Alt."""
    window.workspace.tell("")
    QtTest.QTest.keyPress(window.canvas, KEY.Key_Alt, ALT)
    held = staticmethod(lambda: ALT)
    monkeypatch.setattr(QtGui.QGuiApplication, "queryKeyboardModifiers", held)
    for kind in (QtCore.QEvent.Type.WindowDeactivate, QtCore.QEvent.Type.WindowActivate):
        QtWidgets.QApplication.sendEvent(window, QtCore.QEvent(kind))
    window.move(window.x() + 7, window.y() + 5)
    live(0.1)
    monkeypatch.undo()
    QtTest.QTest.keyRelease(window.canvas, KEY.Key_Alt)
    assert "Space" in window.status.message_label.text()


SEEN: list[QtCore.QEvent.Type] = []


def note(self: object, watched: object, event: QtCore.QEvent) -> bool:
    """A filter that takes nothing; Qt holds no reference to it, so that it has to stay."""
    SEEN.append(event.type())
    return False


def test_events_of_all_the_program_are_looked_at_only_while_the_window_is_active(
    program, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To hand one to Python costs more than most of them do."""
    seen = SEEN
    monkeypatch.setattr(keys._Everywhere, "eventFilter", note)
    with opened(program, "plane", 4.0, drawn=False) as other:
        wait_for(other.isActiveWindow)
        type_key(other.canvas, KEY.Key_F24)
        assert QtCore.QEvent.Type.KeyPress in seen
        with closing(QtWidgets.QDialog()) as elsewhere:
            elsewhere.show()
            elsewhere.activateWindow()
            wait_for(lambda: elsewhere.isActiveWindow() and not other.isActiveWindow())
            seen.clear()
            QtTest.QTest.keyClick(other.canvas, KEY.Key_F24)
            assert seen == []
        type_key(other.canvas, KEY.Key_F24)
        assert QtCore.QEvent.Type.KeyPress in seen


@pytest.mark.parametrize("had", [True, False])
def test_keys_that_went_to_nobody_when_a_dialog_closed_are_asked_for(
    window, monkeypatch: pytest.MonkeyPatch, had: bool
) -> None:
    """If they were this program's: nobody's keys are taken from another."""
    focus, asked = [window.windowHandle() if had else None], []
    current = staticmethod(lambda: focus[-1])
    monkeypatch.setattr(QtGui.QGuiApplication, "focusWindow", current)
    monkeypatch.setattr(window, "activateWindow", lambda: asked.append(True))
    dialog = QtWidgets.QDialog(window)
    dialog.setWindowModality(QtCore.Qt.WindowModality.WindowModal)
    dialog.show()
    live(0.1)
    dialog.close()
    focus.append(None)
    if had:
        wait_for(lambda: asked)
    live(0.5)
    assert len(asked) == had
    dialog.deleteLater()


@pytest.mark.skipif(shutil.which("xdotool") is None, reason="xdotool is not installed")
def test_every_step_of_a_real_mouse_is_heard_however_busy_the_window_is(window) -> None:
    """The screen sends them while nobody listens; none is left out for the one after it."""
    middle = window.canvas.mapToGlobal(window.canvas.rect().center())
    steps = [(middle.x() + 4 * k, middle.y() + 2 * (k % 2)) for k in range(30)]
    ratio = window.devicePixelRatio()
    words = [f"mousemove {ratio * x:.0f} {ratio * y:.0f}".split() for x, y in steps]
    heard: list[tuple[int, int]] = []
    live(0.1)
    window.canvas.touched.connect(lambda touch: heard.append((round(touch.x), round(touch.y))))
    subprocess.run(["xdotool", *(word for step in words for word in step)], check=True)
    wanted = [window.canvas.mapFromGlobal(QtCore.QPoint(*step)).toTuple() for step in steps]
    wait_for(lambda: heard[-1:] == wanted[-1:])
    assert set(wanted) <= set(heard)


@pytest.mark.skipif(shutil.which("xdotool") is None, reason="xdotool is not installed")
@pytest.mark.parametrize("num_lock", [False, True])
def test_real_key_codes_of_the_keypad_turn_the_view(window, num_lock) -> None:
    def press(*keys: str) -> None:
        subprocess.run(["xdotool", "key", *keys], check=True)
        live(0.15)

    subprocess.run(["xdotool", "windowfocus", str(int(window.winId()))], check=True)
    wait_for(window.isActiveWindow)
    brush = window.document.painter.brush
    if num_lock:
        press("Num_Lock")
    try:
        for code, towards in ((87, (0, -1, 0)), (89, (1, 0, 0)), (79, (0, 0, 1))):
            press(str(code))
            np.testing.assert_allclose(back(window), towards, atol=1e-9)
    finally:
        if num_lock:
            press("Num_Lock")
    assert window.document.painter.brush == brush


# -- the column of grips -----------------------------------------------------------------------


AREA = QtCore.QRect(0, 0, 320, 260)


def picture(grips: Grips, pixel_ratio: float = 1.0) -> QtGui.QImage:
    """What a canvas of 320 x 260 shows with them."""
    image = QtGui.QImage(AREA.size() * pixel_ratio, QtGui.QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(pixel_ratio)
    image.fill(QtGui.QColor(90, 120, 150))
    painter = QtGui.QPainter(image)
    grips.paint(painter, AREA)
    painter.end()
    return image


def test_they_are_drawn_anew_only_when_they_look_otherwise(program, monkeypatch) -> None:
    made: list[str] = []
    make = module.make_icon
    monkeypatch.setattr(module, "make_icon", lambda n, t: (made.append(n), make(n, t))[1])
    theme = [LIGHT_THEME]
    grips = Grips(lambda: theme[0])

    def look(**now: object) -> QtGui.QImage:
        for name, value in now.items():
            setattr(grips, name, value)
        first = picture(grips)
        n_made = len(made)
        assert picture(grips) == first
        assert len(made) == n_made
        return first

    seen = [look(), look(under="pan"), look(held="pan"), look(held=None, under="roll")]
    theme[0] = DARK_THEME
    seen.append(look())
    assert all(seen[i] != seen[j] for i in range(len(seen)) for j in range(i))
    assert len(made) == len(seen) * len(GRIPS)
    assert picture(grips, 2.0).size() == 2 * seen[0].size()
    assert len(made) == (len(seen) + 1) * len(GRIPS)
    grips.shown = False
    assert picture(grips).pixelColor(300, 30) == QtGui.QColor(90, 120, 150)


def test_they_lie_where_they_are_taken_hold_of(program) -> None:
    grips = Grips(lambda: LIGHT_THEME)
    bare = QtGui.QColor(90, 120, 150)
    image = picture(grips)
    for name in GRIPS:
        box = grips.box(name, AREA)
        middle = box.center()
        assert grips.at(middle.x(), middle.y(), AREA) == name
        left = next(
            x for x in range(AREA.width()) if image.pixelColor(x, round(middle.y())) != bare
        )
        assert abs(left - box.left()) <= 1.0
        column = range(round(box.top()) - 3, round(box.bottom()) + 4)
        inked = [y for y in column if image.pixelColor(round(middle.x()), y) != bare]
        assert abs(inked[0] - box.top()) <= 1.0
        assert abs(inked[-1] + 1 - box.bottom()) <= 1.0

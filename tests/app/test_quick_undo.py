"""Undo and redo in quick succession: each that was asked for is done, whatever the buttons show."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from tests.support.app.gestures import drag, live, wait_for
from tests.support.app.pointers import places, tap
from tests.support.app.windows import faults, opened, settled
from tests.support.cases import long_but

CTRL, SHIFT = QtCore.Qt.KeyboardModifier.ControlModifier, QtCore.Qt.KeyboardModifier.ShiftModifier
N_STROKES = 4


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 2.5, "xuan") as window, faults() as found:
        yield window
        assert not found


@pytest.fixture(params=["dry", "wet"])
def painted(window, request: pytest.FixtureRequest):
    """A window with some strokes, and codes of all colours after none, one, two... of them."""
    assert window.opening.open_path("plane", 2.5, "xuan", asked=True)
    window.stage.paint_thread.wet = request.param == "wet"
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.canvas.setFocus()
    seen = [colours(window)]
    for y in np.linspace(0.35, 0.65, N_STROKES):
        drag(window.canvas, (0.42, y), (0.58, y), n=6)
        settled(window)
        seen.append(colours(window))
    return window, seen


def colours(window) -> np.ndarray:
    with window.stage.paint_thread.paused() as document:
        n = document.surface.source.n_vertices
        return document.surface.srgb[:n].copy()


@contextmanager
def no_frames(window) -> Iterator[None]:
    """Let no frame come meanwhile, as on a machine that is busy."""
    window.workspace.hold()
    try:
        yield
    finally:
        window.workspace.go_on()


def ask(window, step: str) -> None:
    keys = CTRL if step == "undo" else CTRL | SHIFT
    QtTest.QTest.keyClick(window.canvas, QtCore.Qt.Key.Key_Z, keys)


def wait_for_buttons(window, *enabled: bool) -> None:
    actions = window.workspace.actions["undo"], window.workspace.actions["redo"]
    wait_for(lambda: tuple(action.isEnabled() for action in actions) == enabled)


@pytest.mark.parametrize("seed", long_but([1, 2], range(8)))
def test_any_keys_of_undo_and_redo_leave_what_they_spell(painted, seed: int) -> None:
    window, seen = painted
    document, chance, done = window.document, random.Random(seed), N_STROKES
    for _ in range(12):  # else where they end hides what was lost: undo at the start does nothing
        for _ in range(chance.randint(2, 5)):
            step = chance.choice(["undo", "redo"])
            done = min(max(0, done + (1 if step == "redo" else -1)), N_STROKES)
            ask(window, step)
            live(chance.choice([0.0, 0.0, chance.uniform(0.0, 0.06)]))
        settled(window)
        assert (len(document.strokes), len(document.undone_strokes)) == (done, N_STROKES - done)
        if not window.stage.paint_thread.wet:  # on which water goes on running
            np.testing.assert_array_equal(colours(window), seen[done])
        wait_for_buttons(window, done > 0, done < N_STROKES)


def test_a_redo_right_after_an_undo_saves_the_stroke_from_the_next_one(painted) -> None:
    window, _ = painted
    ask(window, "undo")
    ask(window, "redo")
    drag(window.canvas, (0.45, 0.3), (0.55, 0.3), n=5)
    settled(window)
    assert len(window.document.strokes) == N_STROKES + 1


def test_an_undo_right_after_the_first_stroke_is_heard(window) -> None:
    assert window.opening.open_path("plane", 2.5, "xuan", asked=True)
    window.canvas.setFocus()
    settled(window)
    with no_frames(window):
        drag(window.canvas, (0.42, 0.5), (0.58, 0.5), n=6)
        ask(window, "undo")
    settled(window)
    assert (len(window.document.strokes), len(window.document.undone_strokes)) == (0, 1)


def test_taps_of_fingers_are_heard_as_quickly(painted) -> None:
    window, _ = painted
    two, three = places(window, (0.42, 0.5), (0.58, 0.5)), [(0.42, 0.5), (0.58, 0.5), (0.5, 0.6)]
    with no_frames(window):
        tap(window.canvas, *two)
        tap(window.canvas, *places(window, *three))
    settled(window)
    assert len(window.document.strokes) == N_STROKES


def test_with_nothing_open_they_do_nothing(program) -> None:
    from paint3d.app.window.studio import StudioWindow

    window = StudioWindow(program)
    window.show()
    window.activateWindow()
    wait_for(window.isActiveWindow)
    with faults() as found:
        ask(window, "undo")
        ask(window, "redo")
        window.steering.asked.emit("undo")
        live()
    assert not found
    window.close()

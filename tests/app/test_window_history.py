"""The history of a painting that was saved and opened again, in the real window."""

from __future__ import annotations

import dataclasses
import itertools
import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.app.window.studio import StudioWindow
from paint3d.files.project.session import load_session, save_session
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    drag,
    live,
    mouse,
    pen_stroke,
    type_key,
    wait_for,
)
from tests.support.app.windows import SMALL, close_unasked, pretend_saved

ROWS = (0.42, 0.47, 0.52, 0.57)


@pytest.fixture(scope="module")
def window(program):
    window = StudioWindow(program)
    window.resize(*SMALL)
    window.show()
    window.workspace.quiet = True
    yield window
    close_unasked(window)


@pytest.fixture(scope="module")
def painting(window, tmp_path_factory):
    """A painting of four strokes with a dip, drying and a layer between, saved; and its states."""
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    wait_for(lambda: window.stage.is_lit)
    for k, row in enumerate(ROWS):
        if k == 1:
            choose(window, "swap_inks")
        if k == 2:
            choose(window, "dry")
            choose(window, "add_layer")
        pen_stroke(window.canvas, (0.42, row), (0.55, row), [0.1, *[0.5] * 8, 0.0])
        settled(window)
    states = []
    for upto in range(len(ROWS) + 1):  # undo itself is held to the bit elsewhere
        window.workspace.post("replay_history", upto)
        settled(window)
        states.append(state(window))
    path = tmp_path_factory.mktemp("painting") / "painting.p3d"
    with window.stage.paint_thread.paused() as document:
        document.save(path)
    return path, states


@pytest.fixture
def painted(window, painting, tmp_path):
    """The same in a file of its own."""
    pretend_saved(window.stage.paint_thread)
    return Path(shutil.copy(painting[0], tmp_path)), painting[1]


def settled(window) -> None:
    """Wait until everything asked for is painted and seen."""
    window.stage.paint_thread.post(lambda document: None).result(300)
    wait_for(lambda: window.stage.paint_thread.is_still)
    live(0.05)


def choose(window, name) -> None:
    wait_for(window.workspace.actions[name].isEnabled)
    window.workspace.actions[name].trigger()
    settled(window)


def press(window, *keys) -> None:
    """Press keys, as a hand does."""
    window.canvas.setFocus()
    type_key(window.canvas, *keys)
    settled(window)


def state(window):
    """How many strokes there are, and the colour of every vertex."""
    with window.stage.paint_thread.paused() as document:
        return len(document.strokes), document.surface.srgb.copy()


def looks(window, then) -> None:
    """The painting is as it was then; vertices that came since are left out."""
    n, codes = state(window)
    assert n == then[0]
    np.testing.assert_array_equal(codes[: len(then[1])], then[1])


def click(window, row) -> None:
    """Click a row of the history with the mouse."""
    shown = window.panels.history.list
    window.panels.docks["history"].raise_()
    live(0.05)
    place = shown.visualItemRect(shown.item(row)).center()
    QtTest.QTest.mouseClick(shown.viewport(), QtCore.Qt.MouseButton.LeftButton, pos=place)
    settled(window)


CTRL, SHIFT = QtCore.Qt.KeyboardModifier.ControlModifier, QtCore.Qt.KeyboardModifier.ShiftModifier
Z = QtCore.Qt.Key.Key_Z


def test_a_painting_that_was_opened_is_undone_and_done_again(window, painted):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    looks(window, states[-1])
    assert window.panels.history.list.count() == len(ROWS)
    wait_for(window.workspace.actions["undo"].isEnabled)
    for _ in range(6):  # four strokes, drying, a layer
        press(window, Z, CTRL)
    looks(window, states[0])
    wait_for(lambda: not window.workspace.actions["undo"].isEnabled())
    assert window.panels.history.list.count() == len(ROWS)  # fainter, and not forgotten
    for _ in range(6):
        press(window, Z, CTRL | SHIFT)
    looks(window, states[-1])


def test_a_click_shows_the_painting_as_it_was_after_a_stroke(window, painted):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    for upto in (3, 1, 4, 1):
        click(window, upto - 1)
        looks(window, states[upto])
        assert window.panels.history.list.currentRow() == upto - 1
        assert window.panels.history.slider.value() == upto
    with window.stage.paint_thread.paused() as document:
        document.save()
    assert window.opening.open_path(str(path), asked=True)  # undone when it was saved
    settled(window)
    looks(window, states[1])
    assert window.panels.history.list.count() == len(ROWS)
    click(window, 3)
    looks(window, states[4])


@pytest.mark.parametrize("speed", [16.0, None])
def test_replay_plays_all_strokes(window, painted, monkeypatch, speed):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    panel, seen = window.panels.history, []
    show = panel.show_strokes

    def see(strokes, *others) -> None:
        seen.append(len(strokes))
        show(strokes, *others)

    monkeypatch.setattr(panel, "show_strokes", see)
    panel.pace.setCurrentIndex(panel.pace.findData(speed))
    QtTest.QTest.mouseClick(panel.play, QtCore.Qt.MouseButton.LeftButton)
    wait_for(lambda: not panel.is_playing)
    settled(window)  # the last may be asked for and not yet there
    assert [n for n, _ in itertools.groupby(seen)][-5:] == [0, 1, 2, 3, 4]
    looks(window, states[-1])


@pytest.mark.parametrize(
    "samples", [8, pytest.param(80, marks=pytest.mark.long)]
)  # done before the next is shown, or not
def test_painting_while_strokes_are_replayed_loses_none(window, painted, samples):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    panel = window.panels.history
    panel.pace.setCurrentIndex(panel.pace.findData(0.25))
    shown: list[int] = []
    panel.asked.connect(lambda upto, playing: shown.append(upto))
    QtTest.QTest.mouseClick(panel.play, QtCore.Qt.MouseButton.LeftButton)
    wait_for(lambda: shown and shown[-1] >= 1)
    pen_stroke(window.canvas, (0.42, 0.62), (0.55, 0.62), [0.1, *[0.5] * samples, 0.0])
    settled(window)
    assert not panel.is_playing
    assert "replay was stopped" in window.status.told.text()
    assert len(window.document.strokes) == 5
    assert len(window.document.strokes[-1].samples) > samples
    press(window, Z, CTRL)
    looks(window, states[-1])


def test_strokes_of_an_older_file_are_painted_again_to_go_back(window, painted):
    path, states = painted
    session = load_session(path)
    save_session(dataclasses.replace(session, undone=(), history=None), path)
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    click(window, 0)
    looks(window, states[1])
    assert "repainted" in window.status.told.text()
    click(window, 3)
    looks(window, states[4])
    assert window.opening.open_path(str(path), asked=True)
    wait_for(window.workspace.actions["undo"].isEnabled)
    press(window, Z, CTRL)
    assert len(window.document.strokes) == 3


def test_damaged_steps_are_dropped_and_it_is_said(window, painted):
    path, states = painted
    session = load_session(path)
    history = {**session.history, "done": ["stroke"]}
    save_session(dataclasses.replace(session, history=history), path)
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    looks(window, states[-1])
    assert "undo steps cannot be used" in window.status.told.text()


def test_a_replay_of_nothing_says_so(window):
    pretend_saved(window.stage.paint_thread)
    assert window.opening.open_path("plane", 1.5, "xuan", asked=True)
    settled(window)
    QtTest.QTest.mouseClick(window.panels.history.play, QtCore.Qt.MouseButton.LeftButton)
    assert "no stroke" in window.status.told.text()


def test_a_painting_brought_back_after_a_crash_has_its_history(window, painted, tmp_path):
    path, states = painted
    assert window.opening.open_path(str(path), asked=True)
    settled(window)
    press(window, Z, CTRL)
    press(window, Z, CTRL)
    sitting = RecoveryFolder(window.document, tmp_path / "left")  # a base, as a crash leaves it
    sitting.note({"do": "redo"})
    sitting.close(keep=True)
    (left,) = recoverable(tmp_path / "left")
    assert window.recovery.recover(left)
    settled(window)
    looks(window, states[3])
    press(window, Z, CTRL | SHIFT)
    looks(window, states[4])
    click(window, 0)
    looks(window, states[1])


def test_the_title_marks_only_what_is_otherwise_than_it_was_saved(window, painted):
    """Undo and redo that lead back to it leave nothing to be saved, nor to be asked about."""
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    assert not window.isWindowModified()
    strokes = len(window.document.strokes)
    pen_stroke(window.canvas, (0.42, 0.62), (0.55, 0.62), [0.1, *[0.5] * 8, 0.0])
    settled(window)
    assert window.isWindowModified()
    press(window, Z, CTRL)
    assert len(window.document.strokes) == strokes
    assert not window.isWindowModified()
    press(window, Z, CTRL)
    assert window.isWindowModified()
    pen_stroke(window.canvas, (0.42, 0.62), (0.55, 0.62), [0.1, *[0.5] * 8, 0.0])
    settled(window)
    assert len(window.document.strokes) == strokes
    assert window.isWindowModified()  # as many, and another one
    press(window, Z, CTRL)
    assert window.isWindowModified()


def test_what_was_only_looked_at_in_the_history_is_as_saved(window, painted):
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    for row in (1, 0, len(ROWS) - 1):
        click(window, row)
    assert not window.isWindowModified()


def test_a_stroke_that_is_cancelled_leaves_the_painting_as_saved(window, painted):
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    paint_thread = window.stage.paint_thread
    drag(window.canvas, (0.42, 0.62), (0.55, 0.62), release=False)
    wait_for(lambda: window.isWindowModified())
    window.workspace.actions["cancel_stroke"].trigger()
    paint_thread.post(lambda document: None).result(300)
    wait_for(lambda: not window.isWindowModified())
    x, y = 0.55 * window.canvas.width(), 0.62 * window.canvas.height()
    mouse(window.canvas, KIND.MouseButtonRelease, x, y, BUTTON.LeftButton)
    settled(window)
    assert not window.isWindowModified()


def test_what_no_undo_takes_back_stays_unsaved(window, painted):
    path, _ = painted
    assert window.opening.open_path(str(path), asked=True)
    choose(window, "hide_layer")
    choose(window, "undo")
    choose(window, "redo")
    assert window.isWindowModified()
    choose(window, "hide_layer")


def test_older_strokes_painted_again_lead_to_what_was_saved(window, painted):
    """As in `test_strokes_of_an_older_file_are_painted_again_to_go_back`."""
    path, _ = painted
    session = load_session(path)
    save_session(dataclasses.replace(session, history=None), path)
    assert window.opening.open_path(str(path), asked=True)
    n = len(window.document.strokes)
    window.recalling.go_to(0)
    settled(window)
    assert window.isWindowModified()
    window.recalling.go_to(n)
    settled(window)
    assert not window.isWindowModified()

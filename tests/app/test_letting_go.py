"""A painting is let go of while strokes wait and a step goes on: the window lives meanwhile."""

from __future__ import annotations

import threading

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtWidgets

from tests.support.app.gestures import answer, answer_bar, drag, live, wait_for
from tests.support.app.windows import opened, settled

LONGEST_S = 300.0  # that a step goes on which nobody ends
N_WAITING = 6
TICKS = 20


@pytest.fixture
def window(program):
    with opened(program, material="porcelain") as window:
        yield window


@pytest.fixture
def gate():
    """Ends a step of the painting."""
    gate = threading.Event()
    yield gate
    gate.set()


def be_behind(window, gate: threading.Event) -> None:
    """Paint strokes that wait for a step that lasts."""
    settled(window)
    window.stage.paint_thread.post(lambda document: gate.wait(LONGEST_S))
    for k in range(N_WAITING):
        y = 0.4 + 0.03 * k
        drag(window.canvas, (0.45, y), (0.55, y), n=6)
    assert not window.document.strokes


def cancel(bar: QtWidgets.QProgressDialog) -> None:
    bar.findChild(QtWidgets.QPushButton).click()


def cancelling_the_wait() -> QtCore.QTimer:
    """Press *Cancel* in the bar of the step that is waited for; one of reading may come before."""

    def look() -> None:
        for bar in QtWidgets.QApplication.topLevelWidgets():
            is_bar = isinstance(bar, QtWidgets.QProgressDialog) and bar.isVisible()
            if is_bar and "current step" in bar.labelText():
                cancel(bar)

    timer = QtCore.QTimer()
    timer.timeout.connect(look)
    timer.start(20)
    return timer


def discard(box: QtWidgets.QMessageBox) -> None:
    next(b for b in box.buttons() if b.text() == "Do not save").click()


def test_the_window_lives_while_a_step_of_the_old_painting_goes_on(window, gate) -> None:
    be_behind(window, gate)
    before, ticked = window.document, []

    def tick() -> None:  # also the window's own ticks come then
        ticked.append(window.document is before)
        if len(ticked) > TICKS:
            gate.set()

    timer = QtCore.QTimer(window)
    timer.timeout.connect(tick)
    answer_bar(lambda bar: timer.start(10))
    assert window.opening.open_path("sphere", 8.0, asked=True)
    timer.stop()
    assert len(ticked) > TICKS
    assert all(ticked)
    assert gate.is_set()  # it was not left to itself
    assert window.document.surface.source.name == "sphere"
    assert not before.strokes  # what waited was not wanted any more
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    settled(window)
    assert len(window.document.strokes) == 1


def test_cancel_goes_on_with_the_old_painting_and_all_that_waits(window, gate) -> None:
    be_behind(window, gate)
    before = window.document
    timer = cancelling_the_wait()
    assert not window.opening.open_path("sphere", 8.0, asked=True)
    timer.stop()
    assert not gate.is_set()
    assert window.document is before
    assert "Stopped" in window.status.told.text()
    gate.set()
    settled(window)
    assert len(window.document.strokes) == N_WAITING
    painted = window.document.surface.painted.sum()
    for _ in range(N_WAITING):
        window.workspace.actions["undo"].trigger()
        settled(window)
    assert not window.document.strokes
    assert window.document.surface.painted.sum() < painted
    drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
    settled(window)
    assert len(window.document.strokes) == 1


def test_what_waits_is_in_the_file_that_is_saved_first(window, gate, tmp_path) -> None:
    """Asked what becomes of it, the hand says: save."""
    be_behind(window, gate)
    file = tmp_path / "mine.p3d"
    with window.stage.paint_thread.paused(0.0) as document:
        assert document is None
    window.document.path = file
    answer_bar(lambda bar: gate.set())
    answer(lambda box: box.defaultButton().click(), QtWidgets.QMessageBox)
    assert window.opening.open_path("sphere", 8.0)
    assert window.document.surface.source.name == "sphere"
    assert window.opening.open_path(str(file), asked=True)
    assert len(window.document.strokes) == N_WAITING


def test_the_window_closes_with_a_bar_too_and_stays_where_it_is_stopped(window, gate) -> None:
    be_behind(window, gate)

    def stay(box: QtWidgets.QMessageBox) -> None:
        answer_bar(cancel)
        discard(box)

    answer(stay, QtWidgets.QMessageBox)
    assert not window.close()
    assert window.isVisible()
    assert not gate.is_set()
    gate.set()
    settled(window)
    assert len(window.document.strokes) == N_WAITING
    live(0.1)
    wait_for(window.workspace.actions["undo"].isEnabled)

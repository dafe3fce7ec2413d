"""A recording that is replayed in the window: how far it is, and how it is stopped."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.persistence.recovery_folder import recoverable
from paint3d.device.recorded import Recording
from paint3d.errors import Paint3DError
from paint3d.recording.recording import save_recording
from tests.support.app.gestures import BUTTON, answer, drag, live, take_file, wait_for
from tests.support.app.hands import pad_stroke
from tests.support.app.windows import opened, settled

TIMES = 300  # to and fro
REST_NS = 600_000_000_000
CHUNKS = 3 * 64  # samples that may be painted after a replay was stopped


@pytest.fixture
def window(program):
    with opened(program, "plane", 2.0, "porcelain") as window:
        window.panels.history.pace.setCurrentText("max")
        yield window


def long_file(window, folder: Path, rest_ns: int = 0, times: int = TIMES) -> Path:
    """A line that goes to and fro, and rests in the middle of it."""
    drag(window.canvas, (0.42, 0.5), (0.58, 0.5), n=20)
    settled(window)
    line = window.document.strokes[0].samples
    window.workspace.actions["undo"].trigger()
    settled(window)
    samples, at_ns = [], 0
    for k in range(times):
        for sample in line if k % 2 == 0 else line[::-1]:
            at_ns += 8_000_000 + (rest_ns if len(samples) == times * len(line) // 2 else 0)
            samples.append(replace(sample, time_ns=at_ns))
    file = folder / "long.jsonl"
    save_recording(joined(samples), file)
    return file


def joined(samples) -> Recording:
    return Recording(
        [s.time_ns for s in samples],
        [s.position for s in samples],
        [s.orientation for s in samples],
        [s.pressure for s in samples],
        contact=[s.contact for s in samples],
    )


def replay(window, file: Path, times: int = TIMES) -> int:
    """By the menu; how many samples there are."""
    answer(take_file(file))
    window.workspace.actions["replay"].trigger()
    assert window.player.is_playing
    return times * 20


def by_button(window) -> None:
    QtTest.QTest.mouseClick(window.replay_bar.button, BUTTON.LeftButton)


def press(window, key: QtCore.Qt.Key, *held: QtCore.Qt.KeyboardModifier) -> None:
    window.activateWindow()  # a dialog had the keys until now
    assert QtTest.QTest.qWaitForWindowActive(window, 60_000)
    window.canvas.setFocus()
    QtTest.QTest.keyClick(window.canvas, key, *held)


def by_key(window) -> None:
    press(window, QtCore.Qt.Key.Key_Escape)


def test_it_is_ready_when_all_is_painted_and_a_bar_says_how_far_it_is(window, tmp_path) -> None:
    file = long_file(window, tmp_path, times=TIMES // 6)  # all of it is waited for
    shares: list[int] = []
    paint_thread = window.stage.paint_thread
    for k in range(5):  # what was painted before does not count
        drag(window.canvas, (0.42, 0.4 + 0.01 * k), (0.58, 0.4 + 0.01 * k), n=40)
    settled(window)
    before, n = paint_thread.n_painted, replay(window, file, TIMES // 6)
    with paint_thread.paused():  # wherever it is
        window.player.tick()
        shares.append(window.replay_bar.bar.value())
        of_all = 1000 * (paint_thread.n_painted - before) / n
        assert of_all - 20 < shares[0] <= of_all + 1
    while window.player.is_playing:
        assert window.replay_bar.bar.value() <= 1000 * (paint_thread.n_painted - before) / n + 1
        assert "Ready" not in window.status.told.text()
        assert window.replay_bar.isVisible()
        shares.append(window.replay_bar.bar.value())
        live(0.0)
    assert len(window.document.strokes) == 6
    assert not window.document.in_stroke
    assert "Ready" in window.status.told.text()
    assert not window.replay_bar.isVisible()
    assert shares == sorted(shares)


@pytest.mark.parametrize("stop", [by_button, pytest.param(by_key, marks=pytest.mark.long)])
def test_it_is_stopped_at_once_and_undone_as_a_whole(window, tmp_path, stop) -> None:
    file = long_file(window, tmp_path)
    paint_thread = window.stage.paint_thread
    before, n = paint_thread.n_painted, replay(window, file)
    wait_for(lambda: paint_thread.n_painted > before + 200)
    stop(window)
    at = paint_thread.n_painted
    assert not window.player.is_playing
    assert not window.replay_bar.isVisible()
    assert "stopped" in window.status.told.text()
    settled(window)
    assert paint_thread.n_painted <= at + CHUNKS
    (stroke,) = window.document.strokes
    assert len(stroke.samples) == paint_thread.n_painted - before < n
    assert window.document.surface.painted.any()
    window.workspace.actions["undo"].trigger()
    settled(window)
    assert not window.document.strokes
    assert not window.document.surface.painted.any()
    drag(window.canvas, (0.45, 0.4), (0.55, 0.4), n=6)
    settled(window)
    assert len(window.document.strokes) == 1


def test_undo_stops_it_and_takes_all_of_it_back(window, tmp_path) -> None:
    file = long_file(window, tmp_path)
    replay(window, file)
    wait_for(lambda: window.document.surface.painted.any())
    press(window, QtCore.Qt.Key.Key_Z, QtCore.Qt.KeyboardModifier.ControlModifier)
    settled(window)
    assert not window.player.is_playing
    assert not window.document.strokes
    assert not window.document.surface.painted.any()
    assert "undone" in window.status.told.text()


def test_the_rest_of_a_wet_recording_is_not_waited_for(window, tmp_path) -> None:
    """Ten minutes that pass for the ink are 12,000 pieces of time."""
    file = long_file(window, tmp_path, REST_NS, times=60)
    window.workspace.actions["wet"].trigger()
    replay(window, file, 60)
    paint_thread = window.stage.paint_thread
    wait_for(lambda: paint_thread.queue_length > 1000)
    by_key(window)
    assert paint_thread.queue_length < 10
    settled(window)
    window.workspace.actions["wet"].trigger()
    window.workspace.actions["undo"].trigger()
    settled(window)
    assert not window.document.strokes


def test_what_was_not_painted_does_not_come_back_after_a_crash(window, tmp_path) -> None:
    file = long_file(window, tmp_path)
    replay(window, file)
    paint_thread = window.stage.paint_thread
    wait_for(lambda: window.document.surface.painted.any())
    by_key(window)
    settled(window)
    (stroke,) = window.document.strokes
    paint_thread.stop(keep=True)
    back = recoverable()[0].recover().document
    assert [len(s.samples) for s in back.strokes] == [len(stroke.samples)]
    recoverable()[0].discard()


@pytest.mark.parametrize("beside", [False, True])
def test_a_pads_recording_is_laid_where_the_picture_is_looked_at(
    program, tmp_path, beside: bool
) -> None:
    """It was painted as if it knew where the object is: in the middle of the ball, say."""
    line = np.linspace((100.0, 50.0), (130.0, 50.0), 40)  # anywhere on the pad
    file = tmp_path / "pad.jsonl"
    save_recording(pad_stroke(line, 0.3, np.radians(60.0)), file)
    with opened(program, "sphere", 1.0, "porcelain") as window:
        window.workspace.actions["look_left"].trigger()
        for _ in range(20 * beside):
            window.workspace.actions["pan_left"].trigger()
        assert window.recordings.replay_file(str(file))
        wait_for(lambda: not window.player.is_playing)
        (stroke,) = window.document.strokes
        places = np.array([sample.contact for sample in stroke.samples])
        assert np.linalg.norm(np.diff(places, axis=0), axis=1).sum() == pytest.approx(30.0, rel=0.1)
        points = window.document.surface.source.vertices
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        side = (places.mean(axis=0) - middle) / np.linalg.norm(places.mean(axis=0) - middle)
        towards = (0.0, -1.0, 0.0) if beside else (-1.0, 0.0, 0.0)  # its front, or what is seen
        assert side @ towards > 0.95
        assert window.document.surface.painted.any()
        assert "Ready" in window.status.told.text()


def test_a_pads_recording_that_does_not_fit_is_refused_in_words(window, tmp_path) -> None:
    file = tmp_path / "pad.jsonl"
    save_recording(pad_stroke([(0.0, 0.0), (4000.0, 0.0)], 0.3, 1.0), file)
    assert not window.recordings.replay_file(str(file))
    assert isinstance(window.workspace.error, Paint3DError)
    assert not window.document.strokes


def test_a_stroke_by_hand_that_waits_behind_it_is_kept(window, tmp_path) -> None:
    """All is handed on and the rest waits: what is stopped is the replay alone."""
    file, paint_thread = long_file(window, tmp_path, times=100), window.stage.paint_thread
    with paint_thread.paused() as document:
        assert document is not None
        replay(window, file)
        waiting = -1
        while paint_thread.queue_length > waiting:  # until no more of it is handed on
            waiting = paint_thread.queue_length
            live(0.1)
        drag(window.canvas, (0.45, 0.4), (0.55, 0.4), n=6)
        by_button(window)
    settled(window)
    (own,) = window.document.strokes  # nothing of the recording had been painted
    assert 100 * 20 > len(own.samples) >= 6

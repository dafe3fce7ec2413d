"""What the line of status says, how long it says so, and that the panels say the same."""

from __future__ import annotations

from dataclasses import replace

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore

from tests.support.app.gestures import drag, live, type_key, wait_for
from tests.support.app.windows import opened, settled

HINT = "Paint with the left button"


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 2.0, "porcelain", drawn=False) as window:
        yield window


def stroke(window) -> None:
    drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
    settled(window)


def test_what_was_saved_is_said_until_the_next_stroke(window, tmp_path) -> None:
    stroke(window)
    assert window.saving.save_to(tmp_path / "mine.p3d")
    settled(window)
    live(0.2)
    assert "mine.p3d" in window.status.message_label.text()
    stroke(window)
    assert HINT in window.status.message_label.text()


def test_what_goes_on_is_said_beside_the_strokes(window) -> None:
    window.workspace.tell("No room to keep what is painted", state="bad", stays=True)
    stroke(window)
    assert "No room" in window.status.message_label.text()
    window.workspace.tell("")


def test_what_has_no_room_ends_in_an_ellipsis(window) -> None:
    label = window.status.message_label
    window.workspace.tell("永 " * 400)
    assert label.shown.endswith("…")
    assert label.toolTip() == "永 " * 400
    window.workspace.tell("永")
    assert label.shown == "永"


class Laid(QtCore.QObject):
    """Counts how often a window is laid out."""

    times = 0

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        self.times += event.type() == QtCore.QEvent.Type.LayoutRequest
        return False


def test_what_is_said_again_does_not_lay_out_the_window(window) -> None:
    """It is said where each stroke begins, before the first of it is painted."""
    laid = Laid()
    for state in ("off", "bad"):
        window.workspace.tell("the same", state=state)
        live(0.1)
        window.installEventFilter(laid)
        before = laid.times
        for _ in range(3):
            window.workspace.tell("the same", state=state)
            live(0.02)
        window.removeEventFilter(laid)
        assert laid.times == before
    window.installEventFilter(laid)
    window.workspace.tell("")
    live(0.02)
    window.removeEventFilter(laid)
    assert laid.times > before


def test_that_strokes_are_recorded_is_said_until_they_are_not(window, monkeypatch) -> None:
    monkeypatch.setattr(window.recordings, "do_save_recording", lambda first=0: None)
    type_key(window.canvas, QtCore.Qt.Key.Key_R, QtCore.Qt.KeyboardModifier.ControlModifier)
    assert window.workspace.actions["record"].isChecked()
    said = window.status.message_label.text()
    assert HINT not in said
    stroke(window)
    assert window.status.message_label.text() == said
    type_key(window.canvas, QtCore.Qt.Key.Key_R, QtCore.Qt.KeyboardModifier.ControlModifier)
    assert HINT in window.status.message_label.text()


@pytest.mark.parametrize(
    ("lag_s", "queue", "said"),
    [
        (0.7, 3, "is catching up with your strokes, 0.7 s"),
        (0.7, 0, "has caught up"),
        (0.3, 3, "keeps up, 300.0 ms"),
        (0.02, 0, "keeps up, 20.0 ms"),
    ],
)
def test_the_devices_say_of_the_painting_what_the_status_line_says(
    window, monkeypatch, lag_s, queue, said
) -> None:
    frame = replace(window.stage.frame, lag_s=lag_s, queue_length=queue)
    monkeypatch.setattr(window.stage, "follow", lambda: frame)
    monkeypatch.setattr(window.stage, "frame", frame)
    window.panels.docks["devices"].raise_()
    wait_for(lambda: said in window.status.state.text())
    wait_for(lambda: f"Painting: {said}" in window.panels.devices.lines.text())
    assert "late" not in window.panels.devices.lines.text()

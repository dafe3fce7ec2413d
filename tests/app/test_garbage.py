"""What a window leaves behind dies in the window's thread, whoever makes garbage meanwhile."""

from __future__ import annotations

import threading
import weakref

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtWidgets

from paint3d.app.window import studio
from tests.support.app.gestures import wait_for
from tests.support.app.windows import opened


class _Window(QtWidgets.QWidget):
    """Of a class of our own: Qt's own ones are handed back to their thread."""


def test_closed_windows_die_in_their_own_thread(program) -> None:
    died: list[threading.Thread] = []
    for _ in range(40):
        widget = _Window()
        widget.itself = widget
        widget.destroyed.connect(
            lambda: died.append(threading.current_thread()),
            QtCore.Qt.ConnectionType.DirectConnection,
        )
        del widget

    def litter() -> None:
        for _ in range(300_000):
            cycle: list[object] = []
            cycle.append(cycle)

    beside = threading.Thread(target=litter)
    beside.start()
    beside.join()
    wait_for(lambda: len(died) == 40)
    assert set(died) == {threading.main_thread()}


def test_a_painting_that_was_let_go_of_goes_with_its_memory(
    program, monkeypatch: pytest.MonkeyPatch
) -> None:
    given_back: list[threading.Thread] = []
    monkeypatch.setattr(studio, "_LATER_MS", 200)
    monkeypatch.setattr(
        studio, "give_back_memory", lambda: given_back.append(threading.current_thread())
    )
    with opened(program, "plane", 4.0) as window:
        left = weakref.ref(window.document)
        wait_for(lambda: given_back)  # of what was there before
        assert window.opening.open_path("sphere", 8.0, "porcelain", asked=True)
        wait_for(lambda: left() is None and len(given_back) > 1)
    assert threading.main_thread() not in given_back  # the window does not wait for it

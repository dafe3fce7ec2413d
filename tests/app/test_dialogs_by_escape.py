"""Escape closes every dialog, whichever part of it has the keys, and leaves all as it was."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.window.files.exporting import ExportDialog
from paint3d.app.window.playing.pictures import FilmDialog, FilmOptions
from tests.support.app.gestures import answer, drag, live, wait_for
from tests.support.app.windows import faults, opened, settled
from tests.support.examples import ALL

KEY = QtCore.Qt.Key
SIZE = (640, 480)


@pytest.fixture(scope="module")
def window(program, nothing_planned_ahead):
    with opened(program, "plane", 4.0, "porcelain", drawn=False) as window:
        drag(window.canvas, (0.45, 0.5), (0.55, 0.5), n=6)
        settled(window)
        yield window


def correct(window) -> None:
    """Correct the strokes found in a picture of writing."""
    pytest.importorskip("skimage", reason="scikit-image is not installed")
    button = window.panels.copybook.correct_button
    if not button.isEnabled():
        pixels = np.full((300, 300, 3), 235, np.uint8)
        pixels[60:84, 50:250] = pixels[200:224, 50:250] = 20
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "two.png"
            Image.fromarray(pixels).save(file)
            assert window.copying.layout_file(str(file), 30.0)
    button.click()


def by_action(name: str) -> Callable[..., object]:
    return lambda window: window.workspace.actions[name].trigger()


def by_edit(what: str) -> Callable[..., object]:
    return lambda window: window.editing.ask(what, 0)


def export(suffix: str) -> Callable[..., object]:
    return lambda window: ExportDialog(window, suffix, {}, SIZE).exec()


MODAL: dict[str, Callable[..., object]] = {
    **{
        name: by_action(name)
        for name in (
            "new", "open", "save_as", "export", "screenshot", "turntable", "growth", "replay",
            "save_recording", "preferences", "test_pen", "stand", "seal", "open_brush",
            "open_pigments", "shortcuts", "about", "choose_light",
        )
    },
    "correct": correct,
    "move": by_edit("move"),
    "time": by_edit("time"),
    **{f"export {suffix}": export(suffix) for suffix in (".glb", ".html", ".png", ".3mf")},
    "film": lambda window: FilmDialog(
        window, FilmOptions(), SIZE, any_length=False, title="A"
    ).exec(),
}  # fmt: skip


def parts(dialog: QtWidgets.QDialog) -> list[QtWidgets.QWidget]:
    """One widget of each kind that can have the keys."""
    found = {
        (type(part), isinstance(part.parent(), QtWidgets.QColorDialog)): part
        for part in dialog.findChildren(QtWidgets.QWidget)
        if part.isVisible()
        and part.isEnabled()
        and part.focusPolicy() & QtCore.Qt.FocusPolicy.TabFocus
        and not (isinstance(part, QtWidgets.QAbstractButton) and part.isDown())  # Escape lets go
    }
    return list(found.values())


def escape(dialog: QtWidgets.QDialog, k: int) -> int:
    """Press Escape while its k-th part has the keys; how many there are."""
    dialog.activateWindow()
    wait_for(dialog.isActiveWindow)
    there = parts(dialog)
    if there:
        there[min(k, len(there) - 1)].setFocus()
    QtTest.QTest.keyClick(QtWidgets.QApplication.focusWidget() or dialog, KEY.Key_Escape)
    assert not dialog.isVisible()
    return len(there)


def after(k: int, n: int) -> int:
    """Which of n parts has the keys next: the last after the first, each in turn with --long."""
    return k + 1 if ALL else max(k + 1, n - 1)


def state(window) -> tuple:
    document, hand = window.document, window.hand
    kept = replace(window.workspace.settings, window={})
    return kept, document.painter.dipped, len(document.strokes), hand.camera, document.modified


@pytest.mark.parametrize("name", MODAL)
def test_escape_closes_a_dialog_and_leaves_all_as_it_was(window, name: str) -> None:
    before, n, k = state(window), [1], 0
    with faults() as found:
        while k < n[0]:
            answer(lambda dialog, k=k: n.__setitem__(0, escape(dialog, k)))
            MODAL[name](window)
            k = after(k, n[0])
    assert not found
    assert state(window) == before
    assert QtWidgets.QApplication.activeModalWidget() is None


@pytest.mark.parametrize("name", ["choose_colour", "edit_brush"])
def test_escape_closes_a_dialog_beside_the_painting(window, name: str) -> None:
    before, n, k = state(window), 1, 0
    with faults() as found:
        while k < n:
            window.workspace.actions[name].trigger()
            dialog = next(
                widget
                for widget in QtWidgets.QApplication.topLevelWidgets()
                if isinstance(widget, QtWidgets.QDialog) and widget.isVisible()
            )
            n = escape(dialog, k)
            k = after(k, n)
            live(0.05)
    assert not found
    assert state(window) == before

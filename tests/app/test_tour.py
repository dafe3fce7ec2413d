"""The first ten minutes: ways to begin, a sample painting, a tour that ends with a stroke of 永."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.persistence.settings import load_settings
from paint3d.app.window.studio import StudioWindow
from tests.support.app.gestures import BUTTON, drag, live, pen_stroke, type_key, wait_for
from tests.support.app.windows import SMALL, close_unasked, pretend_saved, settled

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier


@pytest.fixture(scope="module")
def window(program):
    """A window with nothing open."""
    window = StudioWindow(program)
    window.resize(*SMALL)
    window.show()
    window.workspace.quiet = True
    window.saving.may_leave = lambda: True
    window.activateWindow()
    yield window
    close_unasked(window)


def press(window, text: str) -> None:
    wait_for(window.begin_page.isVisible)
    button = next(b for b in window.begin_page.buttons if b.text() == text)
    QtTest.QTest.mouseClick(button, BUTTON.LeftButton)


def reached(window, step: int) -> None:
    wait_for(lambda: window.tour.step == step)
    assert window.tour.isVisible()
    assert window.tour.counted.text() == f"{step + 1} / 5"


def test_the_tour_follows_the_hand_and_ends_with_the_first_stroke_of_yong(window) -> None:
    press(window, "A short tour")
    reached(window, 0)
    canvas = window.canvas
    canvas.setFocus()
    drag(canvas, (0.4, 0.45), (0.6, 0.45), n=10)
    reached(window, 1)
    drag(canvas, (0.03, 0.2), (0.12, 0.25), n=6)  # beside the sheet
    reached(window, 2)
    window.panels.inks.dishes.taken.emit("cinnabar")
    reached(window, 3)
    type_key(canvas, KEY.Key_Z, HELD.ControlModifier)
    reached(window, 4)
    settled(window)
    assert [text.text for text in window.document.texts] == ["永"]
    (ghost,) = window.panels.copybook.copybook.ghosts
    dot = window.hand.pixels_of(ghost.medians[0]) / [canvas.width(), canvas.height()]
    pen_stroke(canvas, tuple(dot[0]), tuple(dot[-1]), list(np.linspace(0.3, 0.6, 14)))
    wait_for(lambda: window.tour.step is None)
    assert not window.tour.isVisible()
    assert window.document.strokes[-1].tags["character"] == "永"
    pretend_saved(window.stage.paint_thread)


def test_it_is_gone_through_by_its_buttons_and_ended_at_any_time(window) -> None:
    window.workspace.actions["tour"].trigger()
    reached(window, 0)
    for step in (1, 2):
        QtTest.QTest.mouseClick(window.tour.next_button, BUTTON.LeftButton)
        reached(window, step)
    QtTest.QTest.mouseClick(window.tour.end_button, BUTTON.LeftButton)
    assert window.tour.step is None
    assert not window.tour.isVisible()


def test_a_sample_painting_is_opened_to_play_with(window, monkeypatch) -> None:
    from paint3d.app.window.playing import recordings

    monkeypatch.setattr(recordings, "_SAMPLE_MM", 1.5)
    window.workspace.actions["sample"].trigger()
    wait_for(lambda: window.document.strokes and not window.player.is_playing)
    settled(window)
    assert window.document.surface.painted.any()
    assert "bowl" in window.document.surface.source.name
    pretend_saved(window.stage.paint_thread)


def test_brushes_say_what_they_are_for(window) -> None:
    view = window.panels.brushes.findChild(QtWidgets.QListWidget, "brushes")
    rows = {view.item(k).text().split("  ")[0]: view.item(k) for k in range(view.count())}
    assert "8 to 25 mm" in rows["xiaokai"].text()
    assert "flying white" in rows["feibai"].toolTip()
    assert all("\n" in item.text() for item in rows.values())
    live()


def test_favourites_come_first_and_are_kept(window) -> None:
    panel = window.panels.brushes
    view = panel.findChild(QtWidgets.QListWidget, "brushes")
    names = [view.item(k).text() for k in range(view.count())]
    row = next(k for k, text in enumerate(names) if text.startswith("gongbi"))

    def choose() -> None:
        place = view.visualItemRect(view.item(row)).center()
        view.customContextMenuRequested.emit(place)
        menu = next(m for m in view.findChildren(QtWidgets.QMenu) if m.isVisible())
        menu.actions()[0].trigger()

    choose()
    assert view.item(0).text().startswith("★ gongbi")
    assert window.workspace.settings.favourite_brushes == ("gongbi",)
    assert load_settings()[0].favourite_brushes == ("gongbi",)
    assert view.count() == len(names)
    row = 0
    choose()
    assert [view.item(k).text() for k in range(view.count())] == names
    assert window.workspace.settings.favourite_brushes == ()


def test_the_right_button_leaves_the_brush_in_hand_marked(window) -> None:
    panel = window.panels.brushes
    view = panel.findChild(QtWidgets.QListWidget, "brushes")
    before, brush = view.currentRow(), panel.brush
    row = 0 if before != 0 else 1
    place = view.visualItemRect(view.item(row)).center()
    view.setCurrentRow(row)  # as its press does
    view.customContextMenuRequested.emit(place)
    *_, menu = view.findChildren(QtWidgets.QMenu, "brush_menu")
    menu.close()
    assert view.currentRow() == before
    assert panel.brush == brush


def test_brushes_lie_in_folders(window, monkeypatch: pytest.MonkeyPatch) -> None:
    panel = window.panels.brushes
    view = panel.findChild(QtWidgets.QListWidget, "brushes")
    assert not panel.folder.isVisibleTo(panel)  # there is none yet

    def choose(row: int, text: str) -> None:
        view.customContextMenuRequested.emit(view.visualItemRect(view.item(row)).center())
        *_, menu = view.findChildren(QtWidgets.QMenu, "brush_menu")
        folders = menu.findChild(QtWidgets.QMenu, "folders")
        next(action for action in folders.actions() if action.text() == text).trigger()
        menu.close()

    def listed() -> list[int]:
        return [row for row in range(view.count()) if not view.isRowHidden(row)]

    name = view.item(1).data(QtCore.Qt.ItemDataRole.UserRole)
    monkeypatch.setattr(QtWidgets.QInputDialog, "getText", lambda *_: (" Flowers ", True))
    choose(1, "New folder…")
    choose(3, "Flowers")
    assert load_settings()[0].brush_folders[name] == "Flowers"
    panel.folder.setCurrentIndex(panel.folder.findText("Flowers"))
    assert listed() == [1, 3]
    choose(3, "None")
    assert listed() == [1]
    choose(1, "None")  # an empty folder is gone, and all are listed
    assert len(listed()) == view.count()
    assert not panel.folder.isVisibleTo(panel)
    assert load_settings()[0].brush_folders == {}

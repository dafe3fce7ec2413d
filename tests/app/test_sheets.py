"""Sheets in the studio: chosen from pictures, sized, mounted, written on, saved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.persistence import settings
from paint3d.app.model.persistence.settings import Settings, load_settings
from paint3d.app.window.object.new_dialog import NewDialog
from paint3d.app.window.wording import choose_language
from paint3d.mesh.sheet_mesh import sheet_of
from paint3d.mesh.sheets import FORMS
from tests.support.app.gestures import BUTTON, answer, pen_stroke, type_key, wait_for
from tests.support.app.windows import opened, settled

CONTROL = QtCore.Qt.KeyboardModifier.ControlModifier


@pytest.fixture(scope="module")
def window(program):
    """A window with a sheet in it."""
    with opened(program, drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def unasked(window, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(window.saving, "may_leave", lambda: True)


def click_picture(pictures: QtWidgets.QListWidget, words: str) -> None:
    (item,) = pictures.findItems(words, QtCore.Qt.MatchFlag.MatchStartsWith)
    pictures.scrollToItem(item)
    middle = pictures.visualItemRect(item).center()
    QtTest.QTest.mouseClick(pictures.viewport(), BUTTON.LeftButton, pos=middle)


def type_number(box: QtWidgets.QDoubleSpinBox, number: str) -> None:
    box.setFocus()
    box.selectAll()
    QtTest.QTest.keyClicks(box, number)
    QtTest.QTest.keyClick(box, QtCore.Qt.Key.Key_Tab)


def press(dialog: NewDialog) -> None:
    ok = dialog.buttons.button(QtWidgets.QDialogButtonBox.StandardButton.Ok)
    QtTest.QTest.mouseClick(ok, BUTTON.LeftButton)


def begin(window, fill) -> None:
    """Ask for a new painting by its keys, and answer."""
    before = window.document

    def choose(dialog: NewDialog) -> None:
        fill(dialog)
        press(dialog)

    answer(choose)
    type_key(window.canvas, QtCore.Qt.Key.Key_N, CONTROL)
    wait_for(lambda: window.document is not before)
    settled(window)


def test_a_scroll_is_chosen_sized_mounted_and_painted(window, tmp_path: Path) -> None:
    def fill(dialog: NewDialog) -> None:
        click_picture(dialog.sheets, "Hanging scroll")
        assert dialog.chosen()[:2] == ("scroll", "xuan")
        type_number(dialog.width_box, "100")
        type_number(dialog.height_box, "240")
        QtTest.QTest.mouseClick(dialog.mounted, BUTTON.LeftButton, pos=QtCore.QPoint(8, 8))
        type_number(dialog.resolution, "1.5")

    begin(window, fill)
    surface = window.document.surface
    assert surface.source.name == "scroll:100x240:margin=35:mounted"
    assert surface.material.name == "xuan"
    assert "Hanging scroll" in window.windowTitle()
    assert load_settings()[0].begun_on == surface.source.name
    pen_stroke(window.canvas, (0.47, 0.5), (0.53, 0.5), [0.5] * 12)
    settled(window)
    assert len(window.document.strokes) == 1
    path = tmp_path / "scroll.p3d"
    window.document.save(path)
    assert window.opening.open_path(str(path), asked=True)
    opened = window.document.surface
    assert sheet_of(opened.source) == sheet_of(surface.source) is not None
    np.testing.assert_array_equal(opened.srgb, surface.srgb)


def test_what_there_is_to_choose_from_is_said_whole(window) -> None:
    dialog = NewDialog(window, Settings())
    for pictures in (dialog.sheets, dialog.objects):
        wide = pictures.fontMetrics().horizontalAdvance
        for row in range(pictures.count()):
            words = pictures.item(row).text().split("\n")
            assert max(map(wide, words)) + 8 <= pictures.gridSize().width(), words
    dialog.deleteLater()


def test_a_round_fan_has_one_size_and_is_of_silk(window) -> None:
    def fill(dialog: NewDialog) -> None:
        click_picture(dialog.sheets, "Round fan")
        assert not dialog.height_box.isVisible()
        type_number(dialog.width_box, "120")

    begin(window, fill)
    source = window.document.surface.source
    assert source.name == "round-fan:120:margin=20"
    assert np.ptp(source.bounds, axis=0)[:2] == pytest.approx([120.0, 120.0], rel=0.01)
    assert window.document.surface.material.name == "silk"


def test_objects_propose_what_suits_them_and_one_is_chosen_by_two_clicks(window) -> None:
    def fill(dialog: NewDialog) -> None:
        wait_for(lambda: not dialog._coming)
        click_picture(dialog.objects, "Bowl")
        assert not dialog.width_box.isVisible()
        assert dialog.sheets.currentRow() == -1
        assert dialog.material.material() == "porcelain"
        type_number(dialog.resolution, "4")

    begin(window, fill)
    assert window.document.surface.source.name == "bowl"


def test_a_material_says_whether_ink_spreads_and_an_object_how_large_it_is(
    program, monkeypatch
) -> None:
    parent = QtWidgets.QWidget()
    dialog = NewDialog(parent, Settings())
    monkeypatch.setattr(settings, "WET_AT_FIRST", {"xuan"})
    dialog.choose("fan")
    for material, words in (
        ("sized xuan", "Ink stays where it is laid; it spreads on xuan paper"),
        ("xuan", "Ink spreads on it"),
    ):
        dialog.material.setCurrentIndex(dialog.material.findData(material))
        assert dialog.wetness.text() == words
    dialog.choose("bowl")
    assert dialog.wetness.text() == "Ink stays where it is laid"
    assert dialog.objects.item(0).text() == "Bowl\n150 × 68 mm"
    fan = dialog.sheets.item(list(FORMS).index("fan"))
    assert fan.text() == "Folding fan\n510 × 237 mm"


def test_what_cannot_be_is_said_and_not_begun(window) -> None:
    seen = []

    def fill(dialog: NewDialog) -> None:
        click_picture(dialog.sheets, "Folding fan")
        type_number(dialog.height_box, "400")
        ok = dialog.buttons.button(QtWidgets.QDialogButtonBox.StandardButton.Ok)
        seen.append((dialog.fault.text(), ok.isEnabled()))
        dialog.reject()

    answer(fill)
    type_key(window.canvas, QtCore.Qt.Key.Key_N, CONTROL)
    wait_for(lambda: bool(seen))
    assert seen == [("a fan's leaf of 400 mm is too broad for 510 mm; expected at most 229.5 mm",
                     False)]  # fmt: skip


def test_a_sheet_on_the_command_line_is_of_what_suits_it(window) -> None:
    assert window.opening.open_path("sheet:90x120:mounted", 1.5, asked=True)
    assert window.document.surface.material.name == "xuan"
    assert window.opening.open_path("fan", 1.5, "silk", asked=True)
    assert window.document.surface.material.name == "silk"


def test_sheets_have_chinese_names(window) -> None:
    choose_language("zh")
    try:
        dialog = NewDialog(window, window.workspace.settings)
        words = [dialog.sheets.item(row).text() for row in range(dialog.sheets.count())]
        dialog.deleteLater()
    finally:
        choose_language("en")
    assert words[0].startswith("条幅\n340 × 1380 mm")
    assert not any(word[0].isascii() for word in words if not word.startswith("A"))

"""Of what the object is, chosen in the surface panel: by name, or from a file of one's own."""

from __future__ import annotations

import itertools

import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest

from paint3d.app.model.persistence.settings import Settings
from paint3d.app.window.object.material_box import MaterialBox
from paint3d.app.window.studio import StudioWindow
from paint3d.app.window.wording import choose_language
from paint3d.colour.materials import load_materials, material_names
from tests.support.app.gestures import answer, drag, live, take_file, wait_for
from tests.support.app.windows import close_unasked, pretend_saved, settled

MINE = 'base = "xuan"\ncolour = "#e8d9b0"\nfriction = 1.5\nchinese = "旧纸"\n'


@pytest.fixture(scope="module")
def window(program):
    window = StudioWindow(program, Settings(material="porcelain"))
    window.resize(1280, 800)
    window.show()
    assert window.opening.open_path("plane", 2.0, "porcelain", asked=True)
    wait_for(lambda: window.stage.is_lit)
    window.panels.docks["surface"].raise_()
    live(0.1)
    yield window
    close_unasked(window)


def step_to(box: MaterialBox, row: int) -> None:
    """By the arrow keys, as one does in a box that is closed."""
    box.setFocus()
    key = QtCore.Qt.Key.Key_Down if row > box.currentIndex() else QtCore.Qt.Key.Key_Up
    while box.currentIndex() != row:
        before = box.currentIndex()
        settled(box.window())  # while an object is made anew, keys are nothing
        QtTest.QTest.keyClick(box, key)
        wait_for(lambda before=before: box.currentIndex() != before)
    settled(box.window())


def choose_a_file(box: MaterialBox) -> None:
    """As by a click on the last row, which is shown when it is told."""
    box.setCurrentIndex(box.count() - 1)
    box.activated.emit(box.count() - 1)


def made_of(window: StudioWindow) -> str:
    settled(window)
    return window.document.surface.material.name


def test_the_next_material_is_there_at_once_on_the_same_object(window) -> None:
    panel = window.panels.surface
    assert [panel.material.itemText(k) for k in range(3)] == ["Porcelain", "Bisque", "Xuan paper"]
    step_to(panel.material, 1)
    assert made_of(window) == "bisque"
    assert window.document.surface.source.name == "plane"
    assert panel.name.text() == "Bisque"
    assert "110 %" in [label.text() for label in panel._numbers.values()]
    assert window.workspace.settings.material == "bisque"


def test_a_file_of_ones_own_is_chosen_and_its_colour_is_seen(window, tmp_path) -> None:
    box = window.panels.surface.material
    (tmp_path / "old paper.toml").write_text(MINE, encoding="utf-8")
    answer(take_file(tmp_path / "old paper.toml"))
    box.setCurrentIndex(box.count() - 1)
    choose_a_file(box)
    assert made_of(window) == "old paper"
    surface = window.document.surface
    assert surface.material.friction == 1.5
    surface.refresh()
    assert tuple(surface.srgb[0]) == (0xE8, 0xD9, 0xB0)
    assert window.panels.surface.name.text() == "old paper"
    assert box.currentText() == "old paper"
    assert window.workspace.settings.material == str(tmp_path / "old paper.toml")
    assert window.workspace.actions["wet"].isChecked()  # its base drinks
    choose_language("zh")
    try:
        window.panels.surface._shown = ()
        window.panels.surface.show_surface(surface)
        assert window.panels.surface.name.text() == "旧纸"
    finally:
        choose_language("en")
        window.panels.surface._shown = ()
        window.panels.surface.show_surface(surface)


def test_a_bad_file_says_why_and_all_stays(window, tmp_path) -> None:
    box, before = window.panels.surface.material, made_of(window)
    shown = box.currentText()
    (tmp_path / "bad.toml").write_text('base = "xuan"\nfriction = 9\n')
    answer(take_file(tmp_path / "bad.toml"))
    choose_a_file(box)
    wait_for(
        lambda: "friction of bad is 9; expected 0.2 to 2" in window.status.message_label.text()
    )
    assert made_of(window) == before
    assert box.currentText() == shown


def test_while_a_file_is_asked_for_the_material_is_the_one_before(program, tmp_path) -> None:
    """Who draws what is chosen asks at each change of the row, also at that of the file."""
    box, seen = MaterialBox("silk"), []

    def see(_: int) -> None:
        seen.append("a fault")
        seen[-1] = box.material()

    box.currentIndexChanged.connect(see)
    files = [tmp_path / "one.toml", tmp_path / "two.toml"]
    for file in files:
        file.write_text(MINE)
        answer(take_file(file))
        choose_a_file(box)
        assert box.material() == str(file)
    assert [one for one, _ in itertools.groupby(seen)] == ["silk", *map(str, files)]


def test_paint_is_not_lost_unasked(window) -> None:
    box = window.panels.surface.material
    step_to(box, material_names().index("silk"))
    assert made_of(window) == "silk"
    drag(window.canvas, (0.4, 0.5), (0.6, 0.5))
    settled(window)
    assert window.document.strokes
    box.setFocus()
    asked = []
    answer(lambda box: (asked.append(box.text()), box.reject()))
    QtTest.QTest.keyClick(box, QtCore.Qt.Key.Key_Up)
    assert made_of(window) == "silk"
    assert box.material() == "silk"
    assert "starts a new painting, without the paint" in asked[0]
    pretend_saved(window.stage.paint_thread)
    box.setFocus()
    answer(lambda box: next(b for b in box.buttons() if b.text() == "Begin anew").click())
    QtTest.QTest.keyClick(box, QtCore.Qt.Key.Key_Up)
    assert made_of(window) == "tinted xuan"
    assert not window.document.strokes


def test_every_material_is_in_the_box(window) -> None:
    box = window.panels.surface.material
    assert [box.itemData(k) for k in range(len(load_materials()))] == material_names()

"""The copybook's panel with any font, a drawing, and a file of strokes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")
pytest.importorskip("uharfbuzz", reason="uharfbuzz is not installed")
pytest.importorskip("svgelements", reason="svgelements is not installed")

from PIL import Image
from PySide6 import QtGui, QtTest, QtWidgets

from paint3d.app.window.seal import SealDialog, SealOptions
from paint3d.app.window.wording import choose_language
from paint3d.calligraphy.fonts.font_file import fonts_with
from paint3d.calligraphy.page.strokes_file import save_strokes
from paint3d.calligraphy.page.svg_drawing import load_svg
from tests.support.app.gestures import BUTTON, answer, click_button, take_file, wait_for
from tests.support.app.windows import opened
from tests.support.photographs import hairs_below_a_stroke

FONT = "DejaVu Sans"
SVG = """<svg xmlns="http://www.w3.org/2000/svg"><g fill="none" stroke="black" stroke-width="4">
<path d="M5 5H55"/><path d="M5 25H55"/></g></svg>"""

pytestmark = pytest.mark.usefixtures("sheets_found_once")


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "bowl", 2.0, "porcelain") as window:
        window.workspace.quiet = False
        yield window


@pytest.fixture
def panel(window):
    window.copying.hide()
    return window.panels.copybook


def type_in(panel, text: str) -> None:
    """As the system's input method commits it."""
    panel.text.setFocus()
    panel.text.selectAll()
    event = QtGui.QInputMethodEvent()
    event.setCommitString(text)
    QtWidgets.QApplication.sendEvent(panel.text, event)


def choose_font(panel, family: str) -> None:
    """By the keys, as one types a name in the list."""
    panel.font_box.setFocus()
    panel.font_box.showPopup()
    panel.font_box.hidePopup()
    place = panel.font_box.findData(family)
    if place < 0:
        pytest.skip(f"there is no {family}")
    panel.font_box.setCurrentIndex(place)


def test_words_of_any_script_stand_as_ghosts_in_a_font(window, panel) -> None:
    if all(font.family != FONT for font in fonts_with("قلم")):
        pytest.skip(f"there is no {FONT} with Arabic")
    panel.em.setValue(30)
    type_in(panel, "قلم")
    choose_font(panel, FONT)
    click_button(panel, "Lay out")
    wait_for(lambda: panel.copybook is not None)
    ghosts = panel.copybook.ghosts
    assert [ghost.text for ghost in ghosts] == ["قلم"]
    bounds = window.document.surface.source.bounds
    for line in ghosts[0].outlines:
        assert (line >= bounds[0] - 0.1).all()
        assert (line <= bounds[1] + 0.1).all()
    first, last = ghosts[0].medians[0], ghosts[0].medians[-3]
    assert first[0, 0] > last[:, 0].max()  # from the right; the two dots of ق come at last
    panel.font_box.setCurrentIndex(0)


def test_characters_that_the_font_lacks_are_named(panel, monkeypatch) -> None:
    told = []
    monkeypatch.setattr(QtWidgets.QMessageBox, "warning", lambda *words: told.append(words[-1]))
    type_in(panel, "龘")
    choose_font(panel, FONT)
    click_button(panel, "Lay out")
    wait_for(lambda: told)
    assert "U+9F98" in told[0]
    assert panel.copybook is None
    panel.font_box.setCurrentIndex(0)


def test_characters_that_are_taken_from_a_font_are_told(window, panel, system_fonts) -> None:
    system_fonts.add("Test Kai", "步")
    panel.em.setValue(30)
    type_in(panel, "漫步")
    click_button(panel, "Lay out")
    wait_for(lambda: panel.copybook is not None)
    assert [ghost.text for ghost in panel.copybook.ghosts] == ["漫", "步"]
    assert "步 taken from the font Test Kai" in window.status.message_label.text()


def test_a_seal_says_which_characters_are_from_a_font(window, system_fonts) -> None:
    system_fonts.add("Test Kai", "步")
    dialog = SealDialog(window, SealOptions("漫步"))
    dialog.show()
    wait_for(lambda: not dialog.picture.pixmap().isNull())
    assert dialog.note.text() == "16 mm × 16 mm; 步 taken from the font Test Kai"
    dialog.text.setText("漫")
    wait_for(lambda: dialog.note.text() == "16 mm × 16 mm")
    dialog.close()


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("en", "kanjivg has no glyph for '步' (U+6B65), and no font that is installed has one"),
        ("zh", "kanjivg 没有这些字形：'步' (U+6B65)；已安装的字体也都没有"),
    ],
)
def test_what_a_painter_can_do_about_a_character_is_said(
    panel, system_fonts, monkeypatch, language: str, words: str
) -> None:
    told = []
    monkeypatch.setattr(QtWidgets.QMessageBox, "warning", lambda *said: told.append(said[-1]))
    type_in(panel, "漫步")
    choose_language(language)
    try:
        click_button(panel, "Lay out")
        wait_for(lambda: told)
    finally:
        choose_language("en")
    assert told[0].startswith(words)
    assert "--" not in told[0]
    assert panel.copybook is None


def test_a_photograph_is_opened(window, panel, tmp_path: Path) -> None:
    pytest.importorskip("skimage", reason="scikit-image is not installed")
    pixels = np.full((300, 300, 3), 235, np.uint8)
    pixels[60:84, 50:250] = pixels[200:224, 50:250] = 20  # a scan of two bars: no table is seen
    file = tmp_path / "two.png"
    Image.fromarray(pixels).save(file)
    panel.em.setValue(30)
    answer(take_file(file), QtWidgets.QFileDialog)
    QtTest.QTest.mouseClick(panel.open_button, BUTTON.LeftButton)
    wait_for(lambda: panel.copybook is not None)
    assert sum(len(ghost.glyph.strokes) for ghost in panel.copybook.ghosts) == 2


def test_ink_that_is_in_no_stroke_is_told(window, panel, tmp_path: Path) -> None:
    pytest.importorskip("skimage", reason="scikit-image is not installed")
    file = hairs_below_a_stroke(tmp_path)
    choose_language("zh")
    try:
        answer(take_file(file), QtWidgets.QFileDialog)
        QtTest.QTest.mouseClick(panel.open_button, BUTTON.LeftButton)
        wait_for(lambda: panel.copybook is not None)
    finally:
        choose_language("en")
    assert "部分墨迹未归入笔画：字 1 (" in window.status.message_label.text()


@pytest.mark.parametrize("kind", [".svg", ".strokes.json"])
def test_a_drawing_and_its_strokes_are_opened(window, panel, tmp_path: Path, kind: str) -> None:
    file = tmp_path / "two.svg"
    file.write_text(SVG, encoding="utf-8")
    if kind != ".svg":
        file = tmp_path / "two.strokes.json"
        save_strokes(load_svg(tmp_path / "two.svg"), file)
    panel.em.setValue(40)
    answer(take_file(file), QtWidgets.QFileDialog)
    QtTest.QTest.mouseClick(panel.open_button, BUTTON.LeftButton)
    wait_for(lambda: panel.copybook is not None)
    ghosts = panel.copybook.ghosts
    assert sum(len(ghost.glyph.strokes) for ghost in ghosts) == 2
    lengths = [
        np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for g in ghosts for line in g.medians
    ]
    np.testing.assert_allclose(lengths, 40.0, rtol=0.03)

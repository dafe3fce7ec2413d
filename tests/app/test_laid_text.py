"""Texts laid on a sheet and on a bowl: moved, turned, scaled, spaced, signed, and taken back."""

from __future__ import annotations

import datetime

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtTest, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.laid_text import LaidText, pack_texts, unpack_texts
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.persistence.recovery_folder import RecoveryFolder, recoverable
from paint3d.app.model.score.playing import painted
from paint3d.app.window.copybook.copybook_guide import date_line, signer_in
from paint3d.app.window.seal import SealDialog
from paint3d.brush.presets import load_brush
from paint3d.calligraphy.seal.stone import cut_seal
from paint3d.errors import InputError
from tests.support.app.gestures import (
    BUTTON,
    KIND,
    answer,
    click_button,
    mouse,
    pen,
    pen_stroke,
    type_key,
    wait_for,
)
from tests.support.app.windows import opened, pretend_saved, settled
from tests.support.cases import long_but

KEY, HELD = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier


@pytest.fixture(scope="module")
def window(program, nothing_planned_ahead):
    """A window with a sheet in it."""
    with opened(program, "sheet:200x260", 1.5, "xuan", drawn=False) as window:
        yield window


@pytest.fixture(autouse=True)
def bare(window) -> None:
    window.copying.mover.end()
    while window.document.can_undo:
        window.stage.paint_thread.post("undo").result(300)
    settled(window)
    wait_for(lambda: not window.copying._shown)


def lay(window, text: str, em: float, columns: bool = True) -> None:
    count = len(window.document.texts)
    assert window.copying.layout_text(text, em, columns)
    wait_for(lambda: len(window.document.texts) >= max(count, 1))
    settled(window)


def begin(window) -> None:
    type_key(window.canvas, KEY.Key_T)
    wait_for(lambda: window.copying.mover.is_on)


def origins(window) -> np.ndarray:
    return np.array([s.chart.frame.origin for s in window.panels.copybook.copybook.squares])


def pixel(window, point) -> tuple[float, float]:
    x, y = window.hand.pixels_of(np.array([point]))[0]
    return float(x), float(y)


def drag(window, start, end, by: str = "mouse") -> None:
    """From one place of the picture to another, pixels, with a mouse or a pen."""
    canvas, ways = window.canvas, np.linspace(start, end, 8)
    if by == "pen":
        pen(canvas, KIND.TabletPress, *ways[0], 0.5)
        for x, y in ways[1:]:
            pen(canvas, KIND.TabletMove, x, y, 0.5)
        pen(canvas, KIND.TabletRelease, *ways[-1], 0.0)
        return
    mouse(canvas, KIND.MouseMove, *ways[0])
    mouse(canvas, KIND.MouseButtonPress, *ways[0], BUTTON.LeftButton, BUTTON.LeftButton)
    for x, y in ways[1:]:
        mouse(canvas, KIND.MouseMove, x, y, buttons=BUTTON.LeftButton)
    mouse(canvas, KIND.MouseButtonRelease, *ways[-1], BUTTON.LeftButton)


def text_of(window) -> LaidText:
    (text,) = window.document.texts
    return text


@pytest.mark.parametrize("by", long_but(["pen"], ["mouse", "pen"]))
def test_a_text_is_dragged_and_one_undo_takes_it_back(window, by: str) -> None:
    lay(window, "永和\n九年", 30.0)
    before = origins(window)
    begin(window)
    start = pixel(window, before[0])
    end = pixel(window, before[0] + np.array([25.0, 40.0, 0.0]))
    drag(window, start, end, by)
    wait_for(lambda: window.document.texts and text_of(window).point is not None)
    settled(window)
    np.testing.assert_allclose(origins(window), before + np.array([25.0, 40.0, 0.0]), atol=0.6)
    assert not window.document.strokes
    type_key(window.canvas, KEY.Key_T)
    assert not window.copying.mover.is_on
    type_key(window.canvas, KEY.Key_Z, HELD.ControlModifier)
    wait_for(lambda: text_of(window).point is None)
    wait_for(lambda: np.allclose(origins(window), before, atol=1e-6))


def test_grips_scale_turn_and_space_it(window) -> None:
    lay(window, "永和\n九年", 24.0)
    begin(window)
    mover = window.copying.mover

    def grip(name: str) -> tuple[float, float]:
        at = mover.grips()[name]
        return at.x(), at.y()

    start, middle = np.array(grip("scale")), np.array(pixel(window, (0.0, 0.0, 0.0)))
    drag(window, start, middle + 1.25 * (start - middle))
    wait_for(lambda: text_of(window).em_mm == pytest.approx(30.0, abs=0.6))
    settled(window)
    x, y = grip("across")
    gap = text_of(window).gap
    drag(window, (x, y), (x - 20.0, y))
    wait_for(lambda: text_of(window).gap > gap + 0.05)
    settled(window)
    x, y = grip("down")
    drag(window, (x, y), (x, y + 20.0))
    wait_for(lambda: text_of(window).between > 0.05)
    settled(window)
    at = window.hand.place_at(*grip("turn"))  # the sheet lies in z = 0
    c, s = np.cos(np.radians(20.0)), np.sin(np.radians(20.0))
    drag(window, grip("turn"), pixel(window, (c * at[0] - s * at[1], s * at[0] + c * at[1], 0.0)))
    wait_for(lambda: text_of(window).turn == pytest.approx(20.0, abs=1.0))
    settled(window)
    up = window.panels.copybook.copybook.squares[0].chart.frame.y_axis
    turn = np.radians(text_of(window).turn)
    np.testing.assert_allclose(up, [-np.sin(turn), np.cos(turn), 0.0], atol=1e-6)
    assert len(window.document.steps.done) == 5


def test_keys_move_turn_scale_and_space_it_and_are_one_step(window) -> None:
    lay(window, "永和\n九年", 24.0)
    begin(window)
    beside = pixel(window, (-50.0, 0.0, 0.0))
    drag(window, beside, beside)
    wait_for(lambda: "no text there" in window.status.message_label.text())
    for _ in range(3):
        type_key(window.canvas, KEY.Key_Right)
    assert "arrows move" in window.status.message_label.text()
    type_key(window.canvas, KEY.Key_Up, HELD.ShiftModifier)
    type_key(window.canvas, KEY.Key_Left, HELD.ControlModifier)
    type_key(window.canvas, KEY.Key_Up, HELD.ControlModifier)
    type_key(window.canvas, KEY.Key_Up, HELD.AltModifier)
    wait_for(lambda: text_of(window).point is not None)
    text = text_of(window)
    assert text.point == pytest.approx((3.0, 10.0, 0.0), abs=0.05)
    assert (text.turn, text.em_mm) == (1.0, pytest.approx(24.0 * 1.02))
    assert text.between == pytest.approx(0.02)
    assert len(window.document.steps.done) == 2
    type_key(window.canvas, KEY.Key_Delete)
    wait_for(lambda: not window.document.texts)
    type_key(window.canvas, KEY.Key_Escape)
    assert not window.copying.mover.is_on


def test_numbers_in_the_panel_change_it_at_once(window) -> None:
    panel = window.panels.copybook
    lay(window, "永和九年", 24.0)
    for box, number in (
        (panel.turn, 10.0),
        (panel.em, 20.0),
        (panel.between, 50.0),
        (panel.right, 7.0),
    ):
        box.setFocus()
        box.selectAll()
        QtTest.QTest.keyClicks(box, f"{number:g}")
        QtTest.QTest.keyClick(box, KEY.Key_Return)
        settled(window)
    text = text_of(window)
    assert (text.turn, text.em_mm, text.between) == (10.0, 20.0, 0.5)
    c, s = np.cos(np.radians(10.0)), np.sin(np.radians(10.0))
    assert text.point == pytest.approx((7.0 * c, 7.0 * s, 0.0), abs=0.3)


def test_several_texts_are_chosen_by_a_click_and_a_stroke_belongs_to_its_own(window) -> None:
    panel = window.panels.copybook
    lay(window, "一", 60.0)
    begin(window)
    drag(window, pixel(window, (0.0, 0.0, 0.0)), pixel(window, (0.0, 70.0, 0.0)))
    wait_for(lambda: text_of(window).point is not None)
    type_key(window.canvas, KEY.Key_T)
    panel.text.setPlainText("二")
    click_button(panel, "Another")
    wait_for(lambda: len(window.document.texts) == 2)
    settled(window)
    assert [panel.texts.itemText(k) for k in range(panel.texts.count())] == ["一", "二"]
    assert panel.texts.currentIndex() == 1
    ghost = window.copying._books[window.document.texts[0]].ghosts[0]
    line = window.hand.pixels_of(ghost.medians[0][[0, -1]])
    line = line / [window.canvas.width(), window.canvas.height()]
    pen_stroke(window.canvas, tuple(line[0]), tuple(line[1]), [0.4] * 16)
    settled(window)
    wait_for(lambda: panel.texts.currentIndex() == 0)
    wait_for(lambda: panel.percent(0) is not None)
    assert window.document.strokes[-1].tags["character"] == "一"


def test_a_grid_lies_alone_and_around_characters(window) -> None:
    panel = window.panels.copybook
    panel.text.setPlainText("")
    panel.em.setValue(25.0)
    panel.across.setValue(3)
    panel.down.setValue(4)
    panel.grid_box.setCurrentIndex(panel.grid_box.findData("mi"))
    click_button(panel, "Another")
    wait_for(lambda: len(window.document.texts) == 1)
    settled(window)
    assert text_of(window) == LaidText("", 25.0, grid="mi", cells=(3, 4))
    book = panel.copybook
    assert len(book.squares) == 12
    assert len(book.grid("mi", True)) == 12 * 8
    assert len(book.grid("jiu", True)) == 12 * 8
    assert len(book.grid("columns", True)) == 24
    assert panel.texts.itemText(0) == "Grid of 3 × 4"


def test_a_signature_is_laid_smaller_to_the_left_and_written_in_another_ink(window) -> None:
    lay(window, "永和\n九年", 40.0)
    main = origins(window)

    def fill(dialog: QtWidgets.QInputDialog) -> None:
        edit = dialog.findChild(QtWidgets.QLineEdit)
        date = date_line(datetime.date.today())
        wait_for(lambda: edit.selectedText() == "□□")
        QtTest.QTest.keyClicks(edit, "Anna")  # which leaves the date
        assert dialog.textValue() == f"{date[:-1]}Anna{date[-1]}"
        dialog.setTextValue("丙午年春□□")  # a name that is not given is not written
        dialog.accept()

    answer(fill)
    window.workspace.actions["sign"].trigger()
    wait_for(lambda: len(window.document.texts) == 2)
    settled(window)
    signature = window.document.texts[1]
    assert (signature.text, signature.grid) == ("丙午年春", "none")
    assert 8.0 <= signature.em_mm <= 16.0
    assert origins(window)[:, 0].max() < main[:, 0].min() - 20.0
    assert not window.copying.mover.is_on  # it lies where it belongs


def test_letters_are_proposed_in_a_row_and_squares_without_a_text(window) -> None:
    panel = window.panels.copybook
    for text, in_columns in (("Anna", False), ("永和，九年", True), ("Anna 永", False)):
        panel.text.setPlainText(text)
        assert panel.direction.currentData() is in_columns
        assert not panel.across.isEnabled()
    panel.text.setPlainText(" ")
    assert panel.across.isEnabled()
    panel.direction.setCurrentIndex(panel.direction.findData(True))
    panel.direction.activated.emit(panel.direction.currentIndex())
    panel.text.setPlainText("Anna")
    assert panel.direction.currentData() is True  # as it was chosen


def test_the_panel_begins_anew_with_a_painting_and_leaves_no_signature(window) -> None:
    panel = window.panels.copybook
    panel.show_values(LaidText("丙午年冬李明書", 12.0, grid="none", is_signature=True))
    panel.begin_anew(on_sheet=True)
    assert (panel.text.text(), panel.em.value()) == ("永和九年", 40.0)
    assert panel.grid_box.currentData() == "frame"
    panel.show_values(LaidText("靜夜思", 55.0))
    panel.begin_anew(on_sheet=True)
    assert (panel.text.text(), panel.em.value()) == ("靜夜思", 40.0)
    panel.text.setPlainText("永" * 2500)  # more than is laid
    panel.begin_anew(on_sheet=True)
    assert len(panel.text.text()) == 2500


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("丙午年冬李明書", "李明"), ("丙午年三月初五日張大千畫", "張大千"),
        ("李明書", "李明"), ("丙午年冬書", ""), ("王羲之丙午年春", "王羲之"), ("張大年", "張大年"),
        ("2026年11月29日 Anna", "Anna"), ("二〇二六年十一月二十九日李明", "李明"),
        ("丙午年冬月張大年", "張大年"), ("民國一一五年春三月李明", "李明"),
    ],
)  # fmt: skip
def test_a_signature_says_who_signed(line: str, name: str) -> None:
    assert signer_in(line) == name


def test_a_seal_has_the_name_and_the_size_of_the_signature(window) -> None:
    lay(window, "永和", 40.0)
    answer(lambda dialog: (dialog.setTextValue("丙午年冬李明書"), dialog.accept()))
    window.workspace.actions["sign"].trigger()
    wait_for(lambda: len(window.document.texts) == 2)
    window.copying.mover.end()
    seen = []
    answer(lambda dialog: (seen.append(dialog.asked()), dialog.reject()), SealDialog)
    click_button(window.panels.copybook, "Press a seal…")
    em = window.document.texts[1].em_mm
    assert (seen[0].text, seen[0].size_mm) == ("李明", pytest.approx(0.85 * em, abs=0.25))
    assert (
        date_line(datetime.date(2026, 12, 1), window.workspace.settings.signer) == "丙午年冬李明書"
    )
    window.workspace.update_settings(signer="")
    window.copying.mover.end()
    window.copying.choose(1)
    window.copying.change({"grid": "frame"})
    wait_for(lambda: window.document.texts[1].grid == "frame")
    assert unpack_texts(pack_texts(window.document.texts))[1].is_signature
    assert window.copying.signature()[:2] == ("李明", pytest.approx(0.85 * em))


def test_a_text_without_a_grid_is_no_signature_and_a_long_name_no_seal(window) -> None:
    lay(window, "靜心", 40.0)
    window.copying.change({"grid": "none"})
    wait_for(lambda: text_of(window).grid == "none")
    signature = window.copying.signature()
    assert (signature.name, signature.size_mm) == ("", pytest.approx(0.85 * 0.35 * 40.0))
    assert signature.point[0] < origins(window)[:, 0].min() - 20.0
    shown = []
    window.workspace.update_settings(signer="張大千李明")
    answer(lambda dialog: (shown.append(dialog.asked()), dialog.reject()), SealDialog)
    click_button(window.panels.copybook, "Press a seal…")
    window.workspace.update_settings(signer="")
    assert cut_seal(shown[0].text).text != "張大千李明"
    assert shown[0].size_mm == pytest.approx(0.85 * 0.35 * 40.0, abs=0.3)


def test_a_brush_that_fits_is_taken_and_undo_takes_it_back(window) -> None:
    paint_thread = window.stage.paint_thread
    before = paint_thread.brush
    lay(window, "永", 14.0)
    assert paint_thread.brush.name == "xiaobaiyun"
    assert "xiaobaiyun" in window.status.message_label.text()
    window.workspace.actions["undo"].trigger()
    wait_for(lambda: window.document.painter.brush == before)
    assert not window.document.texts


def test_moves_and_signatures_leave_the_brush_and_so_does_undo_of_a_move(window) -> None:
    paint_thread, undo = window.stage.paint_thread, window.workspace.actions["undo"]
    before = paint_thread.brush
    lay(window, "永", 14.0)
    fitted = paint_thread.brush
    assert fitted != before
    for _ in range(2):
        window.copying.nudge(3.0, 0.0)
        settled(window)
    place = text_of(window).point
    undo.trigger()
    wait_for(lambda: text_of(window).point != place)
    settled(window)
    wait_for(lambda: window.copying._shown == window.document.texts)
    assert paint_thread.brush == fitted
    paint_thread.post("set_brush", load_brush("dabaiyun"))
    window.copying.nudge(3.0, 0.0)
    settled(window)
    assert paint_thread.brush.name == "dabaiyun"
    answer(lambda dialog: (dialog.setTextValue("李明"), dialog.accept()))
    window.workspace.actions["sign"].trigger()
    wait_for(lambda: len(window.document.texts) == 2)
    window.copying.mover.end()
    window.workspace.update_settings(signer="")
    assert paint_thread.brush.name == "dabaiyun"
    window.copying.choose(0)
    window.copying.change({"em_mm": 13.0})
    settled(window)
    assert paint_thread.brush == fitted
    paint_thread.post("set_brush", before)


def test_a_text_fills_a_sheet_until_a_number_is_given(program) -> None:
    with opened(program, "sheet:100x150:margin=10", 2.0, "xuan", drawn=False) as window:
        panel = window.panels.copybook
        assert panel.fills
        lay(window, "永", 12.0)
        pretend_saved(window.stage.paint_thread)
        changes = []
        panel.changed.connect(changes.append)
        assert window.opening.open_path("sheet:100x150:margin=10", 2.0, "xuan", asked=True)
        wait_for(lambda: not window.copying._shown)
        assert (panel.fills, changes) == (True, [])
        panel.text.setPlainText("一二\n三四\n五六\n七八")
        panel.ask()
        wait_for(lambda: window.document.texts)
        book = window.copying.chosen_text().book
        assert len(book.ghosts) == 8
        assert 8 * panel.em.value() ** 2 > 0.3 * 100.0 * 150.0
        assert [len(line) for line in book.lines.split("\n")] == [4, 4]
        panel.em.setValue(15.0)
        wait_for(lambda: window.document.texts[0].em_mm == 15.0)
        assert not panel.fills
        panel.text.setPlainText("一二")
        panel.ask()
        wait_for(lambda: len(window.copying.chosen_text().book.ghosts) == 2)
        assert window.document.texts[0].em_mm == 15.0


def test_a_text_lies_in_the_middle_of_what_is_painted(window) -> None:
    pen_stroke(window.canvas, (0.45, 0.5), (0.55, 0.5), [0.5] * 12)
    settled(window)
    inked = window.document.surface.wet_ink() + window.document.surface.dry_ink()
    lay(window, "山", 50.0)
    surface = window.document.surface
    np.testing.assert_array_equal(surface.wet_ink() + surface.dry_ink(), inked)
    assert len(window.document.strokes) == 1


def test_texts_come_back_from_files_scores_and_recovery(window, tmp_path) -> None:
    lay(window, "永和\n九年", 24.0)
    window.copying.change({"turn": 12.0})
    settled(window)
    document = window.document
    texts = document.texts
    document.save(tmp_path / "one.p3d")
    again = Document.open(tmp_path / "one.p3d")
    assert again.texts == texts
    again.undo()
    assert again.texts[0].turn == 0.0
    again.redo()
    assert again.texts == texts
    assert painted(document.score, document.surface.source).texts == texts


def test_a_reopened_painting_counts_no_stroke_from_before_its_text(
    program, window, tmp_path
) -> None:
    pen_stroke(window.canvas, (0.42, 0.5), (0.58, 0.5), [0.5] * 12)
    settled(window)
    lay(window, "一", 60.0)
    assert window.panels.copybook.message_label.text() == "0 of 1 written; next: 一"
    window.document.save(tmp_path / "one.p3d")
    with opened(program, str(tmp_path / "one.p3d"), drawn=False) as again:
        wait_for(lambda: again.panels.copybook.copybook is not None)
        assert len(again.document.strokes) == 1
        settled(again)
        assert again.panels.copybook.message_label.text() == "0 of 1 written; next: 一"
        pen_stroke(again.canvas, (0.42, 0.5), (0.58, 0.5), [0.5] * 12)
        wait_for(lambda: again.panels.copybook.message_label.text() == "All characters are written")
        pretend_saved(again.stage.paint_thread)


def test_texts_come_back_after_a_crash(tmp_path) -> None:
    document = Document.new("plane", 4.0, "xuan")
    folder = RecoveryFolder(document, tmp_path)
    paint_thread = PaintThread(document, recovery=folder)
    paint_thread.post("lay_text", LaidText("永和", 24.0).words()).result(300)
    paint_thread.post("lay_text", LaidText("永和", 24.0, turn=20.0).words(), 0).result(300)
    paint_thread.stop(keep=True)
    recovered = recoverable(tmp_path)[0].recover().document
    assert recovered.texts == (LaidText("永和", 24.0, turn=20.0),)
    recovered.undo()
    assert recovered.texts == (LaidText("永和", 24.0),)


def test_a_text_that_has_no_room_stays_where_it_was(window) -> None:
    lay(window, "永和\n九年", 40.0)
    before = origins(window)
    begin(window)
    drag(window, pixel(window, (0.0, 0.0, 0.0)), pixel(window, (62.0, 0.0, 0.0)))
    wait_for(lambda: "does not fit" in window.status.message_label.text())
    np.testing.assert_array_equal(origins(window), before)
    assert text_of(window).point is None


def test_a_signature_alone_has_room_to_be_moved_and_stays_one_column(program) -> None:
    with opened(program, "fan:300x100:margin=5", 2.0, "xuan", drawn=False) as window:
        answer(lambda dialog: (dialog.setTextValue("丙午年春山人書"), dialog.accept()))
        window.workspace.actions["sign"].trigger()
        wait_for(lambda: window.document.texts)
        settled(window)
        assert 7 * text_of(window).em_mm <= 45.0 + 1e-6
        before = origins(window)
        for away in ((30.0, 5.0, 0.0), (0.0, -28.0, 0.0)):  # there it fits; there only in two
            start = origins(window)[3]
            drag(window, pixel(window, start), pixel(window, start + np.array(away)))
            settled(window)
            assert window.panels.copybook.copybook.lines == "丙午年春山人書"
        wait_for(lambda: "no room" in window.status.message_label.text())
        assert origins(window)[3, 0] > before[3, 0] + 25.0
        pretend_saved(window.stage.paint_thread)


def test_rows_are_laid_at_once_and_what_is_too_large_at_the_size_that_fits(window) -> None:
    lay(window, "永和九年", 20.0)
    window.panels.copybook.text.setPlainText("松竹")  # typed for another text
    direction = window.panels.copybook.direction
    direction.setFocus()
    QtTest.QTest.keyClick(direction, KEY.Key_Down)
    wait_for(lambda: text_of(window).order == "row")
    settled(window)
    assert "".join(text_of(window).text.split()) == "永和九年"
    assert np.ptp(origins(window)[:, 0]) > 50.0
    answer(lambda box: box.defaultButton().click())
    assert window.copying.layout_text("永和九年", 70.0, False)
    wait_for(lambda: text_of(window).em_mm != 20.0)
    settled(window)
    assert 20.0 < text_of(window).em_mm < 70.0
    before = window.document.texts
    assert not window.copying.layout_text("永和九年", 300.0, True)
    assert "no place for an em of 300 mm" in str(window.workspace.error)
    assert window.document.texts == before


def test_a_text_all_around_breaks_anew_and_is_not_turned(program) -> None:
    with opened(program, "bowl", 4.0, "porcelain", drawn=False) as window:
        panel = window.panels.copybook
        lay(window, "永和九年", 14.0)
        window.copying.change({"turn": 20.0})
        wait_for(lambda: text_of(window).turn == 20.0)
        settled(window)
        window.copying.ask({"text": "永和九年", "turn": 20.0}, False)
        wait_for(lambda: text_of(window).text == "永和九年")
        settled(window)
        panel.around_box.click()
        wait_for(lambda: text_of(window).around)
        settled(window)
        assert text_of(window) == LaidText("永和九年", 14.0, around=True)
        assert panel.copybook.lines == "永\n和\n九\n年"
        assert (panel.turn.isEnabled(), panel.turn.value()) == (False, 0.0)
        begin(window)
        assert "scale" in window.copying.mover.grips()
        assert "turn" not in window.copying.mover.grips()
        panel.around_box.click()
        wait_for(lambda: not text_of(window).around)
        settled(window)
        assert text_of(window).text == "永和九年"
        assert panel.turn.isEnabled()
        pretend_saved(window.stage.paint_thread)


def test_a_text_on_a_bowl_is_moved_over_its_wall(program) -> None:
    with opened(program, "bowl", 4.0, "porcelain", drawn=False) as window:
        lay(window, "永和", 16.0)
        before = origins(window).mean(axis=0)
        begin(window)
        frame = window.panels.copybook.copybook.block.frame
        there = frame.origin + 18.0 * frame.x_axis
        drag(window, pixel(window, frame.origin), pixel(window, there))
        wait_for(lambda: text_of(window).point is not None)
        settled(window)
        away = origins(window).mean(axis=0) - before
        assert away @ frame.x_axis == pytest.approx(18.0, abs=3.0)
        pretend_saved(window.stage.paint_thread)


def test_the_view_turns_to_a_text_that_comes_to_lie_on_the_far_side(program) -> None:
    with opened(program, "bowl", 4.0, "porcelain", drawn=False) as window:
        window.workspace.actions["look_back"].trigger()
        behind = window.hand.camera
        lay(window, "永和", 16.0)
        place = origins(window).mean(axis=0)
        seen = window.hand.camera
        assert place @ behind.position < 0.0 < place @ seen.position
        window.copying.change({"turn": 10.0})  # and where it is seen stays
        wait_for(lambda: text_of(window).turn == 10.0)
        assert window.hand.camera is seen
        pretend_saved(window.stage.paint_thread)


@pytest.mark.parametrize("words", [{"em_mm": 1.0}, {"turn": 200.0}, {"grid": "star"}, {"size": 3},
    {"cells": [0, 4]}, {"text": 3}, {"point": [1.0, 2.0]}, {"order": "up"},
    {"is_signature": 1}])  # fmt: skip
def test_what_is_no_text_is_refused_and_changes_nothing(words) -> None:
    document = Document.new("plane", 4.0, "xuan")
    with pytest.raises(InputError):
        document.lay_text(words)
    with pytest.raises(InputError):
        document.remove_text(0)
    assert not document.texts
    assert not document.steps.done
    with pytest.raises(InputError):
        unpack_texts("[3]")


def test_words_of_a_text_say_it_again() -> None:
    text = LaidText(
        "永和", 33.0, "Kai", "row", (1.0, 2.0, 3.0), -20.0, 0.3, 0.1, "jiu", (2, 3), True
    )
    assert unpack_texts(pack_texts([text, LaidText("二")])) == (text, LaidText("二"))
    document = Document.new("plane", 4.0, "xuan")
    document.lay_text(text.words())
    assert document.score.events[-1]["text"] == text.words()


def test_a_year_of_the_sixty_and_its_season_are_said() -> None:
    import datetime

    assert date_line(datetime.date(2026, 4, 1)) == "丙午年春書"
    assert date_line(datetime.date(1984, 12, 9)) == "甲子年冬書"
    assert date_line(datetime.date(2026, 11, 30)) == "丙午年冬書"
    assert date_line(datetime.date(2027, 1, 20)) == "丙午年冬書"
    assert date_line(datetime.date(2027, 2, 20)) == "丁未年春書"

"""Strokes over the picture: corrected by mouse, pen, finger and keys in the real window."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")
pytest.importorskip("svgelements", reason="svgelements is not installed")

from PIL import Image
from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from paint3d.app.model.copybook import Copybook
from paint3d.app.window.copybook import copybook_guide
from paint3d.app.window.copybook.strokes_dialog import CorrectionSteps, LabelGrid, StrokesDialog
from paint3d.app.window.questions import Answer
from paint3d.calligraphy.page.opening import open_page
from paint3d.calligraphy.page.strokes_file import load_strokes, save_strokes
from paint3d.calligraphy.photo import copying
from paint3d.errors import InputError
from tests.support.app.gestures import BUTTON, KIND, answer, answer_bar, live, mouse, pen, wait_for
from tests.support.app.windows import opened

KEY, CONTROL = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier.ControlModifier
SVG = """<svg xmlns="http://www.w3.org/2000/svg"><g fill="none" stroke="black" stroke-width="6">
<path d="M5 5H55"/><path d="M5 25H55"/><path d="M5 45H55"/></g></svg>"""

pytestmark = pytest.mark.usefixtures("sheets_found_once")


@pytest.fixture(scope="module")
def window(program):
    with opened(program, "plane", 2.0, "porcelain", drawn=False) as window:
        window.workspace.quiet = False
        yield window


@pytest.fixture
def drawing(window, tmp_path: Path) -> Path:
    file = tmp_path / "three.svg"
    file.write_text(SVG, encoding="utf-8")
    assert window.copying.layout_file(str(file), 30.0)
    return file


@pytest.fixture
def sheet(window, tmp_path: Path) -> Path:
    pytest.importorskip("skimage", reason="scikit-image is not installed")
    pixels = np.full((300, 300, 3), 235, np.uint8)
    pixels[60:84, 50:250] = pixels[200:224, 50:250] = 20
    file = tmp_path / "two.png"
    Image.fromarray(pixels).save(file)
    assert window.copying.layout_file(str(file), 30.0)
    return file


def correct(window, act) -> None:
    """Open the dialog by its button, and let `act` use it; what it finds wrong fails the test."""
    found: list[BaseException] = []

    def watched(dialog) -> None:
        try:
            act(dialog)
        except BaseException as error:
            found.append(error)
            dialog.done(0)  # and nothing is asked

    answer(watched, StrokesDialog)
    button = window.panels.copybook.correct_button
    assert button.isEnabled()
    QtTest.QTest.mouseClick(button, BUTTON.LeftButton)
    live(0.05)
    if found:
        raise found[0]


def pixels_of(view) -> np.ndarray:
    """What a view shows (H, W, 4)."""
    image = view.grab().toImage().convertToFormat(QtGui.QImage.Format.Format_RGBA8888)
    shape = image.height(), image.width(), 4
    return np.frombuffer(image.constBits(), np.uint8).reshape(shape).astype(float)


def ways(window) -> list[np.ndarray]:
    """From where to where the ghosts' strokes lead, mm, in their order."""
    ghosts = window.panels.copybook.copybook.ghosts
    return [line[-1] - line[0] for ghost in ghosts for line in ghost.medians]


def place_on(dialog, k: int, share: float = 0.5) -> QtCore.QPointF:
    """Where a stroke lies in the dialog's picture."""
    line = dialog.steps.now.strokes.strokes[k].stroke.median
    there = line[0] + share * (line[-1] - line[0])
    return dialog.view.place(*dialog.view.behind.pixels(there[None])[0])


def click(dialog, place: QtCore.QPointF) -> None:
    x, y = place.x(), place.y()
    mouse(dialog.view, KIND.MouseButtonPress, x, y, BUTTON.LeftButton, BUTTON.LeftButton)
    mouse(dialog.view, KIND.MouseButtonRelease, x, y, BUTTON.LeftButton)


def key(dialog, which, held=QtCore.Qt.KeyboardModifier.NoModifier) -> None:
    QtTest.QTest.keyClick(dialog.focusWidget() or dialog.view, which, held)


def drop_button(box) -> QtWidgets.QAbstractButton:
    return next(b for b in box.buttons() if box.buttonRole(b) == Answer.DestructiveRole)


def use(dialog) -> None:
    QtTest.QTest.mouseClick(dialog.use, BUTTON.LeftButton)


def test_a_stroke_is_chosen_and_reversed_and_its_ghost_follows(window, drawing) -> None:
    before = ways(window)

    def act(dialog) -> None:
        click(dialog, place_on(dialog, 1))
        assert dialog.chosen == 1
        assert "1" in dialog.message_label.text()
        key(dialog, KEY.Key_R)
        use(dialog)

    correct(window, act)
    after = ways(window)
    assert len(after) == 3
    np.testing.assert_allclose(after[1], -before[1], atol=0.1)
    np.testing.assert_allclose(after[0], before[0], atol=0.1)


def test_buttons_and_keys_are_the_same_and_are_undone(window, drawing) -> None:
    names = {"reverse": KEY.Key_R, "leave out": KEY.Key_X}

    def act(dialog) -> None:
        for name, by_key in names.items():
            first = dialog.steps.now
            QtTest.QTest.mouseClick(dialog.buttons[name], BUTTON.LeftButton)
            by_button = dialog.page
            key(dialog, KEY.Key_Z, CONTROL)
            assert dialog.steps.now is first
            key(dialog, by_key)
            for one, other in zip(by_button.pieces, dialog.page.pieces, strict=True):
                for a, b in zip(one.glyph.strokes, other.glyph.strokes, strict=True):
                    np.testing.assert_array_equal(a.median, b.median)
            key(dialog, KEY.Key_Z, CONTROL)
            key(dialog, KEY.Key_Y, CONTROL)
            assert dialog.steps.now is not first
            key(dialog, KEY.Key_Z, CONTROL)
        use(dialog)

    correct(window, act)
    assert len(ways(window)) == 3


def test_pieces_follow_in_another_order(window, drawing) -> None:
    before = [g.square.points[0, 0] for g in window.panels.copybook.copybook.ghosts]

    def act(dialog) -> None:
        click(dialog, place_on(dialog, 2))
        key(dialog, KEY.Key_PageUp)
        assert dialog.chosen == 2  # it is alone in its piece
        key(dialog, KEY.Key_W)
        assert dialog.whole.isChecked()
        key(dialog, KEY.Key_PageUp)
        assert dialog.chosen == 1
        use(dialog)

    correct(window, act)
    after = [g.square.points[0, 0] for g in window.panels.copybook.copybook.ghosts]
    np.testing.assert_allclose([after[k] for k in (0, 2, 1)], before, atol=0.1)


def test_a_stroke_is_split_where_it_is_clicked_and_joined_by_keys(window, drawing) -> None:
    def act(dialog) -> None:
        key(dialog, KEY.Key_S)
        assert dialog.view.cut is not None
        click(dialog, place_on(dialog, 0, 0.25))
        assert len(dialog.steps.now.strokes.strokes) == 4
        assert dialog.chosen == 0
        key(dialog, KEY.Key_J)
        assert dialog.view.other == 1
        key(dialog, KEY.Key_Return)
        assert len(dialog.steps.now.strokes.strokes) == 3
        key(dialog, KEY.Key_S)
        for _ in range(6):
            key(dialog, KEY.Key_Right)
        key(dialog, KEY.Key_Return)
        use(dialog)

    correct(window, act)
    lengths = np.linalg.norm(ways(window), axis=1)
    np.testing.assert_allclose(lengths[0] / lengths[1], 3.0, rtol=0.15)
    assert len(lengths) == 4


def test_pen_and_finger_choose_and_the_wheel_zooms(window, drawing) -> None:
    screen = QtTest.QTest.createTouchDevice()

    def act(dialog) -> None:
        there = place_on(dialog, 2)
        pen(dialog.view, KIND.TabletPress, there.x(), there.y(), 0.5)
        pen(dialog.view, KIND.TabletRelease, there.x(), there.y(), 0.0)
        live(0.05)
        by_pen = dialog.chosen
        there = place_on(dialog, 1).toPoint()
        finger = QtTest.QTest.touchEvent(dialog.view, screen)
        finger.press(0, there, dialog.view).commit()
        finger.release(0, there, dialog.view).commit()
        live(0.05)
        by_finger = dialog.chosen
        scale, at = dialog.view.scale, dialog.view.pixel(QtCore.QPointF(there))
        wheel = QtGui.QWheelEvent(
            QtCore.QPointF(there), dialog.view.mapToGlobal(QtCore.QPointF(there)),
            QtCore.QPoint(), QtCore.QPoint(0, 240), BUTTON.NoButton,
            QtCore.Qt.KeyboardModifier.NoModifier, QtCore.Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QtWidgets.QApplication.sendEvent(dialog.view, wheel)
        zoomed = dialog.view.scale / scale
        held = dialog.view.pixel(QtCore.QPointF(there))
        use(dialog)
        assert (by_pen, by_finger) == (2, 1)
        assert zoomed > 1.3
        np.testing.assert_allclose(held, at)

    correct(window, act)


def test_what_is_drawn_shows_what_is_left_out(window, drawing) -> None:
    """In the middle of a stroke's region, beside its line, its colour goes when it is left out."""

    def act(dialog) -> None:
        def colours() -> list[QtGui.QColor]:
            picture = dialog.view.grab().toImage()
            scale = picture.devicePixelRatio()
            beside = QtCore.QPointF(0.0, 8.0)
            return [
                picture.pixelColor((scale * (place_on(dialog, k, 0.3) + beside)).toPoint())
                for k in range(3)
            ]

        before = colours()
        assert len({colour.rgb() for colour in before}) == 3
        click(dialog, place_on(dialog, 1))
        key(dialog, KEY.Key_X)
        after = colours()
        assert before[1].hsvSaturationF() > 0.15
        assert after[1].hsvSaturationF() < 0.1
        assert after[2] == before[2]
        use(dialog)

    correct(window, act)
    assert len(ways(window)) == 2


def test_strokes_are_saved_in_a_file(window, drawing) -> None:
    def type_name(dialog) -> None:
        assert dialog.selectedFiles()[0].endswith("three.strokes.json")
        dialog.accept()

    def act(dialog) -> None:
        key(dialog, KEY.Key_R)
        answer(type_name, QtWidgets.QFileDialog)
        key(dialog, KEY.Key_S, CONTROL)
        dialog.reject()  # nothing is asked: it is saved

    correct(window, act)
    page = load_strokes(drawing.with_name("three.strokes.json"))
    first = page.pieces[0].glyph.strokes[0].median
    assert first[0, 0] > first[-1, 0]
    assert ways(window)[0][0] > 0.0  # what lies on the object stays


def test_corrections_are_not_dropped_unasked(window, drawing) -> None:
    seen = []

    def press(role):
        def act(box) -> None:
            next(b for b in box.buttons() if box.buttonRole(b) == role).click()

        return act

    def act(dialog) -> None:
        key(dialog, KEY.Key_R)
        for role in (Answer.RejectRole, Answer.DestructiveRole):
            answer(press(role), QtWidgets.QMessageBox)
            key(dialog, KEY.Key_Escape)
            live(0.05)
            seen.append(dialog.isVisible())

    before = ways(window)
    correct(window, act)
    assert seen == [True, False]
    np.testing.assert_allclose(ways(window), before)


def test_corners_are_dragged_and_the_strokes_found_anew(window, sheet) -> None:
    assert len(ways(window)) == 2

    def act(dialog) -> None:
        first, behind = dialog.steps.now, dialog.view.behind
        key(dialog, KEY.Key_C)
        view = dialog.corners
        assert view.isVisible()
        for k, corner in ((0, (20.0, 150.0)), (1, (285.0, 150.0))):
            start, end = view.place(*view.corners[k]), view.place(*corner)
            mouse(view, KIND.MouseButtonPress, start.x(), start.y(), BUTTON.LeftButton,
                  BUTTON.LeftButton)  # fmt: skip
            mouse(view, KIND.MouseMove, end.x(), end.y(), buttons=BUTTON.LeftButton)
            mouse(view, KIND.MouseButtonRelease, end.x(), end.y(), BUTTON.LeftButton)
        np.testing.assert_allclose(view.corners[:2], [(20.0, 150.0), (285.0, 150.0)], atol=0.6)
        key(dialog, KEY.Key_Right)
        np.testing.assert_allclose(view.corners[1], (286.0, 150.0), atol=0.6)
        key(dialog, KEY.Key_Return)
        wait_for(lambda: dialog.steps.now is not first)
        assert len(dialog.steps.now.strokes.strokes) == 1
        found = dialog.view.behind.size
        key(dialog, KEY.Key_Z, CONTROL)
        assert found != behind.size
        assert dialog.steps.now is first
        assert dialog.view.behind.size == behind.size
        key(dialog, KEY.Key_Y, CONTROL)
        assert dialog.view.behind.size == found
        use(dialog)

    correct(window, act)
    assert len(ways(window)) == 1

    def look(dialog) -> None:
        np.testing.assert_allclose(
            dialog.steps.now.sheet.corners[:2], [(20.0, 150.0), (286.0, 150.0)], atol=0.6
        )
        dialog.reject()

    correct(window, look)


def test_corners_that_show_no_sheet_stay_to_be_mended(window, sheet) -> None:
    told: list[str] = []

    def read(box) -> None:
        told.append(box.text())
        box.accept()

    def act(dialog) -> None:
        key(dialog, KEY.Key_C)
        crossed = dialog.corners.corners[[1, 0, 2, 3]]
        dialog.corners.show_corners(crossed)
        answer(read, QtWidgets.QMessageBox)
        key(dialog, KEY.Key_Return)
        wait_for(lambda: told)
        live(0.05)
        assert dialog.corners.isVisible()
        np.testing.assert_array_equal(dialog.corners.corners, crossed)
        assert dialog.buttons["corners"].isChecked()
        key(dialog, KEY.Key_Escape)
        assert dialog.view.isVisible()
        assert not dialog.is_changed
        dialog.reject()

    correct(window, act)
    assert "corners" in told[0]


def test_another_correction_ends_a_join_that_was_begun(window, drawing) -> None:
    def act(dialog) -> None:
        key(dialog, KEY.Key_J)
        for other in (1, 2, 1):  # never itself
            assert dialog.view.other == other
            key(dialog, KEY.Key_Right)
        key(dialog, KEY.Key_R)
        assert dialog.view.other is None
        assert not dialog.buttons["join"].isChecked()
        key(dialog, KEY.Key_Z, CONTROL)
        key(dialog, KEY.Key_J)
        click(dialog, place_on(dialog, 0))
        assert "itself" in dialog.message_label.text()
        assert dialog.view.other == 1
        key(dialog, KEY.Key_Escape)
        use(dialog)

    correct(window, act)
    assert len(ways(window)) == 3


def test_what_is_used_as_it_was_lies_as_it_lay(window, drawing) -> None:
    """And what was written after it stays judged."""
    before = window.panels.copybook.copybook
    correct(window, use)
    assert window.panels.copybook.copybook is before


def test_a_drag_moves_the_picture_and_keys_show_it_from_near(window, drawing) -> None:
    def act(dialog) -> None:
        view, chosen = dialog.view, dialog.chosen
        scale, there = view.scale, place_on(dialog, 2)
        x, y = there.x(), there.y()
        mouse(view, KIND.MouseButtonPress, x, y, BUTTON.LeftButton, BUTTON.LeftButton)
        mouse(view, KIND.MouseMove, x + 40.0, y - 25.0, buttons=BUTTON.LeftButton)
        mouse(view, KIND.MouseButtonRelease, x + 40.0, y - 25.0, BUTTON.LeftButton)
        moved = place_on(dialog, 2) - there
        assert (moved.x(), moved.y()) == pytest.approx((40.0, -25.0))
        assert dialog.chosen == chosen
        key(dialog, KEY.Key_Plus)
        assert view.scale == pytest.approx(1.25 * scale)
        key(dialog, KEY.Key_Minus)
        key(dialog, KEY.Key_Minus)
        assert view.scale == pytest.approx(scale / 1.25)
        key(dialog, KEY.Key_0)
        assert view.scale == pytest.approx(scale)
        assert place_on(dialog, 2) == there
        use(dialog)

    correct(window, act)


def test_numbers_cover_no_other() -> None:
    """And of many only near ones are looked at."""
    rng = np.random.default_rng(20)
    taken, there = LabelGrid(), []
    for x, y in rng.uniform(-60.0, 60.0, (200, 2)):
        is_free = all(np.hypot(x - a, y - b) > 18.0 for a, b in there)
        assert taken.is_free(QtCore.QPointF(x, y)) == is_free
        if is_free:
            taken.add(QtCore.QPointF(x, y))
            there.append((x, y))
    assert len(there) > 10


def test_a_corner_goes_by_one_pixel_or_ten_and_not_off_the_picture(window, sheet) -> None:
    def act(dialog) -> None:
        key(dialog, KEY.Key_C)
        corners = dialog.corners
        before = corners.corners.copy()
        key(dialog, KEY.Key_3)
        key(dialog, KEY.Key_Up)
        key(dialog, KEY.Key_Left, QtCore.Qt.KeyboardModifier.ShiftModifier)
        np.testing.assert_allclose(corners.corners - before, [[0, 0], [0, 0], [-10, -1], [0, 0]])
        key(dialog, KEY.Key_W)
        assert not dialog.whole.isEnabled()
        assert not dialog.whole.isChecked()
        for _ in range(3):
            key(dialog, KEY.Key_Right, QtCore.Qt.KeyboardModifier.ShiftModifier)
        assert corners.corners[2, 0] == 300.0
        key(dialog, KEY.Key_Escape)
        assert not dialog.is_changed
        dialog.reject()

    correct(window, act)


def test_ink_far_from_its_box_is_seen(window, drawing, tmp_path: Path) -> None:
    file = tmp_path / "off.strokes.json"
    page = open_page(str(drawing))
    save_strokes(page, file)
    told = json.loads(file.read_text(encoding="utf-8"))
    for piece in told["pieces"]:
        piece["box"] = [8000.0, 8000.0, 9000.0, 9000.0]
    file.write_text(json.dumps(told), encoding="utf-8")
    assert window.copying.layout_file(str(file), 5.0)

    def act(dialog) -> None:
        room = QtCore.QRectF(dialog.view.rect())
        assert all(room.contains(place_on(dialog, k)) for k in range(3))
        use(dialog)

    correct(window, act)


def test_known_characters_have_no_picture_to_correct(window) -> None:
    assert window.copying.layout_text("永", 30.0, True)
    assert not window.panels.copybook.correct_button.isEnabled()


def test_kept_strokes_lie_over_their_photograph_again(window, sheet) -> None:
    """Which is laid flat as it was; its corners can still be dragged."""
    kept = sheet.with_name("two.strokes.json")

    def keep(dialog) -> None:
        answer(lambda asked: asked.accept(), QtWidgets.QFileDialog)
        key(dialog, KEY.Key_R)
        key(dialog, KEY.Key_S, CONTROL)
        seen.append(pixels_of(dialog.view))
        use(dialog)

    def look(dialog) -> None:
        assert len(dialog.steps.now.strokes.strokes) == 2
        seen.append(pixels_of(dialog.view))
        key(dialog, KEY.Key_C)
        view = dialog.corners
        start, end = view.place(*view.corners[0]), view.place(20.0, 150.0)
        mouse(
            view, KIND.MouseButtonPress, start.x(), start.y(), BUTTON.LeftButton, BUTTON.LeftButton
        )
        mouse(view, KIND.MouseMove, end.x(), end.y(), buttons=BUTTON.LeftButton)
        mouse(view, KIND.MouseButtonRelease, end.x(), end.y(), BUTTON.LeftButton)
        key(dialog, KEY.Key_Return)
        assert dialog.steps.now.strokes.base.photograph.corners[0, 1] == pytest.approx(150.0, abs=2)
        use(dialog)

    seen: list[np.ndarray] = []
    correct(window, keep)
    assert window.copying.layout_file(str(kept), 30.0)
    correct(window, look)
    assert np.abs(seen[0] - seen[1]).mean() < 0.5, np.abs(seen[0] - seen[1]).mean()


def test_a_photograph_that_is_gone_is_told(window, sheet) -> None:
    kept = sheet.with_name("two.strokes.json")

    def keep(dialog) -> None:
        answer(lambda asked: asked.accept(), QtWidgets.QFileDialog)
        key(dialog, KEY.Key_S, CONTROL)
        dialog.reject()

    def look(dialog) -> None:
        assert dialog.corners is None
        dialog.reject()

    told: list[str] = []
    correct(window, keep)
    sheet.unlink()
    window.workspace.said.connect(lambda text, *_: told.append(text))
    assert window.copying.layout_file(str(kept), 30.0)
    assert any("two.png: there is no such file" in text for text in told), told
    correct(window, look)


def test_which_photograph_a_file_of_strokes_asks_for_is_told(window, sheet, tmp_path) -> None:
    """By its own place; and none is read that is not named as a picture, whatever it is."""

    def look(dialog) -> None:
        seen.append(dialog.corners)
        dialog.reject()

    told: list[str] = []
    seen: list[object] = []
    page = window.panels.copybook.copybook.page
    kept, elsewhere = tmp_path / "two.strokes.json", tmp_path / "elsewhere.png"
    sheet.rename(elsewhere)
    sheet.symlink_to(elsewhere)
    (tmp_path / "secret").write_bytes(elsewhere.read_bytes())
    window.workspace.said.connect(lambda text, *_: told.append(text))
    for name, is_shown in (("two.png", True), ("secret", False), (f"{300 * 'a'}.png", False)):
        photograph = replace(page.photograph, file=tmp_path / name)
        save_strokes(replace(page, photograph=photograph), kept)
        told.clear()
        assert window.copying.layout_file(str(kept), 30.0)
        correct(window, look)
        assert (seen.pop() is not None) is is_shown
        assert any((str(elsewhere) if is_shown else name) in text for text in told), told


def test_a_photograph_that_was_replaced_is_not_shown_below_old_strokes(
    window, sheet, tmp_path
) -> None:
    """By one of the same size, in which the sheet's corners might lie."""
    told: list[str] = []
    kept = tmp_path / "two.strokes.json"
    save_strokes(window.panels.copybook.copybook.page, kept)
    Image.open(sheet).transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(sheet)
    window.workspace.said.connect(lambda text, *_: told.append(text))
    assert window.copying.layout_file(str(kept), 30.0)
    assert any(sheet.name in text for text in told), told

    def look(dialog) -> None:
        assert dialog.corners is None
        dialog.reject()

    correct(window, look)


def test_corrections_whose_laying_was_cancelled_are_kept(window, drawing, monkeypatch) -> None:
    """And offered again, to be undone too; until they lie there, or are dropped."""
    started, go_on = threading.Event(), threading.Event()

    class Slow(Copybook):
        def __init__(self, *given) -> None:
            started.set()
            go_on.wait(5.0)
            super().__init__(*given)

    def cancel(bar) -> None:
        assert started.is_set()
        QtTest.QTest.mouseClick(bar.findChild(QtWidgets.QPushButton), BUTTON.LeftButton)

    def reverse(dialog) -> None:
        key(dialog, KEY.Key_R)
        answer_bar(cancel)
        use(dialog)

    def again(dialog) -> None:
        assert dialog.is_changed
        key(dialog, KEY.Key_Z, CONTROL)
        assert not dialog.is_changed
        key(dialog, KEY.Key_Y, CONTROL)
        use(dialog)

    def drop(dialog) -> None:
        assert not dialog.is_changed
        dialog.reject()

    before = ways(window)
    with monkeypatch.context() as slow:
        slow.setattr(copybook_guide, "Copybook", Slow)
        correct(window, reverse)
    go_on.set()
    np.testing.assert_allclose(ways(window), before)
    correct(window, again)
    np.testing.assert_allclose(ways(window)[0], -before[0], atol=0.1)
    correct(window, drop)  # they lie there: nothing is left to be used


def test_corrections_that_could_not_be_laid_belong_to_their_page(window, drawing, monkeypatch):
    """Dropped they are not offered again, and never over another page."""
    told: list[str] = []

    def fail(*_) -> None:
        raise InputError("there is no room")

    def reverse(dialog) -> None:
        assert not dialog.is_changed
        key(dialog, KEY.Key_R)
        use(dialog)

    def fail_to_lay() -> None:
        with monkeypatch.context() as failing:
            failing.setattr(copybook_guide, "Copybook", fail)
            failing.setattr(window.workspace, "quiet", True)
            correct(window, reverse)

    def drop(dialog) -> None:
        assert dialog.is_changed
        answer(lambda box: drop_button(box).click(), QtWidgets.QMessageBox)
        key(dialog, KEY.Key_Escape)

    window.workspace.said.connect(lambda text, *_: told.append(text))
    fail_to_lay()
    assert "The corrections are kept; check the strokes again" in told
    answer(lambda box: box.reject(), QtWidgets.QMessageBox)
    assert not window.close(), "they would be lost"
    answer(lambda box: drop_button(box).click(), QtWidgets.QMessageBox)
    assert window.copying.may_drop()
    correct(window, drop)
    assert window.copying.may_drop()
    fail_to_lay()
    other = drawing.with_name("one.svg")
    other.write_text(SVG.replace('<path d="M5 5H55"/>', ""), encoding="utf-8")
    drop_them = [
        lambda: window.opening.open_path("plane", asked=True),
        lambda: window.copying.layout_file(str(other), 30.0),
        lambda: window.copying.layout_text("永", 30.0, True),
        window.copying.hide,
    ]
    for drop_by in drop_them:
        answer(lambda box: box.reject(), QtWidgets.QMessageBox)
        assert not drop_by()
        assert window.panels.copybook.copybook.page is not None, "they are there as they were"
    answer(lambda box: drop_button(box).click(), QtWidgets.QMessageBox)
    assert window.copying.layout_file(str(other), 30.0)

    def look(dialog) -> None:
        assert not dialog.is_changed
        assert len(dialog.steps.now.strokes.strokes) == 2
        dialog.reject()

    correct(window, look)
    fail_to_lay()
    answer(lambda box: drop_button(box).click(), QtWidgets.QMessageBox)
    window.copying.hide()
    left = window.panels.copybook.copybook  # a text that was laid before is shown again
    assert left is None or left.page is None
    assert window.copying.may_drop(), "nobody is asked twice"


def test_another_painting_drops_what_could_not_be_laid(window, drawing, monkeypatch) -> None:
    """Once it was asked for; of the next one nothing is left that nobody can look at."""

    def reverse(dialog) -> None:
        key(dialog, KEY.Key_R)
        use(dialog)

    def fail(*_) -> None:
        raise InputError("there is no room")

    with monkeypatch.context() as failing:
        failing.setattr(copybook_guide, "Copybook", fail)
        failing.setattr(window.workspace, "quiet", True)
        correct(window, reverse)
    answer(lambda box: drop_button(box).click(), QtWidgets.QMessageBox)
    assert window.opening.open_path("plane", asked=True)
    assert window.panels.copybook.copybook is None
    assert window.copying.may_drop(), "nobody is asked twice"


def test_strokes_of_a_rubbing_are_found_anew_as_such(window, sheet, monkeypatch) -> None:
    page, asked = window.panels.copybook.copybook.page, []
    rubbing = replace(page, photograph=replace(page.photograph, invert=True))
    save_strokes(rubbing, sheet.with_name("two.strokes.json"))
    look = copying.copy_sheet

    def watched(pixels, name, how) -> copying.CopiedSheet:
        asked.append(how)
        return look(pixels, name, replace(how, invert=False))

    monkeypatch.setattr(copying, "copy_sheet", watched)
    assert window.copying.layout_file(str(sheet.with_name("two.strokes.json")), 30.0)

    def act(dialog) -> None:
        key(dialog, KEY.Key_C)
        key(dialog, KEY.Key_1)
        key(dialog, KEY.Key_Right, QtCore.Qt.KeyboardModifier.ShiftModifier)
        key(dialog, KEY.Key_Return)
        assert [how.invert for how in asked] == [True]
        assert dialog.steps.now.sheet.page.photograph.invert
        dialog.done(0)

    correct(window, act)


def test_steps_are_undone_and_done_again() -> None:
    steps = CorrectionSteps("a")
    assert (steps.can_undo, steps.can_redo) == (False, False)
    steps.undo()
    steps.take("b")
    steps.take("c")
    steps.undo()
    steps.undo()
    assert (steps.now, steps.can_undo, steps.can_redo) == ("a", False, True)
    steps.redo()
    assert steps.now == "b"
    steps.take("d")
    steps.redo()
    assert (steps.now, steps.can_redo) == ("d", False)

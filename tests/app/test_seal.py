"""A seal on a document: a step like any other, for undo, sessions, scores and journals."""

from __future__ import annotations

import numpy as np
import pytest

import paint3d
from paint3d.app.model.commands import encode_command, replay_command
from paint3d.app.model.document import Document
from paint3d.app.model.mask import AngleMask, Mask
from paint3d.app.model.score.playing import painted
from paint3d.colour.pigments import load_pigment
from paint3d.errors import InputError, LayerError
from paint3d.recording.score import load_score, save_score
from tests.support.app.hands import paint, small_plane

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PySide6 import QtCore, QtGui, QtTest, QtWidgets

from tests.support.app.gestures import BUTTON, KIND, answer, live, mouse, type_key, wait_for
from tests.support.app.pointers import Touching, move_view, places
from tests.support.app.windows import opened, settled

RINGS = [[[-6, -6], [6, -6], [6, 6], [-6, 6]], [[-5, -5], [5, -5], [5, 5], [-5, 5]],
         [[-3, -1], [3, -1], [3, 1], [-3, 1]]]  # fmt: skip
HERE, UP = [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]


@pytest.fixture
def document() -> Document:
    made = Document.new(small_plane().surface.source, 0.5, "xuan")
    paint(made, (-15, 0), (15, 0))
    return made


def state(document: Document):
    surface = document.surface
    return surface.srgb.copy(), surface.painted_coverage(), surface.wet_ink(), surface.dry_ink()


def same(one, other) -> None:
    n = min(len(one[0]), len(other[0]))
    for a, b in zip(one[:2], other[:2], strict=True):
        np.testing.assert_array_equal(a[:n], b[:n])
    np.testing.assert_allclose(one[2:], other[2:], rtol=1e-9)


def test_a_seal_can_be_undone_and_done_again(document: Document) -> None:
    document.press_seal(RINGS, HERE, UP)
    document.undo()
    before = state(document)
    document.redo()
    after = state(document)
    assert document.steps.done[-1] == "seal"
    red = after[0].astype(int)
    assert ((red[:, 0] > 1.6 * red[:, 1]) & (after[1] > 0.9)).sum() > 50
    document.undo()
    same(before, state(document))


def test_it_lies_on_what_was_painted_and_its_paste_is_counted(document: Document) -> None:
    wet = document.surface.wet_ink()
    document.press_seal(RINGS, HERE, UP)
    accounts = document.painter.ledger()
    loaded = accounts.pop("loaded")
    assert sum(accounts.values()) == pytest.approx(loaded, rel=1e-6)
    assert accounts["wet"] < wet  # what was below has dried
    middle = int(np.argmin(np.linalg.norm(document.surface.mesh.vertices, axis=1)))
    r, g, _ = document.surface.srgb[middle].astype(int)
    assert r > 1.5 * g  # a full coat of vermilion over black ink


def test_sessions_keep_it_with_its_step(document: Document, tmp_path) -> None:
    document.press_seal(RINGS, HERE, UP, seed=7)
    document.save(tmp_path / "a.p3d")
    again = Document.open(tmp_path / "a.p3d")
    same(state(document), state(again))
    assert again.refused_history is None
    again.undo()
    document.undo()
    same(state(document), state(again))


def test_a_score_repeats_it_to_the_bit(document: Document, tmp_path) -> None:
    document.press_seal(RINGS, HERE, UP, {"cinnabar": 2.0, "minium": 1.0}, coats=0.8, wear=2.0)
    assert document.score is not None
    save_score(document.score, tmp_path / "a.jsonl")
    again = painted(load_score(tmp_path / "a.jsonl"), small_plane().surface.source)
    np.testing.assert_array_equal(again.surface.srgb, document.surface.srgb)


def test_a_journal_repeats_it(document: Document) -> None:
    other = Document.new(small_plane().surface.source, 0.5, "xuan")
    note = encode_command(other, "press_seal", [RINGS, HERE, UP], {"seed": 3})
    replay_command(other, note)
    assert other.steps.done == ["seal"]
    assert other.surface.painted.any()


def test_masks_and_layers_are_heeded(document: Document) -> None:
    document.surface.column_of(load_pigment("cinnabar"))  # what comes later colours all anew
    document.set_mask(Mask(AngleMask((0.0, 0.0, -1.0), 30.0)))  # nothing faces down
    before = state(document)
    document.press_seal(RINGS, HERE, UP)
    same(before, state(document))
    document.set_mask(Mask())
    document.set_locked(0)
    with pytest.raises(LayerError):
        document.press_seal(RINGS, HERE, UP)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (([], HERE), "a seal of 0 rings"),
        (([[[0, 0], [1, 1]]], HERE), "expected rings of three"),
        (([[[0, 0], [0, 0], [0, 0]]], HERE, UP), "go around no area"),
        ((RINGS, HERE, (0, 0, 1)), "along the surface's normal"),
        ((RINGS, HERE, UP, {}), "the paste is empty"),
        ((RINGS, HERE, UP, "cinnabar", 0.0), "coats"),
    ],
)
def test_what_cannot_be_pressed_is_said(document: Document, given, words: str) -> None:
    steps = list(document.steps.done)
    with pytest.raises(InputError, match=words):
        document.press_seal(*given)
    assert document.steps.done == steps


def test_no_wet_ink_is_lost_below_it(document: Document) -> None:
    """What is dipped for is the paste alone, on wet ink as on bare paper."""
    bare = Document.new(small_plane().surface.source, 0.5, "xuan")
    paint(bare, (-15, 0), (15, 0))
    bare.undo()  # the same vertices, without ink
    paste = []
    for one in (document, bare):
        before = one.painter.loaded
        one.press_seal(RINGS, HERE, UP)
        paste.append(one.painter.loaded - before)
    assert paste[0] == pytest.approx(paste[1], rel=0.01)


def test_it_is_not_pressed_within_a_stroke(document: Document) -> None:
    document.begin_stroke()
    with pytest.raises(InputError, match="a seal"):
        document.press_seal(RINGS, HERE, UP)
    document.end_stroke()


def test_what_was_undone_only_to_look_at_it_is_there_below_a_seal(document: Document) -> None:
    document.replay_history(0, passing=True)
    assert len(document.strokes) == 0
    document.press_seal(RINGS, HERE, UP)
    assert len(document.strokes) == 1
    document.undo()
    assert document.surface.painted.any()


def test_a_seal_is_edited_while_one_looks_at_what_was_before_it(document: Document) -> None:
    document.press_seal(RINGS, HERE, UP)
    paint(document, (-15, 6), (15, 6))
    document.replay_history(0)
    document.edit_seal(0, {"do": "delete"})
    assert len(document.strokes) == 2
    assert document.pressed_seals() == []


# -- by the hand, in the window ----------------------------------------------------------------


@pytest.fixture(scope="module")
def sheet(program):
    """A window with a sheet in it."""
    with opened(program, resolution=0.8, drawn=False) as window:
        yield window


@pytest.fixture
def window(sheet):
    """It with nothing on the sheet."""
    while sheet.document.can_undo:
        sheet.stage.paint_thread.post("undo").result(300)
    settled(sheet)
    return sheet


def type_text(text: str, style: str = ""):
    """What deals with the dialog: types a text, chooses a style, and accepts."""

    def fill(dialog: QtWidgets.QDialog) -> None:
        dialog.drawing.clear()  # which the dialog keeps
        dialog.text.selectAll()
        event = QtGui.QInputMethodEvent()  # as the system's input method commits it
        event.setCommitString(text)
        QtWidgets.QApplication.sendEvent(dialog.text, event)
        if style:
            dialog.style_box.setCurrentIndex(dialog.style_box.findData(style))
        box = dialog.findChild(QtWidgets.QDialogButtonBox)
        QtTest.QTest.mouseClick(
            box.button(QtWidgets.QDialogButtonBox.StandardButton.Ok), BUTTON.LeftButton
        )

    return fill


def click(canvas, x: float, y: float) -> None:
    place = x * canvas.width(), y * canvas.height()
    mouse(canvas, KIND.MouseMove, *place)
    mouse(canvas, KIND.MouseButtonPress, *place, BUTTON.LeftButton, BUTTON.LeftButton)
    mouse(canvas, KIND.MouseButtonRelease, *place, BUTTON.LeftButton)


def ask(window, text: str, style: str = "") -> None:
    answer(type_text(text, style))
    window.workspace.actions["seal"].trigger()
    wait_for(lambda: window.sealing.seal is not None)


def test_a_seal_is_pressed_where_one_clicks_and_is_one_step(window) -> None:
    ask(window, "永", "baiwen")
    assert window.sealing.seal.style == "baiwen"
    click(window.canvas, 0.5, 0.5)
    wait_for(lambda: window.document.steps.done == ["seal"])
    settled(window)
    surface = window.document.surface
    where = surface.mesh.vertices[surface.painted_coverage() > 0.5]
    middle = 0.5 * (where.min(axis=0) + where.max(axis=0))
    np.testing.assert_allclose(middle, window.hand.place(), atol=1.0)
    assert np.ptp(where[:, 0]) == pytest.approx(16.0, abs=1.2)
    assert len(window.document.strokes) == 0  # the click painted nothing
    wait_for(lambda: "Seal pressed" in window.status.message_label.text())
    type_key(window.canvas, QtCore.Qt.Key.Key_Z, QtCore.Qt.KeyboardModifier.ControlModifier)
    wait_for(lambda: not window.document.surface.painted.any())


def test_escape_lets_it_be_and_the_next_click_paints(window) -> None:
    ask(window, "永")
    type_key(window.canvas, QtCore.Qt.Key.Key_Escape)
    assert window.sealing.seal is None
    click(window.canvas, 0.5, 0.5)
    settled(window)
    live(0.1)
    assert "seal" not in window.document.steps.done


def test_a_press_beside_the_object_turns_it_and_the_seal_waits(window) -> None:
    ask(window, "永")
    click(window.canvas, 0.02, 0.02)
    settled(window)
    assert window.sealing.seal is not None
    assert window.document.steps.done == []
    window.sealing.let_be()


@pytest.mark.parametrize("finger", ["auto", "turn"])
def test_a_finger_presses_it_too_and_paints_nothing(window, finger) -> None:
    window.canvas.finger = finger
    ask(window, "永")
    with Touching(window.canvas) as fingers:
        fingers.drag({1: places(window, (0.5, 0.5), (0.52, 0.5))})
    wait_for(lambda: window.document.steps.done == ["seal"])
    settled(window)
    assert len(window.document.strokes) == 0
    assert window.canvas.tool is None


def test_two_fingers_move_the_view_and_the_seal_waits(window) -> None:
    camera = window.hand.camera
    ask(window, "永")
    move_view(window)
    settled(window)
    assert window.hand.camera is not camera
    assert window.sealing.seal is not None
    assert window.document.steps.done == []
    window.hand.look(camera)
    window.sealing.let_be()


def test_the_rest_of_a_drag_paints_nothing_after_esc(window) -> None:
    canvas = window.canvas
    ask(window, "永")
    (x, y), end = places(window, (0.4, 0.5), (0.6, 0.5))
    mouse(canvas, KIND.MouseButtonPress, x, y, BUTTON.LeftButton, BUTTON.LeftButton)
    canvas.setFocus()
    type_key(canvas, QtCore.Qt.Key.Key_Escape)
    assert window.sealing.seal is None
    for share in np.linspace(0.1, 1.0, 8):
        mouse(canvas, KIND.MouseMove, *((1 - share) * np.array([x, y]) + share * end),
              BUTTON.NoButton, BUTTON.LeftButton)  # fmt: skip
    mouse(canvas, KIND.MouseButtonRelease, *end, BUTTON.LeftButton)
    settled(window)
    assert window.document.steps.done == []


def test_a_stroke_that_goes_on_when_it_is_asked_for_is_painted_to_its_end(window) -> None:
    canvas = window.canvas
    (x, y), end = places(window, (0.4, 0.5), (0.6, 0.5))
    mouse(canvas, KIND.MouseButtonPress, x, y, BUTTON.LeftButton, BUTTON.LeftButton)
    ask(window, "永")
    mouse(canvas, KIND.MouseMove, *end, BUTTON.NoButton, BUTTON.LeftButton)
    mouse(canvas, KIND.MouseButtonRelease, *end, BUTTON.LeftButton)
    settled(window)
    assert len(window.document.strokes) == 1
    assert not window.hand.in_stroke
    assert window.sealing.seal is not None
    window.sealing.let_be()


def test_one_tool_lets_the_other_be(window) -> None:
    drag, canvas = window.editing.drag, window.canvas
    steers = canvas.mode_at
    ask(window, "永")
    drag.begin()
    assert window.sealing.seal is None
    assert drag.is_on
    ask(window, "永")
    assert not drag.is_on
    assert canvas.mode_at == steers
    window.sealing.let_be()
    assert canvas.tool is None


def reds(surface) -> np.ndarray:
    """Where there is cinnabar, (N, 3) mm."""
    codes = surface.srgb.astype(int)
    return surface.mesh.vertices[codes[:, 0] - codes[:, 1] > 60]


def test_the_dialog_shows_the_stone_and_says_what_cannot_be_cut(window) -> None:
    seen = []

    def red_share(dialog) -> float:
        """How much of the picture's middle row is red."""
        image = dialog.picture.pixmap().toImage()
        pixels = [image.pixelColor(x, image.height() // 2) for x in range(image.width())]
        return sum(one.red() - one.green() > 60 for one in pixels) / max(1, len(pixels))

    def look(dialog) -> None:
        dialog.text.setText("永和")
        for style, low, high in (("zhuwen", 0.03, 0.5), ("baiwen", 0.5, 0.97)):
            dialog.style_box.setCurrentIndex(dialog.style_box.findData(style))
            wait_for(lambda low=low, high=high: low < red_share(dialog) < high)
        assert "16 mm" in dialog.note.text()
        dialog.text.setText("永和九年歲")
        wait_for(lambda: dialog.picture.pixmap().isNull() and "5" in dialog.note.text())
        seen.append(True)
        dialog.reject()

    answer(look)
    window.workspace.actions["seal"].trigger()
    wait_for(lambda: seen)


def test_its_outline_lies_under_the_pointer_in_its_true_size(window) -> None:
    ask(window, "永")
    shown = {}
    window.stage.show_lines, plain = (
        lambda name, lines, *how: shown.update({name: lines}) or plain(name, lines, *how),
        window.stage.show_lines,
    )
    try:
        place = 0.5 * window.canvas.width(), 0.5 * window.canvas.height()
        mouse(window.canvas, KIND.MouseMove, *place)
        points = np.concatenate(shown["seal"])
        assert np.ptp(points[:, 0]) == pytest.approx(16.0, abs=0.05)
        middle = window.hand.place_at(*place)
        np.testing.assert_allclose(
            0.5 * (points.min(axis=0) + points.max(axis=0))[:2], middle[:2], atol=0.1
        )
        assert not window.stage.shows_brush
        type_key(window.canvas, QtCore.Qt.Key.Key_Escape)
        assert not len(shown["seal"])
        assert window.stage.shows_brush
    finally:
        del window.stage.show_lines


def test_a_seal_in_the_history_is_moved_inked_and_deleted(window) -> None:
    history = window.panels.history
    ask(window, "永")
    click(window.canvas, 0.5, 0.5)
    wait_for(lambda: window.document.steps.done == ["seal"])
    settled(window)
    wait_for(lambda: history.seals.count() == 1)
    assert history.seals.item(0).text() == "Seal 1"
    before = reds(window.document.surface).mean(axis=0)
    history.seal_edited.emit("drag", 0)
    assert window.sealing.seal is not None
    click(window.canvas, 0.6, 0.5)
    wait_for(lambda: "Seal 1 is changed" in window.status.message_label.text())
    settled(window)
    after = reds(window.document.surface).mean(axis=0)
    assert after[0] - before[0] > 5.0
    window.workspace.dip("pine soot")
    settled(window)
    history.seal_edited.emit("ink", 0)
    wait_for(lambda: not len(reds(window.document.surface)))
    settled(window)
    assert window.document.surface.painted.any()
    history.seal_edited.emit("delete", 0)
    wait_for(lambda: not window.document.surface.painted.any())
    settled(window)
    wait_for(lambda: history.seals.count() == 0)
    for _ in range(3):
        window.stage.paint_thread.post("undo").result(300)
    np.testing.assert_allclose(reds(window.document.surface).mean(axis=0), before, atol=1e-6)


def test_a_small_seal_is_sharp_on_a_coarse_sheet() -> None:
    surface = paint3d.PaintedSurface(paint3d.load_mesh("plane"), 0.8, "xuan")
    paint3d.Painter(surface, ink="cinnabar").seal("永和九年", at=(0.5, 0.5), size=10.0)
    share = surface.painted_coverage()
    vertices = surface.mesh.vertices
    under = (np.abs(vertices[:, :2]) < 5.0).all(axis=1)
    assert np.sqrt(100.0 / under.sum()) < 0.1  # mm from vertex to vertex
    inked = share[under & (share > 0.02)]
    assert (inked > 0.9).mean() > 0.5  # paste or paper, little between


def test_a_drawing_that_is_none_is_said(window, monkeypatch) -> None:
    told = []
    monkeypatch.setattr(QtWidgets.QMessageBox, "warning", lambda *words: told.append(words[-1]))
    monkeypatch.setattr(window.workspace, "quiet", False)

    def fill(dialog) -> None:
        dialog.drawing.setText("/nowhere/logo.svg")
        dialog.accept()

    answer(fill)
    window.workspace.actions["seal"].trigger()
    wait_for(lambda: told)
    assert "logo.svg" in told[0]
    assert window.sealing.seal is None

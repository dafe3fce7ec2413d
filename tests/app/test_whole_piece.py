"""Pieces from beginning to end, as somebody goes who has read nothing: by clicks and keys.

A scroll with a verse, a fan with bamboo in wet ink, a bowl with words all around it and a plum
inside; signed and sealed as the dialogs propose it, and taken as a picture.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtCore, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.window.files.exporting import ExportDialog
from paint3d.app.window.object.new_dialog import NewDialog
from paint3d.app.window.seal import SealDialog
from paint3d.core.arrays import AnyArray
from tests.support.app.gestures import (
    KIND,
    answer,
    click_button,
    drag,
    mouse,
    take_file,
    type_key,
    wait_for,
)
from tests.support.app.hands import same_vertices
from tests.support.app.windows import opened, pretend_saved, settled

KEY = QtCore.Qt.Key
CONTROL, SHIFT = (
    QtCore.Qt.KeyboardModifier.ControlModifier,
    QtCore.Qt.KeyboardModifier.ShiftModifier,
)


@pytest.fixture
def window(program, few_pixels):
    """A window with something else in it, of somebody whose name is not known."""
    with opened(program, "plane", 8.0, "porcelain", drawn=False) as window:
        window.workspace.update_settings(exports={}, signer="", wet=None)
        yield window
        pretend_saved(window.stage.paint_thread)


def begin(window, name: str, material: str = "") -> None:
    """Choose what to paint on; what it is of as proposed, where nothing is said."""

    def choose(dialog: NewDialog) -> None:
        dialog.choose(name)
        dialog.resolution.setValue(1.5)
        if material:
            dialog.material.setCurrentIndex(dialog.material.findData(material))
        click_button(dialog, "Begin")

    answer(choose, NewDialog)
    type_key(window.canvas, KEY.Key_N, CONTROL)
    wait_for(lambda: window.document.surface.source.name.startswith(name))
    settled(window)


def lay_out(window, text: str) -> None:
    """Type a text over what is proposed, which is chosen, and lay it out."""
    count = len(window.document.texts)
    window.workspace.actions["lay_out"].trigger()
    window.panels.copybook.text.insertPlainText(text)
    click_button(window.panels.copybook, "Lay out")
    wait_for(lambda: len(window.document.texts) == count + 1)


def write(window, *, breaks_up: bool = False) -> None:
    """Have the brush write the chosen text, also one too small for vertices so far apart."""
    count = len(window.document.strokes)
    if breaks_up:
        answer(lambda box: click_button(box, "Write it so"), QtWidgets.QMessageBox)
    click_button(window.panels.copybook, "Write it with the brush")
    wait_for(lambda: len(window.document.strokes) == count + 1 and not window.player.is_playing)
    settled(window)


def sign(window) -> None:
    """Type a name over what stands for it in the signature."""
    count = len(window.document.texts)

    def name(dialog: QtWidgets.QInputDialog) -> None:
        edit = dialog.findChild(QtWidgets.QLineEdit)
        wait_for(lambda: edit.selectedText() == "□□")
        edit.insert("山人")
        dialog.accept()

    answer(name)
    click_button(window.panels.copybook, "Signature and date…")
    wait_for(lambda: len(window.document.texts) == count + 1)
    settled(window)


def press_seal(window) -> None:
    """Press the seal that is proposed, where it is proposed."""
    asked = []
    answer(lambda dialog: (asked.append(dialog.asked().text), dialog.accept()), SealDialog)
    click_button(window.panels.copybook, "Press a seal…")
    wait_for(lambda: window.sealing.seal is not None)
    type_key(window.canvas, KEY.Key_Return)
    wait_for(lambda: window.document.pressed_seals())
    settled(window)
    assert asked == ["山人"]


def take_picture(window, path: Path) -> AnyArray:
    """The picture that Export proposes, (H, W, 3) codes; paper around a fan's is white."""

    def name(dialog: QtWidgets.QFileDialog) -> None:
        take_file(path)(dialog)
        answer(lambda dialog: dialog.accept(), ExportDialog)

    answer(name, QtWidgets.QFileDialog)
    type_key(window.canvas, KEY.Key_E, CONTROL)
    wait_for(path.exists)
    with Image.open(path) as picture:
        whole = Image.new("RGBA", picture.size, "white")
        whole.alpha_composite(picture.convert("RGBA"))
        return np.array(whole.convert("RGB")).astype(int)


def reds(pixels: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Rows and columns of a seal's pixels."""
    rows, columns = (pixels[..., 0] - pixels[..., 1] > 60).nonzero()
    return rows, columns


def test_a_signed_scroll_comes_about_by_what_each_dialog_proposes(window, tmp_path: Path) -> None:
    window.workspace.update_settings(wet=False)
    begin(window, "scroll:60x200")
    assert window.workspace.painting.material.name == "xuan"
    lay_out(window, "一，十。")
    assert window.document.texts[0].text.replace("\n", "") == "一十"
    write(window)
    sign(window)
    write(window, breaks_up=True)
    press_seal(window)
    pixels = take_picture(window, tmp_path / "scroll.png")
    assert pixels.shape[0] / pixels.shape[1] == pytest.approx(200 / 60, rel=0.01)
    rows, columns = reds(pixels)
    black = (pixels.max(axis=2) < 90).nonzero()
    assert len(black[0]) > 125
    assert rows.mean() > black[0].mean()  # the seal stands low
    assert columns.mean() < black[1].mean()  # and to the left


def test_a_seal_waits_in_the_hand_while_the_brush_writes(window, monkeypatch) -> None:
    """Then it is said again how to press it; where Enter does is shown wherever the pointer is."""
    shown = {}
    draw = window.stage.show_lines

    def note(name: str, lines, *how) -> None:
        shown[name] = list(lines)
        draw(name, lines, *how)

    monkeypatch.setattr(window.stage, "show_lines", note)
    window.workspace.update_settings(wet=False)
    begin(window, "scroll:60x200")
    lay_out(window, "一")
    click_button(window.panels.copybook, "Write it with the brush")
    wait_for(lambda: window.player.is_playing)
    window.player.pause(True)
    answer(lambda dialog: dialog.accept(), SealDialog)
    click_button(window.panels.copybook, "Press a seal…")
    wait_for(lambda: window.sealing.seal is not None)
    type_key(window.canvas, KEY.Key_Return)
    assert "still writing" in window.status.message_label.text()
    window.player.pause(False)
    wait_for(lambda: len(window.document.strokes) == 1 and not window.player.is_playing)
    assert "Enter presses" in window.status.message_label.text()
    beside = len(shown["seal"])
    mouse(window.canvas, KIND.MouseMove, 2.0, 2.0)
    assert len(shown["seal"]) == beside > 0
    mouse(window.canvas, KIND.MouseMove, 0.5 * window.canvas.width(), 0.5 * window.canvas.height())
    assert len(shown["seal"]) == 2 * beside
    type_key(window.canvas, KEY.Key_Return)
    wait_for(lambda: window.document.pressed_seals())


@pytest.mark.usefixtures("wet_at_first")
def test_a_fan_with_bamboo_in_wet_ink_is_signed_sealed_and_kept(window, tmp_path: Path) -> None:
    begin(window, "fan:240x80:margin=5", "xuan")
    assert window.stage.paint_thread.wet
    for low, high in (((0.3, 0.6), (0.33, 0.5)), ((0.335, 0.48), (0.36, 0.38))):  # a culm
        drag(window.canvas, low, high)
    type_key(window.canvas, KEY.Key_N, CONTROL | SHIFT)
    wait_for(lambda: len(window.document.layers) == 2)
    for tip in ((0.45, 0.42), (0.44, 0.5), (0.3, 0.46)):  # leaves
        drag(window.canvas, (0.35, 0.45), tip)
    settled(window)
    type_key(window.canvas, KEY.Key_Z, CONTROL)
    wait_for(lambda: len(window.document.strokes) == 4)
    type_key(window.canvas, KEY.Key_Z, CONTROL | SHIFT)
    wait_for(lambda: len(window.document.strokes) == 5)
    sign(window)
    before = window.copying.chosen_text().book.lines
    middle = window.hand.pixels_of(window.copying.chosen_text().book.block.frame.origin[None])[0]
    start = middle / [window.canvas.width(), window.canvas.height()]
    drag(window.canvas, start, start + np.array([0.2, 0.04]))
    wait_for(lambda: window.document.texts[0].point is not None)
    settled(window)
    assert window.copying.chosen_text().book.lines == before
    type_key(window.canvas, KEY.Key_Escape)
    write(window, breaks_up=True)
    press_seal(window)
    type_key(window.canvas, KEY.Key_W, SHIFT)  # all of it dries
    settled(window)
    pixels = take_picture(window, tmp_path / "fan.png")
    _, columns = reds(pixels)
    black = (pixels.max(axis=2) < 90).nonzero()
    half = pixels.shape[1] // 2
    assert np.count_nonzero(black[1] < half) > 200  # the bamboo
    assert np.count_nonzero(black[1] > half) > 20  # the signature
    assert columns.min() > half
    path = tmp_path / "fan.p3d"
    window.document.save(path)
    again = Document.open(path)
    same_vertices(again.surface, window.document.surface)
    assert len(again.strokes) == 6
    assert again.pressed_seals()


def test_a_bowl_has_a_name_all_around_and_a_plum_inside(window) -> None:
    begin(window, "bowl")
    panel = window.panels.copybook
    panel.around_box.setChecked(True)
    panel.em.setValue(16.0)
    lay_out(window, "山人")
    write(window, breaks_up=True)
    surface = window.document.surface
    places, written = surface.paint_mesh.vertices, surface.painted.copy()
    turns = np.degrees(np.arctan2(places[written, 1], places[written, 0]))
    assert np.ptp(turns) > 170.0  # one on each side
    window.workspace.actions["look_top"].trigger()
    settled(window)
    drag(window.canvas, (0.45, 0.55), (0.55, 0.45))
    settled(window)
    assert len(window.document.strokes) == 2
    plum = surface.painted[: len(written)] & ~written
    assert np.hypot(*places[: len(written)][plum][:, :2].T).max() < 50.0
    normals = surface.paint_mesh.normals[: len(written)][plum]
    assert normals[:, 2].min() > 0.0  # on the bowl's inside

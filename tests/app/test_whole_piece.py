"""A piece from its beginning to its end, as somebody goes who has read nothing: by clicks and keys.

A sheet, a verse, who signs, a seal below, a picture; each as its dialog proposes it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("PySide6", reason="PySide6 is not installed")

from PIL import Image
from PySide6 import QtCore, QtWidgets

from paint3d.app.window.files.exporting import ExportDialog
from paint3d.app.window.object.new_dialog import NewDialog
from paint3d.app.window.seal import SealDialog
from tests.support.app.gestures import answer, click_button, take_file, type_key, wait_for
from tests.support.app.windows import opened, settled

KEY, CONTROL = QtCore.Qt.Key, QtCore.Qt.KeyboardModifier.ControlModifier


@pytest.mark.usefixtures("few_pixels")
def test_a_signed_scroll_comes_about_by_what_each_dialog_proposes(program, tmp_path: Path) -> None:
    with opened(program, "plane", 8.0, "porcelain", drawn=False) as window:
        panel = window.panels.copybook
        window.workspace.update_settings(exports={}, signer="", wet=False)

        def choose(dialog: NewDialog) -> None:
            dialog.choose("scroll:60x200")
            dialog.resolution.setValue(1.5)
            click_button(dialog, "Begin")

        def write(count: int) -> None:
            click_button(panel, "Write it with the brush")
            wait_for(lambda: len(window.document.strokes) == count)
            settled(window)

        answer(choose, NewDialog)
        type_key(window.canvas, KEY.Key_N, CONTROL)
        wait_for(lambda: window.document.surface.source.name == "scroll:60x200")
        assert window.workspace.painting.material.name == "xuan"
        window.workspace.actions["lay_out"].trigger()
        panel.text.insertPlainText("一，十。")  # over what is proposed, which is chosen
        click_button(panel, "Lay out")
        wait_for(lambda: len(window.document.texts) == 1)
        assert window.document.texts[0].text.replace("\n", "") == "一十"
        write(1)

        def sign(dialog: QtWidgets.QInputDialog) -> None:
            edit = dialog.findChild(QtWidgets.QLineEdit)
            wait_for(lambda: edit.selectedText() == "□□")
            edit.insert("山人")
            dialog.accept()

        answer(sign)
        click_button(panel, "Signature and date…")
        wait_for(lambda: len(window.document.texts) == 2)
        write(2)
        asked = []
        answer(lambda dialog: (asked.append(dialog.asked().text), dialog.accept()), SealDialog)
        click_button(panel, "Press a seal…")
        wait_for(lambda: window.sealing.seal is not None)
        type_key(window.canvas, KEY.Key_Return)
        wait_for(lambda: window.document.pressed_seals())
        assert asked == ["山人"]

        def name(dialog: QtWidgets.QFileDialog) -> None:
            take_file(tmp_path / "scroll.png")(dialog)
            answer(lambda dialog: dialog.accept(), ExportDialog)

        answer(name, QtWidgets.QFileDialog)
        type_key(window.canvas, KEY.Key_E, CONTROL)
        wait_for((tmp_path / "scroll.png").exists)
        window.stage.paint_thread.post(lambda document: setattr(document, "modified", False))
    with Image.open(tmp_path / "scroll.png") as picture:
        assert picture.height / picture.width == pytest.approx(200 / 60, rel=0.01)
        pixels = np.array(picture.convert("RGB")).astype(int)
    red = (pixels[..., 0] - pixels[..., 1] > 60).nonzero()
    black = (pixels.max(axis=2) < 90).nonzero()
    assert len(black[0]) > 125
    assert red[0].mean() > black[0].mean()  # the seal stands low
    assert red[1].mean() < black[1].mean()  # and to the left

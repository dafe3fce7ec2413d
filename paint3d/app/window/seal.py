"""Seals: asked for in a dialog, then pressed where one clicks."""

from __future__ import annotations

from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.forms import FormDialog
from paint3d.app.window.hand.canvas import Touch
from paint3d.app.window.job import Progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.calligraphy.fonts.font_file import list_fonts
from paint3d.calligraphy.seal.stone import LARGEST_MM, SMALLEST_MM, Seal, cut_seal
from paint3d.core.arrays import AnyArray
from paint3d.errors import InputError
from paint3d.view.camera import picture_axes

__all__ = ["SealAsked", "SealDialog", "Sealing"]

# ---- The dialog ----------------------------------------------------------------------------------
# What is cut into a seal: a text or a drawing, its style and size.


class SealAsked(NamedTuple):
    """A seal as it is asked for: a text, or the path of a drawing."""

    text: str = "永和"
    drawing: str = ""
    style: str = "zhuwen"
    size_mm: float = 16.0
    font: str = ""


class SealDialog(FormDialog):
    """Ask for a seal.

    Parameters
    ----------
    parent : QWidget
    kept : SealAsked
        What was asked for last.
    """

    def __init__(self, parent: QtWidgets.QWidget, kept: SealAsked) -> None:
        super().__init__(parent, say("Press a seal…").rstrip("…"))
        self.text = QtWidgets.QLineEdit(kept.text)
        self.form.addRow(say("Text"), self.text)
        families = {"": say("Lines of one width")} | {name: name for name in _families()}
        self.font_box = self.add_box(say("Font"), families, kept.font)
        self.drawing = QtWidgets.QLineEdit(kept.drawing)
        self.drawing.setPlaceholderText(say("A drawing instead of the text"))
        self.drawing.setClearButtonEnabled(True)
        self.choose = QtWidgets.QPushButton("…")
        self.choose.clicked.connect(self._choose)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.drawing, 1)
        row.addWidget(self.choose)
        self.form.addRow("SVG", row)
        styles = {"zhuwen": say("Red lines (zhuwen)"), "baiwen": say("White lines (baiwen)")}
        self.style_box = self.add_box(say("Style"), styles, kept.style)
        self.size_box = self.add_number(
            say("Longer side"), SMALLEST_MM, LARGEST_MM, kept.size_mm, "mm", 1
        )
        self.finish(say("OK"))
        self.text.setFocus()
        self.text.selectAll()

    def _choose(self) -> None:
        dialog = QtWidgets.QFileDialog(self, say("A drawing"), filter="SVG (*.svg)")
        dialog.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
        if self.drawing.text():
            dialog.setDirectory(str(Path(self.drawing.text()).parent))
        if dialog.exec() and dialog.selectedFiles():
            self.drawing.setText(dialog.selectedFiles()[0])

    def asked(self) -> SealAsked:
        """What was asked for."""
        return SealAsked(
            self.text.text().strip(),
            self.drawing.text().strip(),
            self.style_box.currentData(),
            self.size_box.value(),
            self.font_box.currentData(),
        )


def _families() -> list[str]:
    """The families of the system's fonts; none where nobody can be asked."""
    try:
        return list(dict.fromkeys(font.family for font in list_fonts()))
    except InputError:
        return []


# --------------------------------------------------------------------------------------------------


_KIND = QtCore.QEvent.Type
_KEYS = (_KIND.ShortcutOverride, _KIND.KeyPress)
_LOOK_MS = 40


class Sealing(QtCore.QObject):
    """For one window.

    Attributes
    ----------
    seal : Seal or None
        What is pressed with the next click on the object.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace.window)
        self._workspace = workspace
        self._kept = SealAsked()
        self.seal: Seal | None = None
        self._is_down = False  # a pen, a mouse or a finger that presses it when it is lifted
        self._done: Future[Any] | None = None
        self._timer = QtCore.QTimer(self)
        self._timer.timeout.connect(self._follow)
        workspace.canvas.installEventFilter(self)
        workspace.canvas.taken_back.connect(self._drop)
        workspace.opened.connect(lambda _: self.let_be())

    def do_seal(self) -> None:
        """Ask for a seal, and let the next click on the object press it."""
        workspace = self._workspace
        self.let_be()
        dialog = SealDialog(workspace.window, self._kept)
        if not dialog.exec():
            return
        asked = self._kept = dialog.asked()
        if not asked.text and not asked.drawing:
            return

        def work(_: Progress) -> Seal:
            text = None if asked.drawing else asked.text
            drawing = asked.drawing or None
            font = asked.font or None
            return cut_seal(text, drawing, asked.style, asked.size_mm, font=font)

        done = workspace.run(say("Cutting the seal…"), work)
        if workspace.went_well(done):
            workspace.canvas.take_up(self._take, self.let_be)
            self.seal, self._is_down = done.result(), False
            workspace.canvas.setCursor(QtCore.Qt.CursorShape.PointingHandCursor)
            workspace.canvas.setFocus()
            workspace.tell(say("Click where to press the seal; Esc cancels"), stays=True)

    def let_be(self) -> None:
        """Press nothing."""
        if self.seal is not None:
            self.seal = None
            self._workspace.canvas.lay_down(self._take)
            self._workspace.canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)

    # -- the click --------------------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Let it be by Esc."""
        if self.seal is None or event.type() not in _KEYS:
            return False
        if not isinstance(event, QtGui.QKeyEvent) or event.key() != QtCore.Qt.Key.Key_Escape:
            return False
        event.accept()
        self.let_be()
        self._workspace.tell(say("No seal was pressed"))
        return True

    def _take(self, touch: Touch) -> bool:
        """Press it where a mouse, a pen or a finger is lifted; False while that is only over it."""
        was_down, self._is_down = self._is_down, touch.down
        if was_down and not touch.down:
            place = self._workspace.hand.place_at(touch.x, touch.y)
            if place is None:
                self._workspace.tell(say("That is beside the object"), state="bad")
            else:
                self._press(place)
        return was_down or touch.down

    def _drop(self) -> None:
        """Press nothing: what a finger began was the beginning of a gesture of several."""
        self._is_down = False

    def _press(self, place: AnyArray) -> None:
        """Press it there, upright in the picture."""
        workspace, seal = self._workspace, self.seal
        assert seal is not None
        up = picture_axes(workspace.hand.open_camera)[1]
        rings = [ring.tolist() for ring in seal.rings]
        self.let_be()
        self._done = workspace.paint_thread.post("press_seal", rings, place.tolist(), up.tolist())
        self._timer.start(_LOOK_MS)

    def _follow(self) -> None:
        """Say how much of it touched, once it is pressed; a fault is told as all are."""
        if self._done is None or not self._done.done():
            return
        self._timer.stop()
        done, self._done = self._done, None
        if not done.cancelled() and done.exception() is None:
            percent = 100.0 * done.result()
            message = say(
                "Seal pressed; {percent:.0f} % of it touched the surface", percent=percent
            )
            self._workspace.tell(message, state="good")

"""Seals: asked for in a dialog, then pressed where one clicks."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.files.file_dialogs import look_at_names_only
from paint3d.app.window.font_box import FontBox
from paint3d.app.window.forms import FormDialog
from paint3d.app.window.hand.canvas import Touch
from paint3d.app.window.job import JobProgress
from paint3d.app.window.wording import say, say_error, say_fonts, say_length
from paint3d.app.window.workspace import Workspace
from paint3d.calligraphy.fonts.fallback import FallbackGlyphs, with_fallback
from paint3d.calligraphy.glyph_sources import open_glyphs
from paint3d.calligraphy.seal.stone import (
    LARGEST_MM,
    MOST_CHARACTERS,
    SMALLEST_MM,
    Seal,
    cut_known,
    cut_seal,
)
from paint3d.core.arrays import AnyArray
from paint3d.errors import Paint3DError
from paint3d.mesh.chart import frame_at
from paint3d.view.camera import picture_axes

__all__ = ["ProposedSeal", "SealDialog", "SealOptions", "Sealing"]

# ---- The dialog ----------------------------------------------------------------------------------
# A seal's text or drawing, its style and size.


_PICTURE = 190  # pixels
_LOOK_MS = 40
_PATIENCE_S = 1.0  # that the window waits for a step of the painting
_RIM_POINTS = 12  # along a side of it
_LIFT_MM = 0.1  # of the outline above the surface
_Cut = tuple[Seal, dict[str, str]]
_PAPER, _CINNABAR = (243, 240, 230), (178, 44, 34)


class SealOptions(NamedTuple):
    """The options of a seal: a text, or the path of a drawing, and its style and size."""

    text: str = "永和"
    drawing: str = ""
    style: str = "zhuwen"
    size_mm: float = 16.0
    font: str = ""
    shape: str = "square"


class ProposedSeal(NamedTuple):
    """A seal proposed below a signature: its name, size and position."""

    name: str
    size_mm: float
    point: AnyArray
    """(3,) mm"""
    up: AnyArray
    """(3,)"""


class SealDialog(FormDialog):
    """Ask for a seal, and show its stone as it will be cut.

    Parameters
    ----------
    parent : QWidget
    options : SealOptions
        Of the last seal.
    glyphs : str
        A folder of characters, as the settings name it.
    """

    def __init__(self, parent: QtWidgets.QWidget, options: SealOptions, glyphs: str = "") -> None:
        super().__init__(parent, say("Press a seal…").rstrip("…"))
        self._glyphs = glyphs
        self._shown: SealOptions | None = None
        self._cutting: Future[_Cut] | None = None
        self.picture = QtWidgets.QLabel()
        self.picture.setFixedSize(_PICTURE + 60, _PICTURE + 8)
        self.picture.setAlignment(QtCore.Qt.AlignmentFlag.AlignCenter)
        self.picture.setAccessibleName(say("The seal as it will be cut"))
        self.note = QtWidgets.QLabel()
        self.note.setWordWrap(True)
        self.note.setObjectName("faint")
        self.form.addRow(self.picture)
        self.form.addRow(self.note)
        self.text = QtWidgets.QLineEdit(options.text)
        self.form.addRow(say("Text"), self.text)
        self.font_box = FontBox(say("Lines of one width"))
        self.font_box.show_font(options.font)
        self.form.addRow(say("Font"), self.font_box)
        self.drawing = QtWidgets.QLineEdit(options.drawing)
        self.drawing.setPlaceholderText(say("A drawing instead of the text"))
        self.drawing.setClearButtonEnabled(True)
        self.choose = QtWidgets.QPushButton("…")
        self.choose.clicked.connect(self._choose_drawing)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.drawing, 1)
        row.addWidget(self.choose)
        self.form.addRow("SVG", row)
        styles = {"zhuwen": say("Red lines (zhuwen)"), "baiwen": say("White lines (baiwen)")}
        self.style_box = self.add_box(say("Style"), styles, options.style)
        shapes = {
            "square": say("As wide as high"),
            "upright": say("Upright: one above the other"),
            "level": say("Level: side by side, from the right"),
        }
        self.shape_box = self.add_box(say("Shape"), shapes, options.shape)
        self.size_box = self.add_number(
            say("Longer side"), SMALLEST_MM, LARGEST_MM, options.size_mm, "mm", 1
        )
        self.finish(say("OK"))
        self.text.setFocus()
        self.text.selectAll()
        self._timer = QtCore.QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._follow)
        self._timer.start()

    def _choose_drawing(self) -> None:
        dialog = QtWidgets.QFileDialog(self, say("A drawing"), filter="SVG (*.svg)")
        dialog.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
        look_at_names_only(dialog)
        if self.drawing.text():
            dialog.setDirectory(str(Path(self.drawing.text()).parent))
        if dialog.exec() and dialog.selectedFiles():
            self.drawing.setText(dialog.selectedFiles()[0])

    def asked(self) -> SealOptions:
        """Return the chosen options."""
        return SealOptions(
            self.text.text().strip(),
            self.drawing.text().strip(),
            self.style_box.currentData(),
            self.size_box.value(),
            self.font_box.font_name,
            self.shape_box.currentData(),
        )

    # -- its picture ------------------------------------------------------------------------

    def _follow(self) -> None:
        """Cut the chosen seal in a thread of its own, and show the last one cut."""
        if self._cutting is not None:
            if not self._cutting.done():
                return
            done, self._cutting = self._cutting, None
            self._show(done)
        asked = self.asked()
        if asked != self._shown:
            self._shown = asked
            self._cutting = Future()
            work = (asked, self._glyphs, self._cutting)
            threading.Thread(
                target=_cut_beside, args=work, name="paint3d-seal", daemon=True
            ).start()

    def _show(self, done: Future[_Cut]) -> None:
        error = done.exception()
        if error is not None:
            self.picture.setPixmap(QtGui.QPixmap())
            self.note.setText(say_error(error) if isinstance(error, Paint3DError) else "")
            return
        seal, from_fonts = done.result()
        self.picture.setPixmap(seal_picture(seal, _PICTURE))
        size = f"{say_length(seal.width_mm)} × {say_length(seal.height_mm)}"
        self.note.setText(say("; ").join([size, *say_fonts(from_fonts)]))


def _signer_options(options: SealOptions, name: str, size_mm: float) -> SealOptions:
    """Return the options of a signer's seal of this size; those given stay where no name fits."""
    n = len("".join(name.split()))
    if options.shape != "square" and 1 <= n <= MOST_CHARACTERS:
        size_mm *= n
    size = min(max(round(2.0 * size_mm) / 2.0, SMALLEST_MM), LARGEST_MM)
    if not 1 <= n <= MOST_CHARACTERS:
        return options._replace(size_mm=size)
    return options._replace(text=name, drawing="", size_mm=size)


def _cut(asked: SealOptions, glyphs: str) -> _Cut:
    """Cut a seal; return it and the characters that fonts stand in for, with the fonts' names."""
    how = asked.style, asked.size_mm
    if asked.drawing:
        return cut_seal(None, asked.drawing, *how), {}
    if asked.font:
        return cut_seal(asked.text, None, *how, shape=asked.shape, font=asked.font), {}
    source = with_fallback(open_glyphs(glyphs or None), asked.text)
    taken = source.characters if isinstance(source, FallbackGlyphs) else {}
    return cut_known(asked.text, source, *how, asked.shape), taken


def _cut_beside(asked: SealOptions, glyphs: str, done: Future[_Cut]) -> None:
    try:
        done.set_result(_cut(asked, glyphs))
    except Exception as error:
        done.set_exception(error)


def seal_picture(seal: Seal, size: int) -> QtGui.QPixmap:
    """Draw a seal's print, in cinnabar on paper, its longer side so many pixels."""
    scale = size / max(seal.width_mm, seal.height_mm)
    wide, high = (max(1, round(scale * mm)) for mm in (seal.width_mm, seal.height_mm))
    pixels = QtGui.QPixmap(wide + 8, high + 8)
    pixels.fill(QtGui.QColor(*_PAPER))
    painter = QtGui.QPainter(pixels)
    painter.setRenderHint(QtGui.QPainter.RenderHint.Antialiasing)
    path = QtGui.QPainterPath()
    path.setFillRule(QtCore.Qt.FillRule.OddEvenFill)
    for ring in seal.rings:
        at = ring * [scale, -scale] + [0.5 * wide + 4.0, 0.5 * high + 4.0]
        path.addPolygon(QtGui.QPolygonF([QtCore.QPointF(x, y) for x, y in at.tolist()]))
        path.closeSubpath()
    painter.fillPath(path, QtGui.QColor(*_CINNABAR))
    painter.end()
    return pixels


# ---- Pressing ------------------------------------------------------------------------------------


_KIND = QtCore.QEvent.Type
_KEYS = (_KIND.ShortcutOverride, _KIND.KeyPress)


class Sealing(QtCore.QObject):
    """Chooses a seal, and presses it where the object is clicked.

    Attributes
    ----------
    seal : Seal or None
        Pressed by the next click on the object.
    of_signature : callable
        The `ProposedSeal` of who signed the painting; None where there is no text.
    is_writing : callable
        Whether the brush paints by itself: the seal waits in the hand meanwhile.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace.window)
        self._workspace = workspace
        self._options = SealOptions()
        self._proposed: tuple[str, float] | None = None
        self.of_signature: Callable[[], ProposedSeal | None] = lambda: None
        self.is_writing: Callable[[], bool] = lambda: False
        self._proposed_at: ProposedSeal | None = None  # where Enter presses it
        self.seal: Seal | None = None
        self._moved: int | None = None  # the seal that is pressed elsewhere
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
        glyphs = workspace.settings.glyphs
        proposed = self.of_signature()
        if proposed is not None and proposed[:2] != self._proposed:
            self._proposed = proposed[:2]
            self._options = _signer_options(self._options, *proposed[:2])
        dialog = SealDialog(workspace.window, self._options, glyphs)
        if not dialog.exec():
            return
        asked = self._options = dialog.asked()
        if not asked.text and not asked.drawing:
            return

        done = workspace.run(say("Cutting the seal…"), lambda _: _cut(asked, glyphs))
        if workspace.went_well(done):
            self._moved = None
            self._take_up(done.result()[0], proposed)

    def edit(self, what: str, index: int) -> None:
        """Move a seal that was pressed, press it in the ink in hand, or delete it.

        Parameters
        ----------
        what : {"drag", "ink", "delete"}
        index : int
            From 0, among those that are there.
        """
        workspace = self._workspace
        self.let_be()
        if what == "ink":
            self._edit(index, {"do": "ink", "ink": workspace.painting.dipped})
            return
        if what == "delete":
            self._edit(index, {"do": "delete"})
            return
        with workspace.paint_thread.paused(_PATIENCE_S) as document:
            pressed = [] if document is None else document.pressed_seals()
        if not 0 <= index < len(pressed):
            workspace.tell(say("Still painting; try again in a moment"), state="slow")
            return
        rings = tuple(np.array(ring, np.float64) for ring in pressed[index]["rings"])
        size = np.ptp(np.concatenate(rings), axis=0).tolist()
        self._moved = index
        self._take_up(Seal("", "", size[0], size[1], rings, 0.0, ""))

    def _edit(self, index: int, edit: dict[str, Any]) -> None:
        workspace = self._workspace
        paint_thread = workspace.paint_thread

        def work(progress: JobProgress) -> None:
            with paint_thread.reporting(progress):
                paint_thread.post("edit_seal", index, edit).result()

        if workspace.went_well(workspace.run(say("Pressing the seal anew…"), work)):
            workspace.tell(
                say("Seal {n} is changed; undo takes it back", n=index + 1), state="good"
            )

    def _take_up(self, seal: Seal, proposed: ProposedSeal | None = None) -> None:
        """Take a stone into the hand until it is pressed, or let be."""
        workspace = self._workspace
        self._proposed_at = proposed
        workspace.canvas.take_up(self._take, self.let_be)
        self.seal, self._is_down = seal, False
        workspace.canvas.setCursor(QtCore.Qt.CursorShape.CrossCursor)
        self._hide_brush(True)
        workspace.canvas.setFocus()
        self._show_outline(None)
        self.say_how()

    def say_how(self) -> None:
        """Say how the stone in the hand is pressed, if there is one."""
        if self.seal is None:
            return
        message = say("Click where to press the seal; Esc cancels")
        if self._proposed_at is not None:
            message = say(
                "Enter presses the seal below the text; click to press it elsewhere; Esc cancels"
            )
        self._workspace.tell(message, stays=True)

    def let_be(self) -> None:
        """Put the stone away without pressing it."""
        if self.seal is not None:
            self.seal = None
            self._workspace.canvas.lay_down(self._take)
            self._hide_brush(False)
            self._show_outline(None)

    # -- the click --------------------------------------------------------------------------

    def eventFilter(self, watched: QtCore.QObject, event: QtCore.QEvent) -> bool:
        """Put the stone away by Esc, press it by Enter where that is proposed."""
        if self.seal is None or event.type() not in _KEYS:
            return False
        if not isinstance(event, QtGui.QKeyEvent):
            return False
        key = QtCore.Qt.Key
        if event.key() in (key.Key_Return, key.Key_Enter) and self._proposed_at is not None:
            event.accept()
            if event.type() == _KIND.KeyPress:
                self._press(self._proposed_at.point, self._proposed_at.up)
            return True
        if event.key() != key.Key_Escape:
            return False
        event.accept()
        self.let_be()
        self._workspace.tell(say("No seal was pressed"))
        return True

    def _hide_brush(self, away: bool) -> None:
        """Hide the brush while a stone is in the hand, or show it again where it is shown."""
        shown = self._workspace.actions["brush"].isChecked()
        self._workspace.stage.shows_brush = shown and not away
        self._workspace.stage.touch()

    def _show_outline(self, point: AnyArray | None) -> None:
        """Draw the outline of the stone's print, in its true size.

        It is drawn at a point (3,) of the object, and where Enter presses it.
        """
        stage, seal, proposed = self._workspace.stage, self.seal, self._proposed_at
        if stage.paint_thread is None:
            return
        lines: list[AnyArray] = []
        if seal is not None and proposed is not None:
            lines += self._print_of(seal, proposed.point, proposed.up)
        if seal is not None and point is not None:
            lines += self._print_of(seal, point, picture_axes(self._workspace.hand.open_camera)[1])
        stage.show_lines("seal", lines, (*_CINNABAR, 220), 1.3)

    def _print_of(self, seal: Seal, point: AnyArray, up: AnyArray) -> list[AnyArray]:
        """Return lines (N, 3) on the object along the rim and the rings of a print there."""
        surface = self._workspace.hand.surface
        frame = frame_at(surface, point, up)
        half = 0.5 * np.array([seal.width_mm, seal.height_mm])
        along = np.linspace(-1.0, 1.0, _RIM_POINTS)[:, None]
        ends = np.ones((_RIM_POINTS, 1))
        sides = [(along, -ends), (ends, along), (-along, ends), (-ends, -along)]
        rim = half * np.concatenate([np.hstack(side) for side in sides])
        lines = []
        for ring in (rim, *seal.rings):
            closed = np.concatenate([ring, ring[:1]])
            across = np.outer(closed[:, 0], frame.x_axis) + np.outer(closed[:, 1], frame.y_axis)
            hits = surface.find(frame.origin + across)
            lines.append(hits.points + _LIFT_MM * hits.normals)
        return lines

    def _take(self, touch: Touch) -> bool:
        """Press it where a mouse, a pen or a finger is lifted; show it where that is over it."""
        was_down, self._is_down = self._is_down, touch.down
        self._show_outline(self._workspace.hand.place_at(touch.x, touch.y))
        if was_down and not touch.down:
            point = self._workspace.hand.place_at(touch.x, touch.y)
            if point is None:
                self._workspace.tell(say("That is beside the object"), state="bad")
            else:
                self._press(point)
        return was_down or touch.down

    def _drop(self) -> None:
        """Press nothing: what a finger began was the beginning of a gesture of several."""
        self._is_down = False

    def _press(self, point: AnyArray, up: AnyArray | None = None) -> None:
        """Press it there, by default upright in the picture."""
        workspace, seal = self._workspace, self.seal
        assert seal is not None
        if self.is_writing():
            message = say("The brush is still writing; press the seal once it has finished")
            workspace.tell(message, state="slow", stays=True)
            return
        if up is None:
            up = picture_axes(workspace.hand.open_camera)[1]
        rings = [ring.tolist() for ring in seal.rings]
        moved = self._moved
        self.let_be()
        if moved is not None:
            self._edit(moved, {"do": "move", "at": point.tolist(), "up": up.tolist()})
            return
        workspace.tell(say("Pressing the seal…"), stays=True)
        self._done = workspace.paint_thread.post("press_seal", rings, point.tolist(), up.tolist())
        self._timer.start(_LOOK_MS)

    def _follow(self) -> None:
        """Say how much of it touched, once it is pressed; the painting thread reports a fault."""
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

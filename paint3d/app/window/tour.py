"""A short tour: painting, turning, ink, undo, and at its end the first stroke of 永."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from PySide6 import QtCore, QtWidgets

from paint3d.app.window.copybook.copybook_guide import CopybookGuide
from paint3d.app.window.files.opening import Opening
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["Tour"]

_SHEET, _RESOLUTION_MM, _MATERIAL = "sheet:200x200", 0.5, "xuan"
_TEXT, _EM_MM = "永", 110.0
_LOOK_MS = 200
_WIDTH, _BELOW = 440, 96  # pixels; from the canvas's lower edge
_TURNED = 0.02  # of the camera's distance


class _TourStep(NamedTuple):
    """A step: its text, and whether it is done."""

    text: str
    is_done: Callable[[], bool]


class Tour(QtWidgets.QFrame):
    """A card over the picture that follows what the hand does.

    Parameters
    ----------
    workspace : Workspace
    opening : Opening
        Begins the sheet that the tour is on.
    copying : CopybookGuide
        Lays the character at its end.
    """

    def __init__(self, workspace: Workspace, opening: Opening, copying: CopybookGuide) -> None:
        super().__init__(workspace.canvas)
        self._workspace, self._opening, self._copying = workspace, opening, copying
        self._steps: list[_TourStep] = []
        self._at = 0
        self.setObjectName("card")
        self.setCursor(QtCore.Qt.CursorShape.ArrowCursor)
        self.setFixedWidth(_WIDTH)
        self.message_label = QtWidgets.QLabel()
        self.message_label.setWordWrap(True)
        self.counted = QtWidgets.QLabel()
        self.counted.setObjectName("faint")
        self.next_button = QtWidgets.QPushButton(say("Next"))
        self.end_button = QtWidgets.QPushButton(say("End the tour"))
        self.next_button.clicked.connect(self._go_on)
        self.end_button.clicked.connect(self.end)
        column = QtWidgets.QVBoxLayout(self)
        column.setContentsMargins(20, 14, 20, 14)
        column.addWidget(self.message_label)
        row = QtWidgets.QHBoxLayout()
        row.addWidget(self.counted, 1)
        row.addWidget(self.next_button)
        row.addWidget(self.end_button)
        column.addLayout(row)
        self._timer = QtCore.QTimer(self, interval=_LOOK_MS)
        self._timer.timeout.connect(self._look)
        workspace.canvas.resized.connect(self._place)
        workspace.opened.connect(lambda _: self.end())
        self.hide()

    def do_tour(self) -> None:
        """Begin on a new sheet, after asking about the open painting."""
        if not self._opening.open_path(_SHEET, _RESOLUTION_MM, _MATERIAL):
            return
        workspace = self._workspace
        camera = workspace.hand.open_camera
        painting = workspace.painting

        def turned() -> bool:
            now = workspace.hand.open_camera
            distance = float(np.linalg.norm(camera.position - camera.focus))
            return float(np.linalg.norm(now.position - camera.position)) > _TURNED * distance

        self._steps = [
            _TourStep(
                say("Press and draw over the sheet: with a pen, a finger, or the left button."),
                lambda: bool(workspace.painting.strokes),
            ),
            _TourStep(
                say(
                    "Turn it: drag beside the sheet, or anywhere with Space held. The wheel comes "
                    "nearer, Home shows all again."
                ),
                turned,
            ),
            _TourStep(
                say(
                    "Take another ink: a click on a dish of Inks. V held and a drag waters it, "
                    "F held and a drag changes the brush's size, with Shift how hard a mouse "
                    "presses."
                ),
                lambda: list(workspace.painting.inks) != list(painting.inks),
            ),
            _TourStep(
                say("Ctrl+Z takes back what you did last, as far as you like."),
                lambda: bool(workspace.painting.undone_strokes),
            ),
            _TourStep(
                say(
                    "Now 永, eternity, which has all the strokes of kaishu. The first is the dot "
                    "at its top: press on its upper left, lead down to the right, and lift."
                ),
                self._is_traced,
            ),
        ]
        self._at = 0
        self._show()
        self._timer.start()

    def end(self) -> None:
        """Put the card away."""
        self._timer.stop()
        self._steps = []
        self.hide()

    @property
    def step(self) -> int | None:
        """The step that is shown, from 0; None where no tour is on."""
        return self._at if self._steps else None

    def _is_traced(self) -> bool:
        chosen = self._copying.chosen_text()
        return chosen is not None and any(ghost.strokes for ghost in chosen.book.ghosts)

    def _look(self) -> None:
        """Go on if the step is done, unless a stroke is being painted."""
        if not self._steps or self._workspace.stage.paint_thread is None:
            self.end()
        elif not self._workspace.hand.in_stroke and self._steps[self._at].is_done():
            self._go_on()

    def _go_on(self) -> None:
        if self._at + 1 == len(self._steps):
            self.end()
            self._workspace.tell(
                say("The tour is over: go on writing, or lay out a text of your own"), state="good"
            )
            return
        self._at += 1
        if self._at + 1 == len(self._steps):
            self._workspace.hand.show_all()
            self._copying.layout_text(_TEXT, _EM_MM, True)
        self._show()

    def _show(self) -> None:
        self.message_label.setText(self._steps[self._at].text)
        self.counted.setText(f"{self._at + 1} / {len(self._steps)}")
        self.adjustSize()
        self._place()
        self.show()
        self.raise_()

    def _place(self) -> None:
        canvas = self._workspace.canvas.rect()
        self.move(canvas.center().x() - self.width() // 2, canvas.bottom() - _BELOW - self.height())

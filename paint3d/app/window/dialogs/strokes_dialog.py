"""Strokes over the picture: looked at and corrected before they are written after or painted."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6 import QtCore, QtGui, QtWidgets

from paint3d.app.window.dialogs.corner_view import CornerView
from paint3d.app.window.dialogs.forms import buttons
from paint3d.app.window.dialogs.questions import Answer, ask
from paint3d.app.window.dialogs.stroke_view import Behind, ShownStroke, StrokeView
from paint3d.app.window.dialogs.target_dialog import Kind, ask_target
from paint3d.app.window.jobs.job import run_beside
from paint3d.app.window.theme import Theme
from paint3d.app.window.wording import say, say_error
from paint3d.calligraphy.page.correcting import CorrectedPage, Steps
from paint3d.calligraphy.page.page import Page
from paint3d.calligraphy.page.strokes_file import save_strokes
from paint3d.errors import Paint3DError

if TYPE_CHECKING:
    from paint3d.calligraphy.photo.copying import SheetPicture

__all__ = ["CorrectionState", "Photographed", "StrokesDialog"]

_REACH = 14.0  # pixels of the widget that a click may miss a stroke by
_STEPS = 24  # along a stroke, that the keys move a cut by
_KEY = QtCore.Qt.Key
_REDO = QtCore.QKeyCombination(QtCore.Qt.KeyboardModifier.ControlModifier, _KEY.Key_Y)
_SUFFIX = ".strokes.json"


class Photographed(NamedTuple):
    """A photograph that strokes are from.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
    sheet : SheetPicture
        What was found in it.
    find : callable
        Finds the strokes anew in a sheet of other corners (4, 2).
    """

    pixels: NDArray[np.uint8]
    sheet: SheetPicture
    find: Callable[[NDArray[np.float64]], SheetPicture]


class CorrectionState(NamedTuple):
    """What can be undone: the strokes, and the sheet that they lie on."""

    strokes: CorrectedPage
    sheet: SheetPicture | None


class StrokesDialog(QtWidgets.QDialog):
    """Correct the strokes of a page.

    Parameters
    ----------
    parent : QWidget
    theme : Theme
    page : Page
    photographed : Photographed, optional
        Where the page is a photograph's.
    beside : Path
        The file that was opened: what is saved is proposed beside it.
    steps : Steps, optional
        Corrections of before, to go on with.

    Attributes
    ----------
    view : StrokeView
    corners : CornerView or None
    steps : Steps
        What was corrected, to be undone.
    buttons : dict of str to QAbstractButton
        By their names in `_BUTTONS`.
    told : QLabel
        What is chosen, and what is expected next.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        theme: Theme,
        page: Page,
        photographed: Photographed | None = None,
        beside: Path | None = None,
        steps: Steps[CorrectionState] | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(say("Strokes over the picture…").rstrip("…"))
        self._theme, self._photo = theme, photographed
        self._beside = beside or Path.cwd() / "strokes"
        sheet = photographed.sheet if photographed is not None else None
        self.steps = steps or Steps(CorrectionState(CorrectedPage.of(page), sheet))
        self._kept = self.steps.first
        self._chosen: int | None = 0 if self._now.strokes else None
        self._mode = "choose"
        self._cut_at = 0.5
        self.view = StrokeView(theme, self._behind())
        self.view.setAccessibleName(self.windowTitle())
        self.view.clicked.connect(self._click)
        self.corners: CornerView | None = None
        self._views = QtWidgets.QStackedWidget()
        self._views.addWidget(self.view)
        if photographed is not None:
            self.corners = CornerView(theme, photographed.pixels)
            self._views.addWidget(self.corners)
        self.told = QtWidgets.QLabel()
        self.told.setWordWrap(True)
        self.buttons: dict[str, QtWidgets.QAbstractButton] = {}
        self._lay_out()
        room = parent.window().size()
        self.resize(max(room.width() - 60, 760), max(room.height() - 60, 480))
        self.view.setFocus()
        self._show()

    # -- what is made -----------------------------------------------------------------------

    @property
    def page(self) -> Page:
        """The page as it was corrected.

        Raises
        ------
        InputError
            If every stroke is left out.
        """
        return self._now.page()

    @property
    def is_changed(self) -> bool:
        """Whether strokes or sheet are not as they were."""
        is_other = self._photo is not None and self.steps.now.sheet is not self._photo.sheet
        return is_other or self._now.is_changed

    @property
    def photographed(self) -> Photographed | None:
        """The photograph with the sheet that counts now."""
        sheet = self.steps.now.sheet
        if self._photo is None or sheet is None:
            return None
        return self._photo._replace(sheet=sheet)

    @property
    def chosen(self) -> int | None:
        """Which stroke is chosen."""
        return self._chosen

    @property
    def _now(self) -> CorrectedPage:
        return self.steps.now.strokes

    def _behind(self) -> Behind:
        corrected, sheet = self.steps.now
        strokes = [one.stroke for one in corrected.strokes]
        if sheet is None:
            return Behind.of_page(corrected.base, strokes)
        return Behind.of_sheet(sheet, strokes)

    # -- layout -----------------------------------------------------------------------------

    def _lay_out(self) -> None:
        grid = QtWidgets.QGridLayout()
        grid.setSpacing(6)
        rows = (
            ("reverse", "leave out"), ("earlier", "later"), ("join", "split"), ("undo", "redo"),
        )  # fmt: skip
        for row, names in enumerate(rows):
            for column, name in enumerate(names):
                grid.addWidget(self._button(name), row, column)
        self.whole = QtWidgets.QCheckBox(f"{say('The whole piece')}  (W)")
        self.whole.setToolTip(say("Earlier, later and leave out take all strokes of its piece"))
        self.whole.setFocusPolicy(QtCore.Qt.FocusPolicy.TabFocus)
        self.whole.toggled.connect(lambda _: self._show())
        grid.addWidget(self.whole, len(rows), 0, 1, 2)
        side = QtWidgets.QVBoxLayout()
        side.addLayout(grid)
        if self.corners is not None:
            side.addWidget(self._button("corners"))
        side.addSpacing(6)
        side.addWidget(self.told)
        side.addStretch(1)
        side.addWidget(self._button("save"))
        box = buttons(self, say("Use"))
        self.use = box.button(QtWidgets.QDialogButtonBox.StandardButton.Ok)
        self.use.setToolTip(say("As ghosts on the object"))
        side.addWidget(box)
        panel = QtWidgets.QWidget()
        panel.setLayout(side)
        panel.setFixedWidth(276)
        side.setContentsMargins(0, 0, 0, 0)
        layout = QtWidgets.QHBoxLayout(self)
        layout.addWidget(self._views, 1)
        layout.addWidget(panel)

    def _button(self, name: str) -> QtWidgets.QPushButton:
        """One that keeps the keys with the picture when it is clicked."""
        text, key, what, checkable = _BUTTONS[name]
        button = QtWidgets.QPushButton(f"{say(text)}  ({key})" if key else say(text))
        button.setToolTip(say(what))
        button.setAutoDefault(False)
        button.setCheckable(checkable)
        button.setFocusPolicy(QtCore.Qt.FocusPolicy.TabFocus)
        button.clicked.connect(lambda _=False: self.do(name))
        self.buttons[name] = button
        return button

    # -- what is asked for ------------------------------------------------------------------

    def do(self, name: str) -> None:
        """Do what a button says, by its name: see `_BUTTONS`."""
        if not self.buttons[name].isEnabled():
            return
        if name in ("join", "split", "corners"):
            self._enter("choose" if self._mode == name else name)
            return
        acts: dict[str, Callable[[], None]] = {
            "reverse": self._reverse, "leave out": self._leave_out, "undo": self._undo,
            "redo": self._redo, "save": self.save, "earlier": lambda: self._move(-1),
            "later": lambda: self._move(1),
        }  # fmt: skip
        acts[name]()

    def _take(self, strokes: CorrectedPage, chosen: int | None = None) -> None:
        """Go on with corrected strokes; what else was begun is over."""
        self.steps.take(self.steps.now._replace(strokes=strokes))
        if chosen is not None:
            self._chosen = chosen
        self._enter("choose")

    def _reverse(self) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        self._take(self._now.reverse(self._chosen))

    def _leave_out(self) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        on = not self._now.strokes[self._chosen].is_left_out
        do = self._now.leave_out_piece if self.whole.isChecked() else self._now.leave_out
        self._take(do(self._chosen, on))

    def _move(self, by: int) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        do = self._now.move_piece if self.whole.isChecked() else self._now.move
        moved, at = do(self._chosen, by)
        if moved.strokes != self._now.strokes:
            self._take(moved, at)

    def _undo(self) -> None:
        self._step(self.steps.undo)

    def _redo(self) -> None:
        self._step(self.steps.redo)

    def _step(self, do: Callable[[], None]) -> None:
        sheet = self.steps.now.sheet
        do()
        if self.steps.now.sheet is not sheet:
            self.view.show_behind(self._behind())
        n = len(self._now.strokes)
        self._chosen = min(self._chosen or 0, n - 1) if n else None
        self._enter("choose")

    # -- joining, splitting, corners --------------------------------------------------------

    def _enter(self, mode: str) -> None:
        """Expect another thing with the next click.

        Strokes are found anew of corners that were dragged; where that fails these are still there.
        """
        if self._mode == "corners" and mode != "corners" and not self._find_anew():
            self._show()
            return
        self._mode = mode
        self._cut_at = 0.5
        self.view.other = None
        if mode == "join" and self._chosen is not None:
            self.view.other = (self._chosen + 1) % len(self._now.strokes)
        if mode == "corners" and self.corners is not None and self.steps.now.sheet is not None:
            self.corners.show_corners(self.steps.now.sheet.corners)
        shown = self.corners if mode == "corners" and self.corners is not None else self.view
        self._views.setCurrentWidget(shown)
        shown.setFocus()
        self._show()

    def _find_anew(self) -> bool:
        """Find the strokes of the sheet whose corners were dragged; whether that went well."""
        sheet = self.steps.now.sheet
        if self.corners is None or self._photo is None or sheet is None:
            return True
        corners, find = self.corners.corners.copy(), self._photo.find
        if np.abs(corners - sheet.corners).max() < 0.01:
            return True
        done = run_beside(self, say("Finding the strokes…"), lambda _: find(corners))
        error = done.exception()
        if error is None:
            found: SheetPicture = done.result()
            self.steps.take(CorrectionState(CorrectedPage.of(found.page), found))
            self._chosen = 0 if self._now.strokes else None
            self.view.show_behind(self._behind())
        elif isinstance(error, Paint3DError):
            QtWidgets.QMessageBox.warning(self, "paint3d", say_error(error))
        elif not isinstance(error, CancelledError):
            raise error
        return error is None

    def _click(self, x: float, y: float) -> None:
        """Choose the stroke there, join it, or cut there."""
        point = self.view.behind.units(x, y)
        reach = _REACH / self.view.scale / self.view.behind.per_unit
        found = self._now.stroke_at(point, reach)
        if self._mode == "split":
            self._split(point)
        elif found is not None and self._mode == "join":
            self._join(found)
        elif found is not None:
            self._chosen = found
            self._show()

    def _confirm(self) -> None:
        """Join or cut what is shown."""
        if self._mode == "join" and self.view.other is not None:
            self._join(self.view.other)
        elif self._mode == "split" and self.view.cut is not None:
            self._split(self.view.cut)
        elif self._mode == "corners":
            self._enter("choose")

    def _join(self, other: int) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        try:
            joined, at = self._now.join(self._chosen, other)
        except Paint3DError as error:
            self.told.setText(say_error(error))
        else:
            self._take(joined, at)

    def _split(self, point: NDArray[np.float64]) -> None:
        assert self._chosen is not None, "the button is off without a stroke"
        try:
            parts = self._now.split(self._chosen, point)
        except Paint3DError as error:
            self.told.setText(say_error(error))
        else:
            self._take(parts)

    def _step_along(self, by: int) -> None:
        """Another stroke, or another place of the cut."""
        n = len(self._now.strokes)
        if self._mode == "split":
            self._cut_at = min(max(self._cut_at + by / _STEPS, 1 / _STEPS), 1.0 - 1 / _STEPS)
        elif self._mode == "join" and self.view.other is not None:
            other = (self.view.other + by) % n
            self.view.other = (other + by) % n if other == self._chosen else other
        elif n:
            self._chosen = ((-1 if self._chosen is None else self._chosen) + by) % n
        self._show()

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Every button by its key; arrows choose; Return agrees, Escape leaves what was begun."""
        key, standard = _KEY(event.key()), QtGui.QKeySequence.StandardKey
        if event.matches(standard.Undo):
            self.do("undo")
        elif event.matches(standard.Redo) or event.keyCombination() == _REDO:
            self.do("redo")
        elif event.matches(standard.Save):
            self.do("save")
        elif self._mode != "choose" and key in (_KEY.Key_Return, _KEY.Key_Enter):
            self._confirm()
        elif self._mode != "choose" and key == _KEY.Key_Escape:
            self._leave()
        elif key in (_KEY.Key_Left, _KEY.Key_Right):
            self._step_along(1 if key == _KEY.Key_Right else -1)
        elif key == _KEY.Key_W:
            self.whole.click()
        elif key in _KEYS and _KEYS[key] in self.buttons and not _commands(event):
            self.do(_KEYS[key])
        else:
            super().keyPressEvent(event)

    def _leave(self) -> None:
        """Let go of what was begun; corners stay as they were."""
        if self._mode == "corners" and self.corners is not None and self.steps.now.sheet:
            self.corners.show_corners(self.steps.now.sheet.corners)
        self._enter("choose")

    def save(self) -> None:
        """Ask where, and write the strokes as a file."""
        name = self._beside.name
        stem = name.removesuffix(_SUFFIX) if name.endswith(_SUFFIX) else self._beside.stem
        start = self._beside.with_name(f"{stem}{_SUFFIX}")
        path = ask_target(self, say("Save the strokes"), start, [Kind(say("Strokes"), _SUFFIX)])
        if path is None:
            return
        try:
            save_strokes(self.page, path)
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(self, "paint3d", say_error(error))
        else:
            self._beside, self._kept = path, self.steps.now
            self.told.setText(say("status.exported", name=path.name))

    def reject(self) -> None:
        """Close it; corrections that are not in a file are asked for."""
        if self.steps.now is not self._kept:
            told = say("The corrections are not used and not saved")
            if ask(self, told, destroy="Drop them", warns=True) is not Answer.DestructiveRole:
                return
        super().reject()

    # -- what is shown ----------------------------------------------------------------------

    def _show(self) -> None:
        """Show the strokes, and which buttons can do something."""
        now, k = self._now, self._chosen
        self.view.show_strokes(
            [
                ShownStroke(one.stroke, number, one.is_left_out)
                for one, number in zip(now.strokes, now.numbers, strict=True)
            ]
        )
        self.view.chosen = k
        self.view.cut = None
        if self._mode == "split" and k is not None:
            self.view.cut = _along(now.strokes[k].stroke.median, self._cut_at)
        can = dict.fromkeys(self.buttons, self._mode != "corners" and k is not None)
        is_still = self._mode != "corners"
        can |= {
            "undo": self.steps.can_undo and is_still, "redo": self.steps.can_redo and is_still,
            "corners": True,
        }  # fmt: skip
        can["join"] &= len(now.strokes) > 1
        is_any = any(not one.is_left_out for one in now.strokes)
        can["save"] = is_any and is_still
        for name, button in self.buttons.items():
            button.setEnabled(can[name])
            if button.isCheckable():
                button.setChecked(self._mode == name)
        self.use.setEnabled(can["save"])
        self.whole.setEnabled(can["reverse"])
        is_out = k is not None and now.strokes[k].is_left_out
        key = _BUTTONS["leave out"][1]
        self.buttons["leave out"].setText(f"{say('Take in' if is_out else 'Leave out')}  ({key})")
        self.told.setText(self._words())
        self.view.update()

    def _words(self) -> str:
        """What is chosen, and what to do next."""
        k = self._chosen
        if k is None:
            return say("There are no strokes")
        if self._mode == "corners":
            return say(_HINTS[self._mode])
        number, count = self._now.number(k)
        told = say("{piece}: stroke {k} of {n}", piece=self._now.text(k), k=number, n=count)
        return f"{told}\n\n{say(_HINTS[self._mode])}"


_BUTTONS = {
    "reverse": ("Reverse", "R", "Write the stroke the other way", False),
    "leave out": ("Leave out", "X", "It is no stroke, or is to be written again", False),
    "earlier": ("Earlier", "PgUp", "Write it before the one before", False),
    "later": ("Later", "PgDn", "Write it after the next one", False),
    "join": ("Join", "J", "Make one stroke of this and another", True),
    "split": ("Split", "S", "Make two strokes of this, at a place", True),
    "undo": ("Undo", "Ctrl+Z", "Take the last correction back", False),
    "redo": ("Redo", "Ctrl+Y", "Correct it again", False),
    "corners": ("Corners of the sheet", "C", "Drag them, and find the strokes anew", True),
    "save": ("Save the strokes…", "Ctrl+S", "As a file that can be written and corrected", False),
}
"""Words, key, what it does, and whether it stays pressed."""

_KEYS = {
    _KEY.Key_R: "reverse", _KEY.Key_X: "leave out", _KEY.Key_PageUp: "earlier",
    _KEY.Key_PageDown: "later", _KEY.Key_J: "join", _KEY.Key_S: "split", _KEY.Key_C: "corners",
}  # fmt: skip

_HINTS = {
    "choose": "Click a stroke, or go through them by ← and →. Each begins at its number.",
    "join": "Click the stroke to join it to, or choose by ← and → and press Return.",
    "split": "Click where to split it, or move the cut by ← and → and press Return.",
    "corners": "Drag the corners of the sheet, or move one by the arrows (1 to 4 choose it). "
    "Return finds the strokes anew, Esc leaves them.",
}


def _commands(event: QtGui.QKeyEvent) -> bool:
    """Whether Ctrl or the like is held."""
    held = QtCore.Qt.KeyboardModifier
    return bool(event.modifiers() & (held.ControlModifier | held.AltModifier | held.MetaModifier))


def _along(line: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """The place so far along a line."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    return np.array([np.interp(share * way[-1], way, line[:, axis]) for axis in (0, 1)])

"""The page shown while nothing is open: ways to begin."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.persistence.recovery_folder import recoverable
from paint3d.app.window.files.opening import Opening
from paint3d.app.window.files.recovery import Recovery
from paint3d.app.window.files.saving import RecentFiles
from paint3d.app.window.wording import say, say_object
from paint3d.app.window.workspace import Workspace

__all__ = ["BeginPage"]

_WIDTH = 380
_MOST_RECENT = 5
_SHEET, _SHEET_MM = "sheet:340x680", 0.5


class BeginPage(QtWidgets.QFrame):
    """A card in the middle of the canvas: a new painting, a file, recent files."""

    def __init__(
        self, workspace: Workspace, opening: Opening, recovery: Recovery, recent: RecentFiles
    ) -> None:
        super().__init__(workspace.canvas)
        self._workspace, self._recovery = workspace, recovery
        self._opening, self._recent = opening, recent
        self.setObjectName("card")
        self.setCursor(QtCore.Qt.CursorShape.ArrowCursor)
        self.setFixedWidth(_WIDTH)
        self._rows = QtWidgets.QVBoxLayout(self)
        self._rows.setContentsMargins(22, 18, 22, 20)
        self._rows.setSpacing(8)
        self.buttons: list[QtWidgets.QPushButton] = []
        self.hide()
        recovery.discarded = self._fill_again

    def show_page(self, shown: bool) -> None:
        """Show the card with its current offers, or hide it."""
        if shown == self.isVisible():
            return
        if shown:
            self._fill()
            self.place()
        self.setVisible(shown)

    def place(self) -> None:
        """Move the card to the middle of the canvas."""
        self.adjustSize()
        self.move(self._workspace.canvas.rect().center() - self.rect().center())

    def _fill_again(self) -> None:
        """Update the offers, if the card is shown."""
        if self.isVisible():
            self.hide()
            self.show_page(True)

    def _fill(self) -> None:
        while self._rows.count():
            item = self._rows.takeAt(0)
            row = None if item is None else item.widget()
            if row is not None:
                row.deleteLater()
        self.buttons = []
        head = QtWidgets.QLabel(say("What will you paint on? Choose, or drop a file here"))
        head.setObjectName("title")
        head.setAlignment(QtCore.Qt.AlignmentFlag.AlignCenter)
        self._rows.addWidget(head)
        actions, begin = self._workspace.actions, self._opening.open_path
        self._add(say("A bowl"), partial(begin, "bowl", None, "porcelain"))
        self._add(say("A sheet of paper"), partial(begin, _SHEET, _SHEET_MM, "xuan"))
        self._add(say("Another sheet or object…"), actions["new"].trigger)
        self._add(say("An object of your own, or a painting…"), actions["open"].trigger)
        for name in ("sample", "tour"):
            self._add(actions[name].text(), actions[name].trigger)
        left = recoverable()
        if left:
            name = left[0].path.name if left[0].path else say_object(left[0].object_name)
            message = say("Recover unsaved work: {name}", name=name)
            self._add(message, lambda: self._recovery.recover(left[0]))
        recent = self._recent.paths()[:_MOST_RECENT]
        if recent:
            below = QtWidgets.QLabel(say("Open recent"))
            below.setObjectName("faint")
            self._rows.addWidget(below)
        for path in recent:
            opened = self._add(Path(path).name, partial(self._opening.open_path, path))
            opened.setToolTip(path)

    def _add(self, text: str, do: Callable[[], object]) -> QtWidgets.QPushButton:
        button = QtWidgets.QPushButton(text)
        button.clicked.connect(lambda _=False: do())
        self._rows.addWidget(button)
        self.buttons.append(button)
        return button

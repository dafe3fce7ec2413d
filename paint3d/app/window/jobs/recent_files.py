"""The files that were opened or saved last, and their menu."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.workspace import Workspace

__all__ = ["RecentFiles"]


class RecentFiles(QtCore.QObject):
    """For one window.

    Signals
    -------
    chosen : str
        The path of one that is to be opened.
    """

    chosen = QtCore.Signal(str)

    def __init__(self, workspace: Workspace, menu: QtWidgets.QMenu) -> None:
        super().__init__(workspace)
        self._workspace, self._menu = workspace, menu

    def add(self, path: str) -> None:
        """Put a file first."""
        self._workspace.keep(recent=self._workspace.settings.with_recent(path).recent)
        self.show()

    def show(self) -> None:
        """Fill the menu."""
        self._menu.clear()
        for path in self.paths():
            self._menu.addAction(Path(path).name, self._chooser(path))
        self._menu.setEnabled(bool(self._menu.actions()))

    def _chooser(self, path: str) -> Callable[[], None]:
        return lambda: self.chosen.emit(path)

    def paths(self) -> list[str]:
        """Those that are still there, the last opened first."""
        return [path for path in self._workspace.settings.recent if Path(path).exists()]

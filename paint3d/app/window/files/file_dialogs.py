"""Dialogs that ask for files; a folder that does not answer never blocks the window.

A look into a network folder that is gone blocks in the kernel. So a thread of its own looks, and is
abandoned if it does not return.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Sequence
from typing import Any

from PySide6 import QtCore, QtGui, QtWidgets

__all__ = ["NamesOnly", "answers", "ask_file", "look_at_names_only", "that_exist"]

_PATIENCE_S = 1.5


class NamesOnly(QtWidgets.QFileIconProvider):
    """Finds icons and kinds by file names alone: Qt's own provider opens files of unknown names.

    Reading a special file, as the kernel's log, may block for ever.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setOptions(self.Option.DontUseCustomDirectoryIcons)

    def icon(self, file: Any) -> QtGui.QIcon:
        """Return the plain icon of a folder or a file."""
        if isinstance(file, QtCore.QFileInfo):
            is_folder = file.isDir()
            return super().icon(self.IconType.Folder if is_folder else self.IconType.File)
        return super().icon(file)

    def type(self, file: QtCore.QFileInfo) -> str:
        """Return the kind of a folder, or of a file by its suffix."""
        if file.isDir():
            return super().type(file)
        by_name = QtCore.QMimeDatabase.MatchMode.MatchExtension
        return QtCore.QMimeDatabase().mimeTypeForFile(file.fileName(), by_name).comment()


_icons: list[NamesOnly] = []  # Qt does not own it


def look_at_names_only(dialog: QtWidgets.QFileDialog) -> None:
    """Keep a dialog from opening the files that it lists."""
    if not _icons:
        _icons.append(NamesOnly())
    dialog.setIconProvider(_icons[0])


def ask_file(parent: QtWidgets.QWidget, title: str, kinds: str, folder: str = "") -> str:
    """Ask for an existing file; empty for none.

    Parameters
    ----------
    parent : QWidget
    title : str
    kinds : str
        Name filters, parted by ``;;``.
    folder : str
        To begin in; by default the last one.
    """
    dialog = QtWidgets.QFileDialog(parent, title, folder)
    dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
    dialog.setNameFilters(kinds.split(";;"))
    look_at_names_only(dialog)
    chosen = dialog.selectedFiles() if dialog.exec() else []
    dialog.deleteLater()
    return chosen[0] if chosen else ""


def that_exist(paths: Sequence[str | os.PathLike[str]]) -> list[str]:
    """Return those of several files that exist, as far as their folders answer, in order."""
    exists = _look(paths)
    return [os.fspath(path) for path in paths if exists.get(os.fspath(path), False)]


def answers(path: str | os.PathLike[str]) -> bool:
    """Return whether a path's folder answers within a while, whatever the answer."""
    return os.fspath(path) in _look([path])


def _look(paths: Sequence[str | os.PathLike[str]]) -> dict[str, bool]:
    """Look whether each of several files exists; leave out those without an answer in time."""
    exists: dict[str, bool] = {}
    seekers = []
    for path in [os.fspath(path) for path in paths]:
        seeker = threading.Thread(
            target=lambda path=path: exists.update({path: _is_there(path)}), daemon=True
        )
        seeker.start()
        seekers.append(seeker)
    deadline = time.monotonic() + _PATIENCE_S
    for seeker in seekers:
        seeker.join(max(0.0, deadline - time.monotonic()))
    return dict(exists)


def _is_there(path: str) -> bool:
    return os.path.exists(path)

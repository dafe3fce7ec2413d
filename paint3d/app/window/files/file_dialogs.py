"""Dialogs that ask for files, and folders that do not answer: neither holds the window up.

A network folder that is gone stands in the kernel, and so does whoever looks into it. What might
lie there is looked at by a thread of its own, which is left to itself if it does not come back.
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
    """Says by the names of files what they are: Qt's own opens those whose names do not tell.

    Reading the kernel's log, for one, may wait for ever.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setOptions(self.Option.DontUseCustomDirectoryIcons)

    def icon(self, file: Any) -> QtGui.QIcon:
        """The plain icon of a folder or a file."""
        if isinstance(file, QtCore.QFileInfo):
            is_folder = file.isDir()
            return super().icon(self.IconType.Folder if is_folder else self.IconType.File)
        return super().icon(file)

    def type(self, file: QtCore.QFileInfo) -> str:
        """The kind of a folder, or of a file by its suffix."""
        if file.isDir():
            return super().type(file)
        by_name = QtCore.QMimeDatabase.MatchMode.MatchExtension
        return QtCore.QMimeDatabase().mimeTypeForFile(file.fileName(), by_name).comment()


_icons: list[NamesOnly] = []  # Qt does not keep it


def look_at_names_only(dialog: QtWidgets.QFileDialog) -> None:
    """Have a dialog open no file that it lists."""
    if not _icons:
        _icons.append(NamesOnly())
    dialog.setIconProvider(_icons[0])


def ask_file(parent: QtWidgets.QWidget, title: str, kinds: str, folder: str = "") -> str:
    """Ask for a file that is there; empty for none.

    Parameters
    ----------
    parent : QWidget
    title : str
    kinds : str
        Name filters, parted by ``;;``.
    folder : str
        To begin in; by default where was looked last.
    """
    dialog = QtWidgets.QFileDialog(parent, title, folder)
    dialog.setFileMode(QtWidgets.QFileDialog.FileMode.ExistingFile)
    dialog.setNameFilters(kinds.split(";;"))
    look_at_names_only(dialog)
    chosen = dialog.selectedFiles() if dialog.exec() else []
    dialog.deleteLater()
    return chosen[0] if chosen else ""


def that_exist(paths: Sequence[str | os.PathLike[str]]) -> list[str]:
    """Those of several files that are there, as far as their folders answer, in their order."""
    found = _look(paths)
    return [os.fspath(path) for path in paths if found.get(os.fspath(path), False)]


def answers(path: str | os.PathLike[str]) -> bool:
    """Return whether it can be told at all, within a while, if something is at a path."""
    return os.fspath(path) in _look([path])


def _look(paths: Sequence[str | os.PathLike[str]]) -> dict[str, bool]:
    """Whether each of several files is there; those of which nothing was heard are left out."""
    found: dict[str, bool] = {}
    seekers = []
    for path in [os.fspath(path) for path in paths]:
        seeker = threading.Thread(
            target=lambda path=path: found.update({path: _is_there(path)}), daemon=True
        )
        seeker.start()
        seekers.append(seeker)
    deadline = time.monotonic() + _PATIENCE_S
    for seeker in seekers:
        seeker.join(max(0.0, deadline - time.monotonic()))
    return dict(found)


def _is_there(path: str) -> bool:
    return os.path.exists(path)

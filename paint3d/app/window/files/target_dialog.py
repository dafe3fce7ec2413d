"""Asking where to write: the format by name, and once before a file is replaced."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import NamedTuple

from PySide6 import QtWidgets

from paint3d.app.window.files.file_dialogs import answers, look_at_names_only
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_object
from paint3d.app.window.workspace import Workspace

__all__ = ["FileKind", "TargetDialog", "Targets", "ask_target"]


class FileKind(NamedTuple):
    """A format: its name in words, and the suffix that a file of it has."""

    name: str
    suffix: str

    @property
    def filter(self) -> str:
        """The dialog's filter."""
        return f"{self.name} (*{self.suffix})"


class TargetDialog(QtWidgets.QFileDialog):
    """Asks for a file to write.

    Qt's own dialog on every desktop: the name that is typed gets its suffix before it is asked
    whether a file of that name is to be replaced, which a desktop's dialog does not know of.

    Parameters
    ----------
    parent : QWidget
    title : str
    start : Path
        The folder to look into, and a name to begin with.
    kinds : sequence of FileKind
    preferred : str
        The suffix of the kind that is chosen at first.

    Attributes
    ----------
    target : Path or None
        The chosen file, with its suffix.
    """

    def __init__(
        self,
        parent: QtWidgets.QWidget,
        title: str,
        start: Path,
        kinds: Sequence[FileKind],
        preferred: str,
    ) -> None:
        super().__init__(parent, title)
        self.target: Path | None = None
        self._kinds = list(kinds)
        self._first = next((k for k in kinds if k.suffix == preferred), kinds[0])
        self.setAcceptMode(QtWidgets.QFileDialog.AcceptMode.AcceptSave)
        self.setFileMode(QtWidgets.QFileDialog.FileMode.AnyFile)
        self.setOption(QtWidgets.QFileDialog.Option.DontUseNativeDialog)
        self.setOption(QtWidgets.QFileDialog.Option.DontConfirmOverwrite)
        filters = [kind.filter for kind in kinds]
        if len(filters) > 1:
            every = " ".join(f"*{kind.suffix}" for kind in kinds)
            filters.append(f"{say('Everything')} ({every})")
        self.setNameFilters(filters)
        self.selectNameFilter(self._first.filter)
        label = QtWidgets.QFileDialog.DialogLabel
        for part, text in (
            (label.LookIn, say("Folder")),
            (label.FileName, say("File name")),
            (label.FileType, say("Format")),
            (label.Accept, say("Save")),
            (label.Reject, say("Cancel")),
        ):
            self.setLabelText(part, text)
        look_at_names_only(self)
        there = answers(start.parent) and start.parent.is_dir()
        folder = start.parent if there else Path.cwd()
        self.setDirectory(os.path.abspath(folder))
        self.selectFile(start.name)
        self.filterSelected.connect(self._rename)

    def _rename(self, chosen: str) -> None:
        """Give the name in the box the suffix of the chosen kind."""
        kind = next((k for k in self._kinds if k.filter == chosen), None)
        named = self.selectedFiles()
        if kind is not None and named and not Path(named[0]).is_dir():
            name = Path(named[0]).name
            known = _suffix(name, self._kinds) or ""
            self.selectFile(name[: len(name) - len(known)] + kind.suffix)

    def _with_suffix(self, path: Path) -> Path:
        """Return the file of a typed name; a known suffix in it gives the format."""
        if _suffix(path.name, self._kinds) is not None:
            return path
        chosen = self.selectedNameFilter()
        kind = next((k for k in self._kinds if k.filter == chosen), self._first)
        return path.with_name(path.name + kind.suffix)

    def accept(self) -> None:
        """Ask before a file is replaced; stay open if that is declined."""
        named = self.selectedFiles()
        if named and not answers(named[0]):
            folder = os.path.dirname(named[0])
            message = say("“{folder}” does not answer; choose another folder", folder=folder)
            ask(self, message, warns=True)
            return
        if not named or Path(named[0]).is_dir():
            super().accept()
            return
        target = self._with_suffix(Path(named[0]))
        if os.path.lexists(target) and not target.is_dir() and not _may_replace(self, target):
            return
        self.target = target
        super().accept()


def _suffix(name: str, kinds: Sequence[FileKind]) -> str | None:
    """Return the longest known suffix of a name."""
    suffixes = [k.suffix for k in kinds if name.lower().endswith(k.suffix)]
    return max(suffixes, key=len, default=None)


def _may_replace(parent: QtWidgets.QWidget, path: Path) -> bool:
    """Ask whether a file may be replaced, naming also a link's target."""
    name = f"{path.name} → {os.path.realpath(path)}" if path.is_symlink() else path.name
    answer = ask(
        parent, say("“{name}” exists. Replace it?", name=name), destroy=say("Replace"), warns=True
    )
    return answer is Answer.DestructiveRole


def ask_target(
    parent: QtWidgets.QWidget,
    title: str,
    start: Path,
    kinds: Sequence[FileKind],
    preferred: str = "",
) -> Path | None:
    """Ask where to write; None if cancelled. The file returned may be replaced."""
    dialog = TargetDialog(parent, title, start, kinds, preferred)
    accepted = dialog.exec()
    dialog.deleteLater()
    return dialog.target if accepted else None


# ---- Where ---------------------------------------------------------------------------------------
# Proposes the painting's name, in the folder that was written to last.


class Targets:
    """Asks for the names and folders of files to write.

    Attributes
    ----------
    folder : Path or None
        Written to last.
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.folder: Path | None = None

    def ask(self, title: str, names: Mapping[str, str], preferred: str = "") -> Path | None:
        """Ask where to write; None if cancelled.

        A painting without a file of its own is proposed under a name that is free.

        Parameters
        ----------
        title : str
        names : mapping
            Names of formats by their suffix.
        preferred : str
            The suffix that is chosen at first.
        """
        painting = self._workspace.painting
        stem = painting.path.stem if painting.path else say_object(painting.source.name)
        beside = painting.path.parent if painting.path else Path.cwd()
        suffix = preferred if preferred in names else next(iter(names))
        start = (self.folder or beside) / f"{stem}{suffix}"
        if painting.path is None and answers(start.parent):
            start = _free_path(start, suffix)
        kinds = [FileKind(say(name), suffix) for suffix, name in names.items()]
        path = ask_target(self._workspace.window, title.rstrip("…"), start, kinds, suffix)
        if path is not None:
            self.folder = path.parent
        return path


def _free_path(path: Path, suffix: str) -> Path:
    """Return that path, or the first with a number behind its name that no file has."""
    names = (f"{path.name.removesuffix(suffix)} {k}{suffix}" for k in count(2))
    paths = (path.with_name(name) for name in names)
    return path if not os.path.lexists(path) else next(p for p in paths if not os.path.lexists(p))

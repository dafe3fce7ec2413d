"""Saving paintings, and what becomes of unsaved work."""

from __future__ import annotations

from pathlib import Path

from PySide6 import QtWidgets

from paint3d.app.window.jobs.job import Progress, result_of
from paint3d.app.window.jobs.recent_files import RecentFiles
from paint3d.app.window.jobs.targets import Targets
from paint3d.app.window.named import named
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.files.project.session import SESSION_SUFFIX

__all__ = ["Saving"]


class Saving:
    """For one window."""

    def __init__(self, workspace: Workspace, targets: Targets, recent: RecentFiles) -> None:
        self._workspace, self._targets, self._recent = workspace, targets, recent

    def may_leave(self) -> bool:
        """Ask what is to become of unsaved work; False if it is to stay."""
        easel = self._workspace.stage.easel
        if easel is None:
            return True
        document = self._workspace.document
        if not (easel.is_behind or document.modified):  # what is still to be done will change it
            return True
        name = document.path.name if document.path else named(document.surface.source.name)
        box = QtWidgets.QMessageBox(self._workspace.window)
        box.setWindowTitle("paint3d")
        box.setText(say("ask.save_changes", name=name))
        role = QtWidgets.QMessageBox.ButtonRole
        save = box.addButton(say("button.save"), role.AcceptRole)
        discard = box.addButton(say("button.discard"), role.DestructiveRole)
        box.setEscapeButton(box.addButton(say("button.cancel"), role.RejectRole))
        box.setDefaultButton(save)
        box.exec()
        if box.clickedButton() is save:
            return self.do_save()
        return box.clickedButton() is discard

    def do_save(self) -> bool:
        """Save where it was saved before, or ask where; say whether that went well."""
        document = self._workspace.document
        if document.path is None:
            return self.do_save_as()
        if document.is_written_by_others:
            return self._save_beside_others(document.path)
        return self.save_to(document.path)

    def _save_beside_others(self, path: Path) -> bool:
        """Ask before what somebody else has saved in the same file is replaced."""
        box = QtWidgets.QMessageBox(self._workspace.window)
        box.setIcon(QtWidgets.QMessageBox.Icon.Warning)
        box.setWindowTitle("paint3d")
        words = "{name} was saved by another window or program since it was opened here."
        box.setText(say(words, name=path.name))
        role = QtWidgets.QMessageBox.ButtonRole
        other = box.addButton(say("action.save_as"), role.AcceptRole)
        replace = box.addButton(say("Replace"), role.DestructiveRole)
        box.setEscapeButton(box.addButton(say("button.cancel"), role.RejectRole))
        box.setDefaultButton(other)
        box.exec()
        if box.clickedButton() is other:
            return self.do_save_as()
        return box.clickedButton() is replace and self.save_to(path)

    def do_save_as(self) -> bool:
        """Ask where to save; say whether that went well."""
        path = self._targets.ask(say("action.save_as"), {SESSION_SUFFIX: "Paintings"})
        return path is not None and self.save_to(path)

    def save_to(self, path: Path) -> bool:
        """Save to a session; say whether that went well."""
        workspace = self._workspace
        easel = workspace.easel

        def work(progress: Progress) -> None:
            result_of(easel.post("save", path, progress=progress), progress)

        if not workspace.went_well(workspace.run(say("Writing {name}…", name=path.name), work)):
            return False
        workspace.saved.emit()
        workspace.tell(say("status.saved", name=path.name), state="good")
        self._recent.add(str(path))
        return True

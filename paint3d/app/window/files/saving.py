"""Saving paintings, and asking about unsaved work."""

from __future__ import annotations

from pathlib import Path

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.files.file_dialogs import that_exist
from paint3d.app.window.files.target_dialog import Targets
from paint3d.app.window.job import JobProgress, result_of
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_object
from paint3d.app.window.workspace import Workspace
from paint3d.errors import Message
from paint3d.files.project.session import SESSION_SUFFIX

__all__ = ["RecentFiles", "Saving"]

# ---- Recent files --------------------------------------------------------------------------------
# The files that were opened or saved last, and their menu.


class RecentFiles(QtCore.QObject):
    """Submenu of the paintings that were opened or saved last.

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
        self._workspace.update_settings(recent=self._workspace.settings.with_recent(path).recent)
        self.show()

    def show(self) -> None:
        """Fill the menu."""
        self._menu.clear()
        for path in self.paths():
            action = self._menu.addAction(Path(path).name)
            action.triggered.connect(lambda _=False, path=path: self.chosen.emit(path))
        self._menu.setEnabled(bool(self._menu.actions()))

    def paths(self) -> list[str]:
        """Return those that still exist, the last opened first."""
        return that_exist(self._workspace.settings.recent)


# ---- Saving --------------------------------------------------------------------------------------


class Saving:
    """Saves the open painting, and asks about unsaved work."""

    def __init__(self, workspace: Workspace, targets: Targets, recent: RecentFiles) -> None:
        self._workspace, self._targets, self._recent = workspace, targets, recent

    def may_leave(self) -> bool:
        """Ask about unsaved work; False if the painting is not to be left."""
        paint_thread = self._workspace.stage.paint_thread
        if paint_thread is None:
            return True
        painting = self._workspace.painting
        if not (paint_thread.is_behind or painting.modified):  # queued commands will change it
            return True
        name = painting.path.name if painting.path else say_object(painting.source.name)
        words = say("Save the changes to “{name}”?", name=name)
        window = self._workspace.window
        answer = ask(window, words, accept=say("Save"), destroy=say("Do not save"))
        if answer is Answer.AcceptRole:
            return self.do_save()
        return answer is Answer.DestructiveRole

    def do_save(self) -> bool:
        """Save where it was saved before, or ask where; return whether that succeeded."""
        workspace, state = self._workspace, list[tuple[Path | None, bool]]()
        paint_thread, painting = workspace.paint_thread, workspace.painting

        def work(progress: JobProgress) -> None:  # with a bar, as the current step may last
            asked = paint_thread.post(
                lambda document: (document.path, document.file_changed_on_disk)
            )
            state.append(result_of(asked, progress))

        name = painting.path.name if painting.path else say_object(painting.source.name)
        if not workspace.went_well(workspace.run(say("Writing {name}…", name=name), work)):
            return False
        ((path, is_written),) = state
        if path is None:
            return self.do_save_as()
        return self._save_beside_others(path) if is_written else self.save_to(path)

    def _save_beside_others(self, path: Path) -> bool:
        """Ask before replacing what another program has saved in the same file."""
        answer = ask(
            self._workspace.window,
            say(
                "{name} was saved by another window or program since it was opened here.",
                name=path.name,
            ),
            accept=say("Save as…"),
            destroy=say("Replace"),
            warns=True,
        )
        if answer is Answer.AcceptRole:
            return self.do_save_as()
        return answer is Answer.DestructiveRole and self.save_to(path)

    def do_save_as(self) -> bool:
        """Ask where to save; return whether that succeeded."""
        path = self._targets.ask(say("Save as…"), {SESSION_SUFFIX: Message("Paintings")})
        return path is not None and self.save_to(path)

    def save_to(self, path: Path) -> bool:
        """Save to a session; return whether that succeeded."""
        workspace = self._workspace
        paint_thread = workspace.paint_thread

        def work(progress: JobProgress) -> None:
            paint_thread.post(workspace.before_saving)
            result_of(paint_thread.post("save", path, progress=progress), progress)

        if not workspace.went_well(workspace.run(say("Writing {name}…", name=path.name), work)):
            return False
        workspace.saved.emit()
        workspace.tell(say("Saved {name}", name=path.name), state="good")
        self._recent.add(str(path))
        return True

"""Recovering paintings that a crash left."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.persistence.recovery_folder import (
    Recovered,
    Unfinished,
    is_open_elsewhere,
    recoverable,
)
from paint3d.app.window.files.open_result import open_with_progress
from paint3d.app.window.job import JobProgress
from paint3d.app.window.questions import Answer, ask
from paint3d.app.window.wording import say, say_error, say_object
from paint3d.app.window.workspace import Workspace
from paint3d.errors import SessionError
from paint3d.files.progress import part_of

__all__ = ["Recovery", "open_elsewhere"]


class Recovery:
    """Offers the paintings that crashes left, to recover or delete them.

    Parameters
    ----------
    workspace : Workspace
    menu : QMenu
        Of the paintings that can be recovered; filled when it is about to be shown.
    may_leave : callable
        Asks whether the open painting may be left.

    Attributes
    ----------
    discarded : callable
        Called when the user has deleted a painting.
    """

    def __init__(
        self, workspace: Workspace, menu: QtWidgets.QMenu, may_leave: Callable[[], bool]
    ) -> None:
        self._workspace, self._menu, self._may_leave = workspace, menu, may_leave
        self.discarded: Callable[[], None] = lambda: None

    def offer(self) -> bool:
        """Ask about the newest painting that was never saved; True if it was recovered."""
        left = recoverable()
        return bool(left) and self._is_wanted(left[0]) and self.recover(left[0])

    def _ask_and_recover(self, one: Unfinished) -> bool:
        """Ask about a painting, and about leaving the open one; return whether it was recovered."""
        return self._is_wanted(one) and self._may_leave() and self.recover(one)

    def _is_wanted(self, one: Unfinished) -> bool:
        """Ask whether to recover a painting; if not, it is deleted or stays for later."""
        answer = ask(
            self._workspace.window,
            say(
                "The studio did not close properly. Recover “{name}” of {time}?",
                name=_name_of(one),
                time=_time_of(one),
            ),
            accept=say("Recover"),
            destroy=say("Delete it"),
            leave=say("Not now"),
        )
        if answer is Answer.DestructiveRole:
            one.discard()
            self.discarded()
        return answer is Answer.AcceptRole

    def tell_unsaved(self) -> None:
        """Show where unsaved paintings can be found, if there are any."""
        if recoverable():
            where = f"{say('File')}, {say('Recover unsaved work')}"
            message = say("Unsaved paintings stay in the menu: {where}", where=where)
            self._workspace.tell(message)

    def fill_menu(self) -> None:
        """List the paintings that can be recovered now."""
        self._menu.clear()
        for one in recoverable():
            text = f"{_name_of(one)}  ({_time_of(one)})"
            action = self._menu.addAction(text)
            action.triggered.connect(lambda _=False, one=one: self._ask_and_recover(one))
        self._menu.setEnabled(bool(self._menu.actions()))

    def recover(self, one: Unfinished) -> bool:
        """Recover a painting; its recovery data is deleted once it is saved again by this process.

        If it is stopped, it stays where it is and is offered again.
        """
        with ExitStack() as lock:  # until it is saved anew, no other window may recover it, too
            with suppress(SessionError):  # the recovery itself reports it
                lock.enter_context(one.held())
            return self._recover(one)

    def _recover(self, one: Unfinished) -> bool:
        workspace = self._workspace
        workspace.error = None

        def work(progress: JobProgress) -> object:
            recovered = one.recover(part_of(progress, 0.0, 0.9))
            return recovered, open_with_progress(recovered.document, progress, 0.9)

        done = workspace.run(say("Opening {name}…", name=_name_of(one)), work)
        if not workspace.went_well(done):
            return False
        recovered, opened = done.result()
        if not workspace.show(opened):
            return False
        is_kept = workspace.paint_thread.recovery is not None
        if is_kept:
            one.discard()
        lost = _losses(recovered)
        if lost or is_kept:  # if not, that is shown already, and the crash's data stays
            bad = lost + open_elsewhere(workspace)
            message = say("; ").join([say("Recovered; save it to keep it"), *bad])
            workspace.tell(message, state="bad" if bad else "good", stays=bool(bad))
        return True


def open_elsewhere(workspace: Workspace) -> list[str]:
    """Return a note if another window has the same file open; who saves second is asked."""
    path, recovery = workspace.painting.path, workspace.paint_thread.recovery
    own = None if recovery is None else recovery.folder
    if path is None or not is_open_elsewhere(path, own):
        return []
    return [say("{name} is open in another window, too", name=path.name)]


def _losses(recovered: Recovered) -> list[str]:
    """Return notes on what could not be recovered."""
    notes = []
    if recovered.n_lost:
        notes.append(say("about {count:,} samples of the hand were lost", count=recovered.n_lost))
    if recovered.refused:
        message = say("{count} steps could not be done again", count=len(recovered.refused))
        notes.append(f"{message} ({say_error(recovered.refused[0])})")
    return notes


def _name_of(one: Unfinished) -> str:
    return one.path.name if one.path else say_object(one.object_name)


def _time_of(one: Unfinished) -> str:
    when = QtCore.QDateTime.fromSecsSinceEpoch(int(one.time_s))
    return when.toString("yyyy-MM-dd hh:mm:ss")

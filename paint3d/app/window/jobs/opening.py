"""Opening objects and paintings, and bringing back what a crash left."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6 import QtCore, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.saved_settings import chosen_brush, chosen_inks, chosen_material
from paint3d.app.model.persistence.sitting import Unfinished, recoverable
from paint3d.app.window.dialogs.questions import NewDialog
from paint3d.app.window.jobs.job import Progress, is_waiting, run_beside
from paint3d.app.window.jobs.opened import Opened
from paint3d.app.window.named import named
from paint3d.app.window.warming import is_first_start, warm_up
from paint3d.app.window.wording import say, say_error
from paint3d.errors import Paint3DError
from paint3d.files.load import BUILT_IN_OBJECTS, MESH_SUFFIXES, read_mesh
from paint3d.files.progress import part_of
from paint3d.files.project.session import SESSION_SUFFIX, is_session_path
from paint3d.files.sandbox.reading import Reading

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["Opening"]

_FACES_A_SECOND = 1e6  # of a mesh that is made ready to be painted on, about
_SHOWN_A_SECOND = 6e5  # and to be shown


class Opening:
    """For one window; a part of `Files`.

    Attributes
    ----------
    error : BaseException or None
        What went wrong last.
    quiet : bool
        Keep it there instead of showing it.
    up : str or None
        The axis of mesh files that points up, where that was said; see `load_mesh`.
    """

    _window: StudioWindow
    error: BaseException | None
    quiet: bool
    up: str | None = None
    may_leave: Callable[[], bool]

    # -- asking -----------------------------------------------------------------------------

    def new(self) -> None:
        """Ask for an object, a material and a fineness, and begin."""
        dialog = NewDialog(self._window, self._window.settings)
        if not dialog.exec() or not self.may_leave():
            return
        name, material, resolution = dialog.chosen()
        self._window.keep(material=material, resolution_mm=resolution)
        if name:
            self.open_path(name, resolution, material, asked=True)
        else:
            self.open(resolution, material)

    def open(self, resolution: float | None = None, material: str | None = None) -> None:
        """Ask for a file, and open it."""
        meshes = " ".join(f"*{suffix}" for suffix in (SESSION_SUFFIX, *MESH_SUFFIXES))
        kinds = f"{say('Objects and paintings')} ({meshes});;{say('All files')} (*)"
        path, _ = QtWidgets.QFileDialog.getOpenFileName(
            self._window, say("action.open").rstrip("…"), "", kinds
        )
        if path:
            self.open_path(path, resolution, material)

    # -- opening ----------------------------------------------------------------------------

    def open_path(
        self,
        path: str,
        resolution: float | None = None,
        material: str | None = None,
        *,
        asked: bool = False,
    ) -> bool:
        """Open a painting, a mesh or a built-in object; say whether that went well.

        If it is stopped or fails, the painting that is open stays as it is.

        Parameters
        ----------
        path : str
        resolution : float, optional
            mm; of a mesh. By default what was chosen last.
        material : str, optional
            Of a mesh. By default what was chosen last.
        asked : bool
            Whether it was asked already what becomes of the painting that is open.
        """
        if is_waiting(self._window):
            return False
        if not asked and self._window.stage.easel is not None and not self.may_leave():
            return False
        self.error = None
        if not self.went_well(run_beside(self._window, _warming(), _warm_up)):
            return False
        title = say("status.opening", name=named(Path(path).name))
        if is_session_path(path):
            done = self._open_session(path, title)
        else:
            done = self._open_mesh(path, title, resolution, material)
        if done is None or not self.went_well(done):
            return False
        self._window.show_document(done.result())
        self._window.standing.tell()
        if path not in BUILT_IN_OBJECTS:
            self._remember(path)
        return True

    def _open_session(self, path: str, title: str) -> Future:
        undo_bytes = self._undo_bytes()

        def work(progress: Progress) -> Opened:
            told = part_of(progress, 0.0, 0.9)
            document = Document.open(path, undo_bytes=undo_bytes, progress=told)
            return _opened(document, progress, 0.9)

        return run_beside(self._window, title, work)

    def _open_mesh(
        self, path: str, title: str, resolution: float | None, material: str | None
    ) -> Future | None:
        settings = self._window.settings
        resolution = settings.resolution_mm if resolution is None else resolution
        material = chosen_material(settings) if material is None else material

        def read(progress: Progress) -> Reading:
            found = read_mesh(path, texture=True, up=self.up, progress=_before_one(progress))
            _ = found.likely_up  # found here, not in the window's thread
            return found

        loaded = run_beside(self._window, title, read)
        if not self.went_well(loaded):
            return None
        reading = loaded.result()
        standing = self._window.standing
        choice = standing.choose(path, reading, material, resolution, ask=not self.quiet)
        if choice is None:
            return None
        self._window.keep_in_hand()
        settings = self._window.settings
        brush, inks = chosen_brush(settings), chosen_inks(settings)
        undo_bytes = self._undo_bytes()

        def make(progress: Progress) -> Opened:
            found = reading.mesh
            if not choice.coloured:  # as it was before it was refined for its picture
                found = read_mesh(path, up=self.up, progress=part_of(progress, 0.0, 0.4)).mesh
            share = 0.0 if choice.coloured else 0.4
            progress.expect(share, 0.7, 0.2 + found.n_faces / _FACES_A_SECOND)
            document = Document.new(
                choice.apply(found),
                choice.resolution,
                choice.material,
                brush=brush,
                ink=inks[0],
                undo_bytes=undo_bytes,
            )
            document.inks[1] = inks[1]
            return _opened(document, progress, 0.7)

        return run_beside(self._window, title, make)

    def _undo_bytes(self) -> int:
        return int(self._window.settings.undo_megabytes * (1 << 20))

    def went_well(self, done: Future) -> bool:
        """Whether work ended well; what went wrong is told."""
        error = done.exception()
        if error is None:
            return True
        self.error = error
        if isinstance(error, CancelledError):
            self._window.tell(say("Stopped"))
        elif not isinstance(error, Paint3DError | OSError):
            raise error
        elif not self.quiet:
            QtWidgets.QMessageBox.warning(self._window, "paint3d", say_error(error))
        return False

    def _remember(self, path: str) -> None:
        """Put a file first among the recent ones."""
        self._window.keep(recent=self._window.settings.with_recent(path).recent)
        self.show_recent()

    def show_recent(self) -> None:
        """Fill the menu of recent files."""
        menu = self._window.recent_menu
        menu.clear()
        for path in self.recent_files():
            menu.addAction(Path(path).name, lambda path=path: self.open_path(path))
        menu.setEnabled(bool(menu.actions()))

    def recent_files(self) -> list[str]:
        """Those that are still there, the last opened first."""
        return [path for path in self._window.settings.recent if Path(path).exists()]

    # -- what a crash left ------------------------------------------------------------------

    def offer_recovery(self) -> bool:
        """Ask about a painting that was never saved, the newest; True if it was brought back."""
        left = recoverable()
        return bool(left) and self._is_wanted_back(left[0]) and self.recover(left[0])

    def bring_back(self, one: Unfinished) -> bool:
        """Ask about a painting that was never saved, and what becomes of the one that is open."""
        return self._is_wanted_back(one) and self.may_leave() and self.recover(one)

    def _is_wanted_back(self, one: Unfinished) -> bool:
        """Whether to go on with it; if not, it is deleted or stays for later."""
        box = QtWidgets.QMessageBox(self._window)
        box.setWindowTitle("paint3d")
        box.setText(say("ask.recover", name=_name_of(one), time=_time_of(one)))
        role = QtWidgets.QMessageBox.ButtonRole
        back = box.addButton(say("button.recover"), role.AcceptRole)
        away = box.addButton(say("button.delete"), role.DestructiveRole)
        box.addButton(say("button.later"), role.RejectRole)
        box.setDefaultButton(back)
        box.exec()
        if box.clickedButton() is away:
            one.discard()
        return box.clickedButton() is back

    def tell_unsaved(self) -> None:
        """Say where what was put off can be found, if there is any."""
        if recoverable():
            where = f"{say('menu.file')}, {say('Bring back what was not saved')}"
            self._window.tell(say("What was not saved stays in the menu: {where}", where=where))

    def show_unsaved(self) -> None:
        """Fill the menu of paintings that can be brought back, as they are left by now."""
        menu = self._window.unsaved_menu
        menu.clear()
        for one in recoverable():
            text = f"{_name_of(one)}  ({_time_of(one)})"
            menu.addAction(text, lambda one=one: self.bring_back(one))
        menu.setEnabled(bool(menu.actions()))

    def recover(self, one: Unfinished) -> bool:
        """Bring a painting back; what it was kept in is deleted once it is kept anew.

        If it is stopped, it stays where it is and is offered again.
        """
        self.error = None
        title = say("status.opening", name=_name_of(one))

        def work(progress: Progress) -> Opened:
            return _opened(one.recover(part_of(progress, 0.0, 0.9)).document, progress, 0.9)

        done = run_beside(self._window, title, work)
        if not self.went_well(done):
            return False
        self._window.show_document(done.result())
        one.discard()
        self._window.tell(say("Brought back; save it to keep it"), state="good")
        return True


def _name_of(one: Unfinished) -> str:
    return one.path.name if one.path else named(one.object_name)


def _time_of(one: Unfinished) -> str:
    when = QtCore.QDateTime.fromSecsSinceEpoch(int(one.time_s))
    return when.toString("yyyy-MM-dd hh:mm:ss")


def _warming() -> str:
    """What is said while the kernels are got ready."""
    return say("status.compiling" if is_first_start() else "status.warming")


def _warm_up(progress: Progress) -> None:
    progress.expect(0.0, 0.98, 20.0)
    warm_up(progress.check)


def _opened(document: Document, progress: Progress, share: float) -> Opened:
    """Make it ready to be shown; the share of the work that is done before."""
    n = document.surface.source.n_faces + 2 * document.surface.n_vertices
    progress.expect(share, 0.98, 0.1 + n / _SHOWN_A_SECOND)
    return Opened.of(document, progress.check)


def _before_one(progress: Progress):
    return part_of(progress, 0.0, 0.98)

"""Opening objects and paintings."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.persistence.saved_settings import chosen_brush, chosen_inks, chosen_material
from paint3d.app.window.dialogs.questions import NewDialog
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.jobs.opened import Opened, open_with_progress
from paint3d.app.window.jobs.recent_files import RecentFiles
from paint3d.app.window.jobs.recovery import open_elsewhere
from paint3d.app.window.jobs.saving import Saving
from paint3d.app.window.jobs.standing import Standing
from paint3d.app.window.named import named
from paint3d.app.window.warming import is_first_start, is_warm, warm_up
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.files.load import BUILT_IN_OBJECTS, MESH_SUFFIXES, read_mesh
from paint3d.files.progress import part_of
from paint3d.files.project.session import SESSION_SUFFIX, is_session_path
from paint3d.files.sandbox.reading import Reading

__all__ = ["Opening", "say_warming"]


class Opening:
    """For one window.

    Attributes
    ----------
    up : str or None
        The axis of mesh files that points up, where that was said; see `load_mesh`.
    """

    def __init__(
        self, workspace: Workspace, saving: Saving, standing: Standing, recent: RecentFiles
    ) -> None:
        self._workspace, self._saving = workspace, saving
        self._standing, self._recent = standing, recent
        self.up: str | None = None

    # -- asking -----------------------------------------------------------------------------

    def do_new(self) -> None:
        """Ask for an object, a material and a fineness, and begin."""
        dialog = NewDialog(self._workspace.window, self._workspace.settings)
        if not dialog.exec() or not self._saving.may_leave():
            return
        name, material, resolution = dialog.chosen()
        self._workspace.keep(material=material, resolution_mm=resolution)
        if name:
            self.open_path(name, resolution, material, asked=True)
        else:
            self.do_open(resolution, material, asked=True)

    def do_open(
        self, resolution: float | None = None, material: str | None = None, *, asked: bool = False
    ) -> None:
        """Ask for a file, and open it; see `open_path`."""
        meshes = " ".join(f"*{suffix}" for suffix in (SESSION_SUFFIX, *MESH_SUFFIXES))
        kinds = f"{say('Objects and paintings')} ({meshes});;{say('All files')} (*)"
        path, _ = QtWidgets.QFileDialog.getOpenFileName(
            self._workspace.window, say("action.open").rstrip("…"), "", kinds
        )
        if path:
            self.open_path(path, resolution, material, asked=asked)

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
        if self._workspace.is_waiting:
            return False
        if not asked and self._workspace.stage.easel is not None and not self._saving.may_leave():
            return False
        self._workspace.error = None
        if not self._is_ready():
            return False
        title = say("status.opening", name=named(Path(path).name))
        if is_session_path(path):
            done: Future[Any] | None = self._open_session(path, title)
        else:
            done = self._open_mesh(path, title, resolution, material)
        if done is None or not self._workspace.went_well(done):
            return False
        if not self._workspace.show(done.result()):
            return False
        self._standing.tell()
        if path not in BUILT_IN_OBJECTS:
            self._recent.add(path)
        for told in open_elsewhere(self._workspace):
            self._workspace.tell(told, state="bad", stays=True)
        return True

    def _is_ready(self) -> bool:
        """Whether a stroke could be painted at once; gets kernels ready that are compiled late."""
        return is_warm() or self._workspace.went_well(self._workspace.run(say_warming(), _warm_up))

    def _open_session(self, path: str, title: str) -> Future[Any]:
        undo_bytes = self._undo_bytes()

        def work(progress: Progress) -> Opened:
            told = part_of(progress, 0.0, 0.9)
            document = Document.open(path, undo_bytes=undo_bytes, progress=told)
            return open_with_progress(document, progress, 0.9)

        return self._workspace.run(title, work)

    def _open_mesh(
        self, path: str, title: str, resolution: float | None, material: str | None
    ) -> Future[Any] | None:
        settings = self._workspace.settings
        resolution = settings.resolution_mm if resolution is None else resolution
        material = chosen_material(settings) if material is None else material

        def read(progress: Progress) -> Reading:
            found = read_mesh(path, texture=True, up=self.up, progress=_before_one(progress))
            _ = found.likely_up, found.mesh.face_normals, found.mesh.bounds  # found here, not in
            # the window's thread
            return found

        loaded = self._workspace.run(title, read)
        if not self._workspace.went_well(loaded):
            return None
        reading = loaded.result()
        choice = self._standing.choose(
            path, reading, material, resolution, ask=not self._workspace.quiet
        )
        if choice is None:
            return None
        self._workspace.keep_in_hand()
        settings = self._workspace.settings
        brush, inks = chosen_brush(settings), chosen_inks(settings)
        undo_bytes = self._undo_bytes()

        def make(progress: Progress) -> Opened:
            found = reading.mesh
            if not choice.coloured:  # as it was before it was refined for its picture
                found = read_mesh(path, up=self.up, progress=part_of(progress, 0.0, 0.4)).mesh
            progress(0.0 if choice.coloured else 0.4)
            document = Document.new(
                choice.apply(found),
                choice.resolution,
                choice.material,
                brush=brush,
                ink=inks[0],
                undo_bytes=undo_bytes,
            )
            document.inks[1] = inks[1]
            return open_with_progress(document, progress, 0.7)

        return self._workspace.run(title, make)

    def _undo_bytes(self) -> int:
        return int(self._workspace.settings.undo_megabytes * (1 << 20))


def say_warming() -> str:
    """What is said while the kernels are got ready."""
    return say("status.compiling" if is_first_start() else "status.warming")


def _warm_up(progress: Progress) -> None:
    warm_up(_before_one(progress))


def _before_one(progress: Progress) -> Callable[[float], None]:
    return part_of(progress, 0.0, 0.98)

"""Saving, exporting and recording, and the questions that come with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6 import QtWidgets

from paint3d.app.window.dialogs.export_dialog import ExportDialog, kept_options
from paint3d.app.window.dialogs.target_dialog import Kind, ask_target
from paint3d.app.window.jobs.job import Progress, result_of, run_beside
from paint3d.app.window.named import named
from paint3d.app.window.wording import say
from paint3d.files.export import EXPORT_SUFFIXES
from paint3d.files.export_options import ExportOptions
from paint3d.files.progress import part_of
from paint3d.files.project.session import SESSION_SUFFIX
from paint3d.recording.recording import save_recording

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["Saving"]

_FORMATS = {
    ".glb": "glTF, for the web and most programs",
    ".ply": "PLY",
    ".obj": "Wavefront OBJ",
    ".3mf": "3MF, for printers",
    ".usdz": "USDZ, for Apple's devices",
    ".wrl": "VRML, for colour printers",
    ".html": "Page that shows the object",
    ".png": "Picture, PNG",
    ".jpg": "Picture, JPEG",
    ".p3d.txt": "Records of the vertices",
    SESSION_SUFFIX: "Copy of the painting",
}
_RECORDINGS = {
    ".jsonl": "Recording, JSON Lines",
    ".jsonl.gz": "Recording, JSON Lines, packed",
    ".inkml": "Recording, InkML",
}
_TAKEN = 0.5  # of an export's time, about, until the painting may go on
_VERTICES_A_SECOND = 4e5  # that are written, about


def _kinds(names: Mapping[str, str]) -> list[Kind]:
    return [Kind(say(name), suffix) for suffix, name in names.items()]


class Saving:
    """For one window; a part of `Files`."""

    _window: StudioWindow
    _folder: Path | None
    went_well: Callable[[Future], bool]
    picture_to: Callable[[Path, tuple[int, int], int], bool]
    _remember: Callable[[str], None]

    # -- asking -----------------------------------------------------------------------------

    def may_leave(self) -> bool:
        """Ask what is to become of unsaved work; False if it is to stay."""
        easel = self._window.stage.easel
        if easel is None:
            return True
        document = self._window.document
        if not (document.modified or easel.queue_length):  # what waits will change it
            return True
        name = document.path.name if document.path else named(document.surface.source.name)
        box = QtWidgets.QMessageBox(self._window)
        box.setWindowTitle("paint3d")
        box.setText(say("ask.save_changes", name=name))
        role = QtWidgets.QMessageBox.ButtonRole
        save = box.addButton(say("button.save"), role.AcceptRole)
        discard = box.addButton(say("button.discard"), role.DestructiveRole)
        box.setEscapeButton(box.addButton(say("button.cancel"), role.RejectRole))
        box.setDefaultButton(save)
        box.exec()
        if box.clickedButton() is save:
            return self.save()
        return box.clickedButton() is discard

    def ask_target(self, title: str, names: Mapping[str, str], preferred: str = "") -> Path | None:
        """Ask where to write: where was written last, under the painting's name.

        Parameters
        ----------
        title : str
        names : mapping
            What a format is called, by its suffix.
        preferred : str
            The suffix that is chosen at first.
        """
        document = self._window.document
        stem = document.path.stem if document.path else named(document.surface.source.name)
        beside = document.path.parent if document.path else Path.cwd()
        suffix = preferred if preferred in names else next(iter(names))
        start = (self._folder or beside) / f"{stem}{suffix}"
        path = ask_target(self._window, title.rstrip("…"), start, _kinds(names), suffix)
        if path is not None:
            self._folder = path.parent
        return path

    # -- saving -----------------------------------------------------------------------------

    def save(self) -> bool:
        """Save where it was saved before, or ask where."""
        path = self._window.document.path
        return self.save_as() if path is None else self.save_to(path)

    def save_as(self) -> bool:
        """Ask where to save."""
        path = self.ask_target(say("action.save_as"), {SESSION_SUFFIX: "Paintings"})
        return path is not None and self.save_to(path)

    def save_to(self, path: Path) -> bool:
        """Save to a session; say whether that went well."""
        saved = self._posted(path, "save")
        if saved:
            self._window.show_title()
            self._window.tell(say("status.saved", name=path.name), state="good")
            self._remember(str(path))
        return saved

    def _posted(self, path: Path, command: str) -> bool:
        """Have the easel write something, and wait for it with a bar."""
        easel = self._window.stage.easel

        def work(progress: Progress) -> None:
            result_of(easel.post(command, path, progress=progress), progress)

        title = say("Writing {name}…", name=path.name)
        return self.went_well(run_beside(self._window, title, work))

    # -- exporting --------------------------------------------------------------------------

    def export(self) -> None:
        """Ask for a name and a format, then for what can be chosen in that format; write it."""
        kept = self._window.settings.exports
        path = self.ask_target(say("action.export"), _FORMATS, str(kept.get("format", "")))
        if path is None:
            return
        name = path.name.lower()
        suffix = max((s for s in _FORMATS if name.endswith(s)), key=len)
        if suffix == SESSION_SUFFIX:
            self.export_to(path)
            return
        dialog = ExportDialog(
            self._window, suffix, kept_options(kept, suffix), self._window.canvas.pixel_size
        )
        if not dialog.exec():
            return
        kept_now = {**kept, "format": suffix, suffix: dialog.chosen()}
        self._window.keep(exports=kept_now)
        if dialog.is_of_screen:
            self.picture_to(path, dialog.size(), dialog.quality())
        else:
            self.export_to(path, **dialog.options())

    def export_to(self, path: Path, **options: object) -> bool:
        """Write the painting in another format; say whether that went well.

        Parameters
        ----------
        path : Path
            Its suffix says the format.
        **options
            See `ExportOptions`.
        """
        if path.name.lower().endswith(EXPORT_SUFFIXES) and path.suffix.lower() != SESSION_SUFFIX:
            wrote = self._export_beside(path, options)
        else:
            wrote = self._posted(path, "export")
        if wrote:
            self._window.tell(say("status.exported", name=path.name), state="good")
        return wrote

    def _export_beside(self, path: Path, options: Mapping[str, object]) -> bool:
        """Take what is needed from the painting, then write it while that may go on."""
        easel = self._window.stage.easel
        seconds = self._window.document.surface.n_vertices / _VERTICES_A_SECOND

        def work(progress: Progress) -> None:
            progress.expect(0.0, _TAKEN, 1.0 + 2.0 * seconds)
            taken = part_of(progress, 0.0, _TAKEN)
            asked = easel.post("prepare_export", path, ExportOptions(**options), taken)
            prepared = result_of(asked, progress)
            progress.expect(_TAKEN, 0.98, 1.0 + seconds)
            prepared.write(part_of(progress, _TAKEN, 1.0))

        title = say("Writing {name}…", name=path.name)
        return self.went_well(run_beside(self._window, title, work))

    # -- recordings -------------------------------------------------------------------------

    def save_recording(self, first: int = 0) -> None:
        """Ask where, and save the strokes of this sitting from number `first` on."""
        with self._window.stage.easel.paused() as document:
            recording = document.recording(first)
        if recording is None:
            told = say("Strokes: {n}, {seconds:.1f} s", n=0, seconds=0.0)
            self._window.tell(told, state="bad")
            return
        path = self.ask_target(say("Save the strokes as a recording…"), _RECORDINGS)
        if path is None:
            return
        title = say("Writing {name}…", name=path.name)
        done = run_beside(self._window, title, lambda progress: _write(recording, path, progress))
        if self.went_well(done):
            self._window.tell(say("status.exported", name=path.name), state="good")


def _write(recording, path: Path, progress: Progress) -> None:
    progress.expect(0.0, 0.95, 1.0)
    save_recording(recording, path, progress)

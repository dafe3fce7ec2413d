"""Opening, saving, exporting, and the questions that come with them."""

from __future__ import annotations

from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image
from PySide6 import QtCore, QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.sitting import Unfinished, recoverable
from paint3d.app.window.dialogs import NewDialog, ask_unit, implausible
from paint3d.app.window.jobs import Progress, run_beside
from paint3d.app.window.turntable import write_turntable
from paint3d.app.window.warming import warm_up
from paint3d.app.window.wording import say
from paint3d.errors import Paint3DError
from paint3d.files.atomic import write_atomically
from paint3d.files.export import EXPORT_SUFFIXES
from paint3d.files.load import BUILT_IN_OBJECTS, MESH_SUFFIXES, load_mesh
from paint3d.files.session import SESSION_SUFFIX, is_session_path
from paint3d.stroke.recording import load_recording, save_recording

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["FINEST_MM", "Files", "named"]

FINEST_MM = 0.4


def named(name: str) -> str:
    """An object's name in words: a built-in one's in the language that is spoken."""
    return say(f"object.{name}") if name in BUILT_IN_OBJECTS else name


class Files:
    """What the file menu does, for one window.

    Attributes
    ----------
    error : BaseException or None
        What went wrong last.
    quiet : bool
        Keep it there instead of showing it.
    """

    def __init__(self, window: StudioWindow) -> None:
        self._window = window
        self.error: BaseException | None = None
        self.quiet = False
        self._recorded_from = 0

    # -- opening ----------------------------------------------------------------------------

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

    def open(self, resolution: float = FINEST_MM, material: str = "porcelain") -> None:
        """Ask for a file, and open it."""
        meshes = " ".join(f"*{suffix}" for suffix in (SESSION_SUFFIX, *MESH_SUFFIXES))
        kinds = f"{say('Objects and paintings')} ({meshes});;{say('All files')} (*)"
        path, _ = QtWidgets.QFileDialog.getOpenFileName(
            self._window, say("action.open").rstrip("…"), "", kinds
        )
        if path:
            self.open_path(path, resolution, material)

    def open_path(
        self,
        path: str,
        resolution: float | None = FINEST_MM,
        material: str = "porcelain",
        *,
        asked: bool = False,
    ) -> bool:
        """Open a painting, a mesh or a built-in object; say whether that went well.

        Parameters
        ----------
        path : str
        resolution : float or None
            mm; of a mesh.
        material : str
            Of a mesh.
        asked : bool
            Whether it was asked already what becomes of the painting that is open.
        """
        if not asked and self._window.stage.easel is not None and not self.may_leave():
            return False
        compiled = run_beside(
            self._window, say("status.compiling"), lambda progress: warm_up(progress.check)
        )
        if not self.went_well(compiled):
            return False
        name = Path(path).name
        title = say("status.opening", name=named(name))
        if is_session_path(path):
            done = run_beside(self._window, title, lambda _: Document.open(path))
        else:
            done = self._open_mesh(path, title, resolution, material)
        if done is None or not self.went_well(done):
            return False
        self._window.show_document(done.result())
        if path not in BUILT_IN_OBJECTS:
            self._remember(path)
        return True

    def _open_mesh(self, path: str, title: str, resolution: float, material: str) -> Future | None:
        loaded = run_beside(self._window, title, lambda _: load_mesh(path))
        if not self.went_well(loaded):
            return None
        mesh, unit = loaded.result(), None
        size = float(np.ptp(mesh.vertices, axis=0).max())
        if path not in BUILT_IN_OBJECTS and implausible(size):
            unit = ask_unit(self._window, Path(path).name, size)
            if unit is None:
                return None

        def make(_: Progress) -> Document:
            found = load_mesh(path, unit) if unit else mesh
            return Document.new(found, resolution, material, unit=unit)

        return run_beside(self._window, title, make)

    def went_well(self, done: Future) -> bool:
        """Whether work ended well; what went wrong is told."""
        if done.cancelled():
            return False
        error = done.exception()
        if error is None:
            return True
        self.error = error
        if isinstance(error, Paint3DError | OSError) and self.quiet:
            return False
        if isinstance(error, Paint3DError | OSError):
            QtWidgets.QMessageBox.warning(self._window, "paint3d", str(error))
        elif type(error).__name__ == "CancelledError":
            self._window.tell(say("Stopped"))
        else:
            raise error
        return False

    def _remember(self, path: str) -> None:
        """Put a file first among the recent ones."""
        self._window.keep(recent=self._window.settings.with_recent(path).recent)
        self.show_recent()

    def show_recent(self) -> None:
        """Fill the menu of recent files."""
        menu = self._window.recent_menu
        menu.clear()
        for path in self._window.settings.recent:
            if Path(path).exists():
                menu.addAction(Path(path).name, lambda path=path: self.open_path(path))
        menu.setEnabled(bool(menu.actions()))

    # -- saving -----------------------------------------------------------------------------

    def may_leave(self) -> bool:
        """Ask what is to become of unsaved work; False if it is to stay."""
        if self._window.stage.easel is None:
            return True
        with self._window.stage.easel.paused() as document:
            modified = document.modified
        if not modified:
            return True
        document = self._window.document
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

    def save(self) -> bool:
        """Save where it was saved before, or ask where."""
        path = self._window.document.path
        return self.save_as() if path is None else self.save_to(path)

    def save_as(self) -> bool:
        """Ask where to save."""
        path = self._ask_target(say("action.save_as"), say("Paintings"), (SESSION_SUFFIX,))
        return path is not None and self.save_to(path)

    def save_to(self, path: Path) -> bool:
        """Save to a session; say whether that went well."""
        saved = self._posted(say("Writing {name}…", name=path.name), "save", path)
        if saved:
            self._window.show_title()
            self._window.tell(say("status.saved", name=path.name), state="good")
            self._remember(str(path))
        return saved

    def export(self) -> None:
        """Ask for a name, whose suffix is the format."""
        path = self._ask_target(
            say("action.export").rstrip("…"), say("Everything"), EXPORT_SUFFIXES
        )
        if path is not None:
            self.export_to(path)

    def export_to(self, path: Path) -> bool:
        """Write the painting in another format."""
        wrote = self._posted(say("Writing {name}…", name=path.name), "export", path)
        if wrote:
            self._window.tell(say("status.exported", name=path.name), state="good")
        return wrote

    def _posted(self, title: str, command: str, *arguments: object) -> bool:
        """Have the easel do something that takes long, and wait for it with a bar."""
        future = self._window.stage.easel.post(command, *arguments)
        return self.went_well(run_beside(self._window, title, lambda _: future.result()))

    def _ask_target(self, title: str, kind: str, suffixes: tuple[str, ...]) -> Path | None:
        document = self._window.document
        start = document.path or Path(document.surface.source.name + suffixes[0])
        wanted = f"{kind} ({' '.join('*' + suffix for suffix in suffixes)})"
        start = str(start.with_suffix("")) + suffixes[0]
        path, _ = QtWidgets.QFileDialog.getSaveFileName(self._window, title, start, wanted)
        if not path:
            return None
        known = any(path.lower().endswith(suffix) for suffix in suffixes)
        return Path(path if known else path + suffixes[0])

    # -- what a crash left ------------------------------------------------------------------

    def offer_recovery(self) -> bool:
        """Ask about a painting that was never saved; True if it was brought back."""
        left = recoverable()
        if not left:
            return False
        one = left[0]
        box = QtWidgets.QMessageBox(self._window)
        box.setWindowTitle("paint3d")
        name = one.path.name if one.path else named(one.object_name)
        when = QtCore.QDateTime.fromSecsSinceEpoch(int(one.time_s))
        box.setText(say("ask.recover", name=name, time=when.toString("yyyy-MM-dd hh:mm:ss")))
        role = QtWidgets.QMessageBox.ButtonRole
        back = box.addButton(say("button.recover"), role.AcceptRole)
        away = box.addButton(say("button.delete"), role.DestructiveRole)
        box.addButton(say("button.later"), role.RejectRole)
        box.setDefaultButton(back)
        box.exec()
        if box.clickedButton() is away:
            one.discard()
        if box.clickedButton() is not back:
            return False
        return self.recover(one)

    def recover(self, one: Unfinished) -> bool:
        """Bring a painting back; what it was kept in is deleted once it is kept anew."""
        title = say("status.opening", name=named(one.object_name))
        done = run_beside(self._window, title, lambda _: one.recover())
        if not self.went_well(done):
            return False
        back = done.result()
        self._window.show_document(back.document)
        one.discard()
        self._window.tell(say("Brought back; save it to keep it"), state="good")
        return True

    # -- recordings and pictures ------------------------------------------------------------

    def save_recording(self, first: int = 0) -> None:
        """Ask where, and save the strokes of this sitting from number `first` on."""
        path = self._ask_target(
            say("action.export").rstrip("…"), say("Recordings"), (".jsonl", ".jsonl.gz", ".inkml")
        )
        if path is None:
            return
        with self._window.stage.easel.paused() as document:
            recording = document.recording(first)
        if recording is None:
            self._window.tell(
                say("{n} strokes, {seconds:.1f} s").format(n=0, seconds=0), state="bad"
            )
            return
        done = run_beside(self._window, path.name, lambda _: save_recording(recording, path))
        self.went_well(done)

    def replay(self) -> None:
        """Ask for a recording, and paint it on what is here."""
        kinds = f"{say('Recordings')} (*.jsonl *.jsonl.gz *.inkml *.csv);;{say('All files')} (*)"
        path, _ = QtWidgets.QFileDialog.getOpenFileName(
            self._window, say("action.replay"), "", kinds
        )
        if path:
            self.replay_file(path, self._window.panels.history.speed())

    def replay_file(self, path: str, speed: float | None = None) -> bool:
        """Paint a recording on what is here, as if by hand; say whether that began.

        Parameters
        ----------
        path : str
        speed : float, optional
            Of the recording's own time; by default as fast as it goes.
        """
        loaded = run_beside(self._window, Path(path).name, lambda _: load_recording(path))
        if not self.went_well(loaded):
            return False
        self._window.player.play(list(loaded.result().samples()), speed)
        return True

    def refine(self) -> None:
        """Refine the whole surface now, with a bar; if it is stopped, what was done stays."""

        def work(progress: Progress) -> None:
            future = self._window.stage.easel.post(
                lambda document: document.surface.refine_all(progress)
            )
            future.result()

        if self.went_well(run_beside(self._window, say("Refining the surface…"), work)):
            count = self._window.document.surface.n_vertices
            self._window.tell(say("status.vertices", count=count), state="good")

    def screenshot(self) -> None:
        """Save the picture as it is seen."""
        path = self._ask_target(say("action.screenshot"), say("Picture"), (".png",))
        if path is not None:
            self.screenshot_to(path)

    def screenshot_to(self, path: Path) -> None:
        """Write the picture as it is seen, without what lies over it."""
        pixels = self._window.stage.picture()[::-1, :, :3]
        try:
            with write_atomically(path) as part:
                Image.fromarray(pixels).save(part, format="PNG")
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(self._window, "paint3d", str(error))
            return
        self._window.tell(say("status.exported", name=path.name), state="good")

    def turntable(self) -> None:
        """Save a film of the object turning."""
        path = self._ask_target(say("action.turntable"), say("Film"), (".gif", ".webp"))
        if path is not None:
            self.turntable_to(path)

    def turntable_to(self, path: Path, n_frames: int = 72) -> None:
        """Write a film of the object turning once."""
        window = self._window
        window.stage.hide_brush()
        try:
            write_turntable(window, path, n_frames)
        except Paint3DError as error:
            QtWidgets.QMessageBox.warning(window, "paint3d", str(error))
            return
        window.tell(say("status.exported", name=path.name), state="good")

    # -- by the name of the action ----------------------------------------------------------

    def do_new(self) -> None:
        """Begin a painting."""
        self.new()

    def do_open(self) -> None:
        """Ask for a file, and open it."""
        self.open(self._window.settings.resolution_mm, self._window.settings.material)

    def do_save(self) -> None:
        """Save where it was saved before, or ask where."""
        self.save()

    def do_save_as(self) -> None:
        """Ask where to save."""
        self.save_as()

    def do_export(self) -> None:
        """Ask for a name, whose suffix is the format."""
        self.export()

    def do_save_recording(self) -> None:
        """Save the strokes of this sitting."""
        self.save_recording()

    def do_record(self, on: bool) -> None:
        """Remember where the recording begins; when it ends, ask where to save it."""
        strokes = len(self._window.document.strokes)
        if on:
            self._recorded_from = strokes
            self._window.tell(say("status.recording"), state="good")
        elif strokes > self._recorded_from:
            self.save_recording(self._recorded_from)

    def do_replay(self) -> None:
        """Ask for a recording, and paint it on what is here."""
        self.replay()

    def do_screenshot(self) -> None:
        """Save the picture as it is seen."""
        self.screenshot()

    def do_turntable(self) -> None:
        """Save a film of the object turning."""
        self.turntable()

    def do_quit(self) -> None:
        """Leave."""
        self._window.close()

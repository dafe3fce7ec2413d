"""What the file menu does: opening, saving, exporting, recordings, pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6 import QtWidgets

from paint3d.app.window.jobs.job import Progress, result_of, run_beside
from paint3d.app.window.jobs.opening import Opening
from paint3d.app.window.jobs.pictures import Pictures
from paint3d.app.window.jobs.saving import Saving
from paint3d.app.window.named import named
from paint3d.app.window.wording import say
from paint3d.recording.recording import load_recording

if TYPE_CHECKING:
    from paint3d.app.window.studio import StudioWindow

__all__ = ["Files", "named"]


class Files(Opening, Pictures, Saving):
    """What the file menu does, for one window; see `Opening`, `Saving` and `Pictures`."""

    def __init__(self, window: StudioWindow) -> None:
        self._window = window
        self.error: BaseException | None = None
        self.quiet = False
        self._recorded_from = 0
        self._folder: Path | None = None

    # -- recordings -------------------------------------------------------------------------

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
        title = say("status.opening", name=Path(path).name)
        loaded = run_beside(self._window, title, lambda _: load_recording(path))
        if not self.went_well(loaded):
            return False
        self._window.player.play(list(loaded.result().samples()), speed)
        return True

    # -- the surface ------------------------------------------------------------------------

    def refine(self) -> None:
        """Refine the whole surface now, with a bar; if it is stopped, it is as it was."""
        easel = self._window.stage.easel

        def work(progress: Progress) -> None:
            result_of(easel.post(lambda document: document.surface.refine_all(progress)), progress)

        if self.went_well(run_beside(self._window, say("Refining the surface…"), work)):
            count = self._window.document.surface.n_vertices
            self._window.tell(say("status.vertices", count=count), state="good")

    # -- by the name of the action ----------------------------------------------------------

    def do_new(self) -> None:
        """Begin a painting."""
        self.new()

    def do_open(self) -> None:
        """Ask for a file, and open it."""
        self.open()

    def do_save(self) -> None:
        """Save where it was saved before, or ask where."""
        self.save()

    def do_save_as(self) -> None:
        """Ask where to save."""
        self.save_as()

    def do_export(self) -> None:
        """Ask for a name and a format, and how it is to be written."""
        self.export()

    def do_save_recording(self) -> None:
        """Save the strokes of this sitting."""
        self.save_recording()

    def do_record(self, on: bool) -> None:
        """Remember where the recording begins; when it ends, ask where to save it."""
        strokes = len(self._window.document.strokes)
        if on:
            self._recorded_from = strokes
            self._window.tell(say("status.recording"), state="good", stays=True)
            return
        self._window.tell(say("hint.turn"))
        if strokes > self._recorded_from:
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

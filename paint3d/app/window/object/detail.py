"""The detail of the open painting: asked for, and everything painted anew with it."""

from __future__ import annotations

from PySide6 import QtWidgets

from paint3d.app.model.document import Document
from paint3d.app.model.score.playing import painted
from paint3d.app.window.files.open_result import OpenResult, open_with_progress
from paint3d.app.window.forms import FormDialog
from paint3d.app.window.job import JobProgress, result_of
from paint3d.app.window.wording import say, say_length
from paint3d.app.window.workspace import Workspace
from paint3d.errors import InputError
from paint3d.files.progress import part_of

__all__ = ["Detail"]

_FINEST_MM, _COARSEST_MM = 0.05, 10.0
_PAINTED = 0.85  # of the progress, before it is shown


class Detail:
    """Changes how far apart the vertices of the open painting lie.

    Parameters
    ----------
    workspace : Workspace
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace

    @property
    def can_paint_anew(self) -> bool:
        """True if it is known how the painting was painted, from its bare object on."""
        with self._workspace.paint_thread.paused() as document:
            recorder = None if document is None else document.recorder
            return recorder is not None and recorder.is_whole

    def do_set_detail(self) -> None:
        """Ask for another detail, and paint everything anew with it."""
        workspace = self._workspace
        spacing = workspace.painting.resolution or workspace.settings.resolution_mm
        dialog = FormDialog(workspace.window, say("Paint anew at another detail…").rstrip("…"))
        note = QtWidgets.QLabel(say("All that was painted is painted anew, as finely as this"))
        note.setWordWrap(True)
        dialog.form.addRow(note)
        number = dialog.add_number(say("Detail"), _FINEST_MM, _COARSEST_MM, spacing, "mm", 2)
        number.setSingleStep(0.05)
        dialog.finish(say("Paint anew"))
        if dialog.exec() and abs(number.value() - spacing) >= 0.005:
            self.paint_anew(number.value())
        dialog.deleteLater()

    def paint_anew(self, detail_mm: float) -> bool:
        """Paint the open painting anew on vertices so far apart, mm; return whether it is.

        Its file, its undo steps, the view and the inks in hand stay.
        """
        workspace = self._workspace
        workspace.hand.interrupt()
        paint_thread, camera = workspace.paint_thread, workspace.hand.camera

        def work(progress: JobProgress) -> OpenResult:
            asked = paint_thread.post(lambda document: (document, document.score))
            before, score = result_of(asked, progress)
            if score is None:
                raise InputError(
                    "it is not known how this painting began; expected one that was painted from "
                    "its bare object on"
                )
            document = painted(
                score, before.surface.source, detail_mm, before.surface.material,
                part_of(progress, 0.0, _PAINTED),
            )  # fmt: skip
            _go_on_from(document, before)
            return open_with_progress(document, progress, _PAINTED)

        done = workspace.run(say("Painting anew…"), work)
        if not workspace.went_well(done) or not workspace.show(done.result()):
            return False
        if camera is not None:
            workspace.hand.look(camera)
        workspace.tell(
            say("The detail is {detail} now", detail=say_length(detail_mm)), state="good"
        )
        return True


def _go_on_from(document: Document, before: Document) -> None:
    """Give a painting the file, the inks, the properties and the memory of the one before."""
    document.set_file(before.path, before.file_state)
    document.unit = before.unit
    document.inks[:] = before.inks
    document.properties.update(before.properties)
    document.steps.memory_budget = before.steps.memory_budget
    document.mark_modified()

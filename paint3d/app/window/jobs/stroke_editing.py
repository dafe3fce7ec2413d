"""Edits of one stroke of the history; what comes after it is painted anew, with a bar."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from PySide6 import QtWidgets

from paint3d.app.window.dialogs.stroke_dialogs import MoveDialog, TimeDialog
from paint3d.app.window.input.stroke_drag import StrokeDrag
from paint3d.app.window.input.stroke_mark import StrokeMark
from paint3d.app.window.jobs.job import Progress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = ["StrokeEditing"]


class StrokeEditing:
    """For one window.

    Parameters
    ----------
    workspace : Workspace
    mark : StrokeMark
        Shows the stroke that is edited.

    Attributes
    ----------
    drag : StrokeDrag
        Of the next stroke that is to be moved so.
    """

    def __init__(self, workspace: Workspace, mark: StrokeMark) -> None:
        self._workspace, self._mark = workspace, mark
        drag = self.drag = StrokeDrag(workspace, workspace.canvas, mark.stroke_at)
        drag.chosen.connect(mark.choose)
        drag.dragged.connect(
            lambda number, ends: self.edit(number, {"do": "move", "to": [e.tolist() for e in ends]})
        )

    def ask(self, what: str, number: int) -> None:
        """Do what was chosen for a stroke.

        Parameters
        ----------
        what : {"pick", "delete", "drag", "move", "ink", "brush", "time"}
            "pick": one is to be chosen on the object, whatever the number.
        number : int
            Place of the stroke in the history, from 0.
        """
        workspace, document = self._workspace, self._workspace.document
        if what == "pick":
            self._mark.choose(None)
            self.drag.begin()
            return
        strokes = [*document.strokes, *document.undone_strokes]
        if not 0 <= number < len(strokes):
            return
        self.drag.end()
        self._mark.choose(number)
        if what == "drag":
            self.drag.begin(number)
            return
        edit: Mapping[str, Any] | None = {"do": what}
        if what == "ink":
            edit = {"do": "ink", "ink": document.painter.dipped}
        elif what == "brush":
            edit = {"do": "brush", "brush": workspace.easel.brush}
        elif what == "move":
            edit = _answer(MoveDialog(workspace.window, number + 1))
        elif what == "time":
            edit = _answer(TimeDialog(workspace.window, number + 1, strokes[number].duration_s))
        if edit is not None:
            self.edit(number, edit)

    def edit(self, number: int, edit: Mapping[str, Any]) -> bool:
        """Edit a stroke; say whether that went well.

        Parameters
        ----------
        number : int
            Place of the stroke in the history, from 0.
        edit : mapping
            See `Document.edit_stroke`.
        """
        workspace = self._workspace
        easel, document = workspace.easel, workspace.document

        def work(progress: Progress) -> None:
            document.progress = progress
            try:
                easel.post("edit_stroke", number, edit).result()
            finally:
                document.progress = None

        began = time.perf_counter()
        after = len(document.strokes) + len(document.undone_strokes) - number - 1
        title = say("Painting what comes after stroke {n} again…", n=number + 1)
        if not workspace.went_well(workspace.run(title, work)):
            return False
        seconds = time.perf_counter() - began
        workspace.tell(
            say("Stroke {n}: done; {after} after it painted again in {seconds:.1f} s; "
                "undo takes it back until the painting is closed",
                n=number + 1, after=after, seconds=seconds),
            state="good",
        )  # fmt: skip
        self._mark.choose(None)
        if edit["do"] != "delete":
            self._mark.choose(number)
        return True


def _answer(dialog: MoveDialog | TimeDialog) -> Mapping[str, Any] | None:
    accepted = dialog.exec() == QtWidgets.QDialog.DialogCode.Accepted
    return dialog.edit if accepted else None

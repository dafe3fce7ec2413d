"""Going back in the history of strokes, and editing strokes, which repaints what follows."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from PySide6 import QtCore, QtWidgets

from paint3d.app.window.forms import FormDialog
from paint3d.app.window.history.stroke_choosing import StrokeChooser
from paint3d.app.window.history.stroke_mark import StrokeDrag, StrokeMark
from paint3d.app.window.job import JobProgress
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace

__all__ = [
    "MoveDialog",
    "Recalling",
    "ShapeDialog",
    "StrokeEditing",
    "TimeDialog",
]


class Recalling:
    """Going back in the history of strokes, which may paint them again.

    Parameters
    ----------
    workspace : Workspace
    refused : callable
        Called when it was stopped, or failed.
    """

    def __init__(self, workspace: Workspace, refused: Callable[[], None]) -> None:
        self._workspace, self._refused = workspace, refused

    def go_to(self, upto: int, passing: bool = False) -> None:
        """Show the painting as it was after so many strokes.

        Parameters
        ----------
        upto : int
        passing : bool
            Only to look at; see `Document.replay_history`.
        """
        workspace = self._workspace
        paint_thread, painting = workspace.paint_thread, workspace.painting
        if upto >= painting.n_strokes_without_undo or upto < painting.fewest_strokes:
            workspace.post("replay_history", upto, passing)
            return

        def work(progress: JobProgress) -> None:
            with paint_thread.reporting(progress):
                paint_thread.post("replay_history", upto, passing).result()

        count = painting.n_strokes_without_undo
        title = say("Repainting {n} strokes to go back to them…", n=count)
        if workspace.went_well(workspace.run(title, work)):
            workspace.tell(
                say("{n} strokes were repainted; drying between them is not repeated", n=count)
            )
        else:
            self._refused()

    def undo(self) -> None:
        """Undo the last step; where no step is saved, repaint the strokes before it."""
        painting, paint_thread = self._workspace.painting, self._workspace.paint_thread
        if paint_thread.is_behind or painting.has_steps or not painting.can_undo:
            self._workspace.post("undo")
        else:
            self.go_to(len(painting.strokes) - 1)


# ---- Dialogs -------------------------------------------------------------------------------------
# A stroke's distance, shape and time.


_FARTHEST_MM, _LATEST_S = 2000.0, 600.0
_SHORTEST_S, _LONGEST = 0.01, 100.0  # s, and times as long


class MoveDialog(FormDialog):
    """Asks how far a stroke moves along the surface and turns about its normal.

    Parameters
    ----------
    parent : QWidget
    number : int
        Of the stroke, from 1.
    """

    def __init__(self, parent: QtWidgets.QWidget, number: int) -> None:
        super().__init__(parent, say("Move stroke {n}", n=number))
        far = _FARTHEST_MM
        self.right = self.add_number(say("To the right (x)"), -far, far, 0.0, "mm", 2)
        self.up = self.add_number(say("Upwards (y)"), -far, far, 0.0, "mm", 2)
        self.turn = self.add_number(say("Turn to the left"), -360.0, 360.0, 0.0, "°", 1)
        self.finish(say("Move"))

    @property
    def edit(self) -> dict[str, Any]:
        """The chosen edit, as `score_edits.apply_stroke_edit` takes it."""
        along = [self.right.value(), self.up.value()]
        return {"do": "move", "along": along, "turn_deg": self.turn.value()}


class ShapeDialog(FormDialog):
    """Asks how far several strokes are moved along the surface, turned about it, and scaled.

    Parameters
    ----------
    parent : QWidget
    count : int
        Of the strokes.
    """

    def __init__(self, parent: QtWidgets.QWidget, count: int) -> None:
        title = say("Move, turn and scale {n} stroke", "Move, turn and scale {n} strokes", n=count)
        super().__init__(parent, title)
        far = _FARTHEST_MM
        self.right = self.add_number(say("To the right (x)"), -far, far, 0.0, "mm", 2)
        self.up = self.add_number(say("Upwards (y)"), -far, far, 0.0, "mm", 2)
        self.turn = self.add_number(say("Turn to the left"), -360.0, 360.0, 0.0, "°", 1)
        self.scale = self.add_number(say("Scale"), 5.0, 2000.0, 100.0, "%", 1)
        self.finish(say("Change"))

    @property
    def edits(self) -> list[dict[str, Any]]:
        """The chosen edits, each as `score_edits.apply_stroke_edit` takes it."""
        along, turn = [self.right.value(), self.up.value()], self.turn.value()
        chosen: list[dict[str, Any]] = []
        if any(along) or turn:
            chosen.append({"do": "move", "along": along, "turn_deg": turn})
        if self.scale.value() != 100.0:
            chosen.append({"do": "scale", "factor": 0.01 * self.scale.value()})
        return chosen


class TimeDialog(FormDialog):
    """Asks how long a stroke is to take, and how much later it is to begin.

    Parameters
    ----------
    parent : QWidget
    number : int
        Of the stroke, from 1.
    seconds : float
        That it takes now.
    """

    def __init__(self, parent: QtWidgets.QWidget, number: int, seconds: float) -> None:
        super().__init__(parent, say("Time of stroke {n}", n=number))
        self._was = seconds
        least, longest = min(_SHORTEST_S, seconds), max(1.0, _LONGEST * seconds)
        self.seconds = self.add_number(say("It takes"), least, longest, seconds, "s", 2)
        late = _LATEST_S
        self.shift = self.add_number(say("It begins later by"), -late, late, 0.0, "s", 2)
        self.finish(say("Change"))

    @property
    def edit(self) -> dict[str, Any]:
        """The chosen edit, as `score_edits.apply_stroke_edit` takes it."""
        words: dict[str, Any] = {"do": "time", "shift_s": self.shift.value()}
        if abs(self.seconds.value() - self._was) > 0.005:  # of what the box shows
            words["seconds"] = self.seconds.value()
        return words


# ---- Editing -------------------------------------------------------------------------------------


class StrokeEditing:
    """Edits of strokes, from the history, the menus and the picture.

    Parameters
    ----------
    workspace : Workspace
    mark : StrokeMark
        Shows the stroke that is edited.

    Attributes
    ----------
    drag : StrokeDrag
        Of the next stroke that is to be moved so.
    chooser : StrokeChooser
        Of several.
    """

    def __init__(self, workspace: Workspace, mark: StrokeMark) -> None:
        self._workspace, self._mark = workspace, mark
        drag = self.drag = StrokeDrag(workspace, mark.stroke_at)
        drag.chosen.connect(mark.choose)
        drag.dragged.connect(
            lambda index, ends: self.run_edit(
                [index], {"do": "move", "to": [e.tolist() for e in ends]}
            )
        )
        self.chooser = StrokeChooser(workspace, mark)
        self.chooser.edited.connect(self.edit_chosen)
        self.chooser.turned_on.connect(self._show_choosing)

    # -- several ----------------------------------------------------------------------------

    def do_choose_strokes(self, on: bool) -> None:
        """Switch between drags that choose strokes and drags that paint."""
        if on:
            self.chooser.begin()
        else:
            self.chooser.end()

    def _show_choosing(self, on: bool) -> None:
        action = self._workspace.actions["choose_strokes"]
        with QtCore.QSignalBlocker(action):
            action.setChecked(on)

    def do_mirror_strokes(self) -> None:
        """Mirror the chosen strokes, left and right."""
        self.edit_chosen({"do": "mirror"})

    def do_ink_strokes(self) -> None:
        """Paint the chosen strokes in the ink in hand."""
        self.edit_chosen({"do": "ink", "ink": self._workspace.painting.dipped})

    def do_brush_strokes(self) -> None:
        """Paint the chosen strokes with the brush in hand."""
        self.edit_chosen({"do": "brush", "brush": self._workspace.paint_thread.brush})

    def do_delete_strokes(self) -> None:
        """Delete the chosen strokes."""
        self.edit_chosen({"do": "delete"})

    def do_shape_strokes(self) -> None:
        """Ask how far the chosen strokes are moved, turned and scaled."""
        if self._are_chosen():
            dialog = ShapeDialog(self._workspace.window, len(self._mark.indices))
            if dialog.exec() == QtWidgets.QDialog.DialogCode.Accepted:
                for edit in dialog.edits:
                    if not self.edit_chosen(edit):
                        break

    def _are_chosen(self) -> bool:
        if not self._mark.indices:
            self._workspace.tell(say("No stroke is chosen; press Q and draw a loop"), state="bad")
        return bool(self._mark.indices)

    def edit_chosen(self, edit: Mapping[str, Any]) -> bool:
        """Edit the chosen strokes as one; return whether that succeeded."""
        return self._are_chosen() and self.run_edit(self._mark.indices, edit)

    # -- one --------------------------------------------------------------------------------

    def ask(self, what: str, index: int) -> None:
        """Do an edit of a stroke, after asking for its numbers.

        Parameters
        ----------
        what : {"pick", "delete", "drag", "move", "ink", "brush", "time"}
            "pick": one is to be chosen on the object, whatever the number.
        index : int
            Of the stroke in the history, from 0.
        """
        workspace, painting = self._workspace, self._workspace.painting
        if what == "pick":
            self._mark.choose(None)
            self.drag.begin()
            return
        strokes = [*painting.strokes, *painting.undone_strokes]
        if not 0 <= index < len(strokes):
            return
        self.drag.end()
        self._mark.choose(index)
        if what == "drag":
            self.drag.begin(index)
            return
        edit: Mapping[str, Any] | None = {"do": what}
        if what == "ink":
            edit = {"do": "ink", "ink": painting.dipped}
        elif what == "brush":
            edit = {"do": "brush", "brush": workspace.paint_thread.brush}
        elif what == "move":
            edit = _answer(MoveDialog(workspace.window, index + 1))
        elif what == "time":
            edit = _answer(TimeDialog(workspace.window, index + 1, strokes[index].duration_s))
        if edit is not None:
            self.run_edit([index], edit)

    def run_edit(self, indices: Sequence[int], edit: Mapping[str, Any]) -> bool:
        """Edit strokes, several as one; return whether that succeeded.

        Parameters
        ----------
        indices : sequence of int
            Of the strokes in the history, from 0.
        edit : mapping
            See `Document.edit_strokes`.
        """
        workspace = self._workspace
        paint_thread, painting = workspace.paint_thread, workspace.painting

        def work(progress: JobProgress) -> None:
            with paint_thread.reporting(progress):
                paint_thread.post("edit_strokes", list(indices), edit).result()

        began = time.perf_counter()
        first = min(indices)
        after = len(painting.strokes) + len(painting.undone_strokes) - first - 1
        title = say("Repainting what follows stroke {n}…", n=first + 1)
        if not workspace.went_well(workspace.run(title, work)):
            return False
        seconds = time.perf_counter() - began
        message = say(
            "Stroke {n} edited; {after} after it repainted in {seconds:.1f} s; undo takes it back "
            "until the painting is closed",
            n=first + 1, after=after, seconds=seconds,
        )  # fmt: skip
        if len(indices) > 1:
            message = say(
                "{n} stroke edited in {seconds:.1f} s; undo takes it back until the painting is "
                "closed",
                "{n} strokes edited in {seconds:.1f} s; undo takes it back until the painting is "
                "closed",
                n=len(indices), seconds=seconds,
            )  # fmt: skip
        workspace.tell(message, state="good")
        self._mark.choose(None)
        if edit["do"] != "delete":
            self._mark.choose_all(indices)
        return True


def _answer(dialog: MoveDialog | TimeDialog) -> Mapping[str, Any] | None:
    accepted = dialog.exec() == QtWidgets.QDialog.DialogCode.Accepted
    return dialog.edit if accepted else None

"""A document's way back and again: undo, redo, replays, its strokes as a recording."""

from __future__ import annotations

from collections.abc import Callable

from paint3d.app.model.recall_commands import RecallCommands
from paint3d.app.model.stroke_log import Stroke, StrokeLog, weights_of
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.painter.painter import Painter
from paint3d.surface.ink_store import union
from paint3d.surface.painted_surface import PaintedSurface
from paint3d.surface.undo import UndoHistory

__all__ = ["EDIT_STEP", "HistoryCommands"]

EDIT_STEP = "edit"
"""Label of a step of an edit that no stroke begins: it is taken back with the step before it, and
done again with the one after it."""


class HistoryCommands(RecallCommands):
    """The history of a `Document`."""

    surface: PaintedSurface
    painter: Painter
    modified: bool
    _saved_at: int | None
    _passing: bool = False
    _looking: bool = False  # strokes were undone to look at what was before
    _dipped: bool
    _log: StrokeLog
    _undo: UndoHistory
    _note: Callable[[AnyArray], None]
    break_off: Callable[[], None]  # the document's other commands bring it along

    @property
    def steps(self) -> UndoHistory:
        """What can be undone, step by step."""
        return self._undo

    @property
    def can_undo(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._undo.done) or self.earliest_stroke < self.oldest_stroke

    @property
    def can_redo(self) -> bool:
        """Whether there is something to do again."""
        return bool(self._undo.undone)

    @property
    def looks_back(self) -> bool:
        """Whether strokes were undone by `replay_history` and not done again since."""
        return self._looking

    def undo(self) -> AnyArray:
        """Take back the last step; the brush stays the one that was chosen last.

        Where a stroke is the last that was done and no step takes it back, all are painted again
        first; see `recall_strokes`.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.
        """
        self.break_off()
        return self._step_back()

    def _step_back(self) -> AnyArray:
        self._passing = self._looking = False
        if not self._undo.done and self.can_undo:
            self.recall_strokes()
        painter, steps = self.painter, self._undo
        brush, dipped, amount = painter.brush, painter.dipped, painter.amount
        touched = []
        while steps.done and steps.done[-1] == EDIT_STEP:
            touched.append(steps.undo())
        touched.append(steps.undo())
        held = painter.brush, weights_of(painter.dipped), painter.amount
        if held != (brush, weights_of(dipped), amount):
            painter.change_brush(brush)
            painter.dip(dipped, amount=amount)
            self._dipped = True
        return self._stepped(union(touched, self.surface.paint_mesh.capacity))

    def redo(self) -> AnyArray:
        """Do again what was undone last; returns as `undo`."""
        self.break_off()
        return self._step_forth()

    def _step_forth(self) -> AnyArray:
        self._passing = self._looking = False
        steps = self._undo
        touched = [steps.redo()]
        while steps.undone and steps.done[-1] == EDIT_STEP:
            touched.append(steps.redo())
        return self._stepped(union(touched, self.surface.paint_mesh.capacity))

    def _follow_log(self) -> None:
        """Have the strokes of the steps that are done."""
        self._log.follow([label for label in self._undo.done if isinstance(label, Stroke)])

    def _stepped(self, touched: AnyArray) -> AnyArray:
        self._follow_log()
        self.compare_with_saved()
        self._note(touched)
        return touched

    def compare_with_saved(self) -> None:
        """See whether the steps that are done are those with which it was saved."""
        self.modified = self._undo.next_undo != self._saved_at

    @property
    def undone_strokes(self) -> list[Stroke]:
        """Strokes that were taken back and can be done again, the next one first."""
        return [label for label in reversed(self._undo.undone) if isinstance(label, Stroke)]

    def replay_history(self, upto: int, passing: bool = False) -> AnyArray:
        """Show the painting as it was before the next stroke began, by undo and redo.

        Strokes that no step takes back are painted again where that is needed; see
        `recall_strokes`.

        Parameters
        ----------
        upto : int
            After how many strokes: from `earliest_stroke` to as many as there are with those that
            were undone.
        passing : bool
            Only to look at: what is painted next comes after all strokes, not in their stead.

        Returns
        -------
        (N,) int32
            Vertices whose colours may have changed.

        Raises
        ------
        InputError
            If there are not so many, or they lie over a recording.
        """
        self.break_off()
        most = len(self.strokes) + len(self.undone_strokes)
        if not self.earliest_stroke <= upto <= most:
            raise InputError(
                f"stroke {upto} of the history; expected {self.earliest_stroke} to {most}"
            )
        touched: list[AnyArray] = []
        if upto < self.oldest_stroke:
            touched.append(self.recall_strokes())
        while len(self.strokes) > upto:
            touched.append(self._step_back())
        while len(self.strokes) < upto or self._next_is_no_stroke():
            touched.append(self._step_forth())
        self._passing, self._looking = passing, upto < most
        return union(touched, self.surface.paint_mesh.capacity)

    def _come_back(self) -> None:
        """Do all again that was undone only to look at what was before."""
        if self._passing:
            self.replay_history(len(self.strokes) + len(self.undone_strokes))

    def _next_is_no_stroke(self) -> bool:
        """Whether what can be done again next is drying, or a change of the layers."""
        undone = self._undo.undone
        return bool(undone) and not isinstance(undone[-1], Stroke)

    def recording(self, first: int = 0) -> Recording | None:
        """The strokes from number `first` on as one recording in the object's frame, with dips.

        None if there are none.
        """
        return self._log.recording(self.surface.source.name, first)

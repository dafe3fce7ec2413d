"""Undo of edits of strokes: the painting before an edit, and after it.

An edit goes back to where its stroke began, by undo, and plays the edited score from there. Steps
that there were are set aside, so that undo of the edit brings the painting back as it was, to
the bit, in one step; and redo the edited one.
"""

from __future__ import annotations

from dataclasses import dataclass

from paint3d.app.model.score.recorder import ScoreRecorder
from paint3d.core.arrays import AnyArray
from paint3d.device.recorded import Recording
from paint3d.errors import InputError
from paint3d.recording.score import Score
from paint3d.recording.score_steps import follow_steps
from paint3d.surface.undo import Step, UndoHistory

__all__ = [
    "EditHistory",
    "Turned",
    "Version",
    "first_difference",
    "locate_strokes",
    "without_refusals",
]

_PAINTS = frozenset({"begin_stroke", "dry", "blot", "press_seal", "merge_layer"})
"""Commands that need a visible, unlocked layer."""

Turned = tuple[list[AnyArray], ScoreRecorder | None]
"""Vertices (N,) int32 whose colours may have changed, and the recorder of the painting as it is."""


@dataclass(eq=False)
class Version:
    """The painting with or without an edit: the undo steps that lead to it.

    Attributes
    ----------
    n_shared : int
        Steps that both have.
    redo_stack : list of Step
        Those to do again after them, the next one last.
    n_redo : int
        How many of them are to be done.
    later_step : Step
        What came since an undo, to do again after them.
    recorder : ScoreRecorder or None
    last_step : int
        Number of the last step of the version that is there now.
    other_last_step : int
        And of the other one.
    newest : int
        Number of the newest step when the versions were exchanged.
    """

    n_shared: int
    redo_stack: list[Step]
    n_redo: int
    later_step: Step
    recorder: ScoreRecorder | None
    last_step: int
    other_last_step: int
    newest: int


class EditHistory:
    """The edits that undo and redo lead over.

    Parameters
    ----------
    steps : UndoHistory
        Of the painting.
    """

    def __init__(self, steps: UndoHistory) -> None:
        self._steps = steps
        self._done: list[Version] = []
        self._undone: list[Version] = []

    @property
    def n_done(self) -> int:
        """Number of edits that undo can take back."""
        return len(self._done)

    @property
    def has_any(self) -> bool:
        """True if undo or redo may lead over an edit, which no file keeps."""
        return bool(self._done or self._undone)

    @property
    def ends_here(self) -> bool:
        """True if the last thing that was done is an edit."""
        return bool(self._done) and self._done[-1].last_step == self._steps.next_undo

    @property
    def continues_here(self) -> bool:
        """True if the next thing to do again is an edit."""
        last = self._undone[-1] if self._undone else None
        if last is None:
            return False
        return last.last_step == self._steps.next_undo and last.newest == self._steps.newest

    def add(self, version: Version) -> None:
        """Add an edit that has just been done; the version is the painting without it."""
        version.last_step = self._steps.next_undo
        self._done.append(version)
        self._undone.clear()

    def undo(self, recorder: ScoreRecorder | None) -> Turned:
        """Take the last edit back.

        Parameters
        ----------
        recorder : ScoreRecorder or None
            Of the painting as it is.

        Returns
        -------
        Turned
        """
        return self._exchange_last(self._done, self._undone, recorder)

    def redo(self, recorder: ScoreRecorder | None) -> Turned:
        """Do the next edit again; see `undo`."""
        return self._exchange_last(self._undone, self._done, recorder)

    def _exchange_last(
        self, one: list[Version], other: list[Version], recorder: ScoreRecorder | None
    ) -> Turned:
        version = one.pop()
        touched = self.exchange(version)
        version.newest = self._steps.newest
        other.append(version)
        back, version.recorder = version.recorder, recorder
        return touched, back

    def exchange(self, version: Version) -> list[AnyArray]:
        """Undo to where the versions part, and redo in the other one; see `undo`."""
        steps = self._steps
        later_step, ids = steps.lay_aside_since()
        count = len(steps.done) - version.n_shared
        touched = [ids, *(steps.undo() for _ in range(count))]
        redo_stack = steps.exchange_undone(version.redo_stack)
        touched += [steps.redo() for _ in range(version.n_redo)]
        touched.append(steps.resume_since(version.later_step))
        version.redo_stack, version.n_redo, version.later_step = redo_stack, count, later_step
        version.last_step, version.other_last_step = version.other_last_step, version.last_step
        return touched


def locate_strokes(score: Score, n_done: int, n_undone: int) -> list[tuple[int, int]]:
    """Of the strokes that are there and those that were undone: number in the score, and event.

    Raises
    ------
    InputError
        If they are others than the score's.
    """
    steps = follow_steps(score)
    if (len(steps.done), len(steps.undone)) != (n_done, n_undone):
        raise InputError(
            "the score has {n} strokes there and {steps_undone} undone; expected {there} and "
            "{undone}, as in the painting",
            n=len(steps.done),
            steps_undone=len(steps.undone),
            there=n_done,
            undone=n_undone,
        )
    return [(stroke.number, stroke.begin) for stroke in (*steps.done, *steps.undone)]


def first_difference(one: Score, other: Score) -> int:
    """The first event in which two scores differ."""
    for k, (a, b) in enumerate(zip(one.events, other.events, strict=False)):
        if a is not b and (isinstance(a, Recording) or isinstance(b, Recording) or a != b):
            return k
    return min(len(one.events), len(other.events))


def without_refusals(score: Score, first: int) -> Score:
    """A score without what a locked or hidden layer refused, from an event on.

    While an edited score is played all layers are visible and unlocked: it would be done.
    """
    events = [
        {"do": "end_stroke"} if k >= first and not isinstance(event, Recording)
        and event.get("refused") and event["do"] in _PAINTS else event
        for k, event in enumerate(score.events)
    ]  # fmt: skip
    return Score(score.header, tuple(events), score.lines, score.name)

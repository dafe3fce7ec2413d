"""State of the strokes of a score: those present at its end, and those that undo takes back.

A step is what one undo takes back: a stroke, drying, a seal, a text that is laid or removed, a
layer that comes, goes, moves or shows otherwise. Who takes a stroke out of the middle of a score
must know which of the undos and redos after it were for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from paint3d.errors import Message, RecordingError
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score, undo_kinds

__all__ = ["ScoreSteps", "ScoreStroke", "follow_steps", "stroke_of"]


@dataclass(eq=False)
class ScoreStroke:
    """A stroke with samples in a score, or a seal, which is one event.

    Attributes
    ----------
    number : int
        From 1; of strokes as `Score.strokes` has them, of seals among seals.
    begin, end : int
        Its first event, and the one after its last.
    is_there : bool
        Whether it is painted at the end.
    is_cancelled : bool
        Whether it was taken back before it ended.
    emptied_redo : bool
        Whether what had been undone was done again, or could no longer be, when it began.
    """

    number: int
    begin: int
    end: int = 0
    is_there: bool = True
    is_cancelled: bool = False
    emptied_redo: bool = False
    has_samples: bool = False
    is_seal: bool = False


@dataclass(eq=False)
class ScoreSteps:
    """Steps that `follow_steps` finds.

    Attributes
    ----------
    strokes : list of ScoreStroke
    seals : list of ScoreStroke
        Those that are there at the end.
    done, undone : list of ScoreStroke
        Those that are there at the end, and those that could be done again, the next one first.
    affected_steps : dict
        For each event that goes back or forth, the steps that it takes back or does again: strokes,
        seals, and None for others.
    strokes_after : dict
        For each of these, the strokes that are there after it.
    """

    strokes: list[ScoreStroke] = field(default_factory=list)
    seals: list[ScoreStroke] = field(default_factory=list)
    done: list[ScoreStroke] = field(default_factory=list)
    undone: list[ScoreStroke] = field(default_factory=list)
    affected_steps: dict[int, list[ScoreStroke | None]] = field(default_factory=dict)
    strokes_after: dict[int, list[ScoreStroke]] = field(default_factory=dict)


class _Follower:
    """Simulates the undo history of a score without painting it."""

    def __init__(self) -> None:
        self.strokes: list[ScoreStroke] = []
        self.done: list[ScoreStroke | None] = []
        self.undone: list[ScoreStroke | None] = []
        self.current: ScoreStroke | None = None
        self.is_previewing = False

    def command(self, k: int, line: Mapping[str, Any]) -> list[ScoreStroke | None]:
        """Execute a line; return the steps that it takes back or does again."""
        name, refused = line["do"], bool(line.get("refused"))
        kind = undo_kinds().get(name)
        if kind == "stroke" and self.current is None:
            empties_redo = self.is_previewing or bool(self.undone)
            self._end_preview()
            if not refused:
                self.current = ScoreStroke(0, k, emptied_redo=empties_redo)
                self._add_step(self.current)
        elif name in ("end_stroke", "cancel_stroke"):
            self._end_stroke(k + 1, cancelled=name == "cancel_stroke")
        elif kind == "step" and self.current is None:
            self._end_preview()
            if not refused:
                is_seal = name == "press_seal"
                self._add_step(ScoreStroke(0, k, k + 1, is_seal=True) if is_seal else None)
        elif kind == "layers" and self.current is None and not self.is_previewing:
            self._add_step(None)
        elif kind == "history":
            self._end_stroke(k)
            self.is_previewing = name == "replay_history" and bool(line.get("passing"))
            if name == "replay_history":
                return self._go_to(line["upto"]) if not refused else []
            return self._undo() if name == "undo" else self._redo()
        return []

    def _add_step(self, step: ScoreStroke | None) -> None:
        self.undone.clear()
        self.done.append(step)

    def _end_stroke(self, k: int, cancelled: bool = False) -> None:
        stroke, self.current = self.current, None
        if stroke is None:
            return
        stroke.end, stroke.is_cancelled = k, cancelled
        if cancelled or not stroke.has_samples:
            self.done.pop()
        if stroke.has_samples:
            self.strokes.append(stroke)
            stroke.number = len(self.strokes)

    def _end_preview(self) -> None:
        if self.is_previewing:
            self.is_previewing = False
            self._go_to(len(self.strokes_done()) + sum(_is_stroke(step) for step in self.undone))

    def strokes_done(self) -> list[ScoreStroke]:
        return [step for step in self.done if step is not None and not step.is_seal]

    def _undo(self) -> list[ScoreStroke | None]:
        if not self.done:
            return []
        self.undone.append(self.done.pop())
        return [self.undone[-1]]

    def _redo(self) -> list[ScoreStroke | None]:
        if not self.undone:
            return []
        self.done.append(self.undone.pop())
        return [self.done[-1]]

    def _go_to(self, upto: int) -> list[ScoreStroke | None]:
        affected: list[ScoreStroke | None] = []
        while len(self.strokes_done()) > upto and self.done:
            affected += self._undo()
        while self.undone and (len(self.strokes_done()) < upto or not _is_stroke(self.undone[-1])):
            affected += self._redo()
        return affected


def _is_stroke(step: ScoreStroke | None) -> bool:
    return step is not None and not step.is_seal


def follow_steps(score: Score) -> ScoreSteps:
    """Follow the steps of a score and their undoing, without painting it."""
    follower, steps = _Follower(), ScoreSteps()
    for k, event in enumerate(score.events):
        if isinstance(event, Recording):
            if follower.current is not None:
                follower.current.has_samples = True
            continue
        affected = follower.command(k, event)
        if undo_kinds().get(event["do"]) == "history":
            steps.affected_steps[k], steps.strokes_after[k] = affected, follower.strokes_done()
    follower._end_stroke(len(score.events))
    steps.strokes, steps.done = follower.strokes, follower.strokes_done()
    steps.undone = [s for s in reversed(follower.undone) if s is not None and not s.is_seal]
    steps.seals = [step for step in follower.done if step is not None and step.is_seal]
    for number, seal in enumerate(steps.seals, 1):
        seal.number = number
    for stroke in steps.strokes:
        stroke.is_there = any(stroke is other for other in steps.done)
    return steps


def stroke_of(score: Score, number: int) -> tuple[ScoreStroke, ScoreSteps]:
    """A stroke by its number, and the steps of the whole score.

    Raises
    ------
    RecordingError
        If there is none of this number.
    """
    steps = follow_steps(score)
    if not 1 <= number <= len(steps.strokes):
        name = score.name or Message("the score")
        if not steps.strokes:
            raise RecordingError("{score}: it has no strokes", score=name)
        raise RecordingError(
            "{score}: there is no stroke {number}; expected 1 to {n}",
            score=name,
            number=number,
            n=len(steps.strokes),
        )
    return steps.strokes[number - 1], steps

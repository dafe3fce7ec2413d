"""A score step by step: what a document is asked for, in order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from paint3d.app.model.commands import COMMANDS, arguments_of
from paint3d.app.model.score.words import Inks, Vocabulary
from paint3d.device.sample import DeviceSample
from paint3d.errors import Paint3DError, RecordingError
from paint3d.recording.recording import Recording
from paint3d.recording.score import Score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = ["Step", "play"]

_AT_ONCE = 256  # samples between two looks at whether it goes on


@dataclass(frozen=True, eq=False)
class Step:
    """Something to be done: samples of the stroke that goes on, or a command.

    Attributes
    ----------
    event : int
        Its place in the score.
    samples : list of DeviceSample
    command : str
        Name of a method of `Document`; empty for samples.
    options : dict
        What it is called with.
    may_fail : bool
        Whether it was refused when it was asked for first.
    share : float
        Of the score that is done after it, 0 to 1.
    """

    event: int
    samples: list[DeviceSample]
    command: str
    options: dict[str, Any]
    may_fail: bool
    share: float


def _steps_of(score: Score, surface: PaintedSurface, first: int) -> Iterator[Step]:
    """What is to be done from an event on, in order; each is made when those before it are done.

    Raises
    ------
    RecordingError
        ``file:line: what is wrong`` for a brush or an ink that is not known, and the like.
    """
    vocabulary = Vocabulary(surface, Inks(dict(score.header.get("pigments", {}))))
    whole = sum(map(_cost, score.events[first:])) or 1.0
    done = 0.0
    for k, event in enumerate(score.events[first:], first):
        if isinstance(event, Recording):
            samples = list(event.samples())
            for at in range(0, len(samples), _AT_ONCE):
                part = samples[at : at + _AT_ONCE]
                done += len(part)
                yield Step(k, part, "", {}, False, done / whole)
            continue
        try:
            asked = arguments_of(event, vocabulary)
        except Paint3DError as cause:
            if event.get("refused"):  # as it was then
                continue
            raise RecordingError(f"{score.where(k)}: {event['do']}: {cause}") from None
        if event["do"] == "begin_stroke" and not event.get("refused"):
            asked.setdefault("time_s", 0.0)
        times = event.get("times", 1)
        cost = _cost(event) / times
        for _ in range(times):
            done += cost
            yield Step(k, [], event["do"], asked, bool(event.get("refused")), done / whole)


def _cost(event: Any) -> float:
    if isinstance(event, Recording):
        return float(len(event))
    return float(COMMANDS[event["do"]].cost * event.get("times", 1))


def play(document: Any, score: Score, first: int = 0) -> Iterator[Step]:
    """Do what a score says, step by step; each is done when it comes out.

    Parameters
    ----------
    document : Document
        Nobody else touches it meanwhile.
    score : Score
    first : int
        The event to begin with: the document is as those before it left it.

    Raises
    ------
    RecordingError
        ``file:line: what is wrong`` where something cannot be done, except what was refused when it
        was asked for first.
    """
    for step in _steps_of(score, document.surface, first):
        try:
            if step.samples:
                document.feed(step.samples)
            else:
                getattr(document, step.command)(**step.options)
        except Paint3DError as cause:
            if not step.may_fail:
                what = step.command or "a sample"
                raise RecordingError(f"{score.where(step.event)}: {what}: {cause}") from None
        yield step

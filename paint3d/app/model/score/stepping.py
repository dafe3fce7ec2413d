"""A score step by step: its commands and samples, in order and in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from paint3d.app.model.commands import COMMANDS, decode_arguments
from paint3d.app.model.score.codecs import InkTable, Vocabulary
from paint3d.device.sample import DeviceSample
from paint3d.errors import Message, Paint3DError, RecordingError
from paint3d.recording.recording import HandTime, Recording
from paint3d.recording.score import Event, Score
from paint3d.surface.painted_surface import PaintedSurface

__all__ = [
    "Cue",
    "PlaybackStep",
    "cues_of",
    "in_pieces",
    "pass_step",
    "play",
    "seconds_of",
]

# ---- In order ------------------------------------------------------------------------------------


_AT_ONCE = 256  # samples between two looks at whether it goes on


@dataclass(frozen=True, eq=False)
class PlaybackStep:
    """A step to play: samples of the stroke that goes on, or a command.

    Attributes
    ----------
    event : int
        Its index in the score.
    samples : list of DeviceSample
    command : str
        Name of a method of `Document`; empty for samples.
    options : dict
        What it is called with.
    may_fail : bool
        Whether it was refused when it was asked for first.
    fraction : float
        Of the score that is done after it, 0 to 1.
    """

    event: int
    samples: list[DeviceSample]
    command: str
    options: dict[str, Any]
    may_fail: bool
    fraction: float


def _make_steps(score: Score, surface: PaintedSurface, first: int) -> Iterator[PlaybackStep]:
    """Yield the steps from an event on; each is made when those before it are done.

    Raises
    ------
    RecordingError
        ``file:line: what is wrong`` for a brush or an ink that is not known, and the like.
    """
    whole = sum(map(_cost, score.events[first:])) or 1.0
    done = 0.0
    for k, event, arguments in _decode_events(score, surface, first):
        if isinstance(event, Recording):
            samples = list(event.samples())
            for at in range(0, len(samples), _AT_ONCE):
                part = samples[at : at + _AT_ONCE]
                done += len(part)
                yield PlaybackStep(k, part, "", {}, False, done / whole)
            continue
        times = event.get("times", 1)
        cost = _cost(event) / times
        for _ in range(times):
            done += cost
            yield PlaybackStep(
                k, [], event["do"], arguments, bool(event.get("refused")), done / whole
            )


def _decode_events(
    score: Score, surface: PaintedSurface, first: int
) -> Iterator[tuple[int, Event, dict[str, Any]]]:
    """Events from `first` on: index, event, and a command's arguments; none that was refused."""
    vocabulary = Vocabulary(surface, InkTable.of(score.header))
    for k, event in enumerate(score.events[first:], first):
        arguments: dict[str, Any] = {}
        if not isinstance(event, Recording):
            try:
                arguments = decode_arguments(event, vocabulary)
            except Paint3DError as cause:
                if event.get("refused"):  # as it was then
                    continue
                raise RecordingError(
                    "{where}: {do}: {cause}", where=score.where(k), do=event["do"], cause=cause
                ) from None
            if event["do"] == "begin_stroke" and not event.get("refused"):
                arguments.setdefault("time_s", 0.0)
        yield k, event, arguments


def _cost(event: Any) -> float:
    if isinstance(event, Recording):
        return float(len(event))
    return float(COMMANDS[event["do"]].cost * event.get("times", 1))


def play(document: Any, score: Score, first: int = 0) -> Iterator[PlaybackStep]:
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
    for step in _make_steps(score, document.surface, first):
        try:
            if step.samples:
                document.feed(step.samples)
            else:
                getattr(document, step.command)(**step.options)
        except Paint3DError as cause:
            if not step.may_fail:
                what = step.command or Message("a sample")
                raise RecordingError(
                    "{where}: {what}: {cause}",
                    where=score.where(step.event),
                    what=what,
                    cause=cause,
                ) from None
        yield step


# ---- In time -------------------------------------------------------------------------------------


_OF_INK = frozenset({"follow_time", "let_time_pass"})


@dataclass(frozen=True, eq=False)
class Cue:
    """Samples of the stroke that goes on, or a command, and their time.

    Attributes
    ----------
    when : float
        s since the score began, by the hand's time.
    samples : list of DeviceSample
    command : str
        Name of a method of `Document`; empty for samples.
    options : dict
        What it is called with.
    """

    when: float
    samples: list[DeviceSample] = field(default_factory=list)
    command: str = ""
    options: dict[str, Any] = field(default_factory=dict)


def seconds_of(score: Score) -> float:
    """Duration of a score at the hand's own speed, s."""
    clock = HandTime()
    for event in score.events:
        if isinstance(event, Recording):
            clock.pass_samples(event.time_ns)
        else:
            _pass_command(clock, event["do"], event, event.get("times", 1))
    return clock.seconds


def in_pieces(score: Score, n: int = 1) -> Score:
    """The same score with at most n samples between two events: what it paints is the same."""
    events: list[Any] = []
    lines: list[int] = []
    for k, event in enumerate(score.events):
        cut = [event]
        if isinstance(event, Recording):
            cut = [event.part(at, at + n) for at in range(0, len(event), n)]
        events += cut
        lines += score.lines[k : k + 1] * len(cut)
    return replace(score, events=tuple(events), lines=tuple(lines))


def pass_step(clock: HandTime, step: PlaybackStep) -> None:
    """Count a step that has been done."""
    if step.samples:
        clock.pass_samples(np.array([sample.time_ns for sample in step.samples], np.int64))
    else:
        _pass_command(clock, step.command, step.options, 1)


def cues_of(score: Score, surface: PaintedSurface) -> Iterator[Cue]:
    """Yield what is to be done, and when; samples one by one.

    Parameters
    ----------
    score : Score
    surface : PaintedSurface
        Of the painting that it is played on.

    Raises
    ------
    RecordingError
        ``file:line: what is wrong`` for a brush or an ink that is not known, and the like.
    """
    clock = HandTime()
    for _, event, arguments in _decode_events(score, surface, 0):
        if isinstance(event, Recording):
            for when, sample in zip(
                clock.pass_samples(event.time_ns), event.samples(), strict=True
            ):
                yield Cue(float(when), [sample])
            continue
        for _ in range(event.get("times", 1)):
            _pass_command(clock, event["do"], event, 1)
            yield Cue(clock.seconds, [], event["do"], arguments)


def _pass_command(clock: HandTime, name: str, options: Mapping[str, Any], times: int) -> None:
    """Count a command; it takes time only where ink is left to spread."""
    if name in _OF_INK:
        clock.pass_ink(float(options["seconds"]) * times)

"""Plays a recording on the object as if a hand painted it, at any speed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from PySide6 import QtCore

from paint3d.app.model.brush_in_hand import BRUSH_COMMANDS
from paint3d.app.model.paint_thread import PaintThread
from paint3d.app.model.score.stepping import Cue
from paint3d.app.window.wording import say
from paint3d.app.window.workspace import Workspace
from paint3d.device.sample import DeviceSample
from paint3d.painter.ink_time import INK_STEP_NS
from paint3d.painter.recorded_tools import eraser_runs
from paint3d.recording.recording import HandTime

__all__ = ["Asked", "Player", "Tools"]

_BATCH = 64  # samples fed at once where no time is kept
_MOST_BATCHES = 16  # in one tick: the window lives on
_MOST_CUES = 1024
_AHEAD = 64  # batches that wait: painting is not to wait for the next tick
_HASTE = 8  # speed of a writing hand, for the ink, relative to the plan, where no time is kept
_LOOK_S, _LOOK_FRACTION = 2.0, 0.004  # until it is known how fast it goes

Asked = tuple[str, tuple[Any, ...]]
"""A command of a document, and its arguments."""


@dataclass(frozen=True)
class Tools:
    """Commands before a recording is played, and after it, for the hand to go on.

    And how much ink the brush comes to hold at its samples, and how strong it is; see
    `Document.begin_stroke`.

    Attributes
    ----------
    writes : bool
        Whether it is no recording but a text that is written: played as fast as it goes, its ink
        has the time of a swifter hand, and goes on afterwards by the clock.
    """

    before: Sequence[Asked] = ()
    after: Sequence[Asked] = ()
    loads: Sequence[tuple[int, float]] = ()
    strengths: Sequence[tuple[int, float]] = ()
    writes: bool = False

    def haste(self, speed: float | None) -> int:
        """Return the factor by which the ink has less time than passes between samples."""
        return _HASTE if self.writes and speed is None else 1


class _Clock:
    """The time of a replay: a multiple of the clock's, or as fast as it goes."""

    def __init__(self, speed: float | None) -> None:
        self._speed, self._is_still = speed, False
        self._at, self._since = 0.0, time.perf_counter()

    @property
    def seconds(self) -> float:
        """The time reached by now, s of the hand's time; infinite for as fast as it goes."""
        if self._is_still:
            return self._at
        if self._speed is None:
            return math.inf
        return self._at + (time.perf_counter() - self._since) * self._speed

    def change(self, reached: float, speed: float | None, is_still: bool) -> None:
        """Go on from what has been reached, at this speed or not at all."""
        at = self.seconds
        self._at = at if math.isfinite(at) else reached
        self._since, self._speed, self._is_still = time.perf_counter(), speed, is_still

    @property
    def speed(self) -> float | None:
        """Speed as a multiple of the hand's; None: as fast as it goes."""
        return self._speed


@dataclass(eq=False)
class _StrokeReplay:
    """A recording of version 1 that is being played: one stroke for each turn of its pen.

    Attributes
    ----------
    samples : sequence of DeviceSample
    when : list of float
        Of each, s since the first.
    tools : Tools
    turns : dict of int to (int, bool)
        The first sample of each turn of the pen's ends, to the one behind its last and whether that
        end is the eraser.
    began : Future
        Of the command that begins the first stroke.
    later_ns : int
        From the samples' clock to the hand's.
    next : int
        Index of the first that is still to be fed.
    before : int
        How many samples had been painted when the first was.
    ended : Future or None
        Of the command that ends the last stroke.
    """

    samples: Sequence[DeviceSample]
    when: list[float]
    tools: Tools
    turns: dict[int, list[int]]
    began: Future[Any]
    later_ns: int
    next: int = 0
    before: int = 0
    ended: Future[Any] | None = None

    @classmethod
    def begun(
        cls, paint_thread: PaintThread, samples: Sequence[DeviceSample], tools: Tools
    ) -> _StrokeReplay:
        """Begin the stroke."""
        # by the hand's clock, and by whole pieces of the ink's time: as it was painted
        whole = tools.haste(None) * INK_STEP_NS
        later_ns = (time.perf_counter_ns() - samples[0].time_ns) // whole * whole
        times = np.array([sample.time_ns for sample in samples], np.int64)
        when = HandTime(in_full=paint_thread.wet).pass_samples(times).tolist()
        _ask(paint_thread, tools.before)
        runs = {first: run for first, *run in eraser_runs([sample.buttons for sample in samples])}
        began = _begin_stroke(paint_thread, tools, 0, *runs.pop(0))
        playing = cls(samples, when, tools, runs, began, later_ns, before=paint_thread.n_painted)
        began.add_done_callback(lambda _: playing.count_from(paint_thread.n_painted))
        return playing

    def count_from(self, n_painted: int) -> None:
        """Note how many samples had been painted when the stroke began."""
        self.before = n_painted

    @property
    def reached(self) -> float:
        """Time up to which it has been fed, s."""
        return self.when[min(self.next, len(self.when) - 1)]

    def fraction(self, paint_thread: PaintThread) -> float:
        """Return the fraction that is painted, 0 to 1."""
        if not self.began.done():
            return 0.0
        return (paint_thread.n_painted - self.before) / len(self.samples)

    @property
    def is_refused(self) -> bool:
        """True if its stroke could not begin."""
        began = self.began
        return began.done() and (began.cancelled() or began.exception() is not None)

    @property
    def is_over(self) -> bool:
        """True if all of it is painted."""
        return self.ended is not None and self.ended.done()

    @property
    def is_handed_on(self) -> bool:
        """True if all of it has been fed."""
        return self.ended is not None

    def hand_on(self, paint_thread: PaintThread, seconds: float) -> None:
        """Ask for what is due by then."""
        due = self.next
        while due < len(self.when) and self.when[due] <= seconds:
            due += 1
        for _ in range(_MOST_BATCHES):
            if self.next == due or paint_thread.queue_length > _AHEAD:
                break
            if self.next in self.turns:
                paint_thread.post("end_stroke")
                _begin_stroke(paint_thread, self.tools, self.next, *self.turns.pop(self.next))
            turn = min(self.turns, default=due)
            samples = self.samples[self.next : min(self.next + _BATCH, due, turn)]
            moved = [replace(s, time_ns=s.time_ns + self.later_ns) for s in samples]
            paint_thread.feed(moved, all_time=True)
            self.next += len(samples)
        if self.next == len(self.samples):
            self._end(paint_thread)

    def _end(self, paint_thread: PaintThread) -> None:
        self.ended = paint_thread.post("end_stroke")
        _ask(paint_thread, self.tools.after)

    def stop(self, paint_thread: PaintThread) -> None:
        """Lift the brush where it is; what waits is not painted."""
        paint_thread.leave_out_samples(self.began, self.ended)
        if self.ended is None:
            self._end(paint_thread)


@dataclass(eq=False)
class _Score:
    """A whole painting that is being played, on an object of its own.

    Attributes
    ----------
    cues : sequence of Cue
    wants_wet : callable
        Whether ink is to spread beside the hand again, afterwards; meanwhile the score says when.
    next : int
        The first that is still to be asked for.
    last : Future or None
        Of the last command.
    in_stroke : bool
    """

    cues: Sequence[Cue]
    wants_wet: Callable[[], bool]
    next: int = 0
    last: Future[Any] | None = None
    in_stroke: bool = field(default=False)

    is_refused = False

    @property
    def reached(self) -> float:
        """Time up to which it has been fed, s."""
        return self.cues[min(self.next, len(self.cues) - 1)].when

    def fraction(self, _: PaintThread) -> float:
        """Return the fraction that has been asked for, 0 to 1."""
        return self.next / len(self.cues)

    @property
    def is_over(self) -> bool:
        """True if all of it is painted."""
        return self.last is not None and self.last.done()

    @property
    def is_handed_on(self) -> bool:
        """True if all of it has been fed."""
        return self.last is not None

    def hand_on(self, paint_thread: PaintThread, seconds: float) -> None:
        """Ask for what is due by then."""
        for _ in range(_MOST_CUES):
            if self.next == len(self.cues) or paint_thread.queue_length > _AHEAD:
                break
            cue = self.cues[self.next]
            if cue.when > seconds:
                break
            self.next += 1
            if cue.samples:
                paint_thread.feed(cue.samples)
                continue
            if cue.command in BRUSH_COMMANDS:
                # by position: the painting thread reads the arguments to foresee the next brush
                paint_thread.post(cue.command, *cue.options.values())
            else:
                paint_thread.post(cue.command, **cue.options)
            ends = cue.command in ("end_stroke", "cancel_stroke")
            self.in_stroke = cue.command == "begin_stroke" or (self.in_stroke and not ends)
        if self.next == len(self.cues):
            self._end(paint_thread)

    def _end(self, paint_thread: PaintThread) -> None:
        if self.in_stroke:
            paint_thread.post("end_stroke")
        self.last = paint_thread.post(_done)
        paint_thread.wet = self.wants_wet()

    def stop(self, paint_thread: PaintThread) -> None:
        """Lift the brush where it is."""
        if self.last is None:
            self._end(paint_thread)


def _begin_stroke(
    paint_thread: PaintThread, tools: Tools, first: int, end: int, erases: int
) -> Future[Any]:
    """Begin the stroke of a recording's samples from `first` to before `end`."""
    options: dict[str, Any] = {
        name: tuple((k - first, fraction) for k, fraction in pairs if first <= k < end)
        for name, pairs in (("loads", tools.loads), ("strengths", tools.strengths))
    }
    options["erase"] = bool(erases)
    return paint_thread.post(
        "begin_stroke", **{name: value for name, value in options.items() if value}
    )


def _done(_: object) -> None:
    """Do nothing: when this is done, all that was asked for before is."""


def _ask(paint_thread: PaintThread, commands: Sequence[Asked]) -> None:
    for command, arguments in commands:
        paint_thread.post(command, *arguments)


class Player(QtCore.QObject):
    """Plays recordings and whole paintings on the object; `tick` hands on what is due.

    Signals
    -------
    moved : float
        The fraction that is painted, 0 to 1; below 0 where nothing is played any more.
    """

    moved = QtCore.Signal(float)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._workspace = workspace
        self._replay: _StrokeReplay | _Score | None = None
        self._clock = _Clock(None)
        self._since = 0.0, 0.0  # when it was at which fraction
        self._is_paused = self._refused = False
        workspace.said.connect(self._note_failure)

    @property
    def is_playing(self) -> bool:
        """True if there is something still to be painted."""
        return self._replay is not None

    @property
    def speed(self) -> float | None:
        """Speed as a multiple of the hand's own; None: as fast as it goes."""
        return self._clock.speed

    @property
    def is_paused(self) -> bool:
        """True if it is paused."""
        return self._is_paused

    @property
    def left_s(self) -> float | None:
        """Estimate of the time left at this speed, s; None while it is not known."""
        replay, paint_thread = self._replay, self._workspace.stage.paint_thread
        if replay is None or paint_thread is None or self._is_paused:
            return None
        (since, before), fraction = self._since, replay.fraction(paint_thread)
        passed, done = time.perf_counter() - since, fraction - before
        if passed < _LOOK_S or done < _LOOK_FRACTION:
            return None
        return passed / done * (1.0 - fraction)

    @property
    def is_spreading(self) -> bool:
        """True if a text is written and its ink spreads meanwhile, as `stop_spreading` ends."""
        replay, paint_thread = self._replay, self._workspace.stage.paint_thread
        writes = isinstance(replay, _StrokeReplay) and replay.tools.writes
        return writes and paint_thread is not None and paint_thread.wet

    def stop_spreading(self) -> None:
        """Write on while the ink stays where it is laid, until the user lets it spread again."""
        wet = self._workspace.actions["wet"]
        with QtCore.QSignalBlocker(wet):
            wet.setChecked(False)
        self._workspace.paint_thread.wet = False
        self._restart_estimate()
        self._workspace.tell(
            say("Ink stays where it is laid; “Ink spreads and dries” lets it spread again")
        )

    def play(
        self, samples: Sequence[DeviceSample], speed: float | None, tools: Tools | None = None
    ) -> None:
        """Paint samples at a multiple of their own speed; None: as fast as it goes.

        Rests count as `HandTime` does, in full where ink spreads meanwhile.
        """
        self.stop()
        if samples:
            tools = tools or Tools()
            self._workspace.paint_thread.use_sample_time_alone(True, tools.haste(speed))
            playing = _StrokeReplay.begun(self._workspace.paint_thread, samples, tools)
            self._begin(playing, speed)

    def play_score(self, cues: Sequence[Cue], speed: float | None) -> None:
        """Paint a whole painting on the object, which is as the score began."""
        self.stop()
        if cues:
            paint_thread = self._workspace.paint_thread
            playing = _Score(cues, self._workspace.actions["wet"].isChecked)
            paint_thread.wet = False
            self._begin(playing, speed)

    def _begin(self, playing: _StrokeReplay | _Score, speed: float | None) -> None:
        self._replay, self._clock = playing, _Clock(speed)
        self._is_paused = self._refused = False
        self._restart_estimate()
        if not isinstance(playing, _StrokeReplay) or not playing.tools.writes:
            message = say("Replaying; Esc stops it")
        elif self.is_spreading:
            message = say("The brush writes, and its ink spreads; Esc stops it")
        else:
            message = say("The brush writes; Esc stops it")
        self._workspace.tell(message)
        self.moved.emit(0.0)
        self.tick()

    def set_speed(self, speed: float | None) -> None:
        """Go on at another speed, a multiple of the hand's own."""
        replay = self._replay
        if replay is not None:
            if isinstance(replay, _StrokeReplay):
                haste = replay.tools.haste(speed)
                if haste != replay.tools.haste(self._clock.speed):
                    self._workspace.paint_thread.use_sample_time_alone(True, haste)
            self._clock.change(replay.reached, speed, self._is_paused)
            self._restart_estimate()

    def pause(self, on: bool) -> None:
        """Pause the replay, or go on."""
        if self._replay is not None:
            self._is_paused = on
            self._clock.change(self._replay.reached, self._clock.speed, on)
            self._restart_estimate()

    def _restart_estimate(self) -> None:
        """Measure from now on how fast it goes."""
        replay, paint_thread = self._replay, self._workspace.stage.paint_thread
        if replay is not None and paint_thread is not None:
            self._since = time.perf_counter(), replay.fraction(paint_thread)

    def tick(self) -> None:
        """Feed what is due by now, and emit how much is painted."""
        replay, paint_thread = self._replay, self._workspace.stage.paint_thread
        if replay is None or paint_thread is None:
            return
        if replay.is_refused:
            self.stop()  # the painting thread has reported why
            return
        self.moved.emit(replay.fraction(paint_thread))
        if not replay.is_handed_on:
            if not self._is_paused:
                replay.hand_on(paint_thread, self._clock.seconds)
        elif replay.is_over:
            if not self._refused:
                self._workspace.tell(say("Ready"))
            self._forget()

    def stop(self) -> None:
        """Lift the brush where it is, if something is playing; what waits is not painted."""
        replay = self._replay
        if replay is not None:
            replay.stop(self._workspace.paint_thread)
            self._forget()

    def do_stop(self) -> None:
        """Stop on the user's command, and say what that leaves."""
        if self.is_playing:
            is_score = isinstance(self._replay, _Score)
            self.stop()
            self._workspace.tell(
                say("The replay was stopped")
                if is_score
                else say("The replay was stopped; undo takes back what it painted")
            )

    def take_back(self) -> None:
        """Stop because what was painted is about to be undone, and say so."""
        if self.is_playing:
            self.stop()
            self._workspace.tell(say("The replay was stopped and undone"))

    def give_way(self) -> None:
        """Stop for a stroke by hand, which would be one with that of the recording."""
        if self._replay is not None and not self._replay.is_handed_on:
            self.stop()
            self._workspace.tell(say("The replay was stopped by your stroke"))

    def _forget(self) -> None:
        if isinstance(self._replay, _StrokeReplay):
            self._workspace.paint_thread.use_sample_time_alone(False)
        self._replay = None
        self._workspace.stage.hide_brush()  # it would stand on what it has just painted
        self.moved.emit(-1.0)

    def _note_failure(self, _: str, state: str, __: bool) -> None:
        """Note a failure, so that "Ready" does not replace it on the status line."""
        if self._replay is not None and state == "bad":
            self._refused = True
